//! Profile of the mobility of spheres.

use super::bins::{Bins, HeightBins, Place};
use super::one_run::OneRun;
use crate::statistics::{BlockAverages, Estimate};
use crate::{AcceptedMove, Error, Frame, Merge, MoveCounts, Observer, ObserverError, Recorder, Slab};

/// Mobility of spheres as a function of the height at which a move begins.
///
/// The local mobility of the paper is the mean length of accepted displacements in a bin
/// (doi:10.1103/PhysRevE.83.061306, figs. 5, 12 and 15). It is small in a frozen part. It does not
/// contain the acceptance; therefore path length and number of accepted moves per sphere and sweep
/// are measured too.
///
/// The values depend on the moves. Those of the paper are for local moves with S = 0.75, and 0.25
/// in the strongest field.
///
/// An observation is an interval between two frames: the moves of the interval, and the spheres of
/// each bin at its end. Moves before the first frame are not counted. Intervals are dropped if the
/// simulation ran without this observer, or if a sweep ended with an error.
///
/// ```
/// use gradient_mc::observers::{Bins, DisplacementProfile};
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// let slab = Slab::new(60.0, 6.0, 6.0)?;
/// let scene = Scene::new(slab, 36, UniformField::default(), Isothermal::new(5.0)?)?;
/// let mut profile = DisplacementProfile::new(&slab, Bins::count(20))?;
/// Simulation::builder(scene).build()?.run(100, &mut profile)?;
/// for point in profile.points()? {
///     println!("{:4.1}  {}", point.height, point.path_per_sweep);
/// }
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct DisplacementProfile {
    run: OneRun,
    bins: HeightBins,
    /// Current interval: path length in all bins, accepted moves in all bins and, set at its end,
    /// spheres times sweeps in all bins.
    sample: Vec<f64>,
    /// Number of moves recorded in the interval, also outside the bins.
    recorded: u64,
    /// Sweep number and move counts at the beginning of the interval.
    start: Option<(u64, MoveCounts)>,
    averages: BlockAverages,
}

/// Mobility in one bin, with standard errors.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct DisplacementPoint {
    /// Middle of the bin, in diameters.
    pub height: f64,
    /// Mean length of an accepted displacement, in diameters (Δr per Monte Carlo step in the
    /// paper). NaN if none was accepted.
    pub mean_displacement: Estimate,
    /// Path length of a sphere in one sweep, in diameters: the sum of its accepted displacements.
    /// NaN if the bin was always empty.
    pub path_per_sweep: Estimate,
    /// Number of accepted moves of a sphere in one sweep. For local moves, with one trial per
    /// sphere and sweep, this is the acceptance at this height. NaN if the bin was always empty.
    pub accepted_per_sweep: Estimate,
}

impl DisplacementProfile {
    /// Makes an empty profile with `bins` over the heights of `slab`.
    ///
    /// # Errors
    /// Those of [`Bins`].
    pub fn new(slab: &Slab, bins: Bins) -> Result<Self, Error> {
        let bins = bins.of(slab)?;
        let averages = BlockAverages::new(3 * bins.count())?.said_of("intervals for a displacement profile");
        Ok(Self {
            run: OneRun::in_slab(slab),
            bins,
            sample: vec![0.0; 3 * bins.count()],
            recorded: 0,
            start: None,
            averages,
        })
    }

    /// Number of intervals observed: one less than the number of frames, if none was dropped.
    #[must_use]
    pub fn observations(&self) -> u64 {
        self.averages.observations()
    }

    /// The profile, from the lowest bin upwards, with errors by the jackknife.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] for fewer than 16 intervals.
    pub fn points(&self) -> Result<Vec<DisplacementPoint>, Error> {
        let bins = self.bins.count();
        let ratios = self.averages.jackknife(|means| {
            let ratio = move |numerator: usize, denominator: usize| {
                (0..bins).map(move |bin| means[numerator * bins + bin] / means[denominator * bins + bin])
            };
            ratio(0, 1).chain(ratio(0, 2)).chain(ratio(1, 2)).map(finite_or_nan).collect::<Vec<f64>>()
        })?;
        let points = self.bins.centers().enumerate().map(|(bin, height)| DisplacementPoint {
            height,
            mean_displacement: ratios[bin],
            path_per_sweep: ratios[bins + bin],
            accepted_per_sweep: ratios[2 * bins + bin],
        });
        Ok(points.collect())
    }
}

/// A rate is unknown in a bin with moves but without a sphere in any frame.
fn finite_or_nan(ratio: f64) -> f64 {
    if ratio.is_finite() { ratio } else { f64::NAN }
}

impl Merge for DisplacementProfile {
    fn merge(&mut self, other: &Self) -> Result<(), Error> {
        self.bins.require_same(&other.bins)?;
        self.run.pool(&mut self.averages, &other.run, &other.averages)
    }
}

impl Observer for DisplacementProfile {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.run.admit(frame)?;
        if let Some((start_sweep, start)) = self.start {
            let sweeps = frame.sweep() - start_sweep;
            // If the simulation counted more moves than were recorded, it ran without this observer
            // in between.
            let moves = frame.move_counts().since(&start);
            let complete = moves.displacements() <= self.recorded && moves.incomplete_sweeps == 0;
            if complete {
                // The occupation at the end is used for the whole interval; in a steady state both
                // are equal on average.
                let exposures = &mut self.sample[2 * self.bins.count()..];
                for height in frame.heights() {
                    if let Place::Inside(bin, _) = self.bins.locate(height) {
                        exposures[bin] += sweeps as f64;
                    }
                }
                self.averages.push(&self.sample)?;
            }
        }
        self.sample.fill(0.0);
        self.recorded = 0;
        self.start = Some((frame.sweep(), *frame.move_counts()));
        Ok(())
    }

    fn recorder(&mut self) -> Option<&mut dyn Recorder> {
        Some(self)
    }
}

impl Recorder for DisplacementProfile {
    fn record_move(&mut self, accepted: &AcceptedMove) {
        self.recorded += 1;
        if let Place::Inside(bin, _) = self.bins.locate(accepted.from_height) {
            self.sample[bin] += accepted.displacement.norm();
            self.sample[self.bins.count() + bin] += 1.0;
        }
    }
}

persist!(
    DisplacementProfile { part run, same bins, slice sample, count recorded, value start, part averages },
    |profile| profile.start.is_none_or(|(sweep, _)| profile.run.is_past(sweep))
);

#[cfg(test)]
mod tests {
    use super::super::test_frame::Scene;
    use super::*;
    use crate::Vector3;

    fn moved(profile: &mut DisplacementProfile, scene: &mut Scene, from_height: f64, length: f64) {
        let displacement = Vector3::new(0.0, 0.6 * length, -0.8 * length);
        profile.record_move(&AcceptedMove { from_height, displacement, chain_axis: None });
        scene.move_counts.accepted += 1;
    }

    #[test]
    fn rates_and_lengths_are_those_of_the_moves() {
        // Two spheres in the lower half, one in the upper, frames every ten sweeps.
        let mut scene = Scene::new(10.0, &[1.0, 2.0, 7.0]);
        let mut profile = DisplacementProfile::new(&scene.slab, Bins::count(3).from(0.0).to(9.0)).unwrap();
        scene.move_counts.accepted = 1000;
        scene.sweep.set(5);
        moved(&mut profile, &mut scene, 1.0, 100.0);
        profile.observe(&scene.frame()).unwrap();
        for interval in 0..40 {
            for _ in 0..4 {
                moved(&mut profile, &mut scene, 1.0, 0.1);
                moved(&mut profile, &mut scene, 2.0, 0.3);
                moved(&mut profile, &mut scene, 7.0, 0.5);
                moved(&mut profile, &mut scene, 9.5, 0.5);
            }
            if interval == 20 {
                // The simulation ran without the observer for a while.
                scene.sweep.set(scene.sweep.get() + 1000);
                scene.move_counts.accepted += 1;
            }
            scene.sweep.set(scene.sweep.get() + 9);
            profile.observe(&scene.frame()).unwrap();
        }
        assert_eq!(profile.observations(), 39);
        let points = profile.points().unwrap();
        let expected = [(0.2, 8.0 * 0.2 / 20.0, 8.0 / 20.0), (f64::NAN, f64::NAN, f64::NAN), (0.5, 0.2, 0.4)];
        for (point, (length, path, accepted)) in points.iter().zip(expected) {
            for (estimate, value) in [
                (point.mean_displacement, length),
                (point.path_per_sweep, path),
                (point.accepted_per_sweep, accepted),
            ] {
                assert_eq!(estimate.mean.is_nan(), value.is_nan());
                assert!(value.is_nan() || (estimate.mean - value).abs() < 1e-12);
                assert!(value.is_nan() || estimate.standard_error < 1e-12);
            }
        }
    }

    #[test]
    fn replicas_are_pooled() {
        let mut pooled = DisplacementProfile::new(&Scene::new(10.0, &[]).slab, Bins::count(1)).unwrap();
        for length in [0.2, 0.4] {
            let mut scene = Scene::new(10.0, &[1.0]);
            let mut profile = DisplacementProfile::new(&scene.slab, Bins::count(1)).unwrap();
            for _ in 0..=64 {
                profile.observe(&scene.frame()).unwrap();
                moved(&mut profile, &mut scene, 1.0, length);
            }
            pooled.merge(&profile).unwrap();
        }
        let point = pooled.points().unwrap()[0];
        approx::assert_relative_eq!(point.mean_displacement.mean, 0.3, max_relative = 1e-12);
        // Replicas disagree: two means 0.2 apart.
        let error = point.mean_displacement.standard_error;
        approx::assert_relative_eq!(error, 0.1, max_relative = 1e-9);
        let other = DisplacementProfile::new(&Scene::new(10.0, &[]).slab, Bins::count(2)).unwrap();
        assert!(matches!(pooled.merge(&other), Err(Error::InvalidParameter { .. })));
    }
}
