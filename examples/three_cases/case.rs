//! The three cases: field, temperature and names of each.

use super::measurement::{Replica, Task};
use super::protocol::SchemeChoice;
use gradient_mc::drive::{Automatic, EquationOfStateClosure, Instantaneous, SelfConsistent};
use gradient_mc::field::{ExponentialField, UniformField};
use gradient_mc::temperature::{ExponentialTemperature, Isothermal};
use gradient_mc::{Error, Field, Scene, TemperatureProfile};
use paper::Failure;

/// One of the three systems of the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Case {
    Isothermal,
    VaryingField,
    VaryingTemperature,
}

impl Case {
    pub(crate) const ALL: [Self; 3] = [Self::Isothermal, Self::VaryingField, Self::VaryingTemperature];

    /// Temperature T₀ at the base, in m g d.
    fn base_temperature(self) -> f64 {
        match self {
            Self::Isothermal => 15.0,
            Self::VaryingField | Self::VaryingTemperature => 20.0,
        }
    }

    /// α of the field exp(αx), per diameter.
    fn field_rate(self) -> f64 {
        if self == Self::VaryingField { 0.02 } else { 0.0 }
    }

    /// β of the temperature T₀ exp(−βx), per diameter.
    fn temperature_decay(self) -> f64 {
        if self == Self::VaryingTemperature { 0.02 } else { 0.0 }
    }

    /// Name of the output files.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Isothermal => "isothermal",
            Self::VaryingField => "varying_field",
            Self::VaryingTemperature => "varying_temperature",
        }
    }

    /// Head of the column in the table.
    pub(crate) fn head(self) -> String {
        let temperature = self.base_temperature();
        match self {
            Self::Isothermal => format!("(a) T = {temperature}"),
            Self::VaryingField => format!("(b) T = {temperature}, α = {}", self.field_rate()),
            Self::VaryingTemperature => format!("(c) T₀ = {temperature}, β = {}", self.temperature_decay()),
        }
    }

    /// Title of the picture.
    pub(crate) fn title(self) -> String {
        let temperature = self.base_temperature();
        match self {
            Self::Isothermal => format!("Isothermal column in a uniform field: T = {temperature} mgd"),
            Self::VaryingField => format!(
                "Isothermal column in a field that increases with height: T = {temperature} mgd, a = g exp({} x/d)",
                self.field_rate()
            ),
            Self::VaryingTemperature => format!(
                "Temperature that decreases with height in a uniform field: T = {temperature} mgd exp(−{} x/d)",
                self.temperature_decay()
            ),
        }
    }

    pub(crate) fn field(self) -> Result<Box<dyn Field>, Error> {
        Ok(Box::new(ExponentialField::new(self.field_rate())?))
    }

    pub(crate) fn temperature(self) -> Result<Box<dyn TemperatureProfile>, Error> {
        Ok(Box::new(ExponentialTemperature::new(self.base_temperature(), self.temperature_decay())?))
    }

    /// Simulates one replica.
    pub(crate) fn simulate(self, task: Task<'_>) -> Result<Replica, Failure> {
        let slab = task.protocol.slab()?;
        let particles = task.protocol.particles;
        let temperature = self.base_temperature();
        match self {
            Self::Isothermal => {
                let temperature = Isothermal::new(temperature)?;
                task.simulate(Scene::new(slab, particles, UniformField::default(), temperature)?, Automatic)
            }
            Self::VaryingField => {
                let field = ExponentialField::new(self.field_rate())?;
                task.simulate(Scene::new(slab, particles, field, Isothermal::new(temperature)?)?, Automatic)
            }
            Self::VaryingTemperature => {
                let temperature = ExponentialTemperature::new(temperature, self.temperature_decay())?;
                let scene = Scene::new(slab, particles, UniformField::default(), temperature)?;
                match task.protocol.scheme {
                    SchemeChoice::SelfConsistent => task.simulate(scene, SelfConsistent::default()),
                    SchemeChoice::Closure => task.simulate(scene, EquationOfStateClosure::default()),
                    SchemeChoice::Instantaneous => task.simulate(scene, Instantaneous::default().any_moves()),
                }
            }
        }
    }
}
