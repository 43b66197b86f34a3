//! What whoever looks at a run is shown after a sweep.

use crate::centers::Centers;
use crate::scene::AnyScene;
use crate::{Field, Slab, TemperatureProfile};
use nalgebra::Vector3;
use std::fmt;

/// What part of a run a sweep belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Phase {
    /// Before the measurement: a drive may adapt.
    Equilibration,
    /// The measurement.
    Production,
}

/// The reduced potential in force, whatever the types of scene and drive.
pub(crate) trait InForce: Sync {
    fn reduced_potential(&self, height: f64) -> f64;
    fn reduced_force(&self, height: f64) -> f64;
    fn generation(&self) -> u64;
    fn open_end_pressure(&self) -> f64;
}

/// No potential, changed so many times: for tests of what does not look at it.
#[cfg(test)]
pub(crate) struct Still(pub(crate) u64);

#[cfg(test)]
impl InForce for Still {
    fn reduced_potential(&self, _: f64) -> f64 {
        0.0
    }
    fn reduced_force(&self, _: f64) -> f64 {
        0.0
    }
    fn generation(&self) -> u64 {
        self.0
    }
    fn open_end_pressure(&self) -> f64 {
        0.0
    }
}

/// A configuration as an observer sees it, after a whole number of sweeps.
#[derive(Clone, Copy)]
pub struct Frame<'a> {
    pub(crate) scene: AnyScene<'a>,
    pub(crate) potential: &'a dyn InForce,
    pub(crate) centers: Centers<'a>,
    pub(crate) sweep: u64,
    pub(crate) phase: Phase,
    pub(crate) sweep_of_phase: u64,
    pub(crate) move_counts: &'a MoveCounts,
}

impl fmt::Debug for Frame<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Frame")
            .field("slab", self.slab())
            .field("particles", &self.particles())
            .field("sweep", &self.sweep)
            .field("phase", &self.phase)
            .finish_non_exhaustive()
    }
}

impl<'a> Frame<'a> {
    /// What is simulated.
    #[must_use]
    pub fn scene(&self) -> &AnyScene<'a> {
        &self.scene
    }

    /// The slab.
    #[must_use]
    pub fn slab(&self) -> &Slab {
        self.scene.slab()
    }

    /// The external field of the scene.
    #[must_use]
    pub fn field(&self) -> &'a dyn Field {
        *self.scene.field()
    }

    /// The temperature profile of the scene.
    #[must_use]
    pub fn temperature(&self) -> &'a dyn TemperatureProfile {
        *self.scene.temperature()
    }

    /// Number of spheres.
    #[must_use]
    pub fn particles(&self) -> usize {
        self.centers.count()
    }

    /// Centers of the spheres in diameters, x up, y and z inside the periodic widths. A sphere
    /// keeps its place in this order for the whole run.
    #[must_use]
    pub fn positions(&self) -> impl ExactSizeIterator<Item = Vector3<f64>> + Clone + 'a {
        self.centers.positions().iter().map(|&[x, y, z]| Vector3::new(x, y, z))
    }

    /// Heights of the centers, in the order of [`positions`](Self::positions).
    #[must_use]
    pub fn heights(&self) -> impl ExactSizeIterator<Item = f64> + Clone + 'a {
        self.centers.positions().iter().map(|position| position[0])
    }

    /// Calls `visit` with the height of each sphere, in an order that means nothing.
    ///
    /// Moves keep spheres sorted by place. The first who asks for [`positions`](Self::positions) or
    /// [`heights`](Self::heights) after a sweep has them put in order of number; this does without.
    pub fn for_each_height(&self, visit: impl FnMut(f64)) {
        self.centers.for_each_height(visit);
    }

    /// The reduced potential u = U/T in which the sweep was made, at `height`. Only differences
    /// matter.
    #[must_use]
    pub fn reduced_potential(&self, height: f64) -> f64 {
        self.potential.reduced_potential(height)
    }

    /// u' in inverse diameters, at `height`.
    #[must_use]
    pub fn reduced_force(&self, height: f64) -> f64 {
        self.potential.reduced_force(height)
    }

    /// Number of times that u has changed so far.
    #[must_use]
    pub fn generation(&self) -> u64 {
        self.potential.generation()
    }

    /// Pressure on the wall at the [open end](crate::Scene::open_end), in m g/d², that u assumes.
    #[must_use]
    pub fn open_end_pressure(&self) -> f64 {
        self.potential.open_end_pressure()
    }

    /// Sweeps since the simulation was built, equilibration included.
    #[must_use]
    pub fn sweep(&self) -> u64 {
        self.sweep
    }

    /// The part of the run that the sweep belongs to.
    #[must_use]
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Sweeps since that part began: 1 after its first.
    #[must_use]
    pub fn sweep_of_phase(&self) -> u64 {
        self.sweep_of_phase
    }

    /// Trials and acceptances since the simulation was built.
    #[must_use]
    pub fn move_counts(&self) -> &'a MoveCounts {
        self.move_counts
    }
}

/// Counts of moves and what became of them, since the simulation was built.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct MoveCounts {
    /// Local moves tried.
    pub trials: u64,
    /// Local moves accepted.
    pub accepted: u64,
    /// Local moves rejected because they would leave the domain in which a sweep moves their sphere
    /// ([`LocalMoves`](crate::moves::LocalMoves)): none in a small system.
    pub left_domain: u64,
    /// Event chains run to their full length.
    pub chains: u64,
    /// Events that ended a straight piece of an event chain: a collision, a wall, or the field.
    pub events: u64,
    /// Sweeps that ended with an error before all of their moves were made. What they made is
    /// counted above.
    pub incomplete_sweeps: u64,
}

impl MoveCounts {
    /// Fraction of trial moves that were accepted; NaN before the first.
    #[must_use]
    pub fn acceptance(&self) -> f64 {
        self.accepted as f64 / self.trials as f64
    }

    /// Displacements of single spheres: accepted moves, and straight pieces of event chains.
    #[must_use]
    pub fn displacements(&self) -> u64 {
        self.accepted + self.events + self.chains
    }

    /// What was counted since an earlier one of the same run; zero if it is not earlier.
    #[must_use]
    pub fn since(&self, earlier: &Self) -> Self {
        Self {
            trials: self.trials.saturating_sub(earlier.trials),
            accepted: self.accepted.saturating_sub(earlier.accepted),
            left_domain: self.left_domain.saturating_sub(earlier.left_domain),
            chains: self.chains.saturating_sub(earlier.chains),
            events: self.events.saturating_sub(earlier.events),
            incomplete_sweeps: self.incomplete_sweeps.saturating_sub(earlier.incomplete_sweeps),
        }
    }
}

persist!(MoveCounts {
    count trials,
    count accepted,
    count left_domain,
    count chains,
    count events,
    count incomplete_sweeps,
});
