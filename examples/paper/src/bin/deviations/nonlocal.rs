//! Deviation of any local equation of state where the density changes within a diameter, to lowest
//! order in the density.
//!
//! In a stationary isothermal system ln n + φ/T + ∫ n(x + r) d³r over the unit sphere of neighbors
//! is constant to first order in n (second virial coefficient). Forces then hold up P/T = n − ∫ₓ n
//! (w∗n)' dx' with w(s) = π(1 − s²), where a local equation has n + (2π/3) n². The difference has
//! the sign of n'': negative below the surface of a column, positive in its tail. In a temperature
//! gradient the same holds for the isothermal system in the effective field, with `P_iso`/T₀ = P/T.

use super::case::Case;
use gradient_mc::equation_of_state::{EquationOfState, FluidSolid, packing_fraction};

/// The correction of a column, on a grid of heights.
#[derive(Debug, Clone)]
pub(crate) struct Nonlocal {
    lowest: f64,
    /// P/T minus that of the local equation, and P/T of the local equation.
    values: Vec<[f64; 2]>,
}

const STEP: f64 = 0.02;
/// Steps in a diameter.
const REACH: usize = 50;

impl Nonlocal {
    /// From the theory's profile, over the range that is compared.
    pub(crate) fn of(case: &Case) -> Self {
        // High enough that the deviation is negligible above.
        let (lowest, highest) = (case.lowest(), case.highest() + 10.0);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let count = ((highest - lowest) / STEP) as usize;
        let height = |index: usize| lowest + STEP * (index as f64 - REACH as f64);
        let densities: Vec<f64> =
            (0..count + 2 * REACH).map(|index| case.theory.number_density(height(index))).collect();
        let weights: Vec<f64> = (0..=2 * REACH)
            .map(|index| (index as f64 - REACH as f64) / REACH as f64)
            .map(|distance| std::f64::consts::PI * (1.0 - distance * distance) * STEP)
            .collect();
        let neighbors: Vec<f64> = densities
            .windows(weights.len())
            .map(|window| window.iter().zip(&weights).map(|(density, weight)| density * weight).sum())
            .collect();
        let densities = &densities[REACH..REACH + neighbors.len()];
        let mut values = vec![[0.0; 2]; neighbors.len()];
        let mut held = 0.0;
        for index in (0..neighbors.len()).rev() {
            if index + 1 < neighbors.len() {
                let density = f64::midpoint(densities[index], densities[index + 1]);
                held += density * (neighbors[index] - neighbors[index + 1]);
            }
            let density = densities[index];
            let factor = FluidSolid::default().compressibility_factor(packing_fraction(density));
            let local = 2.0 * std::f64::consts::FRAC_PI_3 * density * density;
            values[index] = [held - local, density * factor];
        }
        Self { lowest, values }
    }

    /// Predicted P/(nTZ) − 1 of a range of heights.
    pub(crate) fn over(&self, [low, high]: [f64; 2]) -> f64 {
        let heights = (0..self.values.len()).map(|index| self.lowest + STEP * index as f64);
        let inside = heights.zip(&self.values).filter(|(height, _)| (low..high).contains(height));
        let (beyond, local) =
            inside.fold((0.0, 0.0), |(beyond, local), (_, value)| (beyond + value[0], local + value[1]));
        beyond / local
    }
}
