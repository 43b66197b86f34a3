//! The Percus-Yevick equation, by the virial route.

use super::EquationOfState;

/// Percus and Yevick's closure with the pressure from the contact value: Z = (1 + 2η + 3η²)/(1 −
/// η)².
///
/// It is too low, by 15 % at freezing. M. S. Wertheim, Phys. Rev. Lett. 10, 321 (1963),
/// doi:10.1103/PhysRevLett.10.321; E. Thiele, J. Chem. Phys. 39, 474 (1963), doi:10.1063/1.1734272.
///
/// ```
/// use gradient_mc::equation_of_state::{EquationOfState, PercusYevickVirial};
/// assert_eq!(PercusYevickVirial.compressibility_factor(0.5), 11.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PercusYevickVirial;

impl EquationOfState for PercusYevickVirial {
    fn compressibility_factor(&self, packing_fraction: f64) -> f64 {
        let eta = packing_fraction;
        let void = 1.0 - eta;
        (1.0 + eta * (2.0 + 3.0 * eta)) / (void * void)
    }
    fn compressibility_derivative(&self, packing_fraction: f64) -> f64 {
        let eta = packing_fraction;
        let void = 1.0 - eta;
        eta * (4.0 + 8.0 * eta) / (void * void * void)
    }
    fn excess_chemical_potential(&self, packing_fraction: f64) -> f64 {
        let eta = packing_fraction;
        let void = 1.0 - eta;
        eta * (4.0 + 2.0 * eta) / (void * void) + 6.0 * eta / void + 2.0 * libm::log1p(-eta)
    }
}
