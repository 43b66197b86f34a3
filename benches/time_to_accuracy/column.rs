//! What is measured of a column, and how far it is from the reference.

use crate::methods::Engine;
use paper::Failure;
use std::fmt;

pub(crate) const TEMPERATURE: f64 = 20.0;
pub(crate) const HEIGHT: f64 = 400.0;
const COLUMN_DENSITY: f64 = 40.0;
const BINS: usize = 100;
const BIN_HEIGHT: f64 = 4.0;
/// Below this bin are the layers at the wall.
const BULK_BEGINS: usize = 2;
/// Packing fraction 0.05, in spheres per cubic diameter.
const BULK_DENSITY: f64 = 0.0955;

/// Spheres over a square base of this side.
pub(crate) fn particles(width: f64) -> usize {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let particles = (COLUMN_DENSITY * width * width).round() as usize;
    particles
}

/// Averages over a stretch of a run.
#[derive(Debug, Clone)]
pub(crate) struct Profile {
    pub(crate) center_of_mass: f64,
    density: Vec<f64>,
    pressure: Vec<f64>,
}

impl Profile {
    pub(crate) fn mean(profiles: &[Self]) -> Self {
        let count = profiles.len() as f64;
        let mean = |of: &dyn Fn(&Self) -> f64| profiles.iter().map(of).sum::<f64>() / count;
        Self {
            center_of_mass: mean(&|profile| profile.center_of_mass),
            density: (0..BINS).map(|bin| mean(&|profile| profile.density[bin])).collect(),
            pressure: (0..BINS).map(|bin| mean(&|profile| profile.pressure[bin])).collect(),
        }
    }
}

/// Makes sweeps, and averages over every fifth configuration; over more of a short stretch.
pub(crate) fn observe(engine: &mut dyn Engine, width: f64, sweeps: u64) -> Result<Profile, Failure> {
    let interval = (sweeps / 250).clamp(1, 5);
    let (mut counts, mut sum, mut spheres, mut frames, mut done) = (vec![0.0; BINS], 0.0, 0.0, 0.0, 0);
    while done < sweeps {
        let stretch = interval.min(sweeps - done);
        engine.sweep(stretch)?;
        done += stretch;
        frames += 1.0;
        engine.heights(&mut |height| {
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let bin = ((height / BIN_HEIGHT) as usize).min(BINS - 1);
            counts[bin] += 1.0;
            sum += height;
            spheres += 1.0;
        });
    }
    let area = width * width;
    let density: Vec<f64> = counts.iter().map(|count| count / (frames * area * BIN_HEIGHT)).collect();
    // The weight above the middle of the bin.
    let mut above = 0.0;
    let mut pressure: Vec<f64> = density
        .iter()
        .rev()
        .map(|density| {
            above += density * BIN_HEIGHT;
            above - 0.5 * density * BIN_HEIGHT
        })
        .collect();
    pressure.reverse();
    Ok(Profile { center_of_mass: sum / spheres, density, pressure })
}

/// Relative root-mean-square errors; of profiles, over the bulk.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Errors {
    pub(crate) center_of_mass: f64,
    pub(crate) density: f64,
    pub(crate) pressure: f64,
}

impl Errors {
    pub(crate) fn of(profiles: &[Profile], reference: &Profile) -> Self {
        let bulk: Vec<usize> =
            (BULK_BEGINS..BINS).filter(|&bin| reference.density[bin] > BULK_DENSITY).collect();
        let rms = |values: &mut dyn Iterator<Item = f64>| {
            let (mut squares, mut count) = (0.0, 0.0);
            for value in values {
                squares += value * value;
                count += 1.0;
            }
            f64::sqrt(squares / count)
        };
        let over_bulk = |of: fn(&Profile) -> &[f64]| {
            let pairs = profiles
                .iter()
                .flat_map(|profile| bulk.iter().map(move |&bin| of(profile)[bin] / of(reference)[bin] - 1.0));
            rms(&mut { pairs })
        };
        Self {
            center_of_mass: rms(&mut profiles
                .iter()
                .map(|profile| profile.center_of_mass / reference.center_of_mass - 1.0)),
            density: over_bulk(|profile| &profile.density),
            pressure: over_bulk(|profile| &profile.pressure),
        }
    }

    pub(crate) fn largest(&self) -> f64 {
        self.center_of_mass.max(self.density).max(self.pressure)
    }
}

impl fmt::Display for Errors {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = [self.center_of_mass, self.density, self.pressure].map(|error| 100.0 * error);
        write!(formatter, "h_c {:.2} %, n {:.2} %, P {:.2} %", percent[0], percent[1], percent[2])
    }
}
