//! The virial series.

use super::{Domain, EquationOfState};
use crate::Error;

/// Coefficients of η, η², ... in Z: B₂ to B₁₀.
const COEFFICIENTS: [f64; 9] =
    [4.0, 10.0, 18.364_768_383, 28.224_45, 39.815_50, 53.344_4, 68.538, 85.813, 105.78];

/// The virial series Z = 1 + B₂η + B₃η² + ..., up to at most B₁₀ η⁹.
///
/// With all ten coefficients it is too low by 0.36 % at η = 0.4, where its domain ends. B₂ to B₄
/// are exact; the others: S. Labík, J. Kolafa and A. Malijevský, Phys. Rev. E 71, 021105 (2005),
/// doi:10.1103/PhysRevE.71.021105; N. Clisby and B. M. `McCoy`, J. Stat. Phys. 122, 15 (2006),
/// doi:10.1007/s10955-005-8080-0.
///
/// ```
/// use gradient_mc::equation_of_state::{EquationOfState, VirialSeries};
/// assert_eq!(VirialSeries::new(3)?.compressibility_factor(0.5), 1.0 + 2.0 + 2.5);
/// assert_eq!(VirialSeries::default(), VirialSeries::new(10)?);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct VirialSeries {
    order: usize,
}

impl VirialSeries {
    /// Makes the series up to and including B_`order`, with `order` from 1 (the ideal gas) to 10.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] outside that range.
    pub fn new(order: usize) -> Result<Self, Error> {
        if (1..=COEFFICIENTS.len() + 1).contains(&order) {
            Ok(Self { order })
        } else {
            let (name, requirement) = ("order of the virial series", "it must be between 1 and 10");
            Err(Error::InvalidParameter { name, value: order as f64, requirement })
        }
    }

    /// Σ weight(k) B_(k+1) η^k over k = 1 ... order − 1, by Horner's rule.
    fn sum(self, eta: f64, weight: impl Fn(f64) -> f64) -> f64 {
        let terms = COEFFICIENTS[..self.order - 1].iter().enumerate();
        terms
            .rev()
            .fold(0.0, |sum, (index, coefficient)| eta * (weight((index + 1) as f64) * coefficient + sum))
    }
}

impl Default for VirialSeries {
    fn default() -> Self {
        Self { order: COEFFICIENTS.len() + 1 }
    }
}

impl EquationOfState for VirialSeries {
    fn compressibility_factor(&self, packing_fraction: f64) -> f64 {
        1.0 + self.sum(packing_fraction, |_| 1.0)
    }
    fn compressibility_derivative(&self, packing_fraction: f64) -> f64 {
        self.sum(packing_fraction, |k| k)
    }
    fn excess_chemical_potential(&self, packing_fraction: f64) -> f64 {
        self.sum(packing_fraction, |k| 1.0 + 1.0 / k)
    }
    fn domain(&self) -> Domain {
        Domain { lowest: 0.0, highest: 0.4 }
    }
}
