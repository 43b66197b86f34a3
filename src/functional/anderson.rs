//! Anderson mixing: solves a fixed-point problem from the last few steps.
//!
//! D. G. Anderson, J. ACM 12, 547 (1965), doi:10.1145/321296.321305.

use std::collections::VecDeque;

/// The last steps, and the changes of the residual by them.
#[derive(Debug, Clone, Default)]
pub(super) struct Anderson {
    last: Option<[Vec<f64>; 2]>,
    differences: VecDeque<[Vec<f64>; 2]>,
}

impl Anderson {
    /// Steps that are remembered.
    const DEPTH: usize = 16;
    /// Share of the diagonal that is added, so that nearly parallel steps do no harm.
    const RIDGE: f64 = 1e-14;

    /// Forgets everything.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// The next change of `values`, from the residuals here and at the earlier points. `metric`
    /// holds the weights of the squared residuals, `damping` the factor from each residual to the
    /// change of its value.
    pub(super) fn step(
        &mut self,
        values: &[f64],
        residuals: &[f64],
        metric: &[f64],
        damping: &[f64],
    ) -> Vec<f64> {
        if let Some([old_values, old_residuals]) = self.last.take() {
            let minus = |new: &[f64], old: &[f64]| new.iter().zip(old).map(|(new, old)| new - old).collect();
            self.differences.push_back([minus(values, &old_values), minus(residuals, &old_residuals)]);
            if self.differences.len() > Self::DEPTH {
                self.differences.pop_front();
            }
        }
        self.last = Some([values.to_vec(), residuals.to_vec()]);
        let product = |left: &[f64], right: &[f64]| -> f64 {
            left.iter().zip(right).zip(metric).map(|((left, right), weight)| left * right * weight).sum()
        };
        let matrix: Vec<Vec<f64>> = self
            .differences
            .iter()
            .map(|[_, one]| self.differences.iter().map(|[_, other]| product(one, other)).collect())
            .collect();
        let right = self.differences.iter().map(|[_, change]| product(change, residuals)).collect();
        let coefficients = solve(matrix, right);
        let mut changes = vec![0.0; values.len()];
        let mut left = residuals.to_vec();
        for ([step, change], coefficient) in self.differences.iter().zip(coefficients) {
            for i in 0..values.len() {
                changes[i] -= coefficient * step[i];
                left[i] -= coefficient * change[i];
            }
        }
        for ((change, left), damping) in changes.iter_mut().zip(left).zip(damping) {
            *change += damping * left;
        }
        changes
    }
}

/// Cholesky decomposition of a symmetric matrix that is scaled to a unit diagonal. Directions that
/// are lost in rounding get the coefficient 0.
fn solve(mut matrix: Vec<Vec<f64>>, mut right: Vec<f64>) -> Vec<f64> {
    let size = right.len();
    let scales: Vec<f64> = (0..size)
        .map(|i| {
            let square = matrix[i][i];
            if square > 0.0 { 1.0 / square.sqrt() } else { 0.0 }
        })
        .collect();
    for i in 0..size {
        for j in 0..size {
            matrix[i][j] *= scales[i] * scales[j];
        }
        matrix[i][i] = 1.0 + Anderson::RIDGE;
        right[i] *= scales[i];
    }
    // The newest direction first, so that the oldest ones are left out.
    matrix.reverse();
    for row in &mut matrix {
        row.reverse();
    }
    right.reverse();
    let mut kept = vec![true; size];
    for i in 0..size {
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| matrix[i][k] * matrix[j][k]).sum();
            let value = matrix[i][j] - sum;
            if i == j {
                kept[i] = value > 1e-12;
                matrix[i][i] = if kept[i] { value.sqrt() } else { 0.0 };
            } else {
                matrix[i][j] = if kept[j] { value / matrix[j][j] } else { 0.0 };
            }
        }
        if !kept[i] {
            matrix[i].fill(0.0);
        }
    }
    for i in 0..size {
        let sum: f64 = (0..i).map(|k| matrix[i][k] * right[k]).sum();
        right[i] = if kept[i] { (right[i] - sum) / matrix[i][i] } else { 0.0 };
    }
    for i in (0..size).rev() {
        let sum: f64 = (i + 1..size).map(|k| matrix[k][i] * right[k]).sum();
        right[i] = if kept[i] { (right[i] - sum) / matrix[i][i] } else { 0.0 };
    }
    right.reverse();
    right.into_iter().zip(scales).map(|(value, scale)| value * scale).collect()
}
