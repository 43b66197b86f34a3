//! Random sequential insertion.

use super::Start;
use crate::configuration::Configuration;
use crate::equation_of_state::packing_fraction;
use crate::random::unit;
use crate::{AnyScene, Error, Generator};
use nalgebra::Vector3;

/// Spheres inserted one by one at random positions without overlap, from the base up to the height
/// that gives a number density, or to the lid if that is lower.
///
/// Random insertion jams near a packing fraction of 0.38 (n = 0.73).
///
/// ```
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, start::RandomInsertion, temperature::Isothermal};
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 180, UniformField::default(), Isothermal::new(5.0)?)?;
/// let simulation = Simulation::builder(scene).start(RandomInsertion::new(0.2)?).build()?;
/// // 180/36 spheres per area at n = 0.2 fill 25 diameters.
/// let highest = simulation.frame().heights().fold(0.0, f64::max);
/// assert!(highest > 20.0 && highest < 25.0);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RandomInsertion {
    number_density: f64,
}

impl RandomInsertion {
    /// Spheres at `number_density`, in inverse cubic diameters.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] unless positive and finite.
    pub fn new(number_density: f64) -> Result<Self, Error> {
        let name = "number density of random insertion";
        Ok(Self { number_density: Error::require_positive(name, number_density)? })
    }
}

impl Default for RandomInsertion {
    /// n = 0.1, as in doi:10.1103/PhysRevE.83.061306.
    fn default() -> Self {
        Self { number_density: 0.1 }
    }
}

impl Start for RandomInsertion {
    /// # Errors
    /// [`Error::InsertionFailed`] when the spheres do not fit.
    fn place(&self, scene: &AnyScene<'_>, generator: &mut Generator) -> Result<Vec<Vector3<f64>>, Error> {
        // After a million failures in a row the free volume is below about 1e-6 of the whole.
        const ATTEMPTS: usize = 1_000_000;
        let slab = scene.slab();
        let [width_y, width_z] = slab.widths();
        let requested = scene.particles();
        // Centers keep half a diameter off the walls; the density is that of the slab between
        // surfaces, so that the paper's 25 000 spheres fill its 400 diameters.
        let top = scene.column_density() / self.number_density;
        let range = (top.min(slab.height()) - 1.0).max(0.0);
        let mut configuration = Configuration::empty(*slab);
        for placed in 0..requested {
            let inserted = (0..ATTEMPTS).any(|_| {
                let mut along = |start: f64, width: f64| {
                    // Rounding may reach the end of the range, which a periodic width excludes.
                    (start + width * unit(generator)).min((start + width).next_down())
                };
                let lowest = slab.lowest_center();
                let height = if range > 0.0 { along(lowest, range) } else { lowest };
                configuration.try_push([height, along(0.0, width_y), along(0.0, width_z)])
            });
            if !inserted {
                let volume = slab.base_area() * (range + 1.0);
                return Err(Error::InsertionFailed {
                    placed,
                    requested,
                    attempts: ATTEMPTS,
                    packing_fraction: packing_fraction(placed as f64 / volume),
                });
            }
        }
        Ok(configuration.positions().iter().map(|&position| position.into()).collect())
    }
}
