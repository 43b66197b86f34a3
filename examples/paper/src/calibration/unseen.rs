//! `Scene::model_for` on columns that no constant was fitted to: what it chooses, and what is true.

use super::scenes::{Column, HeldOut, Parameters};
use crate::Failure;
use gradient_mc::equation_of_state::ModifiedKolafa;
use gradient_mc::model::{Accuracy, CorrectedLayers, Model, MonteCarloPlan, Quantity};
use serde::{Deserialize, Serialize};

/// The candidates, in order of cost.
pub const NAMES: [&str; 4] = ["ideal gas", "theory", "functional", "simulation"];
/// The place of the simulation among them.
pub const PLAN: usize = 3;
/// Seeds over which the error of a shorter plan is averaged.
const SEEDS: u64 = 3;
/// A plan is too expensive if this part of its sweeps is enough.
pub const PART: f64 = 1.0 / 9.0;

/// A model that was chosen, and what became of it. Deviations are from the reference, without what
/// the noise of that makes of them.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Judged {
    /// What was asked for, in words.
    pub accuracy: String,
    pub quantity: usize,
    pub tolerance: f64,
    /// Noise of the reference in this.
    pub noise: f64,
    /// Whether the library calls the choice adequate.
    pub is_adequate: bool,
    /// Place of the choice among the candidates.
    pub chosen: usize,
    pub expected: f64,
    pub moves: f64,
    /// The deviation of the choice, and its standard error; not a number if it is a simulation that
    /// would take too long.
    pub found: [f64; 2],
    /// Deviations of ideal gas, theory and functional.
    pub formulas: [f64; PLAN],
    /// Deviation of a plan of [`PART`] of the sweeps, root mean square over seeds, where no formula
    /// is adequate and a simulation was chosen.
    pub shorter: f64,
}

impl Judged {
    /// Whether the true deviation is known to be below the tolerance, or above: not where a
    /// simulation was not run.
    pub fn was_run(&self) -> bool {
        self.found[0].is_finite()
    }

    /// Below the tolerance.
    pub fn is_right(&self) -> bool {
        self.is_adequate && self.found[0] <= self.tolerance
    }

    /// So near the tolerance that the reference does not decide, by two standard errors.
    pub fn is_close(&self) -> bool {
        (self.found[0] - self.tolerance).abs() < 2.0 * self.found[1]
    }

    /// Place of the cheapest candidate whose true deviation is below the tolerance.
    pub fn cheapest(&self) -> usize {
        self.formulas.iter().position(|&deviation| deviation <= self.tolerance).unwrap_or(PLAN)
    }

    /// Whether less would have been enough: a cheaper formula, or a ninth of the sweeps.
    pub fn is_dear(&self) -> bool {
        self.chosen > self.cheapest() || self.shorter <= self.tolerance
    }
}

/// A reference: profiles of independent runs, one at least, or their mean.
#[derive(Debug, Clone, Copy)]
pub struct Truth<'a> {
    pub mean: &'a [f64],
    /// None if only the mean is known.
    pub replicas: &'a [Vec<f64>],
}

/// Deviation of a profile from what is true, and its standard error by the jackknife.
fn deviation(scene: &Column, accuracy: &Accuracy, noise: f64, truth: Truth<'_>, profile: &[f64]) -> [f64; 2] {
    let square = |error: f64, noise: f64| (error * error - noise * noise).max(0.0);
    let all = square(accuracy.error(scene, profile, truth.mean), noise).sqrt();
    let count = truth.replicas.len() as f64;
    // Each without one of the replicas, and so with a little more noise.
    let without = |replica: &Vec<f64>| {
        let mean: Vec<f64> =
            truth.mean.iter().zip(replica).map(|(mean, one)| (count * mean - one) / (count - 1.0)).collect();
        let noise = noise * (count / (count - 1.0)).sqrt();
        square(accuracy.error(scene, profile, &mean), noise).sqrt()
    };
    let left: Vec<f64> = truth.replicas.iter().map(without).collect();
    let mean = left.iter().sum::<f64>() / count;
    let squares: f64 = left.iter().map(|one| (one - mean) * (one - mean)).sum();
    [all, ((count - 1.0) / count * squares).sqrt()]
}

/// Asks for a model, takes what is chosen, and compares it. Simulations with more moves than
/// `most_moves` are not run.
pub fn judge(
    scene: &Column,
    accuracy: &Accuracy,
    noise: f64,
    truth: Truth<'_>,
    most_moves: f64,
) -> Result<Judged, Failure> {
    let choice = scene.model_for(*accuracy)?;
    let compare = |profile: &[f64]| deviation(scene, accuracy, noise, truth, profile);
    let layers = CorrectedLayers::new(scene, &scene.hydrostatics(&ModifiedKolafa)?)?;
    let [ideal, theory, ..] = choice.candidates() else { return Err("too few candidates".into()) };
    let formulas = [
        compare(&ideal.model.densities(scene, 0)?),
        compare(&theory.model.densities(scene, 0)?),
        compare(&layers.densities(scene)),
    ];
    let best = choice.best();
    let run = |plan: &MonteCarloPlan, seed: u64| -> Result<[f64; 2], Failure> {
        Ok(compare(&plan.densities(scene, seed)?))
    };
    let tolerance = accuracy.tolerance();
    let none_is_adequate = formulas.iter().all(|&[deviation, _]| deviation > tolerance);
    let (mut found, mut shorter) = ([f64::NAN; 2], f64::NAN);
    let chosen = match &best.model {
        Model::IdealGas(_) => 0,
        Model::Hydrostatics(_) => 1,
        Model::DensityFunctional(_) => 2,
        _ => PLAN,
    };
    match &best.model {
        Model::MonteCarlo(plan) => {
            if best.expected_moves <= most_moves {
                found = run(plan, 1)?;
                if none_is_adequate {
                    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                    let less = plan.with_sweeps((PART * plan.sweeps() as f64).round() as u64);
                    let mut squares = 0.0;
                    for seed in 0..SEEDS {
                        let [deviation, _] = run(&less, 100 + seed)?;
                        squares += deviation * deviation;
                    }
                    shorter = (squares / SEEDS as f64).sqrt();
                }
            }
        }
        _ => found = formulas[chosen],
    }
    Ok(Judged {
        accuracy: accuracy.to_string(),
        quantity: accuracy.quantity() as usize,
        tolerance,
        noise,
        is_adequate: choice.is_adequate(),
        chosen,
        expected: best.expected_error,
        moves: best.expected_moves,
        found,
        formulas: formulas.map(|[deviation, _]| deviation),
        shorter,
    })
}

/// A line for the terminal.
pub fn line(number: usize, parameters: &Parameters, judged: &Judged) -> String {
    let Parameters { temperature, field_rate, decay_rate, column_density } = parameters;
    let percent = |value: f64| format!("{:.3}", 100.0 * value);
    let [found, error] = judged.found;
    let verdict = match judged {
        judged if !judged.is_adequate => "none adequate",
        judged if !judged.was_run() => "not run",
        judged if !judged.is_right() => "WRONG",
        judged if judged.is_dear() => "right, too expensive",
        _ => "right",
    };
    let close = if judged.is_close() { " (close)" } else { "" };
    format!(
        "{number:>3} {temperature:>6} {field_rate:>8} {decay_rate:>8} {column_density:>7} {:>8} {:>8} {:>8}({:>5}) {:>10} {:>10} {verdict}{close}; {}",
        percent(judged.tolerance),
        percent(judged.expected),
        percent(found),
        percent(error),
        NAMES[judged.chosen],
        NAMES[judged.cheapest()],
        judged.accuracy,
    )
}

/// The header of these lines.
pub const HEADER: &str =
    "  #     T0    alpha     beta     N/A   tol, % expected  true(error), %     chosen   cheapest";

/// How often the choices are right, and how often each candidate is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Count {
    pub right: usize,
    pub wrong: usize,
    pub not_run: usize,
    pub close: usize,
    pub dear: usize,
    pub chosen: [usize; 4],
    /// Of which the cheapest adequate.
    pub cheapest: [usize; 4],
    /// Had one always taken this formula: right.
    pub always: [usize; PLAN],
}

impl Count {
    pub fn of(judged: &[Judged], quantity: Quantity) -> Self {
        let ours: Vec<&Judged> = judged.iter().filter(|one| one.quantity == quantity as usize).collect();
        let count = |is: &dyn Fn(&Judged) -> bool| ours.iter().filter(|one| is(one)).count();
        Self {
            right: count(&|one| one.is_right()),
            wrong: count(&|one| !one.is_adequate || one.was_run() && !one.is_right()),
            not_run: count(&|one| one.is_adequate && !one.was_run()),
            close: count(&|one| one.is_close()),
            dear: count(&|one| one.is_right() && one.is_dear()),
            chosen: [0, 1, 2, PLAN].map(|place| count(&|one| one.chosen == place)),
            cheapest: [0, 1, 2, PLAN].map(|place| count(&|one| one.chosen == place && !one.is_dear())),
            always: [0, 1, 2].map(|place| count(&|one| one.formulas[place] <= one.tolerance)),
        }
    }
}

/// The first `count` scenes that do not freeze, with their numbers among those drawn.
pub fn fluids(count: usize) -> Result<Vec<(usize, HeldOut)>, Failure> {
    let mut fluids = Vec::new();
    for (number, scene) in HeldOut::draw(4 * count).into_iter().enumerate() {
        if fluids.len() < count && !scene.parameters.freezes()? {
            fluids.push((number, scene));
        }
    }
    if fluids.len() < count {
        return Err("too many of the scenes freeze".into());
    }
    Ok(fluids)
}
