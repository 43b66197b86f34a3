//! The White Bear functional, mark II.

use super::terms::{Factor, Third, free_energy};
use super::{FreeEnergy, Functional, WeightedDensities};

/// [`Rosenfeld`](super::Rosenfeld)'s with f₂ = ⅓ + 4/(3(1 − n₃)) + 2 ln(1 − n₃)/(3n₃) in place of
/// 1/(1 − n₃), and f₃ = (−2 + 6n₃ − 2n₃²)/(3n₃(1 − n₃)²) − 2 ln(1 − n₃)/(3n₃²) in place of 1/(1 −
/// n₃)².
///
/// H. Hansen-Goos and R. Roth, J. Phys.: Condens. Matter 18, 8413 (2006),
/// doi:10.1088/0953-8984/18/37/002. Its uniform fluid is
/// [`CarnahanStarling`](crate::equation_of_state::CarnahanStarling), and it is consistent with
/// scaled-particle theory to 2 %.
///
/// ```
/// use gradient_mc::functional::{DensityFunctional, WhiteBear2};
/// use gradient_mc::{field::UniformField, temperature::Isothermal};
/// let column = DensityFunctional::new(UniformField::default(), Isothermal::new(15.0)?, WhiteBear2);
/// assert!((column.column_density(40.0)?.center_of_mass() - 42.980).abs() < 1e-3);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct WhiteBear2;

impl Functional for WhiteBear2 {
    fn free_energy(&self, weighted: &WeightedDensities) -> FreeEnergy {
        let packing = weighted.packing;
        let [second, third] = factors(packing);
        free_energy(weighted, second, Third::rosenfeld(weighted), third)
    }
}

fn factors(packing: f64) -> [Factor; 2] {
    const SCALE: f64 = 2.0 / 3.0;
    if packing.abs() < Factor::SERIES {
        return [
            Factor::from_series(packing, |k| if k < 1.0 { 1.0 } else { SCALE * (2.0 - 1.0 / (k + 1.0)) }),
            Factor::from_series(packing, |k| SCALE * (k + 1.0 + 1.0 / (k + 2.0))),
        ];
    }
    let (inverse, void) = (1.0 / packing, 1.0 / (1.0 - packing));
    // ln(1 − n₃)/n₃ and its derivative.
    let logarithm = libm::log1p(-packing) * inverse;
    let slope = -inverse * (void + logarithm);
    let polynomial = (3.0 - packing) * packing - 1.0;
    [
        Factor {
            value: 1.0 / 3.0 + SCALE * (2.0 * void + logarithm),
            slope: SCALE * (2.0 * void * void + slope),
        },
        Factor {
            value: SCALE * inverse * (polynomial * void * void - logarithm),
            slope: SCALE
                * inverse
                * ((3.0 - 2.0 * packing + polynomial * (2.0 * void - inverse)) * void * void
                    + inverse * logarithm
                    - slope),
        },
    ]
}
