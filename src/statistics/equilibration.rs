//! Detection of the beginning of the steady state of a series.

use super::{Estimate, autocorrelation, mean};
use crate::Error;

/// The steady part of a series, as found by [`equilibration`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Equilibration {
    /// Index of the first number of the steady part.
    pub start: usize,
    /// Effective number of independent numbers in the steady part, N/(2τ).
    pub effective_sample_size: f64,
    /// Integrated autocorrelation time τ of the steady part, in intervals of the series; see
    /// [`autocorrelation`](super::autocorrelation()).
    pub autocorrelation_time: Estimate,
}

/// Detects the beginning of the steady state of a series: the start with the largest effective
/// number of independent numbers, (N − start)/(2τ), where τ is the autocorrelation time of the rest
/// (Chodera, doi:10.1021/acs.jctc.5b00784).
///
/// If the relaxation is part of the rest, τ is large; if more is cut than the relaxation, data are
/// lost. Candidates are 0, 1, 2, ... and further on 3 % apart. A long series is first averaged over
/// at most 4096 blocks, which bounds the work; the start is then a whole number of blocks.
///
/// This rule finds a start also in a series without a steady state. Therefore the start must be in
/// the first half, and the rest at least 50 τ long. The rule cannot detect a relaxation that is
/// slower than the series, or one hidden by anticorrelated noise. Therefore compare runs from a
/// dense and a dilute start.
///
/// The rule would also keep a large relaxation that is as fast as the fluctuations, because its τ
/// is not longer. Therefore everything is cut up to the last number of the first half that differs
/// from the mean of the second half by more than six of its standard deviations.
///
/// ```
/// use gradient_mc::statistics::equilibration;
/// // From 3 to 0 within a hundred numbers, under noise.
/// let mut random = 1_u32;
/// let series: Vec<f64> = (0..2000)
///     .map(|time| {
///         random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
///         3.0 * 0.95_f64.powi(time) + f64::from(random) / f64::from(u32::MAX) - 0.5
///     })
///     .collect();
/// let steady = equilibration(&series)?;
/// assert!(steady.start > 30 && steady.start < 200);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
///
/// # Errors
/// [`Error::NotEquilibrated`] if the best start is in the second half, or leaves fewer than 25
/// independent numbers; [`Error::TooFewObservations`] for fewer than 100 numbers;
/// [`Error::InvalidParameter`] if the second half is constant, or a number is not finite.
pub fn equilibration(series: &[f64]) -> Result<Equilibration, Error> {
    const SHORTEST: usize = 100;
    const MOST_BLOCKS: usize = 4096;
    /// Smallest number of values, or blocks, for an estimate of τ.
    const SHORTEST_REST: usize = 25;

    let observations = series.len();
    if observations < SHORTEST {
        return Err(Error::TooFewObservations {
            what: "numbers of a series for its steady state",
            available: observations,
            needed: SHORTEST,
        });
    }
    for &value in series {
        Error::require_finite("number in the series", value)?;
    }
    let block = observations.div_ceil(MOST_BLOCKS);
    // The blocks end at the end of the series; an incomplete block at the beginning is dropped.
    let offset = observations % block;
    let blocks: Vec<f64> = series[offset..].chunks_exact(block).map(mean).collect();
    let (mut start, mut most) = (0, 0.0);
    let mut candidate = end_of_fall(&blocks);
    while candidate + SHORTEST_REST <= blocks.len() {
        let rest = &blocks[candidate..];
        let effective = rest.len() as f64 / inefficiency(rest);
        if effective > most {
            (start, most) = (candidate, effective);
        }
        candidate += 1 + candidate / 32;
    }
    let start = if start == 0 { 0 } else { offset + start * block };
    let refused = |effective_sample_size: f64| {
        Err(Error::NotEquilibrated { observations, start, effective_sample_size })
    };
    if start > observations / 2 {
        return refused(most);
    }
    match autocorrelation(&series[start..]) {
        Ok(rest) => Ok(Equilibration {
            start,
            effective_sample_size: rest.effective_sample_size,
            autocorrelation_time: rest.time,
        }),
        Err(Error::TooFewObservations { .. }) => refused(most),
        Err(error) => Err(error),
    }
}

/// Index after the last number of the first half that differs too much from the second half.
fn end_of_fall(series: &[f64]) -> usize {
    const FARTHEST: f64 = 6.0;

    let (first, second) = series.split_at(series.len() / 2);
    let length = second.len() as f64;
    let mean = mean(second);
    let variance = second.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / length;
    let foreign = |value: &f64| (value - mean) * (value - mean) > FARTHEST * FARTHEST * variance;
    // A constant second half is refused later.
    first.iter().rposition(foreign).filter(|_| variance > 0.0).map_or(0, |last| last + 1)
}

/// Statistical inefficiency 2τ of a series, at least 1: the sum of correlations up to the first
/// that is not positive, but over at least three lags, as in the paper cited above. Sokal's window
/// is too short for a slow relaxation of small amplitude under fast noise.
fn inefficiency(series: &[f64]) -> f64 {
    const FEWEST_LAGS: usize = 3;

    let length = series.len() as f64;
    let mean = mean(series);
    let centered: Vec<f64> = series.iter().map(|value| value - mean).collect();
    let squares: f64 = centered.iter().map(|value| value * value).sum();
    if squares <= 0.0 {
        // The autocorrelation time of a constant series is unknown.
        return length;
    }
    let mut inefficiency = 1.0;
    for lag in 1..series.len() {
        let products: f64 = centered.iter().zip(&centered[lag..]).map(|(early, late)| early * late).sum();
        if products <= 0.0 && lag > FEWEST_LAGS {
            break;
        }
        inefficiency += 2.0 * products / squares;
    }
    inefficiency.max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::blocking;
    use crate::statistics::test_series::autoregressive;

    /// Relaxation from `amplitude` with the time `relaxation` under noise of unit variance and
    /// correlation φ^t.
    fn relaxing(amplitude: f64, relaxation: f64, correlation: f64, length: usize, seed: u64) -> Vec<f64> {
        let noise = autoregressive(correlation, length, seed);
        let decay = |time: usize| amplitude * (-(time as f64) / relaxation).exp();
        noise.into_iter().enumerate().map(|(time, value)| value + decay(time)).collect()
    }

    /// The mean of the rest is right within its error, the start is neither in the relaxation nor
    /// far behind it, and the correlation time is that of the noise. Without a cut the mean is
    /// wrong.
    #[test]
    fn relaxations_are_cut_off() {
        const RUNS: u32 = 20;
        for (amplitude, relaxation, correlation, length) in
            [(20.0, 50.0, 0.0, 4000), (20.0, 200.0, 0.9, 20_000), (-30.0, 1000.0, 0.9, 100_000)]
        {
            let exact = 0.5 * (1.0 + correlation) / (1.0 - correlation);
            let (mut squares, mut untrimmed, mut times) = (0.0, 0.0, 0.0);
            for seed in 0..RUNS {
                let series = relaxing(amplitude, relaxation, correlation, length, u64::from(seed));
                let steady = equilibration(&series).unwrap();
                let begin = steady.start as f64 / relaxation;
                assert!(begin > 1.5 && begin < 15.0, "from {begin} relaxation times on");
                squares += blocking(&series[steady.start..]).unwrap().deviation_from(0.0).powi(2);
                times += steady.autocorrelation_time.mean / f64::from(RUNS);
                let independent = (length - steady.start) as f64 / (2.0 * exact);
                assert!((steady.effective_sample_size / independent - 1.0).abs() < 0.4);
                // Without a cut the mean is off by amplitude · relaxation/length, many standard
                // errors.
                let mean = series.iter().sum::<f64>() / length as f64;
                untrimmed += mean.abs() / (2.0 * exact / length as f64).sqrt() / f64::from(RUNS);
            }
            // Twenty squares of mean 1 scatter by √(2/20); a little relaxation is left, as the rule
            // trades bias for noise.
            let square = squares / f64::from(RUNS);
            assert!(square < 1.0 + 4.0 * 0.32, "{square}");
            assert!(untrimmed > 5.0, "{untrimmed}");
            assert!((times / exact - 1.0).abs() < 0.15, "{times} instead of {exact}");
        }
    }

    #[test]
    fn steady_series_are_kept() {
        // The rule cuts a little by chance, since estimates of τ scatter.
        let kept = |correlation: f64| {
            let starts =
                (0..20).map(|seed| equilibration(&autoregressive(correlation, 10_000, seed)).unwrap().start);
            starts.sum::<usize>() as f64 / 20.0 / 10_000.0
        };
        for correlation in [0.0, 0.9] {
            assert!(kept(correlation) < 0.15, "{} of it is cut", kept(correlation));
        }
    }

    /// A column falls by a hundred standard deviations, as fast as it fluctuates or faster.
    #[test]
    fn a_fall_as_fast_as_the_fluctuations_is_cut_off() {
        for relaxation in [5.0, 100.0] {
            let mut cut = 0.0;
            for seed in 0..20 {
                let series = relaxing(100.0, relaxation, 0.99, 20_000, seed);
                let steady = equilibration(&series).unwrap();
                // ln(100/6) relaxation times, less what the fluctuations may hide.
                assert!(steady.start as f64 > 2.3 * relaxation, "{} at {relaxation}", steady.start);
                cut += steady.start as f64 / 20_000.0 / 20.0;
                // The rule alone would keep the fall of most series, because that gives a larger
                // effective number.
                let number = |start: usize| (20_000 - start) as f64 / inefficiency(&series[start..]);
                assert!(relaxation > 50.0 || number(0) > number(steady.start));
            }
            // As many are cut by chance from a steady series with this correlation time.
            assert!(cut < 0.15, "{cut} of it is cut");
        }
    }

    #[test]
    fn what_never_settles_is_refused() {
        let ramp: Vec<f64> = autoregressive(0.0, 5000, 1)
            .iter()
            .enumerate()
            .map(|(time, value)| value + 0.01 * time as f64)
            .collect();
        assert!(matches!(equilibration(&ramp), Err(Error::NotEquilibrated { observations: 5000, .. })));
        let slow = relaxing(20.0, 5000.0, 0.5, 5000, 2);
        assert!(matches!(equilibration(&slow), Err(Error::NotEquilibrated { .. })));
        let mut sum = 0.0;
        let walk: Vec<f64> = autoregressive(0.0, 5000, 3)
            .iter()
            .map(|step| {
                sum += step;
                sum
            })
            .collect();
        assert!(matches!(equilibration(&walk), Err(Error::NotEquilibrated { .. })));
        assert!(matches!(equilibration(&[1.0; 99]), Err(Error::TooFewObservations { needed: 100, .. })));
        for value in [1.0, 12.7, 0.1, 2.0] {
            assert!(matches!(equilibration(&[value; 1000]), Err(Error::InvalidParameter { .. })), "{value}");
        }
        let mut broken = autoregressive(0.0, 200, 1);
        broken[150] = f64::NAN;
        assert!(matches!(equilibration(&broken), Err(Error::InvalidParameter { .. })));
    }
}
