//! Warnings about a run, from its records, its scene and the theory of the scene. Each file makes
//! one kind of warning, independently of the others.

mod acceptance;
mod expectation;
mod feedback;
mod freezing;
mod hexagonal;
mod mixing;
mod narrow;

use crate::drive::{Adaptation, Drive, ForceBalance};
use crate::monitor::Monitor;
use crate::moves::Engine;
use crate::{Error, Field, Scene, TemperatureProfile, Warning};
use expectation::Expectation;
pub(crate) use freezing::LEAST_LAYER;
use mixing::Mixing;
pub(crate) use mixing::slowest;

/// The input of all checks: records of production, the scene and its drive.
#[derive(Clone, Copy)]
pub(crate) struct Case<'a, F, T, D, A> {
    pub(crate) scene: &'a Scene<F, T>,
    pub(crate) drive: &'a D,
    pub(crate) adaptation: &'a A,
    pub(crate) monitor: &'a Monitor,
    /// Present if the temperature varies.
    pub(crate) balance: Option<&'a ForceBalance>,
    /// The moves.
    pub(crate) engine: &'a Engine,
}

impl<F: Field, T: TemperatureProfile, D: Drive<F, T>, A: Adaptation<D>> Case<'_, F, T, D, A> {
    /// Smallest number of sweeps of production that is judged; half of it gives sixteen numbers of
    /// the series.
    const FEWEST_SWEEPS: u64 = 32 * Monitor::FIRST_INTERVAL;

    pub(crate) fn warnings(&self) -> Vec<Warning> {
        let Self { scene, drive, monitor, .. } = *self;
        let sweeps = monitor.sweeps();
        let changes = drive.generation().saturating_sub(monitor.generation());
        let mut warnings = self.adaptation.warnings(drive, &scene.as_any());
        warnings.extend(self.balance.and_then(|balance| feedback::warning(balance, sweeps)));
        let theory = match Expectation::new(scene) {
            Ok(theory) => Some(theory),
            Err(error) => {
                let height = match error {
                    Error::EquationOfStateExhausted { height, .. }
                    | Error::HydrostaticsNotConverged { height, .. } => height,
                    _ => f64::NAN,
                };
                warnings.push(Warning::NoTheory { height });
                None
            }
        };
        if let Some(theory) = &theory {
            warnings.extend(theory.of_the_scene(scene));
            warnings.extend(narrow::warning(scene, theory.profile()));
        }
        if sweeps < Self::FEWEST_SWEEPS {
            warnings.push(Warning::TooShort { sweeps, needed: Self::FEWEST_SWEEPS });
        } else {
            if changes > 0 {
                warnings.push(Warning::ChangesWhileMeasuring { changes });
            }
            // The equilibrium variance holds only in a constant field.
            let required_variance = theory.as_ref().filter(|_| changes == 0).map(Expectation::variance);
            let mixing = Mixing::new(monitor, required_variance);
            warnings.extend(mixing.warnings(sweeps));
            if let Some(theory) = &theory {
                warnings.extend(theory.far_from(mixing.center_of_mass()));
            }
            if self.engine.has_only_local_moves() {
                let tuned = self.engine.local().is_some_and(|moves| moves.tuning().is_some());
                warnings.extend(acceptance::low(monitor, tuned));
            }
        }
        warnings.extend(freezing::warnings(scene, monitor, theory.as_ref().map(Expectation::profile)));
        keep_longest(&mut warnings);
        warnings
    }
}

/// Keeps one of several [`Warning::TooShort`]: that which needs the most sweeps.
fn keep_longest(warnings: &mut Vec<Warning>) {
    let demand = |warning: &Warning| match warning {
        Warning::TooShort { needed, .. } => Some(*needed),
        _ => None,
    };
    let longest = warnings.iter().filter_map(demand).max();
    let mut kept = false;
    warnings.retain(|warning| match demand(warning) {
        None => true,
        needed => needed == longest && !std::mem::replace(&mut kept, true),
    });
}
