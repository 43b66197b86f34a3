//! Linear least squares.

use nalgebra::{SMatrix, SVector};

/// Weighted linear least squares by the normal equations: rows of features, value and weight. NaN
/// if they are singular, that is if a feature is a combination of others to within a millionth.
pub fn least_squares<const N: usize>(rows: &[([f64; N], f64, f64)]) -> [f64; N] {
    let mut normal = SMatrix::<f64, N, N>::zeros();
    let mut right = SVector::<f64, N>::zeros();
    for (features, value, weight) in rows {
        let features = SVector::from(*features);
        normal += features * features.transpose() * *weight;
        right += features * (weight * value);
    }
    let independent = |factor: &SMatrix<f64, N, N>| {
        (0..N).all(|feature| {
            factor[(feature, feature)] * factor[(feature, feature)] > 1e-12 * normal[(feature, feature)]
        })
    };
    normal
        .cholesky()
        .filter(|cholesky| independent(&cholesky.l()))
        .map_or([f64::NAN; N], |cholesky| cholesky.solve(&right).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_is_found() {
        let rows =
            [-1.0, 0.5, 2.0, 3.0].map(|x: f64| ([1.0, x, x * x], 3.0 - 2.0 * x + 0.5 * x * x, 1.0 + x * x));
        for (found, expected) in least_squares(&rows).into_iter().zip([3.0, -2.0, 0.5]) {
            approx::assert_relative_eq!(found, expected, max_relative = 1e-12);
        }
        assert!(least_squares(&rows[..2]).iter().all(|coefficient| coefficient.is_nan()));
    }
}
