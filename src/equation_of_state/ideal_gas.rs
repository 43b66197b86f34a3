//! Point particles.

use super::{Domain, EquationOfState};

/// The ideal gas: Z = 1 at every density, the limit of a dilute column.
///
/// It is exact for point particles, so its domain has no end. For hard spheres it is too low by 1 %
/// at η = 0.0025.
///
/// ```
/// use gradient_mc::equation_of_state::{EquationOfState, IdealGas};
/// assert_eq!(IdealGas.compressibility_factor(0.3), 1.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct IdealGas;

impl EquationOfState for IdealGas {
    fn compressibility_factor(&self, _packing_fraction: f64) -> f64 {
        1.0
    }
    fn compressibility_derivative(&self, _packing_fraction: f64) -> f64 {
        0.0
    }
    fn excess_chemical_potential(&self, _packing_fraction: f64) -> f64 {
        0.0
    }
    fn domain(&self) -> Domain {
        Domain::ALL
    }
    fn packing_fraction_at(&self, reduced_pressure: f64, _guess: Option<f64>) -> Option<f64> {
        (reduced_pressure >= 0.0 && reduced_pressure.is_finite())
            .then(|| super::packing_fraction(reduced_pressure))
    }
}
