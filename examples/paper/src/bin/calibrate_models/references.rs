//! References of the scenes that are not used in the fit, for `tests/model_for.rs`.

use crate::reference::{Effort, Reference};
use paper::calibration::scenes::{HeldOut, Parameters};
use paper::{Failure, Session, output};
use std::path::Path;

/// Scenes that do not freeze.
const WANTED: usize = 40;
/// Draws among which they are.
const DRAWN: usize = 60;
/// The noise of a reference in parts of the tolerance.
const PART_OF_TOLERANCE: f64 = 0.125;
const SMALLEST_NOISE: f64 = 9e-4;
const MOST_SECONDS: f64 = 25.0;
const SWEEPS: u64 = 2000;
/// Seeds of one scene are apart from those of the next by this.
const SEEDS: u64 = 10_000;

/// Measures them and writes `model_scenes.csv` and `model_profiles.csv`.
pub(crate) fn make(directory: &Path, session: &Session) -> Result<(), Failure> {
    output::create_directory(directory)?;
    let mut drawn = Vec::new();
    let mut fluids = 0;
    for (index, scene) in HeldOut::draw(DRAWN).into_iter().enumerate() {
        let freezes = scene.parameters.freezes()?;
        fluids += usize::from(!freezes);
        drawn.push((index, scene, freezes));
        if fluids == WANTED {
            break;
        }
    }
    let lengths = session.choose((SWEEPS, MOST_SECONDS), (50, 0.0));
    let measured = session.run_each(
        "scenes of the test",
        drawn,
        |(index, ..)| format!("scene {index}"),
        |(index, scene, freezes)| one(index, scene, freezes, session.seed + SEEDS * index as u64, lengths),
    )?;
    let scenes = measured.iter().map(|(row, _)| *row);
    let profiles = measured.iter().flat_map(|(_, profile)| profile.iter().copied());
    output::write_csv(
        &directory.join("model_scenes.csv"),
        "cargo run --release -p paper --bin calibrate_models -- --references; T0 in m g d, alpha and beta per diameter, N/A per square diameter; \
         total variation distances; replica k of a scene has the seed first_seed + k",
        "scene, temperature, field_rate, decay_rate, column_density, tolerance, freezes, \
         particles, replicas, sweeps, first_seed, noise, cpu_seconds",
        scenes,
    )?;
    output::write_csv(
        &directory.join("model_profiles.csv"),
        "number densities in bins one diameter high from x = 0, and their standard errors over replicas; see model_scenes.csv",
        "scene, bin, number_density, standard_error",
        profiles,
    )
}

/// A row of the scenes, and those of its profile.
type Measured = ([f64; 13], Vec<[f64; 4]>);

fn one(
    index: usize,
    scene: HeldOut,
    freezes: bool,
    first_seed: u64,
    (sweeps, most_seconds): (u64, f64),
) -> Result<Measured, Failure> {
    let HeldOut { parameters, tolerance } = scene;
    let Parameters { temperature, field_rate, decay_rate, column_density } = parameters;
    let number = index as f64;
    let known = [number, temperature, field_rate, decay_rate, column_density, tolerance];
    let mut row = [0.0; 13];
    row[..6].copy_from_slice(&known);
    row[6] = f64::from(u8::from(freezes));
    row[10] = first_seed as f64;
    if freezes {
        return Ok((row, Vec::new()));
    }
    let (particles, side) = Parameters::WIDE;
    let column = parameters.scene(particles, side)?;
    let noise = (PART_OF_TOLERANCE * tolerance).max(SMALLEST_NOISE);
    let effort = Effort { sweeps, noise, most_seconds, seed: first_seed };
    let reference = Reference::measure(&column, effort)?;
    row[7] = reference.particles as f64;
    row[8] = reference.replicas.len() as f64;
    row[9] = reference.sweeps as f64;
    row[11] = reference.noise();
    row[12] = reference.cpu_seconds;
    let densities = reference.densities.iter().zip(&reference.errors).enumerate();
    let profile = densities.map(|(bin, (density, error))| [number, bin as f64, *density, *error]).collect();
    eprintln!(
        "scene {index}: tolerance {tolerance}, noise {:.5}, {} replicas, {:.1} CPU s",
        reference.noise(),
        reference.replicas.len(),
        reference.cpu_seconds
    );
    Ok((row, profile))
}
