//! Equations of state of hard spheres: Z(η) = P/(nT).
//!
//! To add one, implement [`EquationOfState`] for a type of your own: one method.

use crate::Error;
use crate::numerics::{differentiate, integrate_panel};
use std::f64::consts::PI;

/// Number density n = 6η/π of a packing fraction, in inverse cubic diameters.
#[must_use]
pub fn number_density(packing_fraction: f64) -> f64 {
    packing_fraction * (6.0 / PI)
}

/// Packing fraction η = πn/6 of a number density.
#[must_use]
pub fn packing_fraction(number_density: f64) -> f64 {
    number_density * (PI / 6.0)
}

/// Pressure of hard spheres as a function of packing fraction, through Z(η) = P/(nT).
pub trait EquationOfState {
    /// Compressibility factor Z(η), for `packing_fraction` ≥ 0.
    fn compressibility_factor(&self, packing_fraction: f64) -> f64;

    /// d Z/d ln η; the default differentiates [`compressibility_factor`](Self::compressibility_factor).
    fn compressibility_derivative(&self, packing_fraction: f64) -> f64 {
        let step = 1e-3 * packing_fraction;
        if step == 0.0 {
            return 0.0;
        }
        packing_fraction * differentiate(|eta| self.compressibility_factor(eta), packing_fraction, step)
    }

    /// Excess chemical potential over temperature, Z − 1 + ∫₀^η (Z − 1)/η' dη'; the default
    /// integrates numerically.
    fn excess_chemical_potential(&self, packing_fraction: f64) -> f64 {
        const PANELS: usize = 32;
        if packing_fraction == 0.0 {
            return 0.0;
        }
        let width = packing_fraction / PANELS as f64;
        let integral: f64 = (0..PANELS)
            .map(|panel| {
                let low = panel as f64 * width;
                integrate_panel(|eta| (self.compressibility_factor(eta) - 1.0) / eta, low, low + width)
            })
            .sum();
        self.compressibility_factor(packing_fraction) - 1.0 + integral
    }
}
