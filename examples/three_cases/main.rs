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
use paper::interrupt::Interrupt;
use paper::output::{self, create_directory};
use paper::progress::{Progress, in_words};
use paper::{Ending, Failure, Session, replicas, study};
use protocol::{Arguments, Protocol};
use report::Report;
use std::io::ErrorKind;
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

fn main() -> ExitCode {
    study::main("three_cases", run)
}

/// Refuses what cannot be simulated before anything starts, in the words of the command line.
fn check(arguments: &Arguments) -> Result<(), Failure> {
    const FEWEST: f64 = Protocol::COLUMN_DENSITY * Slab::MINIMUM_WIDTH * Slab::MINIMUM_WIDTH;
    const MOST: f64 = Protocol::COLUMN_DENSITY * Slab::MAXIMUM_VOLUME / Protocol::HEIGHT;
    const MOST_SWEEPS: u64 = 1_000_000_000_000;
    const MOST_REPLICAS: u64 = 10_000;
    if let Some(particles) = arguments.particles
        && !(FEWEST..=MOST).contains(&(particles as f64))
    {
        return Err(format!("--particles {particles}: take {FEWEST} to {MOST}").into());
    }
    if let Some(width) = arguments.bin_width {
        let (narrowest, widest) = (Protocol::HEIGHT / MAXIMUM_BINS as f64, Protocol::HEIGHT);
        if !(narrowest..=widest).contains(&width) {
            return Err(format!("--bin-width {width}: take {narrowest} to {widest} diameters").into());
        }
    }
    for (name, sweeps, least) in
        [("--sweeps", arguments.sweeps, 1), ("--equilibration", arguments.equilibration, 0)]
    {
        if let Some(sweeps) = sweeps.filter(|sweeps| !(least..=MOST_SWEEPS).contains(sweeps)) {
            return Err(format!("{name} {sweeps}: take {least} to {MOST_SWEEPS}").into());
        }
    }
    if let Some(replicas) = arguments.replicas.filter(|replicas| !(1..=MOST_REPLICAS).contains(replicas)) {
        return Err(format!("--replicas {replicas}: take 1 to {MOST_REPLICAS}").into());
    }
    Ok(())
}

/// What a run that is stopped leaves in its directory, to go on from.
const UNFINISHED: &str = "unfinished";

fn run(arguments: &Arguments, session: &Session) -> Result<Ending, Failure> {
    check(arguments)?;
    let protocol = Protocol::new(arguments, session)?;
    let (directory, interrupt) = (&session.directory, &session.interrupt);
    let unfinished = &directory.join(UNFINISHED);
    if arguments.fresh {
        remove(unfinished)?;
    }
    let goes_on = unfinished.is_dir();
    println!("{protocol}{}", if goes_on { "; goes on where it was stopped" } else { "" });
    keep_options(&protocol, unfinished)?;
    if arguments.paper && !goes_on {
        announce_duration(&protocol, session.threads, interrupt, unfinished)?;
    }

    let started = Instant::now();
    let tasks: Vec<(Case, u64)> = Case::ALL
        .into_iter()
        .flat_map(|case| (0..protocol.replicas).map(move |replica| (case, replica)))
        .collect();
    let progress = &Progress::new(tasks.len() as u64 * protocol.sweeps_per_replica(), "three cases");
    let measured = replicas::in_parallel(session.threads, tasks, |(case, replica)| {
        let checkpoint = &unfinished.join(format!("{}_{replica}", case.name()));
        let (protocol, seed) = (&protocol, protocol.seed(case, replica));
        // An error in one case must not cost the others.
        let outcome = case.simulate(Task { protocol, seed, checkpoint, interrupt, progress });
        Ok(outcome.map_err(|failure| explained(&failure, case, replica)))
    })?;
    progress.finish();
    let elapsed = started.elapsed();

    let mut measured = measured.into_iter();
    let mut reports = Vec::new();
    let mut failures = Vec::new();
    for case in Case::ALL {
        let replicas = measured.by_ref().take(usize::try_from(protocol.replicas)?);
        let replicas = match replicas.collect::<Vec<_>>().into_iter().collect::<Result<Vec<_>, _>>() {
            Ok(replicas) => replicas,
            Err(failure) => {
                failures.push(failure);
                continue;
            }
        };
        // An interrupt may come before anything was measured, or before it is enough for an error bar; that
        // must not cost the cases that are complete.
        let any = replicas.iter().any(|replica| replica.measured > 0);
        let outcome = if any {
            write_case(case, &replicas, &protocol, directory)
        } else {
            Err("nothing was measured".into())
        };
        match outcome {
            Ok(report) => reports.push(report),
            Err(failure) if interrupt.pressed() && (!any || is_too_short(&failure)) => {
                println!("{}: interrupted before enough was measured for a table", case.head());
            }
            Err(failure) => failures.push(format!("{}: {failure}", case.head())),
        }
    }
    if !reports.is_empty() {
        println!("\n{}", summary::table(&reports));
        println!("{}", summary::remarks(&protocol, &reports, session.threads, elapsed));
        println!("written to {}", directory.display());
    }
    if !failures.is_empty() {
        return Err(failures.join("\n").into());
    }
    if interrupt.pressed() {
        println!("the same command goes on from {}", unfinished.display());
        return Ok(Ending::Interrupted);
    }
    remove(unfinished)?;
    Ok(Ending::Finished)
}

/// Notes in the directory of what is unfinished what is simulated, or sees that it is the same as was.
fn keep_options(protocol: &Protocol, unfinished: &Path) -> Result<(), Failure> {
    create_directory(unfinished)?;
    let (path, options) = (unfinished.join("options"), format!("{protocol:#?}\n"));
    match std::fs::read_to_string(&path) {
        Ok(text) if text == options => Ok(()),
        Ok(_) => {
            let path = path.display();
            Err(format!("{path} is of a run with other options: take these, another --out, or --fresh")
                .into())
        }
        Err(_) => output::write(&path, options),
    }
}

/// What went wrong in a replica, with its causes.
fn explained(failure: &Failure, case: Case, replica: u64) -> String {
    let mut text = format!("{}, replica {replica}: {failure}", case.head());
    let mut cause = failure.source();
    while let Some(error) = cause {
        text.push_str(&format!(", because: {error}"));
        cause = error.source();
    }
    text
}

/// Removes a directory, if it is there.
fn remove(directory: &Path) -> Result<(), Failure> {
    match std::fs::remove_dir_all(directory) {
        Err(error) if error.kind() != ErrorKind::NotFound => {
            Err(format!("cannot remove {}: {error}", directory.display()).into())
        }
        _ => Ok(()),
    }
}

/// Whether all that is wrong is that too little was measured.
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

/// Says how long the protocol takes on this machine, from a few sweeps of each case.
fn announce_duration(
    protocol: &Protocol,
    threads: usize,
    interrupt: &Interrupt,
    directory: &Path,
) -> Result<(), Failure> {
    let trial = &protocol.trial();
    let checkpoint = &directory.join("trial");
    let progress = &Progress::hidden();
    let speeds = Case::ALL
        .into_iter()
        .map(|case| {
            let task = Task { protocol: trial, seed: 0, checkpoint, interrupt, progress };
            let replica = case.simulate(task)?;
            for path in [checkpoint.clone(), checkpoint.with_extension("previous")] {
                std::fs::remove_file(path).ok();
            }
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
        "estimate: {} on {} threads; Ctrl-C stops, and the same command goes on",
        in_words(total),
        replicas::thread_count(threads)
    );
    Ok(())
}
