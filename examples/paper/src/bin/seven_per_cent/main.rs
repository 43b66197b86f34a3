//! Explains the deviation of seven per cent of the pressures in the paper at its steepest
//! temperature gradient, and tests schemes without it.
//!
//! The column at T₀ = 20, β = 0.05 (doi:10.1103/PhysRevE.83.061306, Fig. 17c), run with the
//! effective field of every scheme of the library, from above and from below, over bases of 156.25
//! and 625, with bins from 0.05 to 0.5; the bins of the density that enters the field and of the
//! density that is measured are independent. For each run P/(nTZ) − 1 is drawn against height, with
//! the prediction by counting noise for a field from instantaneous counts. A second, smaller column
//! shows the dependence of the bias on the width of the bins and on the number of bins that a move
//! crosses.
//!
//! A field that changes with every configuration breaks detailed balance, so its bias depends on
//! the moves too. The small moves of the paper need 10⁵ sweeps and more to relax its column:
//! `--full` runs them and all other combinations, each with an error of half a per cent; the
//! default runs them only in the smaller column.

#[macro_use]
extern crate paper;

mod collisions;
mod picture;
mod prediction;
mod run;
mod scan;

use gradient_mc::statistics::Estimate;
use paper::groups::largest;
use paper::study::{self, count};
use paper::table::{Table, percent};
use paper::verdict::Verdicts;
use paper::{Ending, Failure, Report, Session, Side};
use prediction::{Prediction, part_outside};
use run::{Band, MEASURING_BINS, MovesChoice, Outcome, SchemeChoice, Setup};
use scan::Scan;
use std::process::ExitCode;

/// Explains the deviation of seven per cent in the paper at β = 0.05.
#[derive(clap::Args, Debug)]
struct Arguments {
    /// Run every scheme, base and bin width from both sides, each to half a per cent (half an hour
    /// on two cores)
    #[arg(long)]
    full: bool,
}

fn main() -> ExitCode {
    study::main("seven_per_cent", run)
}

/// Areas of the base: that of the paper, and a quarter of it.
const AREAS: [f64; 2] = [156.25, 625.0];
/// Bins of the density that enters the field.
const BINS: [f64; 4] = [0.05, 0.1, 0.2, 0.5];

/// Displacement of the paper's moves.
const MAXIMUM_DISPLACEMENT: f64 = 0.75;

/// A run that is long enough for an error of about half a per cent in each band.
fn setup(scheme: SchemeChoice, moves: MovesChoice, area: f64, bin: f64, side: Side, seed: u64) -> Setup {
    // Sweeps of relaxation, and sweeps times area of production: the relaxation does not depend on
    // the area.
    let (relaxation, measurement) = match moves {
        MovesChoice::Chains => (1000.0 + 4e5 / area, 1.1e6),
        MovesChoice::Local(_) => (30_000.0, 3.2e7),
    };
    let sweeps = |number: f64| count(number) as u64;
    Setup {
        scheme,
        area,
        acceptance_bin: bin,
        moves,
        side,
        approach: [300, 15_000],
        equilibration: sweeps(relaxation),
        // Blocks must be long against the slowest mode, some 150 sweeps of chains, for error bars to be
        // right.
        sweeps: sweeps((measurement / area).max(4000.0)),
        seed,
    }
}

/// The runs of a few kinds, or of all.
fn setups(full: bool, session: &Session) -> Vec<Setup> {
    let mut setups = Vec::new();
    let mut add = |scheme, moves, area, bin, side, part: u64| {
        let setup = setup(scheme, moves, area, bin, side, session.seed(setups.len() as u64));
        setups.push(if session.short {
            Setup { area: setup.area / 4.0, approach: [20, 50], equilibration: 50, sweeps: 400, ..setup }
        } else {
            Setup { equilibration: setup.equilibration / part.min(2), sweeps: setup.sweeps / part, ..setup }
        });
    };
    let (chains, local) = (MovesChoice::Chains, MovesChoice::Local(MAXIMUM_DISPLACEMENT));
    if !full {
        add(SchemeChoice::Instantaneous, chains, 156.25, 0.1, Side::Above, 2);
        add(SchemeChoice::Closure, chains, 156.25, 0.1, Side::Below, 2);
        add(SchemeChoice::RunningCollisions, chains, 156.25, 0.1, Side::Above, 2);
        for side in Side::BOTH {
            add(SchemeChoice::SelfConsistent, chains, 156.25, 0.1, side, 2);
        }
        return setups;
    }
    for (area, side) in AREAS.into_iter().flat_map(|area| Side::BOTH.map(|side| (area, side))) {
        for bin in BINS {
            add(SchemeChoice::Instantaneous, local, area, bin, side, 1);
            add(SchemeChoice::SelfConsistent, chains, area, bin, side, 1);
        }
        add(SchemeChoice::Instantaneous, chains, area, 0.1, side, 1);
        for scheme in [
            SchemeChoice::RunningAverage,
            SchemeChoice::AveragedThenFrozen,
            SchemeChoice::RunningCollisions,
            SchemeChoice::Closure,
        ] {
            add(scheme, chains, area, 0.1, side, 1);
        }
    }
    setups
}

/// A run with its outcome.
pub(crate) type Finished = (Setup, Outcome);

/// A run as it is drawn.
pub(crate) type Drawn = (Setup, Vec<Band>);

enum Task {
    Run(Setup),
    Scan(Scan),
}

enum Done {
    Run(Box<Finished>),
    Scan(Scan, Estimate),
}

fn run(arguments: &Arguments, session: &Session) -> Result<Ending, Failure> {
    let prediction = Prediction::new(run::COLUMN)?;
    let setups = setups(arguments.full, session);
    let scans = Scan::all(arguments.full, session);
    let tasks: Vec<Task> =
        setups.into_iter().map(Task::Run).chain(scans.into_iter().map(Task::Scan)).collect();
    let work = |task: &Task| match task {
        Task::Run(setup) => setup.work(),
        Task::Scan(scan) => scan.work(),
    };
    let name = |task: &Task| match task {
        Task::Run(setup) => format!("{setup}, seed {}", setup.seed),
        Task::Scan(scan) => format!("scan, {scan:?}"),
    };
    let done = session.run_all("seven per cent", tasks, name, work, |task, watch| {
        Ok(match task {
            Task::Run(setup) => Done::Run(Box::new((setup, setup.run(watch)?))),
            Task::Scan(scan) => Done::Scan(scan, scan.run(watch)?),
        })
    })?;
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
    let mut report = Report::new(session);
    write(&runs, &prediction, &report)?;
    scan::write(&scans, &report)?;
    let drawn: Vec<Drawn> = runs.iter().map(|(setup, outcome)| (*setup, outcome.bands[0].clone())).collect();
    picture::draw(&drawn, &scans, &prediction, &mut report)?;
    println!("{}", table(&runs, &prediction));
    println!("{}", scan::table(&scans)?);
    for (setup, outcome) in &runs {
        for warning in &outcome.warnings {
            println!("{setup}: warning: {warning}");
        }
    }
    report.verdicts = verdicts(&runs, &scans, &prediction)?;
    report.finish()
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
            table.row("  predicted by counting noise", predicted);
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

fn write(runs: &[Finished], prediction: &Prediction, report: &Report) -> Result<(), Failure> {
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
    report.table(
        "seven_per_cent",
        "lengths in d; scheme: 0 instantaneous, 1 running average, 2 averaged then frozen, 3 closure, 4 \
         self-consistent; side: 0 from above, 1 from below; maximum_displacement 0: event chains; \
         predicted: NaN where nothing is",
        "scheme, side, area, acceptance_bin, measuring_bin, maximum_displacement, height, \
         deviation, deviation_error, predicted",
        records,
    )
}

/// Compares every run with its prediction. All numbers are P/(nTZ) − 1.
fn verdicts(
    runs: &[Finished],
    scans: &[(Scan, Estimate)],
    prediction: &Prediction,
) -> Result<Verdicts, Failure> {
    const FIGURE: &str = "17c";
    let mut verdicts = Verdicts::new();
    for (setup, outcome) in runs.iter().filter(|(setup, _)| setup.scheme == SchemeChoice::Instantaneous) {
        if let Some(part) = setup.part_outside() {
            let bands = &outcome.bands[0][..7];
            let predicted = |band: &Band| prediction.deviation(setup.area, setup.acceptance_bin, band.height);
            let expected = part * bands.iter().map(predicted).sum::<f64>() / 7.0;
            let mut measured = Estimate::mean_of_independent(bands.iter().map(|band| band.deviation));
            // Neighboring bands move together: allow for a fully shared error. The formula takes counts to be
            // Poisson, displacements uniform and the profile that of theory: a fifth of it is
            // allowed for that.
            measured.standard_error *= 7.0_f64.sqrt();
            if expected < 1.0 {
                let reach = 4.0 * measured.standard_error + 0.2 * expected;
                let claim = format!("P/(nTZ) − 1 predicted by counting noise ({expected:.3}): {setup}");
                verdicts.between(FIGURE, &claim, measured, expected - reach, expected + reach);
            } else {
                // Far from the profile that the formula takes it is no more than a warning.
                verdicts.at_least(
                    FIGURE,
                    &format!("no steady state, P/(nTZ) − 1 above 1: {setup}"),
                    measured,
                    1.0,
                );
            }
        }
        let pairs = outcome.bands[1][..7].iter().zip(&outcome.bands[0][..7]);
        let widest = largest(pairs.map(|(fine, coarse)| (fine.deviation.mean - coarse.deviation.mean).abs()));
        let claim = format!("difference with half the measuring bins: {setup}");
        verdicts.at_most(FIGURE, &claim, Estimate::exact(widest), 0.005);
    }
    // Where bins are hardly ever occupied, what an empty one counts as decides, and the formula is
    // rough.
    for (scan, deviation) in scans.iter().filter(|(scan, _)| scan.bin >= Scan::NARROWEST_JUDGED) {
        let Scan { bin, maximum_displacement, .. } = scan;
        let expected = scan.predicted()?;
        let reach = 4.0 * deviation.standard_error + 0.2 * expected.abs();
        let claim = format!(
            "P/(nTZ) − 1 predicted by counting noise ({expected:.3}): small column, bins {bin}, S = {maximum_displacement}"
        );
        verdicts.between(FIGURE, &claim, *deviation, expected - reach, expected + reach);
    }
    let frozen =
        |scheme: SchemeChoice| scheme == SchemeChoice::Closure || scheme == SchemeChoice::SelfConsistent;
    for (setup, outcome) in runs.iter().filter(|(setup, _)| frozen(setup.scheme)) {
        let off = |band: &Band| band.deviation.deviation_from(0.0).abs();
        let farthest = largest(outcome.bands[0].iter().map(off));
        let claim = format!("largest |P/(nTZ) − 1| of a band in standard errors, no bias: {setup}");
        verdicts.at_most(FIGURE, &claim, Estimate::exact(farthest), 4.0);
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

    /// The part of the counting noise that acts on its moves, if it is known: none of the noise
    /// where the field does not follow it, and for chains the noise of a field acts in another
    /// way.
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
            SchemeChoice::RunningCollisions => "collisions, running",
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
