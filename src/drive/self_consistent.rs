//! The effective field iterated while equilibrating, then frozen for production.

use super::column_average::{ColumnAverage, Prior};
use super::effective_potential::bin_width_of;
use super::{Adaptation, EffectivePotential, Scheme};
use crate::equation_of_state::{EquationOfState, FluidSolid, packing_fraction};
use crate::frame::{Frame, Phase};
use crate::observer::{Observer, ObserverError};
use crate::scene::AnyScene;
use crate::{Error, Field, Scene, TemperatureProfile};

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
/// - While the column is still far from mechanical balance, the theory's field takes the place of the measured
///   one: a column that falls or rises would otherwise be held where it is by the field that its own
///   weight makes. Balance is judged by ∫P dx from the weights against ∫nTZ dx, to 10 %.
/// - The theory profile, which knows the column above the layers to 0.2 % ([`Hydrostatics::between_walls`](crate::Hydrostatics::between_walls)), stands in with
///   the [weight](Self::theory_weight) of 10⁵ counted spheres per diameter of height: as many as have to be counted to
///   know the density as well, since what a whole column does together is forgotten slowly. So a short
///   equilibration gives the field of the closure, a long one what was measured, and no bin is ever empty. In the layers
///   within four diameters of a wall, of which the theory knows nothing, it stands for 3 % of that.
/// - The pressure on the lid is the contact density there times T, together with that of the theory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SelfConsistent {
    bin_width: f64,
    theory_weight: f64,
}

impl Default for SelfConsistent {
    /// Bins of 0.1 diameters, and a theory that stands for 10⁵ spheres per diameter.
    fn default() -> Self {
        Self { bin_width: 0.1, theory_weight: 1e5 }
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
}

/// Of [`SelfConsistent`]: P/n of the last step of the iteration.
#[derive(Debug, Clone)]
pub struct Iteration {
    prior: Prior,
    lid_pressure: f64,
    /// Of what the contact density says, the part by which the pressure on the lid follows it in a step.
    lid_gain: f64,
    follows_measurement: bool,
    steps: u32,
    /// What the step under way has measured, and how much the one before had.
    average: ColumnAverage,
    configurations_before: u64,
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
        potential.set(prior.lid_pressure, |bin| prior.ratios[bin])?;
        let temperature = |height: f64| scene.temperature().temperature(height);
        let mean_inverse = potential.heights().map(|height| 1.0 / temperature(height)).sum::<f64>()
            / potential.bins() as f64;
        // In a weightless box the contact density overreacts to a wrong pressure by this factor (`docs/physics.md`).
        let response = temperature(scene.slab().highest_center()) * mean_inverse;
        let iteration = Iteration {
            lid_pressure: prior.lid_pressure,
            lid_gain: 1.0 / response.max(1.0),
            prior,
            follows_measurement: false,
            steps: 0,
            average: ColumnAverage::new(&potential),
            configurations_before: 0,
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
    /// Successive configurations are alike, and to count them takes time.
    const SWEEPS_BETWEEN_LOOKS: u64 = 4;

    /// Steps made so far.
    #[must_use]
    pub fn steps(&self) -> u32 {
        self.steps
    }

    /// Whether the field in force was measured; until the column is near balance, it is the theory's.
    #[must_use]
    pub fn follows_measurement(&self) -> bool {
        self.follows_measurement
    }

    /// Whether the weights and the equation of state agree on ∫P dx to 10 %.
    fn near_balance(&self, scene: &AnyScene<'_>, width: f64, rows: &[[f64; 2]]) -> bool {
        const TOLERANCE: f64 = 0.1;
        /// Densities are smoothed over this many diameters, more than a layer at the wall.
        const SMOOTHING: f64 = 2.0;
        /// Above this no equation of state makes sense, and the column is surely not balanced.
        const DENSEST: f64 = 0.72;
        let equation_of_state = FluidSolid::default();
        // At least one bin, at most all.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let group = ((SMOOTHING / width).ceil() as usize).clamp(1, rows.len());
        let volume = scene.slab().base_area() * width * self.average.configurations() as f64;
        let (mut weights, mut theory) = (0.0, 0.0);
        for (index, rows) in rows.chunks(group).enumerate() {
            let count: f64 = rows.iter().map(|row| row[0]).sum();
            let eta = packing_fraction(count / (volume * rows.len() as f64)).min(DENSEST);
            let height = (index * group) as f64 * width + 0.5 * width * rows.len() as f64;
            let temperature = scene.temperature().temperature(height);
            theory += count * temperature * equation_of_state.compressibility_factor(eta);
            weights += rows.iter().map(|row| row[1]).sum::<f64>();
        }
        (weights / theory - 1.0).abs() < TOLERANCE
    }

    /// Ends a step: the field becomes that of what it measured.
    fn update(&mut self, potential: &mut EffectivePotential, scene: &AnyScene<'_>) -> Result<(), Error> {
        let contact = self.average.lid_pressure(scene, &self.prior);
        let lid = self.lid_pressure + self.lid_gain * (contact - self.lid_pressure);
        let width = potential.bin_width();
        let rows = self.average.counts_and_pressures(width, scene.slab().base_area(), lid);
        self.follows_measurement = self.near_balance(scene, width, &rows);
        if self.follows_measurement {
            self.lid_pressure = lid;
            let ratios = self.average.ratios(scene, width, lid, &self.prior);
            potential.set(lid, |bin| ratios[bin])?;
        } else {
            self.lid_pressure = self.prior.lid_pressure;
            potential.set(self.lid_pressure, |bin| self.prior.ratios[bin])?;
        }
        self.steps += 1;
        self.configurations_before = self.average.configurations();
        self.average.clear();
        Ok(())
    }
}

impl Observer for Iteration {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.adapting = frame.phase() == Phase::Equilibration;
        if self.adapting {
            self.sweeps += 1;
            let [begin, end] = self.step;
            let relaxed = 4 * (self.sweeps - begin) > end - begin;
            if relaxed && self.sweeps.is_multiple_of(Self::SWEEPS_BETWEEN_LOOKS) {
                self.average.add(frame);
            }
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
        self.step = [end, 2 * end];
        self.update(potential, scene)
    }

    fn start_production(
        &mut self,
        potential: &mut EffectivePotential,
        scene: &AnyScene<'_>,
    ) -> Result<(), Error> {
        // A step that was hardly begun knows less than the one before.
        if self.average.configurations() > 0
            && 2 * self.average.configurations() >= self.configurations_before
        {
            self.update(potential, scene)?;
        }
        // A later equilibration starts anew from the field that there is.
        self.average.clear();
        self.step = [self.sweeps, self.sweeps + self.step[0].max(Self::FIRST_STEP)];
        Ok(())
    }
}
