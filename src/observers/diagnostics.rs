//! Warnings about bins with too few data.

use super::bins::HeightBins;
use crate::Warning;
use crate::statistics::{BlockAverages, FEWEST_INDEPENDENT, MINIMUM_BLOCKS};
use crate::warning::Disagreement;

/// Fraction of the spheres, from the base, that defines the column. Bins above may be empty.
const COLUMN: f64 = 0.99;

/// Number of parts of the column, each with its own autocorrelation time.
const PARTS: usize = 4;

/// Warnings about bins whose counts are the first components of `averages`; other quantities
/// follow, one for every bin.
///
/// Only accessible bins below the top 1 % of the spheres are judged.
pub(super) fn of_bins(bins: &HeightBins, averages: &BlockAverages) -> Vec<Warning> {
    let mut counts = averages.mean();
    counts.truncate(bins.count());
    if averages.observations() == 0 {
        // Before the first frame the means are NaN.
        counts.fill(0.0);
    }
    let total: f64 = counts.iter().sum();
    let mut below = 0.0;
    let top = counts.iter().position(|count| {
        below += count;
        below >= COLUMN * total
    });
    let column = bins.within_reach().take_while(|&bin| total == 0.0 || top.is_none_or(|top| bin <= top));
    let mut occupied = vec![0; bins.count()];
    let mut blocks = 0;
    for block in averages.blocks() {
        blocks += 1;
        occupied.iter_mut().zip(&block).for_each(|(occupied, &count)| *occupied += usize::from(count > 0.0));
    }
    let (empty, seen): (Vec<usize>, Vec<usize>) = column.partition(|&bin| counts[bin] == 0.0);
    // A run with fewer blocks has no error bars at all.
    let is_thin = |bin: &usize| blocks >= MINIMUM_BLOCKS && occupied[*bin] < MINIMUM_BLOCKS;
    let (thin, known): (Vec<usize>, Vec<usize>) = seen.into_iter().partition(is_thin);
    let middle = |bin: usize| bins.centers().nth(bin).unwrap_or(f64::NAN);
    let mut warnings = Vec::new();
    if let [first, .., last] | [first @ last] = empty[..] {
        let (lowest_height, highest_height) = (middle(first), middle(last));
        warnings.push(Warning::EmptyBins { bins: empty.len(), lowest_height, highest_height });
    }
    if let [first, .., last] | [first @ last] = thin[..] {
        let (lowest_height, highest_height) = (middle(first), middle(last));
        let blocks = thin.iter().map(|&bin| occupied[bin]).min().unwrap_or(0);
        warnings.push(Warning::ThinBins { bins: thin.len(), lowest_height, highest_height, blocks });
    }
    let kinds = averages.components() / bins.count();
    let parts = known.chunks(known.len().div_ceil(PARTS).max(1));
    let memories = parts.flat_map(|part| {
        (0..kinds)
            .map(move |kind| (part, averages.independent(part.iter().map(|bin| kind * bins.count() + bin))))
    });
    let slowest = memories.min_by(|(_, one), (_, other)| one.total_cmp(other));
    if let Some((&[lowest, ..], effective_sample_size)) = slowest
        && effective_sample_size < FEWEST_INDEPENDENT
    {
        let highest = slowest.and_then(|(part, _)| part.last()).copied().unwrap_or(lowest);
        let (lowest_height, highest_height) = (middle(lowest), middle(highest));
        warnings.push(Warning::CorrelatedBins { lowest_height, highest_height, effective_sample_size });
    }
    let mut apart: Vec<usize> =
        averages.contradictions().into_iter().map(|component| component % bins.count()).collect();
    apart.retain(|bin| known.contains(bin));
    apart.sort_unstable();
    apart.dedup();
    if let [first, .., last] | [first @ last] = apart[..] {
        let (lowest_height, highest_height) = (middle(first), middle(last));
        let disagreement = Disagreement::Bins { bins: apart.len(), lowest_height, highest_height };
        warnings.push(Warning::ReplicasDisagree { disagreement });
    }
    warnings
}

/// A warning for the worst bin that is too wide for a local equation of state.
///
/// In a bin in which ln n changes by Δ and ln T by Θ, the relative error of nTZ from the means is
/// about (Δ² + 2 |ΔΘ|)/24.
pub(super) fn too_wide(bins: &HeightBins, averages: &BlockAverages, temperatures: &[f64]) -> Option<Warning> {
    /// Narrower bins are not judged: they resolve the layers at a wall, where no local equation
    /// holds.
    const LAYER: f64 = 1.0;
    /// Smallest relative error that is reported.
    const LARGEST_BIAS: f64 = 0.005;
    /// Smallest number of spheres for a slope that is larger than noise.
    const FEWEST: f64 = 1000.0;
    let bin_width = bins.volume() / bins.base_area();
    if bin_width < LAYER || averages.observations() == 0 {
        return None;
    }
    let mut counts = averages.mean();
    counts.truncate(bins.count());
    let known = |count: f64| count * averages.observations() as f64 >= FEWEST;
    let worst = counts
        .windows(3)
        .zip(temperatures.windows(3))
        .zip(bins.centers().skip(1))
        .filter(|((counts, _), _)| counts.iter().all(|&count| known(count)))
        .map(|((counts, temperatures), height)| {
            let change = 0.5 * libm::log(counts[2] / counts[0]);
            let heating = 0.5 * libm::log(temperatures[2] / temperatures[0]);
            (height, (change * change + 2.0 * (change * heating).abs()) / 24.0)
        })
        .max_by(|(_, one), (_, other)| one.total_cmp(other));
    worst.filter(|(_, bias)| *bias > LARGEST_BIAS).map(|(height, bias)| Warning::WideBins {
        bin_width,
        height,
        bias,
    })
}
