//! Figures 7 to 13 of Mehrotra, Puri and Khakhar (doi:10.1103/PhysRevE.83.061306): an isothermal column, T = 20, in a field
//! that grows with height, a = exp(αx), for α = 0.0025, 0.02, 0.05 and 0.1; 40 spheres per area of the base, box 400 high.
//! At α = 0.1 it freezes; the crystal is grown from the fluid.
//!
//! The paper's own moves need 10⁵ sweeps and more to come to rest. Here they are used where the paper shows what they do (figures
//! 7 and 12); everything else is measured in the steady state that tuned moves and event chains reach in some hundred sweeps, from the same
//! random start. `--paper` does all of it as the paper did.

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

use clap::Parser;
use column::{Column, Run};
use crystal::Crystal;
use gradient_mc::moves::Moves;
use paper::captions::write_captions;
use paper::interrupt::Interrupt;
use paper::progress::{Progress, in_words};
use paper::verdict::Verdicts;
use paper::{Ending, Failure, conclude, output, replicas, warnings};
use protocol::{Arguments, Base, Part, Protocol};
use results::{Fluid, Results};
use std::process::ExitCode;
use std::time::{Duration, Instant};

fn main() -> ExitCode {
    conclude(run(&Arguments::parse()))
}

/// Something for one thread.
#[derive(Debug, Clone, Copy)]
enum Task {
    Crystal(Base, u64),
    Relaxation(Column, u64),
    SteadyState(Column, u64),
}

/// What came of it.
enum Outcome {
    Crystal(Box<Crystal>),
    Relaxation(f64, Run),
    SteadyState(f64, Run),
}

/// All tasks, the longest first.
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

fn perform(
    task: Task,
    protocol: &Protocol,
    interrupt: &Interrupt,
    progress: &Progress,
) -> Result<Outcome, Failure> {
    match task {
        Task::Crystal(base, seed) => {
            Ok(Outcome::Crystal(Box::new(crystal::grow(base, protocol, seed, interrupt, progress)?)))
        }
        Task::Relaxation(column, seed) => {
            let stage = protocol.relaxation(column.rate)?;
            Ok(Outcome::Relaxation(column.rate, column.settle(&stage, seed, interrupt, progress)?))
        }
        Task::SteadyState(column, seed) => {
            let stage = Protocol::steady_state(column.rate);
            Ok(Outcome::SteadyState(column.rate, column.settle(&stage, seed, interrupt, progress)?))
        }
    }
}

/// Progress of a task when it is done: sweeps, which take longer or shorter.
fn size(task: Task, protocol: &Protocol) -> Result<u64, Failure> {
    Ok(match task {
        Task::Crystal(..) => crystal::sweeps(protocol),
        Task::Relaxation(column, _) => protocol.relaxation(column.rate)?.sweeps(),
        Task::SteadyState(column, _) => Protocol::steady_state(column.rate).sweeps(),
    })
}

fn run(arguments: &Arguments) -> Result<Ending, Failure> {
    let protocol = Protocol::new(arguments)?;
    let directory = arguments.shared.directory("isothermal_varying_field");
    output::create_directory(&directory)?;
    let interrupt = Interrupt::listen()?;
    announce(&protocol, arguments);

    let started = Instant::now();
    let tasks = tasks(&protocol, arguments.part);
    let total = tasks.iter().map(|&task| size(task, &protocol)).sum::<Result<u64, Failure>>()?;
    let progress = Progress::new(total, "columns and crystals");
    let done = replicas::in_parallel(arguments.shared.threads, tasks, |task| {
        perform(task, &protocol, &interrupt, &progress)
    });
    progress.finish();
    if interrupt.pressed() {
        println!("interrupted: figures need complete runs, nothing is written");
        return Ok(Ending::Interrupted);
    }
    let results = collect(done?, &protocol)?;
    let mut verdicts = Verdicts::new();
    if arguments.part.fluids() {
        relaxation::draw(&results, &directory)?;
        relaxation::judge(&results, &mut verdicts);
        density::draw(&results, &directory)?;
        density::judge(&results, &mut verdicts)?;
    }
    if arguments.part.crystals() {
        layers::draw(&results, &directory)?;
        layers::judge(&results, &mut verdicts)?;
        positions::draw(&results, &directory)?;
        positions::judge(&results, &mut verdicts)?;
        correlations::draw(&results, &directory)?;
        correlations::judge(&results, &mut verdicts)?;
    }
    mobility::draw(&results, &directory)?;
    mobility::judge(&results, &mut verdicts)?;
    equation::draw(&results, &directory)?;
    equation::judge(&results, &mut verdicts)?;
    if arguments.part.crystals() {
        growth::draw(&results, &directory)?;
        growth::judge(&results, &mut verdicts)?;
        println!("\n{}", growth::table(&results)?);
    }
    verdicts.write_csv(&directory)?;
    write_captions(&directory, captions(arguments.part))?;
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
    println!("\n{verdicts}");
    println!(
        "{}; processor time {:.0} s; written to {}",
        in_words(started.elapsed()),
        busy(&results).as_secs_f64(),
        directory.display()
    );
    Ok(verdicts.ending())
}

/// What the pictures show.
fn captions(part: Part) -> Vec<(&'static str, String)> {
    let fluids = [
        (
            "figure_07.png",
            "Figure 7: the center of mass falls from the uniform start, by the paper's moves and by ours; inset: where it comes to rest, \
             against α, with hydrostatics between walls",
        ),
        (
            "figure_08.png",
            "Figure 8: density over height with theory, and on a logarithmic scale with the ideal gas",
        ),
    ];
    let crystals = [
        (
            "figure_09.png",
            "Figure 9: density over height at α = 0.1: layers of a crystal grown from the fluid",
        ),
        (
            "figure_10.png",
            "Figure 10: where spheres are at α = 0.1: a slice of the column, and the two lowest layers from above",
        ),
        (
            "figure_11.png",
            "Figure 11: lateral distribution of distances in the lowest layer, and of angles between neighbors",
        ),
        (
            "crystal.png",
            "The crystal at α = 0.1: its growth, and the shares of face-centered, hexagonal and fluid spheres over height",
        ),
    ];
    let both = [
        ("figure_12.png", "Figure 12: mean accepted displacement over height"),
        ("figure_13.png", "Figure 13: pressure over temperature against packing fraction"),
    ];
    let mut captions = Vec::new();
    captions.extend(fluids.into_iter().filter(|_| part.fluids()));
    captions.extend(crystals.into_iter().filter(|_| part.crystals()));
    captions.extend(both);
    captions.sort_unstable();
    captions.into_iter().map(|(file, caption)| (file, caption.to_owned())).collect()
}

/// Everything that the numbers depend on.
fn announce(protocol: &Protocol, arguments: &Arguments) {
    println!(
        "T = {}, a = exp(αx), N/A = {}, box {} high, seed {}",
        Protocol::TEMPERATURE,
        Protocol::COLUMN_DENSITY,
        Protocol::HEIGHT,
        arguments.shared.seed
    );
    if arguments.part.fluids() {
        let (relaxation, base) = (protocol.relaxation_base, protocol.base);
        println!(
            "fluid, α = {:?}: relaxation by local moves, S = 0.75, base {relaxation} ({} spheres), {} sweeps",
            Protocol::FLUID_RATES,
            relaxation.particles(),
            if protocol.paper { "500000 + 5 x 100000" } else { "100000" },
        );
        if !protocol.paper {
            for rate in Protocol::FLUID_RATES {
                let stage = Protocol::steady_state(rate);
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

/// Where a column came to rest, and when.
fn describe(fluid: &Fluid) -> String {
    let beginnings = fluid
        .beginnings
        .iter()
        .map(|beginning| beginning.map_or("(unknown: all is used)".to_owned(), |sweep| sweep.to_string()));
    format!(
        "h_c = {} at rest, hydrostatics {:.3}; of what was measured, steady by the data from sweep {}; {:.1} s for the relaxation, {:.1} s for the rest",
        fluid.plateau,
        fluid.theory.center_of_mass(),
        beginnings.collect::<Vec<String>>().join(", "),
        fluid.relaxation.busy.as_secs_f64(),
        fluid.runs.iter().map(|run| run.busy).sum::<Duration>().as_secs_f64()
    )
}

/// Puts together what belongs together.
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
        let equilibration = if protocol.paper { 500_000 } else { Protocol::steady_state(rate).equilibration };
        fluids.push(Fluid::new(column, relaxation, runs, equilibration, protocol.seed(900 + index))?);
    }
    Ok(Results { fluids, crystals, paper: protocol.paper })
}

/// Processor time of all runs.
fn busy(results: &Results) -> Duration {
    let crystals = results.crystals.iter().map(|crystal| crystal.busy);
    let relaxations = results.fluids.iter().map(|fluid| fluid.relaxation.busy);
    let steady = results.fluids.iter().flat_map(|fluid| &fluid.runs).map(|run| run.busy);
    let steady: Duration = if results.paper { Duration::ZERO } else { steady.sum() };
    crystals.sum::<Duration>() + relaxations.sum::<Duration>() + steady
}
