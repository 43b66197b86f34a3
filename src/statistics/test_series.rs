//! Series of known statistics, for the tests.

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Gaussian autoregressive series x(t+1) = φ x(t) + noise, variance 1, stationary from the start.
/// Its autocorrelation is φ^t, so τ = (1 + φ)/(1 − φ)/2, and φ = 0 is white noise.
pub(crate) struct Autoregressive {
    generator: Pcg64Mcg,
    correlation: f64,
    value: f64,
}

impl Autoregressive {
    pub(crate) fn new(correlation: f64, seed: u64) -> Self {
        let mut generator = Pcg64Mcg::seed_from_u64(seed);
        let value = gaussian(&mut generator);
        Self { generator, correlation, value }
    }
}

impl Iterator for Autoregressive {
    type Item = f64;
    fn next(&mut self) -> Option<f64> {
        let value = self.value;
        let noise = (1.0 - self.correlation * self.correlation).sqrt();
        self.value = self.correlation * value + noise * gaussian(&mut self.generator);
        Some(value)
    }
}

/// Box and Muller's transformation, one of its two numbers.
fn gaussian(generator: &mut Pcg64Mcg) -> f64 {
    let radius = (-2.0 * (1.0 - generator.random::<f64>()).ln()).sqrt();
    radius * (std::f64::consts::TAU * generator.random::<f64>()).cos()
}

pub(crate) fn autoregressive(correlation: f64, length: usize, seed: u64) -> Vec<f64> {
    Autoregressive::new(correlation, seed).take(length).collect()
}
