//! The modified equation of Kolafa, Labík and Malijevský.

use super::EquationOfState;

/// Powers of y = η/(1 − η) and their coefficients in Z.
const TERMS: [(usize, f64); 11] = [
    (1, 4.0),
    (2, 6.0),
    (3, 2.364_768_4),
    (4, -0.869_855_1),
    (5, 1.106_280_3),
    (6, -1.101_422_1),
    (7, 0.666_058_66),
    (8, -0.036_334_31),
    (10, -0.209_651_64),
    (14, 0.105_555_69),
    (22, -0.008_723_80),
];
/// Highest power in [`TERMS`].
const DEGREE: usize = 22;

/// The modified equation of Kolafa, Labík and Malijevský: a polynomial in η/(1 − η), the most
/// accurate fluid equation of the library.
///
/// It is fitted to simulations, including the metastable fluid up to η = 0.52. Its domain ends at
/// freezing, because the crystal is the stable state beyond. The pressure has a maximum at η =
/// 0.571 (P/T = 22.1), above which it cannot be inverted. S. Pieprzyk, M. N. Bannerman, A. C.
/// Brańka, M. Chudak and D. M. Heyes, Phys. Chem. Chem. Phys. 21, 6886 (2019),
/// doi:10.1039/C9CP00903E.
///
/// ```
/// use gradient_mc::equation_of_state::{EquationOfState, ModifiedKolafa};
/// assert!((ModifiedKolafa.compressibility_factor(0.2) - 2.4094).abs() < 1e-5);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ModifiedKolafa;

/// Sum over the terms of `weight(k) c_k y^k`, powers by repeated multiplication.
fn sum_terms(y: f64, weight: impl Fn(usize) -> f64) -> f64 {
    let (mut power, mut degree, mut sum) = (1.0, 0, 0.0);
    for (exponent, coefficient) in TERMS {
        while degree < exponent {
            power *= y;
            degree += 1;
        }
        sum += weight(exponent) * coefficient * power;
    }
    sum
}

impl EquationOfState for ModifiedKolafa {
    fn compressibility_factor(&self, packing_fraction: f64) -> f64 {
        1.0 + sum_terms(packing_fraction / (1.0 - packing_fraction), |_| 1.0)
    }
    fn compressibility_derivative(&self, packing_fraction: f64) -> f64 {
        let void = 1.0 - packing_fraction;
        sum_terms(packing_fraction / void, |exponent| exponent as f64) / void
    }
    fn excess_chemical_potential(&self, packing_fraction: f64) -> f64 {
        let y = packing_fraction / (1.0 - packing_fraction);
        // dη/η = dy/(y(1 + y)), and I_k = ∫ y^(k-1)/(1 + y) dy obeys I_(k+1) = y^k/k - I_k.
        let mut integrals = [0.0; DEGREE + 1];
        integrals[1] = libm::log1p(y);
        let mut power = 1.0;
        for k in 1..DEGREE {
            power *= y;
            integrals[k + 1] = power / k as f64 - integrals[k];
        }
        let integral: f64 = TERMS.iter().map(|&(k, coefficient)| coefficient * integrals[k]).sum();
        sum_terms(y, |_| 1.0) + integral
    }
}
