//! The measurements of the calibration: columns compared with theory, plans with columns, and small
//! bases with wide ones.

use crate::reference::{Effort, Reference, mean};
use gradient_mc::equation_of_state::{ModifiedKolafa, packing_fraction};
use gradient_mc::model::{
    Accuracy, CorrectedLayers, MonteCarloPlan, MoveFamily, Quantity, densities, total_variation_distance,
};
use gradient_mc::{Error, HydrostaticProfile};
use paper::calibration::data::{Base, ColumnRow, Data, Formula, LayerRow, Moves, Plan};
use paper::calibration::scenes::{Column, Parameters};
use paper::{Failure, Session};

/// Heights up to which a wall layers the fluid.
const LAYERED: usize = 8;
/// Plans are tried with these numbers of sweeps, by as many replicas.
const LADDER: [u64; 3] = [32, 128, 512];
const REPLICAS: u64 = 8;
/// Longer ones, of columns with no more spheres than this over that base, are compared with one
/// another.
const LONG_LADDER: [u64; 2] = [2048, 8192];
const MOST_SPHERES: usize = 250;
/// Side of the base of those plans, and their fewest spheres.
const SIDE: f64 = 5.0;
const FEWEST: usize = 40;
/// Columns whose base is varied, by their place among the calibration scenes, and the sides.
const COLUMNS_OF_BASES: [usize; 4] = [4, 5, 6, 7];
const SIDES: [f64; 3] = [3.0, 4.0, 5.0];
/// Required accuracy of a column, and largest CPU time in seconds.
const NOISE: f64 = 6e-4;
const MOST_SECONDS: f64 = 10.0;
const SWEEPS: u64 = 2000;
/// Seeds of one scene are apart from those of the next by this.
const SEEDS: u64 = 10_000;
/// Sweeps over which moves are counted, after as many.
const COUNTED: u64 = 64;

/// How long runs are: of a calibration that counts, or of one that is tried out.
#[derive(Debug, Clone, Copy)]
struct Lengths {
    sweeps: u64,
    most_seconds: f64,
    ladder: [u64; 3],
    long_ladder: [u64; 2],
}

impl Lengths {
    fn new(session: &Session) -> Self {
        let usual =
            Self { sweeps: SWEEPS, most_seconds: MOST_SECONDS, ladder: LADDER, long_ladder: LONG_LADDER };
        let short = Self { sweeps: 32, most_seconds: 0.0, ladder: [2, 8, 32], long_ladder: [64, 128] };
        session.choose(usual, short)
    }
}

/// All of them.
pub(crate) fn all(session: &Session) -> Result<Data, Failure> {
    let scenes: Vec<(usize, Parameters)> = Parameters::calibration().into_iter().enumerate().collect();
    let lengths = Lengths::new(session);
    let measured = session.run_each(
        "calibration scenes",
        scenes,
        |(index, _)| format!("scene {index}"),
        |(index, parameters)| one(session.seed + SEEDS * index as u64, index, parameters, lengths),
    )?;
    let mut all = Data::default();
    for measured in measured {
        all.columns.extend(measured.columns);
        all.layers.extend(measured.layers);
        all.formulas.extend(measured.formulas);
        all.plans.extend(measured.plans);
        all.moves.extend(measured.moves);
        all.bases.extend(measured.bases);
    }
    Ok(all)
}

fn one(first_seed: u64, index: usize, parameters: Parameters, lengths: Lengths) -> Result<Data, Failure> {
    let (particles, side) = Parameters::WIDE;
    let scene = parameters.scene(particles, side)?;
    let Lengths { sweeps, most_seconds, .. } = lengths;
    let effort = Effort { sweeps, most_seconds, seed: first_seed };
    let truth = Reference::measure(&scene, effort, is_enough)?;
    let theory = theory(&scene)?;
    let mut measured = Data::default();
    compare(index, parameters, &scene, &theory, &truth, &mut measured)?;
    try_plans(index, &scene, &theory, &truth, (first_seed + SEEDS / 2, lengths), &mut measured)?;
    for &side in SIDES.iter().filter(|_| COLUMNS_OF_BASES.contains(&index)) {
        measured.bases.push(base(index, parameters, side, &truth, (first_seed + SEEDS / 4, lengths))?);
    }
    Ok(measured)
}

fn is_enough(reference: &Reference) -> bool {
    reference.noise() < NOISE
}

fn theory(scene: &Column) -> Result<HydrostaticProfile, Error> {
    scene.hydrostatics(&ModifiedKolafa)
}

/// Anything that the library can be asked for.
fn accuracies() -> Result<Vec<Accuracy>, Error> {
    Quantity::ALL.iter().map(|&quantity| Accuracy::new(quantity, 0.5)).collect()
}

/// Profiles of ideal gas, theory and functional, as the library has them.
fn formulas(scene: &Column) -> Result<[Vec<f64>; 3], Error> {
    let choice = scene.model_for(Accuracy::density(0.5)?)?;
    let [ideal, theory, ..] = choice.candidates() else { unreachable!("there are three candidates") };
    Ok([
        ideal.model.densities(scene, 0)?,
        theory.model.densities(scene, 0)?,
        CorrectedLayers::new(scene, &self::theory(scene)?)?.densities(scene),
    ])
}

/// Errors of ideal gas, theory and functional for a column.
fn compare(
    index: usize,
    parameters: Parameters,
    scene: &Column,
    profile: &HydrostaticProfile,
    truth: &Reference,
    measured: &mut Data,
) -> Result<(), Failure> {
    let column_density = scene.column_density();
    let [ideal, model, functional] = formulas(scene)?;
    let differences: Vec<f64> =
        model.iter().zip(&truth.densities).map(|(model, truth)| model - truth).collect();
    let layered = LAYERED.min(differences.len());
    let (near, far) = differences.split_at(layered);
    let (near_errors, far_errors) = truth.errors.split_at(layered);
    // |difference| without what noise alone would make of it.
    let misplaced: f64 = near
        .iter()
        .zip(near_errors)
        .map(|(difference, error)| (difference * difference - error * error).max(0.0).sqrt())
        .sum();
    let column = index as f64;
    measured.layers.extend(near.iter().zip(near_errors).enumerate().map(|(bin, (difference, error))| {
        LayerRow { column, bin: bin as f64, difference: *difference, error: *error }
    }));
    for (quantity, accuracy) in accuracies()?.iter().enumerate() {
        for (formula, profile) in [&ideal, &model, &functional].into_iter().enumerate() {
            measured.formulas.push(Formula {
                column,
                quantity: quantity as f64,
                formula: formula as f64,
                error: accuracy.error(scene, profile, &truth.densities),
                noise: truth.noise_of(accuracy, scene),
            });
        }
    }
    measured.columns.push(ColumnRow {
        temperature: parameters.temperature,
        field_rate: parameters.field_rate,
        decay_rate: parameters.decay_rate,
        column_density,
        height: scene.slab().height(),
        packing_fraction: profile.base_packing_fraction(),
        excluded_volume: total_variation_distance(&ideal, &model),
        ideal_error: total_variation_distance(&ideal, &truth.densities),
        theory_error: total_variation_distance(&model, &truth.densities),
        noise: truth.noise(),
        layers: 0.5 * misplaced * near[0].signum(),
        layers_error: 0.5 * near_errors.iter().map(|error| error * error).sum::<f64>().sqrt(),
        bulk: 0.5 * far.iter().map(|difference| difference.abs()).sum::<f64>() / column_density,
        bulk_noise: 0.5 * std::f64::consts::FRAC_2_PI.sqrt() * far_errors.iter().sum::<f64>()
            / column_density,
    });
    Ok(())
}

/// Root mean square of the errors of profiles, and the standard deviation of single ones in units
/// of it.
fn scatter(accuracy: &Accuracy, scene: &Column, profiles: &[Vec<f64>], truth: &[f64]) -> [f64; 2] {
    let errors: Vec<f64> = profiles.iter().map(|profile| accuracy.error(scene, profile, truth)).collect();
    let count = errors.len() as f64;
    let average = errors.iter().sum::<f64>() / count;
    let square = errors.iter().map(|error| error * error).sum::<f64>() / count;
    let variance =
        errors.iter().map(|error| (error - average) * (error - average)).sum::<f64>() / (count - 1.0);
    [square.sqrt(), (variance / square).sqrt()]
}

/// Plans of both families. Short ones are compared with the reference. Long ones, which do not
/// depend on the theory start, are compared with the mean of all of them, because their errors may
/// be smaller than that of the reference.
fn try_plans(
    index: usize,
    scene: &Column,
    theory: &HydrostaticProfile,
    truth: &Reference,
    (first_seed, lengths): (u64, Lengths),
    measured: &mut Data,
) -> Result<(), Failure> {
    let particles = paper::study::count((scene.column_density() * SIDE * SIDE).ceil()).max(FEWEST);
    let expected = densities(scene, theory);
    let densest = packing_fraction(theory.density_maximum().1);
    let Lengths { ladder, long_ladder, .. } = lengths;
    let is_long = |sweeps: &u64| long_ladder.contains(sweeps);
    for (family, moves) in MoveFamily::ALL.into_iter().enumerate() {
        let (column, family) = (index as f64, family as f64);
        for sweeps in ladder.into_iter().chain(long_ladder) {
            if is_long(&sweeps) && particles > MOST_SPHERES {
                continue;
            }
            let plan = MonteCarloPlan::new(scene, particles, moves, sweeps)?;
            let profiles = (0..REPLICAS)
                .map(|replica| plan.densities(scene, first_seed + replica))
                .collect::<Result<Vec<_>, _>>()?;
            let count = REPLICAS as f64;
            for (quantity, accuracy) in accuracies()?.iter().enumerate() {
                let ([error, scatter], noise) = if is_long(&sweeps) {
                    let [error, scatter] = scatter(accuracy, scene, &profiles, &mean(&profiles));
                    // The mean takes its part of every deviation.
                    ([error * (count / (count - 1.0)).sqrt(), scatter], 0.0)
                } else {
                    let [error, _] = scatter(accuracy, scene, &profiles, &truth.densities);
                    ([error, 0.0], truth.noise_of(accuracy, scene))
                };
                measured.plans.push(Plan {
                    column,
                    family,
                    quantity: quantity as f64,
                    particles: particles as f64,
                    sweeps: sweeps as f64,
                    error,
                    noise,
                    spread: accuracy.noise(scene, &expected, 1.0),
                    densest,
                    extent: theory.center_of_mass() - theory.base(),
                    scatter,
                });
            }
        }
        let mut simulation =
            MonteCarloPlan::new(scene, particles, moves, COUNTED)?.simulation(scene, first_seed)?;
        simulation.equilibrate(COUNTED, &mut ())?;
        let before = *simulation.move_counts();
        simulation.run(COUNTED, &mut ())?;
        let counts = simulation.move_counts().since(&before);
        let moves =
            (counts.trials + counts.events + counts.chains) as f64 / (COUNTED * particles as u64) as f64;
        measured.moves.push(Moves { column, family, densest, moves });
    }
    Ok(())
}

/// A base of the given side against the wide one.
fn base(
    column: usize,
    parameters: Parameters,
    side: f64,
    truth: &Reference,
    (first_seed, lengths): (u64, Lengths),
) -> Result<Base, Failure> {
    let particles = paper::study::count((parameters.column_density * side * side).ceil());
    let scene = parameters.scene(particles, 0.0)?;
    // As many spheres in as many sweeps as the wide base had, so that the noise is alike.
    let ratio = (truth.particles / particles).max(1) as u64;
    let Lengths { sweeps, most_seconds, .. } = lengths;
    let effort = Effort { sweeps: sweeps * ratio, most_seconds, seed: first_seed };
    let small = Reference::measure(&scene, effort, is_enough)?;
    let [ideal, model, _] = formulas(&scene)?;
    Ok(Base {
        column: column as f64,
        side: scene.slab().widths()[0],
        particles: particles as f64,
        error: total_variation_distance(&small.densities, &truth.densities),
        noise: small.noise().hypot(truth.noise()),
        excluded_volume: total_variation_distance(&ideal, &model),
    })
}
