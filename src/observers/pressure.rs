//! Pressure against height, from the weight of the column.

use super::bins::{Bins, HeightBins, Place};
use super::one_run::OneRun;
use crate::statistics::{BlockAverages, Estimate};
use crate::{Error, Frame, Merge, Observer, ObserverError, Slab, Wall};

/// Pressure P(x) that carries the column above,
///
/// P(x) = `P_end` + (1/A) Σ a(xᵢ) over the spheres with xᵢ > x
///
/// (eq. 3 of doi:10.1103/PhysRevE.83.061306), which force balance makes the normal pressure at every
/// height, layers at the walls included.
///
/// In one configuration this is a step function of x, and its mean over a bin is computed exactly: a
/// sphere in the bin counts with the fraction (xᵢ − low)/Δx of its weight. So there is no discretization
/// error other than the averaging over the bin; a sum over binned densities times Δx, as eq. (3) is
/// usually evaluated, has one.
///
/// `P_end` is what the wall at the [open end](crate::Scene::open_end) bears: zero for a column that ends before it (the
/// default), T n(contact) there otherwise. It is taken as exact. Where the field pulls up that wall is the base, and the
/// sum is that of −a(xᵢ) over the spheres with xᵢ < x.
///
/// ```
/// use gradient_mc::observers::{Bins, PressureProfile};
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// let slab = Slab::new(60.0, 6.0, 6.0)?;
/// let scene = Scene::new(slab, 72, UniformField::default(), Isothermal::new(5.0)?)?;
/// let mut profile = PressureProfile::new(&slab, Bins::count(120))?;
/// Simulation::builder(scene).build()?.run(64, &mut profile)?;
/// // Below the lowest centers the pressure is the weight of the column, N/A.
/// assert!((profile.points()?[0].pressure.mean - 2.0).abs() < 1e-12);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct PressureProfile {
    run: OneRun,
    bins: HeightBins,
    open_end_pressure: f64,
    weights: Vec<f64>,
    pressures: Vec<f64>,
    averages: BlockAverages,
}

/// Pressure of one bin.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PressurePoint {
    /// Middle of the bin.
    pub height: f64,
    /// Mean pressure over the bin, in m g/d².
    pub pressure: Estimate,
}

impl PressureProfile {
    /// A profile over `bins` of the heights of `slab`; spheres above them weigh on them.
    ///
    /// # Errors
    /// Those of [`Bins`].
    pub fn new(slab: &Slab, bins: Bins) -> Result<Self, Error> {
        let bins = bins.of(slab)?;
        Ok(Self {
            run: OneRun::in_slab(slab),
            bins,
            open_end_pressure: 0.0,
            weights: vec![0.0; bins.count()],
            pressures: vec![0.0; bins.count()],
            averages: BlockAverages::new(bins.count())?,
        })
    }

    /// Sets the pressure on the wall at the [open end](crate::Scene::open_end); it may be set after the run, since it is added to the results.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] if not finite.
    pub fn set_open_end_pressure(&mut self, pressure: f64) -> Result<(), Error> {
        self.open_end_pressure = Error::require_finite("pressure at the open end", pressure)?;
        Ok(())
    }

    /// Frames observed.
    #[must_use]
    pub fn observations(&self) -> u64 {
        self.averages.observations()
    }

    /// Mean pressure of every bin, upwards, without errors: for a running simulation. NaN before the
    /// first frame.
    #[must_use]
    pub fn means(&self) -> Vec<f64> {
        let area = self.bins.base_area();
        self.averages.mean().into_iter().map(|weight| weight / area + self.open_end_pressure).collect()
    }

    /// The profile, upwards.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] below 16 frames.
    pub fn points(&self) -> Result<Vec<PressurePoint>, Error> {
        let area = self.bins.base_area();
        let weights = self.averages.estimates_of_rows(&[super::ALIKE_WEIGHTS])?;
        let points = self.bins.centers().zip(weights).map(|(height, weight)| {
            let mean = weight.mean / area + self.open_end_pressure;
            PressurePoint { height, pressure: Estimate::new(mean, weight.standard_error / area) }
        });
        Ok(points.collect())
    }
}

/// The pressure at the open end stays this one's.
impl Merge for PressureProfile {
    fn merge(&mut self, other: &Self) -> Result<(), Error> {
        self.bins.require_same(&other.bins)?;
        self.run.require_same_scene(&other.run)?;
        self.averages.merge(&other.averages)?;
        self.run.join(&other.run);
        Ok(())
    }
}

impl Observer for PressureProfile {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.run.admit(frame)?;
        weigh_column(frame, &self.bins, &mut self.weights, &mut self.pressures, |_| {});
        self.averages.push(&self.pressures)?;
        Ok(())
    }
}

/// Sets `pressures` to the exact means over bins of the weight between a height and the open end (not yet divided by the
/// area), using `weights` as scratch, and calls `count` with the bin of every sphere inside.
pub(super) fn weigh_column(
    frame: &Frame<'_>,
    bins: &HeightBins,
    weights: &mut [f64],
    pressures: &mut [f64],
    mut count: impl FnMut(usize),
) {
    weights.fill(0.0);
    pressures.fill(0.0);
    let field = frame.field();
    let (mut above, mut all) = (0.0, 0.0);
    for height in frame.heights() {
        let weight = field.acceleration(height);
        all += weight;
        match bins.locate(height) {
            Place::Below => {}
            Place::Above => above += weight,
            Place::Inside(bin, fraction) => {
                weights[bin] += weight;
                pressures[bin] += weight * fraction;
                count(bin);
            }
        }
    }
    if frame.scene().open_end() == Wall::Base {
        above -= all;
    }
    for (pressure, weight) in pressures.iter_mut().zip(weights).rev() {
        *pressure += above;
        above += *weight;
    }
}

persist!(PressureProfile { part run, same bins, value open_end_pressure, part averages });

#[cfg(test)]
mod tests {
    use super::super::test_frame::{Scene, ideal_heights};
    use super::*;
    use crate::Field;
    use crate::field::ExponentialField;

    /// The bin mean of the step function, by brute force over sub-heights.
    fn by_hand(heights: &[f64], field: &dyn Field, low: f64, high: f64) -> f64 {
        let weight: f64 = heights
            .iter()
            .map(|&height| field.acceleration(height) * ((height - low) / (high - low)).clamp(0.0, 1.0))
            .sum();
        weight / 25.0
    }

    #[test]
    fn pressure_is_the_exact_mean_of_the_step_function() {
        let heights = ideal_heights(300, 1);
        let mut scene = Scene::new(150.0, &heights);
        scene.field = Box::new(ExponentialField::new(0.02).unwrap());
        for (low, high, bins) in [(0.0, 150.0, 37), (0.5, 20.5, 100), (3.0, 4.0, 1)] {
            let mut profile =
                PressureProfile::new(&scene.slab, Bins::count(bins).from(low).to(high)).unwrap();
            profile.set_open_end_pressure(0.25).unwrap();
            for _ in 0..16 {
                profile.observe(&scene.frame()).unwrap();
            }
            let width = (high - low) / bins as f64;
            for (point, mean) in profile.points().unwrap().iter().zip(profile.means()) {
                let (bottom, top) = (point.height - 0.5 * width, point.height + 0.5 * width);
                let exact = 0.25 + by_hand(&heights, &*scene.field, bottom, top);
                approx::assert_relative_eq!(mean, exact, max_relative = 1e-10);
                approx::assert_relative_eq!(point.pressure.mean, exact, max_relative = 1e-10);
            }
        }
    }

    #[test]
    fn refining_the_bins_changes_nothing_on_average() {
        let scene = Scene::new(150.0, &ideal_heights(300, 2));
        let mut coarse = PressureProfile::new(&scene.slab, Bins::count(10)).unwrap();
        let mut fine = PressureProfile::new(&scene.slab, Bins::count(1000)).unwrap();
        (&mut coarse, &mut fine).observe(&scene.frame()).unwrap();
        for (coarse, fine) in coarse.means().iter().zip(fine.means().chunks_exact(100)) {
            let mean = fine.iter().sum::<f64>() / 100.0;
            approx::assert_relative_eq!(*coarse, mean, max_relative = 1e-10);
        }
        // The base carries everything below the first sphere.
        approx::assert_relative_eq!(fine.means()[0], 300.0 / 25.0, max_relative = 1e-12);
        assert!(coarse.merge(&fine).is_err());
        assert!(coarse.set_open_end_pressure(f64::NAN).is_err());
    }
}
