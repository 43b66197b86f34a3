//! The reduced potential of a column.

use super::grid::Grid;
use crate::legendre::{Legendre, ORDER, evaluate};
use crate::{Error, Field, TemperatureProfile, Wall};

/// u(x) at the nodes of a grid: φ/T if T is constant, otherwise the effective potential of the
/// density.
#[derive(Debug, Clone)]
pub(super) struct Potential {
    /// u itself if it does not depend on the density.
    fixed: Option<Vec<f64>>,
    /// a, 1/T and T'/T² at the nodes.
    accelerations: Vec<f64>,
    coldness: Vec<f64>,
    gradients: Vec<f64>,
    /// u at the lower end.
    lowest: f64,
    open_end: Wall,
    /// Pressure over number density at the open end.
    ratio: f64,
}

impl Potential {
    /// `ratio` is pressure over number density at the `open_end`: T at a wall.
    ///
    /// # Errors
    /// [`Error::InvalidField`] and [`Error::InvalidTemperature`].
    pub(super) fn new<F: Field, T: TemperatureProfile>(
        field: &F,
        temperature: &T,
        constant: Option<f64>,
        grid: &Grid,
        open_end: Wall,
        ratio: f64,
    ) -> Result<Self, Error> {
        let mut potential = Self {
            fixed: None,
            accelerations: Vec::new(),
            coldness: Vec::new(),
            gradients: Vec::new(),
            lowest: 0.0,
            open_end,
            ratio,
        };
        let value = |height: f64| {
            let (energy, temperature) =
                (field.potential(height), constant.unwrap_or_else(|| temperature.temperature(height)));
            if !(temperature > 0.0 && temperature.is_finite()) {
                return Err(Error::InvalidTemperature { height, temperature });
            }
            if !energy.is_finite() {
                return Err(Error::InvalidField {
                    height,
                    acceleration: field.acceleration(height),
                    potential: energy,
                });
            }
            Ok(energy / temperature)
        };
        potential.lowest = value(grid.ends()[0])?;
        let values: Result<Vec<f64>, Error> = grid.nodes.iter().map(|&height| value(height)).collect();
        let values = values?;
        for &height in &grid.nodes {
            let acceleration = field.acceleration(height);
            if !acceleration.is_finite() {
                return Err(Error::InvalidField { height, acceleration, potential: field.potential(height) });
            }
            potential.accelerations.push(acceleration);
        }
        if constant.is_some() {
            potential.fixed = Some(values);
        } else {
            potential.coldness =
                grid.nodes.iter().map(|&height| 1.0 / temperature.temperature(height)).collect();
            let slopes = grid.nodes.iter().map(|&height| temperature.logarithmic_gradient(height));
            potential.gradients =
                slopes.zip(&potential.coldness).map(|(slope, coldness)| slope * coldness).collect();
        }
        Ok(potential)
    }

    /// The weight per area of the spheres between each node and the open end, plus the pressure
    /// there.
    pub(super) fn weights(&self, rule: &Legendre, grid: &Grid, densities: &[f64]) -> Vec<f64> {
        let mut weights = vec![0.0; densities.len()];
        let panels = grid.panels().len();
        let end = |panel: usize, t: f64| evaluate(&rule.coefficients(&Grid::values(panel, densities)), t);
        let (order, mut sum): (Vec<usize>, f64) = match self.open_end {
            Wall::Lid => ((0..panels).rev().collect(), self.ratio * end(panels - 1, 1.0)),
            Wall::Base => ((0..panels).collect(), self.ratio * end(0, -1.0)),
        };
        let halves: Vec<f64> = grid.panels().map(|[start, end]| 0.5 * (end - start)).collect();
        for panel in order {
            let pulls = std::array::from_fn(|node| {
                let node = panel * ORDER + node;
                densities[node] * self.accelerations[node]
            });
            let (whole, below) = (rule.integrate(&pulls), rule.integrate_to_nodes(&pulls));
            for (node, below) in below.into_iter().enumerate() {
                let part = match self.open_end {
                    Wall::Lid => whole - below,
                    Wall::Base => -below,
                };
                weights[panel * ORDER + node] = sum + halves[panel] * part;
            }
            sum += match self.open_end {
                Wall::Lid => halves[panel] * whole,
                Wall::Base => -halves[panel] * whole,
            };
        }
        weights
    }

    /// u at the nodes, by u' = a/T + (W/n) T'/T².
    pub(super) fn values(&self, rule: &Legendre, grid: &Grid, densities: &[f64]) -> Vec<f64> {
        if let Some(fixed) = &self.fixed {
            return fixed.clone();
        }
        let weights = self.weights(rule, grid, densities);
        let mut values = vec![0.0; densities.len()];
        let mut sum = self.lowest;
        for (panel, [start, end]) in grid.panels().enumerate() {
            let slopes = std::array::from_fn(|node| {
                let node = panel * ORDER + node;
                self.accelerations[node] * self.coldness[node]
                    + weights[node] / densities[node] * self.gradients[node]
            });
            let half = 0.5 * (end - start);
            for (node, rise) in rule.integrate_to_nodes(&slopes).into_iter().enumerate() {
                values[panel * ORDER + node] = sum + half * rise;
            }
            sum += half * rule.integrate(&slopes);
        }
        values
    }
}
