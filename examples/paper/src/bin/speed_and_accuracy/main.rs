//! Speed against accuracy: CPU time and true error of all methods for n(x) and P(x) of the three
//! systems of Mehrotra, Puri and Khakhar (doi:10.1103/PhysRevE.83.061306), from the formula of the
//! ideal gas to event chains on the full base; and of the equation of state from one run in a
//! gradient, compared with homogeneous runs.
//!
//! | quantity | error |
//! |---|---|
//! | n(x) | the total variation distance ½∫abs(n − n') dx/(N/A), n averaged over bins one diameter high |
//! | P(x) | the largest abs(P − P') over P' at the base, at the middles of these bins |
//!
//! The references n', P' are from long runs stored in `reference/`, with their errors. Times are
//! CPU seconds of the thread; other programs on the machine increase them only slightly. Two
//! threads are two replicas with the time of the slower one. Finished runs are kept; an interrupted
//! run starts again, so that its time is of one process. The length of a run depends on the time it
//! takes; its results depend only on the seed.
//!
//! A result whose true error is more than twice its own error estimate is over-confident, shown as
//! a ring in the charts. `--long` repeats the reference runs.

#[macro_use]
extern crate paper;

mod chart;
mod column;
mod contest;
mod gradient;
mod method;
mod pace;
mod point;
mod profile;
mod reference;
mod report;
mod series;
mod system;
mod theory;
mod verdict;

use chart::Data;
use contest::{Contest, Task};
use method::Method;
use paper::{Ending, Failure, Report, Session, study};
use point::Quantity;
use reference::Reference;
use series::Checkpoint;
use std::path::PathBuf;
use std::process::ExitCode;
use system::System;

/// Charts error against CPU time of every method, and compares the gradient with homogeneous runs.
#[derive(clap::Args, Debug)]
struct Arguments {
    /// First repeat the reference runs and store them with the program (five minutes more on two
    /// cores)
    #[arg(long)]
    long: bool,
    /// Only the reference runs; needs `--long`
    #[arg(long, requires = "long")]
    only_reference: bool,
    /// CPU seconds of the longest run on the small base; twice as many on the full base
    #[arg(long, default_value_t = 1.5)]
    patience: f64,
    /// Leave out the full base, for a quick overview
    #[arg(long)]
    small: bool,
    /// Replicas on the small base; half as many on the full base
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u64).range(2..=1000))]
    replicas: u64,
    /// Relative error of the equation of state for which times are printed
    #[arg(long, default_value_t = 0.005)]
    target: f64,
}

/// CPU seconds of the longest gradient run for the equation of state, and of the seventeen
/// homogeneous runs together.
const GRADIENT_PATIENCE: f64 = 4.0;

fn main() -> ExitCode {
    study::main("speed_and_accuracy", run)
}

fn run(arguments: &Arguments, session: &Session) -> Result<Ending, Failure> {
    if arguments.long {
        let stored = stored(session);
        reference::make(session, &stored)?;
        println!("references written to {}", stored.display());
        if arguments.only_reference {
            return Ok(Ending::Finished);
        }
    }
    let followed = simulate(arguments, session)?;
    let references = references(arguments, session)?;
    let mut refusals = Vec::new();
    let mut points = Vec::new();
    // Before other runs, because they would disturb times of microseconds.
    for (system, reference) in System::ALL.into_iter().zip(&references) {
        let mut own = theory::points(system, reference, &mut refusals)?;
        for (_, method, replicas) in followed.iter().filter(|(of, ..)| *of == system) {
            own.extend(series::points(*method, replicas, reference));
        }
        points.push(own);
    }
    let pace = pace::measure(session.seed)?;
    let contest = Contest::run(session, session.choose(GRADIENT_PATIENCE, 0.2), &pace)?;
    let all: Vec<Data<'_>> = System::ALL
        .into_iter()
        .zip(&points)
        .zip(&references)
        .map(|((system, points), reference)| Data { system, points, reference })
        .collect();
    let mut report = Report::new(session);
    write(&all, &contest, arguments.target, &mut report)?;
    for refusal in &refusals {
        println!("no result: {}, {}: {}", refusal.name, refusal.system.title(), refusal.reason);
    }
    println!("{}", pace.table());
    conclude_from(&all, &contest, arguments.target, report)
}

/// Directory of new references: with the program, or in the output directory for short runs.
fn stored(session: &Session) -> PathBuf {
    if session.short { session.directory.join("reference") } else { reference::directory() }
}

fn references(arguments: &Arguments, session: &Session) -> Result<Vec<Reference>, Failure> {
    if arguments.long {
        let directory = stored(session);
        System::ALL.into_iter().map(|system| Reference::read(system, &directory)).collect()
    } else {
        System::ALL.into_iter().map(Reference::stored).collect()
    }
}

/// A method and the checkpoints of its replicas.
type Followed = (System, Method, Vec<Vec<Checkpoint>>);

/// Follows all simulations: checkpoints of every replica.
fn simulate(arguments: &Arguments, session: &Session) -> Result<Vec<Followed>, Failure> {
    let replicas = session.choose(arguments.replicas, 2);
    let replicas_of = |method: &Method| if method.is_full() { (replicas / 2).max(2) } else { replicas };
    let mut methods: Vec<(System, Method)> = System::ALL
        .into_iter()
        .flat_map(|system| Method::all(system).into_iter().map(move |method| (system, method)))
        .filter(|(_, method)| !((arguments.small || session.short) && method.is_full()))
        .collect();
    methods.sort_by_key(|(_, method)| !method.is_full());
    let tasks: Vec<series::Task> = methods
        .iter()
        .flat_map(|&(system, method)| {
            let patience =
                session.choose(arguments.patience, 0.02) * if method.is_full() { 2.0 } else { 1.0 };
            (0..replicas_of(&method)).map(move |replica| {
                let seed = session.seed(replica);
                series::Task { system, method, seed, patience }
            })
        })
        .collect();
    let followed = session.run_each("simulations", tasks, series::Task::name, |task| task.follow())?;
    let mut followed = followed.into_iter();
    let mut all = Vec::new();
    for (system, method) in methods {
        let own = followed.by_ref().take(usize::try_from(replicas_of(&method))?).collect();
        all.push((system, method, own));
    }
    Ok(all)
}

/// Tables of numbers and pictures.
fn write(all: &[Data<'_>], contest: &Contest, target: f64, report: &mut Report) -> Result<(), Failure> {
    report::write_points(all, report)?;
    report::write_contest(contest, report)?;
    for data in all {
        let name = data.system.name();
        report.picture(name, &chart::system(*data), "Errors of n(x) and P(x) against CPU time.")?;
        if data.system == System::VaryingTemperature {
            report.picture(
                "schemes",
                &chart::schemes(*data),
                "The same for every scheme of the effective field.",
            )?;
        }
    }
    let caption = "Estimated against true errors; rings: over-confident.";
    report.picture("claims", &chart::claims(all), caption)?;
    let caption = "The equation of state from one run in a gradient, compared with homogeneous runs.";
    report.picture("equation_of_state", &chart::contest(contest, target), caption)?;
    let caption = "The best methods for n(x) and for the equation of state.";
    report.picture("speed_and_accuracy", &chart::overview(all, contest, target), caption)
}

/// Tables and claims on the terminal.
fn conclude_from(
    all: &[Data<'_>],
    contest: &Contest,
    target: f64,
    mut report: Report,
) -> Result<Ending, Failure> {
    for data in all {
        println!("\n{}", report::system_table(data));
        for quantity in Quantity::BOTH {
            println!("{}", report::front_table(data, quantity));
        }
    }
    println!("{}", report::threads_table(all));
    for (column, spheres) in contest.columns() {
        println!("{}: {spheres} spheres", column.label());
    }
    println!("\n{}", report::deviations_table(contest));
    for target in [4.0 * target, 2.0 * target, target, 0.5 * target] {
        for tasks in [Task::DENSITIES, Task::CURVES] {
            println!("\n{}", report::contest_table(contest, &tasks, target, true));
        }
    }
    println!("\n{}", report::contest_table(contest, &Task::DENSITIES, target, false));
    println!("≈: not reached; extrapolated with an error proportional to 1/sqrt(time).");
    report.verdicts = verdict::judge(all, contest, target);
    report.finish()
}
