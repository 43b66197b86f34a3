//! Checks whether a run is equilibrated, and long enough for its slowest quantity.

use crate::monitor::Monitor;
use crate::statistics::{Estimate, FEWEST_INDEPENDENT, drift, independent, mean, plateau};
use crate::warning::MixingEvidence;
use crate::{Quantity, Warning};

/// The series of the height of the center of mass, its variance in equilibrium, and the slowest of
/// all series.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mixing<'a> {
    series: &'a [f64],
    required_variance: Option<f64>,
    slowest: (Quantity, f64),
}

/// The quantity with the smallest effective number of independent configurations, and this number.
/// Constant series are left out, except that of the center of mass.
pub(crate) fn slowest(monitor: &Monitor) -> (Quantity, f64) {
    let changes = |series: &Vec<f64>| series.windows(2).any(|pair| (pair[0] - pair[1]).abs() > 0.0);
    monitor
        .series()
        .into_iter()
        .filter(|(quantity, series)| *quantity == Quantity::Column || series.iter().any(changes))
        .map(|(quantity, series)| (quantity, independent(series)))
        .min_by(|(_, one), (_, other)| one.total_cmp(other))
        .unwrap_or((Quantity::Column, 1.0))
}

impl<'a> Mixing<'a> {
    /// A drift is significant above this number of standard errors.
    const LARGEST_DRIFT: f64 = 4.0;
    /// A drift below this number of equilibrium standard deviations is not reported: the error bar
    /// of a run with a few independent configurations is as large.
    const SMALLEST_DRIFT: f64 = 0.75;
    /// Smallest variance relative to equilibrium. Sixteen independent numbers have a smaller one in
    /// one of a thousand runs.
    const QUIETEST: f64 = 0.25;

    /// A shift of the first eighth below this number of equilibrium standard deviations is not
    /// reported: it changes the mean of the run by at most a quarter of one standard deviation.
    const SMALLEST_SHIFT: f64 = 2.0;

    pub(super) fn new(monitor: &'a Monitor, required_variance: Option<f64>) -> Self {
        Self { series: monitor.center_of_mass(), required_variance, slowest: slowest(monitor) }
    }

    /// Mean height of the center of mass. Its error is not widened for a drift, to detect a
    /// drifting column as far from theory. The error is NaN if the series is too short.
    pub(super) fn center_of_mass(&self) -> Estimate {
        plateau(self.series).unwrap_or(Estimate::new(f64::NAN, f64::NAN))
    }

    fn variance(&self) -> f64 {
        let count = self.series.len() as f64;
        let mean = mean(self.series);
        self.series.iter().map(|height| (height - mean) * (height - mean)).sum::<f64>() / count
    }

    /// The mean of the first eighth of the series minus that of its second half. The error is that
    /// of equilibrium: the first eighth has a quarter of the independent configurations of the
    /// second half, at least one.
    fn shift(&self) -> Estimate {
        let (eighth, half) = (&self.series[..self.series.len() / 8], &self.series[self.series.len() / 2..]);
        let rest = Mixing { series: half, ..*self };
        let variance = rest.variance().max(self.required_variance.unwrap_or(0.0));
        let independent = independent(&[half]).max(4.0);
        Estimate::new(mean(eighth) - mean(half), (variance * (4.0 + 1.0) / independent).sqrt())
    }

    pub(super) fn warnings(&self, sweeps: u64) -> Vec<Warning> {
        let variance = self.variance();
        if variance == 0.0 {
            return vec![Warning::NothingMoved { sweeps }];
        }
        let mut evidence = Vec::new();
        if let Ok(drift) = drift(self.series) {
            let smallest =
                self.required_variance.map_or(0.0, |required| Self::SMALLEST_DRIFT * required.sqrt());
            if drift.deviation_from(0.0).abs() > Self::LARGEST_DRIFT && drift.mean.abs() > smallest {
                evidence.push(MixingEvidence::Drift { drift });
            }
        }
        let shift = self.shift();
        let smallest = Self::SMALLEST_SHIFT * self.required_variance.unwrap_or(0.0).sqrt();
        if shift.deviation_from(0.0).abs() > Self::LARGEST_DRIFT && shift.mean.abs() > smallest {
            evidence.push(MixingEvidence::Relaxing { shift });
        }
        let (quantity, effective_sample_size) = self.slowest;
        if effective_sample_size < FEWEST_INDEPENDENT {
            evidence.push(MixingEvidence::FewIndependent { quantity, effective_sample_size });
        }
        if let Some(required) = self.required_variance.filter(|required| variance < Self::QUIETEST * required)
        {
            evidence.push(MixingEvidence::TooQuiet { variance, required });
        }
        evidence.into_iter().map(|evidence| Warning::NotMixed { sweeps, evidence }).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::test_series::autoregressive;

    fn of(series: &[f64], required: f64) -> Mixing<'_> {
        let slowest = (Quantity::Column, independent(&[series]));
        Mixing { series, required_variance: Some(required), slowest }
    }

    /// Shares of 1000 stationary series with `size` independent numbers each that give any warning,
    /// and a warning of a drift.
    fn warned_of(length: usize, size: f64, required: f64) -> [f64; 2] {
        const SERIES: u64 = 1000;
        let memory = libm::exp(-2.0 * size / length as f64);
        let mut warned = [0.0; 2];
        for seed in 0..SERIES {
            let warnings = of(&autoregressive(memory, length, seed), required).warnings(1);
            let is_drift = |warning: &Warning| {
                matches!(warning, Warning::NotMixed { evidence: MixingEvidence::Drift { .. }, .. })
            };
            warned[0] += f64::from(u8::from(!warnings.is_empty())) / SERIES as f64;
            warned[1] += f64::from(u8::from(warnings.iter().any(is_drift))) / SERIES as f64;
        }
        warned
    }

    #[test]
    fn few_independent_numbers_are_warned_of_and_many_are_not() {
        for length in [64, 128] {
            assert!(warned_of(length, 0.25, 1.0)[0] > 0.95);
            assert!(warned_of(length, 1.0, 1.0)[0] > 0.6);
            assert!(warned_of(length, 10.0, 1.0)[0] < 0.06);
            let [any, drift] = warned_of(length, 64.0, 1.0);
            assert!(any < 0.02 && drift < 0.005, "{any} {drift}");
            // With an eighth of the equilibrium variance, half the limit, there is always a
            // warning. With half of that variance there are no more warnings than otherwise.
            assert!(warned_of(length, 64.0, 8.0)[0] > 0.99);
            assert!(warned_of(length, 64.0, 2.0)[0] < 0.02);
        }
        // The shortest series that is checked.
        assert!(warned_of(32, 16.0, 1.0)[1] < 0.01);
    }

    /// A start that relaxes within the first tenth gives a warning, although halves and
    /// autocorrelation time are inconspicuous.
    #[test]
    fn a_start_that_relaxes_is_warned_of() {
        for seed in 0..20 {
            let mut series = autoregressive(0.3, 128, seed);
            let relaxing = |warnings: &[Warning]| {
                warnings.iter().any(|warning| {
                    matches!(warning, Warning::NotMixed { evidence: MixingEvidence::Relaxing { .. }, .. })
                })
            };
            assert!(!relaxing(&of(&series, 1.0).warnings(7)));
            for (time, value) in (0..13).zip(&mut series) {
                *value += 25.0 * libm::exp(-0.3 * f64::from(time));
            }
            assert!(relaxing(&of(&series, 1.0).warnings(7)), "{seed}");
        }
    }

    #[test]
    fn a_series_that_moves_or_stands_still_is_warned_of() {
        let ramp: Vec<f64> = autoregressive(0.0, 256, 1)
            .iter()
            .zip(0..)
            .map(|(noise, i)| noise + 0.02 * f64::from(i))
            .collect();
        let warnings = of(&ramp, 1.0).warnings(7);
        assert!(
            matches!(warnings[0], Warning::NotMixed { sweeps: 7, evidence: MixingEvidence::Drift { drift } } if drift.mean > 2.0),
            "{warnings:?}"
        );
        let still = of(&[3.0; 256], 1.0).warnings(7);
        assert_eq!(still, [Warning::NothingMoved { sweeps: 7 }]);
        let still = of(&[12.7; 256], 1.0).warnings(7);
        assert_eq!(still, [Warning::NothingMoved { sweeps: 7 }]);
    }
}
