//! `Scene::model_for` on forty scenes that nothing was fitted to, and on some that freeze.
//!
//! What is true of each was measured beforehand (`tests/reference/model_scenes.csv`). The recommended model is run for real. `-- --nocapture` prints the
//! table.

#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use gradient_mc::Error;
use gradient_mc::equation_of_state::ModifiedKolafa;
use gradient_mc::model::{IdealColumn, Model, ModelChoice, MonteCarloPlan, Reason, total_variation_distance};
use paper::calibration::data::{Base, ColumnRow, Plan, Seeds};
use paper::calibration::fit;
use paper::calibration::scenes::{Column, HeldOut, Parameters};
use rustix::time::{ClockId, clock_gettime};
use std::path::Path;

/// Seeds over which the error of a candidate of the ladder of plans is averaged.
const SEEDS: u64 = 3;
/// A choice may cost this many times what the cheapest adequate model costs.
const FACTOR: f64 = 3.0;

fn cpu_seconds() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// Least CPU time of three turns: what else the machine does only adds to it.
fn time<Output>(mut work: impl FnMut() -> Output) -> f64 {
    let mut least = f64::INFINITY;
    for _ in 0..3 {
        let started = cpu_seconds();
        std::hint::black_box(work());
        least = least.min(cpu_seconds() - started);
    }
    least
}

/// The rows of a reference file.
fn rows(name: &str) -> Vec<Vec<f64>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference").join(name);
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path).unwrap();
    let parse = |record: csv::StringRecord| record.iter().map(|field| field.parse().unwrap()).collect();
    reader.records().map(|record| parse(record.unwrap())).collect()
}

/// A held-out scene with what is true of it.
struct Known {
    parameters: Parameters,
    tolerance: f64,
    noise: f64,
    densities: Vec<f64>,
}

fn known() -> Vec<Known> {
    let profiles = rows("model_profiles.csv");
    let mut scenes = Vec::new();
    for row in rows("model_scenes.csv") {
        let &[number, temperature, field_rate, decay_rate, column_density, tolerance, freezes, .., noise, _] =
            &row[..]
        else {
            panic!("a row of model_scenes.csv has the wrong number of fields")
        };
        if freezes == 0.0 {
            let of_scene = profiles.iter().filter(|profile| (profile[0] - number).abs() < 0.5);
            let densities = of_scene.map(|profile| profile[2]).collect();
            let parameters = Parameters { temperature, field_rate, decay_rate, column_density };
            scenes.push(Known { parameters, tolerance, noise, densities });
        }
    }
    scenes
}

/// A model that was run: its error, and the CPU seconds it took.
#[derive(Debug, Clone, Copy)]
struct Run {
    error: f64,
    seconds: f64,
}

/// The formulas on one scene.
fn formulas(scene: &Column, truth: &[f64]) -> [Run; 2] {
    let ideal = || IdealColumn::new(scene).unwrap();
    let theory = || scene.hydrostatics(&ModifiedKolafa).unwrap();
    let error = |model: Model| total_variation_distance(&model.densities(scene, 0).unwrap(), truth);
    [
        Run { error: error(Model::IdealGas(ideal())), seconds: time(ideal) },
        Run { error: error(Model::Hydrostatics(theory())), seconds: time(theory) },
    ]
}

fn run_plan(plan: &MonteCarloPlan, scene: &Column, truth: &[f64], seed: u64) -> Run {
    let started = cpu_seconds();
    let densities = plan.densities(scene, seed).unwrap();
    Run { seconds: cpu_seconds() - started, error: total_variation_distance(&densities, truth) }
}

/// The shortest plan of the ladder whose error, root mean square over seeds, is below the tolerance; the longest is the last resort.
fn cheapest_plan(plan: &MonteCarloPlan, scene: &Column, truth: &[f64], tolerance: f64) -> (String, Run) {
    let mut last = ("none".to_owned(), Run { error: f64::INFINITY, seconds: f64::INFINITY });
    for (label, factor) in [("1/9", 1.0 / 9.0), ("1/3", 1.0 / 3.0), ("1", 1.0), ("3", 3.0)] {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let plan = plan.with_sweeps((factor * plan.sweeps() as f64).round() as u64);
        let runs: Vec<Run> = (0..SEEDS).map(|seed| run_plan(&plan, scene, truth, 100 + seed)).collect();
        let mean = |of: fn(&Run) -> f64| runs.iter().map(of).sum::<f64>() / SEEDS as f64;
        let run = Run { error: mean(|run| run.error * run.error).sqrt(), seconds: mean(|run| run.seconds) };
        last = (format!("{label} of the plan"), run);
        if run.error <= tolerance {
            break;
        }
    }
    last
}

/// What became of one scene.
struct Outcome {
    /// Of the choice.
    is_right: bool,
    is_cheap: bool,
    /// Place of the choice among ideal gas, theory and simulation.
    candidate: usize,
    /// Had one always taken the ideal gas, or the theory: right, and cheap.
    always: [(bool, bool); 2],
    /// Had one always simulated: cheap.
    simulated_is_cheap: bool,
}

fn judge(index: usize, known: &Known) -> Outcome {
    let (particles, side) = Parameters::WIDE;
    let scene = known.parameters.scene(particles, side).unwrap();
    let (truth, tolerance) = (&known.densities[..], known.tolerance);
    assert!((truth.len() as f64 - scene.slab().height()).abs() < 1e-9, "the reference is of another slab");
    let choice = scene.model_for(tolerance).unwrap();
    assert!(choice.is_adequate(), "no adequate model for a fluid:\n{choice}");
    let formulas = formulas(&scene, truth);
    let candidate = match choice.model() {
        Model::IdealGas(_) => 0,
        Model::Hydrostatics(_) => 1,
        _ => 2,
    };
    let plan = match &choice.candidates()[2].model {
        Model::MonteCarlo(plan) => *plan,
        other => panic!("{other} is not a plan"),
    };
    let simulated = (candidate == 2).then(|| run_plan(&plan, &scene, truth, 1));
    let chosen = simulated.unwrap_or_else(|| formulas[candidate.min(1)]);
    let names = ["ideal gas", "theory"];
    let adequate = formulas.iter().position(|run| run.error <= tolerance);
    let (cheapest, least) = match adequate {
        Some(first) => (names[first].to_owned(), formulas[first]),
        None => cheapest_plan(&plan, &scene, truth, tolerance),
    };
    let is_right = chosen.error <= tolerance;
    let ratio = chosen.seconds / least.seconds;
    let Parameters { temperature, field_rate, decay_rate, column_density } = known.parameters;
    let best = choice.best();
    let name = match choice.model() {
        Model::MonteCarlo(plan) => {
            format!("{} x {} sweeps {:?}", plan.particles(), plan.sweeps(), plan.family())
        }
        _ => names[candidate.min(1)].to_owned(),
    };
    println!(
        "{index:>2} {temperature:>6} {field_rate:>8} {decay_rate:>8} {column_density:>7} {:>7.2} {name:>30} {:>8.3} {:>8.3}{} {:>9.3} {:>9.3} {cheapest:>16} {:>8.3} {ratio:>6.2}{}   {:.3}",
        100.0 * tolerance,
        100.0 * best.expected_error,
        100.0 * chosen.error,
        if is_right { ' ' } else { '!' },
        1e3 * best.expected_seconds,
        1e3 * chosen.seconds,
        100.0 * least.error,
        if ratio <= FACTOR { ' ' } else { '!' },
        100.0 * known.noise,
    );
    let always = [0, 1].map(|formula| {
        let run = formulas[formula];
        (run.error <= tolerance, run.error <= tolerance && run.seconds <= FACTOR * least.seconds)
    });
    Outcome {
        is_right,
        is_cheap: is_right && ratio <= FACTOR,
        candidate,
        always,
        simulated_is_cheap: choice.candidates()[2].expected_seconds <= FACTOR * least.seconds,
    }
}

#[test]
fn forty_unseen_scenes() {
    let scenes = known();
    assert_eq!(scenes.len(), 40);
    let drawn: Vec<HeldOut> = HeldOut::draw(60);
    for known in &scenes {
        // The file holds what the generator drew, and nothing that was picked.
        let HeldOut { parameters, tolerance } =
            drawn.iter().find(|drawn| drawn.parameters == known.parameters).unwrap();
        assert!((tolerance - known.tolerance).abs() < 1e-12 && !parameters.freezes().unwrap());
        assert!(known.noise < 0.5 * known.tolerance, "a reference that is not known well enough");
    }
    println!(
        "      T0    alpha     beta     N/A  tol, %                          choice expected    true, %     CPU ms:   true  cheapest adequate  error, %  ratio  noise, %"
    );
    let outcomes: Vec<Outcome> =
        scenes.iter().enumerate().map(|(index, known)| judge(index, known)).collect();
    let count = |of: &dyn Fn(&Outcome) -> bool| outcomes.iter().filter(|outcome| of(outcome)).count();
    let (right, cheap) = (count(&|outcome| outcome.is_right), count(&|outcome| outcome.is_cheap));
    println!(
        "error below the tolerance: {right} of 40; within a factor {FACTOR} of the cheapest adequate: {cheap} of 40"
    );
    let candidates = [0, 1, 2].map(|candidate| count(&|outcome| outcome.candidate == candidate));
    println!("ideal gas, theory, simulation: {candidates:?}");
    assert!(
        candidates.iter().all(|&times| times >= 4),
        "the scenes do not exercise all candidates: {candidates:?}"
    );
    assert!(right >= 38);
    assert!(cheap >= 32);
    // Rules that are wrong fail the same criteria.
    for (formula, name) in ["ideal gas", "theory"].into_iter().enumerate() {
        let right = count(&|outcome| outcome.always[formula].0);
        println!("always {name}: right {right}");
        assert!(right < 38);
    }
    let cheap = count(&|outcome| outcome.simulated_is_cheap);
    println!("always simulation: cheap {cheap}");
    assert!(cheap < 32);
}

#[test]
fn a_column_that_freezes_is_not_promised_anything() {
    let mut frozen = 0;
    for HeldOut { parameters, tolerance } in HeldOut::draw(500) {
        if !parameters.freezes().unwrap() {
            continue;
        }
        frozen += 1;
        let (particles, side) = Parameters::WIDE;
        let choice = parameters.scene(particles, side).unwrap().model_for(tolerance);
        let choice = choice.unwrap_or_else(|error| panic!("{parameters:?}: {error}"));
        assert!(!choice.is_adequate(), "{choice}");
        let says_so = |reason: &Reason| matches!(reason, Reason::Freezing { .. });
        assert!(choice.best().reasons.iter().any(says_so));
        assert!(choice.to_string().contains("the column freezes between"), "{choice}");
    }
    println!("{frozen} columns that freeze");
    assert!(frozen >= 8, "{frozen}");
}

#[test]
fn constants_follow_from_the_calibration_files() {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("calibration");
    let columns = ColumnRow::read(&directory.join("columns.csv")).unwrap();
    let mut plans = Plan::read(&directory.join("plans.csv")).unwrap();
    plans.extend(Plan::read(&directory.join("long_plans.csv")).unwrap());
    let bases = Base::read(&directory.join("bases.csv")).unwrap();
    let seeds = Seeds::read(&directory.join("seeds.csv")).unwrap();
    let (constants, _) = fit::fit(&columns, &plans, &bases, &seeds);
    // All numbers on the right-hand sides, in order.
    let numbers = |source: &str| -> Vec<f64> {
        let right: Vec<&str> = source
            .split("pub(super) const")
            .skip(1)
            .filter_map(|item| item.split_once('='))
            .map(|(_, right)| right)
            .collect();
        right
            .iter()
            .filter_map(|right| right.split_once(';'))
            .flat_map(|(values, _)| values.split(|c: char| !(c.is_ascii_digit() || "-.e".contains(c))))
            .filter_map(|text| text.parse().ok())
            .collect()
    };
    let (fitted, used) =
        (numbers(&constants.source()), numbers(include_str!("../../../src/model/constants.rs")));
    assert!(used.len() == fitted.len() && used.len() >= 25, "{} and {} numbers", used.len(), fitted.len());
    for (fitted, used) in fitted.iter().zip(&used) {
        assert!((fitted - used).abs() <= 1e-3 * used.abs() + 1e-12, "{fitted} instead of {used}");
    }
}

/// What a formula says it misplaces does not depend on the tolerance, and a smaller tolerance never has a cheaper model.
#[test]
fn a_smaller_tolerance_never_costs_less() {
    let (particles, side) = Parameters::WIDE;
    let parameters = Parameters { temperature: 2.0, field_rate: 0.02, decay_rate: 0.01, column_density: 2.0 };
    let scene = parameters.scene(particles, side).unwrap();
    let mut previous: Option<ModelChoice> = None;
    for tolerance in [0.5, 0.2, 0.1, 0.03, 0.01, 0.003, 0.001, 1e-4] {
        let choice = scene.model_for(tolerance).unwrap();
        assert!(choice.is_adequate() && choice.best().expected_error <= tolerance, "{choice}");
        if let Some(previous) = &previous {
            assert!(choice.best().expected_seconds >= previous.best().expected_seconds, "{previous}{choice}");
            assert!(
                (choice.candidates()[1].expected_error - previous.candidates()[1].expected_error).abs()
                    < 1e-15
            );
        }
        previous = Some(choice);
    }
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(scene.model_for(tolerance), Err(Error::InvalidParameter { .. })));
    }
}
