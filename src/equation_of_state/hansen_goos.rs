//! The equation of Hansen-Goos.

use super::EquationOfState;

/// Coefficient of ln(1 − η)/η.
const LOGARITHM: f64 = 8.0;
/// Coefficients of η^i/(1 − η)³.
const TERMS: [f64; 8] = [9.0, -19.0, 47.0 / 3.0, -2.635_232, -1.265_575, 0.041_212, 0.248_245, -0.096_495];

/// The equation of Hansen-Goos: Z = 8 ln(1 − η)/η + Σ bᵢ ηⁱ/(1 − η)³, eight terms.
///
/// It is based on the virial coefficients up to the eleventh and on simulations, independently of
/// [`ModifiedKolafa`](super::ModifiedKolafa). The two differ by less than 3·10⁻⁵ in Z up to η =
/// 0.3, by less than 7·10⁻⁵ up to 0.47 and by 1.5·10⁻⁴ at freezing, where its domain ends. H.
/// Hansen-Goos, J. Chem. Phys. 144, 164506 (2016), doi:10.1063/1.4947534.
///
/// ```
/// use gradient_mc::equation_of_state::{EquationOfState, HansenGoos, ModifiedKolafa};
/// let ratio = HansenGoos.compressibility_factor(0.45) / ModifiedKolafa.compressibility_factor(0.45);
/// assert!((ratio - 1.0).abs() < 5e-5);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct HansenGoos;

/// Σ bᵢ ηⁱ, each term times `weight(i)`.
fn sum_terms(packing_fraction: f64, weight: impl Fn(usize) -> f64) -> f64 {
    let terms = TERMS.iter().enumerate().rev();
    terms.fold(0.0, |sum, (i, coefficient)| sum * packing_fraction + weight(i) * coefficient)
}

/// ln(1 − η)/η.
fn logarithm(packing_fraction: f64) -> f64 {
    if packing_fraction == 0.0 { -1.0 } else { libm::log1p(-packing_fraction) / packing_fraction }
}

impl EquationOfState for HansenGoos {
    fn compressibility_factor(&self, packing_fraction: f64) -> f64 {
        let void = 1.0 - packing_fraction;
        LOGARITHM * logarithm(packing_fraction) + sum_terms(packing_fraction, |_| 1.0) / (void * void * void)
    }
    fn compressibility_derivative(&self, packing_fraction: f64) -> f64 {
        let void = 1.0 - packing_fraction;
        let rise = sum_terms(packing_fraction, |i| i as f64)
            + sum_terms(packing_fraction, |_| 1.0) * 3.0 * packing_fraction / void;
        rise / (void * void * void) - LOGARITHM * (1.0 / void + logarithm(packing_fraction))
    }
    fn excess_chemical_potential(&self, packing_fraction: f64) -> f64 {
        let eta = packing_fraction;
        let inverse = 1.0 / (1.0 - eta);
        let log_void = libm::log1p(-eta);
        // ∫ (8 ln(1 − η)/η + b₀/(1 − η)³ − 1)/η dη from zero; since b₀ = 9 the terms in ln η
        // cancel.
        let mut integral = TERMS[0] * (inverse + 0.5 * inverse * inverse - 1.5)
            - LOGARITHM * (logarithm(eta) + 1.0)
            + (LOGARITHM - TERMS[0]) * log_void;
        // powers[m] = ∫ η^k/(1 − η)^m dη, and η^k = η^(k−1) − η^(k−1) (1 − η).
        let mut powers = [eta, -log_void, inverse - 1.0, 0.5 * (inverse * inverse - 1.0)];
        let mut power = eta;
        for (i, coefficient) in TERMS.iter().enumerate().skip(1) {
            integral += coefficient * powers[3];
            power *= eta;
            let next = power / (i + 1) as f64;
            powers = [next, powers[1] - powers[0], powers[2] - powers[1], powers[3] - powers[2]];
        }
        self.compressibility_factor(eta) - 1.0 + integral
    }
}
