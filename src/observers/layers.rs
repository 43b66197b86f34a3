//! Layers of a density profile: near a wall, and of a crystal.

use super::{DensityPoint, DensityProfile};
use crate::Error;
use crate::statistics::Estimate;

/// One layer of spheres: a maximum of n(x) between two minima.
///
/// ```
/// use gradient_mc::observers::{Bins, DensityProfile, Layer};
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// let slab = Slab::new(60.0, 6.0, 6.0)?;
/// let scene = Scene::new(slab, 720, UniformField::default(), Isothermal::new(5.0)?)?;
/// let mut simulation = Simulation::builder(scene).seed(1).build()?;
/// let mut profile = DensityProfile::new(&slab, Bins::count(150).from(0.5).to(8.0))?;
/// simulation.equilibrate(200, &mut ())?;
/// simulation.run(200, &mut profile)?;
/// // The first layer touches the base and is very clear.
/// let first: Layer = profile.layers(Layer::CLEAR)?[0];
/// assert_eq!(first.position.mean, 0.5);
/// assert!(first.visibility.mean > 0.5);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Layer {
    /// Height of the peak, in diameters: the centroid of the part above half height, measured from
    /// the higher of the two adjacent minima. A peak in the lowest accessible bin is the contact
    /// peak at the wall; its position is the contact height, without error.
    pub position: Estimate,
    /// Distance from the position of the layer below, in diameters; NaN for the lowest layer.
    pub spacing: Estimate,
    /// Mean height of the spheres between the minima, in diameters.
    pub mean_height: Estimate,
    /// Standard deviation of their heights, in diameters.
    pub width: Estimate,
    /// Their number per area of the base, in inverse square diameters.
    pub lateral_density: Estimate,
    /// Largest number density of a bin, in inverse cubic diameters.
    pub maximum_density: Estimate,
    /// Smallest number density between this layer and the next, in inverse cubic diameters; NaN for
    /// the uppermost layer.
    pub minimum_density: Estimate,
    /// Visibility (`n_max` − `n_min`)/(`n_max` + `n_min`) with the minimum above, from 0 to 1; NaN
    /// for the uppermost layer.
    pub visibility: Estimate,
}

impl Layer {
    /// Smallest visibility of a layer that the eye recognizes in a plot of n(x). In profiles of
    /// density functional theory it gives five layers at T = 5, as in the paper
    /// (doi:10.1103/PhysRevE.83.061306, fig. 4), and three at T = 15.
    pub const CLEAR: f64 = 0.05;
}

/// Number of values of a layer with errors by the jackknife.
const VALUES: usize = 8;

/// The bins of a layer in the mean profile.
#[derive(Debug, Clone, Copy)]
struct Window {
    /// First bin, and first of the next layer.
    bins: [usize; 2],
    highest: usize,
    /// The minimum above; `None` for the uppermost layer.
    lowest: Option<usize>,
}

impl DensityProfile {
    /// The layers, from the lowest upwards. Use bins of 0.05 diameters or less that begin at the
    /// lowest center, 0.5.
    ///
    /// Two maxima are different layers if the minimum between them is clear: the visibility
    /// (`n_max` − `n_min`)/(`n_max` + `n_min`) is at least `minimum_visibility` on both sides, and
    /// the difference at least five standard errors. The result is empty if there is no minimum
    /// above the contact peak, as in a gas. [`Layer::CLEAR`] is a good value of
    /// `minimum_visibility`.
    ///
    /// The uppermost layer has no minimum above; it is assumed to extend as far above its peak as
    /// below. The bins of a layer are chosen from the mean profile; errors are by the jackknife
    /// over blocks for these bins.
    ///
    /// ```
    /// use gradient_mc::observers::{Bins, DensityProfile, Layer};
    /// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
    /// let slab = Slab::new(60.0, 6.0, 6.0)?;
    /// let scene = Scene::new(slab, 720, UniformField::default(), Isothermal::new(5.0)?)?;
    /// let mut profile = DensityProfile::new(&slab, Bins::count(150).from(0.5).to(8.0))?;
    /// Simulation::builder(scene).build()?.run(64, &mut profile)?;
    /// for layer in profile.layers(Layer::CLEAR)? {
    ///     println!("{}  {}  {}", layer.position, layer.spacing, layer.visibility);
    /// }
    /// # Ok::<(), gradient_mc::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] for fewer than 16 frames; [`Error::InvalidParameter`] if the
    /// visibility is not above 0 and below 1.
    pub fn layers(&self, minimum_visibility: f64) -> Result<Vec<Layer>, Error> {
        if !(minimum_visibility > 0.0 && minimum_visibility < 1.0) {
            let requirement = "it must be above 0 and below 1";
            let name = "minimum visibility of a layer";
            return Err(Error::InvalidParameter { name, value: minimum_visibility, requirement });
        }
        let points = self.points()?;
        let windows = windows(&points, minimum_visibility);
        let bin_height = if points.len() > 1 { points[1].height - points[0].height } else { 0.0 };
        let lowest_center = self.lowest_center();
        let heights: Vec<f64> = points.iter().map(|point| point.height).collect();
        let values = self.jackknife(|densities| {
            let mut values: Vec<f64> = Vec::with_capacity(VALUES * windows.len());
            let mut below = f64::NAN;
            for window in &windows {
                let values_of_one = measure(window, &heights, densities, bin_height, lowest_center, below);
                below = values_of_one[0];
                values.extend(values_of_one);
            }
            values
        })?;
        let layer = |values: &[Estimate]| Layer {
            position: values[0],
            spacing: values[1],
            mean_height: values[2],
            width: values[3],
            lateral_density: values[4],
            maximum_density: values[5],
            minimum_density: values[6],
            visibility: values[7],
        };
        Ok(values.chunks_exact(VALUES).map(layer).collect())
    }
}

/// The values of a [`Layer`] in the order of its fields; `below` is the position of the layer
/// below.
fn measure(
    window: &Window,
    heights: &[f64],
    densities: &[f64],
    bin_height: f64,
    lowest_center: f64,
    below: f64,
) -> [f64; VALUES] {
    let [first, end] = window.bins;
    let maximum = densities[window.highest];
    let minimum = window.lowest.map_or(f64::NAN, |bin| densities[bin]);
    let (mut spheres, mut moment, mut square) = (0.0, 0.0, 0.0);
    for (height, density) in heights[first..end].iter().zip(&densities[first..end]) {
        let offset = height - heights[window.highest];
        spheres += density;
        moment += density * offset;
        square += density * offset * offset;
    }
    let offset = moment / spheres;
    let at_the_wall = (heights[window.highest] - lowest_center).abs() <= 0.5001 * bin_height;
    let position = if at_the_wall {
        lowest_center
    } else {
        // Half height above the higher of the two minima, so that both sides have equal weight.
        let beside = if first == 0 { minimum } else { minimum.max(densities[first]) };
        let level = 0.5 * (maximum + beside);
        let (mut weight, mut moment) = (0.0, 0.0);
        for (height, density) in heights[first..end].iter().zip(&densities[first..end]) {
            let excess = (density - level).max(0.0);
            weight += excess;
            moment += excess * height;
        }
        moment / weight
    };
    [
        position,
        position - below,
        heights[window.highest] + offset,
        (square / spheres - offset * offset).max(0.0).sqrt(),
        spheres * bin_height,
        maximum,
        minimum,
        (maximum - minimum) / (maximum + minimum),
    ]
}

/// Finds maxima separated by clear minima, in one pass upwards: the largest density so far is a
/// maximum when the density has clearly decreased, and then the smallest is a minimum when it has
/// clearly increased.
fn windows(points: &[DensityPoint], minimum_visibility: f64) -> Vec<Window> {
    const STANDARD_ERRORS: f64 = 5.0;

    let clearly_above = |high: usize, low: usize| {
        let (high, low) = (points[high].number_density, points[low].number_density);
        let difference = high.mean - low.mean;
        difference > 0.0
            && difference >= minimum_visibility * (high.mean + low.mean)
            && difference >= STANDARD_ERRORS * high.standard_error.hypot(low.standard_error)
    };
    let density = |bin: usize| points[bin].number_density.mean;
    let mut windows = Vec::new();
    let (mut first, mut highest, mut lowest) = (0, 0, None::<usize>);
    for bin in 0..points.len() {
        match lowest {
            None if density(bin) > density(highest) => highest = bin,
            None if clearly_above(highest, bin) => lowest = Some(bin),
            Some(minimum) if density(bin) < density(minimum) => lowest = Some(bin),
            Some(minimum) if clearly_above(bin, minimum) => {
                // Empty bins between two layers of a crystal are divided evenly.
                let tie = (minimum..bin).take_while(|&tied| density(tied) <= density(minimum)).count() / 2;
                let minimum = minimum + tie;
                windows.push(Window { bins: [first, minimum], highest, lowest: Some(minimum) });
                (first, highest, lowest) = (minimum, bin, None);
            }
            Some(_) | None => {}
        }
    }
    if !windows.is_empty() {
        // The uppermost layer extends as far above its peak as below, at most to the height where
        // the density is that of the minimum below.
        let mirrored = (2 * highest + 1 - first).min(points.len());
        let floor = density(first);
        let end = (highest..mirrored).find(|&bin| density(bin) < floor).unwrap_or(mirrored);
        windows.push(Window { bins: [first, end], highest, lowest: None });
    }
    windows
}

#[cfg(test)]
mod tests {
    use super::super::test_frame::{Scene, ideal_heights};
    use super::*;
    use crate::observers::Bins;
    use crate::{Merge, Observer, Slab};
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    /// Layers of 25 spheres each, from the wall on, whose heights are the sum of four uniform
    /// numbers: nearly Gaussian, with standard deviation `half_width`/√3.
    fn layered(positions: &[f64], half_width: f64, frames: u64, seed: u64) -> DensityProfile {
        let mut generator = Pcg64Mcg::seed_from_u64(seed);
        let mut scene = Scene::new(20.0, &[]);
        let mut profile = DensityProfile::new(&scene.slab, Bins::count(400).from(0.5).to(10.5)).unwrap();
        for _ in 0..frames {
            let mut heights = Vec::new();
            for &position in positions {
                for _ in 0..25 {
                    let noise: f64 = (0..4).map(|_| generator.random::<f64>() - 0.5).sum();
                    let height = position + half_width * noise;
                    // Reflected by the wall.
                    heights.push(if height < 0.5 { 1.0 - height } else { height });
                }
            }
            scene.place(&heights);
            profile.observe(&scene.frame()).unwrap();
        }
        profile
    }

    #[test]
    fn layers_are_where_they_were_put() {
        // Spacings that grow upwards, as in a crystal under its own weight.
        let positions = [0.5, 1.33, 2.17, 3.02, 3.88, 4.75];
        let half_width = 0.24;
        let mut profile = layered(&positions, half_width, 400, 1);
        profile.merge(&layered(&positions, half_width, 400, 2)).unwrap();
        let layers = profile.layers(0.2).unwrap();
        assert_eq!(layers.len(), positions.len());
        assert!(layers[0].spacing.mean.is_nan() && layers[5].minimum_density.mean.is_nan());
        assert_eq!(layers[0].position, Estimate::new(0.5, 0.0));
        let width = half_width / 3.0_f64.sqrt();
        for (index, (layer, position)) in layers.iter().zip(positions).enumerate() {
            let density = layer.lateral_density;
            assert!((density.mean - 1.0).abs() < 0.02, "{density}");
            if index == 0 {
                continue;
            }
            for (estimate, expected, cap) in [
                (layer.position, position, 0.004),
                (layer.mean_height, position, 0.003),
                (layer.spacing, position - positions[index - 1], 0.005),
            ] {
                let off = estimate.deviation_from(expected);
                assert!(off.abs() < 4.0 && estimate.standard_error < cap, "{estimate} and not {expected}");
            }
            // Tails beyond the minima are cut off, and mixed with those of the neighbors.
            assert!((layer.width.mean / width - 1.0).abs() < 0.03, "{}", layer.width);
            // Sum of four: density at the middle is 2/3 of that of one.
            let peak = layer.maximum_density.mean * half_width;
            assert!((peak / (2.0 / 3.0) - 1.0).abs() < 0.1, "{peak}");
            assert!(index == 5 || layer.visibility.mean > 0.8, "{}", layer.visibility);
        }
        // Empty bins between narrow layers belong to both.
        let narrow = layered(&[0.5, 1.5, 2.5], 0.1, 32, 3).layers(0.5).unwrap();
        assert_eq!(narrow.len(), 3);
        assert!(
            (narrow[1].width.mean - 0.1 / 3.0_f64.sqrt()).abs() < 0.004 && narrow[1].visibility.mean > 0.999
        );
    }

    #[test]
    fn a_gas_has_no_layers_and_noise_makes_none() {
        let mut scene = Scene::new(500.0, &[]);
        let mut profile = DensityProfile::new(&scene.slab, Bins::count(600).from(0.5).to(30.5)).unwrap();
        for frame in 0..200 {
            scene.place(&ideal_heights(50, frame));
            profile.observe(&scene.frame()).unwrap();
        }
        // Ten counts per bin: without the standard errors, noise would give many "layers".
        let points = profile.points().unwrap();
        assert!(profile.layers(0.05).unwrap().is_empty());
        let certain = |point: &DensityPoint| {
            let number_density = Estimate::new(point.number_density.mean, 0.0);
            DensityPoint { number_density, ..*point }
        };
        let certain: Vec<DensityPoint> = points.iter().map(certain).collect();
        assert!(windows(&certain, 0.05).len() > 20);
    }

    #[test]
    fn senseless_visibilities_are_refused() {
        let mut profile = DensityProfile::new(&Slab::new(10.0, 5.0, 5.0).unwrap(), Bins::count(10)).unwrap();
        assert!(matches!(profile.layers(0.1), Err(Error::TooFewObservations { .. })));
        let scene = Scene::new(10.0, &[3.0]);
        for _ in 0..16 {
            profile.observe(&scene.frame()).unwrap();
        }
        assert!(profile.layers(0.1).unwrap().is_empty());
        for visibility in [0.0, 1.0, -0.1, f64::NAN] {
            assert!(matches!(profile.layers(visibility), Err(Error::InvalidParameter { .. })));
        }
    }
}
