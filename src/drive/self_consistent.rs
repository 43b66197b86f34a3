//! The effective field iterated while equilibrating, then frozen for production.

use super::column_average::{ColumnAverage, Prior};
use super::effective_potential::bin_width_of;
use super::{Adaptation, EffectivePotential, MeasuredShare, Scheme};
use crate::equation_of_state::FluidSolid;
use crate::frame::{Frame, Phase};
use crate::observer::{Observer, ObserverError};
use crate::scene::AnyScene;
use crate::statistics::drift;
use crate::{Error, Field, Scene, TemperatureProfile, Warning};

/// The effective field by iteration: freeze, measure, update, every time twice as long as before; frozen for good when
/// production starts. The default choice for temperatures that vary.
///
/// Production holds detailed balance exactly, in the field that was frozen, and
/// [`Simulation::certificate`](crate::Simulation::certificate) tells, without an equation of state, whether it was the right
/// one.
///
/// - The iteration starts at the field of the theory profile, which is within a per cent of the result, and what is left
///   of a start shrinks by the spectral radius of the map from density to field with every step (0.11 to 0.57 for the
///   paper's β = 0.005 to 0.05, doi:10.1103/PhysRevE.83.061306). An average over everything so far would
///   remember it as a power of the number of sweeps ([`AveragedThenFrozen`](super::AveragedThenFrozen)).
/// - Within a step the field does not change, so the column relaxes as any isothermal one; the first quarter of each
///   step is left out.
/// - Counts and weights are averaged, never ratios of single configurations, so there is no noise
///   bias of order 1/(spheres per bin and sweep). The last step, some half of the equilibration, makes the field.
/// - A step in which the column fell or rose changes nothing: a field made of it would hold the column where it is, by
///   its own weight. The column goes on in the field in force, at first the theory's, until it is at rest: until its
///   center of mass in the second half of a step is where it was in the first, within four standard errors.
/// - The theory profile ([`Hydrostatics::between_walls`](crate::Hydrostatics::between_walls)) stands in with the
///   [weight](Self::theory_weight) of 10⁴ counted spheres per diameter of height, and in the layers within four diameters of a wall,
///   of which it knows nothing, with 3 % of that. So a short equilibration gives the field of the closure, a long one what was
///   measured, and no bin is ever empty. [`measured_share`](super::Adaptation::measured_share), certificates and
///   warnings say how much was measured. `docs/physics.md` has the measurement by which the weight was chosen;
///   [`without_theory`](Self::without_theory) leaves it out.
/// - The pressure on the wall at the [open end](Scene::open_end) is the contact density there times T, together with that of the theory, which has ten times
///   the weight there: in a closed box 10⁴ sweeps of 500 spheres know a contact density to some 4 %.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SelfConsistent {
    bin_width: f64,
    theory_weight: f64,
}

impl Default for SelfConsistent {
    /// Bins of 0.1 diameters, and a theory that stands for 10⁴ spheres per diameter.
    fn default() -> Self {
        Self { bin_width: 0.1, theory_weight: 1e4 }
    }
}

impl SelfConsistent {
    /// Bins of the given width, in diameters.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] unless positive and finite.
    pub fn bin_width(self, bin_width: f64) -> Result<Self, Error> {
        Ok(Self { bin_width: bin_width_of(bin_width)?, ..self })
    }

    /// How many counted spheres per diameter of height the theory profile stands for; see the type.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] unless positive and finite.
    pub fn theory_weight(self, spheres_per_diameter: f64) -> Result<Self, Error> {
        let theory_weight = Error::require_positive("weight of the theory", spheres_per_diameter)?;
        Ok(Self { theory_weight, ..self })
    }

    /// The theory has no weight: from the first step at rest on, the field is what was measured, wherever a sphere was seen.
    /// The theory only makes the field of the start, and that of bins that stayed empty.
    ///
    /// It takes a long equilibration: the noise of few counts biases the field. With 1000 sweeps of 180 spheres it is off by
    /// up to 8 %, with 40 000 by less than 1 %.
    #[must_use]
    pub fn without_theory(self) -> Self {
        Self { theory_weight: 0.0, ..self }
    }
}

/// Of [`SelfConsistent`]: P/n of the last step of the iteration.
#[derive(Debug, Clone)]
pub struct Iteration {
    prior: Prior,
    open_end_pressure: f64,
    /// Of what the contact density says, the part by which the pressure at the open end follows it in a step.
    end_gain: f64,
    measured: MeasuredShare,
    steps: u32,
    /// What the step under way has measured, and how many configurations made the field in force.
    average: ColumnAverage,
    configurations_in_force: u64,
    /// Heights of the center of mass in the step under way.
    centers: Vec<f64>,
    sweeps: u64,
    step: [u64; 2],
    /// Whether the last sweep was one of equilibration.
    adapting: bool,
}

impl<F: Field, T: TemperatureProfile> Scheme<F, T> for SelfConsistent {
    type Drive = EffectivePotential;
    type Adaptation = Iteration;

    fn drive(self, scene: &Scene<F, T>) -> Result<(EffectivePotential, Iteration), Error> {
        let mut potential = EffectivePotential::new(scene, self.bin_width)?;
        let prior = Prior::new(scene, &potential, &FluidSolid::default(), self.theory_weight)?;
        potential.set(prior.open_end_pressure, |bin| prior.ratios[bin])?;
        let temperature = |height: f64| scene.temperature().temperature(height);
        let mean_inverse = potential.heights().map(|height| 1.0 / temperature(height)).sum::<f64>()
            / potential.bins() as f64;
        // In a weightless box the contact density overreacts to a wrong pressure by this factor (`docs/physics.md`).
        let response = temperature(scene.open_end().contact_height(scene.slab())) * mean_inverse;
        let iteration = Iteration {
            open_end_pressure: prior.open_end_pressure,
            end_gain: 1.0 / response.max(1.0),
            prior,
            measured: MeasuredShare::NONE,
            steps: 0,
            average: ColumnAverage::new(&potential),
            configurations_in_force: 0,
            centers: Vec::new(),
            sweeps: 0,
            step: [0, Iteration::FIRST_STEP],
            adapting: false,
        };
        Ok((potential, iteration))
    }
}

impl Iteration {
    /// Sweeps of the first step.
    const FIRST_STEP: u64 = 64;
    /// A step is judged by at most so many heights of the center of mass.
    const MOST_CENTERS: u64 = 256;
    /// Successive configurations are alike, and to count them takes time.
    const SWEEPS_BETWEEN_LOOKS: u64 = 4;

    /// Steps made so far.
    #[must_use]
    pub fn steps(&self) -> u32 {
        self.steps
    }

    /// Whether the center of mass stood still within the errors of the step; false where it is too short to tell.
    fn at_rest(&self) -> bool {
        /// A drift of more standard errors than this is no accident.
        const LARGEST_DRIFT: f64 = 4.0;
        drift(&self.centers).is_ok_and(|drift| drift.deviation_from(0.0).abs() <= LARGEST_DRIFT)
    }

    /// Ends a step: if the column was at rest, the field becomes that of what was measured. Nothing changes on an error.
    fn update(&mut self, potential: &mut EffectivePotential, scene: &AnyScene<'_>) -> Result<(), Error> {
        if self.at_rest() {
            let contact = self.average.open_end_pressure(scene, &self.prior);
            let end = self.open_end_pressure + self.end_gain * (contact - self.open_end_pressure);
            let ratios = self.average.ratios(scene, potential.bin_width(), end, &self.prior);
            potential.set(end, |bin| ratios[bin])?;
            self.open_end_pressure = end;
            self.measured = self.average.measured_share(scene, potential.bin_width(), &self.prior);
            self.configurations_in_force = self.average.configurations();
        }
        self.steps += 1;
        self.clear();
        Ok(())
    }

    fn clear(&mut self) {
        self.average.clear();
        self.centers.clear();
    }
}

impl Observer for Iteration {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.adapting = frame.phase() == Phase::Equilibration;
        if self.adapting {
            let sweeps = self.sweeps + 1;
            let [begin, end] = self.step;
            let relaxed = 4 * (sweeps - begin) > end - begin;
            // As many centers of mass for a long step as for a short one.
            let interval = ((end - begin) / Self::MOST_CENTERS).max(1);
            // First what asks a field of a user's own.
            if relaxed && sweeps.is_multiple_of(Self::SWEEPS_BETWEEN_LOOKS) {
                self.average.add(frame);
            }
            if relaxed && sweeps.is_multiple_of(interval) {
                self.centers.push(frame.heights().sum::<f64>() / frame.particles() as f64);
            }
            self.sweeps = sweeps;
        }
        Ok(())
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
            // The field in force stays, and the next step begins.
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
        // A step that was hardly begun knows less than the one in force.
        if self.average.configurations() > 0
            && 2 * self.average.configurations() >= self.configurations_in_force
        {
            self.update(potential, scene)?;
        }
        // A later equilibration starts anew from the field that there is.
        self.clear();
        self.step = [self.sweeps, self.sweeps + self.step[0].max(Self::FIRST_STEP)];
        Ok(())
    }

    /// Before the first step at rest, none.
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
        count configurations_in_force,
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
