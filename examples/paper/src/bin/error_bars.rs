//! Tests whether error bars are correct: (value − truth)/error over many replicas, for short and
//! long runs.
//!
//! Every replica of a column of 10 spheres per d² starts in equilibrium, from an independent run.
//! Its results and warnings are recorded after 200, 1000 and 5000 sweeps of production. The
//! reference ("truth") is the mean of all replicas of a scene at the longest production, over all
//! families of moves, with the error from their scatter. For each length the root
//! mean square of (value − truth)/error is printed, over the replicas without a warning about
//! sampling (in brackets: over all). The mean over all quantities should be within 0.8 to 1.25. If
//! all quantities are in this range for all replicas, at most one replica in ten should have a
//! warning.

#[macro_use]
extern crate paper;

use gradient_mc::field::{ExponentialField, Field, UniformField};
use gradient_mc::moves::{EventChains, LocalMoves, Moves};
use gradient_mc::observers::{Bins, CenterOfMass, EquationOfStatePoint, EquationOfStateProfile};
use gradient_mc::start::Positions;
use gradient_mc::statistics::{Estimate, mean_of_replicas};
use gradient_mc::temperature::{ExponentialTemperature, Isothermal, TemperatureProfile};
use gradient_mc::{Every, Scene, Simulation, Slab, WarningKind};
use paper::accuracy::root_mean_square;
use paper::study;
use paper::table::Table;
use paper::{Ending, Failure, Report, Session, Watch};
use std::process::ExitCode;

/// Measures the deviations of results from the truth in units of their error bars.
#[derive(clap::Args, Debug)]
struct Arguments {}

/// Replicas of every scene and family of moves.
const REPLICAS: u64 = 40;
/// Side of the base, in d.
const SIDE: f64 = 6.0;
const SPHERES_PER_AREA: f64 = 10.0;
const BASE_TEMPERATURE: f64 = 5.0;
const SCENES: [&str; 4] = ["isothermal", "varying field", "varying temperature", "closed box"];
const FAMILIES: [&str; 3] = ["tuned", "chains", "plain"];
const PRODUCTIONS: [u64; 3] = [200, 1000, 5000];
/// Frames are this many sweeps apart.
const INTERVAL: u64 = 2;
const BIN: f64 = 0.25;
const QUANTITIES: [&str; 9] = ["h_c", "n(0.6)", "n(1.6)", "n(8)", "P(0.6)", "P(8)", "P(15)", "Z(8)", "Z(15)"];
/// Range of the root mean square of correct error bars.
const CALIBRATED: [f64; 2] = [0.8, 1.25];

/// Of one replica after one production.
struct Outcome {
    estimates: Option<[Estimate; QUANTITIES.len()]>,
    warned: bool,
}

type AnyScene = Scene<Box<dyn Field>, Box<dyn TemperatureProfile>>;

fn scene(name: &str, side: f64) -> Result<AnyScene, Failure> {
    let height = if name == "closed box" { 20.0 } else { 60.0 };
    let field: Box<dyn Field> = match name {
        "varying field" => Box::new(ExponentialField::new(0.02)?),
        _ => Box::new(UniformField::default()),
    };
    let temperature: Box<dyn TemperatureProfile> = match name {
        "varying temperature" => Box::new(ExponentialTemperature::new(BASE_TEMPERATURE, 0.02)?),
        _ => Box::new(Isothermal::new(BASE_TEMPERATURE)?),
    };
    let spheres = study::count(SPHERES_PER_AREA * side * side);
    Ok(Scene::new(Slab::new(height, side, side)?, spheres, field, temperature)?)
}

fn moves(name: &str) -> Result<Moves, Failure> {
    Ok(match name {
        "tuned" => LocalMoves::tuned().into(),
        "chains" => EventChains::default().local_moves(Some(LocalMoves::tuned())).into(),
        _ => LocalMoves::new(0.3)?.into(),
    })
}

/// Whether a warning is about the sampling of a run, and not about its scene or single bins.
fn is_about_sampling(kind: WarningKind) -> bool {
    matches!(
        kind,
        WarningKind::TooShort
            | WarningKind::NotMixed
            | WarningKind::NothingMoved
            | WarningKind::CorrelatedBins
            | WarningKind::FarFromTheory
            | WarningKind::FeedbackNotConverged
    )
}

fn estimates(
    center: &CenterOfMass,
    profile: &EquationOfStateProfile,
) -> Result<[Estimate; QUANTITIES.len()], gradient_mc::Error> {
    let points = profile.points()?;
    let at = |height: f64| -> EquationOfStatePoint { points[study::count((height - 0.5) / BIN - 0.5)] };
    Ok([
        center.estimate()?,
        at(0.625).number_density,
        at(1.625).number_density,
        at(8.125).number_density,
        at(0.625).pressure,
        at(8.125).pressure,
        at(15.125).pressure,
        at(8.125).compressibility_factor,
        at(15.125).compressibility_factor,
    ])
}

/// Results after every production.
fn replica(
    [scene_name, family]: [&str; 2],
    side: f64,
    productions: &[u64],
    relaxation: u64,
    seed: u64,
    watch: &Watch<'_>,
) -> Result<Vec<Outcome>, Failure> {
    let mut relaxed = Simulation::builder(scene(scene_name, side)?).seed(seed).build()?;
    watch.equilibrate(&mut relaxed, relaxation, 1, &mut ())?;
    let scene = scene(scene_name, side)?;
    let slab = *scene.slab();
    let builder = Simulation::builder(scene).start(Positions(relaxed.positions()));
    let mut simulation = builder.moves(moves(family)?).seed(!seed).build()?;
    watch.equilibrate(&mut simulation, relaxation, 1, &mut ())?;
    let bins = Bins::of_width(BIN).from(0.5).to(16.0);
    let mut observers =
        Every::new(INTERVAL, (CenterOfMass::new(), EquationOfStateProfile::new(&slab, bins)?));
    let mut results = Vec::new();
    let mut made = 0;
    for &production in productions {
        watch.run(&mut simulation, production - made, 1, &mut observers)?;
        made = production;
        let (center, profile) = &observers.observer;
        let mut warnings = simulation.warnings();
        warnings.extend(profile.warnings());
        results.push(Outcome {
            estimates: estimates(center, profile).ok(),
            warned: warnings.iter().any(|warning| is_about_sampling(warning.kind())),
        });
    }
    Ok(results)
}

/// Root mean square of deviations in errors, over the replicas that `counts`.
fn pulls(
    results: &[&Outcome],
    truth: &[f64; QUANTITIES.len()],
    counts: impl Fn(&Outcome) -> bool,
) -> [f64; QUANTITIES.len()] {
    let counted: Vec<_> =
        results.iter().filter(|result| counts(result)).filter_map(|result| result.estimates).collect();
    std::array::from_fn(|index| {
        root_mean_square(counted.iter().map(|of| of[index].deviation_from(truth[index])))
    })
}

fn main() -> ExitCode {
    study::main("error_bars", run)
}

fn run(_: &Arguments, session: &Session) -> Result<Ending, Failure> {
    let productions = if session.short { &PRODUCTIONS[..1] } else { &PRODUCTIONS[..] };
    let replicas = session.choose(REPLICAS, 2);
    let side = session.choose(SIDE, 3.0);
    let relaxation = session.choose(1500, 50);
    let longest = productions[productions.len() - 1];
    let tasks: Vec<(usize, usize, u64)> = (0..SCENES.len())
        .flat_map(|scene| (0..FAMILIES.len()).map(move |family| (scene, family)))
        .flat_map(|(scene, family)| (0..replicas).map(move |replica| (scene, family, replica)))
        .collect();
    let work = |(scene, family, number): (usize, usize, u64), watch: &Watch<'_>| {
        let seed = session.seed((scene * FAMILIES.len() + family) as u64 * 100_000 + number);
        replica([SCENES[scene], FAMILIES[family]], side, productions, relaxation, seed, watch)
    };
    let name = |&(scene, family, number): &(usize, usize, u64)| {
        format!("{}, {}, replica {number}", SCENES[scene], FAMILIES[family])
    };
    let results = session.run_all("replicas", tasks, name, |_| 2 * relaxation + longest, work)?;
    let mut report = Report::new(session);
    let mut records = Vec::new();
    let of_scene = usize::try_from(replicas)? * FAMILIES.len();
    for (scene, results) in results.chunks(of_scene).enumerate() {
        let last: Vec<_> =
            results.iter().filter_map(|of| of.last().and_then(|result| result.estimates)).collect();
        let mut truth = [Estimate::exact(f64::NAN); QUANTITIES.len()];
        for (index, truth) in truth.iter_mut().enumerate() {
            *truth = mean_of_replicas(&last.iter().map(|of| of[index].mean).collect::<Vec<_>>())?;
        }
        println!("\n{}", SCENES[scene]);
        let mut table = Table::new(["moves, sweeps", "warned"].iter().chain(&QUANTITIES).copied());
        let truths = truth.iter().map(Estimate::to_string);
        table.row("truth", std::iter::once(String::new()).chain(truths));
        let truth = truth.map(|estimate| estimate.mean);
        for (family, results) in results.chunks(usize::try_from(replicas)?).enumerate() {
            for (place, &production) in productions.iter().enumerate() {
                let results: Vec<&Outcome> = results.iter().map(|of| &of[place]).collect();
                let warned = results.iter().filter(|result| result.warned).count();
                let (silent, all) =
                    (pulls(&results, &truth, |of| !of.warned), pulls(&results, &truth, |_| true));
                let label = format!("{} {production}", FAMILIES[family]);
                let cells = silent.iter().zip(&all).map(|(silent, all)| format!("{silent:.2} ({all:.2})"));
                table.row(&label, std::iter::once(format!("{warned}/{replicas}")).chain(cells));
                let silent_runs = results.len() - warned;
                let name = format!("{}, {label}", SCENES[scene]);
                // The root mean square of few runs is too uncertain.
                if silent_runs >= 10 {
                    let [lowest, highest] = CALIBRATED;
                    let claim = format!("rms of (value − truth)/error: {name}");
                    let square = silent.iter().map(|pull| pull * pull).sum::<f64>() / silent.len() as f64;
                    // The quantities are correlated: as if there were half as many.
                    let error = (square / (silent.len() * silent_runs) as f64).sqrt();
                    let measured = Estimate::new(square.sqrt(), error);
                    report.verdicts.between("error bars", &claim, measured, lowest, highest);
                }
                let honest = all.iter().all(|pull| (CALIBRATED[0]..=CALIBRATED[1]).contains(pull));
                if honest {
                    let share = Estimate::exact(warned as f64 / results.len() as f64);
                    report.verdicts.at_most(
                        "error bars",
                        &format!("share of replicas with a warning: {name}"),
                        share,
                        0.1,
                    );
                }
                records.push(
                    [scene as f64, family as f64, production as f64, warned as f64]
                        .into_iter()
                        .chain(silent)
                        .chain(all)
                        .collect::<Vec<f64>>(),
                );
            }
        }
        println!("{table}");
    }
    let columns = |suffix: &str| QUANTITIES.map(|quantity| format!(", {quantity}{suffix}")).concat();
    let head = format!("scene, moves, sweeps, warned{}{}", columns(""), columns(" of all"));
    report.table("error_bars", "rms of (value - truth)/error, of runs without a warning", &head, records)?;
    report.finish()
}
