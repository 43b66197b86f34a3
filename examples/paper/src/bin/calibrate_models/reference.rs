//! What is true of a column: long runs of independent replicas.

use gradient_mc::model::{MonteCarloPlan, MoveFamily};
use paper::Failure;
use paper::calibration::scenes::Column;
use paper::clock::cpu_seconds;

/// A profile that is taken for true.
#[derive(Debug, Clone)]
pub(crate) struct Reference {
    pub(crate) particles: usize,
    pub(crate) sweeps: u64,
    pub(crate) replicas: u64,
    pub(crate) densities: Vec<f64>,
    pub(crate) errors: Vec<f64>,
    pub(crate) cpu_seconds: f64,
}

/// How a reference is to be made.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Effort {
    pub(crate) sweeps: u64,
    /// Total variation distance by noise at which replicas are enough.
    pub(crate) noise: f64,
    pub(crate) most_seconds: f64,
    pub(crate) seed: u64,
}

impl Reference {
    const FEWEST: usize = 8;

    /// Event chains with tuned local moves in between, which settle dense and dilute columns alike, replica by replica until the
    /// noise is small enough.
    pub(crate) fn measure(scene: &Column, effort: Effort) -> Result<Self, Failure> {
        let started = cpu_seconds();
        let particles = scene.particles();
        let plan = MonteCarloPlan::new(scene, particles, MoveFamily::Chains, effort.sweeps)?;
        let mut profiles: Vec<Vec<f64>> = Vec::new();
        loop {
            let replica = profiles.len() as u64;
            profiles.push(plan.densities(scene, effort.seed.wrapping_add(replica))?);
            if profiles.len() < Self::FEWEST {
                continue;
            }
            let reference = Self::of(&profiles, particles, effort.sweeps, cpu_seconds() - started);
            if reference.noise() < effort.noise || reference.cpu_seconds > effort.most_seconds {
                return Ok(reference);
            }
        }
    }

    fn of(profiles: &[Vec<f64>], particles: usize, sweeps: u64, cpu_seconds: f64) -> Self {
        let replicas = profiles.len() as f64;
        let bins = profiles[0].len();
        let mean = |bin: usize| profiles.iter().map(|profile| profile[bin]).sum::<f64>() / replicas;
        let densities: Vec<f64> = (0..bins).map(mean).collect();
        let errors = (0..bins)
            .map(|bin| {
                let squares: f64 = profiles
                    .iter()
                    .map(|profile| (profile[bin] - densities[bin]) * (profile[bin] - densities[bin]))
                    .sum();
                (squares / (replicas * (replicas - 1.0))).sqrt()
            })
            .collect();
        Self { particles, sweeps, replicas: profiles.len() as u64, densities, errors, cpu_seconds }
    }

    /// Total variation distance that the error bars amount to, as if they were Gaussian: ½ √(2/π) Σ σ / Σ n.
    pub(crate) fn noise(&self) -> f64 {
        0.5 * std::f64::consts::FRAC_2_PI.sqrt() * self.errors.iter().sum::<f64>()
            / self.densities.iter().sum::<f64>()
    }
}
