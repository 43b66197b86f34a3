//! `Scene::model_for` on forty scenes that were not used in the fit, and on some that freeze.
//!
//! What is true of each was measured beforehand (`tests/reference/model_scenes.csv`, by
//! `calibrate_models --unseen 40`, which judges the choices as well, with long simulations). Here
//! simulations are run where they are short. `-- --nocapture` prints the table.

#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use gradient_mc::equation_of_state::{FREEZING, FluidSolid};
use gradient_mc::model::{Accuracy, Model, ModelChoice, Quantity};
use gradient_mc::{Error, HydrostaticProfile};
use paper::calibration::data::Data;
use paper::calibration::fit::{self, Constants};
use paper::calibration::scenes::{HeldOut, Parameters};
use paper::calibration::unseen::{Count, HEADER, Truth, fluids, judge, line};
use std::path::Path;

/// Simulations with more moves than this are not run.
const MOST_MOVES: f64 = 1e7;

/// The rows of a reference file.
fn rows(name: &str) -> Vec<Vec<f64>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference").join(name);
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path).unwrap();
    let parse = |record: csv::StringRecord| record.iter().map(|field| field.parse().unwrap()).collect();
    reader.records().map(|record| parse(record.unwrap())).collect()
}

/// Cost of a model: its place among ideal gas, theory, functional and simulation.
fn cost(model: &Model) -> usize {
    match model {
        Model::IdealGas(_) => 0,
        Model::Hydrostatics(_) => 1,
        Model::DensityFunctional(_) => 2,
        _ => 3,
    }
}

#[test]
fn forty_unseen_scenes() {
    let (known, profiles) = (rows("model_scenes.csv"), rows("model_profiles.csv"));
    let scenes = fluids(40).unwrap();
    assert_eq!(known.len(), scenes.len());
    println!("{HEADER}");
    let mut judged = Vec::new();
    for ((number, scene), row) in scenes.iter().zip(&known) {
        // The file holds what the generator drew, and nothing that was picked.
        let Parameters { temperature, field_rate, decay_rate, column_density } = scene.parameters;
        let drawn = [*number as f64, temperature, field_rate, decay_rate, column_density];
        let drawn = drawn.iter().chain(&scene.tolerances);
        assert!(drawn.zip(row).all(|(drawn, known)| (drawn - known).abs() < 1e-9), "scene {number}");
        let mean: Vec<f64> = profiles
            .iter()
            .filter(|profile| (profile[0] - row[0]).abs() < 0.5)
            .map(|profile| profile[2])
            .collect();
        let column = scene.scene().unwrap();
        assert!((mean.len() as f64 - column.slab().height()).abs() < 1e-9, "of another slab");
        let truth = Truth { mean: &mean, replicas: &[] };
        for (accuracy, noise) in scene.accuracies(&column).unwrap().iter().zip(&row[8..11]) {
            let one = judge(&column, accuracy, *noise, truth, MOST_MOVES).unwrap();
            println!("{}", line(*number, &scene.parameters, &one));
            judged.push(one);
        }
    }
    for (place, quantity) in Quantity::ALL.into_iter().enumerate() {
        let count = Count::of(&judged, quantity);
        println!("{quantity:?}: {count:?}");
        // References that do not resolve half of the tolerance.
        let poor = known.iter().filter(|row| row[8 + place] >= 0.5 * row[5 + place]).count();
        assert!(poor <= 3, "{quantity:?}: {poor}");
        assert!(count.wrong <= 2 && count.right >= 30 && count.dear <= 6, "{quantity:?}: {count:?}");
        // Each formula is chosen at times, and rules that are wrong fail the same criterion.
        assert!(count.chosen[1] >= 4 && count.chosen[2] >= 4, "{quantity:?}: {count:?}");
        assert!(count.always[..2].iter().all(|&right| right < 38), "{quantity:?}: {count:?}");
    }
}

/// Spheres per area that are denser than a fluid can be; fewer than 0.89 do not freeze.
fn dense_layer(profile: &HydrostaticProfile) -> f64 {
    let steps = 1 << 14;
    let width = (profile.top() - profile.base()) / f64::from(steps);
    let heights = (0..steps).map(|step| profile.base() + (f64::from(step) + 0.5) * width);
    heights
        .filter(|&height| profile.packing_fraction(height) > FREEZING)
        .map(|height| profile.number_density(height) * width)
        .sum()
}

#[test]
fn a_column_that_freezes_is_not_promised_anything() {
    let mut frozen = 0;
    for HeldOut { parameters, tolerances: [tolerance, ..], .. } in HeldOut::draw(1000) {
        if !parameters.freezes().unwrap() {
            continue;
        }
        let (particles, side) = Parameters::WIDE;
        let scene = parameters.scene(particles, side).unwrap();
        if dense_layer(&scene.hydrostatics(&FluidSolid::default()).unwrap()) < 1.0 {
            continue;
        }
        frozen += 1;
        let choice = scene.model_for(Accuracy::density(tolerance).unwrap());
        let choice = choice.unwrap_or_else(|error| panic!("{parameters:?}: {error}"));
        assert!(!choice.is_adequate(), "{choice}");
        assert!(choice.freezing().is_some());
        assert!(choice.to_string().contains("the column freezes between"), "{choice}");
    }
    println!("{frozen} columns that freeze");
    assert!(frozen >= 8, "{frozen}");
}

#[test]
fn constants_follow_from_the_calibration_files() {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("calibration");
    let (constants, _) = fit::fit(&Data::read(&directory).unwrap()).unwrap();
    let (fitted, used) = (constants.numbers(), Constants::USED.numbers());
    assert_eq!(fitted.len(), used.len());
    for (fitted, used) in fitted.iter().zip(&used) {
        assert!((fitted - used).abs() <= 1e-3 * used.abs() + 1e-6, "{fitted} instead of {used}");
    }
}

/// What is expected of a formula does not depend on the tolerance, and a smaller tolerance never
/// has a cheaper model.
#[test]
fn a_smaller_tolerance_never_costs_less() {
    let (particles, side) = Parameters::WIDE;
    let parameters = Parameters { temperature: 2.0, field_rate: 0.02, decay_rate: 0.01, column_density: 2.0 };
    let scene = parameters.scene(particles, side).unwrap();
    for quantity in Quantity::ALL {
        let mut previous: Option<ModelChoice> = None;
        // Of P and Z below these the lid of this scene carries too much.
        let tolerances = if quantity == Quantity::Density { 8 } else { 6 };
        for tolerance in [0.5, 0.2, 0.1, 0.03, 0.01, 0.003, 0.001, 1e-4].into_iter().take(tolerances) {
            let choice = scene.model_for(Accuracy::new(quantity, tolerance).unwrap()).unwrap();
            assert!(choice.is_adequate() && choice.best().expected_error <= tolerance, "{choice}");
            if let Some(previous) = &previous {
                assert!(choice.best().expected_moves >= previous.best().expected_moves, "{previous}{choice}");
                assert!(cost(choice.model()) >= cost(previous.model()), "{previous}{choice}");
                let [now, before] = [&choice, previous].map(|choice| choice.candidates()[1].expected_error);
                assert!((now - before).abs() < 1e-15);
            }
            previous = Some(choice);
        }
    }
    let finer = scene.model_for(Accuracy::pressure(1e-3).unwrap()).unwrap();
    assert!(
        !finer.is_adequate() && finer.to_string().contains("the wall at the open end carries"),
        "{finer}"
    );
    // Heights at which there is nothing.
    let nowhere = Accuracy::pressure(0.1).unwrap().between(1e4, 2e4).unwrap();
    assert!(matches!(scene.model_for(nowhere), Err(Error::InvalidParameter { .. })));
}
