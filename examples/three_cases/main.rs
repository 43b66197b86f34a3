//! The three systems of Mehrotra, Puri and Khakhar (doi:10.1103/PhysRevE.83.061306), with the
//! parameters of the paper:
//!
//! | case | field | temperature |
//! |---|---|---|
//! | (a) | a = 1 | T = 15 |
//! | (b) | a = exp(0.02 x) | T = 20 |
//! | (c) | a = 1 | T = 20 exp(−0.02 x) |
//!
//! Each has 40 spheres per area of the base (in d²) in a box 400 d high. One run of each gives the
//! equation of state from the density at the base to the dilute top; it is compared with
//! Carnahan-Starling and with the modified Kolafa-Labík-Malijevský equation. Every case writes a
//! CSV file, a PNG and an SVG.

// The summary is built only once, so the clearer call is used.
#![allow(clippy::format_push_string)]

#[macro_use]
extern crate paper;

mod case;
mod measurement;
mod picture;
mod protocol;
mod report;
mod summary;

use case::Case;
use gradient_mc::observers::MAXIMUM_BINS;
use gradient_mc::{Error, Slab};
use measurement::{Replica, Task};
use paper::progress::in_words;
use paper::watch::explained;
use paper::{Ending, Failure, Interrupted, Session, Watch, replicas, study};
use protocol::{Arguments, Protocol};
use report::Report;
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

fn main() -> ExitCode {
    study::main("three_cases", run)
}

/// Checks the arguments before anything starts, and names the options in its errors.
fn check(arguments: &Arguments) -> Result<(), Failure> {
    const FEWEST: f64 = Protocol::COLUMN_DENSITY * Slab::MINIMUM_WIDTH * Slab::MINIMUM_WIDTH;
    const MOST: f64 = Protocol::COLUMN_DENSITY * Slab::MAXIMUM_VOLUME / Protocol::HEIGHT;
    const MOST_SWEEPS: u64 = 1_000_000_000_000;
    const MOST_REPLICAS: u64 = 10_000;
    if let Some(particles) = arguments.particles
        && !(FEWEST..=MOST).contains(&(particles as f64))
    {
        return Err(format!("--particles {particles} is invalid: use {FEWEST} to {MOST}").into());
    }
    if let Some(width) = arguments.bin_width {
        let (narrowest, widest) = (Protocol::HEIGHT / MAXIMUM_BINS as f64, Protocol::HEIGHT);
        if !(narrowest..=widest).contains(&width) {
            return Err(
                format!("--bin-width {width} is invalid: use {narrowest} to {widest} diameters").into()
            );
        }
    }
    for (name, sweeps, least) in
        [("--sweeps", arguments.sweeps, 1), ("--equilibration", arguments.equilibration, 0)]
    {
        if let Some(sweeps) = sweeps.filter(|sweeps| !(least..=MOST_SWEEPS).contains(sweeps)) {
            return Err(format!("{name} {sweeps} is invalid: use {least} to {MOST_SWEEPS}").into());
        }
    }
    if let Some(replicas) = arguments.replicas.filter(|replicas| !(1..=MOST_REPLICAS).contains(replicas)) {
        return Err(format!("--replicas {replicas} is invalid: use 1 to {MOST_REPLICAS}").into());
    }
    Ok(())
}

fn run(arguments: &Arguments, session: &Session) -> Result<Ending, Failure> {
    check(arguments)?;
    let protocol = Protocol::new(arguments, session)?;
    let goes_on = session.unfinished.goes_on();
    println!("{protocol}{}", if goes_on { "; continues an interrupted run" } else { "" });
    if arguments.paper && !goes_on {
        announce_duration(&protocol, session)?;
    }

    let started = Instant::now();
    let tasks: Vec<(Case, u64)> = Case::ALL
        .into_iter()
        .flat_map(|case| (0..protocol.replicas).map(move |replica| (case, replica)))
        .collect();
    let size = |_: &(Case, u64)| protocol.sweeps_per_replica();
    let measured = session.try_all("three cases", tasks, size, |(case, replica), watch| {
        case.simulate(Task { protocol: &protocol, seed: protocol.seed(case, replica), watch })
    })?;
    let elapsed = started.elapsed();

    let interrupted = session.interrupt.pressed();
    let mut measured = measured.into_iter();
    let (mut reports, mut failures) = (Vec::new(), Vec::new());
    for case in Case::ALL {
        let outcomes = measured.by_ref().take(usize::try_from(protocol.replicas)?);
        match replicas_of(outcomes.collect()) {
            Ok(replicas) if replicas.is_empty() => {
                println!("{}: interrupted before production", case.head());
            }
            Ok(replicas) => match write_case(case, &replicas, &protocol, &session.directory) {
                Ok(report) => reports.push(report),
                // An interrupted case must not prevent the tables of complete ones.
                Err(failure) if interrupted && is_too_short(&failure) => {
                    println!("{}: interrupted with too few data for a table", case.head());
                }
                Err(failure) => failures.push(format!("{}: {}", case.head(), explained(&*failure))),
            },
            Err(failure) => failures.push(format!("{}, {failure}", case.head())),
        }
    }
    if !reports.is_empty() {
        println!("\n{}", summary::table(&reports));
        println!("{}", summary::remarks(&protocol, &reports, session.threads, elapsed));
        println!("written to {}", session.directory.display());
    }
    if !failures.is_empty() {
        return Err(failures.join("\n").into());
    }
    Ok(if interrupted { Ending::Interrupted } else { Ending::Finished })
}

/// The replicas of a case that have data; an error if one has failed.
fn replicas_of(outcomes: Vec<Result<Replica, Failure>>) -> Result<Vec<Replica>, Failure> {
    let mut replicas = Vec::new();
    for (number, outcome) in outcomes.into_iter().enumerate() {
        match outcome {
            Ok(replica) if replica.measured > 0 => replicas.push(replica),
            Ok(_) => {}
            Err(failure) if failure.is::<Interrupted>() => {}
            Err(failure) => return Err(format!("replica {number}: {}", explained(&*failure)).into()),
        }
    }
    Ok(replicas)
}

/// Whether the failure is only a lack of data.
fn is_too_short(failure: &Failure) -> bool {
    matches!(failure.downcast_ref(), Some(Error::TooFewObservations { .. }))
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
    report.write_csv(&path)?;
    picture::draw(&report, &path)?;
    Ok(report)
}

/// Prints the estimated duration of the protocol on this machine, from a few sweeps of each case.
fn announce_duration(protocol: &Protocol, session: &Session) -> Result<(), Failure> {
    let trial = &protocol.trial();
    let size = |_: &Case| trial.sweeps_per_replica();
    let simulate = |case: Case, watch: &Watch<'_>| {
        let replica = case.simulate(Task { protocol: trial, seed: 0, watch })?;
        Ok(replica.busy.as_secs_f64() / trial.sweeps_per_replica() as f64)
    };
    let alone = session.on_threads(1);
    let speeds = alone.run_all("estimate", Case::ALL.to_vec(), |case| case.head(), size, simulate)?;
    let threads = session.threads;
    let sweeps = protocol.sweeps_per_replica() as f64;
    let mut free_at = vec![0.0; replicas::thread_count(threads)];
    for seconds in speeds.iter().flat_map(|seconds| (0..protocol.replicas).map(move |_| seconds * sweeps)) {
        // Each replica runs on the thread that is free first.
        free_at.sort_by(f64::total_cmp);
        free_at[0] += seconds;
    }
    let total = Duration::from_secs_f64(free_at.into_iter().fold(0.0, f64::max));
    println!(
        "estimated duration: {} on {} threads; stop with Ctrl-C, continue with the same command",
        in_words(total),
        replicas::thread_count(threads)
    );
    Ok(())
}
