//! The result of a method at one point of a map, judged by the same rule for all maps.

use gradient_mc::statistics::Estimate;

/// A measured number compared with its reference.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
pub(crate) struct Quantity {
    pub(crate) name: String,
    /// Measured over reference, minus 1, or the difference if the reference is zero, with the
    /// estimated error bar.
    pub(crate) error: Estimate,
    /// Error of the reference.
    pub(crate) truth_error: f64,
    /// Largest acceptable error.
    pub(crate) tolerance: f64,
    /// Largest acceptable error bar.
    pub(crate) largest_error_bar: f64,
    /// Error before the first sweep, if it is useful.
    pub(crate) start: Option<f64>,
    /// Mean of the second half of production minus that of the first half.
    pub(crate) drift: Option<Estimate>,
}

/// The result of a method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub(crate) enum Outcome {
    /// Within the tolerance or four error bars, and the error bar small enough.
    Right,
    /// Still relaxing from the start to the reference, or with too large an error bar.
    Slow,
    /// Wrong by more, and not relaxing.
    Wrong,
    /// Still at the start, or a chain that does not advance.
    Stuck,
    /// No number: a typed error, or NaN.
    Refused,
}

impl Outcome {
    pub(crate) const ALL: [Self; 5] = [Self::Right, Self::Slow, Self::Wrong, Self::Stuck, Self::Refused];

    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Slow => "slow",
            Self::Wrong => "wrong",
            Self::Stuck => "stuck",
            Self::Refused => "refused",
        }
    }
}

impl Quantity {
    /// Relative deviation of `measured` from `truth`.
    pub(crate) fn relative(name: &str, measured: Estimate, truth: f64) -> Self {
        let error = measured / truth - 1.0;
        Self::absolute(name, error)
    }

    /// Deviation of a number from zero.
    pub(crate) fn absolute(name: &str, error: Estimate) -> Self {
        let (tolerance, largest_error_bar) = (0.005, 0.01);
        let name = name.to_owned();
        Self { name, error, truth_error: 0.0, tolerance, largest_error_bar, start: None, drift: None }
    }

    pub(crate) fn tolerating(mut self, tolerance: f64, largest_error_bar: f64) -> Self {
        (self.tolerance, self.largest_error_bar) = (tolerance, largest_error_bar);
        self
    }

    /// Whether the number is wrong: beyond the tolerance and beyond four error bars.
    pub(crate) fn is_off(&self) -> bool {
        let claimed = self.error.standard_error.hypot(self.truth_error);
        // An error bar of NaN counts as zero.
        let allowed = if claimed.is_finite() { (4.0 * claimed).max(self.tolerance) } else { self.tolerance };
        self.error.mean.abs() > allowed
    }

    /// The rule.
    pub(crate) fn judge(&self) -> Outcome {
        let error = self.error.mean;
        if !error.is_finite() {
            return Outcome::Refused;
        }
        if self.is_off() {
            // Of the way from the start to the truth.
            let progress =
                self.start.filter(|start| start.abs() > self.tolerance).map(|start| 1.0 - error / start);
            let approaches = self.drift.is_some_and(|drift| {
                drift.mean * error < 0.0 && drift.mean.abs() > 4.0 * drift.standard_error
            });
            return match progress {
                Some(progress) if progress.abs() < 0.1 => Outcome::Stuck,
                Some(progress) if progress > 0.0 && approaches => Outcome::Slow,
                _ => Outcome::Wrong,
            };
        }
        if self.error.standard_error <= self.largest_error_bar { Outcome::Right } else { Outcome::Slow }
    }
}
