//! Autocorrelation times of series and the errors of their means, for blocks, profiles and
//! warnings.

use super::chi_squared::chi_squared_quantile;
use super::{larger, mean};

/// Smallest effective number of independent configurations without a
/// [`Warning::NotMixed`](crate::Warning::NotMixed). With fewer, even widened errors are too small.
/// A larger limit would give false warnings, and would still miss runs that underestimate their
/// autocorrelation time (`docs/stability.md`, Error bars).
pub(crate) const FEWEST_INDEPENDENT: f64 = 2.5;

/// Window of the sum over lags, in autocorrelation times. For exponential decay 5 % of the variance
/// is beyond it; a longer window adds more noise than that.
const WINDOW_IN_TIMES: f64 = 3.0;
/// If replicas scatter by more than this number of standard errors (probability 1 % by chance), the
/// scatter is used as the error.
const SCATTER: f64 = 2.326_347_874_040_841;
/// If they scatter by more than this number, they disagree.
const CONTRADICTION: f64 = 5.0;

/// Autocorrelation of numbers within segments of a series, each about its own mean.
#[derive(Debug, Clone)]
pub(crate) struct Correlation {
    /// Number of values in all segments.
    numbers: f64,
    /// Number of nonempty segments.
    segments: f64,
    /// Variance of one number.
    variance: f64,
    /// ρ(k) for lags from 1 to the longest; empty for a constant series.
    ratios: Vec<f64>,
}

impl Correlation {
    pub(crate) fn of(segments: &[&[f64]]) -> Self {
        let longest = segments.iter().map(|segment| segment.len()).max().unwrap_or(0);
        let numbers = segments.iter().map(|segment| segment.len()).sum::<usize>() as f64;
        let filled = segments.iter().filter(|segment| !segment.is_empty()).count() as f64;
        let centered: Vec<Vec<f64>> = segments
            .iter()
            .map(|segment| {
                let mean = mean(segment);
                segment.iter().map(|value| value - mean).collect()
            })
            .collect();
        let products = |lag: usize| {
            let of_segment = |segment: &Vec<f64>| {
                segment.iter().zip(segment.iter().skip(lag)).map(|(early, late)| early * late).sum::<f64>()
            };
            centered.iter().map(of_segment).sum::<f64>()
        };
        let squares = products(0);
        let changes = squares != 0.0 && numbers > filled;
        let lags = if changes { longest } else { 1 };
        let ratios = (1..lags).map(|lag| products(lag) / squares).collect();
        let variance = if changes { squares / numbers } else { 0.0 };
        Self { numbers, segments: filled, variance, ratios }
    }

    /// Whether it is used for neighbors: the numbers are finite and not constant.
    fn counts(&self) -> bool {
        self.variance > 0.0 && self.variance.is_finite()
    }
}

/// Autocorrelation time, as a statistical inefficiency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Memory {
    /// g = 2τ, at least 1: the variance of the mean of N numbers is g/N times that of one number.
    pub(crate) inefficiency: f64,
    /// Degrees of freedom of the variance of the mean.
    degrees: f64,
}

impl Memory {
    /// Common autocorrelation time of series of equal lengths, from the mean of their correlations,
    /// which has less noise than that of one series. Constant series are not used.
    ///
    /// τ = ½ + Σ ρ(k) is summed up to the first lag W ≥ 3 τ (Madras and Sokal,
    /// doi:10.1007/BF01022990). It is divided by 1 − (2W + 1)/n, where n is the mean length of a
    /// segment, to correct for the subtracted mean (Wolff, doi:10.1016/S0010-4655(03)00467-3, eq.
    /// 49). The relative variance of τ is 2(2W + 1)/N (for one series, as an upper bound), and that
    /// of the variance of one number is g/N. Their sum is that of a variance with ν = 2N/(2(2W + 1)
    /// + g) degrees of freedom.
    pub(crate) fn of(correlations: &[&Correlation]) -> Self {
        let Some(first) = correlations.first() else { return Self { inefficiency: 1.0, degrees: 1.0 } };
        let numbers = first.numbers;
        let counted: Vec<&[f64]> = correlations
            .iter()
            .filter(|correlation| correlation.counts())
            .map(|correlation| &correlation.ratios[..])
            .collect();
        if counted.is_empty() {
            // A constant series is one independent number; for numbers that are not finite the
            // result is NaN.
            let constant = first.variance == 0.0;
            return Self {
                inefficiency: if constant { numbers.max(1.0) } else { f64::NAN },
                degrees: numbers,
            };
        }
        let longest = counted.iter().map(|ratios| ratios.len()).max().unwrap_or(0);
        let (mut time, mut window) = (0.5, 0_usize);
        while window < longest && (window as f64) < WINDOW_IN_TIMES * time {
            let ratios = counted.iter().filter_map(|ratios| ratios.get(window));
            time += ratios.sum::<f64>() / counted.len() as f64;
            window += 1;
        }
        let lags = (2 * window + 1) as f64;
        let lost = (lags * first.segments / numbers).min(0.9);
        let inefficiency = larger(2.0 * time / (1.0 - lost), numbers / (numbers - first.segments));
        Self { inefficiency, degrees: 2.0 * numbers / (2.0 * lags + inefficiency) }
    }

    /// Effective number of independent numbers among `numbers`.
    pub(crate) fn independent(&self, numbers: f64) -> f64 {
        (numbers / self.inefficiency).max(1.0)
    }

    /// Widened variance; the squared error of a mean of N numbers is this over N: σ² g ν/(ν − 2),
    /// with the variance of Student's distribution with ν degrees of freedom instead of the normal
    /// distribution.
    fn widened(&self, variance: f64) -> f64 {
        // For ν ≤ 2 the variance is infinite; a factor of five is used.
        const FEWEST_DEGREES: f64 = 2.5;
        if variance == 0.0 {
            return 0.0;
        }
        let degrees = self.degrees.max(FEWEST_DEGREES);
        variance * self.inefficiency * degrees / (degrees - 2.0)
    }
}

/// Effective number of independent numbers in series of equal lengths with a common autocorrelation
/// time.
pub(crate) fn independent(series: &[impl AsRef<[f64]>]) -> f64 {
    let correlations: Vec<Correlation> =
        series.iter().map(|series| Correlation::of(&[series.as_ref()])).collect();
    let numbers = series.first().map_or(0, |series| series.as_ref().len());
    Memory::of(&correlations.iter().collect::<Vec<_>>()).independent(numbers as f64)
}

/// Variance of one number times its inefficiency, widened for a short series.
pub(super) fn widened(series: &[f64]) -> f64 {
    let correlation = Correlation::of(&[series]);
    Memory::of(&[&correlation]).widened(correlation.variance)
}

/// The error of the common mean of replicas, and whether they agree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pooled {
    /// Standard error of the mean of all numbers.
    pub(crate) standard_error: f64,
    /// Whether their means disagree.
    pub(crate) contradict: bool,
}

/// Error of the mean of all numbers of `replicas`, from the variance and autocorrelation time, or
/// from the scatter of their means if this is significantly larger.
pub(crate) fn pooled(replicas: &[&[f64]], correlation: &Correlation, memory: &Memory) -> Pooled {
    let of_one = memory.widened(correlation.variance);
    let means = replicas
        .iter()
        .filter(|replica| !replica.is_empty())
        .map(|replica| (mean(replica), replica.len() as f64, of_one / replica.len() as f64));
    scattered(&means.collect::<Vec<_>>(), of_one / correlation.numbers)
}

/// The same, from the mean, weight and squared error of every replica and the squared error of the
/// common mean.
///
/// Q = Σ (mᵣ − m)²/σᵣ² has a χ² distribution with R − 1 degrees of freedom if all R replicas have
/// the same mean. Above its quantile 0.99 the squared error is at least that of the scatter, R/(R −
/// 1) Σ wᵣ² (mᵣ − m)², with weights wᵣ whose sum is 1.
pub(crate) fn scattered(replicas: &[(f64, f64, f64)], squared_error: f64) -> Pooled {
    let count = replicas.len();
    let total: f64 = replicas.iter().map(|(_, weight, _)| weight).sum();
    let center = replicas.iter().map(|(mean, weight, _)| mean * weight).sum::<f64>() / total;
    let (mut chi_squared, mut scatter) = (0.0, 0.0);
    for (mean, weight, squared_error) in replicas {
        let square = (mean - center) * (mean - center);
        // Smaller differences are only rounding.
        if square > 1e-24 * center * center {
            chi_squared += square / squared_error;
            scatter += weight * weight / (total * total) * square;
        }
    }
    let exceeds = |sigmas: f64| count > 1 && chi_squared > chi_squared_quantile(count - 1, sigmas);
    let mut squared = squared_error;
    if exceeds(SCATTER) {
        squared = larger(squared, scatter * count as f64 / (count as f64 - 1.0));
    }
    Pooled { standard_error: squared.sqrt(), contradict: exceeds(CONTRADICTION) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::test_series::autoregressive;

    fn pooled(replicas: &[&[f64]]) -> Pooled {
        let correlation = Correlation::of(replicas);
        super::pooled(replicas, &correlation, &Memory::of(&[&correlation]))
    }

    /// Root mean square of (mean − 0)/error, and the mean number of independent numbers, of series
    /// with `size` of them.
    fn calibration(size: f64, length: usize, replicas: usize) -> (f64, f64) {
        const SERIES: u64 = 600;
        let correlation = libm::exp(-2.0 * size / length as f64);
        let (mut squares, mut independent) = (0.0, 0.0);
        for seed in 0..SERIES {
            let series: Vec<Vec<f64>> = (0..replicas as u64)
                .map(|replica| autoregressive(correlation, length, 100 * seed + replica))
                .collect();
            let series: Vec<&[f64]> = series.iter().map(|series| &series[..]).collect();
            let center = series.iter().map(|series| mean(series)).sum::<f64>() / replicas as f64;
            squares += (center / pooled(&series).standard_error).powi(2) / SERIES as f64;
            independent +=
                Memory::of(&[&Correlation::of(&series)]).independent(length as f64) / SERIES as f64;
        }
        (squares.sqrt(), independent)
    }

    #[test]
    fn deviations_are_as_large_as_errors_even_in_short_series() {
        // A root mean square of 600 is known to 3 %, and to twice that where errors scatter.
        for (size, length, low, high) in
            [(5.0, 96, 0.85, 1.3), (10.0, 96, 0.8, 1.25), (20.0, 96, 0.8, 1.15), (64.0, 768, 0.85, 1.1)]
        {
            let (pull, independent) = calibration(size, length, 1);
            assert!(pull > low && pull < high, "{size}, {length}: {pull}");
            assert!(independent > 0.8 * size && independent < 1.5 * size + 1.0, "{size}: {independent}");
            let (pull, _) = calibration(size, length, 4);
            assert!(pull > low && pull < high, "four replicas, {size}, {length}: {pull}");
        }
    }

    #[test]
    fn replicas_that_contradict_each_other_have_their_scatter() {
        let above: Vec<f64> = autoregressive(0.5, 100, 1).iter().map(|noise| 199.7 + noise).collect();
        let below: Vec<f64> = autoregressive(0.5, 100, 2).iter().map(|noise| 16.1 + noise).collect();
        let result = pooled(&[&above, &below]);
        assert!(result.contradict && (result.standard_error - 91.8).abs() < 0.3, "{result:?}");
        // Honest ones hardly ever do: one in ten thousand by chance.
        let contradict = (0..1000).filter(|&seed| {
            let (one, other) = (autoregressive(0.9, 100, 2 * seed), autoregressive(0.9, 100, 2 * seed + 1));
            pooled(&[&one, &other]).contradict
        });
        assert!(contradict.count() <= 2);
        assert!(!pooled(&[&above]).contradict);
    }

    #[test]
    fn constants_have_no_error_and_broken_numbers_propagate() {
        let still = pooled(&[&[3.0; 20], &[3.0; 5], &[]]);
        assert!(still.standard_error == 0.0 && !still.contradict);
        assert!(independent(&[[3.0; 20]]) <= 1.0);
        let apart = pooled(&[&[3.0; 20], &[5.0; 20]]);
        assert!((apart.standard_error - 1.0).abs() < 1e-12 && apart.contradict, "{apart:?}");
        let mut broken = autoregressive(0.0, 30, 1);
        broken[3] = f64::NAN;
        assert!(pooled(&[&broken]).standard_error.is_nan());
    }
}
