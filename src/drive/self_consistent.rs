//! The effective field by iteration in equilibration, frozen in production.

use super::column_average::{ColumnAverage, Prior};
use super::effective_potential::bin_width_of;
use super::own_equation::OwnEquation;
use super::{Adaptation, EffectivePotential, MeasuredShare, Scheme};
use crate::equation_of_state::{EquationOfState, FluidSolid};
use crate::frame::{Frame, Phase};
use crate::observer::{Observer, ObserverError, Recorder};
use crate::scene::AnyScene;
use crate::statistics::drift;
use crate::{Error, Field, Scene, TemperatureProfile, Warning};

/// Scheme with the effective field by iteration, the default if the temperature varies. Each step
/// of equilibration measures in a constant field and then updates the field. Each step is twice as
/// long as the one before. The field is frozen when production starts.
///
/// Detailed balance is exact in production.
/// [`Simulation::certificate`](crate::Simulation::certificate) checks, without an equation of
/// state, whether the field is self-consistent.
///
/// **Bulk: from collisions.** The field needs P/n = T Z (eq. 20 of doi:10.1103/PhysRevE.83.061306).
/// The collisions of event chains give Z(η) in any field, also before the column is stationary,
/// because only local equilibrium is needed. After every step two coefficients of Z = 1 + (c₁ η +
/// c₂ η²)/(1 − η)³ are fitted to the data, where the last step has twice the weight of the one
/// before. Hydrostatics between walls
/// ([`Hydrostatics::between_walls`](crate::Hydrostatics::between_walls)) with this Z gives a smooth
/// P/n. The noise of the field is therefore that of two numbers, and the equation of state at the
/// [start](Self::new) of the iteration has no influence after a few steps.
///
/// **Layers at the walls: from counts.** A local equation of state does not describe the layers.
/// There P/n is measured as the weight of the column over the number of spheres, in steps:
/// - Within a step the field is constant, so the column relaxes as an isothermal one. The first
///   quarter of each step is not used.
/// - Counts and weights are averaged, not ratios of single configurations. The bias of 1/k from the
///   noise of the averaged counts k is subtracted; the variance of k is measured by comparing
///   alternate eighths of the step.
/// - The closure by Z has the weight of 10⁴ counted spheres per diameter of height
///   ([`closure_weight`](Self::closure_weight)), and 3 % of this weight in the layers within four
///   diameters of a wall. As the steps get longer, the counts dominate, first at the walls.
///   `docs/physics.md` explains the choice of the weight.
/// - Counts of a step are used only if the column was stationary, because a field from other counts
///   would hold the column at its present height. It was stationary if the mean height of its
///   center of mass is equal in both halves of the step, within four standard errors.
/// - The pressure on the wall at the [open end](Scene::open_end) is the contact density there times
///   T, averaged with that of the closure. The closure has ten times its usual weight here, because
///   10⁴ sweeps of 500 spheres in a closed box give the contact density only to about 4 %.
///
/// With local moves alone there are no collisions, and the closure keeps the equation of state of
/// the start. For crystals, Z is that of Speedy's equation, which is not measured.
/// [`measured_share`](super::Adaptation::measured_share), certificates and warnings report the part
/// of the field that was measured.
///
/// ```
/// use gradient_mc::drive::{Adaptation, SelfConsistent};
/// use gradient_mc::equation_of_state::IdealGas;
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::ExponentialTemperature};
/// let temperature = ExponentialTemperature::new(5.0, 0.02)?;
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 360, UniformField::default(), temperature)?;
/// // The iteration starts with the ideal gas, Z = 1.
/// let mut simulation = Simulation::builder(scene).scheme(SelfConsistent::new(IdealGas)).build()?;
/// simulation.equilibrate(1000, &mut ())?;
/// assert!(simulation.adaptation().measured_share().is_some_and(|share| share.bulk > 0.9));
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SelfConsistent<E = FluidSolid> {
    equation_of_state: E,
    bin_width: f64,
    closure_weight: f64,
}

impl Default for SelfConsistent {
    /// The iteration started with [`FluidSolid`], the most accurate equation of state of the
    /// library.
    fn default() -> Self {
        Self::new(FluidSolid::default())
    }
}

impl<E> SelfConsistent<E> {
    /// Makes the scheme with this equation of state at the start, bins of 0.1 diameters, and a
    /// weight of the closure of 10⁴ spheres per diameter.
    pub fn new(equation_of_state: E) -> Self {
        Self { equation_of_state, bin_width: 0.1, closure_weight: 1e4 }
    }

    /// Sets the bin width, in diameters.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] unless positive and finite.
    pub fn bin_width(self, bin_width: f64) -> Result<Self, Error> {
        Ok(Self { bin_width: bin_width_of(bin_width)?, ..self })
    }

    /// Sets the weight of the closure, in counted spheres per diameter of height; see the type.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] unless positive and finite.
    pub fn closure_weight(self, spheres_per_diameter: f64) -> Result<Self, Error> {
        let closure_weight = Error::require_positive("weight of the closure", spheres_per_diameter)?;
        Ok(Self { closure_weight, ..self })
    }
}

/// The adaptation of [`SelfConsistent`]: P/n of the last step of the iteration.
#[derive(Debug, Clone)]
pub struct Iteration {
    prior: Prior,
    own: Option<OwnEquation>,
    open_end_pressure: f64,
    /// Fraction of the difference to the contact density by which the pressure at the open end is
    /// corrected in a step.
    end_gain: f64,
    measured: MeasuredShare,
    steps: u32,
    /// Counts and weights of the current step.
    average: ColumnAverage,
    /// Counts and weights of the last step in which the column was stationary.
    at_rest: ColumnAverage,
    /// Heights of the center of mass in the current step.
    centers: Vec<f64>,
    sweeps: u64,
    step: [u64; 2],
    /// Whether the last sweep was one of equilibration.
    adapting: bool,
}

impl<F: Field, T: TemperatureProfile, E: EquationOfState> Scheme<F, T> for SelfConsistent<E> {
    type Drive = EffectivePotential;
    type Adaptation = Iteration;

    fn drive(self, scene: &Scene<F, T>) -> Result<(EffectivePotential, Iteration), Error> {
        let mut potential = EffectivePotential::new(scene, self.bin_width)?;
        let prior = Prior::new(scene, &potential, &self.equation_of_state, self.closure_weight)?;
        potential.set(prior.open_end_pressure, |bin| prior.ratios[bin])?;
        let temperature = |height: f64| scene.temperature().temperature(height);
        let mean_inverse = potential.heights().map(|height| 1.0 / temperature(height)).sum::<f64>()
            / potential.bins() as f64;
        // In a box without a field the contact density changes more than a wrong pressure, by this
        // factor (`docs/physics.md`).
        let response = temperature(scene.open_end().contact_height(scene.slab())) * mean_inverse;
        let iteration = Iteration {
            open_end_pressure: prior.open_end_pressure,
            end_gain: 1.0 / response.max(1.0),
            prior,
            own: OwnEquation::new(scene.slab()),
            measured: MeasuredShare::NONE,
            steps: 0,
            average: ColumnAverage::new(&potential),
            at_rest: ColumnAverage::new(&potential),
            centers: Vec::new(),
            sweeps: 0,
            step: [0, Iteration::FIRST_STEP],
            adapting: true,
        };
        Ok((potential, iteration))
    }
}

impl Iteration {
    /// Sweeps of the first step.
    const FIRST_STEP: u64 = 64;
    /// Largest number of heights of the center of mass by which a step is judged.
    const MOST_CENTERS: u64 = 256;
    /// Sweeps between two counts of the column; successive configurations are strongly correlated.
    const SWEEPS_BETWEEN_LOOKS: u64 = 4;
    /// Intervals of a step from which the noise of counts is estimated.
    const INTERVALS: u64 = 8;
    /// Sweeps between two counts for the packing fractions of collisions.
    const SWEEPS_BETWEEN_COUNTS: u64 = 2;

    /// Number of steps so far.
    #[must_use]
    pub fn steps(&self) -> u32 {
        self.steps
    }

    /// Whether the column was stationary in the step, within its standard errors; false if the step
    /// is too short to decide.
    fn stood_still(&self) -> bool {
        /// A drift is significant above this number of standard errors.
        const LARGEST_DRIFT: f64 = 4.0;
        drift(&self.centers).is_ok_and(|drift| drift.deviation_from(0.0).abs() <= LARGEST_DRIFT)
    }

    /// Ends a step: updates the closure to the measured equation of state and, if the column was
    /// stationary, the field to the counts. Nothing changes on an error.
    fn update(&mut self, potential: &mut EffectivePotential, scene: &AnyScene<'_>) -> Result<(), Error> {
        let at_rest = self.stood_still();
        let Self { own, prior, .. } = self;
        // If a fit with two terms gives no profile, one term is used.
        let closure = [2, 1].into_iter().find_map(|terms| {
            let equation = own.as_mut()?.fit(terms)?;
            let closure = Prior::new(scene, potential, &equation, prior.weight).ok()?;
            Some(Prior { measured: 1.0, ..closure })
        });
        if at_rest || closure.is_some() {
            let prior = closure.unwrap_or_else(|| self.prior.clone());
            let counted = if at_rest { &self.average } else { &self.at_rest };
            let width = potential.bin_width();
            let contact = counted.open_end_pressure(scene, &prior);
            let end = self.open_end_pressure + self.end_gain * (contact - self.open_end_pressure);
            let ratios = counted.ratios(scene, width, end, &prior);
            potential.set(end, |bin| ratios[bin])?;
            self.open_end_pressure = end;
            self.measured = counted.measured_share(scene, width, &prior, &self.average);
            self.prior = prior;
            if at_rest {
                std::mem::swap(&mut self.average, &mut self.at_rest);
            }
        }
        self.steps += 1;
        self.clear();
        Ok(())
    }

    fn clear(&mut self) {
        self.average.clear();
        self.centers.clear();
        if let Some(own) = &mut self.own {
            own.next_step();
        }
    }

    /// Whether collisions of this sweep are used: after the start has relaxed locally.
    fn listens(&self, sweep: u64) -> bool {
        self.steps > 0 || self.is_relaxed(sweep)
    }

    /// Whether the sweep is after the first quarter of the current step.
    fn is_relaxed(&self, sweeps: u64) -> bool {
        let [begin, end] = self.step;
        4 * (sweeps - begin) > end - begin
    }
}

impl Observer for Iteration {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.adapting = frame.phase() == Phase::Equilibration;
        if self.adapting {
            let sweeps = self.sweeps + 1;
            let [begin, end] = self.step;
            let relaxed = self.is_relaxed(sweeps);
            // The same number of centers of mass for all lengths of a step.
            let interval = ((end - begin) / Self::MOST_CENTERS).max(1);
            // First the part that calls the field of the user, which may panic.
            if relaxed && sweeps.is_multiple_of(Self::SWEEPS_BETWEEN_LOOKS) {
                self.average.add(frame, Self::INTERVALS * (sweeps - begin) / (end - begin));
            }
            if self.listens(sweeps)
                && sweeps.is_multiple_of(Self::SWEEPS_BETWEEN_COUNTS)
                && let Some(own) = &mut self.own
            {
                own.add(frame);
            }
            if relaxed && sweeps.is_multiple_of(interval) {
                self.centers.push(frame.heights().sum::<f64>() / frame.particles() as f64);
            }
            self.sweeps = sweeps;
        }
        Ok(())
    }

    /// Collisions, in equilibration.
    fn recorder(&mut self) -> Option<&mut dyn Recorder> {
        let listens = self.adapting && self.listens(self.sweeps + 1);
        self.own.as_mut().filter(|_| listens).map(OwnEquation::recorder)
    }
}

impl Adaptation<EffectivePotential> for Iteration {
    fn adapt(&mut self, potential: &mut EffectivePotential, scene: &AnyScene<'_>) -> Result<(), Error> {
        let [_, end] = self.step;
        if !self.adapting || self.sweeps < end {
            return Ok(());
        }
        let updated = self.update(potential, scene);
        if updated.is_err() {
            // The field stays, and the next step begins.
            self.clear();
        }
        self.step = [end, 2 * end];
        updated
    }

    fn start_production(
        &mut self,
        potential: &mut EffectivePotential,
        scene: &AnyScene<'_>,
    ) -> Result<(), Error> {
        // A step that has just begun has fewer data than the current field.
        if self.average.configurations() > 0
            && 2 * self.average.configurations() >= self.at_rest.configurations()
        {
            self.update(potential, scene)?;
        }
        self.adapting = false;
        // A later equilibration starts a new iteration from the current field.
        self.clear();
        self.step = [self.sweeps, self.sweeps + self.step[0].max(Self::FIRST_STEP)];
        Ok(())
    }

    /// [`MeasuredShare::NONE`] before the first stationary step.
    fn measured_share(&self) -> Option<MeasuredShare> {
        Some(self.measured)
    }

    /// [`Warning::FieldOfTheory`].
    fn warnings(&self, _: &EffectivePotential, _: &AnyScene<'_>) -> Vec<Warning> {
        self.measured.warning().into_iter().collect()
    }
}

persist!(
    Iteration {
        part prior,
        same end_gain,
        value open_end_pressure,
        value measured,
        value steps,
        part average,
        part at_rest,
        part own,
        value centers,
        count sweeps,
        value step,
        value adapting,
    },
    |iteration| {
        let [begin, end] = iteration.step;
        begin <= iteration.sweeps && begin < end && end <= 1 << 53 && iteration.steps < u32::MAX
    }
);
