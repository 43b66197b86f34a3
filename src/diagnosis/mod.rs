//! What the notes of a run, its scene and the theory of it say against the run: one file for each kind of doubt.

use crate::drive::Drive;
use crate::monitor::Monitor;
use crate::{Scene, Warning};

/// All that is judged: notes of production, the scene and the drive.
#[derive(Clone, Copy)]
pub(crate) struct Case<'a, F, T, D> {
    pub(crate) scene: &'a Scene<F, T>,
    pub(crate) drive: &'a D,
    pub(crate) monitor: &'a Monitor,
    /// Whether a sweep has nothing but local moves.
    #[allow(dead_code, reason = "the judgement of the acceptance comes next")]
    pub(crate) only_local_moves: bool,
}

impl<F, T, D: Drive<F, T>> Case<'_, F, T, D> {
    /// Fewest sweeps of production from which anything is concluded.
    const FEWEST_SWEEPS: u64 = 128;

    pub(crate) fn warnings(&self) -> Vec<Warning> {
        let mut warnings = Vec::new();
        let sweeps = self.monitor.sweeps();
        if sweeps < Self::FEWEST_SWEEPS {
            warnings.push(Warning::TooShort { sweeps, needed: Self::FEWEST_SWEEPS });
        }
        let changes = self.drive.generation().saturating_sub(self.monitor.generation());
        if changes > 0 && sweeps > 0 {
            warnings.push(Warning::ChangesWhileMeasuring { changes });
        }
        warnings.extend(self.drive.warnings(self.scene));
        warnings
    }
}
