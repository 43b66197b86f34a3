//! The measurements that calibrate: columns against theory, plans against columns, small bases against wide ones.

use crate::reference::{Effort, Reference};
use gradient_mc::equation_of_state::{ModifiedKolafa, packing_fraction};
use gradient_mc::model::{IdealColumn, MonteCarloPlan, MoveFamily, densities, total_variation_distance};
use gradient_mc::{Error, HydrostaticProfile};
use paper::calibration::data::{Base, ColumnRow, Plan, Seeds};
use paper::calibration::scenes::{Column, Parameters};
use paper::clock::cpu_seconds;
use paper::{Failure, Session};

/// Heights up to which a wall layers the fluid.
const LAYERED: usize = 8;
/// Plans are tried with these numbers of sweeps, by as many replicas.
const LADDER: [u64; 3] = [32, 128, 512];
const REPLICAS: u64 = 8;
/// Longer ones, of columns with no more spheres than this over that base, are compared with one another.
const LONG_LADDER: [u64; 2] = [2048, 8192];
const MOST_SPHERES: usize = 250;
/// Side of the base of those plans, and their fewest spheres.
const SIDE: f64 = 5.0;
const FEWEST: usize = 40;
/// Columns whose base is varied, by their place among the calibration scenes, and the sides.
const COLUMNS_OF_BASES: [usize; 4] = [4, 5, 6, 7];
const SIDES: [f64; 3] = [3.0, 4.0, 5.0];
/// How well a column is to be known, with the CPU seconds that may go into it.
const NOISE: f64 = 1e-3;
const MOST_SECONDS: f64 = 4.0;
const SWEEPS: u64 = 2000;
/// Seeds of one scene are apart from those of the next by this.
const SEEDS: u64 = 10_000;
/// A time is the median of this many.
const TURNS: usize = 5;

/// What one scene gives.
type Measured = (ColumnRow, Vec<Plan>, Vec<Base>);

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

/// All of them; times are those of a thread.
pub(crate) fn all(session: &Session) -> Result<Vec<Measured>, Failure> {
    let scenes: Vec<(usize, Parameters)> = Parameters::calibration().into_iter().enumerate().collect();
    let lengths = Lengths::new(session);
    session.run_each("calibration scenes", scenes, |(index, parameters)| {
        one(session.seed + SEEDS * index as u64, index, parameters, lengths)
    })
}

fn one(first_seed: u64, index: usize, parameters: Parameters, lengths: Lengths) -> Result<Measured, Failure> {
    let (particles, side) = Parameters::WIDE;
    let scene = parameters.scene(particles, side)?;
    let Lengths { sweeps, most_seconds, .. } = lengths;
    let effort = Effort { sweeps, noise: NOISE, most_seconds, seed: first_seed };
    let truth = Reference::measure(&scene, effort)?;
    let theory = theory(&scene)?;
    let row = column(parameters, &scene, &theory, &truth)?;
    let plans = try_plans(index, &scene, &theory, &truth, (first_seed + SEEDS / 2, lengths.ladder))?;
    let sides = if COLUMNS_OF_BASES.contains(&index) { &SIDES[..] } else { &[] };
    let bases = sides
        .iter()
        .map(|&side| base(index, parameters, side, &truth, (first_seed + SEEDS / 4, lengths)))
        .collect::<Result<_, _>>()?;
    Ok((row, plans, bases))
}

fn theory(scene: &Column) -> Result<HydrostaticProfile, Error> {
    scene.hydrostatics(&ModifiedKolafa)
}

/// The median CPU time of some work.
fn median_seconds<Output>(mut work: impl FnMut() -> Result<Output, Error>) -> Result<f64, Error> {
    let mut times = Vec::with_capacity(TURNS);
    for _ in 0..TURNS {
        let started = cpu_seconds();
        work()?;
        times.push(cpu_seconds() - started);
    }
    times.sort_by(f64::total_cmp);
    Ok(times[TURNS / 2])
}

/// What ideal gas and theory make of a column.
fn column(
    parameters: Parameters,
    scene: &Column,
    profile: &HydrostaticProfile,
    truth: &Reference,
) -> Result<ColumnRow, Failure> {
    let column_density = scene.column_density();
    let gas = IdealColumn::new(scene)?;
    let ideal = densities(scene.slab(), |height| gas.column_below(height));
    let model = densities(scene.slab(), |height| profile.column_below(height));
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
    let plan = MonteCarloPlan::new(scene, scene.particles().min(1000), MoveFamily::TunedLocal, 2)?;
    Ok(ColumnRow {
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
        ideal_seconds: median_seconds(|| IdealColumn::new(scene))?,
        theory_seconds: median_seconds(|| theory(scene))?,
        start_seconds: median_seconds(|| plan.simulation(scene, 1).map(|_| ()))?,
        reference_seconds: truth.cpu_seconds,
    })
}

/// What a plan's error depends on, besides its moves and sweeps.
fn plan_row(column: usize, scene: &Column, theory: &HydrostaticProfile, plan: &MonteCarloPlan) -> Plan {
    let column_density = scene.column_density();
    let spread = densities(scene.slab(), |height| theory.column_below(height))
        .iter()
        .map(|density| density / column_density)
        .map(|part| (part * (1.0 - part)).max(0.0).sqrt())
        .sum();
    let family = MoveFamily::ALL.iter().position(|&family| family == plan.family()).unwrap_or(0);
    Plan {
        column: column as f64,
        family: family as f64,
        particles: plan.particles() as f64,
        sweeps: plan.sweeps() as f64,
        error: 0.0,
        noise: 0.0,
        spread,
        densest: packing_fraction(theory.density_maximum().1),
        extent: theory.center_of_mass() - theory.base(),
        seconds: 0.0,
    }
}

/// Spheres over the base of the plans that are tried.
fn particles_of_plans(scene: &Column) -> usize {
    paper::study::count((scene.column_density() * SIDE * SIDE).ceil()).max(FEWEST)
}

/// Root mean square of total variation distances.
fn root_mean_square(profiles: &[Vec<f64>], truth: &[f64]) -> f64 {
    let squares: f64 = profiles
        .iter()
        .map(|profile| total_variation_distance(profile, truth))
        .map(|error| error * error)
        .sum();
    (squares / profiles.len() as f64).sqrt()
}

/// Plans of either family against what is true.
fn try_plans(
    column: usize,
    scene: &Column,
    theory: &HydrostaticProfile,
    truth: &Reference,
    (first_seed, ladder): (u64, [u64; 3]),
) -> Result<Vec<Plan>, Failure> {
    let mut rows = Vec::new();
    for family in MoveFamily::ALL {
        for sweeps in ladder {
            let plan = MonteCarloPlan::new(scene, particles_of_plans(scene), family, sweeps)?;
            let started = cpu_seconds();
            let profiles = (0..REPLICAS)
                .map(|replica| plan.densities(scene, first_seed + replica))
                .collect::<Result<Vec<_>, _>>()?;
            rows.push(Plan {
                error: root_mean_square(&profiles, &truth.densities),
                noise: truth.noise(),
                seconds: (cpu_seconds() - started) / REPLICAS as f64,
                ..plan_row(column, scene, theory, &plan)
            });
        }
    }
    Ok(rows)
}

/// Plans so long that the theory start is forgotten, against the mean of all of them: what is true does not have to be known better than they know it.
pub(crate) fn long_plans(session: &Session) -> Result<Vec<Vec<(Plan, Seeds)>>, Failure> {
    let scenes: Vec<(usize, Parameters)> = Parameters::calibration().into_iter().enumerate().collect();
    let ladder = Lengths::new(session).long_ladder;
    session.run_each("long plans", scenes, |(index, parameters)| {
        let first_seed = session.seed + SEEDS * index as u64 + 3 * SEEDS / 4;
        let (particles, side) = Parameters::WIDE;
        let scene = parameters.scene(particles, side)?;
        let theory = theory(&scene)?;
        let particles = particles_of_plans(&scene);
        let mut rows = Vec::new();
        for family in MoveFamily::ALL.into_iter().filter(|_| particles <= MOST_SPHERES) {
            for sweeps in ladder {
                let plan = MonteCarloPlan::new(&scene, particles, family, sweeps)?;
                let started = cpu_seconds();
                let profiles = (0..REPLICAS)
                    .map(|replica| plan.densities(&scene, first_seed + replica))
                    .collect::<Result<Vec<_>, _>>()?;
                let mean: Vec<f64> = (0..profiles[0].len())
                    .map(|bin| profiles.iter().map(|profile| profile[bin]).sum::<f64>() / REPLICAS as f64)
                    .collect();
                // The mean takes its part of every deviation.
                let part = (REPLICAS as f64 / (REPLICAS as f64 - 1.0)).sqrt();
                let row = Plan {
                    error: part * root_mean_square(&profiles, &mean),
                    seconds: (cpu_seconds() - started) / REPLICAS as f64,
                    ..plan_row(index, &scene, &theory, &plan)
                };
                rows.push((row, scatter_of_seeds(&row, part, &profiles, &mean)));
            }
        }
        Ok(rows)
    })
}

/// How far single runs of a plan are apart.
fn scatter_of_seeds(row: &Plan, part: f64, profiles: &[Vec<f64>], mean: &[f64]) -> Seeds {
    let errors: Vec<f64> =
        profiles.iter().map(|profile| part * total_variation_distance(profile, mean)).collect();
    let count = errors.len() as f64;
    let average = errors.iter().sum::<f64>() / count;
    let squares: f64 = errors.iter().map(|error| (error - average) * (error - average)).sum();
    let scatter = (squares / (count - 1.0)).sqrt() / row.error;
    Seeds { column: row.column, family: row.family, sweeps: row.sweeps, error: row.error, scatter }
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
    let effort = Effort { sweeps: sweeps * ratio, noise: NOISE, most_seconds, seed: first_seed };
    let small = Reference::measure(&scene, effort)?;
    let gas = IdealColumn::new(&scene)?;
    let ideal = densities(scene.slab(), |height| gas.column_below(height));
    let profile = theory(&scene)?;
    let model = densities(scene.slab(), |height| profile.column_below(height));
    Ok(Base {
        column: column as f64,
        side: scene.slab().widths()[0],
        particles: particles as f64,
        error: total_variation_distance(&small.densities, &truth.densities),
        noise: small.noise().hypot(truth.noise()),
        excluded_volume: total_variation_distance(&ideal, &model),
    })
}
