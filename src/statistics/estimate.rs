//! A number with its error bar.

use std::fmt;

/// A mean and its standard error (one standard deviation of the mean).
///
/// Printed as value(uncertainty), the uncertainty with two figures in units of the last place:
///
/// ```
/// use gradient_mc::statistics::Estimate;
/// assert_eq!(Estimate::new(42.98131, 0.0137).to_string(), "42.981(14)");
/// assert_eq!(Estimate::new(42.98131, 2.34).to_string(), "43.0(2.3)");
/// assert_eq!(Estimate::new(42.98131, 0.0).to_string(), "42.98131(0)");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Estimate {
    /// The estimated value.
    pub mean: f64,
    /// Its standard error.
    pub standard_error: f64,
}

impl Estimate {
    /// A value with its standard error.
    #[must_use]
    pub fn new(mean: f64, standard_error: f64) -> Self {
        Self { mean, standard_error }
    }

    /// Standard errors between this and an exact `value`, with sign; ±∞ or NaN if the error is zero.
    #[must_use]
    pub fn deviation_from(&self, value: f64) -> f64 {
        (self.mean - value) / self.standard_error
    }
}

impl fmt::Display for Estimate {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let &Self { mean, standard_error: error } = self;
        let text = if error.is_finite() && error > 0.0 {
            // The formatter rounds to two figures and says which power of ten they begin at, so that
            // 0.0996 becomes 0.10 and not 0.100.
            let scientific = format!("{error:.1e}");
            let (digits, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
            match exponent.parse::<usize>() {
                Ok(0) => format!("{mean:.1}({digits})"),
                Ok(_) => format!("{mean:.0}({error:.0})"),
                Err(_) => {
                    // Negative: the figures stand 1 + |exponent| places behind the point.
                    let places = exponent.trim_start_matches('-').parse::<usize>().unwrap_or(0) + 1;
                    format!("{mean:.places$}({})", digits.replace('.', ""))
                }
            }
        } else {
            format!("{mean}({error})")
        };
        // A precision would cut the text off; width and alignment are obeyed.
        if formatter.precision().is_some() { formatter.write_str(&text) } else { formatter.pad(&text) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
