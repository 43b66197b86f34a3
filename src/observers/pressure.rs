//! Profile of the pressure from the weight of the column.

use super::bins::{Bins, HeightBins, Place};
use super::one_run::OneRun;
use crate::drive::WallContact;
use crate::statistics::{BlockAverages, Estimate};
use crate::{Error, Frame, HydrostaticProfile, Merge, Observer, ObserverError, Slab, Wall, Warning};

/// Pressure P(x) from the weight of the column above, in m g/d²:
///
/// P(x) = `P_end` + (1/A) Σ a(xᵢ) over the spheres with xᵢ > x
///
/// (eq. 3 of doi:10.1103/PhysRevE.83.061306). By force balance it is the normal pressure at every
/// height, also in the layers at the walls.
///
/// In one configuration this is a step function of x. Its mean over a bin is computed exactly: a
/// sphere in the bin contributes the fraction (xᵢ − low)/Δx of its weight. Therefore there is no
/// discretization error, in contrast to a sum over binned densities.
///
/// `P_end` is the pressure on the wall at the [open end](crate::Scene::open_end): 0 (the default)
/// for a column that ends below this wall, and T n(contact) otherwise, which
/// [`WallPressure`](super::WallPressure) measures. If the field pulls up, this wall is the base,
/// and the sum is over −a(xᵢ) of the spheres with xᵢ < x.
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
    open_end: OpenEnd,
    weights: Vec<f64>,
    pressures: Vec<f64>,
    averages: BlockAverages,
}

/// Pressure of one bin, with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PressurePoint {
    /// Middle of the bin, in diameters.
    pub height: f64,
    /// Mean pressure over the bin, in m g/d².
    pub pressure: Estimate,
}

impl PressureProfile {
    /// Makes an empty profile with `bins` over the heights of `slab`. Spheres above the bins
    /// contribute to the pressure.
    ///
    /// # Errors
    /// Those of [`Bins`].
    pub fn new(slab: &Slab, bins: Bins) -> Result<Self, Error> {
        let bins = bins.of(slab)?;
        Ok(Self {
            run: OneRun::in_slab(slab),
            bins,
            open_end: OpenEnd::default(),
            weights: vec![0.0; bins.count()],
            pressures: vec![0.0; bins.count()],
            averages: BlockAverages::new(bins.count())?.said_of("frames for a pressure profile"),
        })
    }

    /// Sets the pressure on the wall at the [open end](crate::Scene::open_end), in m g/d², as an
    /// exact number or an estimate. It is added to the results, so it may be set after the run. Its
    /// error is treated as independent of that of the weights.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] if it is not finite.
    pub fn set_open_end_pressure(&mut self, pressure: impl Into<Estimate>) -> Result<(), Error> {
        self.open_end.set(pressure.into())
    }

    /// Number of frames observed.
    #[must_use]
    pub fn observations(&self) -> u64 {
        self.averages.observations()
    }

    /// Mean pressure of every bin, upwards, in m g/d², without standard errors, also for short
    /// runs. NaN before the first frame.
    #[must_use]
    pub fn means(&self) -> Vec<f64> {
        let (area, end) = (self.bins.base_area(), self.open_end.pressure().mean);
        self.averages.mean().into_iter().map(|weight| weight / area + end).collect()
    }

    /// [`Warning::LidTooLow`] if the wall at the open end carries pressure that was not set.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        let mut warnings = Vec::new();
        if self.observations() > 0 {
            let largest = self.averages.mean().into_iter().fold(0.0, f64::max);
            warnings.extend(self.open_end.warning(largest, self.observations()));
        }
        warnings
    }

    /// The profile, from the lowest bin upwards.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] for fewer than 16 frames.
    pub fn points(&self) -> Result<Vec<PressurePoint>, Error> {
        let area = self.bins.base_area();
        let weights = self.averages.estimates_of_rows(&[super::ALIKE_WEIGHTS])?;
        let points = self.bins.centers().zip(weights).map(|(height, weight)| PressurePoint {
            height,
            pressure: (weight / area).plus_independent(self.open_end.pressure()),
        });
        Ok(points.collect())
    }
}

/// The pressure at the open end of `self` is kept.
impl Merge for PressureProfile {
    fn merge(&mut self, other: &Self) -> Result<(), Error> {
        self.bins.require_same(&other.bins)?;
        self.run.pool(&mut self.averages, &other.run, &other.averages)?;
        self.open_end.join(&other.open_end);
        Ok(())
    }
}

impl Observer for PressureProfile {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.run.admit(frame)?;
        let weight = |height: f64| frame.field().acceleration(height);
        let contact = weigh_column(frame, &self.bins, weight, &mut self.weights, &mut self.pressures, |_| {});
        self.averages.push(&self.pressures)?;
        self.open_end.add(frame, contact);
        Ok(())
    }
}

/// The wall at the open end, for profiles of the pressure.
#[derive(Debug, Clone, Default)]
pub(super) struct OpenEnd {
    /// The pressure on this wall, if it has been set.
    pressure: Option<Estimate>,
    /// Its height; `None` before the first frame.
    height: Option<f64>,
    /// T n(contact) times the area, summed over frames.
    contacts: f64,
}

impl OpenEnd {
    pub(super) fn set(&mut self, pressure: Estimate) -> Result<(), Error> {
        Error::require_finite("pressure at the open end", pressure.mean)?;
        Error::require_finite("standard error of the pressure at the open end", pressure.standard_error)?;
        self.pressure = Some(pressure);
        Ok(())
    }

    /// The pressure that was set, or 0.
    pub(super) fn pressure(&self) -> Estimate {
        self.pressure.unwrap_or(Estimate::exact(0.0))
    }

    /// Adds T n(contact) A of a frame.
    pub(super) fn add(&mut self, frame: &Frame<'_>, contact: f64) {
        self.height = Some(match frame.scene().open_end() {
            Wall::Lid => frame.slab().height(),
            Wall::Base => 0.0,
        });
        self.contacts += contact;
    }

    /// Adds the data of a replica.
    pub(super) fn join(&mut self, other: &Self) {
        self.height = self.height.or(other.height);
        self.contacts += other.contacts;
    }

    /// A warning if the wall carries pressure that was not set; `largest` is the largest mean
    /// weight on a bin.
    pub(super) fn warning(&self, largest: f64, frames: u64) -> Option<Warning> {
        let (None, Some(lid)) = (self.pressure, self.height) else { return None };
        let contact = self.contacts / frames as f64;
        let pressure_ratio = contact / (contact + largest);
        (pressure_ratio > HydrostaticProfile::LARGEST_LID_PRESSURE)
            .then_some(Warning::LidTooLow { lid, pressure_ratio })
    }
}

/// Sets `pressures` to the exact means over bins of the weight between a height and the open end,
/// not divided by the area. `weight` is the weight of a sphere at a height, and `weights` is
/// scratch memory. Calls `count` with the bin of every sphere inside. Returns T n(contact) at the
/// open end times the area.
pub(super) fn weigh_column(
    frame: &Frame<'_>,
    bins: &HeightBins,
    weight: impl Fn(f64) -> f64,
    weights: &mut [f64],
    pressures: &mut [f64],
    mut count: impl FnMut(usize),
) -> f64 {
    weights.fill(0.0);
    pressures.fill(0.0);
    let (mut above, mut all) = (0.0, 0.0);
    let end = frame.scene().open_end().contact_height(frame.slab());
    let mut contact = WallContact::default();
    for height in frame.heights() {
        let weight = weight(height);
        all += weight;
        contact.add((end - height).abs());
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
    contact.density_times_area() * frame.temperature().temperature(end)
}

persist!(PressureProfile { part run, same bins, part open_end, part averages });

persist!(OpenEnd { value pressure, value height, value contacts });

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

    #[test]
    fn what_the_open_end_bears_is_missed_until_it_is_set() {
        let profile = |heights: &[f64]| {
            let scene = Scene::new(10.0, heights);
            let mut profile = PressureProfile::new(&scene.slab, Bins::count(5)).unwrap();
            assert_eq!(profile.warnings(), []);
            for _ in 0..16 {
                profile.observe(&scene.frame()).unwrap();
            }
            profile
        };
        assert_eq!(profile(&[1.0, 5.0]).warnings(), []);
        let mut near = profile(&[1.0, 9.48]);
        let warnings = near.warnings();
        assert!(matches!(warnings[..], [Warning::LidTooLow { lid: 10.0, .. }]), "{warnings:?}");
        let mut pooled = profile(&[2.0, 5.0]);
        pooled.merge(&near).unwrap();
        assert_eq!(pooled.warnings().len(), 1);
        let mut fresh = PressureProfile::new(&Scene::new(10.0, &[]).slab, Bins::count(5)).unwrap();
        fresh.merge(&near).unwrap();
        assert_eq!(fresh.warnings(), warnings);
        // The weights are the same in all frames.
        let without = near.points().unwrap();
        near.set_open_end_pressure(Estimate::new(2.0, 0.3)).unwrap();
        assert_eq!(near.warnings(), []);
        for (point, without) in near.points().unwrap().iter().zip(without) {
            approx::assert_relative_eq!(
                point.pressure.mean,
                without.pressure.mean + 2.0,
                max_relative = 1e-14
            );
            approx::assert_relative_eq!(point.pressure.standard_error, 0.3, max_relative = 1e-12);
        }
        assert!(near.set_open_end_pressure(Estimate::new(1.0, f64::NAN)).is_err());
    }
}
