//! Hanging columns, solved as their mirror images.
//!
//! The march goes from the dense end to the thin one. A column that hangs from its lid is solved as
//! its mirror image, which stands on its base.

use super::HydrostaticProfile;
use super::march::Panel;
use super::profile::DomainExit;
use crate::equation_of_state::packing_fraction;
use crate::field::{END_MARGIN, acceleration_below};
use crate::legendre::{Series, evaluate};
use crate::{Error, Field, TemperatureProfile};

/// A field or temperature, mirrored about the middle of two heights.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mirrored<P> {
    pub(super) inner: P,
    pub(super) base: f64,
    pub(super) lid: f64,
}

impl<P> Mirrored<P> {
    fn height(&self, height: f64) -> f64 {
        (self.base + self.lid - height).clamp(self.base, self.lid)
    }
}

impl<F: Field> Field for Mirrored<F> {
    fn potential(&self, height: f64) -> f64 {
        self.inner.potential(self.height(height))
    }

    fn acceleration(&self, height: f64) -> f64 {
        -acceleration_below(&self.inner, self.height(height), self.lid)
    }
}

impl<T: TemperatureProfile> TemperatureProfile for Mirrored<T> {
    fn temperature(&self, height: f64) -> f64 {
        self.inner.temperature(self.height(height))
    }

    fn logarithmic_gradient(&self, height: f64) -> f64 {
        -self.inner.logarithmic_gradient(self.height(height).min(self.lid - END_MARGIN).max(self.base))
    }
}

/// The error of the mirror image, whose base and lid lie at heights that add up to `sum`.
pub(super) fn mirrored_error(error: Error, sum: f64) -> Error {
    match error {
        Error::EquationOfStateExhausted { height, reduced_pressure, side } => {
            Error::EquationOfStateExhausted { height: sum - height, reduced_pressure, side }
        }
        Error::HydrostaticsNotConverged { height, residual } => {
            Error::HydrostaticsNotConverged { height: sum - height, residual }
        }
        Error::InvalidField { height, acceleration, potential } => {
            Error::InvalidField { height: sum - height, acceleration: -acceleration, potential }
        }
        Error::InvalidTemperature { height, temperature } => {
            Error::InvalidTemperature { height: sum - height, temperature }
        }
        error => error,
    }
}

impl Panel {
    fn mirrored(mut self, sum: f64, extent: f64) -> Self {
        (self.start, self.end) = (sum - self.end, sum - self.start);
        let turn = |series: &mut Series| {
            // Odd Legendre polynomials change sign.
            series.iter_mut().skip(1).step_by(2).for_each(|coefficient| *coefficient = -*coefficient);
        };
        [&mut self.ln_density, &mut self.ln_pressure, &mut self.density].into_iter().for_each(turn);
        self.edges.reverse();
        self.moment = extent * self.mass - self.moment;
        self
    }
}

impl HydrostaticProfile {
    /// The profile mirrored about the middle of two heights that add up to `sum`.
    pub(super) fn mirrored(self, sum: f64) -> Self {
        let extent = self.top - self.base;
        let lid_pressure = libm::exp(self.ln_base_pressure);
        // The pressure at the thin end, if that has a wall.
        let last = self.panels.last().filter(|_| self.lid_pressure > 0.0);
        let ln_base_pressure = last.map_or(f64::NEG_INFINITY, |panel| evaluate(&panel.ln_pressure, 1.0));
        let at_base = self.panels.last().map_or(0.0, |panel| panel.edges[1]);
        let (mut below, mut above) = (self.above, self.below);
        below.reverse();
        above.reverse();
        let mut panels: Vec<Panel> =
            self.panels.into_iter().map(|panel| panel.mirrored(sum, extent)).collect();
        panels.reverse();
        let domain_exit = self.domain_exit.map(|exit| DomainExit {
            lowest_height: sum - exit.highest_height,
            highest_height: sum - exit.lowest_height,
            ..exit
        });
        Self {
            panels,
            below,
            above,
            base: sum - self.top,
            top: sum - self.base,
            column_density: self.column_density,
            center_of_mass: sum - self.center_of_mass,
            ln_base_pressure,
            base_packing_fraction: packing_fraction(at_base),
            lid_pressure,
            density_maximum: (sum - self.density_maximum.0, self.density_maximum.1),
            domain_exit,
            deviation: self.deviation,
        }
    }
}
