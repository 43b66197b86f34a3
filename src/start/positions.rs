//! Positions given by the user.

use super::Start;
use crate::{AnyScene, Error, Generator};
use nalgebra::Vector3;

/// Centers in diameters, x up. They must lie in the slab (y and z in [0, width]) and not overlap.
///
/// ```
/// use gradient_mc::start::Positions;
/// use gradient_mc::{Scene, Simulation, Slab, Vector3, field::UniformField, temperature::Isothermal};
/// let slab = Slab::new(20.0, 3.0, 3.0)?;
/// let scene = Scene::new(slab, 2, UniformField::default(), Isothermal::new(5.0)?)?;
/// let centers = vec![Vector3::new(0.5, 1.0, 1.0), Vector3::new(1.5, 1.0, 1.0)];
/// let mut simulation = Simulation::builder(scene).start(Positions(centers)).build()?;
/// simulation.equilibrate(10, &mut ())?;
/// // Another run from here. With the same seed it would draw the same random numbers. Tuned
/// // parameters and a measured field are not taken along, so equilibrate again.
/// let resumed = Simulation::builder(scene).start(Positions(simulation.positions())).seed(1).build()?;
/// assert_eq!(resumed.positions(), simulation.positions());
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Positions(
    /// The centers, one per sphere of the scene.
    pub Vec<Vector3<f64>>,
);

impl Start for Positions {
    fn place(&self, _: &AnyScene<'_>, _: &mut Generator) -> Result<Vec<Vector3<f64>>, Error> {
        Ok(self.0.clone())
    }
}
