//! CPU time until the error of `h_c`, n(x) and P(x) falls below half a per cent: `cargo bench
//! --bench time_to_accuracy`.
//!
//! The paper's column (T = 20, N/A = 40, 400 high) on a narrower base, with all moves and from both
//! starts. The error is the true one, relative to a long reference run by event chains: the root
//! mean square over independent replicas, for averages over the second half of the run so far. So
//! it contains the remaining influence of the start. Times are CPU seconds of the thread. Quote
//! ratios within one run, since absolute times drift on a shared machine.
//!
//! With `-- --wall`, wall time: two replicas on two threads, whose profiles are averaged, compared
//! with the paper's algorithm on one core. With `--patience 2000` or more every method runs until
//! it reaches the target, and nothing is extrapolated.

#![allow(clippy::print_stdout)]

mod chart;
mod column;
mod methods;
mod wall;

use clap::Parser;
use column::{Errors, Profile};
use methods::{Engine, Method};
use paper::Failure;
use paper::table::Table;
use rayon::prelude::*;
use std::path::PathBuf;

#[derive(Parser, Debug)]
struct Arguments {
    /// Side of the square base, in diameters; the paper's is 25
    #[arg(long, default_value_t = 5.0)]
    width: f64,
    /// Independent replicas of every method
    #[arg(long, default_value_t = 4)]
    replicas: u64,
    /// Relative error to be reached
    #[arg(long, default_value_t = 0.005)]
    target: f64,
    /// CPU seconds of the longest run; with `--wall`, seconds of wall time. A method stops as soon
    /// as it reaches the target
    #[arg(long, default_value_t = 40.0)]
    patience: f64,
    /// Measure the wall time to the target in P(x): two replicas on two threads, compared with one
    /// of the paper's algorithm; needs an idle machine
    #[arg(long)]
    wall: bool,
    /// Directory for the table and the picture
    #[arg(long, default_value = "out/time_to_accuracy")]
    out: PathBuf,
    /// What cargo adds
    #[arg(long, hide = true)]
    bench: bool,
}

/// Errors of a method when its replicas had used this much CPU time each.
#[derive(Debug, Clone, Copy)]
struct Checkpoint {
    seconds: f64,
    sweeps: u64,
    errors: Errors,
}

fn main() -> Result<(), Failure> {
    let arguments = Arguments::parse();
    paper::output::create_directory(&arguments.out)?;
    let particles = column::particles(arguments.width);
    println!("{particles} spheres over {0} x {0}, T = {1}", arguments.width, column::TEMPERATURE);
    let reference = reference(&arguments)?;
    println!(
        "reference: h_c = {:.4}, of event chains; density functional theory of the same column, on an infinite base: 49.394",
        reference.center_of_mass
    );
    if arguments.wall {
        return wall::compare(&arguments, &reference);
    }
    let mut runs = Vec::new();
    for method in Method::ALL {
        let checkpoints = measure(method, &arguments, &reference)?;
        if let Some(last) = checkpoints.last() {
            println!(
                "{:<44} {} sweeps, {:.1} CPU s each: {}",
                method.label(),
                last.sweeps,
                last.seconds,
                last.errors
            );
        }
        runs.push((method, checkpoints));
    }
    println!("\n{}", table(&runs, arguments.target));
    println!(
        "≥: not reached; extrapolated by 1/√time where the error at the end was below {} %.",
        100.0 * NEAR * arguments.target
    );
    chart::draw(&runs, arguments.target, &arguments.out.join("time_to_accuracy"))?;
    println!("written to {}", arguments.out.display());
    Ok(())
}

/// A profile with an error far below what is to be measured.
fn reference(arguments: &Arguments) -> Result<Profile, Failure> {
    const REPLICAS: u64 = 4;
    let relaxation = 4_000;
    let profiles: Vec<Profile> = (0..REPLICAS)
        .into_par_iter()
        .map(|replica| {
            let mut engine = Method::ChainsFromTheory.engine(arguments.width, 1_000 + replica)?;
            engine.sweep(relaxation)?;
            column::observe(&mut *engine, arguments.width, 50 * relaxation)
        })
        .collect::<Result<_, Failure>>()?;
    Ok(Profile::mean(&profiles))
}

/// Follows the replicas of a method, in stretches that double their length, until all errors are
/// below the target.
fn measure(method: Method, arguments: &Arguments, reference: &Profile) -> Result<Vec<Checkpoint>, Failure> {
    let mut replicas: Vec<(Box<dyn Engine>, f64)> = (0..arguments.replicas)
        .map(|seed| Ok((method.engine(arguments.width, seed)?, 0.0)))
        .collect::<Result<_, Failure>>()?;
    let mut checkpoints: Vec<Checkpoint> = Vec::new();
    let mut sweeps = 0;
    let mut stretch = 64;
    loop {
        let profiles: Vec<Profile> = replicas
            .par_iter_mut()
            .with_max_len(1)
            .map(|(engine, seconds)| {
                let start = paper::clock::cpu_seconds();
                let profile = column::observe(&mut **engine, arguments.width, stretch)?;
                *seconds += paper::clock::cpu_seconds() - start;
                Ok(profile)
            })
            .collect::<Result<_, Failure>>()?;
        sweeps += stretch;
        stretch = sweeps;
        let seconds = replicas.iter().map(|(_, seconds)| seconds).sum::<f64>() / replicas.len() as f64;
        let errors = Errors::of(&profiles, reference);
        checkpoints.push(Checkpoint { seconds, sweeps, errors });
        if errors.largest() < arguments.target || seconds > arguments.patience {
            return Ok(checkpoints);
        }
    }
}

/// CPU seconds at which an error falls below the target for good: between checkpoints by a power
/// law. Beyond the last, at least those of the last; where the error has come near the target, it is
/// extrapolated by 1/√time. That is too early for a column that has not yet relaxed; far from the
/// target the column may still be falling, which is faster.
#[derive(Debug, Clone, Copy)]
struct Crossing {
    seconds: f64,
    extrapolated: bool,
}

/// Errors of so many times the target are near it.
const NEAR: f64 = 10.0;

fn crossing(checkpoints: &[Checkpoint], target: f64, error: impl Fn(&Errors) -> f64) -> Option<Crossing> {
    let last_above = checkpoints.iter().rposition(|checkpoint| error(&checkpoint.errors) >= target);
    let found = |seconds| Some(Crossing { seconds, extrapolated: false });
    let Some(above) = last_above else { return found(checkpoints.first()?.seconds) };
    let before = checkpoints.get(above)?;
    let Some(after) = checkpoints.get(above + 1) else {
        let ratio = error(&before.errors) / target;
        let factor = if ratio < NEAR { ratio * ratio } else { 1.0 };
        return Some(Crossing { seconds: before.seconds * factor, extrapolated: true });
    };
    let (high, low) = (error(&before.errors), error(&after.errors));
    let part = libm::log(high / target) / libm::log(high / low);
    found(before.seconds * libm::pow(after.seconds / before.seconds, part))
}

/// One of the errors.
type Quantity = fn(&Errors) -> f64;

fn table(runs: &[(Method, Vec<Checkpoint>)], target: f64) -> Table {
    let quantities: [(&str, Quantity); 3] = [
        ("h_c", |errors| errors.center_of_mass),
        ("n(x)", |errors| errors.density),
        ("P(x)", |errors| errors.pressure),
    ];
    let mut head = vec![format!("CPU seconds to {} %", 100.0 * target)];
    for (name, _) in quantities {
        head.extend([name.to_owned(), "gain".to_owned()]);
    }
    let mut table = Table::new(head);
    let baseline = runs.iter().find(|(method, _)| *method == Method::Plain);
    for (method, checkpoints) in runs {
        let mut cells = Vec::new();
        for (_, error) in quantities {
            let own = crossing(checkpoints, target, error);
            let other = baseline.and_then(|(_, checkpoints)| crossing(checkpoints, target, error));
            let about = |extrapolated: bool| if extrapolated { "≥ " } else { "" };
            cells
                .push(own.map_or("?".into(), |own| format!("{}{:.2}", about(own.extrapolated), own.seconds)));
            // Of two that were not reached nothing is known.
            let compared = own.zip(other).filter(|(own, _)| !own.extrapolated);
            cells.push(compared.map_or("-".into(), |(own, other)| {
                format!("{}{:.1}", about(other.extrapolated), other.seconds / own.seconds)
            }));
        }
        table.row(method.label(), cells);
    }
    table
}
