//! A start from a frame of a trajectory.

// Units and the box of a file must match exactly.
#![allow(clippy::float_cmp)]

mod error;
mod extended_xyz;
mod gsd;

pub use error::TrajectoryError;

use super::Start;
use crate::configuration::wrap;
use crate::gsd::single;
use crate::{AnyScene, Error, Generator};
use nalgebra::Vector3;
use std::fs::File;
use std::io::{Read, Seek};
use std::path::Path;

/// A frame of a trajectory of [`ExtendedXyz`](crate::observers::ExtendedXyz),
/// [`Gsd`](crate::observers::Gsd) or another program. The format is detected from the first bytes.
///
/// The scene must have the slab and the number of spheres of the frame. To start in another slab,
/// use [`Positions`](super::Positions) with [`positions`](Self::positions). Overlaps and spheres
/// outside the slab are errors of [`build`](crate::SimulationBuilder::build).
///
/// A trajectory does not contain tuned parameters or a measured field, so equilibrate again, with
/// another seed. To continue a run as if it had not been stopped, use a checkpoint.
///
/// # Precision
/// Frames of both observers are exact: the simulation starts from the same bits.
///
/// GSD of other programs has single precision, 10⁻⁵ in a slab of 400 diameters. Spheres in contact
/// may then overlap by as much, which is an error. Let these programs also write the centers in the
/// coordinates of the slab as `log/particles/exact_position`, an array of doubles, or write
/// extended XYZ with all digits. Without exact positions the middle of the box is taken as that of
/// the slab.
///
/// ```
/// use gradient_mc::observers::ExtendedXyz;
/// use gradient_mc::start::TrajectoryFrame;
/// use gradient_mc::{Every, Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// # let path = std::env::temp_dir().join(format!("gradient-mc-start-{}.xyz", std::process::id()));
/// // let path = "column.xyz";
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 36, UniformField::default(), Isothermal::new(5.0)?)?;
/// let mut trajectory = Every::new(10, ExtendedXyz::new(std::fs::File::create(&path)?));
/// let mut simulation = Simulation::builder(scene).build()?;
/// simulation.run(100, &mut trajectory)?;
/// // In a later program:
/// let start = TrajectoryFrame::last(&path)?;
/// assert_eq!(start.sweep(), Some(100));
/// let again = Simulation::builder(scene).start(start).seed(1).build()?;
/// assert_eq!(again.positions(), simulation.positions());
/// # std::fs::remove_file(&path)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct TrajectoryFrame {
    sweep: Option<u64>,
    extents: Extents,
    positions: Vec<Vector3<f64>>,
}

/// Height and widths.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Extents {
    /// Extents of the slab.
    Slab([f64; 3]),
    /// Extents in single precision of a box that has the slab in its middle.
    Box([f32; 3]),
}

impl TrajectoryFrame {
    /// The last frame of a file.
    ///
    /// # Errors
    /// [`TrajectoryError::File`], with the path and what is wrong.
    pub fn last(path: impl AsRef<Path>) -> Result<Self, TrajectoryError> {
        Self::of_file(path.as_ref(), None)
    }

    /// The frame with this number, counted from 0.
    ///
    /// # Errors
    /// [`TrajectoryError::File`], with the path and what is wrong.
    pub fn nth(path: impl AsRef<Path>, number: u64) -> Result<Self, TrajectoryError> {
        Self::of_file(path.as_ref(), Some(number))
    }

    fn of_file(path: &Path, number: Option<u64>) -> Result<Self, TrajectoryError> {
        File::open(path)
            .map_err(TrajectoryError::from)
            .and_then(|file| Self::read(file, number))
            .map_err(|source| TrajectoryError::File { path: path.into(), source: source.into() })
    }

    /// The frame with this number, or the last one, from any reader. It needs at most 100 kB of
    /// memory plus ten times the size of the data.
    ///
    /// # Errors
    /// [`TrajectoryError`], with the place in the file.
    pub fn read(mut source: impl Read + Seek, number: Option<u64>) -> Result<Self, TrajectoryError> {
        let mut beginning = Vec::new();
        source.by_ref().take(8).read_to_end(&mut beginning)?;
        source.rewind()?;
        if beginning == crate::gsd::MAGIC {
            gsd::read(source, number)
        } else {
            extended_xyz::read(source, number)
        }
    }

    /// Number of the sweep after which the frame was written, if the file has it.
    #[must_use]
    pub fn sweep(&self) -> Option<u64> {
        self.sweep
    }

    /// Centers of the spheres in diameters, x up from the base.
    #[must_use]
    pub fn positions(&self) -> &[Vector3<f64>] {
        &self.positions
    }

    /// Fails unless the frame has these extents of the slab.
    fn require_slab(&self, given: [f64; 3]) -> Result<(), TrajectoryError> {
        for (axis, what) in ["height", "width along y", "width along z"].into_iter().enumerate() {
            let given = given[axis];
            let (stored, same) = match self.extents {
                Extents::Slab(stored) => (stored[axis], stored[axis].to_bits() == given.to_bits()),
                Extents::Box(stored) => {
                    let (stored, given) = (stored[axis], single(given));
                    // There may be room beyond the walls.
                    (
                        f64::from(stored),
                        if axis == 0 { stored >= given } else { stored.to_bits() == given.to_bits() },
                    )
                }
            };
            if !same {
                return Err(TrajectoryError::AnotherSlab { what, stored, given });
            }
        }
        Ok(())
    }
}

impl Start for TrajectoryFrame {
    /// # Errors
    /// [`TrajectoryError::AnotherSlab`].
    fn place(&self, scene: &AnyScene<'_>, _: &mut Generator) -> Result<Vec<Vector3<f64>>, Error> {
        let (height, [width_y, width_z]) = (scene.slab().height(), scene.slab().widths());
        let extents = [height, width_y, width_z];
        self.require_slab(extents)?;
        if matches!(self.extents, Extents::Slab(_)) {
            return Ok(self.positions.clone());
        }
        // From the middle of the box to the corner of the slab. Rounding may have put positions
        // slightly outside.
        let placed = self.positions.iter().map(|center| {
            let [x, y, z] = [0, 1, 2].map(|axis| center[axis] + 0.5 * extents[axis]);
            Vector3::new(x, wrap(y, width_y), wrap(z, width_z))
        });
        Ok(placed.collect())
    }
}
