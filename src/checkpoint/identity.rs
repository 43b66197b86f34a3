//! Identity of a run, by which a snapshot of another run is refused.

use crate::drive::Drive;
use crate::moves::Moves;
use crate::{Error, Field, Scene, TemperatureProfile};
use std::fmt::Write as _;

/// Scene, initial potential, moves and seed of a run.
#[derive(Debug, Clone)]
pub(crate) struct Identity {
    pub(super) seed: u64,
    /// One line for each property, "name: value".
    pub(super) simulated: String,
}

impl Identity {
    pub(crate) fn new<F: Field, T: TemperatureProfile>(
        scene: &Scene<F, T>,
        drive: &impl Drive<F, T>,
        moves: &Moves,
        seed: u64,
    ) -> Self {
        /// Number of heights that are compared.
        const HEIGHTS: u32 = 37;
        let slab = scene.slab();
        let mut simulated = format!("slab: {slab:?}\nnumber of spheres: {}\n", scene.particles());
        for number in 0..=HEIGHTS {
            let part = f64::from(number) / f64::from(HEIGHTS);
            let height = slab.lowest_center() + part * (slab.highest_center() - slab.lowest_center());
            for (name, value) in [
                ("potential of the field", scene.field().potential(height)),
                ("temperature", scene.temperature().temperature(height)),
                ("reduced potential at the start", drive.reduced_potential(scene, height)),
            ] {
                // Printed in full, so that equal text means equal bits. Writing to a string cannot
                // fail.
                writeln!(simulated, "{name}: {value:?} at height {height:?}").ok();
            }
        }
        writeln!(simulated, "moves: {moves:?}").ok();
        Self { seed, simulated }
    }

    /// Fails with the first property that differs from the saved identity.
    pub(super) fn require_same(&self, saved: &str) -> Result<(), Error> {
        let lines = self.simulated.lines().zip(saved.lines());
        let Some((given, saved)) = lines.into_iter().find(|(given, saved)| given != saved) else {
            let same = self.simulated == saved;
            return if same {
                Ok(())
            } else {
                Err(Error::CheckpointDamaged { what: "identity of the run".into() })
            };
        };
        let (name, given) = given.split_once(": ").unwrap_or(("", given));
        let saved = saved.split_once(": ").map_or(saved, |(_, saved)| saved);
        Err(Error::CheckpointMismatch { what: name.into(), saved: saved.into(), given: given.into() })
    }

    /// Fails if the seed differs from the saved seed.
    pub(super) fn require_same_seed(&self, saved: u64) -> Result<(), Error> {
        if self.seed == saved {
            return Ok(());
        }
        let (saved, given) = (saved.to_string(), self.seed.to_string());
        Err(Error::CheckpointMismatch { what: "seed".into(), saved, given })
    }
}
