//! Errors of series of correlated numbers.

use super::chi_squared::chi_squared_quantile;
use super::memory::{independent, widened};
use super::{BlockAverages, Estimate, MINIMUM_BLOCKS, larger, mean};
use crate::Error;

/// Text of the error for too few numbers.
const ERROR: &str = "numbers of a series for a standard error";

/// Mean of a series of correlated numbers, with its standard error by automated blocking.
///
/// Neighbors are averaged pairwise until the averages are independent (Flyvbjerg and Petersen,
/// doi:10.1063/1.457480). The level is chosen by Jonsson's χ² test at the 1 % level on the neighbor
/// correlations of all further levels (doi:10.1103/PhysRevE.98.043304). The remaining neighbor
/// covariance of this level is added to the variance if it is positive; without it the error would
/// be too small by correlations that the test does not detect. If no level with at least 16 blocks
/// passes the test, the largest error of these levels is used.
///
/// For fewer than 40 independent numbers this error is too small. Then it is at least the widened
/// error of [`BlockAverages`].
///
/// A constant series has error zero. If a number is not finite, mean and error are NaN.
///
/// ```
/// use gradient_mc::statistics::blocking;
/// let series: Vec<f64> = (0..1024).map(|i| f64::from(i * 7919 % 1009)).collect();
/// let estimate = blocking(&series)?;
/// assert!((estimate.mean - 504.0).abs() < 3.0 * estimate.standard_error);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
///
/// # Errors
/// [`Error::TooFewObservations`] for fewer than 16 numbers.
pub fn blocking(series: &[f64]) -> Result<Estimate, Error> {
    /// Number of independent numbers from which the blocking error is used without widening.
    const ENOUGH: f64 = 40.0;
    let plain = plateau(series)?;
    let length = series.len().div_ceil(BlockAverages::MAXIMUM_BLOCKS);
    let blocks: Vec<f64> = series.chunks_exact(length).map(mean).collect();
    if independent(&[&blocks]) >= ENOUGH {
        return Ok(plain);
    }
    let widened = (widened(&blocks) * length as f64 / series.len() as f64).sqrt();
    Ok(Estimate::new(plain.mean, larger(plain.standard_error, widened)))
}

/// The mean with the error by Jonsson's test alone, which is too small for few independent numbers.
pub(crate) fn plateau(series: &[f64]) -> Result<Estimate, Error> {
    /// Quantile 0.99.
    const NORMAL_QUANTILE: f64 = 2.326_347_874_040_841;
    /// One level of blocking.
    struct Level {
        blocks: usize,
        /// Squared standard error of the mean for independent blocks.
        independent: f64,
        /// The same, with the measured correlation of neighboring blocks.
        corrected: f64,
        /// n [γ(1)/σ² + (n − 1)/n²]²: χ² with one degree of freedom if blocks are independent.
        correlation: f64,
    }

    let observations = series.len();
    if observations < MINIMUM_BLOCKS {
        return Err(Error::TooFewObservations {
            what: ERROR,
            available: observations,
            needed: MINIMUM_BLOCKS,
        });
    }
    let mean = mean(series);
    let mut blocks: Vec<f64> = series.iter().map(|value| value - mean).collect();
    let mut block_length = 1.0;
    let mut levels = Vec::new();
    while blocks.len() >= 2 {
        let count = blocks.len() as f64;
        // The mean of the blocks of this level, without those left over at the end.
        let center = blocks.iter().sum::<f64>() / count;
        let variance = blocks.iter().map(|block| (block - center) * (block - center)).sum::<f64>() / count;
        let covariance =
            blocks.windows(2).map(|pair| (pair[0] - center) * (pair[1] - center)).sum::<f64>() / count;
        // Subtracting the sample mean makes E[γ] = −(n − 1)/n² σ² for independent blocks.
        let covariance = covariance + variance * (count - 1.0) / (count * count);
        let ratio = if variance > 0.0 { covariance / variance } else { 0.0 };
        let share = block_length / observations as f64;
        let unbiased = variance * count / (count - 1.0);
        levels.push(Level {
            blocks: blocks.len(),
            independent: share * unbiased,
            corrected: share * (unbiased + 2.0 * covariance.max(0.0)),
            correlation: count * ratio * ratio,
        });
        let half = blocks.len() / 2;
        for block in 0..half {
            blocks[block] = 0.5 * (blocks[2 * block] + blocks[2 * block + 1]);
        }
        blocks.truncate(half);
        block_length *= 2.0;
    }

    let usable = levels.iter().take_while(|level| level.blocks >= MINIMUM_BLOCKS).count();
    let passed = (0..usable).find(|&first| {
        let statistic: f64 = levels[first..].iter().map(|level| level.correlation).sum();
        statistic < chi_squared_quantile(levels.len() - first, NORMAL_QUANTILE)
    });
    let squared = match passed {
        Some(level) => levels[level].corrected,
        None => levels[..usable].iter().map(|level| level.independent).fold(0.0, larger),
    };
    Ok(Estimate::new(mean, squared.sqrt()))
}

/// Variance of the numbers of a correlated series (not of its mean), with its error by
/// [`blocking`].
///
/// The variance of x̄, by blocking, is added to the mean of (x − x̄)², so the result is unbiased to
/// first order in the autocorrelation time over the length.
///
/// ```
/// use gradient_mc::statistics::variance;
/// // Uniform numbers from 0 to 1008 have the variance (1009² − 1)/12.
/// let series: Vec<f64> = (0..1024).map(|i| f64::from(i * 7919 % 1009)).collect();
/// let estimate = variance(&series)?;
/// assert!((estimate.mean - 84_840.0).abs() < 4.0 * estimate.standard_error);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
///
/// # Errors
/// [`Error::TooFewObservations`] for fewer than 16 numbers.
pub fn variance(series: &[f64]) -> Result<Estimate, Error> {
    let Estimate { mean, standard_error } = blocking(series)?;
    let squares: Vec<f64> = series.iter().map(|value| (value - mean) * (value - mean)).collect();
    let squared = blocking(&squares)?;
    Ok(Estimate::new(squared.mean + standard_error * standard_error, squared.standard_error))
}

/// Drift of a series: mean of the second half minus mean of the first half. Its error is by
/// [`blocking`] each half, not widened, to detect a drift.
///
/// In a steady state it is zero within about two standard errors. It is also zero within errors if
/// the drift is smaller than the noise, or if the series is shorter than the relaxation time. For
/// an odd length the middle element is in the second half.
///
/// ```
/// use gradient_mc::statistics::drift;
/// let series: Vec<f64> = (0..1024).map(|i| f64::from(i * 7919 % 1009) + f64::from(i)).collect();
/// assert!(drift(&series)?.deviation_from(0.0) > 4.0);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
///
/// # Errors
/// [`Error::TooFewObservations`] for fewer than 32 numbers.
pub fn drift(series: &[f64]) -> Result<Estimate, Error> {
    let needed = 2 * MINIMUM_BLOCKS;
    if series.len() < needed {
        return Err(Error::TooFewObservations {
            what: "numbers of a series for a drift",
            available: series.len(),
            needed,
        });
    }
    let (first, second) = series.split_at(series.len() / 2);
    let (first, second) = (plateau(first)?, plateau(second)?);
    // The correlation across the cut is neglected; it is of relative order τ/length.
    let squared = first.standard_error * first.standard_error + second.standard_error * second.standard_error;
    Ok(Estimate::new(second.mean - first.mean, squared.sqrt()))
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // compares only what is exact
mod tests {
    use super::*;
    use crate::statistics::test_series::autoregressive;

    /// Mean over many series of the squared error claimed, in units of the exact one, and mean of
    /// the squared deviation from the exact mean in units of the claimed one.
    fn calibration(correlation: f64, length: u32) -> (f64, f64) {
        const SERIES: u64 = 400;
        let exact = (1.0 + correlation) / (1.0 - correlation) / f64::from(length);
        let estimates =
            (0..SERIES).map(|seed| blocking(&autoregressive(correlation, length as usize, seed)).unwrap());
        let (claimed, squared) = estimates.fold((0.0, 0.0), |(claimed, squared), estimate| {
            let variance = estimate.standard_error.powi(2);
            (claimed + variance / exact, squared + estimate.mean.powi(2) / variance)
        });
        (claimed / SERIES as f64, squared / SERIES as f64)
    }

    #[test]
    fn errors_of_autoregressive_series_are_right() {
        // Exact up to 2τ²/N of it (below 1 %), plus what the test cannot see. The mean of 400
        // squared Gaussian deviations scatters by √(2/400) = 7 %, and by more if the errors
        // scatter.
        for (correlation, length) in [(0.0, 1024), (0.5, 1024), (0.9, 8192), (0.9, 10_000), (0.98, 16_384)] {
            let (claimed, squared) = calibration(correlation, length);
            assert!((claimed - 1.0).abs() < 0.05, "{correlation}, {length}: {claimed}");
            assert!((squared - 1.0).abs() < 4.0 * 0.071, "{correlation}, {length}: {squared}");
        }
        // A short series, 54 independent numbers: somewhat too small, as any method.
        let (claimed, squared) = calibration(0.9, 1024);
        assert!(claimed > 0.85 && squared < 1.5, "{claimed}, {squared}");
        // Anticorrelation is used only in part, so the error is too large.
        let (claimed, squared) = calibration(-0.5, 1024);
        assert!(claimed > 1.0 && squared < 1.0, "{claimed}, {squared}");
    }

    #[test]
    fn constants_have_no_error_and_broken_numbers_propagate() {
        for value in [0.1, 12.7, -1e-300] {
            assert_eq!(blocking(&[value; 1000]).unwrap(), Estimate::new(value, 0.0));
        }
        assert_eq!(blocking(&[3.0; 100]).unwrap(), Estimate::new(3.0, 0.0));
        let mut series = autoregressive(0.5, 100, 1);
        series[50] = f64::NAN;
        for estimate in [blocking(&series), variance(&series), drift(&series)] {
            let estimate = estimate.unwrap();
            assert!(estimate.mean.is_nan() && estimate.standard_error.is_nan());
        }
        let few = blocking(&[1.0; 15]);
        assert!(matches!(few, Err(Error::TooFewObservations { available: 15, needed: 16, .. })));
        assert!(matches!(drift(&[1.0; 31]), Err(Error::TooFewObservations { needed: 32, .. })));
    }

    #[test]
    fn a_series_too_short_for_its_memory_gives_its_largest_error() {
        // A ramp never decorrelates: sixteen blocks have the largest error, whose square is
        // N²/12 (1 − 1/16²) 16/15 / 16.
        let ramp: Vec<f64> = (0..1024).map(f64::from).collect();
        let estimate = plateau(&ramp).unwrap();
        assert!(blocking(&ramp).unwrap().standard_error > 2.0 * estimate.standard_error);
        approx::assert_relative_eq!(
            estimate.standard_error / 1024.0,
            (255.0_f64 / 256.0 / 180.0).sqrt(),
            max_relative = 1e-3
        );
        let change = drift(&ramp).unwrap();
        assert_eq!(change.mean, 512.0);
        assert!(change.deviation_from(0.0) > 4.0);
    }

    #[test]
    fn variance_of_a_correlated_series_is_unbiased() {
        const SERIES: u64 = 200;
        let (mut mean, mut claimed) = (0.0, 0.0);
        // N/(2τ) = 108: without the correction the mean would be low by 1/108.
        for seed in 0..SERIES {
            let estimate = variance(&autoregressive(0.9, 2048, seed)).unwrap();
            mean += estimate.mean / SERIES as f64;
            claimed += estimate.standard_error.powi(2) / SERIES as f64;
        }
        // For Gaussian numbers the squares' correlation is φ²: variance of the result 2(1 + φ²)/(1
        // − φ²)/N.
        let exact = 2.0 * (1.81 / 0.19) / 2048.0;
        assert!((mean - 1.0).abs() < 3.0 * (exact / SERIES as f64).sqrt(), "{mean}");
        assert!((claimed / exact - 1.0).abs() < 0.2, "{}", claimed / exact);
    }
}
