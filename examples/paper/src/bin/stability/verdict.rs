//! What becomes of a method at one point of a map: judged from numbers, by one rule for all maps.

use gradient_mc::statistics::Estimate;

/// A number that a method gave, against the true one.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
pub(crate) struct Quantity {
    pub(crate) name: String,
    /// Measured over true, less 1; the difference where the true one is zero. With the error bar
    /// that the method itself claims.
    pub(crate) error: Estimate,
    /// How well the true one is known.
    pub(crate) truth_error: f64,
    /// Errors up to this are not held against a method.
    pub(crate) tolerance: f64,
    /// A method that does not know its number to this has not done its work.
    pub(crate) largest_error_bar: f64,
    /// What the error was before the first sweep, where that says something.
    pub(crate) start: Option<f64>,
    /// Second half of the production less the first.
    pub(crate) drift: Option<Estimate>,
}

/// What became of a method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
pub(crate) enum Outcome {
    /// Within the tolerance or four error bars, and the error bar small enough.
    Right,
    /// Still on its way from the start to the truth, or with an error bar that is too large.
    Slow,
    /// Off by more, and not on its way.
    Wrong,
    /// Where it started, or a chain that does not get ahead.
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
    /// `measured` against `truth`, relative to the latter.
    pub(crate) fn relative(name: &str, measured: Estimate, truth: f64) -> Self {
        let error = measured / truth - 1.0;
        Self::absolute(name, error)
    }

    /// A number that ought to be zero.
    pub(crate) fn absolute(name: &str, error: Estimate) -> Self {
        let (tolerance, largest_error_bar) = (0.005, 0.01);
        let name = name.to_owned();
        Self { name, error, truth_error: 0.0, tolerance, largest_error_bar, start: None, drift: None }
    }

    pub(crate) fn tolerating(mut self, tolerance: f64, largest_error_bar: f64) -> Self {
        (self.tolerance, self.largest_error_bar) = (tolerance, largest_error_bar);
        self
    }

    /// Whether the number is off: beyond the tolerance and beyond what its own error bar allows
    /// for.
    pub(crate) fn is_off(&self) -> bool {
        let claimed = self.error.standard_error.hypot(self.truth_error);
        // An error bar that is not a number allows for nothing.
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
