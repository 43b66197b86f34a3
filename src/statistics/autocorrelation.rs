//! Autocorrelation times.

use super::{Estimate, mean};
use crate::Error;

/// Integrated autocorrelation time of a series, and the effective number of independent numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Autocorrelation {
    /// τ = ½ + Σ ρ(t) in intervals of the series: ½ if successive numbers are independent. The
    /// variance of the mean of N numbers is 2τ/N times that of one number.
    pub time: Estimate,
    /// Number of lags in the sum.
    pub window: usize,
    /// Effective number of independent numbers N/(2τ), at most N.
    pub effective_sample_size: f64,
}

/// Integrated autocorrelation time with Sokal's automatic window: the sum over lags stops at the
/// first W ≥ 5 τ(W) (Madras and Sokal, doi:10.1007/BF01022990).
///
/// The standard error is τ √(2(2W + 1)/N), from the same paper. It is derived for W much larger
/// than τ, and here it is too large, by a third for exponential decay. For correlations that decay
/// as exp(−t/τ), τ is too small by a relative e⁻⁵ = 0.7 % from the cut-off and (2W + 1)/N from
/// subtracting the sample mean. A slow mode of small amplitude is not detected. The work is N·W;
/// thin a very long series first.
///
/// If the series alternates about its mean, so does the sum. The window is then that of the series
/// with every second sign changed, up to 1000 lags or a tenth of the series, and the last lag has
/// half weight.
///
/// ```
/// use gradient_mc::statistics::autocorrelation;
/// // Every number comes ten times.
/// let series: Vec<f64> = (0..10_000).map(|i| f64::from(i / 10 * 7919 % 1009)).collect();
/// let result = autocorrelation(&series)?;
/// assert!((result.time.mean - 5.0).abs() < 3.0 * result.time.standard_error);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
///
/// # Errors
/// [`Error::TooFewObservations`] if the series is shorter than 50 τ; the needed length is then only
/// approximate, rounded up to two figures; [`Error::InvalidParameter`] if the series is constant,
/// or a number is not finite.
pub fn autocorrelation(series: &[f64]) -> Result<Autocorrelation, Error> {
    const WINDOW_IN_TIMES: f64 = 5.0;
    const LENGTH_IN_TIMES: f64 = 50.0;
    const WHAT: &str = "numbers of a series for its autocorrelation time (fifty times this time)";
    /// Largest number of lags for an alternating series.
    const MOST_STAGGERED: f64 = 1000.0;
    /// A series is treated as alternating if the time of the staggered series over its own time
    /// exceeds this.
    const ANTICORRELATED: f64 = 2.0;

    let count = series.len();
    let length = count as f64;
    // Smallest length: five times the window of independent numbers.
    let shortest = 25;
    if count < shortest {
        return Err(Error::TooFewObservations { what: WHAT, available: count, needed: shortest });
    }
    let mean = mean(series);
    let centered: Vec<f64> = series.iter().map(|value| value - mean).collect();
    let variance = centered.iter().map(|value| value * value).sum::<f64>() / length;
    if !(variance.is_finite() && variance > 0.0) {
        let requirement = "an autocorrelation time needs finite numbers that are not all equal";
        return Err(Error::InvalidParameter { name: "variance of the series", value: variance, requirement });
    }
    let (mut time, mut window) = (0.5_f64, 0);
    // The time of the series with every second sign changed.
    let mut staggered = 0.5_f64;
    let mut last = 1.0;
    let limit = MOST_STAGGERED.min(0.1 * length);
    // The sum over all lags is exactly zero, so the window always ends.
    while window + 1 < count
        && (window as f64) < WINDOW_IN_TIMES * time.max(staggered.min(limit / WINDOW_IN_TIMES))
    {
        window += 1;
        let products: f64 = centered.iter().zip(&centered[window..]).map(|(early, late)| early * late).sum();
        last = products / (length * variance);
        time += last;
        staggered += if window % 2 == 1 { -last } else { last };
    }
    if staggered > ANTICORRELATED * time {
        // The sum alternates about its limit.
        time -= 0.5 * last;
    }
    if length < LENGTH_IN_TIMES * time {
        // τ is far below 2^53 / 50.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let needed = rounded_up(LENGTH_IN_TIMES * time) as usize;
        return Err(Error::TooFewObservations { what: WHAT, available: count, needed });
    }
    let standard_error = time.abs() * (2.0 * (2.0 * window as f64 + 1.0) / length).sqrt();
    let effective_sample_size = length / (2.0 * time).max(1.0);
    Ok(Autocorrelation { time: Estimate::new(time, standard_error), window, effective_sample_size })
}

/// Rounds up to two figures.
fn rounded_up(number: f64) -> f64 {
    let mut unit = 1.0;
    while number > 100.0 * unit {
        unit *= 10.0;
    }
    unit * (number / unit).ceil()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::test_series::autoregressive;

    /// Mean of 64 estimates against the exact τ, within four of *their* errors plus the documented
    /// bias.
    #[test]
    fn times_of_autoregressive_series_are_found() {
        const SERIES: u32 = 64;
        for correlation in [-0.9, -0.5, 0.0, 0.5, 0.9, 0.97] {
            let exact = 0.5 * (1.0 + correlation) / (1.0 - correlation);
            let length = 16_384;
            let results: Vec<Autocorrelation> = (0..SERIES)
                .map(|seed| autocorrelation(&autoregressive(correlation, length, u64::from(seed))).unwrap())
                .collect();
            let average =
                |of: fn(&Autocorrelation) -> f64| results.iter().map(of).sum::<f64>() / f64::from(SERIES);
            let mean = average(|result| result.time.mean);
            let claimed = average(|result| result.time.standard_error);
            let window = average(|result| result.window as f64);
            let bias = exact * ((2.0 * window + 1.0) / length as f64 + 2.0 * (-5.0_f64).exp());
            let error = claimed / f64::from(SERIES).sqrt();
            assert!(
                (mean - exact).abs() < 4.0 * error + bias,
                "{correlation}: {mean} instead of {exact} ± {error}"
            );
            // For exponential decay Bartlett's formula at W = 5τ gives √(2.75/5) = 0.74 of the
            // claimed error, for white noise 0.93. The scatter of 64 values has an error of 9 %;
            // four of those on either side.
            let scatter = (results.iter().map(|r| (r.time.mean - mean).powi(2)).sum::<f64>() / 63.0).sqrt();
            let ratio = scatter / claimed;
            // The error for an anticorrelated series is smaller.
            let least = if correlation < 0.0 { 0.0 } else { 0.74 * 0.64 };
            assert!(ratio > least && ratio < 1.36, "{correlation}: scatter {scatter}, claimed {claimed}");
        }
    }

    #[test]
    fn anticorrelation_is_no_gain_and_hopeless_series_are_refused() {
        let alternating = autocorrelation(&autoregressive(-0.9, 4096, 1)).unwrap();
        assert!(alternating.time.mean < 0.5);
        assert!((alternating.effective_sample_size - 4096.0).abs() < 1e-9);
        for length in [100, 1000, 1001] {
            let to_and_fro: Vec<f64> = (0..length).map(|i| f64::from(1 - 2 * (i % 2))).collect();
            let result = autocorrelation(&to_and_fro).unwrap();
            assert!(result.time.mean.abs() < 2.0 / f64::from(length), "{result:?}");
            assert!((result.effective_sample_size - f64::from(length)).abs() < 1e-9);
        }

        let slow: Vec<f64> = (0..1000).map(f64::from).collect();
        // For 1000 evenly rising numbers Sokal's window gives τ = 92: about 4600 are needed.
        let needed = match autocorrelation(&slow) {
            Err(Error::TooFewObservations { available: 1000, needed, .. }) => needed,
            other => panic!("{other:?}"),
        };
        assert!(needed > 1000 && needed % 100 == 0, "{needed}");
        for (number, rounded) in
            [(25.2, 26.0), (100.0, 100.0), (100.1, 110.0), (4088.0, 4100.0), (99_500.0, 1e5)]
        {
            approx::assert_relative_eq!(rounded_up(number), rounded, max_relative = 1e-14);
        }
        assert!(matches!(autocorrelation(&[1.0; 10]), Err(Error::TooFewObservations { .. })));
        for value in [2.0, 12.7, 0.1, -1e-300] {
            let still = autocorrelation(&[value; 1000]);
            assert!(matches!(still, Err(Error::InvalidParameter { value: 0.0, .. })), "{value}: {still:?}");
        }
        let mut broken = autoregressive(0.0, 100, 1);
        broken[7] = f64::NAN;
        assert!(matches!(autocorrelation(&broken), Err(Error::InvalidParameter { .. })));
    }
}
