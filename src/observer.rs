//! Observers: everything that samples a simulation while it runs.
//!
//! After each sweep all observers get the same [`Frame`]: those of the user, the records behind the
//! warnings, the balance of forces, and the adaptation of the potential. An observer that returns a
//! [`Recorder`] is also called for every single move.
//!
//! To add one, implement [`Observer`] for a type of your own (one method) and pass it by mutable
//! reference to [`Simulation::run`](crate::Simulation::run); read the results from it afterwards.

use crate::failed_observer::FailedObserver;
use crate::frame::Frame;
use nalgebra::Vector3;

/// Error of an observer: any error type, boxed by `?`.
pub type ObserverError = Box<dyn std::error::Error + Send + Sync>;

/// The displacement of one sphere: an accepted local move, or a straight piece of an event chain.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct AcceptedMove {
    /// Height before the move, in diameters.
    pub from_height: f64,
    /// Displacement, in diameters, before periodic wrapping.
    pub displacement: Vector3<f64>,
    /// Axis of the event chain to which this piece belongs (0 is vertical); `None` for a local
    /// move.
    pub chain_axis: Option<usize>,
}

/// A collision in an event chain: the chain passes from one sphere to another that it touches.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Collision {
    /// Axis of the chain: 0 for x (vertical), 1 for y, 2 for z.
    pub axis: usize,
    /// Height of the sphere that stops, in diameters.
    pub from_height: f64,
    /// Height of the sphere that continues, in diameters.
    pub to_height: f64,
    /// Distance from the first to the second sphere along the direction of the chain, between 0 and
    /// 1 diameter.
    pub separation: f64,
}

/// A straight piece of an event chain and the collision at its end, if there is one. A compact form
/// of [`AcceptedMove`] and [`Collision`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ChainPiece {
    /// Height of the sphere before the move, in diameters.
    pub from_height: f64,
    /// Displacement along the axis of the chain, in diameters, before periodic wrapping.
    pub displacement: f64,
    /// Height of the sphere that is hit; NaN if none is.
    pub to_height: f64,
    /// [`Collision::separation`]; 0 if no sphere is hit.
    pub separation: f64,
}

impl ChainPiece {
    /// A piece without a collision at its end.
    pub(crate) fn free(from_height: f64, displacement: f64) -> Self {
        Self { from_height, displacement, to_height: f64::NAN, separation: 0.0 }
    }

    /// Adds the collision at the end of the piece.
    pub(crate) fn collide(&mut self, to_height: f64, separation: f64) {
        (self.to_height, self.separation) = (to_height, separation);
    }

    /// The piece as a move of a chain along `axis`.
    #[inline]
    fn as_move(&self, axis: usize) -> AcceptedMove {
        let mut displacement = Vector3::zeros();
        displacement[axis] = self.displacement;
        AcceptedMove { from_height: self.from_height, displacement, chain_axis: Some(axis) }
    }

    /// The collision at the end of the piece, for a chain along `axis`; `None` without a collision.
    #[inline]
    fn collision(&self, axis: usize) -> Option<Collision> {
        let from_height = if axis == 0 { self.from_height + self.displacement } else { self.from_height };
        let &Self { to_height, separation, .. } = self;
        (!to_height.is_nan()).then_some(Collision { axis, from_height, to_height, separation })
    }
}

/// Receives every single move during a sweep; see [`Observer::recorder`].
///
/// ```
/// use gradient_mc::{Collision, Frame, Observer, ObserverError, Recorder};
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// struct Collisions(u64);
/// impl Recorder for Collisions {
///     fn record_collision(&mut self, _: &Collision) {
///         self.0 += 1;
///     }
/// }
/// impl Observer for Collisions {
///     fn observe(&mut self, _: &Frame<'_>) -> Result<(), ObserverError> {
///         Ok(())
///     }
///     fn recorder(&mut self) -> Option<&mut dyn Recorder> {
///         Some(self)
///     }
/// }
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 36, UniformField::default(), Isothermal::new(5.0)?)?;
/// let mut collisions = Collisions(0);
/// Simulation::builder(scene).build()?.run(10, &mut collisions)?;
/// assert!(collisions.0 > 0);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
pub trait Recorder {
    /// Called after each displacement of a sphere.
    fn record_move(&mut self, _accepted: &AcceptedMove) {}

    /// Called after each collision of an event chain.
    fn record_collision(&mut self, _collision: &Collision) {}

    /// Called with consecutive pieces of event chains along `axis`. The default calls
    /// [`record_move`](Self::record_move) and [`record_collision`](Self::record_collision) for each
    /// piece; implement it if all pieces can be processed faster at once.
    fn record_pieces(&mut self, axis: usize, pieces: &[ChainPiece]) {
        for piece in pieces {
            self.record_move(&piece.as_move(axis));
            if let Some(collision) = piece.collision(axis) {
                self.record_collision(&collision);
            }
        }
    }

    /// Called at the end of an event chain along `axis` (0 is vertical) with a path of `length`
    /// diameters.
    fn record_chain(&mut self, _axis: usize, _length: f64) {}

    /// Whether local moves are recorded. Return `false` to save time if only event chains are
    /// needed.
    fn wants_local_moves(&mut self) -> bool {
        true
    }
}

/// Samples the configuration after every sweep.
///
/// Tuples of observers are observers, and so are `&mut O`, `Option<O>`, and `()`, which samples
/// nothing. Wrap an observer in [`Every`] to sample less often.
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
    /// Samples the configuration after a sweep.
    ///
    /// # Errors
    /// Any error of the observer. It ends the run as [`Error::Observer`](crate::Error::Observer)
    /// with the configuration intact.
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError>;

    /// The recorder of the single moves of the next sweep, usually `Some(self)`. The default is
    /// `None`: moves are not recorded.
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
                // A single recorder is passed on directly.
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

/// Calls the observer inside after every `interval`-th sweep. A [`Recorder`] still gets the moves
/// of all sweeps.
///
/// ```
/// use gradient_mc::{Every, ObserverFn, Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 36, UniformField::default(), Isothermal::new(5.0)?)?;
/// let mut sweeps = Vec::new();
/// let observer = ObserverFn::new(|frame| {
///     sweeps.push(frame.sweep());
///     Ok(())
/// });
/// Simulation::builder(scene).build()?.run(35, &mut Every::new(10, observer))?;
/// assert_eq!(sweeps, [10, 20, 30]);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Every<O> {
    interval: u64,
    /// The observer inside.
    pub observer: O,
}

impl<O> Every<O> {
    /// Observes the sweeps whose number is a multiple of `interval`; 0 is taken as 1.
    pub fn new(interval: u64, observer: O) -> Self {
        Self { interval: interval.max(1), observer }
    }

    /// Number of sweeps between two observations.
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
