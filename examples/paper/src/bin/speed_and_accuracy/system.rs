//! The three systems of Mehrotra, Puri and Khakhar, doi:10.1103/PhysRevE.83.061306.

use gradient_mc::Error;
use gradient_mc::field::ExponentialField;
use gradient_mc::temperature::ExponentialTemperature;

/// One of the three: a = exp(αx), T = T₀ exp(−βx), 40 spheres per area, 400 high.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum System {
    Isothermal,
    VaryingField,
    VaryingTemperature,
}

impl System {
    pub(crate) const ALL: [Self; 3] = [Self::Isothermal, Self::VaryingField, Self::VaryingTemperature];

    /// T₀, in m g d.
    pub(crate) fn base_temperature(self) -> f64 {
        match self {
            Self::Isothermal => 15.0,
            Self::VaryingField | Self::VaryingTemperature => 20.0,
        }
    }

    /// α, per diameter.
    pub(crate) fn field_rate(self) -> f64 {
        if self == Self::VaryingField { 0.02 } else { 0.0 }
    }

    /// β, per diameter.
    pub(crate) fn temperature_decay(self) -> f64 {
        if self == Self::VaryingTemperature { 0.02 } else { 0.0 }
    }

    /// Name of the files.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Isothermal => "isothermal",
            Self::VaryingField => "varying_field",
            Self::VaryingTemperature => "varying_temperature",
        }
    }

    pub(crate) fn title(self) -> String {
        let temperature = self.base_temperature();
        match self {
            Self::Isothermal => format!("(a) T = {temperature}"),
            Self::VaryingField => format!("(b) T = {temperature}, a = exp({} x)", self.field_rate()),
            Self::VaryingTemperature => format!("(c) T = {temperature} exp(−{} x)", self.temperature_decay()),
        }
    }

    pub(crate) fn field(self) -> Result<ExponentialField, Error> {
        ExponentialField::new(self.field_rate())
    }

    pub(crate) fn temperature(self) -> Result<ExponentialTemperature, Error> {
        ExponentialTemperature::new(self.base_temperature(), self.temperature_decay())
    }
}
