//! Straight event chains in a field that varies along one axis.

mod chain;
mod columns;
mod constraints;
mod cut;
mod engine;
mod enter;
mod force_bound;
mod length;
#[cfg(feature = "checkpoint")]
mod saved;
mod shadows;
mod stall_guard;
mod tiles;
mod visit;

use super::LocalMoves;
use crate::{Error, Slab};
pub(super) use engine::Engine;

/// How a chain continues after a field event.
///
/// ```
/// use gradient_mc::moves::{EventChains, FieldEvent};
/// assert_eq!(EventChains::default().field_event(FieldEvent::Relocate), EventChains::default());
/// assert_ne!(EventChains::default().field_event(FieldEvent::Reverse), EventChains::default());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum FieldEvent {
    /// Another sphere, drawn with probability proportional to |u'|, moves on downhill.
    ///
    /// This is the default. The chain does not retrace its path, so long chains move the column.
    #[default]
    Relocate,
    /// The same sphere moves on in the opposite direction. Correct but slow: the chain retraces its
    /// path.
    Reverse,
    /// A wrong rule that tests must detect: any sphere, without the weight |u'|.
    #[cfg(test)]
    Unweighted,
    /// A wrong rule that tests must detect: a sphere drawn as for `Relocate`, but sent uphill.
    #[cfg(test)]
    Uphill,
}

/// Straight event chains (Bernard, Krauth and Wilson, doi:10.1103/PhysRevE.80.056704; the field as
/// a factor of its own, Michel, Kapfer and Krauth, doi:10.1063/1.4863991).
///
/// A sphere moves along an axis until it touches another, which moves on in the same direction,
/// until the chain has used up its length. Nothing is ever rejected. Along x a sphere that goes
/// uphill in the reduced potential u is stopped by the field at the rate |u'| per distance; then
/// the chain continues as [`FieldEvent`] says. A wall reverses the chain. A sweep of [local
/// moves](Self::local_moves) follows the chains.
///
/// As long as all spheres move along one axis, the pairs that can touch do not change. They are
/// found once and serve all chains of a *visit*, with about eight events per sphere. So not every
/// sweep has chains, and [`path_per_sphere`](Self::path_per_sphere) holds on average over some tens
/// of sweeps. If the base is wide enough for several tiles of about 6000 spheres, chains run tile
/// by tile. During a visit the spheres in the strips between tiles are frozen, and reverse chains
/// as walls do (Kapfer and Krauth, doi:10.1088/1742-6596/454/1/012031). The result does not depend
/// on the number of threads that share the tiles.
///
/// Chains hold global balance, not detailed balance; the proof is in `docs/event_chains.md`.
///
/// ```
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, moves::EventChains};
/// use gradient_mc::{observers::CenterOfMass, temperature::Isothermal};
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 360, UniformField::default(), Isothermal::new(5.0)?)?;
/// let mut simulation = Simulation::builder(scene).moves(EventChains::default()).seed(1).build()?;
/// let mut center_of_mass = CenterOfMass::new();
/// simulation.equilibrate(100, &mut ())?;
/// simulation.run(400, &mut center_of_mass)?;
/// assert!(simulation.move_counts().events > 0);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EventChains {
    /// `None` if it is tuned.
    length: Option<f64>,
    vertical_fraction: f64,
    path_per_sphere: f64,
    field_event: FieldEvent,
    local_moves: Option<LocalMoves>,
}

impl Default for EventChains {
    /// Chains with a length that is tuned in equilibration and 90 % of their path vertical, and
    /// local moves of up to half a diameter.
    fn default() -> Self {
        Self {
            length: None,
            vertical_fraction: 0.9,
            path_per_sphere: Self::PATH_PER_SPHERE,
            field_event: FieldEvent::Relocate,
            local_moves: Some(LocalMoves::one(0.5)),
        }
    }
}

impl EventChains {
    /// Default of [`path_per_sphere`](Self::path_per_sphere), in diameters.
    pub const PATH_PER_SPHERE: f64 = 0.5;
    /// Largest mean number of collisions and field events of a sweep, per sphere, at the rate of
    /// vertical chains. In equilibration the path of the chains is shortened to keep below it, so
    /// that a sweep takes a bounded time in any field.
    pub const MOST_EVENTS: f64 = 100.0;
    /// Smallest mean length of a chain, in diameters.
    pub const MINIMUM_LENGTH: f64 = 1e-3;
    /// Largest mean length of a chain, in diameters.
    pub const MAXIMUM_LENGTH: f64 = 1e6;

    /// Chains of a fixed mean length, in diameters. Single lengths are uniform between zero and
    /// twice the mean, so that none is commensurate with the box. The mean length of lateral chains
    /// is at most the width of the slab.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] below [`MINIMUM_LENGTH`](Self::MINIMUM_LENGTH), where a sweep
    /// would need too many chains, or above [`MAXIMUM_LENGTH`](Self::MAXIMUM_LENGTH).
    pub fn with_length(length: f64) -> Result<Self, Error> {
        if (Self::MINIMUM_LENGTH..=Self::MAXIMUM_LENGTH).contains(&length) {
            Ok(Self { length: Some(length), ..Self::default() })
        } else {
            let requirement = "it must be at least 1e-3 and at most 1e6 diameters";
            Err(Error::InvalidParameter { name: "mean length of event chains", value: length, requirement })
        }
    }

    /// Share of the path of all chains that runs along x; the rest runs along y and z, in equal
    /// numbers of chains.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] unless it lies between 0 and 1, both excluded: without both
    /// kinds not every configuration can be reached.
    pub fn vertical_fraction(self, fraction: f64) -> Result<Self, Error> {
        if fraction > 0.0 && fraction < 1.0 {
            Ok(Self { vertical_fraction: fraction, ..self })
        } else {
            let requirement = "it must lie between 0 and 1, both excluded";
            Err(Error::InvalidParameter {
                name: "vertical fraction of event chains",
                value: fraction,
                requirement,
            })
        }
    }

    /// Path of all chains of a sweep, in diameters per sphere, on average over sweeps.
    /// [`MOST_EVENTS`](Self::MOST_EVENTS) may limit it. With a shorter path, local moves take a
    /// larger share of the time.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] below 1e-3 or above 1e3.
    pub fn path_per_sphere(self, path: f64) -> Result<Self, Error> {
        if (1e-3..=1e3).contains(&path) {
            Ok(Self { path_per_sphere: path, ..self })
        } else {
            let requirement = "it must be at least 1e-3 and at most 1e3 diameters";
            Err(Error::InvalidParameter { name: "path of event chains per sphere", value: path, requirement })
        }
    }

    /// How a chain continues after a field event.
    #[must_use]
    pub fn field_event(self, field_event: FieldEvent) -> Self {
        Self { field_event, ..self }
    }

    /// Sets the local moves that follow the chains in each sweep (S = 0.5 by default), or none.
    ///
    /// Chains move the column as a whole, local moves single spheres. Compared with chains alone,
    /// both together reach a given error of n(x) two to three times as fast in every bin, and a
    /// given error of the center of mass half as fast.
    #[must_use]
    pub fn local_moves(self, local_moves: Option<LocalMoves>) -> Self {
        Self { local_moves, ..self }
    }

    /// Fails if there are local moves too large for `slab`.
    pub(crate) fn check(&self, slab: &Slab) -> Result<(), Error> {
        self.local_moves.map_or(Ok(()), |moves| moves.check(slab))
    }

    /// Mean length of a chain in diameters, unless it is tuned.
    #[must_use]
    pub fn length(&self) -> Option<f64> {
        self.length
    }
}

#[cfg(test)]
mod tests;
