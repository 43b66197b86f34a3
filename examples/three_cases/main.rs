//! The three systems of Mehrotra, Puri and Khakhar (doi:10.1103/PhysRevE.83.061306), on its parameters:
//!
//! | case | field | temperature |
//! |---|---|---|
//! | (a) | a = 1 | T = 15 |
//! | (b) | a = exp(0.02 x) | T = 20 |
//! | (c) | a = 1 | T = 20 exp(−0.02 x) |
//!
//! each with 40 spheres per area of the base, in a box 400 high. One run of each yields the equation
//! of state from the base density up to the dilute top; it is compared with Carnahan-Starling and with
//! the modified Kolafa-Labík-Malijevský equation. Every case writes a CSV file, a PNG and an SVG.

// A summary is put together once; the clearer call is the better one.
#![allow(clippy::format_push_string)]

#[path = "../common/mod.rs"]
mod common;

mod case;
mod measurement;
mod picture;
mod protocol;
mod report;
mod summary;

use case::Case;
use clap::Parser;
use common::interrupt::Interrupt;
use common::progress::{Progress, in_words};
use common::{Ending, Failure, conclude, output, replicas};
use measurement::Replica;
use protocol::{Arguments, Protocol};
use report::Report;
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

fn main() -> ExitCode {
    conclude(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<Ending, Failure> {
    let protocol = Protocol::new(arguments)?;
    let directory = arguments.shared.directory("three_cases");
    output::create_directory(&directory)?;
    let interrupt = Interrupt::listen()?;
    println!("{protocol}");
    if arguments.paper {
        announce_duration(&protocol, arguments.shared.threads, &interrupt)?;
    }

    let started = Instant::now();
    let tasks: Vec<(Case, u64)> = Case::ALL
        .into_iter()
        .flat_map(|case| (0..protocol.replicas).map(move |replica| (case, replica)))
        .collect();
    let progress = Progress::new(tasks.len() as u64 * protocol.sweeps_per_replica(), "three cases");
    let measured = replicas::in_parallel(arguments.shared.threads, tasks, |(case, replica)| {
        case.simulate(&protocol, protocol.seed(case, replica), &interrupt, &progress)
    })?;
    progress.finish();
    let elapsed = started.elapsed();

    let per_case = measured.chunks(usize::try_from(protocol.replicas)?);
    let mut reports = Vec::new();
    for (case, replicas) in Case::ALL.into_iter().zip(per_case) {
        // An interrupt may come before anything was measured.
        if replicas.iter().any(|replica| replica.measured > 0) {
            reports.push(write_case(case, replicas, &protocol, &directory)?);
        }
    }
    if reports.is_empty() {
        println!("nothing was measured before the interrupt");
    } else {
        println!("\n{}", summary::table(&reports));
        println!("{}", summary::remarks(&protocol, &reports, arguments.shared.threads, elapsed));
        println!("written to {}", directory.display());
    }
    Ok(if interrupt.pressed() { Ending::Interrupted } else { Ending::Finished })
}

/// Evaluates one case and writes its files.
fn write_case(
    case: Case,
    replicas: &[Replica],
    protocol: &Protocol,
    directory: &Path,
) -> Result<Report, Failure> {
    let report = Report::new(case, replicas, protocol)?;
    let path = directory.join(case.name());
    report.write_csv(&path.with_extension("csv"))?;
    picture::draw(&report, &path)?;
    Ok(report)
}

/// Says how long the protocol takes on this machine, from a few sweeps of each case.
fn announce_duration(protocol: &Protocol, threads: usize, interrupt: &Interrupt) -> Result<(), Failure> {
    let trial = protocol.trial();
    let speeds = Case::ALL
        .into_iter()
        .map(|case| {
            let replica = case.simulate(&trial, 0, interrupt, &Progress::hidden())?;
            Ok(replica.busy.as_secs_f64() / trial.sweeps_per_replica() as f64)
        })
        .collect::<Result<Vec<f64>, Failure>>()?;
    let sweeps = protocol.sweeps_per_replica() as f64;
    let mut free_at = vec![0.0; replicas::thread_count(threads)];
    for seconds in speeds.iter().flat_map(|seconds| (0..protocol.replicas).map(move |_| seconds * sweeps)) {
        // Each replica goes to the thread that is free first.
        free_at.sort_by(f64::total_cmp);
        free_at[0] += seconds;
    }
    let total = Duration::from_secs_f64(free_at.into_iter().fold(0.0, f64::max));
    println!(
        "estimate: {} on {} threads; Ctrl-C stops and writes everything measured by then",
        in_words(total),
        replicas::thread_count(threads)
    );
    Ok(())
}
