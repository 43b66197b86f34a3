//! Positions given by the user.

use super::Start;
use crate::{Error, Generator, Scene};
use nalgebra::Vector3;

/// Centres in diameters, x up. They must lie in the slab (y and z in [0, width]) and not overlap.
#[derive(Debug, Clone, PartialEq)]
pub struct Positions(
    /// The centres, one per sphere of the scene.
    pub Vec<Vector3<f64>>,
);

impl Start for Positions {
    fn place<F, T>(&self, _: &Scene<F, T>, _: &mut Generator) -> Result<Vec<Vector3<f64>>, Error> {
        Ok(self.0.clone())
    }
}
