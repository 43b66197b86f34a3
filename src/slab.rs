//! The simulation box: hard walls below and above, periodic along y and z.

use crate::Error;
use std::f64::consts::{PI, SQRT_2};

/// A tall box: periodic in y and z, hard walls at x = 0 and x = height.
///
/// Lengths are in sphere diameters. Walls act on the surface of a sphere, so the height of a center
/// is in `[0.5, height - 0.5]`.
///
/// ```
/// use gradient_mc::Slab;
/// let slab = Slab::new(400.0, 25.0, 25.0)?;
/// assert_eq!(slab.base_area(), 625.0);
/// assert_eq!(slab.highest_center(), 399.5);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slab {
    height: f64,
    widths: [f64; 2],
}

impl Slab {
    /// Smallest periodic width, in diameters. In a narrower box a sphere could touch two images of
    /// another sphere.
    pub const MINIMUM_WIDTH: f64 = 3.0;
    /// Smallest height, in diameters.
    pub const MINIMUM_HEIGHT: f64 = 2.0;
    /// Largest height or width, in diameters.
    pub const MAXIMUM_EXTENT: f64 = 1e6;
    /// Largest volume of a scene, in cubic diameters: twice that of a slab of 400 x 500 x 500. The
    /// cells need four to eight bytes of memory per cubic diameter (up to four times as much in
    /// slabs below ten diameters high or wide), and each sphere needs about 150 bytes.
    pub const MAXIMUM_VOLUME: f64 = 2e8;

    /// Makes a slab of the given height and periodic widths along y and z, in diameters.
    ///
    /// # Errors
    /// [`Error::SlabTooSmall`] if a width is below 3 or the height below 2;
    /// [`Error::InvalidParameter`] if one of them is not finite or above 10⁶.
    pub fn new(height: f64, width_y: f64, width_z: f64) -> Result<Self, Error> {
        for (direction, name, extent, minimum) in [
            ('x', "slab height", height, Self::MINIMUM_HEIGHT),
            ('y', "slab width along y", width_y, Self::MINIMUM_WIDTH),
            ('z', "slab width along z", width_z, Self::MINIMUM_WIDTH),
        ] {
            if !extent.is_finite() || extent > Self::MAXIMUM_EXTENT {
                let requirement = "it must be finite and at most 1e6 diameters";
                return Err(Error::InvalidParameter { name, value: extent, requirement });
            }
            if extent < minimum {
                return Err(Error::SlabTooSmall { direction, extent, minimum });
            }
        }
        Ok(Self { height, widths: [width_y, width_z] })
    }

    /// Distance between the walls, in diameters.
    #[must_use]
    pub fn height(&self) -> f64 {
        self.height
    }

    /// Periodic widths along y and z, in diameters.
    #[must_use]
    pub fn widths(&self) -> [f64; 2] {
        self.widths
    }

    /// Area of the base, in square diameters.
    #[must_use]
    pub fn base_area(&self) -> f64 {
        self.widths[0] * self.widths[1]
    }

    /// Lowest possible height of a center: 0.5 diameters.
    #[must_use]
    pub fn lowest_center(&self) -> f64 {
        0.5
    }

    /// Highest possible height of a center, in diameters.
    #[must_use]
    pub fn highest_center(&self) -> f64 {
        self.height - 0.5
    }

    /// Packing fraction of `particles` spheres in the whole slab.
    #[must_use]
    pub fn packing_fraction(&self, particles: usize) -> f64 {
        particles as f64 * PI / 6.0 / (self.base_area() * self.height)
    }

    /// Upper bound on the number of spheres in the slab: its volume at close packing, π/√18.
    #[must_use]
    pub fn capacity(&self) -> usize {
        // Truncation is the floor that is meant.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let capacity = (self.base_area() * self.height * SQRT_2) as usize;
        capacity
    }
}
