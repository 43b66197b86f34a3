//! Panels, on each of which the profile is a polynomial.
//!
//! A wall causes a singularity of the density at every whole radius from it, each smoother than the
//! one before, because averages over spheres turn a jump into a kink one radius away. Edges of
//! panels are placed there, so that the profile is smooth on every panel.

use super::RADIUS;
use crate::legendre::{Legendre, ORDER, Series, evaluate};

/// Panels and their Gauss nodes.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    edges: Vec<f64>,
    pub(super) nodes: Vec<f64>,
    /// Weights of the integral over all panels.
    pub(super) weights: Vec<f64>,
}

impl Grid {
    /// Narrowest panel, in diameters.
    pub(super) const NARROWEST: f64 = 1e-6;
    /// Distance from a wall up to which edges lie at whole radii.
    const NEAR: f64 = 4.0;
    /// Distance from a wall up to which panels are at most a diameter wide, to resolve layers.
    const LAYERED: f64 = 24.0;
    /// Width of panels farther away, as a share of the distance.
    const GROWTH: f64 = 0.1;

    /// The grid between the lowest and the highest centers. `walls` tells at which ends there is a
    /// wall half a diameter beyond.
    pub(super) fn new(rule: &Legendre, ends: [f64; 2], walls: [bool; 2]) -> Self {
        let [low, high] = ends;
        let mut edges = vec![low, high];
        let radii = (0_u32..).map(|number| RADIUS * f64::from(number)).take_while(|&far| far <= Self::NEAR);
        for far in radii {
            edges.extend(
                [(walls[0], low + far), (walls[1], high - far)]
                    .map(|(there, edge)| if there { edge } else { low }),
            );
        }
        let nearest = |height: f64| {
            let distances = [(walls[0], height - low), (walls[1], high - height)];
            distances
                .into_iter()
                .filter(|(there, _)| *there)
                .map(|(_, far)| far)
                .fold(f64::INFINITY, f64::min)
        };
        let mut height = low;
        while height < high {
            let far = nearest(height).max(0.0);
            let width = if far < Self::LAYERED {
                2.0 * RADIUS
            } else {
                (Self::GROWTH * far).min(0.5 * (far - Self::LAYERED) + 1.0)
            };
            let width = if far.is_finite() { width } else { 2.0 * RADIUS };
            height += width;
            if nearest(height) >= Self::NEAR - RADIUS {
                edges.push(height);
            }
        }
        Self::with_edges(rule, edges.into_iter().filter(|&edge| edge >= low && edge <= high).collect())
    }

    /// The panels between these heights, given in any order.
    pub(super) fn with_edges(rule: &Legendre, mut edges: Vec<f64>) -> Self {
        edges.sort_by(f64::total_cmp);
        let last = edges.last().copied();
        edges.dedup_by(|next, before| *next - *before < Self::NARROWEST);
        // The upper end stays where it is.
        if let (Some(end), Some(last)) = (edges.last_mut(), last) {
            *end = last;
        }
        let panels = || edges.windows(2).map(|panel| (panel[0], 0.5 * (panel[1] - panel[0])));
        let nodes = panels().flat_map(|(start, half)| rule.nodes.map(|t| start + half * (t + 1.0))).collect();
        let weights = panels().flat_map(|(_, half)| rule.weights.map(|weight| half * weight)).collect();
        Self { edges, nodes, weights }
    }

    /// The same panels and those outside that spheres with centers in the grid reach.
    pub(super) fn extended(&self, rule: &Legendre) -> Self {
        let [low, high] = self.ends();
        let mut edges = vec![low - RADIUS, high + RADIUS];
        edges.extend_from_slice(&self.edges);
        // Edges where the range of the averages passes the other end.
        edges.extend(
            [high - RADIUS, low + RADIUS]
                .into_iter()
                .filter(|&edge| edge > low - RADIUS && edge < high + RADIUS && !(edge > low && edge < high)),
        );
        Self::with_edges(rule, edges)
    }

    pub(super) fn ends(&self) -> [f64; 2] {
        [self.edges.first(), self.edges.last()].map(|edge| edge.copied().unwrap_or(0.0))
    }

    pub(super) fn panels(&self) -> impl DoubleEndedIterator<Item = [f64; 2]> + ExactSizeIterator + '_ {
        self.edges.windows(2).map(|panel| [panel[0], panel[1]])
    }

    /// The panel at a height, or the nearest one.
    pub(super) fn panel_at(&self, height: f64) -> usize {
        let panels = self.edges.len() - 1;
        self.edges.partition_point(|&edge| edge <= height).clamp(1, panels) - 1
    }

    /// The values at the nodes of a panel.
    pub(super) fn values(panel: usize, values: &[f64]) -> Series {
        std::array::from_fn(|node| values[panel * ORDER + node])
    }

    /// The polynomial through values at the nodes, evaluated at a height.
    pub(super) fn interpolate(&self, rule: &Legendre, values: &[f64], height: f64) -> f64 {
        let panel = self.panel_at(height);
        let [start, end] = [self.edges[panel], self.edges[panel + 1]];
        let t = (2.0 * (height - start) / (end - start) - 1.0).clamp(-1.0, 1.0);
        evaluate(&rule.coefficients(&Self::values(panel, values)), t)
    }

    /// The grid with some panels halved.
    pub(super) fn halved(&self, rule: &Legendre, panels: &[usize]) -> Self {
        let middles = panels.iter().map(|&panel| f64::midpoint(self.edges[panel], self.edges[panel + 1]));
        Self::with_edges(rule, self.edges.iter().copied().chain(middles).collect())
    }

    /// The integral of a function given at the nodes.
    pub(super) fn integrate(&self, values: impl IntoIterator<Item = f64>) -> f64 {
        self.weights.iter().zip(values).map(|(weight, value)| weight * value).sum()
    }
}
