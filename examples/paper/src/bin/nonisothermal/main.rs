//! Figures 14 to 16 of doi:10.1103/PhysRevE.83.061306: columns with T = 20 exp(−βx) in a uniform field.
//!
//! For five β, from far above and from far below, with the default scheme: density against height (14a) and on a logarithmic
//! scale with the ideal-gas law (14b), mean accepted displacement of the paper's moves (15), and P/T against packing fraction
//! (16). Theory is drawn as lines, simulation as points. What each figure claims is decided by numbers, in `verdicts.csv`.
//!
//! `--paper` runs the paper's own protocol beside ours, over its base: 25 000 spheres, displacements up to 0.75, the
//! effective field from the histogram of the last sweep, 500 000 sweeps discarded and as many measured, from a uniform start.

mod checks;
mod column;
mod maximum;
mod mobility;
mod outcome;
mod picture;
mod report;
mod rows;
mod run;

use clap::Parser;
use column::{Column, DECAY_RATES};
use outcome::Outcome;
use paper::arguments::SharedArguments;
use paper::interrupt::Interrupt;
use paper::progress::Progress;
use paper::{Ending, Failure, conclude, output, replicas};
use run::{Measured, Method, Protocol, Run, Side};
use std::process::ExitCode;

/// Draws Figures 14 to 16: temperature gradients.
#[derive(Parser, Debug)]
#[command(name = "nonisothermal")]
struct Arguments {
    #[command(flatten)]
    shared: SharedArguments,
    /// The paper's protocol beside ours, over the paper's base: three hours on two cores
    #[arg(long)]
    paper: bool,
    /// Divides all numbers of sweeps, to try the program out: the verdicts may fail then
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    shorten: u64,
    /// Side of the base, in diameters [default: 9; with --paper: 25]
    #[arg(long)]
    width: Option<f64>,
}

impl Arguments {
    fn protocol(&self) -> Protocol {
        let sweeps = |sweeps: u64| (sweeps / self.shorten).max(400);
        if self.paper {
            Protocol {
                width: self.width.unwrap_or(25.0),
                replicas: 2,
                equilibration: sweeps(2000),
                sweeps: sweeps(6000),
                mobility_sweeps: sweeps(1000),
                paper_sweeps: Some(sweeps(500_000)),
            }
        } else {
            Protocol {
                width: self.width.unwrap_or(9.0),
                replicas: 2,
                equilibration: sweeps(1500),
                sweeps: sweeps(3500),
                mobility_sweeps: sweeps(4000),
                paper_sweeps: None,
            }
        }
    }
}

fn main() -> ExitCode {
    conclude(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<Ending, Failure> {
    let directory = arguments.shared.directory("nonisothermal");
    output::create_directory(&directory)?;
    let interrupt = Interrupt::listen()?;
    let protocol = arguments.protocol();
    let columns: Vec<Column> =
        DECAY_RATES.into_iter().map(|rate| Column::new(rate, protocol.width)).collect::<Result<_, _>>()?;
    let mut runs = Vec::new();
    let base_seed = arguments.shared.seed.wrapping_mul(1_000_003);
    // The longest first, so that the threads end together.
    for (index, column) in columns.iter().enumerate().rev() {
        let seed = base_seed.wrapping_add(1000 * index as u64);
        if protocol.paper_sweeps.is_some() {
            let (method, side) = (Method::Papers, Side::Above);
            runs.push(Run { column, protocol, method, side, seed: seed.wrapping_add(500) });
        }
        for number in 0..protocol.replicas {
            let side = if number.is_multiple_of(2) { Side::Above } else { Side::Below };
            let seed = seed.wrapping_add(number);
            runs.push(Run { column, protocol, method: Method::Ours, side, seed });
        }
    }
    let progress = Progress::new(runs.iter().map(Run::work).sum(), "temperature gradients");
    let keys: Vec<(Method, f64)> = runs.iter().map(|run| (run.method, run.column.decay_rate)).collect();
    let measured =
        replicas::in_parallel(arguments.shared.threads, runs, |run| run.measure(&interrupt, &progress));
    progress.finish();
    let measured = match measured {
        Err(_) if interrupt.pressed() => return Ok(Ending::Interrupted),
        measured => measured?,
    };
    let outcomes = |method: Method| -> Result<Vec<Outcome>, Failure> {
        let of_column = |column: &Column| {
            let wanted = keys.iter().zip(&measured).filter(|(key, _)| **key == (method, column.decay_rate));
            let runs: Vec<Measured> = wanted.map(|(_, measured)| measured.clone()).collect();
            Outcome::new(column, &runs)
        };
        columns.iter().map(of_column).collect()
    };
    let ours = outcomes(Method::Ours)?;
    let papers = if protocol.paper_sweeps.is_some() { outcomes(Method::Papers)? } else { Vec::new() };
    report::write(&ours, &papers, &directory)?;
    picture::draw(&ours, &papers, &directory)?;
    report::captions(&protocol, &directory)?;
    println!("{}", report::what_was_run(&protocol, arguments.shared.seed));
    println!("{}", report::table(&ours, &papers));
    for outcome in &ours {
        println!("{}: {}", outcome.column.label(), outcome.certificate);
    }
    for outcome in &papers {
        println!("{}, the paper's field: {}", outcome.column.label(), outcome.certificate);
    }
    for (outcomes, method) in [(&ours, ""), (&papers, ", the paper's protocol")] {
        for outcome in outcomes {
            for warning in &outcome.warnings {
                println!("{}{method}: {warning}", outcome.column.label());
            }
        }
    }
    let verdicts = checks::verdicts(&ours);
    verdicts.write_csv(&directory)?;
    println!("\n{verdicts}");
    println!("written to {}", directory.display());
    Ok(verdicts.ending())
}
