//! Moments over spheres as sums over nodes, exact for polynomials on the panels.

use super::RADIUS;
use super::grid::Grid;
use crate::legendre::{Legendre, ORDER, polynomials};

/// Weights of the sums for ∫f ds, ∫s f ds and ∫s² f ds over |s| < R around given heights, for a
/// function f on a grid.
#[derive(Debug, Clone)]
pub(super) struct Moments {
    rows: Vec<Row>,
    weights: Vec<[f64; 3]>,
}

#[derive(Debug, Clone, Copy)]
struct Row {
    /// First node.
    node: usize,
    /// First weight, and number of weights.
    start: usize,
    length: usize,
}

impl Moments {
    /// Moments around `heights`, for functions on `grid` that are zero outside it.
    pub(super) fn new(rule: &Legendre, grid: &Grid, heights: &[f64]) -> Self {
        /// A narrower part of a panel is neglected.
        const SLIVER: f64 = 1e-13;
        let mut moments = Self { rows: Vec::with_capacity(heights.len()), weights: Vec::new() };
        let panels: Vec<[f64; 2]> = grid.panels().collect();
        for &height in heights {
            let (low, high) = (height - RADIUS, height + RADIUS);
            let first = grid.panel_at(low);
            let start = moments.weights.len();
            for &[begin, end] in &panels[first..=grid.panel_at(high)] {
                let (from, to) = (low.max(begin), high.min(end));
                let mut of_polynomials = [[0.0; ORDER]; 3];
                if to - from > SLIVER {
                    for (node, weight) in rule.nodes.iter().zip(rule.weights) {
                        let x = from + 0.5 * (to - from) * (node + 1.0);
                        let values = polynomials((2.0 * (x - begin) / (end - begin) - 1.0).clamp(-1.0, 1.0));
                        let s = x - height;
                        let mut power = 0.5 * (to - from) * weight;
                        for sums in &mut of_polynomials {
                            for (sum, value) in sums.iter_mut().zip(values) {
                                *sum += power * value;
                            }
                            power *= s;
                        }
                    }
                }
                let by_values = of_polynomials.map(|sums| rule.by_values(&sums));
                moments.weights.extend((0..ORDER).map(|node| by_values.each_ref().map(|row| row[node])));
            }
            let length = moments.weights.len() - start;
            moments.rows.push(Row { node: first * ORDER, start, length });
        }
        moments
    }

    /// The three moments of one function around each height.
    pub(super) fn of<'a>(&'a self, values: &'a [f64]) -> impl Iterator<Item = [f64; 3]> + 'a {
        self.rows.iter().map(|row| {
            let weights = &self.weights[row.start..row.start + row.length];
            let mut sums = [0.0; 3];
            for (weight, &value) in weights.iter().zip(&values[row.node..]) {
                for (sum, weight) in sums.iter_mut().zip(weight) {
                    *sum += weight * value;
                }
            }
            sums
        })
    }

    /// ∫(A₀ + sA₁ + s²A₂) ds around each height.
    pub(super) fn sums<'a>(&'a self, values: &'a [[f64; 3]]) -> impl Iterator<Item = f64> + 'a {
        self.rows.iter().map(|row| {
            let weights = &self.weights[row.start..row.start + row.length];
            let mut sums = [0.0; 3];
            for (weight, value) in weights.iter().zip(&values[row.node..]) {
                for ((sum, weight), value) in sums.iter_mut().zip(weight).zip(value) {
                    *sum += weight * value;
                }
            }
            sums[0] + sums[1] + sums[2]
        })
    }
}
