//! Figure 17 of doi:10.1103/PhysRevE.83.061306: how far P is from the equation of state, and how well it is known.
//!
//! The steepest column of each of the paper's systems (T₀ = 5; α = 0.05, and what stays fluid at α = 0.1; β = 0.05), analysed
//! twice. Left: δ (33) and σ (32) exactly as the paper defines them, from five runs, in bins of 0.1 d, with its line at 2 %.
//! Right: P/(nTZ) − 1 with its sign and with error bars by the jackknife, over ranges of heights, against Carnahan-Starling and
//! against the better equation of Kolafa, Labík and Malijevský as modified in 2019.
//!
//! At β = 0.05 the paper's own effective field is run, too, over a smaller base with as much counting noise: it is where its 7 %
//! come from (`docs/seven_per_cent.md`, `-p paper --bin seven_per_cent`). `--paper` runs the paper's protocol in all systems beside ours, over its base.

mod case;
mod checks;
mod nonlocal;
mod outcome;
mod papers;
mod picture;
mod report;
mod run;

use case::Case;
use clap::Parser;
use gradient_mc::observers::EquationOfStateProfile;
use nonlocal::Nonlocal;
use outcome::{Analysis, Outcome};
use paper::arguments::SharedArguments;
use paper::interrupt::Interrupt;
use paper::progress::Progress;
use paper::{Ending, Failure, conclude, output, replicas, warnings};
use run::{NOISY_WIDTH, Plan, RUNS, Run, Side};
use std::process::ExitCode;

/// Draws Figure 17: deviations from the equation of state, and their errors.
#[derive(Parser, Debug)]
#[command(name = "deviations")]
struct Arguments {
    #[command(flatten)]
    shared: SharedArguments,
    /// The paper's protocol in every system beside ours, over the paper's base: two hours on two cores
    #[arg(long)]
    paper: bool,
    /// Divides all numbers of sweeps, to try the program out: the verdicts may fail then
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    shorten: u64,
    /// Side of the base, in diameters, of all runs [default: 7, and 10.5 for the paper's field; with --paper: 25]
    #[arg(long)]
    width: Option<f64>,
}

/// Sides of the base: ours, and the paper's.
const WIDTHS: [f64; 2] = [7.0, 25.0];

impl Arguments {
    fn sweeps(&self, sweeps: u64) -> u64 {
        (sweeps / self.shorten).max(100)
    }

    fn ours(&self, number: u64) -> Plan {
        Plan::Ours { number, equilibration: self.sweeps(1600), sweeps: self.sweeps(3300) }
    }

    /// The paper's runs of a case.
    fn papers(&self, case: &Case) -> Vec<(&'static str, Plan)> {
        if self.paper {
            let plan = Plan::Protocol { equilibration: self.sweeps(500_000), sweeps: self.sweeps(100_000) };
            vec![("the paper's protocol", plan)]
        } else if case.decay_rate > 0.0 {
            let plan = |side| Plan::Field {
                side,
                jumps: self.sweeps(12_000),
                equilibration: self.sweeps(8000),
                sweeps: self.sweeps(4000),
            };
            vec![
                ("the paper's field, from above", plan(Side::Above)),
                ("the paper's field, from below", plan(Side::Below)),
            ]
        } else {
            Vec::new()
        }
    }
}

fn main() -> ExitCode {
    conclude(run(&Arguments::parse()))
}

/// Whose runs: the number of the case and, for the paper's, their name.
type Key = (usize, Option<&'static str>);

fn run(arguments: &Arguments) -> Result<Ending, Failure> {
    let directory = arguments.shared.directory("deviations");
    output::create_directory(&directory)?;
    let interrupt = Interrupt::listen()?;
    let width = |default: f64| arguments.width.unwrap_or(default);
    let cases = Case::all(width(WIDTHS[usize::from(arguments.paper)]))?;
    let wide = Case::all(width(if arguments.paper { WIDTHS[1] } else { NOISY_WIDTH }))?;
    let base_seed = arguments.shared.seed.wrapping_mul(1_000_003);
    let mut tasks: Vec<(Key, Run)> = Vec::new();
    for (index, (case, wide)) in cases.iter().zip(&wide).enumerate() {
        let seed = base_seed.wrapping_add(1000 * index as u64);
        for (number, (name, plan)) in (0..).zip(arguments.papers(case)) {
            let seed = seed.wrapping_add(500 + number);
            tasks.push(((index, Some(name)), Run { case: wide.clone(), plan, seed }));
        }
        for number in 0..RUNS {
            let (plan, seed) = (arguments.ours(number), seed.wrapping_add(number));
            tasks.push(((index, None), Run { case: case.clone(), plan, seed }));
        }
    }
    // The longest first, so that the threads end together.
    tasks.sort_by_key(|(_, run)| std::cmp::Reverse(run.work()));
    let progress = Progress::new(tasks.iter().map(|(_, run)| run.work()).sum(), "deviations");
    let measured = replicas::in_parallel(arguments.shared.threads, tasks, |(key, run)| {
        Ok((key, run.measure(&interrupt, &progress)?))
    });
    progress.finish();
    let measured = match measured {
        Err(_) if interrupt.pressed() => return Ok(Ending::Interrupted),
        measured => measured?,
    };
    let of_key =
        |key: Key| measured.iter().filter(move |(other, _)| *other == key).map(|(_, measured)| measured);
    let runs_of = |key: Key| -> Vec<EquationOfStateProfile> {
        of_key(key).flat_map(|measured| measured.profiles.clone()).collect()
    };
    let warnings_of = |key: Key| warnings::lines(of_key(key).map(|measured| &measured.warnings[..]));
    let (mut outcomes, mut warned) = (Vec::new(), Vec::new());
    for (index, case) in cases.into_iter().enumerate() {
        let mut papers = Vec::new();
        for (name, _) in arguments.papers(&case) {
            let key = (index, Some(name));
            warned.extend(
                warnings_of(key).iter().map(|warning| format!("{}, {name}: {warning}", case.label())),
            );
            papers.push((name.to_owned(), Analysis::new(&case, &runs_of(key))?));
        }
        warned
            .extend(warnings_of((index, None)).iter().map(|warning| format!("{}: {warning}", case.label())));
        let ours = Analysis::new(&case, &runs_of((index, None)))?;
        let nonlocal = Nonlocal::of(&case);
        let nonlocal = case.groups.iter().map(|&group| nonlocal.over(group)).collect();
        outcomes.push(Outcome { case, nonlocal, ours, papers });
    }
    report::write(&outcomes, &directory)?;
    report::captions(&directory)?;
    picture::draw(&outcomes, &directory)?;
    for outcome in &outcomes {
        println!("{}: {}", outcome.case.label(), run::describe_box(&outcome.case));
    }
    println!("ours: {}", Run::describe(arguments.ours(0)));
    for (_, plan) in
        outcomes.last().map(|outcome| arguments.papers(&outcome.case)).into_iter().flatten().take(1)
    {
        println!("{}: {}", run::describe_box(&wide[0]), Run::describe(plan));
    }
    println!("seed {}\n\n{}", arguments.shared.seed, report::table(&outcomes));
    println!("{}", report::groups(&outcomes));
    for warning in &warned {
        println!("{warning}");
    }
    let verdicts = checks::verdicts(&outcomes);
    verdicts.write_csv(&directory)?;
    println!("{verdicts}");
    println!("written to {}", directory.display());
    Ok(verdicts.ending())
}
