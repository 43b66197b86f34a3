//! The frame: the state of a run that observers get after a sweep.

use crate::centers::Centers;
use crate::scene::AnyScene;
use crate::{Field, Slab, TemperatureProfile};
use nalgebra::Vector3;
use std::fmt;

/// The phase of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Phase {
    /// Before production: the scheme may change the effective field.
    Equilibration,
    /// The measurement; with the default scheme the effective field is constant.
    Production,
}

/// The current reduced potential, independent of the types of scene and drive.
pub(crate) trait InForce: Sync {
    fn reduced_potential(&self, height: f64) -> f64;
    fn reduced_force(&self, height: f64) -> f64;
    fn generation(&self) -> u64;
    fn open_end_pressure(&self) -> f64;
}

/// No potential, with a given generation; for tests that do not depend on it.
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

/// A configuration after a complete sweep, with the data of the run that observers need.
///
/// ```
/// use gradient_mc::{Phase, Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 36, UniformField::default(), Isothermal::new(5.0)?)?;
/// let mut simulation = Simulation::builder(scene).build()?;
/// simulation.equilibrate(10, &mut ())?;
/// simulation.run(5, &mut ())?;
/// let frame = simulation.frame();
/// assert_eq!((frame.sweep(), frame.phase(), frame.sweep_of_phase()), (15, Phase::Production, 5));
/// let lowest = frame.heights().fold(f64::INFINITY, f64::min);
/// assert!((0.5..60.0).contains(&lowest));
/// // In an isothermal column u = φ/T.
/// assert!((frame.reduced_force(3.0) - 1.0 / 5.0).abs() < 1e-12);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
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
    /// The scene that is simulated.
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

    /// Centers of the spheres in diameters: x is the height, y and z are inside the periodic
    /// widths. The order of the spheres is the same during the whole run.
    #[must_use]
    pub fn positions(&self) -> impl ExactSizeIterator<Item = Vector3<f64>> + Clone + 'a {
        self.centers.positions().iter().map(|&[x, y, z]| Vector3::new(x, y, z))
    }

    /// Heights of the centers, in diameters, in the order of [`positions`](Self::positions).
    #[must_use]
    pub fn heights(&self) -> impl ExactSizeIterator<Item = f64> + Clone + 'a {
        self.centers.positions().iter().map(|position| position[0])
    }

    /// Calls `visit` with the height of each sphere, in arbitrary order.
    ///
    /// This is faster than [`heights`](Self::heights): moves keep the spheres sorted by position,
    /// and the first call of [`positions`](Self::positions) or [`heights`](Self::heights) after a
    /// sweep sorts them by number.
    pub fn for_each_height(&self, visit: impl FnMut(f64)) {
        self.centers.for_each_height(visit);
    }

    /// The reduced potential u = U/T of this sweep at `height`, up to a constant.
    #[must_use]
    pub fn reduced_potential(&self, height: f64) -> f64 {
        self.potential.reduced_potential(height)
    }

    /// The reduced force u' = du/dx at `height`, in inverse diameters.
    #[must_use]
    pub fn reduced_force(&self, height: f64) -> f64 {
        self.potential.reduced_force(height)
    }

    /// Number of changes of u so far.
    #[must_use]
    pub fn generation(&self) -> u64 {
        self.potential.generation()
    }

    /// Pressure on the wall at the [open end](crate::Scene::open_end), in m g/d², that u assumes.
    #[must_use]
    pub fn open_end_pressure(&self) -> f64 {
        self.potential.open_end_pressure()
    }

    /// Number of sweeps since the simulation was built, equilibration included.
    #[must_use]
    pub fn sweep(&self) -> u64 {
        self.sweep
    }

    /// The phase of the run.
    #[must_use]
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// Number of sweeps since this phase began: 1 after its first sweep.
    #[must_use]
    pub fn sweep_of_phase(&self) -> u64 {
        self.sweep_of_phase
    }

    /// Counts of the moves tried and accepted since the simulation was built.
    #[must_use]
    pub fn move_counts(&self) -> &'a MoveCounts {
        self.move_counts
    }
}

/// Counts of moves tried and accepted since the simulation was built.
///
/// ```
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, moves::LocalMoves, temperature::Isothermal};
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 36, UniformField::default(), Isothermal::new(5.0)?)?;
/// let mut simulation = Simulation::builder(scene).moves(LocalMoves::new(0.5)?).build()?;
/// simulation.run(10, &mut ())?;
/// let counts = simulation.move_counts();
/// assert_eq!((counts.trials, counts.chains), (360, 0));
/// println!("{:.0} % accepted", 100.0 * counts.acceptance());
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct MoveCounts {
    /// Local moves tried.
    pub trials: u64,
    /// Local moves accepted.
    pub accepted: u64,
    /// Local moves rejected because they leave the domain in which a sweep moves the sphere
    /// ([`LocalMoves`](crate::moves::LocalMoves)); 0 in a small system.
    pub left_domain: u64,
    /// Event chains completed.
    pub chains: u64,
    /// Events of event chains: collisions, walls and field events. Each ends a straight piece of a
    /// chain.
    pub events: u64,
    /// Sweeps that an error ended before all of their moves were made. The moves they made are
    /// counted above.
    pub incomplete_sweeps: u64,
}

impl MoveCounts {
    /// Acceptance: the fraction of trial moves that were accepted; NaN before the first trial.
    #[must_use]
    pub fn acceptance(&self) -> f64 {
        self.accepted as f64 / self.trials as f64
    }

    /// Number of displacements of single spheres: accepted moves and straight pieces of event
    /// chains.
    #[must_use]
    pub fn displacements(&self) -> u64 {
        self.accepted + self.events + self.chains
    }

    /// The counts since `earlier`, a value of the same run; 0 where `earlier` is larger.
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
