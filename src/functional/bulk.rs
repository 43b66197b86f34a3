//! The uniform fluid of a functional.

use super::{Functional, WeightedDensities};
use crate::equation_of_state::{EquationOfState, number_density};

/// The equation of state of a [`Functional`] at uniform density.
///
/// ```
/// use gradient_mc::equation_of_state::{CarnahanStarling, EquationOfState};
/// use gradient_mc::functional::{Bulk, WhiteBear2};
/// let (own, known) = (Bulk(WhiteBear2), CarnahanStarling);
/// assert!((own.compressibility_factor(0.4) - known.compressibility_factor(0.4)).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Bulk<W>(
    /// The functional.
    pub W,
);

impl<W: Functional> Bulk<W> {
    /// Φ/n, and the derivative of Φ by n.
    fn excess(&self, packing_fraction: f64) -> [f64; 2] {
        let number_density = number_density(packing_fraction);
        let weighted = WeightedDensities::uniform(number_density);
        let energy = self.0.free_energy(&weighted);
        let derivative = energy.by_packing * weighted.packing
            + energy.by_surface * weighted.surface
            + energy.by_tensor * weighted.tensor;
        [energy.density / number_density, derivative / number_density]
    }
}

impl<W: Functional> EquationOfState for Bulk<W> {
    fn compressibility_factor(&self, packing_fraction: f64) -> f64 {
        if packing_fraction == 0.0 {
            return 1.0;
        }
        let [energy, derivative] = self.excess(packing_fraction);
        1.0 + derivative - energy
    }

    fn excess_chemical_potential(&self, packing_fraction: f64) -> f64 {
        if packing_fraction == 0.0 {
            return 0.0;
        }
        let [_, derivative] = self.excess(packing_fraction);
        derivative
    }
}
