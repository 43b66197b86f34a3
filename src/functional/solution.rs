//! Solves for the profile on one grid: ln n = μ − u − μₑₓ at every node.

use super::anderson::Anderson;
use super::grid::Grid;
use super::moments::Moments;
use super::potential::Potential;
use super::{FreeEnergy, Functional, WeightedDensities};
use crate::Error;
use crate::legendre::Legendre;

/// The given quantity of a column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Given {
    /// Spheres per area.
    ColumnDensity(f64),
    /// Reduced chemical potential.
    ChemicalPotential(f64),
}

/// A column on a grid.
#[derive(Debug)]
pub(super) struct Problem<'a, W> {
    rule: &'a Legendre,
    functional: &'a W,
    pub(super) potential: Potential,
    given: Given,
    pub(super) grid: Grid,
    /// The grid of the weighted densities.
    extended: Grid,
    to_extended: Moments,
    from_extended: Moments,
    /// Number of nodes of the extended grid below those of the grid.
    offset: usize,
}

/// All that follows from the densities at the nodes.
#[derive(Debug, Clone)]
pub(super) struct State {
    /// The given chemical potential, or the mean over the nodes.
    pub(super) chemical_potential: f64,
    /// μ − u − μₑₓ − ln n.
    residuals: Vec<f64>,
    /// n₃ at the nodes.
    packings: Vec<f64>,
    /// Grand potential per area over temperature.
    pub(super) grand_potential: f64,
    pub(super) densities: Vec<f64>,
}

/// A solved problem.
#[derive(Debug, Clone)]
pub(super) struct Solution {
    pub(super) logarithms: Vec<f64>,
    pub(super) state: State,
    pub(super) iterations: u32,
    pub(super) residual: f64,
}

impl<'a, W: Functional> Problem<'a, W> {
    /// Largest n₃ for which functionals are evaluated.
    const MOST_PACKED: f64 = 0.98;
    /// Weighted root mean square of the residuals at which iteration stops.
    const TOLERANCE: f64 = 1e-11;
    /// The same if iteration, because of rounding, makes no more progress.
    const GOOD_ENOUGH: f64 = 1e-9;
    /// Largest number of iterations.
    const MOST_ITERATIONS: u32 = 2000;
    /// Largest change of ln n in one iteration.
    const LONGEST_STEP: f64 = 0.7;

    pub(super) fn new(
        rule: &'a Legendre,
        functional: &'a W,
        grid: Grid,
        potential: Potential,
        given: Given,
    ) -> Self {
        let extended = grid.extended(rule);
        let to_extended = Moments::new(rule, &grid, &extended.nodes);
        let from_extended = Moments::new(rule, &extended, &grid.nodes);
        let [low, _] = grid.ends();
        let offset = extended.nodes.partition_point(|&node| node < low);
        Self { rule, functional, potential, given, grid, extended, to_extended, from_extended, offset }
    }

    /// The state for these ln n; `None` if n₃ is too large.
    fn state(&self, logarithms: &[f64]) -> Option<State> {
        let densities: Vec<f64> = logarithms.iter().map(|&logarithm| libm::exp(logarithm)).collect();
        let mut packings = Vec::with_capacity(self.extended.nodes.len());
        let mut forces = Vec::with_capacity(self.extended.nodes.len());
        let mut excess = 0.0;
        for (moments, weight) in self.to_extended.of(&densities).zip(&self.extended.weights) {
            let weighted = WeightedDensities::from_moments(moments);
            if weighted.packing >= Self::MOST_PACKED || weighted.packing.is_nan() {
                return None;
            }
            let energy: FreeEnergy = self.functional.free_energy(&weighted);
            excess += weight * energy.density;
            packings.push(weighted.packing);
            forces.push(energy.for_moments());
        }
        let potential = self.potential.values(self.rule, &self.grid, &densities);
        let mut residuals: Vec<f64> = self
            .from_extended
            .sums(&forces)
            .zip(&potential)
            .zip(logarithms)
            .map(|((excess, potential), logarithm)| -potential - excess - logarithm)
            .collect();
        let spheres = self.grid.integrate(densities.iter().copied());
        let chemical_potential = match self.given {
            Given::ColumnDensity(_) => {
                let mean =
                    self.grid.integrate(residuals.iter().zip(&densities).map(|(residual, n)| residual * n));
                -mean / spheres
            }
            Given::ChemicalPotential(given) => given,
        };
        for residual in &mut residuals {
            *residual += chemical_potential;
        }
        let one_body = |((logarithm, potential), density): ((&f64, &f64), &f64)| {
            density * (logarithm - 1.0 + potential - chemical_potential)
        };
        let grand_potential =
            excess + self.grid.integrate(logarithms.iter().zip(&potential).zip(&densities).map(one_body));
        packings.truncate(self.offset + self.grid.nodes.len());
        packings.drain(..self.offset);
        let finite = residuals.iter().all(|residual| residual.is_finite());
        finite.then_some(State { chemical_potential, residuals, packings, grand_potential, densities })
    }

    /// Shifts ln n so that the column holds the given number of spheres.
    fn fill(&self, logarithms: &mut [f64]) {
        if let Given::ColumnDensity(spheres) = self.given {
            let found = self.grid.integrate(logarithms.iter().map(|&logarithm| libm::exp(logarithm)));
            let shift = libm::log(spheres / found);
            for logarithm in logarithms {
                *logarithm += shift;
            }
        }
    }

    /// Solves, starting from these ln n.
    pub(super) fn solve(&self, mut logarithms: Vec<f64>) -> Result<Solution, Error> {
        let failed = |iterations, residual| Error::FunctionalNotConverged { iterations, residual };
        self.fill(&mut logarithms);
        let mut state = self.state(&logarithms).ok_or(failed(0, f64::INFINITY))?;
        let mut mixing = Anderson::default();
        let mut best: Option<Solution> = None;
        let mut since_best = 0;
        for iterations in 0..Self::MOST_ITERATIONS {
            let metric: Vec<f64> = self
                .grid
                .weights
                .iter()
                .zip(&state.densities)
                .map(|(weight, density)| weight * density)
                .collect();
            let square: f64 = state
                .residuals
                .iter()
                .zip(&metric)
                .map(|(residual, weight)| residual * residual * weight)
                .sum();
            let residual = (square / metric.iter().sum::<f64>()).sqrt();
            if best.as_ref().is_none_or(|best| residual < 0.9 * best.residual) {
                best = Some(Solution {
                    logarithms: logarithms.clone(),
                    state: state.clone(),
                    iterations,
                    residual,
                });
                since_best = 0;
            } else {
                since_best += 1;
            }
            let good = best.as_ref().is_some_and(|best| best.residual <= Self::GOOD_ENOUGH);
            if residual <= Self::TOLERANCE || (good && since_best > 30) {
                break;
            }
            if since_best > 60 {
                // Discard misleading steps.
                mixing.clear();
                since_best = 0;
            }
            let damping: Vec<f64> = state.packings.iter().map(|&packing| damping(packing)).collect();
            let mut changes = mixing.step(&logarithms, &state.residuals, &metric, &damping);
            for change in &mut changes {
                *change = change.clamp(-Self::LONGEST_STEP, Self::LONGEST_STEP);
            }
            let mut part = 1.0;
            (logarithms, state) = loop {
                let mut next: Vec<f64> =
                    logarithms.iter().zip(&changes).map(|(value, change)| value + part * change).collect();
                self.fill(&mut next);
                if let Some(state) = self.state(&next) {
                    break (next, state);
                }
                part *= 0.5;
                if part < 1e-6 {
                    return Err(failed(iterations, residual));
                }
            };
        }
        match best {
            Some(best) if best.residual <= Self::GOOD_ENOUGH => Ok(best),
            best => Err(failed(Self::MOST_ITERATIONS, best.map_or(f64::INFINITY, |best| best.residual))),
        }
    }
}

/// Factor from a residual to the change of ln n. Without it, slow modes of a dense fluid would
/// overshoot by the inverse of its compressibility.
fn damping(packing: f64) -> f64 {
    let eta = packing.clamp(0.0, 0.5);
    let (void, stiff) = (1.0 - eta, 1.0 + 2.0 * eta);
    let stiffness = stiff * stiff / (void * void * void * void);
    2.0 / (1.0 + stiffness)
}
