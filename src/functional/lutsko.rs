//! Lutsko's functionals of two parameters.

use super::terms::{Factor, Third, free_energy};
use super::{FreeEnergy, Functional, WeightedDensities};
use crate::Error;
use std::f64::consts::PI;

/// [`Rosenfeld`](super::Rosenfeld)'s with [A(n₂³ − 3n₂ **n**₂² + 3 **n**₂·T·**n**₂ − Tr T³) + B(n₂³
/// − 3n₂ Tr T² + 2 Tr T³)]/(24π) in place of (n₂³ − 3n₂ **n**₂²)/(24π).
///
/// J. F. Lutsko, Phys. Rev. E 102, 062137 (2020), doi:10.1103/PhysRevE.102.062137. With 8A + 2B = 9
/// the uniform fluid is
/// [`PercusYevickCompressibility`](crate::equation_of_state::PercusYevickCompressibility);
/// otherwise its third virial coefficient is wrong. With A ≥ 0 and B ≥ 0 the functional is bounded
/// below for any density.
///
/// ```
/// use gradient_mc::EquationOfState;
/// use gradient_mc::functional::{Bulk, Lutsko};
/// // 8A + 2B = 9: the third virial coefficient is 10.
/// let bulk = Bulk(Lutsko::new(1.0, 0.5)?);
/// let third = (bulk.compressibility_factor(1e-3) - 1.0 - 4.0 * 1e-3) / 1e-6;
/// assert!((third - 10.0).abs() < 0.1);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lutsko {
    a: f64,
    b: f64,
}

impl Lutsko {
    /// The explicitly stable functional, A = 1 and B = 0.
    pub const STABLE: Self = Self { a: 1.0, b: 0.0 };
    /// Tarazona's, A = 3/2 and B = −3/2 (Phys. Rev. Lett. 84, 694 (2000),
    /// doi:10.1103/PhysRevLett.84.694).
    pub const TARAZONA: Self = Self { a: 1.5, b: -1.5 };

    /// A functional with these A and B.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] unless both are finite.
    pub fn new(a: f64, b: f64) -> Result<Self, Error> {
        Ok(Self { a: Error::require_finite("parameter A", a)?, b: Error::require_finite("parameter B", b)? })
    }
}

impl Functional for Lutsko {
    fn free_energy(&self, weighted: &WeightedDensities) -> FreeEnergy {
        const SCALE: f64 = 1.0 / (24.0 * PI);
        let WeightedDensities { packing, surface, vector, tensor } = *weighted;
        // The tensor is diagonal, and its two horizontal components are equal.
        let lateral = 0.5 * (surface - tensor);
        let squares = tensor * tensor + 2.0 * lateral * lateral;
        let cubes = tensor * tensor * tensor + 2.0 * lateral * lateral * lateral;
        let (surface_squared, vector_squared) = (surface * surface, vector * vector);
        // Derivatives of the traces by n₂ and Tₓₓ.
        let (squares_by_surface, cubes_by_surface) = (2.0 * lateral, 3.0 * lateral * lateral);
        let squares_by_tensor = 2.0 * (tensor - lateral);
        let cubes_by_tensor = 3.0 * (tensor * tensor - lateral * lateral);
        let (a, b) = (SCALE * self.a, SCALE * self.b);
        let third = Third {
            value: a
                * (surface * (surface_squared - 3.0 * vector_squared) + 3.0 * vector_squared * tensor
                    - cubes)
                + b * (surface * (surface_squared - 3.0 * squares) + 2.0 * cubes),
            by_surface: a * (3.0 * (surface_squared - vector_squared) - cubes_by_surface)
                + b * (3.0 * (surface_squared - squares - surface * squares_by_surface)
                    + 2.0 * cubes_by_surface),
            by_vector: 6.0 * a * vector * (tensor - surface),
            by_tensor: a * (3.0 * vector_squared - cubes_by_tensor)
                + b * (2.0 * cubes_by_tensor - 3.0 * surface * squares_by_tensor),
        };
        free_energy(weighted, Factor::inverse_void(packing), third, Factor::inverse_square(packing))
    }
}
