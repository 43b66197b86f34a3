//! How accurate a run in a temperature gradient is: T = 20 exp(−βx) for the paper's five β, with the default scheme.
//!
//! For each β the measured P (the weight of the column) is compared with n T Z, Z after Kolafa, Labík and Malijevský as
//! modified in 2019, wherever a local equation of state can be expected to hold: above the layers at the base (x > 8) and
//! where |d ln n/dx| < 0.1. That range is divided into groups of heights that hold equally many spheres, so that the dilute
//! top is known as well as the rest. No equation of state enters the measurement: the certificate of every run
//! says whether its effective field belongs to the density that it made.
//!
//! `--full` goes on until errors are below a quarter of a per cent.

use clap::Parser;
use gradient_mc::drive::{Certificate, ForceBalance, SelfConsistent};
use gradient_mc::equation_of_state::{EquationOfState, ModifiedKolafa};
use gradient_mc::field::UniformField;
use gradient_mc::moves::{EventChains, LocalMoves};
use gradient_mc::observers::EquationOfStateProfile;
use gradient_mc::start::{ClosePacked, RandomInsertion};
use gradient_mc::statistics::Estimate;
use gradient_mc::temperature::ExponentialTemperature;
use gradient_mc::{Every, HydrostaticProfile, Hydrostatics, Scene, Simulation, Slab, Warning};
use paper::arguments::SharedArguments;
use paper::figure::{Axis, Corner, Figure, Mark, Panel, Place, Point, colors};
use paper::interrupt::Interrupt;
use paper::progress::Progress;
use paper::table::{Table, percent};
use paper::{Ending, Failure, conclude, groups, output, replicas, warnings};
use std::path::Path;
use std::process::ExitCode;

/// Measures P/(nTZ) in temperature gradients, and how well it is known.
#[derive(Parser, Debug)]
#[command(name = "temperature_gradient")]
struct Arguments {
    #[command(flatten)]
    shared: SharedArguments,
    /// Until errors are below a quarter of a per cent: three to six minutes on two cores
    #[arg(long, visible_alias = "paper")]
    full: bool,
}

const TEMPERATURE: f64 = 20.0;
const DECAY_RATES: [f64; 5] = [0.005, 0.01, 0.02, 0.03, 0.05];
const COLUMN_DENSITY: f64 = 40.0;
const HEIGHT: f64 = 400.0;
/// Side of the base.
const WIDTH: f64 = 9.0;
/// Below it the fluid is layered.
const LOWEST: f64 = 8.0;
/// Where ln n changes faster the density is not local.
const STEEPEST: f64 = 0.1;
const GROUPS: usize = 6;
/// What is claimed of P/(nTZ) − 1, and what the certificates tolerate.
const CLAIM: f64 = 0.005;
const TOLERANCE: f64 = 0.02;
/// Largest error that a full run may have.
const LARGEST_ERROR: f64 = 0.0025;

/// The edges of the groups of heights.
fn edges(theory: &HydrostaticProfile) -> Vec<f64> {
    let highest = groups::end_of_gentle_slope(theory, LOWEST, STEEPEST, HEIGHT);
    groups::edges_of_equal_numbers(theory, [LOWEST, highest], GROUPS)
}

/// What is known of one β.
struct Outcome {
    decay_rate: f64,
    edges: Vec<f64>,
    deviations: Vec<Estimate>,
    certificate: Certificate,
    /// What the replicas say against themselves, a line for each kind.
    warnings: Vec<String>,
}

/// What a replica has measured, the balance of forces in it, and what it says against itself.
type Replica = (EquationOfStateProfile, ForceBalance, Vec<Warning>);

fn slab() -> Result<Slab, Failure> {
    Ok(Slab::new(HEIGHT, WIDTH, WIDTH)?)
}

/// One replica, from far above or far below.
fn replica(
    decay_rate: f64,
    number: u64,
    sweeps: u64,
    seed: u64,
    interrupt: &Interrupt,
    progress: &Progress,
) -> Result<Replica, Failure> {
    let slab = slab()?;
    let temperature = ExponentialTemperature::new(TEMPERATURE, decay_rate)?;
    // A few thousand.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let particles = (COLUMN_DENSITY * slab.base_area()).round() as usize;
    let scene = Scene::new(slab, particles, UniformField::default(), temperature)?;
    let moves = EventChains::default().local_moves(Some(LocalMoves::tuned()));
    let builder = Simulation::builder(scene).scheme(SelfConsistent::default()).moves(moves).seed(seed);
    let mut simulation = if number.is_multiple_of(2) {
        builder.start(RandomInsertion::default()).build()?
    } else {
        builder.start(ClosePacked).build()?
    };
    replicas::in_chunks(sweeps, interrupt, progress, |sweeps| simulation.equilibrate(sweeps, &mut ()))?;
    let bins = 4 * 399;
    let mut profile = Every::new(5, EquationOfStateProfile::with_range(&slab, 0.5, HEIGHT - 0.5, bins)?);
    let made =
        replicas::in_chunks(sweeps, interrupt, progress, |sweeps| simulation.run(sweeps, &mut profile))?;
    if made < sweeps {
        return Err("interrupted before enough was measured".into());
    }
    let balance = simulation.force_balance().ok_or("there is a field to be judged")?.clone();
    Ok((profile.observer, balance, simulation.warnings()))
}

fn main() -> ExitCode {
    conclude(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<Ending, Failure> {
    let directory = arguments.shared.directory("temperature_gradient");
    output::create_directory(&directory)?;
    let interrupt = Interrupt::listen()?;
    let (replicas_of_each, sweeps) = if arguments.full { (4, 12_000) } else { (2, 2500) };
    let tasks: Vec<(usize, u64)> = (0..DECAY_RATES.len())
        // The longest first, so that the threads end together.
        .rev()
        .flat_map(|index| (0..replicas_of_each).map(move |number| (index, number)))
        .collect();
    // The steepest column remembers longest.
    let sweeps = |index: usize| if DECAY_RATES[index] > 0.04 { 2 * sweeps } else { sweeps };
    let work = tasks.iter().map(|&(index, _)| 2 * sweeps(index)).sum();
    let progress = Progress::new(work, "temperature gradients");
    let base_seed = arguments.shared.seed.wrapping_mul(1_000_003);
    let measured = replicas::in_parallel(arguments.shared.threads, tasks, |(index, number)| {
        let seed = base_seed.wrapping_add(index as u64 * 1000 + number);
        replica(DECAY_RATES[index], number, sweeps(index), seed, &interrupt, &progress)
    });
    progress.finish();
    let measured = match measured {
        Err(_) if interrupt.pressed() => return Ok(Ending::Interrupted),
        measured => measured?,
    };
    let mut outcomes = Vec::new();
    for (decay_rate, replicas) in
        DECAY_RATES.into_iter().zip(measured.chunks(usize::try_from(replicas_of_each)?).rev())
    {
        let (first, rest) = replicas.split_first().ok_or("nothing was measured")?;
        let (mut profile, mut balance, _) = first.clone();
        for (other, other_balance, _) in rest {
            profile.merge(other)?;
            balance.merge(other_balance)?;
        }
        let temperature = ExponentialTemperature::new(TEMPERATURE, decay_rate)?;
        let theory = Hydrostatics::new(UniformField::default(), temperature, ModifiedKolafa)
            .between_walls(&slab()?, COLUMN_DENSITY)?;
        let edges = edges(&theory);
        let groups = groups::ranges_between(&edges);
        let deviations =
            profile.deviations_over(&groups, |eta| ModifiedKolafa.compressibility_factor(eta))?;
        let certificate = balance.certificate(TOLERANCE)?;
        let warnings = warnings::lines(replicas.iter().map(|(.., warnings)| &warnings[..]));
        outcomes.push(Outcome { decay_rate, edges, deviations, certificate, warnings });
    }
    write(&outcomes, &directory)?;
    draw(&outcomes, &directory.join("temperature_gradient"))?;
    println!("{}", table(&outcomes));
    for outcome in &outcomes {
        println!("β = {}: {}", outcome.decay_rate, outcome.certificate);
        for warning in &outcome.warnings {
            println!("β = {}: {warning}", outcome.decay_rate);
        }
    }
    println!("written to {}", directory.display());
    Ok(if verdict(&outcomes, arguments.full) { Ending::Finished } else { Ending::ClaimFailed })
}

fn table(outcomes: &[Outcome]) -> Table {
    let head =
        ["β", "heights", "largest |P/(nTZ) − 1|, %", "in standard errors", "mean, %", "largest error, %"];
    let mut table = Table::new(head);
    for Outcome { decay_rate, edges, deviations, .. } in outcomes {
        let largest = deviations.iter().fold(Estimate::new(0.0, f64::INFINITY), |largest, &deviation| {
            if deviation.mean.abs() >= largest.mean.abs() { deviation } else { largest }
        });
        let count = deviations.len() as f64;
        let mean = deviations.iter().map(|deviation| deviation.mean).sum::<f64>() / count;
        let error = deviations.iter().map(|deviation| deviation.standard_error).fold(0.0, f64::max);
        table.row(
            &decay_rate.to_string(),
            [
                format!("{LOWEST} to {:.0}", edges[GROUPS]),
                percent(largest),
                format!("{:.1}", largest.deviation_from(0.0).abs()),
                format!("{:.2}", 100.0 * mean),
                format!("{:.2}", 100.0 * error),
            ],
        );
    }
    table
}

/// Whether the claim holds: every group within the claim and four standard errors of zero, every run certified; errors
/// small enough in a full run.
fn verdict(outcomes: &[Outcome], full: bool) -> bool {
    let mut holds = true;
    for Outcome { decay_rate, deviations, certificate, .. } in outcomes {
        for deviation in deviations {
            let significant = deviation.deviation_from(0.0).abs() > 4.0;
            let beyond =
                deviation.mean.abs() > CLAIM + if full { 0.0 } else { 4.0 * deviation.standard_error };
            if significant || beyond || deviation.standard_error.is_nan() {
                println!("FAILS at β = {decay_rate}: {} %", percent(*deviation));
                holds = false;
            }
            if full && deviation.standard_error > LARGEST_ERROR {
                println!("FAILS at β = {decay_rate}: the error of {} % is too large", percent(*deviation));
                holds = false;
            }
        }
        if full && !certificate.is_converged() {
            println!("FAILS at β = {decay_rate}: {certificate}");
            holds = false;
        }
    }
    if holds {
        println!("holds: P is n T Z wherever it can be expected to, within {} % or its error", 100.0 * CLAIM);
    }
    holds
}

fn write(outcomes: &[Outcome], directory: &Path) -> Result<(), Failure> {
    let rows = outcomes.iter().flat_map(|outcome| {
        outcome.edges.windows(2).zip(&outcome.deviations).map(|(group, deviation)| {
            [outcome.decay_rate, group[0], group[1], deviation.mean, deviation.standard_error]
        })
    });
    output::write_csv(
        &directory.join("temperature_gradient.csv"),
        "lengths in d; deviation is the sum of P over that of n T Z in the group of heights, less 1",
        ["decay_rate", "lowest_height", "highest_height", "deviation", "deviation_error"],
        rows,
    )
}

fn draw(outcomes: &[Outcome], path: &Path) -> Result<(), Failure> {
    const COLORS: [paper::figure::RGBColor; 5] =
        [colors::INK, colors::BLUE, colors::GREEN, colors::VERMILION, colors::PURPLE];
    let highest = outcomes.iter().map(|outcome| outcome.edges[GROUPS]).fold(0.0, f64::max);
    let mut panel = Panel::new(
        Place { left: 0.0, top: 0.07, width: 1.0, height: 0.93 },
        Axis::new("height x / d", 0.0, highest.ceil()).with_numbers(12),
        Axis::new("P/(nTZ) − 1, %", -2.0, 2.0).with_numbers(9),
    )
    .with_legend(Corner::TopRight);
    for bound in [-CLAIM, CLAIM] {
        let bound = 100.0 * bound;
        panel = panel.line("", colors::GRAY, Mark::Dashed, [(0.0, bound), (highest.ceil(), bound)]);
    }
    for (outcome, color) in outcomes.iter().zip(COLORS) {
        let groups = outcome.edges.windows(2).zip(&outcome.deviations);
        let points = groups.map(|(group, deviation)| Point {
            x: f64::midpoint(group[0], group[1]),
            y: 100.0 * deviation.mean,
            error: 100.0 * deviation.standard_error,
        });
        panel = panel.points(&format!("β = {}", outcome.decay_rate), color, Mark::Points, points);
    }
    Figure::new(
        "P/(nTZ) − 1 in temperature gradients, T = 20 exp(−βx): the default scheme, no equation of state",
    )
    .panel(panel)
    .save(path)
}
