//! Initial configurations.
//!
//! | start | configuration |
//! |---|---|
//! | [`Theory`] | the hydrostatic profile, at any packing: shortest equilibration, the default |
//! | [`Functional`] | the profile of a density functional, with the layers at the walls |
//! | [`RandomInsertion`] | random sequential insertion at n = 0.1, as in the 2011 paper: far above the steady state |
//! | [`ClosePacked`] | a close-packed crystal on the base: far below the steady state |
//! | [`TrajectoryFrame`] | a frame of an earlier run, as extended XYZ or GSD |
//! | [`Positions`] | given positions |
//!
//! To show that a run has reached the steady state, compare two opposite starts. To add a start,
//! implement [`Start`].

mod close_packed;
mod functional;
mod positions;
mod random_insertion;
mod theory;
mod trajectory_frame;

pub use close_packed::ClosePacked;
pub use functional::Functional;
pub use positions::Positions;
pub use random_insertion::RandomInsertion;
pub use theory::Theory;
pub use trajectory_frame::{TrajectoryError, TrajectoryFrame};

use crate::{AnyScene, Error, Generator};
use nalgebra::Vector3;
use std::sync::Arc;

/// A way to place the spheres of a scene.
///
/// `&`, `Box` and `Arc` of a start are starts, so it can be chosen at run time as `Box<dyn Start>`.
///
/// ```
/// use gradient_mc::start::Start;
/// use gradient_mc::{AnyScene, Error, Generator, Vector3};
/// /// A single file of touching spheres.
/// struct Tower;
/// impl Start for Tower {
///     fn place(&self, scene: &AnyScene<'_>, _: &mut Generator) -> Result<Vec<Vector3<f64>>, Error> {
///         Ok((0..scene.particles()).map(|sphere| Vector3::new(0.5 + sphere as f64, 1.0, 1.0)).collect())
///     }
/// }
/// ```
pub trait Start: Send + Sync {
    /// Returns as many centers as the scene has spheres, inside the slab. The simulation checks
    /// them.
    ///
    /// # Errors
    /// Any [`Error`], as documented by the start.
    fn place(&self, scene: &AnyScene<'_>, generator: &mut Generator) -> Result<Vec<Vector3<f64>>, Error>;
}

macro_rules! forward_start {
    ($($pointer:ty),+) => {
        $(impl<S: Start + ?Sized> Start for $pointer {
            fn place(&self, scene: &AnyScene<'_>, generator: &mut Generator) -> Result<Vec<Vector3<f64>>, Error> {
                (**self).place(scene, generator)
            }
        })+
    };
}
forward_start!(&S, Box<S>, Arc<S>);
