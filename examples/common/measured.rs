//! A number and its standard error, printed with the digits that mean something.

use std::fmt;

/// A mean with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Measured {
    pub(crate) value: f64,
    pub(crate) error: f64,
}

impl Measured {
    pub(crate) fn new(value: f64, error: f64) -> Self {
        Self { value, error }
    }

    /// Mean of independent equally good values, with the error from their scatter (infinite for one).
    pub(crate) fn from_independent(values: &[f64]) -> Self {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
        let error = if values.len() > 1 { (squares / (count * (count - 1.0))).sqrt() } else { f64::INFINITY };
        Self { value: mean, error }
    }

    /// The same in other units.
    pub(crate) fn scaled(self, factor: f64) -> Self {
        Self { value: self.value * factor, error: self.error * factor.abs() }
    }

    /// How many standard errors away from `expected`.
    pub(crate) fn sigmas_from(self, expected: f64) -> f64 {
        (self.value - expected) / self.error
    }
}

impl fmt::Display for Measured {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { value, error } = *self;
        if !error.is_finite() {
            return formatter.pad(&format!("{value:.4} ± ?"));
        }
        // Two digits of the error, one of them when it starts with more than 3.
        let mut decimals = 0;
        let mut scaled = error.abs();
        while scaled > 0.0 && scaled < 3.0 && decimals < 9 {
            scaled *= 10.0;
            decimals += 1;
        }
        formatter.pad(&format!("{value:.decimals$} ± {error:.decimals$}"))
    }
}
