//! A simulation followed in time: stretches that double, until patience ends.

use crate::column;
use crate::method::{Method, Moves};
use crate::point::{Point, Way};
use crate::profile::{Errors, Profile};
use crate::reference::Reference;
use crate::system::System;
use paper::Failure;

/// Sweeps of the shortest equilibration and of the shortest measurement.
const SHORTEST: u64 = 32;
/// Replicas that are averaged for two threads.
const TEAM: usize = 2;

/// A replica of a method.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Task {
    pub(crate) system: System,
    pub(crate) method: Method,
    pub(crate) seed: u64,
    /// CPU seconds of the longest run that is waited for.
    pub(crate) patience: f64,
}

/// A run of so many sweeps of equilibration and as many of measurement.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
pub(crate) struct Checkpoint {
    pub(crate) sweeps: u64,
    pub(crate) seconds: f64,
    pub(crate) profile: Profile,
}

impl Task {
    /// In words.
    pub(crate) fn name(&self) -> String {
        format!("{}, {}, seed {}", self.system.title(), self.method, self.seed)
    }

    /// Runs of 32, 64, 128 ... sweeps of equilibration and as many of measurement each. They share
    /// their equilibration; the time of a run includes its whole equilibration.
    pub(crate) fn follow(&self) -> Result<Vec<Checkpoint>, Failure> {
        let (mut column, mut seconds) = column::build(self.system, self.method, self.seed)?;
        let mut checkpoints = Vec::new();
        let mut equilibrated = 0;
        // An equation of state from fewer than 64 frames is too noisy.
        let mut sweeps = if self.method.moves == Moves::OwnEquation { 2 * SHORTEST } else { SHORTEST };
        loop {
            seconds += column.equilibrate(sweeps - equilibrated)?;
            equilibrated = sweeps;
            let stretch = column.measure(sweeps, self.method.moves)?;
            let total = seconds + stretch.seconds;
            checkpoints.push(Checkpoint { sweeps, seconds: total, profile: stretch.profile });
            if 2.0 * total > self.patience {
                return Ok(checkpoints);
            }
            sweeps *= 2;
        }
    }
}

/// The points of a method: of one thread, and of two where replicas can be paired.
pub(crate) fn points(method: Method, replicas: &[Vec<Checkpoint>], reference: &Reference) -> Vec<Point> {
    let common = replicas.iter().map(Vec::len).min().unwrap_or(0);
    let mut points = Vec::new();
    for threads in [1, TEAM] {
        for index in 0..common {
            let teams: Vec<(f64, Profile)> = replicas
                .chunks_exact(threads)
                .map(|team| {
                    let slowest = team.iter().map(|replica| replica[index].seconds).fold(0.0, f64::max);
                    let profiles: Vec<&Profile> =
                        team.iter().map(|replica| &replica[index].profile).collect();
                    (slowest, Profile::mean(&profiles))
                })
                .collect();
            if teams.is_empty() {
                continue;
            }
            let errors: Vec<Errors> =
                teams.iter().map(|(_, profile)| profile.errors(&reference.profile)).collect();
            let claims: Vec<Errors> = teams.iter().map(|(_, profile)| profile.claims()).collect();
            points.push(Point {
                way: Way::Simulation { method, threads, sweeps: replicas[0][index].sweeps },
                seconds: teams.iter().map(|(seconds, _)| seconds).sum::<f64>() / teams.len() as f64,
                errors: Errors::root_mean_square(&errors),
                // Errors of the smooth part are not estimated.
                claims: (method.moves != Moves::OwnEquation).then(|| Errors::root_mean_square(&claims)),
            });
        }
    }
    points
}
