//! Warnings and typed errors of a run, by name.

use gradient_mc::drive::Scheme;
use gradient_mc::{Error, Field, Simulation, TemperatureProfile, Warning};

/// A warning or an error.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) struct Said {
    /// The variant, such as `NotMixed`.
    pub(crate) name: String,
    /// The complete text.
    pub(crate) text: String,
}

impl Said {
    pub(crate) fn error(error: &Error) -> Self {
        // `Debug` begins with the name of the variant.
        let name = format!("{error:?}");
        let name = name.split([' ', '(', '{']).next().unwrap_or_default();
        Self { name: format!("Error::{name}"), text: error.to_string() }
    }

    pub(crate) fn warnings(warnings: &[Warning]) -> Vec<Self> {
        let said =
            |warning: &Warning| Self { name: format!("{:?}", warning.kind()), text: warning.to_string() };
        warnings.iter().map(said).collect()
    }
}

/// The warnings of a simulation after its run.
pub(crate) fn by<F: Field, T: TemperatureProfile, S: Scheme<F, T>>(
    simulation: &Simulation<F, T, S>,
) -> Vec<Said> {
    Said::warnings(&simulation.warnings())
}
