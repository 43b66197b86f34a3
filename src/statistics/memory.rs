//! How long series remember, and what that makes of the error of their mean: the one rule for
//! blocks, for profiles and for the diagnostics of runs.

use super::chi_squared::chi_squared_quantile;
use super::{larger, mean};

/// Fewest independent configurations from which anything is concluded without a
/// [`Warning::NotMixed`](crate::Warning::NotMixed).
pub(crate) const FEWEST_INDEPENDENT: f64 = 10.0;

/// The window of the sum over lags in correlation times. For exponential decay 5 % of the variance
/// lie beyond it; a longer one adds more noise than that.
const WINDOW_IN_TIMES: f64 = 3.0;
/// Replicas scatter by more than this many standard errors once in a hundred times by chance: then
/// the scatter is the error.
const SCATTER: f64 = 2.326_347_874_040_841;
/// And by so many never: then they contradict each other.
const CONTRADICTION: f64 = 5.0;

/// Correlation of successive numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Memory {
    /// g = 2τ: the variance of the mean of N numbers is g/N times that of one. At least 1, so
    /// anticorrelation is no gain.
    pub(crate) inefficiency: f64,
    /// Variance of one number.
    variance: f64,
    /// Degrees of freedom of the variance of the mean.
    degrees: f64,
}

/// Correlation of the numbers within `segments`, each about its own mean.
///
/// τ = ½ + Σ ρ(k) is summed up to the first lag W ≥ 3 τ (Madras and Sokal,
/// doi:10.1007/BF01022990), and divided by 1 − (2W + 1)/n, with n the mean length of a segment:
/// subtracting the mean takes that much from it (Wolff, doi:10.1016/S0010-4655(03)00467-3, eq. 49).
/// The relative variance of τ is 2(2W + 1)/N, that of a variance with N/(2W + 1) degrees of freedom.
pub(crate) fn memory(segments: &[&[f64]]) -> Memory {
    let count: usize = segments.iter().map(|segment| segment.len()).sum();
    let longest = segments.iter().map(|segment| segment.len()).max().unwrap_or(0);
    let numbers = count as f64;
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
    if squares == 0.0 || numbers <= filled {
        // Numbers that never change are one number.
        return Memory { inefficiency: numbers.max(1.0), variance: 0.0, degrees: numbers };
    }
    let (mut time, mut window) = (0.5, 0_usize);
    while window + 1 < longest && (window as f64) < WINDOW_IN_TIMES * time {
        window += 1;
        time += products(window) / squares;
    }
    let lags = (2 * window + 1) as f64;
    let lost = (lags * filled / numbers).min(0.9);
    let inefficiency = larger(2.0 * time / (1.0 - lost), numbers / (numbers - filled));
    Memory { inefficiency, variance: squares / numbers, degrees: numbers / lags }
}

impl Memory {
    /// Number of independent numbers among `numbers`.
    pub(crate) fn independent(&self, numbers: f64) -> f64 {
        (numbers / self.inefficiency).max(1.0)
    }

    /// Variance that the mean of one number has by right if that of N is this over N: σ² g ν/(ν − 2),
    /// the variance of Student's distribution with ν degrees of freedom in place of that of a normal
    /// number.
    pub(super) fn widened(&self) -> f64 {
        // Below the second there is no variance; a factor of five stands for it.
        const FEWEST_DEGREES: f64 = 2.5;
        let degrees = self.degrees.max(FEWEST_DEGREES);
        self.variance * self.inefficiency * degrees / (degrees - 2.0)
    }
}

/// What replicas tell about their common mean.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pooled {
    /// Standard error of the mean of all numbers.
    pub(crate) standard_error: f64,
    /// Whether they cannot have the same mean.
    pub(crate) contradict: bool,
}

/// Error of the mean of all numbers of `replicas`, from their memory, and from the scatter of their
/// means where that is larger than the memory explains.
pub(crate) fn pooled(replicas: &[&[f64]]) -> Pooled {
    let numbers = replicas.iter().map(|replica| replica.len()).sum::<usize>() as f64;
    let of_one = memory(replicas).widened();
    let means = replicas
        .iter()
        .filter(|replica| !replica.is_empty())
        .map(|replica| (mean(replica), replica.len() as f64, of_one / replica.len() as f64));
    scattered(&means.collect::<Vec<_>>(), of_one / numbers)
}

/// The same from the mean, weight and squared error of every replica, and the squared error of the
/// mean of all.
///
/// Q = Σ (mᵣ − m)²/σᵣ² has a χ² distribution with R − 1 degrees of freedom if all R replicas sample
/// the same. Beyond its quantile 0.99 the squared error is at least that of their scatter,
/// R/(R − 1) Σ wᵣ² (mᵣ − m)² with weights wᵣ that add up to 1.
pub(crate) fn scattered(replicas: &[(f64, f64, f64)], squared_error: f64) -> Pooled {
    let count = replicas.len();
    let total: f64 = replicas.iter().map(|(_, weight, _)| weight).sum();
    let center = replicas.iter().map(|(mean, weight, _)| mean * weight).sum::<f64>() / total;
    let (mut chi_squared, mut scatter) = (0.0, 0.0);
    for (mean, weight, squared_error) in replicas {
        let square = (mean - center) * (mean - center);
        // Means that differ by rounding alone.
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

/// Standard deviation of all numbers, each about the mean of its replica.
pub(super) fn spread(replicas: &[Vec<f64>]) -> f64 {
    let replicas: Vec<&[f64]> = replicas.iter().map(|replica| &replica[..]).collect();
    memory(&replicas).variance.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::test_series::autoregressive;

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
            independent += memory(&series).independent(length as f64) / SERIES as f64;
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
        assert!(memory(&[&[3.0; 20]]).independent(20.0) <= 1.0);
        let apart = pooled(&[&[3.0; 20], &[5.0; 20]]);
        assert!((apart.standard_error - 1.0).abs() < 1e-12 && apart.contradict, "{apart:?}");
        let mut broken = autoregressive(0.0, 30, 1);
        broken[3] = f64::NAN;
        assert!(pooled(&[&broken]).standard_error.is_nan());
    }
}
