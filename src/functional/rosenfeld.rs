//! Rosenfeld's functional.

use super::terms::{Factor, Third, free_energy};
use super::{FreeEnergy, Functional, WeightedDensities};

/// Φ = −n₀ ln(1 − n₃) + (n₁n₂ − **n**₁·**n**₂)/(1 − n₃) + (n₂³ − 3n₂ **n**₂²)/(24π(1 − n₃)²).
///
/// Y. Rosenfeld, Phys. Rev. Lett. 63, 980 (1989), doi:10.1103/PhysRevLett.63.980. Its uniform fluid
/// is [`PercusYevickCompressibility`](crate::equation_of_state::PercusYevickCompressibility), whose
/// pressure is 7 % too high at freezing.
///
/// ```
/// use gradient_mc::EquationOfState;
/// use gradient_mc::equation_of_state::PercusYevickCompressibility;
/// use gradient_mc::functional::{Bulk, Rosenfeld};
/// let (own, known) = (Bulk(Rosenfeld), PercusYevickCompressibility);
/// assert!((own.compressibility_factor(0.3) - known.compressibility_factor(0.3)).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Rosenfeld;

impl Functional for Rosenfeld {
    fn free_energy(&self, weighted: &WeightedDensities) -> FreeEnergy {
        let packing = weighted.packing;
        free_energy(
            weighted,
            Factor::inverse_void(packing),
            Third::rosenfeld(weighted),
            Factor::inverse_square(packing),
        )
    }
}
