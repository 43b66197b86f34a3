//! A polynomial for ln n(x) over a small window, fitted to the counts of narrow bins.

use nalgebra::{DMatrix, DVector};

/// ln n = Σ cₖ sᵏ, where s runs from −1 to 1 over the window.
#[derive(Debug, Clone)]
pub(crate) struct LogPolynomial {
    middle: f64,
    half_width: f64,
    coefficients: Vec<f64>,
}

impl LogPolynomial {
    /// Least squares over bins of one width, given as middles and mean densities, each with the
    /// weight of its count.
    ///
    /// What is known of a bin is its mean, not n at its middle: the difference, δ²n″/24, is taken
    /// from a first fit.
    pub(crate) fn fit(bins: &[(f64, f64)], bin_width: f64, degree: usize) -> Option<Self> {
        let ((low, _), (high, _)) = (bins.first()?, bins.last()?);
        let middle = f64::midpoint(*low, *high);
        let half_width = 0.5 * (high - low + bin_width);
        let mut fitted = Self { middle, half_width, coefficients: vec![0.0; degree + 1] };
        for _ in 0..2 {
            let mut normal = DMatrix::<f64>::zeros(degree + 1, degree + 1);
            let mut right = DVector::<f64>::zeros(degree + 1);
            for &(height, density) in bins.iter().filter(|(_, density)| *density > 0.0) {
                let place = (height - middle) / half_width;
                let slope = fitted.derivative(height, 1);
                let relative_curvature = fitted.derivative(height, 2) + slope * slope;
                let target = libm::log(density) - bin_width * bin_width / 24.0 * relative_curvature;
                let powers: Vec<f64> =
                    std::iter::successors(Some(1.0), |power| Some(power * place)).take(degree + 1).collect();
                for (row, first) in powers.iter().enumerate() {
                    right[row] += density * first * target;
                    for (column, second) in powers.iter().enumerate() {
                        normal[(row, column)] += density * first * second;
                    }
                }
            }
            fitted.coefficients = normal.cholesky()?.solve(&right).iter().copied().collect();
        }
        Some(fitted)
    }

    /// n(x).
    pub(crate) fn density(&self, height: f64) -> f64 {
        libm::exp(self.derivative(height, 0))
    }

    /// Where n(x) is largest in the window; its ends are none.
    pub(crate) fn maximum(&self) -> Option<f64> {
        const STEPS: u32 = 200;
        let at = |step: u32| self.middle + self.half_width * (2.0 * f64::from(step) / f64::from(STEPS) - 1.0);
        let highest = (0..=STEPS).max_by(|&first, &second| {
            self.derivative(at(first), 0).total_cmp(&self.derivative(at(second), 0))
        })?;
        if highest == 0 || highest == STEPS {
            return None;
        }
        let mut height = at(highest);
        for _ in 0..8 {
            height -= self.derivative(height, 1) / self.derivative(height, 2);
        }
        Some(height)
    }

    /// ln n or a derivative of it.
    fn derivative(&self, height: f64, order: usize) -> f64 {
        let place = (height - self.middle) / self.half_width;
        let mut sum = 0.0;
        for (power, coefficient) in self.coefficients.iter().enumerate().skip(order).rev() {
            let factor: f64 = (0..order).map(|step| (power - step) as f64).product();
            sum = sum * place + factor * coefficient;
        }
        sum / libm::pow(self.half_width, order as f64)
    }
}
