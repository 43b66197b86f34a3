//! Observers: whatever looks at a simulation while it runs.
//!
//! To add one, implement [`Observer`] for a type of your own (one method) and pass it by mutable
//! reference to [`Simulation::run`](crate::Simulation::run); results are read from it afterwards.

use crate::{Centers, Field, Slab, TemperatureProfile};
use nalgebra::Vector3;

/// What an observer's failure may be: any error type of its own, boxed by `?`.
pub type ObserverError = Box<dyn std::error::Error + Send + Sync>;

/// A configuration as an observer sees it, after a whole number of sweeps.
#[derive(Clone, Copy)]
pub struct Frame<'a> {
    pub(crate) slab: &'a Slab,
    pub(crate) field: &'a dyn Field,
    pub(crate) temperature: &'a dyn TemperatureProfile,
    pub(crate) centers: Centers<'a>,
    pub(crate) sweep: u64,
    pub(crate) move_counts: &'a MoveCounts,
}

impl std::fmt::Debug for Frame<'_> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter
            .debug_struct("Frame")
            .field("slab", self.slab)
            .field("particles", &self.centers.count())
            .field("sweep", &self.sweep)
            .finish_non_exhaustive()
    }
}

impl<'a> Frame<'a> {
    /// The slab.
    #[must_use]
    pub fn slab(&self) -> &'a Slab {
        self.slab
    }

    /// The external field of the scene.
    #[must_use]
    pub fn field(&self) -> &'a dyn Field {
        self.field
    }

    /// The temperature profile of the scene.
    #[must_use]
    pub fn temperature(&self) -> &'a dyn TemperatureProfile {
        self.temperature
    }

    /// Number of spheres.
    #[must_use]
    pub fn particles(&self) -> usize {
        self.centers.count()
    }

    /// Centers of the spheres in diameters, x up, y and z inside the periodic widths. A sphere keeps
    /// its place in this order for the whole run.
    #[must_use]
    pub fn positions(&self) -> impl ExactSizeIterator<Item = Vector3<f64>> + Clone + 'a {
        self.centers.positions().iter().map(|&[x, y, z]| Vector3::new(x, y, z))
    }

    /// Heights of the centers, in the order of [`positions`](Self::positions).
    #[must_use]
    pub fn heights(&self) -> impl ExactSizeIterator<Item = f64> + Clone + 'a {
        self.centers.positions().iter().map(|position| position[0])
    }

    /// Sweeps since the simulation was built, equilibration included.
    #[must_use]
    pub fn sweep(&self) -> u64 {
        self.sweep
    }

    /// Trials and acceptances since the simulation was built.
    #[must_use]
    pub fn move_counts(&self) -> &'a MoveCounts {
        self.move_counts
    }
}

/// Counts of moves and what became of them, since the simulation was built.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
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
        }
    }
}

/// The displacement of one sphere: an accepted local move, or a straight piece of an event chain.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct AcceptedMove {
    /// Height before the move.
    pub from_height: f64,
    /// Displacement, before periodic wrapping.
    pub displacement: Vector3<f64>,
}

/// Two spheres that touch where an event chain passes from one to the other.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Collision {
    /// Axis along which the chain runs: 0 for x (vertical), 1 for y, 2 for z.
    pub axis: usize,
    /// Height of the sphere that stops.
    pub from_height: f64,
    /// Height of the sphere that goes on.
    pub to_height: f64,
    /// Distance from the first to the second along the chain's direction, positive and at most one diameter.
    pub separation: f64,
}

/// Hears of every single move while a sweep is under way; see [`Observer::recorder`].
pub trait Recorder {
    /// A sphere was displaced.
    fn record_move(&mut self, _accepted: &AcceptedMove) {}

    /// An event chain went over from one sphere to another that it touched.
    fn record_collision(&mut self, _collision: &Collision) {}

    /// An event chain along `axis` (0 is vertical) has run its full length, in diameters.
    fn record_chain(&mut self, _axis: usize, _length: f64) {}
}

/// Something that looks at the configuration after every sweep.
///
/// Tuples of observers are observers, and so are `&mut O`, `Option<O>`, and `()`, which looks at nothing. Wrap one in
/// [`Every`] to look less often.
///
/// ```
/// use gradient_mc::{Frame, Observer, ObserverError};
/// /// The highest sphere seen so far.
/// #[derive(Default)]
/// struct Highest(f64);
/// impl Observer for Highest {
///     fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
///         self.0 = frame.heights().fold(self.0, f64::max);
///         Ok(())
///     }
/// }
/// ```
pub trait Observer {
    /// Looks at the configuration after a sweep.
    ///
    /// # Errors
    /// Any error of the observer's own; it ends the run as [`Error::Observer`](crate::Error::Observer)
    /// with the configuration intact.
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError>;

    /// What wants to hear of every single move, usually `Some(self)`; by default nothing, and then sweeps
    /// report nothing.
    fn recorder(&mut self) -> Option<&mut dyn Recorder> {
        None
    }
}

impl Observer for () {
    fn observe(&mut self, _: &Frame<'_>) -> Result<(), ObserverError> {
        Ok(())
    }
}

impl<O: Observer + ?Sized> Observer for &mut O {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        (**self).observe(frame)
    }
    fn recorder(&mut self) -> Option<&mut dyn Recorder> {
        (**self).recorder()
    }
}

impl<O: Observer + ?Sized> Observer for Box<O> {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        (**self).observe(frame)
    }
    fn recorder(&mut self) -> Option<&mut dyn Recorder> {
        (**self).recorder()
    }
}

impl<O: Observer> Observer for Option<O> {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.as_mut().map_or(Ok(()), |observer| observer.observe(frame))
    }
    fn recorder(&mut self) -> Option<&mut dyn Recorder> {
        self.as_mut().and_then(Observer::recorder)
    }
}

macro_rules! observe_tuple {
    ($($name:ident $index:tt),+) => {
        impl<$($name: Observer),+> Observer for ($($name,)+) {
            fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
                $(self.$index.observe(frame)?;)+
                Ok(())
            }
            fn recorder(&mut self) -> Option<&mut dyn Recorder> {
                if $(self.$index.recorder().is_some())||+ { Some(self) } else { None }
            }
        }
        impl<$($name: Observer),+> Recorder for ($($name,)+) {
            fn record_move(&mut self, accepted: &AcceptedMove) {
                $(if let Some(recorder) = self.$index.recorder() {
                    recorder.record_move(accepted);
                })+
            }
            fn record_collision(&mut self, collision: &Collision) {
                $(if let Some(recorder) = self.$index.recorder() {
                    recorder.record_collision(collision);
                })+
            }
            fn record_chain(&mut self, axis: usize, length: f64) {
                $(if let Some(recorder) = self.$index.recorder() {
                    recorder.record_chain(axis, length);
                })+
            }
        }
    };
}
observe_tuple!(A 0);
observe_tuple!(A 0, B 1);
observe_tuple!(A 0, B 1, C 2);
observe_tuple!(A 0, B 1, C 2, D 3);
observe_tuple!(A 0, B 1, C 2, D 3, E 4);
observe_tuple!(A 0, B 1, C 2, D 3, E 4, G 5);

/// Shows every `interval`-th sweep to the observer inside; moves are all passed on.
#[derive(Debug, Clone)]
pub struct Every<O> {
    interval: u64,
    /// The observer inside.
    pub observer: O,
}

impl<O> Every<O> {
    /// Observes the sweeps whose number is a multiple of `interval`; zero counts as one.
    pub fn new(interval: u64, observer: O) -> Self {
        Self { interval: interval.max(1), observer }
    }
}

impl<O: Observer> Observer for Every<O> {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        if frame.sweep().is_multiple_of(self.interval) { self.observer.observe(frame) } else { Ok(()) }
    }
    fn recorder(&mut self) -> Option<&mut dyn Recorder> {
        self.observer.recorder()
    }
}
