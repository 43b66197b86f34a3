//! Accuracy of runs in a temperature gradient: T = 20 exp(−βx) for the five values of β of the
//! paper, with the default scheme.
//!
//! For each β the measured P (the weight of the column) is compared with n T Z, Z after Kolafa,
//! Labík and Malijevský as modified in 2019, where a local equation of state should hold: above the
//! layers at the base (x > 8) and where |d ln n/dx| < 0.1. This range is divided into groups of
//! heights with equal numbers of spheres, so that all have similar errors. No equation of state
//! enters the measurement. The certificate of every run checks whether its effective field is
//! self-consistent.
//!
//! `--full` runs until errors are below a quarter of a per cent.

#[macro_use]
extern crate paper;

use gradient_mc::drive::{Certificate, ForceBalance, SelfConsistent};
use gradient_mc::equation_of_state::ModifiedKolafa;
use gradient_mc::field::UniformField;
use gradient_mc::moves::{EventChains, LocalMoves};
use gradient_mc::observers::{Bins, EquationOfStateProfile};
use gradient_mc::start::{ClosePacked, RandomInsertion};
use gradient_mc::statistics::Estimate;
use gradient_mc::temperature::ExponentialTemperature;
use gradient_mc::{Every, HydrostaticProfile, Hydrostatics, Merge, Scene, Simulation, Slab, Warning};
use paper::figure::{Axis, Corner, Figure, Mark, Panel, Place, Point, colors};
use paper::row;
use paper::study;
use paper::table::{Table, percent};
use paper::verdict::Verdicts;
use paper::{Ending, Failure, Report, Session, Side, Watch, groups, warnings};
use std::process::ExitCode;

/// Measures P/(nTZ) and its error in temperature gradients.
#[derive(clap::Args, Debug)]
struct Arguments {
    /// Run until errors are below a quarter of a per cent (three to six minutes on two cores)
    #[arg(long, visible_alias = "paper")]
    full: bool,
}

const TEMPERATURE: f64 = 20.0;
const DECAY_RATES: [f64; 5] = [0.005, 0.01, 0.02, 0.03, 0.05];
const COLUMN_DENSITY: f64 = 40.0;
const HEIGHT: f64 = 400.0;
/// Side of the base.
const WIDTH: f64 = 9.0;
/// Height of the layers at the base.
const LOWEST: f64 = 8.0;
/// Largest |d ln n/dx| for a local equation of state.
const STEEPEST: f64 = 0.1;
const GROUPS: usize = 6;
/// Largest |P/(nTZ) − 1| claimed, and tolerance of the certificates.
const CLAIM: f64 = 0.005;
const TOLERANCE: f64 = 0.02;
/// Largest error that a full run may have.
const LARGEST_ERROR: f64 = 0.0025;

/// The edges of the groups of heights.
fn edges(theory: &HydrostaticProfile) -> Vec<f64> {
    let highest = groups::end_of_gentle_slope(theory, LOWEST, STEEPEST, HEIGHT);
    groups::edges_of_equal_numbers(theory, [LOWEST, highest], GROUPS)
}

/// Results of one β.
struct Outcome {
    decay_rate: f64,
    edges: Vec<f64>,
    deviations: Vec<Estimate>,
    certificate: Certificate,
    /// Warnings about the replicas, one line for each kind.
    warnings: Vec<String>,
}

/// Results of a replica, its balance of forces, and its warnings.
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
    watch: &Watch<'_>,
) -> Result<Replica, Failure> {
    let slab = slab()?;
    let temperature = ExponentialTemperature::new(TEMPERATURE, decay_rate)?;
    let scene = Scene::with_column_density(slab, COLUMN_DENSITY, UniformField::default(), temperature)?;
    let moves = EventChains::default().local_moves(Some(LocalMoves::tuned()));
    let builder = Simulation::builder(scene).scheme(SelfConsistent::default()).moves(moves).seed(seed);
    let mut simulation = match Side::of(number) {
        Side::Above => builder.start(RandomInsertion::default()).build()?,
        Side::Below => builder.start(ClosePacked).build()?,
    };
    watch.equilibrate(&mut simulation, sweeps, 1, &mut ())?;
    let mut profile =
        Every::new(5, EquationOfStateProfile::new(&slab, Bins::of_width(0.25).from(0.5).to(HEIGHT - 0.5))?);
    watch.run(&mut simulation, sweeps, 1, &mut profile)?;
    let balance = simulation.force_balance().ok_or("no balance of forces was recorded")?.clone();
    Ok((profile.observer, balance, simulation.warnings()))
}

fn main() -> ExitCode {
    study::main("temperature_gradient", run)
}

fn run(arguments: &Arguments, session: &Session) -> Result<Ending, Failure> {
    let (replicas_of_each, sweeps) =
        if arguments.full { (4, session.choose(12_000, 400)) } else { (2, session.choose(2500, 400)) };
    let tasks: Vec<(usize, u64)> = (0..DECAY_RATES.len())
        .flat_map(|index| (0..replicas_of_each).map(move |number| (index, number)))
        .collect();
    // The steepest column has the longest autocorrelation time.
    let sweeps = |index: usize| if DECAY_RATES[index] > 0.04 { 2 * sweeps } else { sweeps };
    let measured = session.run_all(
        "temperature gradients",
        tasks,
        |&(index, number)| format!("β = {}, replica {number}", DECAY_RATES[index]),
        |&(index, _)| 2 * sweeps(index),
        |(index, number), watch| {
            replica(
                DECAY_RATES[index],
                number,
                sweeps(index),
                session.seed(index as u64 * 1000 + number),
                watch,
            )
        },
    )?;
    let mut outcomes = Vec::new();
    for (decay_rate, replicas) in
        DECAY_RATES.into_iter().zip(measured.chunks(usize::try_from(replicas_of_each)?))
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
        let deviations = profile.deviations_over(&groups, &ModifiedKolafa)?;
        let certificate = balance.certificate(TOLERANCE)?;
        let warnings = warnings::lines(replicas.iter().map(|(.., warnings)| &warnings[..]));
        outcomes.push(Outcome { decay_rate, edges, deviations, certificate, warnings });
    }
    let mut report = Report::new(session);
    write(&outcomes, &report)?;
    draw(&outcomes, &mut report)?;
    println!("{}", table(&outcomes));
    for outcome in &outcomes {
        println!("β = {}: {}", outcome.decay_rate, outcome.certificate);
        for warning in &outcome.warnings {
            println!("β = {}: {warning}", outcome.decay_rate);
        }
    }
    report.verdicts = verdicts(&outcomes, arguments.full);
    report.finish()
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

/// Every group of heights within the claim and four standard errors of zero; in a full run every
/// run certified, and errors small enough.
fn verdicts(outcomes: &[Outcome], full: bool) -> Verdicts {
    let mut verdicts = Verdicts::new();
    for Outcome { decay_rate, edges, deviations, certificate, .. } in outcomes {
        for (&deviation, group) in deviations.iter().zip(edges.windows(2)) {
            let claim =
                format!("β = {decay_rate}: P/(nTZ) − 1 at heights from {:.1} to {:.1}", group[0], group[1]);
            // Within the claim or its error, and within four errors of zero.
            let error = 4.0 * deviation.standard_error;
            let reach = error.min(CLAIM + if full { 0.0 } else { error });
            verdicts.between("17", &claim, deviation, -reach, reach);
        }
        if full {
            let largest = groups::largest(deviations.iter().map(|deviation| deviation.standard_error));
            let claim = format!("β = {decay_rate}: largest error of P/(nTZ) − 1");
            verdicts.at_most("17", &claim, Estimate::exact(largest), LARGEST_ERROR);
            let claim = format!("β = {decay_rate}: certificate: {certificate}");
            verdicts.is_so("17", &claim, certificate.is_converged());
        }
    }
    verdicts
}

fn write(outcomes: &[Outcome], report: &Report) -> Result<(), Failure> {
    let rows = outcomes.iter().flat_map(|outcome| {
        outcome
            .edges
            .windows(2)
            .zip(&outcome.deviations)
            .map(|(group, deviation)| row![outcome.decay_rate, group[0], group[1], deviation])
    });
    report.table(
        "temperature_gradient",
        "lengths in d; deviation is the sum of P over that of n T Z in the group of heights, minus 1",
        "decay_rate, lowest_height, highest_height, deviation, deviation_error",
        rows,
    )
}

fn draw(outcomes: &[Outcome], report: &mut Report) -> Result<(), Failure> {
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
        let points =
            groups.map(|(group, deviation)| Point::percent(f64::midpoint(group[0], group[1]), *deviation));
        panel = panel.points(&format!("β = {}", outcome.decay_rate), color, Mark::Points, points);
    }
    let title =
        "P/(nTZ) − 1 in temperature gradients, T = 20 exp(−βx): the default scheme, no equation of state";
    let caption =
        "P/(nTZ) − 1 over ranges of height with equal numbers of spheres; dashed: limit of the claim.";
    report.picture("temperature_gradient", &Figure::new(title).panel(panel), caption)
}
