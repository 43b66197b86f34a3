//! The two measures of error of the paper (doi:10.1103/PhysRevE.83.061306).
//!
//! Neither is a standard error. For N independent Gaussian runs of standard deviation s,
//!
//! E\[σ\] = √(2(N − 1)/(πN)) s/P: 0.714 s/P for the paper's five runs,
//!
//! while the standard error of their mean is s/√N = 0.447 s. For independent runs, σ is therefore
//! 0.714/0.447 = 1.6 times the relative standard error of the mean. The five runs of the paper are
//! successive intervals of one simulation; σ does not contain errors that they have in common.

use crate::Error;

/// The σ of the paper, eq. (32): mean absolute deviation of N runs over their mean P, Σ |Pᵢ − P|/(N
/// P).
///
/// ```
/// use gradient_mc::statistics::deviations::scatter;
/// assert!((scatter(&[1.0, 2.0, 3.0])? - 1.0 / 3.0).abs() < 1e-15);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
///
/// The result is ∞ or NaN if the mean is zero.
///
/// # Errors
/// [`Error::TooFewObservations`] for fewer than two runs.
pub fn scatter(runs: &[f64]) -> Result<f64, Error> {
    if runs.len() < 2 {
        return Err(Error::TooFewObservations {
            what: "runs for a scatter",
            available: runs.len(),
            needed: 2,
        });
    }
    let count = runs.len() as f64;
    let mean = runs.iter().sum::<f64>() / count;
    Ok(runs.iter().map(|run| (run - mean).abs()).sum::<f64>() / (count * mean))
}

/// Expected [`scatter`] of N Gaussian runs, in units of the relative standard deviation s/P of one
/// run: √(2(N − 1)/(πN)). Divide σ by this number and by √N to get the relative standard error of
/// the mean.
///
/// ```
/// use gradient_mc::statistics::deviations::expected_scatter;
/// assert!((expected_scatter(5) - 0.714).abs() < 1e-3);
/// ```
#[must_use]
pub fn expected_scatter(runs: usize) -> f64 {
    let count = runs as f64;
    (std::f64::consts::FRAC_2_PI * (count - 1.0) / count).sqrt()
}

/// The δ of the paper, eq. (33): relative deviation |P − `P_theory`|/`P_theory`.
///
/// ```
/// use gradient_mc::statistics::deviations::deviation;
/// assert!((deviation(1.9, 2.0) - 0.05).abs() < 1e-12);
/// ```
#[must_use]
pub fn deviation(measured: f64, theory: f64) -> f64 {
    (measured - theory).abs() / theory
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::test_series::autoregressive;

    #[test]
    fn scatter_of_five_gaussian_runs_is_0_714_standard_deviations() {
        const TRIALS: usize = 40_000;
        let (pressure, deviation) = (10.0, 0.1);
        let noise = autoregressive(0.0, 5 * TRIALS, 5);
        let mean = noise
            .chunks_exact(5)
            .map(|runs| {
                let runs: Vec<f64> = runs.iter().map(|run| pressure + deviation * run).collect();
                scatter(&runs).unwrap()
            })
            .sum::<f64>()
            / TRIALS as f64;
        // One σ scatters by at most its mean; the runs' mean in the denominator adds (0.01)²/5.
        let tolerance = 4.0 * 0.714 / (TRIALS as f64).sqrt();
        let ratio = mean * pressure / deviation;
        assert!((ratio - expected_scatter(5)).abs() < tolerance, "{ratio}");
        assert!((expected_scatter(5) - 0.714).abs() < 5e-4);
    }

    #[test]
    fn deviation_is_relative_to_theory() {
        approx::assert_relative_eq!(deviation(1.9, 2.0), 0.05, max_relative = 1e-12);
        assert!(matches!(scatter(&[1.0]), Err(Error::TooFewObservations { available: 1, needed: 2, .. })));
    }
}
