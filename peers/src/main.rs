//! Times hoomd-mc 1.4 against gradient-mc in one run: see README.md beside this package.

mod contest;
mod hoomd;
mod library;
mod state;

use clap::Parser;
use contest::{Clock, Engine, Outcome, contest};
use hoomd::{Displacements, Grid, Mode, Settings};
use library::Library;
use state::{STATES, State};

type Failure = Box<dyn std::error::Error + Send + Sync>;

/// Acceptances of the same trials in the same state may differ by this much, relatively.
const TOLERANCE: f64 = 0.02;

/// Times hoomd-mc 1.4 against gradient-mc, in turns, on three states.
#[derive(Parser, Debug)]
struct Arguments {
    /// Turns of each program
    #[arg(long, default_value_t = 9)]
    turns: usize,

    /// Seconds of a turn
    #[arg(long, default_value_t = 0.5)]
    seconds: f64,

    /// Three short turns after a short preparation, to test the program
    #[arg(long)]
    quick: bool,

    /// Only the states whose names begin with this (dense, dilute, column)
    #[arg(long, default_value = "")]
    state: String,

    /// Only hoomd-mc with other settings, to find its fastest
    #[arg(long)]
    tune: bool,
}

fn show(outcomes: &[Outcome], unit: &str) {
    for outcome in outcomes {
        println!(
            "  {:<36} {:>6.2} million trials per {unit}, acceptance {:.4}, {:.2} cores",
            outcome.label,
            outcome.rate(),
            outcome.acceptance(),
            outcome.cores(),
        );
    }
}

fn sequential(state: &State, positions: &[[f64; 3]], arguments: &Arguments) -> Result<(), Failure> {
    let peer = |displacements| hoomd::new(state, state.hoomd, displacements, Mode::Sequential, positions);
    let mut engines: Vec<Box<dyn Engine>> = vec![
        Box::new(Library::new(state, positions)?),
        peer(Displacements::Cube)?,
        peer(Displacements::Ball)?,
    ];
    let outcomes = contest(&mut engines, Clock::Cpu, arguments.turns, arguments.seconds)?;
    show(&outcomes, "CPU second");
    let [ours, cube, ball] = &outcomes[..] else { unreachable!("three engines have three outcomes") };
    println!("  gradient-mc / hoomd-mc: {:.2} (cube), {:.2} (ball)", ours.over(cube), ours.over(ball));
    let difference = ours.acceptance_inside() / cube.acceptance() - 1.0;
    println!("  acceptances of the same trials (cube), without those that leave a domain, differ by {:+.2} %", 100.0 * difference);
    if difference.abs() > TOLERANCE {
        return Err(format!("{}: the programs do not simulate the same system", state.name).into());
    }
    Ok(())
}

fn threads(state: &State, positions: &[[f64; 3]], arguments: &Arguments) -> Result<(), Failure> {
    let peer = |mode| hoomd::new(state, state.hoomd, Displacements::Cube, mode, positions);
    let mut engines: Vec<Box<dyn Engine>> = vec![
        Box::new(Library::new(state, positions)?),
        peer(Mode::Sequential)?,
        peer(Mode::Parallel(1))?,
        peer(Mode::Parallel(2))?,
        // PLACE FOR gradient-mc ON TWO THREADS: one more engine of `library`, last, and a ratio below.
    ];
    let outcomes = contest(&mut engines, Clock::Wall, arguments.turns, arguments.seconds)?;
    show(&outcomes, "second of wall clock");
    let [ours, sequential, one, two, ..] = &outcomes[..] else { unreachable!("four engines") };
    println!(
        "  hoomd-mc on two threads / on one: {:.2}; / its Sweep: {:.2}",
        two.over(one),
        two.over(sequential)
    );
    println!("  gradient-mc on one thread / hoomd-mc on two: {:.2}", ours.over(two));
    if two.cores() < 1.2 {
        println!(
            "  NOT A MEASUREMENT of two threads: they had {:.2} cores; repeat on an idle machine",
            two.cores()
        );
    }
    let proposals = hoomd::proposals_per_trial(state, state.hoomd, positions, 20)?;
    println!("  ParallelSweep proposes {proposals:.3} moves for each that it counts");
    Ok(())
}

/// Which settings are the fastest for hoomd-mc; the column takes some 5 GB.
fn tune(state: &State, positions: &[[f64; 3]], arguments: &Arguments) -> Result<(), Failure> {
    let contest = |mode, clock, candidates: Vec<Settings>| -> Result<(), Failure> {
        let mut engines = Vec::new();
        for &settings in &candidates {
            engines.push(hoomd::new(state, settings, Displacements::Cube, mode, positions)?);
        }
        let outcomes = contest(&mut engines, clock, arguments.turns, arguments.seconds)?;
        for (outcome, settings) in outcomes.iter().zip(&candidates) {
            let chosen = if *settings == state.hoomd { "  <- chosen" } else { "" };
            println!("  {:<36} {:>6.3}  {settings:?}{chosen}", outcome.label, outcome.rate());
        }
        Ok(())
    };
    let with_cells = [Grid::Dense, Grid::Hashed].into_iter().flat_map(|grid| {
        [1.0, 1.6, 2.0, 2.5, 3.2].map(|cell_width| Settings { grid, cell_width, ..state.hoomd })
    });
    contest(Mode::Sequential, Clock::Cpu, with_cells.collect())?;
    let with_checkerboards = [1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0]
        .map(|checkerboard_width| Settings { checkerboard_width, ..state.hoomd });
    contest(Mode::Parallel(2), Clock::Wall, with_checkerboards.into())
}

fn main() -> Result<(), Failure> {
    let mut arguments = Arguments::parse();
    let mut preparation = 1000;
    if arguments.quick {
        (arguments.turns, arguments.seconds, preparation) = (3, 0.1, 500);
    }
    for state in STATES.iter().filter(|state| state.name.starts_with(&arguments.state)) {
        println!("{}", state.name);
        let positions = library::prepare(state, preparation)?;
        if arguments.tune {
            tune(state, &positions, &arguments)?;
        } else {
            sequential(state, &positions, &arguments)?;
            threads(state, &positions, &arguments)?;
        }
    }
    Ok(())
}
