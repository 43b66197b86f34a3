//! Figures 14 to 16 of doi:10.1103/PhysRevE.83.061306: columns with T = 20 exp(−βx) in a uniform
//! field.
//!
//! For five values of β, from far above and from far below, with the default scheme: density
//! against height (14a), on a logarithmic scale with the ideal-gas law (14b), mean accepted
//! displacement of the moves of the paper (15), and P/T against packing fraction (16). Theory is
//! drawn as lines, simulation as points. The claims of each figure are tested in `verdicts.csv`.
//!
//! `--paper` also runs the protocol of the paper with its base: 25 000 spheres, displacements up to
//! 0.75, the effective field from the histogram of the last sweep, 500 000 sweeps of equilibration
//! and 500 000 of production, from a random gas.

#[macro_use]
extern crate paper;

mod checks;
mod column;
mod maximum;
mod mobility;
mod outcome;
mod picture;
mod report;
mod rows;
mod run;

use column::{Column, DECAY_RATES};
use outcome::Outcome;
use paper::{Ending, Failure, Report, Session, Side, study};
use run::{Measured, Method, Protocol, Run};
use std::process::ExitCode;

/// Draws Figures 14 to 16: temperature gradients.
#[derive(clap::Args, Debug)]
struct Arguments {
    /// Also run the protocol of the paper with its base (three hours on two cores)
    #[arg(long)]
    paper: bool,
}

impl Arguments {
    fn protocol(&self, session: &Session) -> Protocol {
        let sweeps = |sweeps: u64| session.choose(sweeps, (sweeps / 30).max(400));
        if self.paper {
            Protocol {
                width: 25.0,
                replicas: 2,
                equilibration: sweeps(2000),
                sweeps: sweeps(6000),
                mobility_sweeps: sweeps(1000),
                paper_sweeps: Some(sweeps(500_000)),
            }
        } else {
            Protocol {
                width: 9.0,
                replicas: 2,
                equilibration: sweeps(3000),
                sweeps: sweeps(8000),
                mobility_sweeps: sweeps(4000),
                paper_sweeps: None,
            }
        }
    }
}

fn main() -> ExitCode {
    study::main("nonisothermal", run)
}

fn run(arguments: &Arguments, session: &Session) -> Result<Ending, Failure> {
    let protocol = arguments.protocol(session);
    let columns: Vec<Column> =
        DECAY_RATES.into_iter().map(|rate| Column::new(rate, protocol.width)).collect::<Result<_, _>>()?;
    let mut runs = Vec::new();
    for (index, column) in columns.iter().enumerate() {
        let seed = session.seed(1000 * index as u64);
        if protocol.paper_sweeps.is_some() {
            let (method, side) = (Method::Papers, Side::Above);
            runs.push(Run { column, protocol, method, side, seed: seed.wrapping_add(500) });
        }
        for number in 0..protocol.replicas {
            let side = Side::of(number);
            let seed = seed.wrapping_add(number);
            runs.push(Run { column, protocol, method: Method::Ours, side, seed });
        }
    }
    let keys: Vec<(Method, f64)> = runs.iter().map(|run| (run.method, run.column.decay_rate)).collect();
    let measured = session
        .run_all("temperature gradients", runs, Run::name, Run::work, |run, watch| run.measure(watch))?;
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
    let mut report = Report::new(session);
    report::write(&ours, &papers, &report)?;
    picture::draw(&ours, &papers, &mut report)?;
    println!("{}", report::what_was_run(&protocol, session.seed));
    println!("{}", report::table(&ours, &papers));
    for outcome in &ours {
        println!("{}: {}", outcome.column.label(), outcome.certificate);
    }
    for outcome in &papers {
        println!("{}, field of the paper: {}", outcome.column.label(), outcome.certificate);
    }
    for (outcomes, method) in [(&ours, ""), (&papers, ", protocol of the paper")] {
        for outcome in outcomes {
            for warning in &outcome.warnings {
                println!("{}{method}: {warning}", outcome.column.label());
            }
        }
    }
    report.verdicts = checks::verdicts(&ours);
    report.finish()
}
