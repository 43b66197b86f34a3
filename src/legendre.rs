//! Legendre series on a panel: quadrature, integration from the left end, evaluation.

use std::f64::consts::PI;

/// Nodes per panel; quadrature is exact for polynomials up to degree 2·16 − 1.
pub(crate) const ORDER: usize = 16;

/// Values at the nodes of a panel, or the coefficients of the series through them.
pub(crate) type Series = [f64; ORDER];

/// The Gauss-Legendre rule on [−1, 1], with matrices for integration and series coefficients.
///
/// All numbers are computed from the recurrence of the polynomials.
#[derive(Debug, Clone)]
pub(crate) struct Legendre {
    /// Nodes, rising.
    pub(crate) nodes: Series,
    /// Weights; their sum is 2.
    pub(crate) weights: Series,
    /// Row i gives the integral from −1 to node i of the polynomial through values at the nodes.
    integration: [Series; ORDER],
    /// Row k gives coefficient k of the series through values at the nodes.
    analysis: [Series; ORDER],
}

/// k/(k + 1), which avoids division in the recurrence.
const RATIOS: [f64; ORDER] = {
    let mut ratios = [0.0; ORDER];
    let mut k = 0;
    while k < ORDER {
        ratios[k] = k as f64 / (k + 1) as f64;
        k += 1;
    }
    ratios
};

/// P₀(t) ... P₁₆(t).
pub(crate) fn polynomials(t: f64) -> [f64; ORDER + 1] {
    let mut values = [1.0; ORDER + 1];
    values[1] = t;
    for k in 1..ORDER {
        let product = t * values[k];
        values[k + 1] = product + RATIOS[k] * (product - values[k - 1]);
    }
    values
}

/// Integrals of P₀ ... P₁₅ from −1 to t.
fn integrals(t: f64) -> Series {
    let values = polynomials(t);
    std::array::from_fn(
        |k| {
            if k == 0 { t + 1.0 } else { (values[k + 1] - values[k - 1]) / (2 * k + 1) as f64 }
        },
    )
}

fn dot(left: &[f64], right: &[f64]) -> f64 {
    left.iter().zip(right).map(|(a, b)| a * b).sum()
}

impl Legendre {
    pub(crate) fn new() -> Self {
        let order = ORDER as f64;
        let mut nodes = [0.0; ORDER];
        let mut weights = [0.0; ORDER];
        for (index, (node, weight)) in nodes.iter_mut().zip(&mut weights).enumerate() {
            let mut t = -libm::cos(PI * (index as f64 + 0.75) / (order + 0.5));
            let mut slope = 1.0;
            // Newton's iteration converges quadratically from a start accurate to three digits.
            for _ in 0..6 {
                let values = polynomials(t);
                slope = order * (t * values[ORDER] - values[ORDER - 1]) / (t * t - 1.0);
                t -= values[ORDER] / slope;
            }
            *node = t;
            *weight = 2.0 / ((1.0 - t * t) * slope * slope);
        }
        let at_nodes = nodes.map(polynomials);
        let analysis: [Series; ORDER] =
            std::array::from_fn(|k| std::array::from_fn(|j| (k as f64 + 0.5) * weights[j] * at_nodes[j][k]));
        let integration = nodes.map(|t| {
            let integrals = integrals(t);
            std::array::from_fn(|j| (0..ORDER).map(|k| integrals[k] * analysis[k][j]).sum())
        });
        Self { nodes, weights, integration, analysis }
    }

    /// Integral over [−1, 1] of the polynomial through `values`.
    pub(crate) fn integrate(&self, values: &Series) -> f64 {
        dot(&self.weights, values)
    }

    /// Integrals from −1 to each node.
    pub(crate) fn integrate_to_nodes(&self, values: &Series) -> Series {
        std::array::from_fn(|i| dot(&self.integration[i], values))
    }

    /// Weights of the values at the nodes for a linear functional given by its values for P₀ ...
    /// P₁₅.
    pub(crate) fn by_values(&self, of_polynomials: &Series) -> Series {
        std::array::from_fn(|j| (0..ORDER).map(|k| of_polynomials[k] * self.analysis[k][j]).sum())
    }

    /// Coefficients of the series through `values`.
    pub(crate) fn coefficients(&self, values: &Series) -> Series {
        std::array::from_fn(|k| dot(&self.analysis[k], values))
    }
}

/// The series at t.
pub(crate) fn evaluate(coefficients: &Series, t: f64) -> f64 {
    dot(coefficients, &polynomials(t))
}

/// The integral of the series from −1 to t.
pub(crate) fn evaluate_integral(coefficients: &Series, t: f64) -> f64 {
    dot(coefficients, &integrals(t))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn quadrature_is_exact_to_degree_31() {
        let rule = Legendre::new();
        assert_relative_eq!(rule.integrate(&[1.0; ORDER]), 2.0, max_relative = 1e-14);
        let values = rule.nodes.map(|t| 31.0 * t.powi(30) + t.powi(31));
        assert_relative_eq!(rule.integrate(&values), 2.0, max_relative = 1e-13);
        let too_high = rule.nodes.map(|t| 33.0 * t.powi(32));
        assert!((rule.integrate(&too_high) - 2.0).abs() > 1e-10);
    }

    #[test]
    fn series_reproduces_a_function_and_its_integral() {
        let rule = Legendre::new();
        let values = rule.nodes.map(|t| (1.3 * t).exp());
        let coefficients = rule.coefficients(&values);
        for t in [-1.0_f64, -0.4, 0.0, 0.77, 1.0] {
            let integral = ((1.3 * t).exp() - (-1.3_f64).exp()) / 1.3;
            assert_relative_eq!(evaluate(&coefficients, t), (1.3 * t).exp(), max_relative = 1e-13);
            assert_relative_eq!(evaluate_integral(&coefficients, t), integral, epsilon = 1e-14);
        }
        for (integral, t) in rule.integrate_to_nodes(&values).iter().zip(rule.nodes) {
            let exact = ((1.3 * t).exp() - (-1.3_f64).exp()) / 1.3;
            assert_relative_eq!(*integral, exact, max_relative = 1e-12);
        }
    }
}
