//! Families of moves.
//!
//! | family | balance | what it is for |
//! |---|---|---|
//! | [`LocalMoves`] | detailed | the paper's rule; any drive |
//! | [`LocalMoves::tuned`] | detailed | any scene, without a choice of S; the fastest where the base is not dense |
//! | [`EventChains`] | global | the fastest where the base is dense (with local moves in between); only drives that are fixed in production |
//!
//! The default of a simulation is [`Moves::default`]: chains with tuned local moves between them.
//! With the scheme of the paper ([`Instantaneous`](crate::drive::Instantaneous)) it is local moves
//! with S = 0.75.
//!
//! All families decide by the drive alone: by `reduced_potential` through
//! [`log_acceptance`](crate::drive::log_acceptance), or by its derivative `reduced_force`. A new
//! family is a folder here and a variant of [`Moves`].

mod event_chain;
mod local;

pub use event_chain::{EventChains, FieldEvent};
pub use local::{LocalMoves, TunedDisplacements};

use crate::configuration::Configuration;
use crate::drive::Drive;
use crate::frame::{MoveCounts, Phase};
use crate::observer::Recorder;
use crate::random::Generator;
use crate::{Error, Field, Scene, Slab, TemperatureProfile};

/// What the sweeps of a simulation consist of.
///
/// ```
/// use gradient_mc::moves::{EventChains, LocalMoves, Moves};
/// let chains = EventChains::default().local_moves(Some(LocalMoves::tuned()));
/// assert_eq!(Moves::default(), chains.into());
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Moves {
    /// Small displacements of single spheres.
    Local(LocalMoves),
    /// Event chains.
    EventChains(EventChains),
}

impl From<LocalMoves> for Moves {
    fn from(moves: LocalMoves) -> Self {
        Self::Local(moves)
    }
}

impl From<EventChains> for Moves {
    fn from(moves: EventChains) -> Self {
        Self::EventChains(moves)
    }
}

impl Default for Moves {
    /// Event chains with tuned local moves between them. Tuned local moves alone are up to twice as
    /// fast where the base is not dense, and hardly move the column where it is.
    fn default() -> Self {
        EventChains::default().local_moves(Some(LocalMoves::tuned())).into()
    }
}

impl Moves {
    /// The moves of a simulation: those that are named, or else the default of the scheme, whose
    /// steady state may depend on the moves.
    pub(crate) fn chosen(named: Option<Self>, steady_state_depends: bool) -> Result<Self, Error> {
        match named {
            None if steady_state_depends => Ok(LocalMoves::one(0.75).into()),
            None => Ok(Self::default()),
            Some(Self::EventChains(_)) if steady_state_depends => {
                Err(Error::UnsuitableMoves { moves: "event chains" })
            }
            Some(moves) => Ok(moves),
        }
    }

    /// Fails for moves that do not suit a slab.
    pub(crate) fn check(&self, slab: &Slab) -> Result<(), Error> {
        match self {
            Self::Local(moves) => moves.check(slab),
            Self::EventChains(chains) => chains.check(slab),
        }
    }
}

/// Everything that a sweep reads and changes.
pub(crate) struct Sweep<'a, F, T, D> {
    pub(crate) scene: &'a Scene<F, T>,
    pub(crate) drive: &'a D,
    pub(crate) configuration: &'a mut Configuration,
    pub(crate) generator: &'a mut Generator,
    pub(crate) move_counts: &'a mut MoveCounts,
    pub(crate) phase: Phase,
    pub(crate) recorder: Option<&'a mut dyn Recorder>,
}

/// A family of moves and its data between sweeps.
#[derive(Debug, Clone)]
pub(crate) enum Engine {
    Local(local::Engine),
    EventChains(event_chain::Engine),
}

impl Engine {
    pub(crate) fn new(moves: Moves) -> Self {
        match moves {
            Moves::Local(moves) => Self::Local(local::Engine::new(moves)),
            Moves::EventChains(chains) => Self::EventChains(event_chain::Engine::new(chains)),
        }
    }

    /// The local moves, alone or between chains.
    pub(crate) fn local(&self) -> Option<&local::Engine> {
        match self {
            Self::Local(moves) => Some(moves),
            Self::EventChains(chains) => chains.local.as_ref(),
        }
    }

    /// See [`Persist`](crate::checkpoint::Persist); `grid` is that of the configuration.
    #[cfg(feature = "checkpoint")]
    pub(crate) fn persist(
        &mut self,
        archive: &mut crate::checkpoint::Archive<'_>,
        grid: &crate::configuration::Grid,
    ) -> Result<(), Error> {
        match self {
            Self::Local(moves) => archive.within("local moves", |archive| moves.persist(archive, grid)),
            Self::EventChains(chains) => {
                archive.within("event chains", |archive| chains.persist(archive, grid))
            }
        }
    }

    /// Whether no event chains are among the moves.
    pub(crate) fn has_only_local_moves(&self) -> bool {
        matches!(self, Self::Local(_))
    }

    /// Makes one sweep. An error leaves the configuration valid.
    pub(crate) fn sweep<F: Field, T: TemperatureProfile, D: Drive<F, T>>(
        &mut self,
        mut sweep: Sweep<'_, F, T, D>,
    ) -> Result<(), Error> {
        match self {
            Self::Local(moves) => moves.sweep(&mut sweep),
            Self::EventChains(chains) => chains.sweep(&mut sweep),
        }
    }
}
