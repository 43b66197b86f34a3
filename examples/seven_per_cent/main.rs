//! Why the paper's pressures were seven per cent off at its steepest temperature gradient, and how not to be.
//!
//! The column at T₀ = 20, β = 0.05 (doi:10.1103/PhysRevE.83.061306, Fig. 17c), run with the effective field of every
//! scheme of the library, from above and from below, over bases of 156.25 and 625, with bins from 0.05 to 0.5; the bins of
//! the density that enters the field and of the density that is measured are independent. For each run P/(nTZ) − 1 is
//! drawn over height, beside what counting noise must do to a field from instantaneous counts. A second, smaller
//! column shows that the bias grows with the number of bins that a move crosses.
//!
//! `--full` makes every combination, each known to half a per cent.

// A summary is put together once; the clearer call is the better one.
#![allow(clippy::format_push_string)]

#[path = "../common/mod.rs"]
mod common;

mod picture;
mod prediction;
mod run;
mod scan;

use clap::Parser;
use common::arguments::SharedArguments;
use common::interrupt::Interrupt;
use common::progress::Progress;
use common::table::Table;
use common::{Ending, Failure, conclude, output, replicas};
use gradient_mc::statistics::Estimate;
use prediction::{Prediction, part_outside};
use run::{MEASURING_BINS, MovesChoice, Outcome, SchemeChoice, Setup, Side};
use scan::Scan;
use std::path::Path;
use std::process::ExitCode;

/// Settles where the paper's seven per cent at β = 0.05 come from.
#[derive(Parser, Debug)]
#[command(name = "seven_per_cent")]
struct Arguments {
    #[command(flatten)]
    shared: SharedArguments,
    /// Every scheme, base and bin, from both sides, each to half a per cent
    #[arg(long)]
    full: bool,
    /// The paper's own moves too, over its own base (with --full; they need 200 000 sweeps to relax)
    #[arg(long)]
    paper: bool,
}

fn main() -> ExitCode {
    conclude(run(&Arguments::parse()))
}

/// The base of the paper, and one of a quarter.
const AREAS: [f64; 2] = [156.25, 625.0];
/// Bins of the density that enters the field.
const BINS: [f64; 4] = [0.05, 0.1, 0.2, 0.5];

/// A run that is long enough for an error of about half a per cent in each band.
fn setup(scheme: SchemeChoice, area: f64, bin: f64, side: Side, seed: u64) -> Setup {
    // What an average has to forget, or to be accurate to.
    let equilibration = if scheme == SchemeChoice::Instantaneous { 4e5 } else { 1e6 };
    // Positive, and far below 2^53.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let sweeps = |work: f64| (work / area).round().max(800.0) as u64;
    Setup {
        scheme,
        area,
        acceptance_bin: bin,
        moves: MovesChoice::Chains,
        side,
        equilibration: sweeps(equilibration),
        sweeps: sweeps(1.1e6),
        seed,
    }
}

/// The runs of a few kinds, or of all.
fn setups(arguments: &Arguments) -> Vec<Setup> {
    let seed = arguments.shared.seed.wrapping_mul(1_000_003);
    let mut setups = Vec::new();
    if arguments.full {
        for area in AREAS {
            for bin in BINS {
                for scheme in [
                    SchemeChoice::Instantaneous,
                    SchemeChoice::RunningAverage,
                    SchemeChoice::AveragedThenFrozen,
                    SchemeChoice::Closure,
                    SchemeChoice::SelfConsistent,
                ] {
                    for side in [Side::Above, Side::Below] {
                        setups.push(setup(scheme, area, bin, side, seed.wrapping_add(setups.len() as u64)));
                    }
                }
            }
        }
    } else {
        for (scheme, area, bin, side) in [
            (SchemeChoice::Instantaneous, 156.25, 0.1, Side::Above),
            (SchemeChoice::Instantaneous, 156.25, 0.2, Side::Below),
            (SchemeChoice::Instantaneous, 156.25, 0.5, Side::Above),
            (SchemeChoice::Instantaneous, 625.0, 0.1, Side::Below),
            (SchemeChoice::Closure, 156.25, 0.1, Side::Below),
            (SchemeChoice::SelfConsistent, 156.25, 0.1, Side::Above),
        ] {
            let full = setup(scheme, area, bin, side, seed.wrapping_add(setups.len() as u64));
            // Errors of nearly one per cent.
            let sweeps = (full.sweeps / 3).max(500);
            setups.push(Setup { equilibration: full.equilibration / 2, sweeps, ..full });
        }
    }
    if arguments.paper {
        for (side, seed) in [(Side::Above, seed ^ 1), (Side::Below, seed ^ 2)] {
            setups.push(Setup {
                moves: MovesChoice::Local(0.75),
                equilibration: 100_000,
                sweeps: 100_000,
                ..setup(SchemeChoice::Instantaneous, 625.0, 0.1, side, seed)
            });
        }
    }
    setups
}

/// A run with what it came to.
pub(crate) type Finished = (Setup, Outcome);

enum Task {
    Run(Setup),
    Scan(Scan),
}

enum Done {
    Run(Box<Finished>),
    Scan(Scan, Estimate),
}

fn run(arguments: &Arguments) -> Result<Ending, Failure> {
    let directory = arguments.shared.directory("seven_per_cent");
    output::create_directory(&directory)?;
    let interrupt = Interrupt::listen()?;
    let setups = setups(arguments);
    let scans = Scan::all(arguments.full, arguments.shared.seed);
    let work = setups.iter().map(Setup::work).sum::<u64>() + scans.iter().map(Scan::work).sum::<u64>();
    let progress = Progress::new(work, "seven per cent");
    let mut tasks: Vec<Task> =
        setups.into_iter().map(Task::Run).chain(scans.into_iter().map(Task::Scan)).collect();
    // The longest first, so that the threads end together.
    tasks.sort_by_key(|task| {
        std::cmp::Reverse(match task {
            Task::Run(setup) => setup.work(),
            Task::Scan(scan) => scan.work(),
        })
    });
    let done = replicas::in_parallel(arguments.shared.threads, tasks, |task| {
        Ok(match task {
            Task::Run(setup) => Done::Run(Box::new((setup, setup.run(&interrupt, &progress)?))),
            Task::Scan(scan) => Done::Scan(scan, scan.run(&interrupt, &progress)?),
        })
    });
    progress.finish();
    let done = match done {
        Err(_) if interrupt.pressed() => return Ok(Ending::Interrupted),
        done => done?,
    };
    let (mut runs, mut scans) = (Vec::new(), Vec::new());
    for done in done {
        match done {
            Done::Run(finished) => runs.push(*finished),
            Done::Scan(scan, deviation) => scans.push((scan, deviation)),
        }
    }
    runs.sort_by(|(a, _), (b, _)| a.key().partial_cmp(&b.key()).unwrap_or(std::cmp::Ordering::Equal));
    scans.sort_by(|(a, _), (b, _)| a.maximum_displacement.total_cmp(&b.maximum_displacement));
    let prediction = Prediction::new()?;
    write(&runs, &prediction, &directory)?;
    scan::write(&scans, &directory)?;
    picture::draw(&runs, &scans, &prediction, &directory.join("seven_per_cent"))?;
    println!("{}", table(&runs, &prediction));
    println!("{}", scan::table(&scans));
    println!("written to {}", directory.display());
    let holds = verdicts(&runs, &prediction);
    println!("\n{}", holds.text);
    Ok(if holds.all { Ending::Finished } else { Ending::ClaimFailed })
}

/// P/(nTZ) − 1 in per cent.
fn percent(deviation: Estimate) -> String {
    Estimate::new(100.0 * deviation.mean, 100.0 * deviation.standard_error).to_string()
}

/// Bands that the table shows: the middle of each, in diameters.
const SHOWN: [usize; 5] = [0, 2, 4, 6, 10];

fn table(runs: &[Finished], prediction: &Prediction) -> Table {
    let mut head = vec!["P/(nTZ) − 1 in %, at heights".to_owned()];
    if let Some((_, outcome)) = runs.first() {
        head.extend(SHOWN.map(|band| format!("{}", outcome.bands[0][band].height)));
    }
    head.push("h_c".into());
    head.push("certificate".into());
    let mut table = Table::new(head);
    for (setup, outcome) in runs {
        let label = setup.to_string();
        let mut cells: Vec<String> =
            SHOWN.iter().map(|&band| percent(outcome.bands[0][band].deviation)).collect();
        cells.push(outcome.center_of_mass.to_string());
        cells.push(if outcome.certificate.is_converged() { "converged" } else { "not converged" }.into());
        table.row(&label, cells);
        if setup.scheme == SchemeChoice::Instantaneous {
            let part = setup.part_outside();
            let predicted = SHOWN.map(|band| {
                let height = outcome.bands[0][band].height;
                let deviation = prediction.deviation(setup.area, setup.acceptance_bin, height);
                format!("{:.1}", 100.0 * part * deviation)
            });
            table.row("  counting noise predicts", predicted);
            for (bins, width) in outcome.bands.iter().zip(MEASURING_BINS).skip(1) {
                let cells = SHOWN.iter().map(|&band| percent(bins[band].deviation));
                table.row(&format!("  measured in bins of {width}"), cells);
            }
        }
    }
    table
}

fn write(runs: &[Finished], prediction: &Prediction, directory: &Path) -> Result<(), Failure> {
    let records = runs.iter().flat_map(|(setup, outcome)| {
        outcome.bands.iter().zip(MEASURING_BINS).flat_map(move |(bands, measuring_bin)| {
            bands.iter().map(move |band| {
                let predicted = if setup.scheme == SchemeChoice::Instantaneous {
                    setup.part_outside() * prediction.deviation(setup.area, setup.acceptance_bin, band.height)
                } else {
                    0.0
                };
                [
                    f64::from(setup.scheme as u8),
                    f64::from(setup.side as u8),
                    setup.area,
                    setup.acceptance_bin,
                    measuring_bin,
                    match setup.moves {
                        MovesChoice::Chains => 0.0,
                        MovesChoice::Local(size) => size,
                    },
                    band.height,
                    band.deviation.mean,
                    band.deviation.standard_error,
                    predicted,
                ]
            })
        })
    });
    output::write_csv(
        &directory.join("seven_per_cent.csv"),
        "lengths in d; scheme: 0 instantaneous, 1 running average, 2 averaged then frozen, 3 closure, 4 \
         self-consistent; side: 0 from above, 1 from below; maximum_displacement 0: event chains",
        [
            "scheme",
            "side",
            "area",
            "acceptance_bin",
            "measuring_bin",
            "maximum_displacement",
            "height",
            "deviation",
            "deviation_error",
            "predicted",
        ],
        records,
    )
}

/// What the data say of each hypothesis.
struct Verdicts {
    text: String,
    all: bool,
}

/// Compares every run with what is expected of it; each comparison can fail.
fn verdicts(runs: &[Finished], prediction: &Prediction) -> Verdicts {
    let mut verdicts = Verdicts { text: String::new(), all: true };
    let mut judge = |claim: &str, holds: bool, numbers: String| {
        let word = if holds { "holds" } else { "FAILS" };
        verdicts.text.push_str(&format!("{word}: {claim}: {numbers}\n"));
        verdicts.all &= holds;
    };
    // Chains cross all bins, so the formula needs no correction; where few spheres are in a bin it is not small.
    for (setup, outcome) in runs.iter().filter(|(setup, _)| setup.scheme == SchemeChoice::Instantaneous) {
        let part = setup.part_outside();
        let (mut measured, mut expected, mut squares) = (0.0, 0.0, 0.0);
        for band in &outcome.bands[0][..7] {
            measured += band.deviation.mean / 7.0;
            squares += band.deviation.standard_error * band.deviation.standard_error / 49.0;
            expected += part * prediction.deviation(setup.area, setup.acceptance_bin, band.height) / 7.0;
        }
        // Neighbouring bands move together: allow for a fully shared error.
        let error = (7.0 * squares).sqrt();
        judge(
            &format!("counting noise explains {setup}"),
            (measured - expected).abs() < 4.0 * error + 0.2 * expected.abs(),
            format!("{:.1}({:.1}) %, predicted {:.1} %", 100.0 * measured, 100.0 * error, 100.0 * expected),
        );
        let widest = outcome.bands[1][..7]
            .iter()
            .zip(&outcome.bands[0][..7])
            .map(|(fine, coarse)| (fine.deviation.mean - coarse.deviation.mean).abs())
            .fold(0.0, f64::max);
        judge(
            &format!("halving the measuring bins changes nothing in {setup}"),
            widest < 0.005,
            format!("at most {:.2} %", 100.0 * widest),
        );
    }
    let frozen =
        |scheme: SchemeChoice| scheme == SchemeChoice::Closure || scheme == SchemeChoice::SelfConsistent;
    for (setup, outcome) in runs.iter().filter(|(setup, _)| frozen(setup.scheme)) {
        let worst = outcome.bands[0].iter().map(|band| band.deviation).fold(
            Estimate::new(0.0, 1.0),
            |worst, deviation| {
                let further = deviation.deviation_from(0.0).abs() > worst.deviation_from(0.0).abs();
                if further { deviation } else { worst }
            },
        );
        judge(
            &format!("no bias in {setup}"),
            worst.deviation_from(0.0).abs() < 4.0,
            format!("the band farthest off by {} %", percent(worst)),
        );
    }
    verdicts
}

impl Setup {
    /// Order of the table.
    fn key(&self) -> (u8, f64, f64, bool, u8) {
        let local = matches!(self.moves, MovesChoice::Local(_));
        (self.scheme as u8, self.area, self.acceptance_bin, local, self.side as u8)
    }

    /// The part of the counting noise that acts on its moves.
    pub(crate) fn part_outside(&self) -> f64 {
        match self.moves {
            MovesChoice::Chains => 1.0,
            MovesChoice::Local(size) => part_outside(size, self.acceptance_bin),
        }
    }
}

impl std::fmt::Display for Setup {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let scheme = match self.scheme {
            SchemeChoice::Instantaneous => "instantaneous",
            SchemeChoice::RunningAverage => "running average",
            SchemeChoice::AveragedThenFrozen => "averaged, frozen",
            SchemeChoice::Closure => "closure",
            SchemeChoice::SelfConsistent => "self-consistent",
        };
        let side = match self.side {
            Side::Above => "from above",
            Side::Below => "from below",
        };
        write!(formatter, "{scheme}, A = {}, bins {}, {side}", self.area, self.acceptance_bin)?;
        if let MovesChoice::Local(size) = self.moves {
            write!(formatter, ", local moves S = {size}")?;
        }
        Ok(())
    }
}
