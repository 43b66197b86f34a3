//! Figures 7 to 13 of Mehrotra, Puri and Khakhar (doi:10.1103/PhysRevE.83.061306): an isothermal
//! column, T = 20, in a field that increases with height, a = exp(αx), for α = 0.0025, 0.02, 0.05
//! and 0.1; 40 spheres per area of the base, box 400 high. At α = 0.1 it freezes; the crystal is
//! grown from the fluid.
//!
//! The moves of the paper need 10⁵ sweeps and more to relax a column. Here they are used for
//! figures 7 and 12, which show their relaxation and mobility. Everything else is measured in the
//! steady state, which tuned moves and event chains reach in some hundred sweeps from the same
//! random start. `--paper` uses the moves of the paper for everything.

#[macro_use]
extern crate paper;

mod column;
mod correlations;
mod crystal;
mod density;
mod equation;
mod front;
mod growth;
mod lattice;
mod layers;
mod mobility;
mod positions;
mod protocol;
mod relaxation;
mod results;

use column::{Column, Run};
use crystal::Crystal;
use gradient_mc::moves::Moves;
use paper::progress::in_words;
use paper::{Ending, Failure, Report, Session, Watch, study, warnings};
use protocol::{Arguments, Base, Part, Protocol};
use results::{Fluid, Results};
use std::process::ExitCode;
use std::time::Instant;

fn main() -> ExitCode {
    study::main("isothermal_varying_field", run)
}

/// A task for one thread.
#[derive(Debug, Clone, Copy)]
enum Task {
    Crystal(Base, u64),
    Relaxation(Column, u64),
    SteadyState(Column, u64),
}

/// The result of a task.
enum Outcome {
    Crystal(Box<Crystal>),
    Relaxation(f64, Run),
    SteadyState(f64, Run),
}

/// All tasks.
fn tasks(protocol: &Protocol, part: Part) -> Vec<Task> {
    let mut tasks = Vec::new();
    for (base, index) in protocol.crystal_bases.iter().filter(|_| part.crystals()).zip(0..) {
        for crystal in 0..protocol.crystals {
            tasks.push(Task::Crystal(*base, protocol.seed(1000 * (index + 1) + crystal)));
        }
    }
    if !part.fluids() {
        return tasks;
    }
    for (rate, index) in Protocol::FLUID_RATES.into_iter().zip(0..) {
        let column = |base| Column { rate, base };
        tasks.push(Task::Relaxation(column(protocol.relaxation_base), protocol.seed(100 * index)));
        if !protocol.paper {
            for replica in 0..protocol.replicas {
                tasks
                    .push(Task::SteadyState(column(protocol.base), protocol.seed(100 * index + 1 + replica)));
            }
        }
    }
    tasks
}

fn perform(task: Task, protocol: &Protocol, watch: &Watch<'_>) -> Result<Outcome, Failure> {
    match task {
        Task::Crystal(base, seed) => {
            Ok(Outcome::Crystal(Box::new(crystal::grow(base, protocol, seed, watch)?)))
        }
        Task::Relaxation(column, seed) => {
            let stage = protocol.relaxation(column.rate)?;
            Ok(Outcome::Relaxation(column.rate, column.settle(&stage, seed, watch)?))
        }
        Task::SteadyState(column, seed) => {
            let stage = protocol.steady_state(column.rate);
            Ok(Outcome::SteadyState(column.rate, column.settle(&stage, seed, watch)?))
        }
    }
}

/// Units of progress of a task, in sweeps.
fn size(task: Task, protocol: &Protocol) -> Result<u64, Failure> {
    Ok(match task {
        Task::Crystal(..) => crystal::sweeps(protocol),
        Task::Relaxation(column, _) => protocol.relaxation(column.rate)?.sweeps(),
        Task::SteadyState(column, _) => protocol.steady_state(column.rate).sweeps(),
    })
}

fn run(arguments: &Arguments, session: &Session) -> Result<Ending, Failure> {
    let protocol = Protocol::new(arguments, session)?;
    announce(&protocol, arguments, session.seed);

    let started = Instant::now();
    let tasks: Vec<(Task, u64)> = tasks(&protocol, arguments.part)
        .into_iter()
        .map(|task| Ok((task, size(task, &protocol)?)))
        .collect::<Result<_, Failure>>()?;
    let done = session.run_all(
        "columns and crystals",
        tasks,
        |(task, _)| format!("{task:?}"),
        |&(_, size)| size,
        |(task, _), watch| perform(task, &protocol, watch),
    )?;
    let results = collect(done, &protocol)?;
    let mut report = Report::new(session);
    if arguments.part.fluids() {
        relaxation::draw(&results, &mut report)?;
        relaxation::judge(&results, &mut report.verdicts);
        density::draw(&results, &mut report)?;
        density::judge(&results, &mut report.verdicts)?;
    }
    if arguments.part.crystals() {
        layers::draw(&results, &mut report)?;
        layers::judge(&results, &mut report.verdicts)?;
        positions::draw(&results, &mut report)?;
        positions::judge(&results, &mut report.verdicts)?;
        correlations::draw(&results, &mut report)?;
        correlations::judge(&results, &mut report.verdicts)?;
    }
    mobility::draw(&results, &mut report)?;
    mobility::judge(&results, &mut report.verdicts)?;
    equation::draw(&results, &mut report)?;
    equation::judge(&results, &mut report.verdicts)?;
    if arguments.part.crystals() {
        growth::draw(&results, &mut report)?;
        growth::judge(&results, &mut report.verdicts)?;
        println!("\n{}", growth::table(&results)?);
    }
    for fluid in &results.fluids {
        println!("{}: {}", fluid.label(), describe(fluid));
    }
    for fluid in results.fluids.iter().filter(|_| !results.paper) {
        println!("{}, measurement:", fluid.label());
        warnings::print(fluid.runs.iter().map(|run| &run.warnings[..]));
    }
    if !results.crystals.is_empty() {
        println!("crystals:");
        warnings::print(results.crystals.iter().map(|crystal| &crystal.warnings[..]));
    }
    println!("{}; CPU time {:.0} s", in_words(started.elapsed()), busy(&results));
    report.finish()
}

/// Prints all parameters of the runs.
fn announce(protocol: &Protocol, arguments: &Arguments, seed: u64) {
    println!(
        "T = {}, a = exp(αx), N/A = {}, box {} high, seed {}",
        Protocol::TEMPERATURE,
        Protocol::COLUMN_DENSITY,
        Protocol::HEIGHT,
        seed
    );
    if arguments.part.fluids() {
        let (relaxation, base) = (protocol.relaxation_base, protocol.base);
        println!(
            "fluid, α = {:?}: relaxation by local moves, S = 0.75, base {relaxation} ({} spheres), {} sweeps",
            Protocol::FLUID_RATES,
            relaxation.particles(),
            if protocol.paper {
                "500000 + 5 x 100000".to_owned()
            } else {
                protocol.relaxation_sweeps.to_string()
            },
        );
        if !protocol.paper {
            for rate in Protocol::FLUID_RATES {
                let stage = protocol.steady_state(rate);
                println!(
                    "  steady state, α = {rate}: {}, base {base} ({} spheres), {} replicas of {} + {} sweeps",
                    match stage.moves {
                        Moves::EventChains(_) => "event chains with tuned local moves",
                        _ => "tuned local moves",
                    },
                    base.particles(),
                    protocol.replicas,
                    stage.equilibration,
                    stage.sweeps() - stage.equilibration
                );
            }
        }
    }
    if !arguments.part.crystals() {
        return;
    }
    let bases: Vec<String> =
        protocol.crystal_bases.iter().map(|base| format!("{base} ({} spheres)", base.particles())).collect();
    println!(
        "crystal, α = {}: base {}, {} each, {}, {} sweeps; starts at random, n = 0.1",
        Protocol::CRYSTAL_RATE,
        bases.join(", "),
        protocol.crystals,
        protocol.growth.describe(),
        protocol.growth_sweeps
    );
}

/// Height of the center of mass in the steady state, and when it is reached.
fn describe(fluid: &Fluid) -> String {
    let beginnings = fluid.beginnings.iter().map(|beginning| {
        beginning.map_or("(unknown: all sweeps are used)".to_owned(), |sweep| sweep.to_string())
    });
    format!(
        "h_c = {} in the steady state, hydrostatics {:.3}; steady from sweep {} of production on; {:.1} s for the relaxation by the moves of the paper, {:.1} s for production",
        fluid.plateau,
        fluid.theory.center_of_mass(),
        beginnings.collect::<Vec<String>>().join(", "),
        fluid.relaxation.busy,
        fluid.runs.iter().map(|run| run.busy).sum::<f64>()
    )
}

/// Collects the results of all tasks.
fn collect(outcomes: Vec<Outcome>, protocol: &Protocol) -> Result<Results, Failure> {
    let (mut crystals, mut relaxations, mut steady) = (Vec::new(), Vec::new(), Vec::new());
    for outcome in outcomes {
        match outcome {
            Outcome::Crystal(crystal) => crystals.push(*crystal),
            Outcome::Relaxation(rate, run) => relaxations.push((rate, run)),
            Outcome::SteadyState(rate, run) => steady.push((rate, run)),
        }
    }
    let mut fluids = Vec::new();
    for ((rate, relaxation), index) in relaxations.into_iter().zip(0..) {
        #[allow(clippy::float_cmp, reason = "the same constant")]
        let mut runs: Vec<Run> =
            steady.iter().filter(|(other, _)| *other == rate).map(|(_, run)| run.clone()).collect();
        if protocol.paper {
            runs.push(relaxation.clone());
        }
        let column = Column { rate, base: protocol.base };
        let equilibration = if protocol.paper { 500_000 } else { protocol.steady_state(rate).equilibration };
        fluids.push(Fluid::new(column, relaxation, runs, equilibration, protocol.seed(900 + index))?);
    }
    Ok(Results { fluids, crystals, paper: protocol.paper })
}

/// CPU time of all runs.
fn busy(results: &Results) -> f64 {
    let crystals = results.crystals.iter().map(|crystal| crystal.busy);
    let relaxations = results.fluids.iter().map(|fluid| fluid.relaxation.busy);
    let steady = results.fluids.iter().flat_map(|fluid| &fluid.runs).map(|run| run.busy);
    let steady: f64 = if results.paper { 0.0 } else { steady.sum() };
    crystals.sum::<f64>() + relaxations.sum::<f64>() + steady
}
