//! The Percus-Yevick equation, by the compressibility route.

use super::EquationOfState;

/// Percus and Yevick's closure with the pressure from the compressibility: Z = (1 + η + η²)/(1 −
/// η)³.
///
/// It is too high, by 7 % at freezing. Scaled-particle theory gives the same pressure. M. S.
/// Wertheim, Phys. Rev. Lett. 10, 321 (1963), doi:10.1103/PhysRevLett.10.321; E. Thiele, J. Chem.
/// Phys. 39, 474 (1963), doi:10.1063/1.1734272.
///
/// ```
/// use gradient_mc::equation_of_state::{EquationOfState, PercusYevickCompressibility};
/// assert_eq!(PercusYevickCompressibility.compressibility_factor(0.5), 14.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PercusYevickCompressibility;

impl EquationOfState for PercusYevickCompressibility {
    fn compressibility_factor(&self, packing_fraction: f64) -> f64 {
        let eta = packing_fraction;
        let void = 1.0 - eta;
        (1.0 + eta * (1.0 + eta)) / (void * void * void)
    }
    fn compressibility_derivative(&self, packing_fraction: f64) -> f64 {
        let eta = packing_fraction;
        let ratio = (2.0 + eta) / ((1.0 - eta) * (1.0 - eta));
        eta * ratio * ratio
    }
    fn excess_chemical_potential(&self, packing_fraction: f64) -> f64 {
        let eta = packing_fraction;
        let void = 1.0 - eta;
        -libm::log1p(-eta) + eta * (14.0 + eta * (5.0 * eta - 13.0)) / (2.0 * void * void * void)
    }
}
