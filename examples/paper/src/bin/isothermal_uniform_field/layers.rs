//! Layers in a density profile: their number, positions and heights.

use super::column::{FINE_BIN_WIDTH, FINE_RANGE};
use super::log_polynomial::LogPolynomial;
use gradient_mc::observers::{DensityProfile, Layer as ClearLayer};
use gradient_mc::statistics::Estimate;
use paper::Failure;

/// The paper's bins, in which references are given.
pub(crate) const BIN_WIDTH: f64 = 0.1;
/// Layers away from the wall whose place is measured, where they are clear.
const MEASURED: usize = 2;
/// Heights between which the highest bin is the peak of the second layer, and of the third.
const WINDOWS: [[f64; 2]; MEASURED] = [[1.3, 2.0], [2.2, 3.0]];

/// A maximum with the minimum after it, as indices of bins of 0.1.
#[derive(Debug, Clone, Copy)]
struct Extremes {
    maximum: usize,
    minimum: usize,
}

/// One layer away from the wall.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Layer {
    /// Where n(x) is largest and how large it is, by a cubic for ln n over narrow bins.
    pub(crate) position: Estimate,
    pub(crate) height: Estimate,
    /// The same from bins of 0.1, for comparison with references in such bins: vertex of a parabola
    /// through three bins, and the mean of the highest bin.
    pub(crate) binned_position: Estimate,
    pub(crate) binned_height: Estimate,
}

/// The layers of a profile at a base.
#[derive(Debug, Clone)]
pub(crate) struct Base {
    /// Middles and densities of bins of 0.1.
    pub(crate) bins: Vec<(f64, Estimate)>,
    /// n(0.5⁺), extrapolated.
    pub(crate) contact_density: Estimate,
    /// Layers that are clear, the one at the wall included.
    pub(crate) clear_layers: usize,
    /// The second layer and the third, if they are.
    pub(crate) layers: Vec<Layer>,
}

impl Base {
    /// Of a profile in bins of 0.1 and one in narrow bins.
    pub(crate) fn new(coarse: &DensityProfile, fine: &DensityProfile) -> Result<Self, Failure> {
        let bins: Vec<(f64, Estimate)> =
            coarse.points()?.iter().map(|point| (point.height, point.number_density)).collect();
        let clear_layers = coarse.layers(ClearLayer::CLEAR)?.len();
        let layers = WINDOWS.iter().take(clear_layers.saturating_sub(1));
        let highest: Vec<usize> = layers.filter_map(|window| highest(&bins, *window)).collect();
        // Peaks are broad where there are few.
        let reach = if clear_layers > 2 { 0.3 } else { 0.45 };
        // Places in the narrow bins, and in the wide ones.
        let peaks = fine.jackknife(|densities| {
            let peaks = highest.iter().flat_map(|&bin| peak(densities, bins[bin].0, reach));
            std::iter::once(contact_density(densities)).chain(peaks).collect::<Vec<f64>>()
        })?;
        let vertices = coarse
            .jackknife(|densities| highest.iter().map(|&bin| vertex(densities, bin)).collect::<Vec<f64>>())?;
        let layers =
            highest.iter().zip(peaks[1..].chunks_exact(2)).zip(vertices).map(|((&bin, fine), vertex)| {
                Layer {
                    position: fine[0],
                    height: fine[1],
                    binned_position: vertex,
                    binned_height: bins[bin].1,
                }
            });
        Ok(Self { contact_density: peaks[0], clear_layers, layers: layers.collect(), bins })
    }
}

/// The highest bin whose middle lies in a window.
fn highest(bins: &[(f64, Estimate)], [low, high]: [f64; 2]) -> Option<usize> {
    let inside = (0..bins.len()).filter(|&bin| (low..high).contains(&bins[bin].0));
    inside.max_by(|&first, &second| bins[first].1.mean.total_cmp(&bins[second].1.mean))
}

/// The same of a theory that is given in bins of 0.1: clear layers, then positions and heights of
/// the second and the third.
pub(crate) fn of_theory(bins: &[(f64, f64)]) -> (usize, Vec<(f64, f64)>) {
    let means: Vec<f64> = bins.iter().map(|&(_, density)| density).collect();
    let extremes = extremes(&means);
    let visible = |maximum: usize, minimum: usize| {
        (means[maximum] - means[minimum]) / (means[maximum] + means[minimum]) >= ClearLayer::CLEAR
    };
    // The rule of `DensityProfile::layers`: what lies between two layers is visible from both.
    let apart = extremes.windows(2).take_while(|pair| {
        visible(pair[0].maximum, pair[0].minimum) && visible(pair[1].maximum, pair[0].minimum)
    });
    let clear = if extremes.is_empty() { 0 } else { 1 + apart.count() };
    let layers = extremes.iter().skip(1).map(|layer| (vertex(&means, layer.maximum), means[layer.maximum]));
    (clear, layers.take(MEASURED).collect())
}

fn middle(bin: usize) -> f64 {
    FINE_RANGE[0] + (bin as f64 + 0.5) * BIN_WIDTH
}

/// Maxima and minima in turn, upwards from the maximum at the wall, of a profile without noise.
fn extremes(means: &[f64]) -> Vec<Extremes> {
    let mut found = Vec::new();
    let mut maximum = 0;
    for bin in 1..means.len().saturating_sub(1) {
        let (before, at, after) = (means[bin - 1], means[bin], means[bin + 1]);
        if at > before && at >= after {
            maximum = bin;
        } else if at < before && at <= after {
            found.push(Extremes { maximum, minimum: bin });
        }
    }
    found
}

/// n(0.5⁺) from the bins in which n falls to about a sixth. A polynomial of one degree less changes
/// it by less than its error.
fn contact_density(fine: &[f64]) -> f64 {
    const LOWEST: f64 = FINE_RANGE[0];
    let first: f64 = fine.iter().take(10).sum::<f64>() / 10.0;
    // Over 0.05 d, the middle of ten bins.
    let window = fine.iter().position(|&density| density < 0.2 * first).unwrap_or(fine.len()).clamp(25, 50);
    let high = LOWEST + FINE_BIN_WIDTH * window as f64;
    fit(fine, [LOWEST, high], 4).map_or(f64::NAN, |polynomial| polynomial.density(LOWEST))
}

/// Place and height of the maximum within reach of a height.
fn peak(fine: &[f64], height: f64, reach: f64) -> [f64; 2] {
    let polynomial = fit(fine, [height - reach, height + reach], 4);
    let found = polynomial.and_then(|polynomial| {
        let position = polynomial.maximum()?;
        Some([position, polynomial.density(position)])
    });
    found.unwrap_or([f64::NAN; 2])
}

/// A fit over the narrow bins whose middles lie in a window.
fn fit(fine: &[f64], [low, high]: [f64; 2], degree: usize) -> Option<LogPolynomial> {
    let heights = (0..).map(|bin| FINE_RANGE[0] + (f64::from(bin) + 0.5) * FINE_BIN_WIDTH);
    let bins: Vec<(f64, f64)> =
        heights.zip(fine.iter().copied()).filter(|(height, _)| (low..high).contains(height)).collect();
    LogPolynomial::fit(&bins, FINE_BIN_WIDTH, degree)
}

/// Vertex of the parabola for ln n through a bin and its neighbors.
fn vertex(means: &[f64], bin: usize) -> f64 {
    let [Some(&before), Some(&at), Some(&after)] =
        [means.get(bin.wrapping_sub(1)), means.get(bin), means.get(bin + 1)]
    else {
        return f64::NAN;
    };
    let [before, at, after] = [before, at, after].map(libm::log);
    middle(bin) + BIN_WIDTH * 0.5 * (before - after) / (before - 2.0 * at + after)
}
