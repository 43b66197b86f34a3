//! Observers: whatever looks at a simulation while it runs.
//!
//! An observer of a user's own, what judges a run afterwards, the balance of forces and what adapts
//! the potential are all shown the same [`Frame`] after each sweep, and hear of the same single
//! moves if they name a [`Recorder`]: there is no other way to look.
//!
//! To add one, implement [`Observer`] for a type of your own (one method) and pass it by mutable
//! reference to [`Simulation::run`](crate::Simulation::run); results are read from it afterwards.

use crate::failed_observer::FailedObserver;
use crate::frame::Frame;
use nalgebra::Vector3;

/// What an observer's failure may be: any error type of its own, boxed by `?`.
pub type ObserverError = Box<dyn std::error::Error + Send + Sync>;

/// The displacement of one sphere: an accepted local move, or a straight piece of an event chain.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct AcceptedMove {
    /// Height before the move.
    pub from_height: f64,
    /// Displacement, before periodic wrapping.
    pub displacement: Vector3<f64>,
    /// Axis of the event chain that this is a straight piece of (0 is vertical); none of a local
    /// move.
    pub chain_axis: Option<usize>,
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
    /// Distance from the first to the second along the chain's direction, positive and at most one
    /// diameter.
    pub separation: f64,
}

/// A straight piece of an event chain, with the collision that ends it, if one does:
/// [`AcceptedMove`] and [`Collision`] in fewer numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ChainPiece {
    /// Height of the sphere before.
    pub from_height: f64,
    /// Displacement along the axis of the chain, before periodic wrapping.
    pub displacement: f64,
    /// Height of the sphere that is touched; NaN if none is.
    pub to_height: f64,
    /// As in [`Collision`]; 0 if no sphere is touched.
    pub separation: f64,
}

impl ChainPiece {
    /// A piece that no collision ends.
    pub(crate) fn free(from_height: f64, displacement: f64) -> Self {
        Self { from_height, displacement, to_height: f64::NAN, separation: 0.0 }
    }

    /// Notes the collision at its end.
    pub(crate) fn collide(&mut self, to_height: f64, separation: f64) {
        (self.to_height, self.separation) = (to_height, separation);
    }

    /// The piece, of a chain along `axis`, as a move.
    #[inline]
    #[must_use]
    pub fn as_move(&self, axis: usize) -> AcceptedMove {
        let mut displacement = Vector3::zeros();
        displacement[axis] = self.displacement;
        AcceptedMove { from_height: self.from_height, displacement, chain_axis: Some(axis) }
    }

    /// The collision that ends the piece, of a chain along `axis`.
    #[inline]
    #[must_use]
    pub fn collision(&self, axis: usize) -> Option<Collision> {
        let from_height = if axis == 0 { self.from_height + self.displacement } else { self.from_height };
        let &Self { to_height, separation, .. } = self;
        (!to_height.is_nan()).then_some(Collision { axis, from_height, to_height, separation })
    }
}

/// Hears of every single move while a sweep is under way; see [`Observer::recorder`].
pub trait Recorder {
    /// A sphere was displaced.
    fn record_move(&mut self, _accepted: &AcceptedMove) {}

    /// An event chain went over from one sphere to another that it touched.
    fn record_collision(&mut self, _collision: &Collision) {}

    /// Event chains along `axis` went these ways, one piece after the other. Tells of each as a
    /// move and a collision; one that can do better with all at once saves time.
    fn record_pieces(&mut self, axis: usize, pieces: &[ChainPiece]) {
        for piece in pieces {
            self.record_move(&piece.as_move(axis));
            if let Some(collision) = piece.collision(axis) {
                self.record_collision(&collision);
            }
        }
    }

    /// An event chain along `axis` (0 is vertical) is over after a path of `length` diameters.
    fn record_chain(&mut self, _axis: usize, _length: f64) {}

    /// Whether it wants to hear of local moves. To list them takes time, which one that only
    /// listens to chains saves with `false`.
    fn wants_local_moves(&mut self) -> bool {
        true
    }
}

/// Something that looks at the configuration after every sweep.
///
/// Tuples of observers are observers, and so are `&mut O`, `Option<O>`, and `()`, which looks at
/// nothing. Wrap one in [`Every`] to look less often.
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
    /// Any error of the observer's own; it ends the run as
    /// [`Error::Observer`](crate::Error::Observer) with the configuration intact.
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError>;

    /// What wants to hear of every single move of the next sweep, usually `Some(self)`; by default
    /// nothing, and then sweeps report nothing.
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
                $(self.$index.observe(frame).map_err(|error| FailedObserver::at::<$name>($index, error))?;)+
                Ok(())
            }
            fn recorder(&mut self) -> Option<&mut dyn Recorder> {
                let asking = [$(self.$index.recorder().is_some()),+];
                if asking.into_iter().filter(|&asks| asks).count() > 1 {
                    return Some(self);
                }
                // One alone is passed on as it is.
                $(if asking[$index] {
                    return self.$index.recorder();
                })+
                None
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
            fn record_pieces(&mut self, axis: usize, pieces: &[ChainPiece]) {
                $(if let Some(recorder) = self.$index.recorder() {
                    recorder.record_pieces(axis, pieces);
                })+
            }
            fn record_chain(&mut self, axis: usize, length: f64) {
                $(if let Some(recorder) = self.$index.recorder() {
                    recorder.record_chain(axis, length);
                })+
            }
            fn wants_local_moves(&mut self) -> bool {
                false $(|| self.$index.recorder().is_some_and(|recorder| recorder.wants_local_moves()))+
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

    /// Sweeps from one that is observed to the next.
    #[must_use]
    pub fn interval(&self) -> u64 {
        self.interval
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
