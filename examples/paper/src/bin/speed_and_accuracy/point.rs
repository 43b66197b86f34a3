//! A point of the chart: a way to get n(x) and P(x), what it costs and how good it is.

use crate::method::Method;
use crate::profile::Errors;
use crate::reference::Reference;

/// What made a point.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Way {
    /// A theory by its name; whether it is told of the walls.
    Theory { name: String, walls: bool },
    /// A simulation; so many replicas at the same time, one on each thread, and their mean.
    Simulation { method: Method, threads: usize, sweeps: u64 },
}

/// A point.
#[derive(Debug, Clone)]
pub(crate) struct Point {
    pub(crate) way: Way,
    /// CPU seconds of the thread that took longest.
    pub(crate) seconds: f64,
    /// The true errors: root mean squares over replicas.
    pub(crate) errors: Errors,
    /// What the result says of its own errors, if it says anything; root mean squares too.
    pub(crate) claims: Option<Errors>,
}

/// What is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Quantity {
    Density,
    Pressure,
}

impl Quantity {
    pub(crate) const BOTH: [Self; 2] = [Self::Density, Self::Pressure];

    pub(crate) fn of(self, errors: &Errors) -> f64 {
        match self {
            Self::Density => errors.misplaced,
            Self::Pressure => errors.pressure,
        }
    }

    pub(crate) fn symbol(self) -> &'static str {
        match self {
            Self::Density => "n(x)",
            Self::Pressure => "P(x)",
        }
    }

    pub(crate) fn label(self) -> &'static str {
        match self {
            Self::Density => "total variation distance",
            Self::Pressure => "largest error of P over P at the base",
        }
    }
}

impl Point {
    /// A true error above so many times the claimed one is over-confident.
    const FACTOR: f64 = 2.0;

    /// Whether the true error is more than twice what is claimed; what the reference does not know
    /// is not held against it.
    pub(crate) fn is_over_confident(&self, quantity: Quantity, reference: &Reference) -> bool {
        self.claims.as_ref().is_some_and(|claims| {
            let known = quantity.of(claims).hypot(quantity.of(&reference.errors));
            quantity.of(&self.errors) > Self::FACTOR * known
        })
    }

    /// Whether the point is of a simulation on one thread.
    pub(crate) fn simulation(&self, threads: usize) -> Option<(Method, u64)> {
        match self.way {
            Way::Simulation { method, threads: own, sweeps } if own == threads => Some((method, sweeps)),
            _ => None,
        }
    }

    pub(crate) fn is_theory(&self) -> bool {
        matches!(self.way, Way::Theory { .. })
    }

    /// What made it, in words, without the number of sweeps.
    pub(crate) fn name(&self) -> String {
        match &self.way {
            Way::Theory { name, walls: false } => name.clone(),
            Way::Theory { name, walls: true } => format!("{name}, between walls"),
            Way::Simulation { method, threads: 1, .. } => method.to_string(),
            Way::Simulation { method, threads, .. } => format!("{method}, {threads} threads"),
        }
    }

    pub(crate) fn threads(&self) -> usize {
        match self.way {
            Way::Theory { .. } => 1,
            Way::Simulation { threads, .. } => threads,
        }
    }

    pub(crate) fn sweeps(&self) -> u64 {
        match self.way {
            Way::Theory { .. } => 0,
            Way::Simulation { sweeps, .. } => sweeps,
        }
    }
}
