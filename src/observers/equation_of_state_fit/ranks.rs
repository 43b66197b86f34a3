//! Z from the mean heights of the k-th highest spheres, at which the pressure is known.

use super::least_squares::LeastSquares;
use crate::equation_of_state::{EquationOfState, MOST_TERMS, Series, number_density};
use crate::{Frame, Wall};

/// Sums over an interval of sweeps at some ranks, which are counted from the open end of the
/// column.
#[derive(Debug, Clone)]
pub(super) struct Ranks {
    nodes: Vec<usize>,
    looks: f64,
    /// Distances from the wall at the open end.
    distances: Vec<f64>,
    /// Weight over T per area of all spheres up to the rank, included.
    weights: Vec<f64>,
    /// Number of spheres within one diameter of contact with the wall at the open end.
    at_wall: f64,
    heights: Vec<f64>,
}

/// Means over intervals, in the order of a sample.
#[derive(Debug, Clone, Copy)]
pub(super) struct Means<'a> {
    distances: &'a [f64],
    weights: &'a [f64],
    at_wall: f64,
}

impl Ranks {
    /// Largest relative difference of successive ranks, if it is more than one rank.
    const RATIO: f64 = 0.03;

    pub(super) fn new(spheres: usize) -> Self {
        let mut nodes = vec![1];
        let mut last = 1;
        while last < spheres {
            // Far below the number of spheres.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let step = (Self::RATIO * last as f64) as usize;
            last = (last + step.max(1)).min(spheres);
            nodes.push(last);
        }
        let zeros = vec![0.0; nodes.len()];
        Self {
            looks: 0.0,
            distances: zeros.clone(),
            weights: zeros,
            at_wall: 0.0,
            heights: Vec::with_capacity(spheres),
            nodes,
        }
    }

    pub(super) fn nodes(&self) -> &[usize] {
        &self.nodes
    }

    /// Number of components of a sample.
    pub(super) fn components(&self) -> usize {
        2 * self.nodes.len() + 1
    }

    pub(super) fn observe(&mut self, frame: &Frame<'_>) {
        let Self { nodes, heights, .. } = self;
        heights.clear();
        frame.for_each_height(|height| heights.push(height));
        let end = frame.scene().open_end();
        let contact = end.contact_height(frame.slab());
        let sign = if end == Wall::Lid { 1.0 } else { -1.0 };
        heights.sort_unstable_by(|one, other| (sign * other).total_cmp(&(sign * one)));
        let per_area = sign / frame.slab().base_area();
        let (mut rank, mut weight) = (0, 0.0);
        for (node, &last) in nodes.iter().enumerate() {
            for &height in &heights[rank..last] {
                weight += per_area * frame.reduced_force(height);
            }
            rank = last;
            self.distances[node] += (contact - heights[last - 1]).abs();
            self.weights[node] += weight;
        }
        self.at_wall += heights.iter().take_while(|&height| (contact - height).abs() < 1.0).count() as f64;
        self.looks += 1.0;
    }

    /// Ends an interval: writes its sample and starts the next interval.
    pub(super) fn take(&mut self, sample: &mut [f64]) {
        let nodes = self.nodes.len();
        for (place, sum) in sample.iter_mut().zip(self.distances.iter().chain(&self.weights)) {
            *place = sum / self.looks;
        }
        sample[2 * nodes] = self.at_wall / self.looks;
        self.forget();
    }

    /// Clears all sums and starts an interval.
    pub(super) fn forget(&mut self) {
        self.distances.fill(0.0);
        self.weights.fill(0.0);
        (self.looks, self.at_wall) = (0.0, 0.0);
    }
}

/// The part of the ranks that is used.
#[derive(Debug, Clone, Copy)]
pub(super) struct Used<'a> {
    pub(super) nodes: &'a [usize],
    /// Area of the base.
    pub(super) area: f64,
    /// Smallest and largest distance from the wall at the open end.
    pub(super) distances: [f64; 2],
}

impl<'a> Means<'a> {
    pub(super) fn of(sample: &'a [f64]) -> Self {
        let nodes = sample.len() / 2;
        Self { distances: &sample[..nodes], weights: &sample[nodes..2 * nodes], at_wall: sample[2 * nodes] }
    }

    /// The coefficients of the [`Series`] with this number of terms that fits the gaps between
    /// ranks best, by the Gauss-Newton method. The pressure at the open end is another unknown if
    /// spheres touch this wall.
    pub(super) fn fit(&self, used: &Used<'_>, terms: usize) -> Option<Vec<f64>> {
        const MOST_STEPS: usize = 60;
        const GOOD: f64 = 1e-9;
        let at_wall = (self.at_wall > 0.0).then_some(self.at_wall / used.area);
        let mut unknowns = vec![0.0; terms + usize::from(at_wall.is_some())];
        for (unknown, carnahan_starling) in unknowns.iter_mut().zip([4.0, -2.0]).take(terms) {
            *unknown = carnahan_starling;
        }
        if let Some(density) = at_wall {
            unknowns[terms] = density;
        }
        let mut step = self.step(used, terms, &unknowns)?;
        for _ in 0..MOST_STEPS {
            let next: Vec<f64> = unknowns.iter().zip(&step).map(|(unknown, step)| unknown + step).collect();
            if let Some(next_step) = self.step(used, terms, &next) {
                let largest = step.iter().copied().map(f64::abs).fold(0.0, f64::max);
                (unknowns, step) = (next, next_step);
                if largest < GOOD {
                    unknowns.truncate(terms);
                    return Some(unknowns);
                }
            } else {
                // The equation has no state at some pressure; the step is shortened.
                for change in &mut step {
                    *change *= 0.5;
                }
            }
        }
        None
    }

    /// The change of the unknowns by the linearized least-squares problem; `None` if there is no
    /// state at a needed pressure.
    fn step(&self, used: &Used<'_>, terms: usize, unknowns: &[f64]) -> Option<Vec<f64>> {
        let series = Series::new(&unknowns[..terms]);
        let end_pressure = unknowns.get(terms).copied();
        let mut equations = LeastSquares::new(unknowns.len());
        let mut guess = None;
        for node in 0..used.nodes.len() - 1 {
            let (near, far) = (self.distances[node], self.distances[node + 1]);
            if near < used.distances[0] || far > used.distances[1] {
                continue;
            }
            let ranks = [used.nodes[node], used.nodes[node + 1]];
            let slope = (self.weights[node + 1] - self.weights[node]) / (ranks[1] - ranks[0]) as f64;
            let mut row = [0.0; MOST_TERMS + 1];
            let (mut expected, mut variance) = (0.0, 0.0);
            for (rank, gaps) in gaps(ranks).into_iter().flatten() {
                let weight = self.weights[node] + slope * (rank - ranks[0] as f64);
                let pressure = weight + end_pressure.unwrap_or(0.0);
                let eta = series.packing_fraction_at(pressure, guess)?;
                guess = Some(eta);
                let factor = series.compressibility_factor(eta);
                // d ln p/d ln η.
                let stiffness = 1.0 + series.compressibility_derivative(eta) / factor;
                let each = gaps / (pressure * used.area);
                expected += each * factor;
                for (value, term) in row.iter_mut().zip(Series::terms(eta)).take(terms) {
                    *value += each * term / stiffness;
                }
                if end_pressure.is_some() {
                    row[terms] -= each * factor / (pressure * stiffness);
                }
                // Number of spheres per height of a fluid at this pressure.
                let spheres = number_density(eta) * used.area;
                variance += gaps / (spheres * spheres * factor * stiffness);
            }
            equations.add(&row[..unknowns.len()], far - near - expected, 1.0 / variance);
        }
        equations.solve()
    }
}

/// Ranks of gaps between two nodes, and the number of gaps that each represents: every gap, or the
/// nodes of the Gauss-Legendre rule if there are many.
fn gaps([first, end]: [usize; 2]) -> [Option<(f64, f64)>; 8] {
    const NODE: f64 = 0.774_596_669_241_483_4;
    let count = end - first;
    let mut gaps = [None; 8];
    if count <= gaps.len() {
        for (rank, gap) in (first..end).zip(&mut gaps) {
            *gap = Some((rank as f64, 1.0));
        }
        return gaps;
    }
    let (middle, half) = (0.5 * (first + end - 1) as f64, 0.5 * count as f64);
    let rule = [(-NODE, 5.0 / 9.0), (0.0, 8.0 / 9.0), (NODE, 5.0 / 9.0)];
    for ((node, weight), gap) in rule.into_iter().zip(&mut gaps) {
        *gap = Some((middle + half * node, half * weight));
    }
    gaps
}

persist!(Ranks { same nodes, value looks, slice distances, slice weights, value at_wall });
