//! Whether the centre of mass has seen what it should.

use crate::Warning;
use crate::statistics::{Estimate, autocorrelation, blocking, drift};
use crate::warning::MixingEvidence;

/// The series of the centre of mass, and what equilibrium demands of it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mixing<'a> {
    series: &'a [f64],
    required_variance: Option<f64>,
}

impl<'a> Mixing<'a> {
    /// A drift of more standard errors than this is no accident.
    const LARGEST_DRIFT: f64 = 4.0;
    /// Nor does one below this many standard deviations of an equilibrium configuration matter: the error bar of a run
    /// that has seen a few independent ones is as large.
    const SMALLEST_DRIFT: f64 = 0.75;
    /// Correlation times of so short a series come out too short: this many stands for some 12.
    const FEWEST_INDEPENDENT: f64 = 20.0;
    /// Sixteen independent numbers have a smaller part of their variance once in a thousand runs.
    const QUIETEST: f64 = 0.25;

    pub(super) fn new(series: &'a [f64], required_variance: Option<f64>) -> Self {
        Self { series, required_variance }
    }

    /// Height of the centre of mass; its error is NaN if the series is too short for one.
    pub(super) fn center_of_mass(&self) -> Estimate {
        blocking(self.series).unwrap_or(Estimate::new(f64::NAN, f64::NAN))
    }

    fn variance(&self) -> f64 {
        let count = self.series.len() as f64;
        let mean = self.series.iter().sum::<f64>() / count;
        self.series.iter().map(|height| (height - mean) * (height - mean)).sum::<f64>() / count
    }

    /// Number of independent configurations.
    fn effective_sample_size(&self) -> f64 {
        match autocorrelation(self.series) {
            Ok(result) => result.effective_sample_size,
            // It asks for 50 τ, and the number is N/(2τ).
            Err(crate::Error::TooFewObservations { available, needed }) => {
                25.0 * available as f64 / needed as f64
            }
            // A series that never changes.
            Err(_) => 1.0,
        }
    }

    pub(super) fn warnings(&self, sweeps: u64) -> Vec<Warning> {
        let mut evidence = Vec::new();
        let variance = self.variance();
        if let Ok(drift) = drift(self.series) {
            let smallest =
                self.required_variance.map_or(0.0, |required| Self::SMALLEST_DRIFT * required.sqrt());
            if drift.deviation_from(0.0).abs() > Self::LARGEST_DRIFT && drift.mean.abs() > smallest {
                evidence.push(MixingEvidence::Drift { drift });
            }
        }
        let effective_sample_size = self.effective_sample_size();
        if effective_sample_size < Self::FEWEST_INDEPENDENT {
            evidence.push(MixingEvidence::FewIndependent { effective_sample_size });
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

    #[test]
    fn calibration() {
        for length in [128, 256, 512] {
            for size in [2.0, 4.0, 8.0, 12.0, 16.0, 24.0, 32.0, 48.0, 64.0, 96.0_f64] {
                let time = length as f64 / (2.0 * size);
                let memory = libm::exp(-1.0 / time);
                let mut flags = [0; 4];
                for seed in 0..1000 {
                    let series = autoregressive(memory, length, seed);
                    let warnings = Mixing::new(&series, Some(1.0)).warnings(1);
                    for w in &warnings {
                        let Warning::NotMixed { evidence, .. } = w else { panic!() };
                        flags[match evidence {
                            MixingEvidence::Drift { .. } => 0,
                            MixingEvidence::FewIndependent { .. } => 1,
                            _ => 2,
                        }] += 1;
                    }
                    flags[3] += usize::from(!warnings.is_empty());
                }
                println!(
                    "{length} {size}: drift {} few {} quiet {} any {}",
                    flags[0], flags[1], flags[2], flags[3]
                );
            }
        }
    }
}
