//! Whether the program said so: warnings and typed errors by name.

use gradient_mc::drive::Scheme;
use gradient_mc::{Error, Field, Simulation, TemperatureProfile, Warning};
use std::fmt::{Debug, Display};

/// A warning or an error.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Said {
    /// The variant, such as `NotMixed`.
    pub(crate) name: String,
    /// The whole line.
    pub(crate) text: String,
}

impl Said {
    /// Of anything whose `Debug` begins with the name of its variant.
    fn new(what: &(impl Debug + Display)) -> Self {
        let name = format!("{what:?}");
        let name = name.split([' ', '(', '{']).next().unwrap_or_default().to_owned();
        Self { name, text: what.to_string() }
    }

    pub(crate) fn error(error: &Error) -> Self {
        let Self { name, text } = Self::new(error);
        Self { name: format!("Error::{name}"), text }
    }

    pub(crate) fn warnings(warnings: &[Warning]) -> Vec<Self> {
        warnings.iter().map(Self::new).collect()
    }
}

/// What a simulation says after its run.
pub(crate) fn by<F: Field, T: TemperatureProfile, S: Scheme<F, T>>(
    simulation: &Simulation<F, T, S>,
) -> Vec<Said> {
    Said::warnings(&simulation.warnings())
}
