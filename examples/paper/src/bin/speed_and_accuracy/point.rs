//! A point of the chart: a method for n(x) and P(x) with its CPU time and errors.

use crate::method::Method;
use crate::profile::Errors;
use crate::reference::Reference;

/// The method of a point.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Way {
    /// A theory by its name; `walls` is whether it includes the walls.
    Theory { name: String, walls: bool },
    /// A simulation, as the mean of simultaneous replicas, one on each thread.
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
    /// The estimated errors of the result, if it has any; root mean squares too.
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
    /// A result is over-confident if its true error exceeds the estimated one by this factor.
    const FACTOR: f64 = 2.0;

    /// Whether the true error is more than twice the estimated one, allowing for the error of the
    /// reference.
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

    /// Name of the method, without the number of sweeps.
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
