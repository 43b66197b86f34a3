//! Scenes that nothing is fitted to: what is true of them, and what `Scene::model_for` chooses.

use crate::reference::{Effort, Reference};
use gradient_mc::model::Quantity;
use paper::calibration::scenes::HeldOut;
use paper::calibration::unseen::{Count, HEADER, Judged, NAMES, PLAN, Truth, fluids, judge, line};
use paper::{Failure, Session, output};
use std::path::Path;

/// The noise of a reference in parts of the tolerance, as far as the CPU seconds allow.
const PART_OF_TOLERANCE: f64 = 1.0 / 3.0;
const MOST_SECONDS: f64 = 20.0;
const SWEEPS: u64 = 2000;
/// Seeds of one scene are apart from those of the next by this, and from those of the calibration.
const SEEDS: u64 = 10_000;
const FIRST_SEED: u64 = 1_000_000;
/// Simulations with more moves than this are not run.
const MOST_MOVES: f64 = 3e8;

/// A scene that was measured, and what became of the choices.
type Measured = (Vec<f64>, Vec<[f64; 4]>, Vec<Judged>);

/// Measures them, writes `model_scenes.csv` and `model_profiles.csv`, and judges the choices.
pub(crate) fn judge_all(count: usize, directory: &Path, session: &Session) -> Result<(), Failure> {
    output::create_directory(directory)?;
    let scenes = fluids(count)?;
    let measured: Vec<Measured> = session.run_each(
        "unseen scenes",
        scenes.clone(),
        |(number, _)| format!("scene {number}"),
        |(number, scene)| one(number, &scene, session),
    )?;
    output::write_csv(
        &directory.join("model_scenes.csv"),
        "cargo run --release -p paper --bin calibrate_models -- --unseen 40; number of the draw; T0 in m g d, alpha and beta per diameter, \
         N/A per square diameter; tolerances and noise of the reference in n, P and Z; replica k of a scene has the seed first_seed + k",
        "scene, temperature, field_rate, decay_rate, column_density, density_tolerance, pressure_tolerance, \
         compressibility_tolerance, density_noise, pressure_noise, compressibility_noise, particles, replicas, sweeps, first_seed, cpu_seconds",
        measured.iter().map(|(row, ..)| row.clone()),
    )?;
    output::write_csv(
        &directory.join("model_profiles.csv"),
        "number densities in bins one diameter high from x = 0, and their standard errors over replicas; see model_scenes.csv",
        "scene, bin, number_density, standard_error",
        measured.iter().flat_map(|(_, profile, _)| profile.iter().copied()),
    )?;
    println!("{HEADER}");
    for ((number, scene), (.., judged)) in scenes.iter().zip(&measured) {
        for judged in judged {
            println!("{}", line(*number, &scene.parameters, judged));
        }
    }
    let judged: Vec<Judged> = measured.into_iter().flat_map(|(.., judged)| judged).collect();
    println!("");
    for quantity in Quantity::ALL {
        println!("{}", summary(&Count::of(&judged, quantity), quantity, count));
    }
    Ok(())
}

/// What was counted, in words.
fn summary(count: &Count, quantity: Quantity, scenes: usize) -> String {
    let Count { right, wrong, not_run, close, dear, chosen, cheapest, always } = *count;
    let mut text = format!(
        "{quantity:?}: right {right} of {scenes}, wrong {wrong}, simulations not run {not_run}; within two errors of the tolerance {close}; \
         right, but too expensive {dear}"
    );
    for place in 0..=PLAN {
        let always =
            always.get(place).map_or(String::new(), |right| format!("; right if always chosen {right}"));
        let lines = [NAMES[place], ": chosen ", &chosen[place].to_string(), ", of these not too expensive "];
        text.push_str("\n  ");
        text.extend(lines);
        text.push_str(&cheapest[place].to_string());
        text.push_str(&always);
    }
    text
}

fn one(number: usize, scene: &HeldOut, session: &Session) -> Result<Measured, Failure> {
    let (sweeps, most_seconds, most_moves) =
        session.choose((SWEEPS, MOST_SECONDS, MOST_MOVES), (50, 0.0, 1e5));
    let column = scene.scene()?;
    let accuracies = scene.accuracies(&column)?;
    let seed = session.seed + FIRST_SEED + SEEDS * number as u64;
    let effort = Effort { sweeps, most_seconds, seed };
    let reference = Reference::measure(&column, effort, |reference| {
        accuracies
            .iter()
            .all(|accuracy| reference.noise_of(accuracy, &column) < PART_OF_TOLERANCE * accuracy.tolerance())
    })?;
    let noise = accuracies.map(|accuracy| reference.noise_of(&accuracy, &column));
    let truth = Truth { mean: &reference.densities, replicas: &reference.replicas };
    let judged = accuracies
        .iter()
        .zip(noise)
        .map(|(accuracy, noise)| judge(&column, accuracy, noise, truth, most_moves))
        .collect::<Result<Vec<_>, _>>()?;
    let parameters = scene.parameters;
    let mut row = vec![
        number as f64,
        parameters.temperature,
        parameters.field_rate,
        parameters.decay_rate,
        parameters.column_density,
    ];
    row.extend(scene.tolerances);
    row.extend(noise);
    row.extend([
        reference.particles as f64,
        reference.replicas.len() as f64,
        reference.sweeps as f64,
        seed as f64,
        reference.cpu_seconds,
    ]);
    let densities = reference.densities.iter().zip(&reference.errors).enumerate();
    let profile =
        densities.map(|(bin, (density, error))| [number as f64, bin as f64, *density, *error]).collect();
    Ok((row, profile, judged))
}
