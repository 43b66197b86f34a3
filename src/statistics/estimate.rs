//! A mean with its standard error.

use std::fmt;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A mean and its standard error (one standard deviation of the mean).
///
/// It prints as value(error), with two figures of the error in units of the last digits:
///
/// ```
/// use gradient_mc::statistics::Estimate;
/// assert_eq!(Estimate::new(42.98131, 0.0137).to_string(), "42.981(14)");
/// assert_eq!(Estimate::new(42.98131, 2.34).to_string(), "43.0(2.3)");
/// assert_eq!(Estimate::new(42.98131, 0.0).to_string(), "42.98131(0)");
/// ```
///
/// # Arithmetic
/// The operators +, −, × and ÷ combine an estimate with an *exact* number. There are no operators
/// for two estimates, because the error of a sum depends on their correlation, and estimates from
/// one run are correlated. Combine independent estimates (other seeds or scenes) with the methods
/// named `..._independent`, with errors to first order. For functions of several numbers from one
/// run use [`jackknife`](super::BlockAverages::jackknife).
///
/// ```
/// use gradient_mc::statistics::Estimate;
/// let percent = 100.0 * (Estimate::new(1.02, 0.003) - 1.0);
/// assert_eq!(percent.to_string(), "2.00(30)");
/// // Of two runs with different seeds.
/// let rise = Estimate::new(43.03, 0.03).minus_independent(Estimate::new(42.98, 0.04));
/// assert_eq!(rise.to_string(), "0.050(50)");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Estimate {
    /// The estimated value.
    pub mean: f64,
    /// Its standard error.
    pub standard_error: f64,
}

/// An exact number, with error 0.
impl From<f64> for Estimate {
    fn from(value: f64) -> Self {
        Self::exact(value)
    }
}

impl Estimate {
    /// Makes an estimate from a value and its standard error.
    #[must_use]
    pub fn new(mean: f64, standard_error: f64) -> Self {
        Self { mean, standard_error }
    }

    /// Makes an estimate from an exact value, with error 0.
    #[must_use]
    pub fn exact(value: f64) -> Self {
        Self::new(value, 0.0)
    }

    /// Sum with an independent estimate.
    #[must_use]
    pub fn plus_independent(self, other: Self) -> Self {
        Self::new(self.mean + other.mean, libm::hypot(self.standard_error, other.standard_error))
    }

    /// Difference to an independent estimate, `self` − `other`.
    #[must_use]
    pub fn minus_independent(self, other: Self) -> Self {
        self.plus_independent(-other)
    }

    /// Product with an independent estimate; the error is to first order.
    #[must_use]
    pub fn times_independent(self, other: Self) -> Self {
        let error = libm::hypot(self.standard_error * other.mean, other.standard_error * self.mean);
        Self::new(self.mean * other.mean, error)
    }

    /// Ratio to an independent estimate; the error is to first order, for a small relative error of
    /// the denominator.
    #[must_use]
    pub fn over_independent(self, other: Self) -> Self {
        let ratio = self.mean / other.mean;
        let error = libm::hypot(self.standard_error, ratio * other.standard_error) / other.mean.abs();
        Self::new(ratio, error)
    }

    /// The mean of independent estimates with equal weights; NaN if there are none.
    #[must_use]
    pub fn mean_of_independent(estimates: impl IntoIterator<Item = Self>) -> Self {
        Self::combine(estimates.into_iter().map(|estimate| (estimate, 1.0)))
    }

    /// The mean of independent estimates of one quantity with weights 1/error², which has the
    /// smallest error; NaN if there are none.
    ///
    /// If the errors are uncertain, as from few blocks, the resulting error is too small; use
    /// [`mean_of_independent`](Self::mean_of_independent) then. An error of zero gives NaN.
    #[must_use]
    pub fn weighted_mean_of_independent(estimates: impl IntoIterator<Item = Self>) -> Self {
        let weigh = |estimate: Self| (estimate, 1.0 / (estimate.standard_error * estimate.standard_error));
        Self::combine(estimates.into_iter().map(weigh))
    }

    fn combine(weighted: impl Iterator<Item = (Self, f64)>) -> Self {
        let (mut weights, mut sum, mut squared) = (0.0, 0.0, 0.0);
        for (estimate, weight) in weighted {
            weights += weight;
            sum += weight * estimate.mean;
            squared += (weight * estimate.standard_error) * (weight * estimate.standard_error);
        }
        Self::new(sum / weights, squared.sqrt() / weights)
    }

    /// Deviation from an exact `value` in standard errors, with sign; ±∞ or NaN if the error is
    /// zero.
    #[must_use]
    pub fn deviation_from(&self, value: f64) -> f64 {
        (self.mean - value) / self.standard_error
    }
}

impl Neg for Estimate {
    type Output = Self;
    fn neg(self) -> Self {
        Self::new(-self.mean, self.standard_error)
    }
}

/// Sum with an exact number.
impl Add<f64> for Estimate {
    type Output = Self;
    fn add(self, exact: f64) -> Self {
        Self::new(self.mean + exact, self.standard_error)
    }
}

/// Difference to an exact number.
impl Sub<f64> for Estimate {
    type Output = Self;
    fn sub(self, exact: f64) -> Self {
        Self::new(self.mean - exact, self.standard_error)
    }
}

/// Product with an exact number.
impl Mul<f64> for Estimate {
    type Output = Self;
    fn mul(self, exact: f64) -> Self {
        Self::new(self.mean * exact, self.standard_error * exact.abs())
    }
}

/// Ratio to an exact number.
impl Div<f64> for Estimate {
    type Output = Self;
    fn div(self, exact: f64) -> Self {
        Self::new(self.mean / exact, self.standard_error / exact.abs())
    }
}

/// Sum with an exact number.
impl Add<Estimate> for f64 {
    type Output = Estimate;
    fn add(self, estimate: Estimate) -> Estimate {
        estimate + self
    }
}

/// Difference of an exact number and an estimate.
impl Sub<Estimate> for f64 {
    type Output = Estimate;
    fn sub(self, estimate: Estimate) -> Estimate {
        -estimate + self
    }
}

/// Product with an exact number.
impl Mul<Estimate> for f64 {
    type Output = Estimate;
    fn mul(self, estimate: Estimate) -> Estimate {
        estimate * self
    }
}

impl fmt::Display for Estimate {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let &Self { mean, standard_error: error } = self;
        let text = if error.is_finite() && error > 0.0 {
            // Scientific notation rounds to two figures and gives their power of ten, so 0.0996
            // becomes 0.10 and not 0.100.
            let scientific = format!("{error:.1e}");
            let (digits, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
            match exponent.parse::<usize>() {
                Ok(0) => format!("{mean:.1}({digits})"),
                Ok(_) => format!("{mean:.0}({error:.0})"),
                Err(_) => {
                    // Negative exponent: the last figure is 1 + |exponent| places after the decimal
                    // point.
                    let places = exponent.trim_start_matches('-').parse::<usize>().unwrap_or(0) + 1;
                    format!("{mean:.places$}({})", digits.replace('.', ""))
                }
            }
        } else {
            format!("{mean}({error})")
        };
        // The precision is ignored, because it would cut off the text; width and alignment are
        // used.
        if formatter.precision().is_some() { formatter.write_str(&text) } else { formatter.pad(&text) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Combine = fn(Estimate, Estimate) -> Estimate;

    /// The scatter of combinations of two normal numbers is their claimed error.
    #[test]
    fn errors_of_combinations_are_their_scatter() {
        const TRIALS: usize = 20_000;
        let noise = crate::statistics::test_series::autoregressive(0.0, 2 * TRIALS, 11);
        let (first, second) = (Estimate::new(3.0, 0.05), Estimate::new(-2.0, 0.04));
        let combinations: [(&str, Combine); 8] = [
            ("sum", Estimate::plus_independent),
            ("difference", Estimate::minus_independent),
            ("product", Estimate::times_independent),
            ("ratio", Estimate::over_independent),
            ("mean", |one, other| Estimate::mean_of_independent([one, -other, one])),
            ("weighted mean", |one, other| Estimate::weighted_mean_of_independent([one, other])),
            ("linear", |one, _| 7.0 - 2.0 * (one - 1.0) / -4.0),
            ("line", |_, other| -(other * 3.0) + 2.0),
        ];
        for (name, combine) in combinations {
            let claimed = combine(first, second);
            let (mut sum, mut square) = (0.0, 0.0);
            for noise in noise.chunks_exact(2) {
                let value = combine(
                    Estimate::new(first.mean + noise[0] * first.standard_error, first.standard_error),
                    Estimate::new(second.mean + noise[1] * second.standard_error, second.standard_error),
                );
                let off = value.mean - claimed.mean;
                (sum, square) = (sum + off, square + off * off);
            }
            let mean = sum / TRIALS as f64;
            let scatter = (square / TRIALS as f64 - mean * mean).sqrt();
            let ratio = scatter / claimed.standard_error;
            // Two of the three in the mean are the same number, so that one is not independent.
            let expected = if name == "mean" {
                let (one, other) = (first.standard_error, second.standard_error);
                (2.0 * one).hypot(other) / (2.0 * one * one + other * other).sqrt()
            } else {
                1.0
            };
            // The scatter has an error of 1/√(2 · 20 000) = 0.5 %; four of these, and 0.1 % for the
            // second order.
            assert!((ratio / expected - 1.0).abs() < 0.021, "{name}: {ratio} instead of {expected}");
        }
        assert!(Estimate::mean_of_independent([]).mean.is_nan());
        assert_eq!(Estimate::exact(2.0).plus_independent(Estimate::exact(1.0)), Estimate::new(3.0, 0.0));
        assert_eq!(Estimate::new(2.0, 0.5) * -2.0, Estimate::new(-4.0, 1.0));
    }

    #[test]
    fn uncertainty_is_printed_in_the_last_places() {
        for (mean, error, text) in [
            (1.0, 0.0996, "1.00(10)"),
            (-1.23456, 0.000_99, "-1.23456(99)"),
            (0.0, 0.5, "0.00(50)"),
            (12_345.6, 234.0, "12346(234)"),
            (12_345.6, 14.4, "12346(14)"),
            (9.0, 9.96, "9(10)"),
            (1.5, f64::NAN, "1.5(NaN)"),
            (f64::NAN, f64::NAN, "NaN(NaN)"),
        ] {
            assert_eq!(Estimate::new(mean, error).to_string(), text);
        }
        assert_eq!(format!("{:>12}|", Estimate::new(42.98131, 0.0137)), "  42.981(14)|");
        assert_eq!(format!("{:.2}", Estimate::new(42.98131, 0.0137)), "42.981(14)");
    }
}
