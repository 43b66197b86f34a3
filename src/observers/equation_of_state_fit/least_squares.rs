//! Small weighted least-squares problems.

use nalgebra::{DMatrix, DVector};

/// Normal equations, summed row by row.
#[derive(Debug)]
pub(super) struct LeastSquares {
    matrix: DMatrix<f64>,
    right: DVector<f64>,
}

impl LeastSquares {
    pub(super) fn new(unknowns: usize) -> Self {
        Self { matrix: DMatrix::zeros(unknowns, unknowns), right: DVector::zeros(unknowns) }
    }

    /// Adds the equation row · x = value, where the value has the variance 1/`weight`.
    pub(super) fn add(&mut self, row: &[f64], value: f64, weight: f64) {
        for (i, one) in row.iter().enumerate() {
            self.right[i] += weight * one * value;
            for (j, other) in row.iter().enumerate() {
                self.matrix[(i, j)] += weight * one * other;
            }
        }
    }

    /// The solution; `None` if the rows do not determine it.
    pub(super) fn solve(mut self) -> Option<Vec<f64>> {
        let scales: Vec<f64> = self.matrix.diagonal().iter().map(|square| 1.0 / square.sqrt()).collect();
        for (i, one) in scales.iter().enumerate() {
            self.right[i] *= one;
            for (j, other) in scales.iter().enumerate() {
                self.matrix[(i, j)] *= one * other;
            }
        }
        let solution = self.matrix.cholesky()?.solve(&self.right);
        Some(solution.iter().zip(&scales).map(|(value, scale)| value * scale).collect())
    }
}
