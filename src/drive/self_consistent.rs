//! The effective field iterated while equilibrating, then frozen for production.

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

/// The effective field by iteration: freeze, measure, update, every time twice as long as before;
/// frozen for good when production starts. The default choice for temperatures that vary.
///
/// Production holds detailed balance exactly, in the field that was frozen, and
/// [`Simulation::certificate`](crate::Simulation::certificate) tells, without an equation of state,
/// whether it was the right one.
///
/// **The bulk by collisions.** The field needs P/n = T Z (eq. 20 of
/// doi:10.1103/PhysRevE.83.061306). Where event chains pass, their collisions give Z(η) in any
/// field, right or wrong, even while the column falls, since they need local equilibrium only.
/// After every step two coefficients of Z = 1 + (c₁ η + c₂ η²)/(1 − η)³ are fitted to what was
/// measured, the last step counting twice as much as the one before, and hydrostatics between walls
/// ([`Hydrostatics::between_walls`](crate::Hydrostatics::between_walls)) with this Z gives a smooth
/// P/n. So noise enters through two numbers and not through the bins of a histogram, and whatever
/// equation of state the iteration [started](Self::new) with is gone after a few steps.
///
/// **The layers by counts.** What a local equation of state does not know, P/n by weight and
/// numbers does, step by step:
/// - Within a step the field does not change, so the column relaxes as any isothermal one; the
///   first quarter of each step is left out.
/// - Counts and weights are averaged, never ratios of single configurations, so there is no noise
///   bias of order 1/(spheres per bin and sweep).
/// - The closure counts as much as 10⁴ spheres per diameter of height
///   ([`closure_weight`](Self::closure_weight)), and in the layers within four diameters of a wall
///   as 3 % of that. So the field goes over to the counts as the steps get longer, soon at the
///   walls, and no bin is ever empty. `docs/physics.md` has the measurement by which the weight was
///   chosen.
/// - A step in which the column fell or rose is not counted: a field made of it would hold the
///   column where it is, by its own weight. It is at rest if its center of mass in the second half
///   of a step is where it was in the first, within four standard errors.
/// - The pressure on the wall at the [open end](Scene::open_end) is the contact density there times
///   T, together with that of the closure, which has ten times the weight there: in a closed box
///   10⁴ sweeps of 500 spheres know a contact density to some 4 %.
///
/// Local moves alone have no collisions: then the closure stays that of the equation of state at
/// the start. [`measured_share`](super::Adaptation::measured_share), certificates and warnings say
/// how much was measured. The same goes for crystals, of which Z is Speedy's, once the fluid was
/// measured.
///
/// ```
/// use gradient_mc::drive::{Adaptation, SelfConsistent};
/// use gradient_mc::equation_of_state::IdealGas;
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::ExponentialTemperature};
/// let temperature = ExponentialTemperature::new(5.0, 0.02)?;
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 360, UniformField::default(), temperature)?;
/// // Z = 1 to start with: nothing is known.
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
    /// A start at the field of the most accurate equation of state here.
    fn default() -> Self {
        Self::new(FluidSolid::default())
    }
}

impl<E> SelfConsistent<E> {
    /// A start at the field of an equation of state, bins of 0.1 diameters, and a closure that
    /// counts as much as 10⁴ spheres per diameter.
    pub fn new(equation_of_state: E) -> Self {
        Self { equation_of_state, bin_width: 0.1, closure_weight: 1e4 }
    }

    /// Bins of the given width, in diameters.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] unless positive and finite.
    pub fn bin_width(self, bin_width: f64) -> Result<Self, Error> {
        Ok(Self { bin_width: bin_width_of(bin_width)?, ..self })
    }

    /// How many counted spheres per diameter of height the closure stands for; see the type.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] unless positive and finite.
    pub fn closure_weight(self, spheres_per_diameter: f64) -> Result<Self, Error> {
        let closure_weight = Error::require_positive("weight of the closure", spheres_per_diameter)?;
        Ok(Self { closure_weight, ..self })
    }
}

/// Of [`SelfConsistent`]: P/n of the last step of the iteration.
#[derive(Debug, Clone)]
pub struct Iteration {
    prior: Prior,
    own: Option<OwnEquation>,
    open_end_pressure: f64,
    /// Of what the contact density says, the part by which the pressure at the open end follows it
    /// in a step.
    end_gain: f64,
    measured: MeasuredShare,
    steps: u32,
    /// What the step under way has measured.
    average: ColumnAverage,
    /// The last step in which the column was at rest.
    at_rest: ColumnAverage,
    /// Heights of the center of mass in the step under way.
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
        // In a weightless box the contact density overreacts to a wrong pressure by this factor
        // (`docs/physics.md`).
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
    /// A step is judged by at most so many heights of the center of mass.
    const MOST_CENTERS: u64 = 256;
    /// Successive configurations are alike, and to count them takes time.
    const SWEEPS_BETWEEN_LOOKS: u64 = 4;
    /// For the packing fractions that collisions are compared at.
    const SWEEPS_BETWEEN_COUNTS: u64 = 2;

    /// Steps made so far.
    #[must_use]
    pub fn steps(&self) -> u32 {
        self.steps
    }

    /// Whether the center of mass stood still within the errors of the step; false where it is too
    /// short to tell.
    fn stood_still(&self) -> bool {
        /// A drift of more standard errors than this is no accident.
        const LARGEST_DRIFT: f64 = 4.0;
        drift(&self.centers).is_ok_and(|drift| drift.deviation_from(0.0).abs() <= LARGEST_DRIFT)
    }

    /// Ends a step: the closure becomes that by the equation of state that was measured, and if the
    /// column was at rest, the field goes over to what was counted. Nothing changes on an
    /// error.
    fn update(&mut self, potential: &mut EffectivePotential, scene: &AnyScene<'_>) -> Result<(), Error> {
        let at_rest = self.stood_still();
        let Self { own, prior, .. } = self;
        // An equation of state that finds no profile has too many terms for what was measured.
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

    /// Whether collisions of this sweep count: wherever there is local equilibrium, as soon as the
    /// start is forgotten.
    fn listens(&self, sweep: u64) -> bool {
        self.steps > 0 || self.is_relaxed(sweep)
    }

    /// Whether so many sweeps are beyond the first quarter of the step under way.
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
            // As many centers of mass for a long step as for a short one.
            let interval = ((end - begin) / Self::MOST_CENTERS).max(1);
            // First what asks a field of a user's own.
            if relaxed && sweeps.is_multiple_of(Self::SWEEPS_BETWEEN_LOOKS) {
                self.average.add(frame);
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

    /// Collisions, while equilibrating.
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
            && 2 * self.average.configurations() >= self.at_rest.configurations()
        {
            self.update(potential, scene)?;
        }
        self.adapting = false;
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
