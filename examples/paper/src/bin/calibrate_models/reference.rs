//! Reference profiles of a column: long runs of independent replicas.

use gradient_mc::model::{Accuracy, MonteCarloPlan, MoveFamily};
use paper::Failure;
use paper::calibration::scenes::Column;
use paper::clock::cpu_seconds;

/// A reference profile.
#[derive(Debug, Clone)]
pub(crate) struct Reference {
    pub(crate) particles: usize,
    pub(crate) sweeps: u64,
    pub(crate) replicas: Vec<Vec<f64>>,
    pub(crate) densities: Vec<f64>,
    pub(crate) errors: Vec<f64>,
    pub(crate) cpu_seconds: f64,
}

/// Parameters of a reference run.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Effort {
    pub(crate) sweeps: u64,
    pub(crate) most_seconds: f64,
    pub(crate) seed: u64,
}

/// The mean of profiles, bin by bin.
pub(crate) fn mean(profiles: &[Vec<f64>]) -> Vec<f64> {
    let mean = |bin: usize| profiles.iter().map(|profile| profile[bin]).sum::<f64>() / profiles.len() as f64;
    (0..profiles[0].len()).map(mean).collect()
}

impl Reference {
    const FEWEST: usize = 8;

    /// Event chains with tuned local moves in between, which settle dense and dilute columns alike,
    /// replica by replica until they are enough.
    pub(crate) fn measure(
        scene: &Column,
        effort: Effort,
        is_enough: impl Fn(&Self) -> bool,
    ) -> Result<Self, Failure> {
        let started = cpu_seconds();
        let particles = scene.particles();
        let plan = MonteCarloPlan::new(scene, particles, MoveFamily::Chains, effort.sweeps)?;
        let mut replicas: Vec<Vec<f64>> = Vec::new();
        loop {
            let replica = replicas.len() as u64;
            replicas.push(plan.densities(scene, effort.seed.wrapping_add(replica))?);
            if replicas.len() < Self::FEWEST {
                continue;
            }
            let cpu_seconds = cpu_seconds() - started;
            let reference = Self::of(replicas, particles, effort.sweeps, cpu_seconds);
            if is_enough(&reference) || cpu_seconds > effort.most_seconds {
                return Ok(reference);
            }
            replicas = reference.replicas;
        }
    }

    fn of(replicas: Vec<Vec<f64>>, particles: usize, sweeps: u64, cpu_seconds: f64) -> Self {
        let count = replicas.len() as f64;
        let densities = mean(&replicas);
        let error = |(bin, density): (usize, &f64)| {
            let deviations = replicas.iter().map(|profile| profile[bin] - density);
            (deviations.map(|deviation| deviation * deviation).sum::<f64>() / (count * (count - 1.0))).sqrt()
        };
        let errors = densities.iter().enumerate().map(error).collect();
        Self { particles, sweeps, replicas, densities, errors, cpu_seconds }
    }

    /// Total variation distance that the error bars amount to, as if they were Gaussian: ½ √(2/π) Σ
    /// σ / Σ n.
    pub(crate) fn noise(&self) -> f64 {
        0.5 * std::f64::consts::FRAC_2_PI.sqrt() * self.errors.iter().sum::<f64>()
            / self.densities.iter().sum::<f64>()
    }

    /// The error of the mean of the replicas, from their scatter.
    pub(crate) fn noise_of(&self, accuracy: &Accuracy, scene: &Column) -> f64 {
        let squares = self.replicas.iter().map(|replica| accuracy.error(scene, replica, &self.densities));
        let sum: f64 = squares.map(|error| error * error).sum();
        let count = self.replicas.len() as f64;
        (sum / (count * (count - 1.0))).sqrt()
    }
}
