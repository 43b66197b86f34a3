//! Where the density is highest inside the column, and the pressure there.

use super::column::Column;
use gradient_mc::observers::{BinState, EquationOfStateProfile};
use gradient_mc::statistics::Estimate;
use nalgebra::{Matrix4, Vector4};
use paper::Failure;

/// A maximum of the measured density.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Maximum {
    /// Of the density.
    pub(crate) height: Estimate,
    /// n there.
    pub(crate) number_density: Estimate,
    /// P β/n where the theory has its maximum: a local equation of state makes it one, since dP/dx
    /// = −n is P d ln T/dx = −βP where n does not change.
    pub(crate) balance: Estimate,
    /// Half the range of heights over which the theory's density is within 0.05 % of its maximum:
    /// as well as can be asked that the place is known.
    pub(crate) flatness: f64,
}

/// Fits a cubic to n over the heights where the theory has it above this part of its maximum.
const WINDOW: f64 = 0.95;
/// What is flat.
const FLAT: f64 = 0.9995;

/// The measured maximum of a column that has one inside.
pub(crate) fn find(column: &Column, profile: &EquationOfStateProfile) -> Result<Option<Maximum>, Failure> {
    let Some(of_theory) = column.maximum() else { return Ok(None) };
    let window = Window::of(column, of_theory, WINDOW);
    // The error of a cubic fit is computed from the theory and subtracted.
    let points: Vec<(f64, f64)> = (0..400)
        .map(|step| window.low + (window.high - window.low) * (f64::from(step) + 0.5) / 400.0)
        .map(|height| (height, column.theory.number_density(height)))
        .collect();
    let bias = window.maximum(&points)[0] - of_theory;
    let values = profile.jackknife(|states| {
        let series = |value: fn(&BinState) -> f64| {
            let inside = states.iter().filter(|state| (window.low..window.high).contains(&state.height));
            inside.map(|state| (state.height, value(state))).collect::<Vec<_>>()
        };
        let densities = series(|state| state.number_density);
        let [height, density] = window.maximum(&densities);
        let balance = column.decay_rate * window.value(&series(|state| state.pressure), of_theory)
            / window.value(&densities, of_theory);
        [height - bias, density, balance]
    })?;
    let flat = Window::of(column, of_theory, FLAT);
    Ok(Some(Maximum {
        height: values[0],
        number_density: values[1],
        balance: values[2],
        flatness: 0.5 * (flat.high - flat.low),
    }))
}

/// The heights of a fit.
#[derive(Debug, Clone, Copy)]
struct Window {
    low: f64,
    high: f64,
}

impl Window {
    /// Around the theory's maximum, where its density is above this part of that.
    fn of(column: &Column, maximum: f64, part: f64) -> Self {
        let least = part * column.theory.number_density(maximum);
        let end = |step: f64| {
            let mut height = maximum;
            while column.theory.number_density(height) > least && height > super::column::LOWEST {
                height += step;
            }
            height
        };
        Self { low: end(-0.1), high: end(0.1) }
    }

    fn scaled(self, height: f64) -> f64 {
        (2.0 * height - self.low - self.high) / (self.high - self.low)
    }

    fn cubic(self, points: &[(f64, f64)]) -> Vector4<f64> {
        let scaled = points.iter().map(|&(height, value)| (self.scaled(height), value));
        cubic(scaled).unwrap_or_else(|| Vector4::repeat(f64::NAN))
    }

    /// The fitted value at a height.
    fn value(self, points: &[(f64, f64)], height: f64) -> f64 {
        at(&self.cubic(points), self.scaled(height))
    }

    /// Height and value of the maximum of the fit; NaN if it has none.
    fn maximum(self, points: &[(f64, f64)]) -> [f64; 2] {
        let fit = self.cubic(points);
        // The root of the slope where the curve bends down, in the form that is stable without a cubic
        // term.
        let (slope, bend, twist) = (fit[1], 2.0 * fit[2], 3.0 * fit[3]);
        let place = -2.0 * slope / (bend - (bend * bend - 4.0 * twist * slope).sqrt());
        let height = f64::midpoint(self.low, self.high) + 0.5 * (self.high - self.low) * place;
        [height, at(&fit, place)]
    }
}

fn at(fit: &Vector4<f64>, u: f64) -> f64 {
    fit[0] + u * (fit[1] + u * (fit[2] + u * fit[3]))
}

/// Least squares by c₀ + c₁u + c₂u² + c₃u³.
fn cubic(points: impl Iterator<Item = (f64, f64)>) -> Option<Vector4<f64>> {
    let (mut matrix, mut right) = (Matrix4::zeros(), Vector4::zeros());
    for (u, value) in points {
        let powers = Vector4::new(1.0, u, u * u, u * u * u);
        matrix += powers * powers.transpose();
        right += powers * value;
    }
    Some(matrix.try_inverse()? * right)
}
