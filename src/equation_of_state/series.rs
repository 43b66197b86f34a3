//! A series of the form of Carnahan and Starling's equation, for fits.

use super::EquationOfState;

/// Largest number of terms of a [`Series`].
pub(crate) const MOST_TERMS: usize = 5;

/// Z = 1 + Σ cₖ ηᵏ/(1 − η)³, with k from 1 to the number of terms.
///
/// Two terms with c = 4, −2 are Carnahan and Starling's equation (doi:10.1063/1.1672048). Three
/// terms agree with the modified equation of Kolafa and others within 0.007 % up to η = 0.3 and
/// 0.03 % up to 0.47, four within 0.0004 % and 0.0024 %.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Series {
    coefficients: [f64; MOST_TERMS],
}

impl Series {
    /// A series with the given coefficients; the others are zero.
    pub(crate) fn new(given: &[f64]) -> Self {
        let mut coefficients = [0.0; MOST_TERMS];
        for (coefficient, given) in coefficients.iter_mut().zip(given) {
            *coefficient = *given;
        }
        Self { coefficients }
    }

    /// ηᵏ/(1 − η)³ of all terms.
    #[inline]
    pub(crate) fn terms(packing_fraction: f64) -> [f64; MOST_TERMS] {
        let void = 1.0 - packing_fraction;
        let mut power = 1.0 / (void * void * void);
        [(); MOST_TERMS].map(|()| {
            power *= packing_fraction;
            power
        })
    }

    /// B₂, B₃ and B₄ in units of the volume of a sphere and its powers: the first coefficients of Z
    /// in η.
    pub(crate) fn virial_coefficients(&self) -> [f64; 3] {
        let [first, second, third, ..] = self.coefficients;
        [first, 3.0 * first + second, 6.0 * first + 3.0 * second + third]
    }
}

impl EquationOfState for Series {
    fn compressibility_factor(&self, packing_fraction: f64) -> f64 {
        let terms = Self::terms(packing_fraction);
        1.0 + terms.iter().zip(&self.coefficients).map(|(term, coefficient)| term * coefficient).sum::<f64>()
    }

    fn compressibility_derivative(&self, packing_fraction: f64) -> f64 {
        let pole = 3.0 * packing_fraction / (1.0 - packing_fraction);
        let terms = Self::terms(packing_fraction).into_iter().zip(self.coefficients).enumerate();
        terms.map(|(k, (term, coefficient))| (k as f64 + 1.0 + pole) * term * coefficient).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{CarnahanStarling, ModifiedKolafa, number_density};
    use super::*;

    #[test]
    fn two_terms_are_carnahan_and_starling() {
        let series = Series::new(&[4.0, -2.0]);
        for eta in [0.01, 0.2, 0.47] {
            let [value, slope] = [series.compressibility_factor(eta), series.compressibility_derivative(eta)];
            approx::assert_relative_eq!(value, CarnahanStarling.compressibility_factor(eta), epsilon = 1e-13);
            approx::assert_relative_eq!(
                slope,
                CarnahanStarling.compressibility_derivative(eta),
                epsilon = 1e-12
            );
            let inverse = series.packing_fraction_at(number_density(eta) * value, None).unwrap();
            approx::assert_relative_eq!(inverse, eta, max_relative = 1e-12);
        }
        for (virial, exact) in series.virial_coefficients().into_iter().zip([4.0, 10.0, 18.0]) {
            approx::assert_relative_eq!(virial, exact);
        }
    }

    #[test]
    fn four_terms_hold_what_is_known_of_the_fluid() {
        let series = Series::new(&[3.999_156, -1.981_168, 0.233_157, -0.522_719]);
        for step in 1..=47_u32 {
            let eta = 0.01 * f64::from(step);
            let known = ModifiedKolafa.compressibility_factor(eta);
            approx::assert_relative_eq!(series.compressibility_factor(eta), known, max_relative = 1e-4);
        }
    }
}
