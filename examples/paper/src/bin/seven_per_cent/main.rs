//! Why the paper's pressures were seven per cent off at its steepest temperature gradient, and how not to be.
//!
//! The column at T₀ = 20, β = 0.05 (doi:10.1103/PhysRevE.83.061306, Fig. 17c), run with the effective field of every
//! scheme of the library, from above and from below, over bases of 156.25 and 625, with bins from 0.05 to 0.5; the bins of
//! the density that enters the field and of the density that is measured are independent. For each run P/(nTZ) − 1 is
//! drawn over height, beside what counting noise must do to a field from instantaneous counts. A second, smaller
//! column shows how the bias depends on the width of the bins and on the number of them that a move crosses.
//!
//! A field that follows every configuration breaks detailed balance, so its bias is a property of the moves too. The paper's
//! small moves take 10⁵ sweeps and more to relax its column: `--full` makes them, and every other combination, each known to
//! half a per cent; the default leaves them to the smaller column.

// A summary is put together once; the clearer call is the better one.
#![allow(clippy::format_push_string)]

mod picture;
mod prediction;
mod redraw;
mod run;
mod scan;

use clap::Parser;
use gradient_mc::statistics::Estimate;
use paper::arguments::SharedArguments;
use paper::interrupt::Interrupt;
use paper::progress::Progress;
use paper::table::{Table, percent};
use paper::{Ending, Failure, conclude, output, replicas};
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
    /// Every scheme, base and bin, from both sides, each to half a per cent; half an hour on two cores
    #[arg(long, visible_alias = "paper")]
    full: bool,
    /// Only draw the picture again, from the CSV files in the directory
    #[arg(long)]
    redraw: bool,
}

fn main() -> ExitCode {
    conclude(run(&Arguments::parse()))
}

/// The base of the paper, and one of a quarter.
const AREAS: [f64; 2] = [156.25, 625.0];
/// Bins of the density that enters the field.
const BINS: [f64; 4] = [0.05, 0.1, 0.2, 0.5];

/// Displacement of the paper's moves.
const MAXIMUM_DISPLACEMENT: f64 = 0.75;

/// A run that is long enough for an error of about half a per cent in each band.
fn setup(scheme: SchemeChoice, moves: MovesChoice, area: f64, bin: f64, side: Side, seed: u64) -> Setup {
    // Sweeps times area. Columns relax as slowly over any base; averages need as many spheres.
    let (relaxation, measurement) = match moves {
        MovesChoice::Chains => (1000.0 + 4e5 / area, 1.1e6),
        MovesChoice::Local(_) => (30_000.0, 3.2e7),
    };
    // Positive, and far below 2^53.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let sweeps = |number: f64| number.round() as u64;
    Setup {
        scheme,
        area,
        acceptance_bin: bin,
        moves,
        side,
        equilibration: sweeps(relaxation),
        // Blocks must be long against the slowest mode, some 150 sweeps of chains, for error bars to be right.
        sweeps: sweeps((measurement / area).max(4000.0)),
        seed,
    }
}

/// The runs of a few kinds, or of all.
fn setups(full: bool, seed: u64) -> Vec<Setup> {
    let seed = seed.wrapping_mul(1_000_003);
    let mut setups = Vec::new();
    let mut add = |scheme, moves, area, bin, side, part: u64| {
        let setup = setup(scheme, moves, area, bin, side, seed.wrapping_add(setups.len() as u64));
        let (equilibration, sweeps) = (setup.equilibration / part.min(2), setup.sweeps / part);
        setups.push(Setup { equilibration, sweeps, ..setup });
    };
    let (chains, local) = (MovesChoice::Chains, MovesChoice::Local(MAXIMUM_DISPLACEMENT));
    let sides = [Side::Above, Side::Below];
    if !full {
        add(SchemeChoice::Instantaneous, chains, 156.25, 0.1, Side::Above, 2);
        add(SchemeChoice::Closure, chains, 156.25, 0.1, Side::Below, 2);
        for side in sides {
            add(SchemeChoice::SelfConsistent, chains, 156.25, 0.1, side, 2);
        }
        return setups;
    }
    for (area, side) in AREAS.into_iter().flat_map(|area| sides.map(|side| (area, side))) {
        for bin in BINS {
            add(SchemeChoice::Instantaneous, local, area, bin, side, 1);
            add(SchemeChoice::SelfConsistent, chains, area, bin, side, 1);
        }
        add(SchemeChoice::Instantaneous, chains, area, 0.1, side, 1);
        for scheme in [SchemeChoice::RunningAverage, SchemeChoice::AveragedThenFrozen, SchemeChoice::Closure]
        {
            add(scheme, chains, area, 0.1, side, 1);
        }
    }
    setups
}

/// A run with what it came to.
pub(crate) type Finished = (Setup, Outcome);

/// A run as it is drawn.
pub(crate) type Drawn = (Setup, Vec<run::Band>);

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
    let path = directory.join("seven_per_cent");
    let prediction = Prediction::new(run::COLUMN)?;
    if arguments.redraw {
        picture::draw(&redraw::runs(&directory)?, &redraw::scans(&directory)?, &prediction, &path)?;
        return Ok(Ending::Finished);
    }
    output::create_directory(&directory)?;
    let interrupt = Interrupt::listen()?;
    let setups = setups(arguments.full, arguments.shared.seed);
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
    scans.sort_by(|(a, _), (b, _)| {
        a.bin.total_cmp(&b.bin).then(a.maximum_displacement.total_cmp(&b.maximum_displacement))
    });
    write(&runs, &prediction, &directory)?;
    scan::write(&scans, &directory)?;
    let drawn: Vec<Drawn> = runs.iter().map(|(setup, outcome)| (*setup, outcome.bands[0].clone())).collect();
    picture::draw(&drawn, &scans, &prediction, &path)?;
    println!("{}", table(&runs, &prediction));
    println!("{}", scan::table(&scans)?);
    for (setup, outcome) in &runs {
        for warning in &outcome.warnings {
            println!("{setup}: warning: {warning}");
        }
    }
    println!("written to {}", directory.display());
    let holds = verdicts(&runs, &scans, &prediction)?;
    println!("\n{}", holds.text);
    Ok(if holds.all { Ending::Finished } else { Ending::ClaimFailed })
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
        if let Some(part) = setup.part_outside() {
            let predicted = SHOWN.map(|band| {
                let height = outcome.bands[0][band].height;
                let deviation = prediction.deviation(setup.area, setup.acceptance_bin, height);
                format!("{:.1}", 100.0 * part * deviation)
            });
            table.row("  counting noise predicts", predicted);
        }
        if setup.scheme == SchemeChoice::Instantaneous {
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
                let predicted = setup.part_outside().map_or(f64::NAN, |part| {
                    part * prediction.deviation(setup.area, setup.acceptance_bin, band.height)
                });
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
         self-consistent; side: 0 from above, 1 from below; maximum_displacement 0: event chains; \
         predicted: NaN where nothing is",
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
fn verdicts(
    runs: &[Finished],
    scans: &[(Scan, Estimate)],
    prediction: &Prediction,
) -> Result<Verdicts, Failure> {
    let mut verdicts = Verdicts { text: String::new(), all: true };
    let mut judge = |claim: &str, holds: bool, numbers: String| {
        let word = if holds { "holds" } else { "FAILS" };
        verdicts.text.push_str(&format!("{word}: {claim}: {numbers}\n"));
        verdicts.all &= holds;
    };
    for (setup, outcome) in runs.iter().filter(|(setup, _)| setup.scheme == SchemeChoice::Instantaneous) {
        if let Some(part) = setup.part_outside() {
            let (mut measured, mut expected, mut squares) = (0.0, 0.0, 0.0);
            for band in &outcome.bands[0][..7] {
                measured += band.deviation.mean / 7.0;
                squares += band.deviation.standard_error * band.deviation.standard_error / 49.0;
                expected += part * prediction.deviation(setup.area, setup.acceptance_bin, band.height) / 7.0;
            }
            // Neighboring bands move together: allow for a fully shared error. The formula takes counts to be Poisson,
            // displacements uniform and the profile that of theory: a fifth of it is allowed for that.
            let error = (7.0 * squares).sqrt();
            let numbers = format!(
                "{:.1}({:.1}) %, predicted {:.1} %",
                100.0 * measured,
                100.0 * error,
                100.0 * expected
            );
            if expected < 1.0 {
                judge(
                    &format!("counting noise explains {setup}"),
                    (measured - expected).abs() < 4.0 * error + 0.2 * expected,
                    numbers,
                );
            } else {
                // Far from the profile that the formula takes it is no more than a warning.
                judge(&format!("the column runs away in {setup}"), measured > 1.0, numbers);
            }
        }
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
    // Where bins are hardly ever occupied, what an empty one counts as decides, and the formula is rough.
    for (scan, deviation) in scans.iter().filter(|(scan, _)| scan.bin >= Scan::NARROWEST_JUDGED) {
        let Scan { bin, maximum_displacement, .. } = scan;
        let expected = scan.predicted()?;
        judge(
            &format!("counting noise explains the small column, bins {bin}, S = {maximum_displacement}"),
            (deviation.mean - expected).abs() < 4.0 * deviation.standard_error + 0.2 * expected.abs(),
            format!("{} %, predicted {:.1} %", percent(*deviation), 100.0 * expected),
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
    Ok(verdicts)
}

impl Setup {
    /// Order of the table.
    fn key(&self) -> (u8, f64, f64, u8, u8) {
        let moves = match self.moves {
            MovesChoice::Local(_) => 0,
            MovesChoice::Chains => 1,
        };
        (self.scheme as u8, self.area, self.acceptance_bin, moves, self.side as u8)
    }

    /// The part of the counting noise that acts on its moves, if it is known: none of the noise where the field does not
    /// follow it, and for chains the noise of a field acts in another way.
    pub(crate) fn part_outside(&self) -> Option<f64> {
        match (self.scheme, self.moves) {
            (SchemeChoice::Instantaneous, MovesChoice::Local(size)) => {
                Some(part_outside(size, self.acceptance_bin))
            }
            _ => None,
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
        match self.moves {
            MovesChoice::Chains => write!(formatter, ", chains"),
            MovesChoice::Local(size) => write!(formatter, ", S = {size}"),
        }
    }
}
