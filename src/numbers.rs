//! Checks of parameters, and the format of numbers in messages.

use crate::Error;

impl Error {
    /// Fails with [`Error::InvalidParameter`] unless `value` is finite and positive.
    pub(crate) fn require_positive(name: &'static str, value: f64) -> Result<f64, Self> {
        if value.is_finite() && value > 0.0 {
            Ok(value)
        } else {
            Err(Self::InvalidParameter { name, value, requirement: "it must be positive and finite" })
        }
    }

    /// Fails with [`Error::InvalidParameter`] unless `value` lies between 0 and 1, both excluded.
    pub(crate) fn require_tolerance(name: &'static str, value: f64) -> Result<f64, Self> {
        if value > 0.0 && value < 1.0 {
            Ok(value)
        } else {
            let requirement = "it must lie between 0 and 1, both excluded";
            Err(Self::InvalidParameter { name, value, requirement })
        }
    }

    /// Fails with [`Error::InvalidParameter`] unless `value` is finite.
    pub(crate) fn require_finite(name: &'static str, value: f64) -> Result<f64, Self> {
        if value.is_finite() {
            Ok(value)
        } else {
            Err(Self::InvalidParameter { name, value, requirement: "it must be finite" })
        }
    }
}

/// A number as printed in messages: with a power of ten if it would have many zeros, in full
/// otherwise.
pub(crate) fn figures(value: f64) -> String {
    let magnitude = value.abs();
    if value == 0.0 || !value.is_finite() || (1e-5..1e16).contains(&magnitude) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}
