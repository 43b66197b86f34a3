//! The White Bear functional.

use super::terms::{Factor, Third, free_energy};
use super::{FreeEnergy, Functional, WeightedDensities};

/// [`Rosenfeld`](super::Rosenfeld)'s with 2[n₃ + (1 − n₃)² ln(1 − n₃)]/(3n₃²(1 − n₃)²) in place of
/// 1/(1 − n₃)².
///
/// R. Roth, R. Evans, A. Lang and G. Kahl, J. Phys.: Condens. Matter 14, 12063 (2002),
/// doi:10.1088/0953-8984/14/46/313. Its uniform fluid
/// is [`CarnahanStarling`](crate::equation_of_state::CarnahanStarling).
///
/// ```
/// use gradient_mc::functional::{DensityFunctional, WhiteBear};
/// use gradient_mc::{field::UniformField, temperature::Isothermal};
/// let column = DensityFunctional::new(UniformField::default(), Isothermal::new(5.0)?, WhiteBear);
/// // The contact theorem.
/// assert!((5.0 * column.column_density(10.0)?.contact_density() - 10.0).abs() < 1e-6);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct WhiteBear;

impl Functional for WhiteBear {
    fn free_energy(&self, weighted: &WeightedDensities) -> FreeEnergy {
        let packing = weighted.packing;
        free_energy(
            weighted,
            Factor::inverse_void(packing),
            Third::rosenfeld(weighted),
            third_factor(packing),
        )
    }
}

/// 2/3 [1/(n₃(1 − n₃)²) + ln(1 − n₃)/n₃²].
fn third_factor(packing: f64) -> Factor {
    const SCALE: f64 = 2.0 / 3.0;
    if packing.abs() < Factor::SERIES {
        return Factor::from_series(packing, |k| SCALE * (k + 2.0 - 1.0 / (k + 2.0)));
    }
    let (inverse, void) = (1.0 / packing, 1.0 / (1.0 - packing));
    let logarithm = libm::log1p(-packing) * inverse;
    Factor {
        value: SCALE * inverse * (void * void + logarithm),
        slope: SCALE
            * inverse
            * (2.0 * void * void * void - inverse * void * void - inverse * void - 2.0 * inverse * logarithm),
    }
}
