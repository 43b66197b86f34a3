//! Profile of the number density.

use super::bins::{Bins, HeightBins, Place};
use super::diagnostics;
use super::one_run::OneRun;
use crate::statistics::{BlockAverages, Estimate};
use crate::{Error, Frame, Merge, Observer, ObserverError, Slab, Warning};

/// Number density n(x) in bins of equal height, in inverse cubic diameters.
///
/// The density of a bin is the mean number of centers in it over its volume A Δx, as in the paper
/// (doi:10.1103/PhysRevE.83.061306). It is the exact mean of n(x) over the bin. Centers are in
/// `[0.5, height − 0.5]`, so the density of a bin that extends beyond these limits is too low. To
/// measure the contact density n(0.5⁺), begin the bins at 0.5 with [`Bins::from`].
///
/// ```
/// use gradient_mc::observers::{Bins, DensityProfile};
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// let slab = Slab::new(60.0, 6.0, 6.0)?;
/// let scene = Scene::new(slab, 72, UniformField::default(), Isothermal::new(5.0)?)?;
/// let mut profile = DensityProfile::new(&slab, Bins::count(120))?;
/// Simulation::builder(scene).build()?.run(64, &mut profile)?;
/// // n A Δx, summed over the bins, is the number of spheres.
/// let spheres: f64 = profile.means().iter().map(|density| density * 36.0 * 0.5).sum();
/// assert!((spheres - 72.0).abs() < 1e-9);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct DensityProfile {
    run: OneRun,
    bins: HeightBins,
    counts: Vec<f64>,
    averages: BlockAverages,
}

/// Density of one bin, with standard errors.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct DensityPoint {
    /// Middle of the bin, in diameters.
    pub height: f64,
    /// Number density, in inverse cubic diameters.
    pub number_density: Estimate,
    /// Packing fraction πn/6.
    pub packing_fraction: Estimate,
}

impl DensityProfile {
    /// Makes an empty profile with `bins` over the heights of `slab`.
    ///
    /// # Errors
    /// Those of [`Bins`].
    pub fn new(slab: &Slab, bins: Bins) -> Result<Self, Error> {
        let bins = bins.of(slab)?;
        let averages = BlockAverages::new(bins.count())?.said_of("frames for a density profile");
        Ok(Self { run: OneRun::in_slab(slab), bins, counts: vec![0.0; bins.count()], averages })
    }

    /// Number of frames observed.
    #[must_use]
    pub fn observations(&self) -> u64 {
        self.averages.observations()
    }

    /// Mean number density of every bin, upwards, without standard errors, also for short runs. NaN
    /// before the first frame.
    #[must_use]
    pub fn means(&self) -> Vec<f64> {
        let volume = self.bins.volume();
        self.averages.mean().into_iter().map(|count| count / volume).collect()
    }

    /// The profile, from the lowest bin upwards.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] for fewer than 16 frames.
    pub fn points(&self) -> Result<Vec<DensityPoint>, Error> {
        let volume = self.bins.volume();
        let counts = self.averages.estimates_of_rows(&[super::ALIKE_COUNTS])?;
        let points = self.bins.centers().zip(counts).map(|(height, count)| {
            let (mean, standard_error) = (count.mean / volume, count.standard_error / volume);
            DensityPoint {
                height,
                number_density: Estimate::new(mean, standard_error),
                packing_fraction: super::packing_fraction(Estimate::new(mean, standard_error)),
            }
        });
        Ok(points.collect())
    }

    /// Warnings about bins below the top 1 % of the spheres: [`Warning::EmptyBins`] and
    /// [`Warning::ThinBins`] for empty and rarely occupied bins; [`Warning::CorrelatedBins`] if the
    /// effective number of independent configurations is below 2.5 in one of four parts of the
    /// column; [`Warning::ReplicasDisagree`] if merged replicas differ.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        diagnostics::of_bins(&self.bins, &self.averages)
    }

    /// Values of any `function` of the number densities of all bins, with errors by the jackknife
    /// over blocks.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] for fewer than 16 frames.
    pub fn jackknife<R: AsRef<[f64]>>(
        &self,
        mut function: impl FnMut(&[f64]) -> R,
    ) -> Result<Vec<Estimate>, Error> {
        let volume = self.bins.volume();
        let mut densities = Vec::with_capacity(self.bins.count());
        self.averages.jackknife(|counts| {
            densities.clear();
            densities.extend(counts.iter().map(|count| count / volume));
            function(&densities)
        })
    }

    /// Lowest possible height of a center.
    pub(super) fn lowest_center(&self) -> f64 {
        self.bins.lowest_center()
    }
}

impl Merge for DensityProfile {
    fn merge(&mut self, other: &Self) -> Result<(), Error> {
        self.bins.require_same(&other.bins)?;
        self.run.pool(&mut self.averages, &other.run, &other.averages)
    }
}

impl Observer for DensityProfile {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.run.admit(frame)?;
        self.counts.fill(0.0);
        for height in frame.heights() {
            if let Place::Inside(bin, _) = self.bins.locate(height) {
                self.counts[bin] += 1.0;
            }
        }
        self.averages.push(&self.counts)?;
        Ok(())
    }
}

persist!(DensityProfile { part run, same bins, part averages });

#[cfg(test)]
mod tests {
    use super::super::test_frame::{Scene, ideal_heights};
    use super::*;
    use crate::warning::Disagreement;

    #[test]
    fn counts_become_densities() {
        let mut scene = Scene::new(10.0, &[0.5, 0.7, 3.2, 9.5]);
        let mut profile = DensityProfile::new(&scene.slab, Bins::count(10)).unwrap();
        let mut upper = DensityProfile::new(&scene.slab, Bins::count(13).from(3.0).to(9.5)).unwrap();
        for _ in 0..16 {
            (&mut profile, &mut upper).observe(&scene.frame()).unwrap();
        }
        let points = profile.points().unwrap();
        assert_eq!(points.len(), 10);
        let expected = [2.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0].map(|count| count / 25.0);
        for ((point, mean), (bin, expected)) in
            points.iter().zip(profile.means()).zip(expected.iter().enumerate())
        {
            approx::assert_relative_eq!(point.height, bin as f64 + 0.5);
            approx::assert_relative_eq!(point.number_density.mean, expected, epsilon = 1e-15);
            approx::assert_relative_eq!(mean, expected, epsilon = 1e-15);
            assert!(point.number_density.standard_error < 1e-15);
            let eta = std::f64::consts::PI / 6.0 * expected;
            approx::assert_relative_eq!(point.packing_fraction.mean, eta, epsilon = 1e-15);
        }
        // Half-diameter bins from 3: the sphere at the upper edge counts in the last.
        let upper = upper.means();
        approx::assert_relative_eq!(upper[0], 2.0 / 25.0, max_relative = 1e-12);
        approx::assert_relative_eq!(upper[12], 2.0 / 25.0, max_relative = 1e-12);

        scene.slab = Slab::new(10.0, 5.0, 6.0).unwrap();
        assert!(profile.observe(&scene.frame()).is_err());
    }

    #[test]
    fn replicas_are_pooled_and_errors_are_poissonian() {
        let scene = Scene::new(200.0, &[]);
        let mut pooled = DensityProfile::new(&scene.slab, Bins::count(100)).unwrap();
        let frames = 1600;
        for replica in 0..4 {
            let mut scene = Scene::new(200.0, &[]);
            let mut profile = DensityProfile::new(&scene.slab, Bins::count(100)).unwrap();
            for frame in 0..frames / 4 {
                scene.place(&ideal_heights(40, replica * 1000 + frame));
                profile.observe(&scene.frame()).unwrap();
            }
            pooled.merge(&profile).unwrap();
        }
        assert_eq!(pooled.observations(), frames);
        // Bin 2 to 4: probability e^{-(x - 0.5)/5} between the edges, binomial noise.
        let probability = (-0.3_f64).exp() - (-0.7_f64).exp();
        let point = pooled.points().unwrap()[1];
        let exact = 40.0 * probability / 50.0;
        let error = (40.0 * probability * (1.0 - probability) / frames as f64).sqrt() / 50.0;
        assert!((point.number_density.mean - exact).abs() < 4.0 * error);
        // The errors are up to 15 % too large, with a scatter of 18 %.
        let ratio = point.number_density.standard_error / error;
        assert!(ratio > 0.8 && ratio < 1.7, "{ratio}");
        let other = DensityProfile::new(&scene.slab, Bins::count(99)).unwrap();
        assert!(matches!(pooled.merge(&other), Err(Error::InvalidParameter { .. })));
    }

    #[test]
    fn bins_that_know_little_or_contradict_each_other_are_warned_of() {
        let profile = |frames: u64, heights: &dyn Fn(u64) -> Vec<f64>| {
            let mut scene = Scene::new(200.0, &[]);
            let mut profile = DensityProfile::new(&scene.slab, Bins::count(50)).unwrap();
            for frame in 0..frames {
                scene.place(&heights(frame));
                profile.observe(&scene.frame()).unwrap();
            }
            profile
        };
        let gas = |seed: u64| profile(1000, &|frame| ideal_heights(40, seed + frame));
        let mut pooled = gas(0);
        pooled.merge(&gas(1000)).unwrap();
        assert_eq!(pooled.warnings(), []);
        // A replica that is twice as hot.
        let hot = |frame| ideal_heights(40, 2000 + frame).iter().map(|x| 2.0 * x - 0.5).collect();
        pooled.merge(&profile(1000, &hot)).unwrap();
        assert!(
            matches!(pooled.warnings()[..], [.., Warning::ReplicasDisagree {
                disagreement: Disagreement::Bins { bins, lowest_height, highest_height }
            }] if bins > 2 && lowest_height < 5.0 && highest_height > 15.0),
            "{:?}",
            pooled.warnings()
        );
        // Two configurations in a thousand frames.
        let two = profile(1000, &|frame| ideal_heights(40, frame / 500));
        assert!(
            matches!(two.warnings()[..], [.., Warning::CorrelatedBins { effective_sample_size, .. }]
                if effective_sample_size < 2.5),
            "{:?}",
            two.warnings()
        );
    }
}
