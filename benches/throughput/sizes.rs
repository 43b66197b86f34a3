//! Time per trial and per event, and memory, over the number of spheres.

use clap::ValueEnum;
use gradient_mc::field::UniformField;
use gradient_mc::moves::{EventChains, LocalMoves, Moves};
use gradient_mc::temperature::Isothermal;
use gradient_mc::{MoveCounts, Scene, Simulation, Slab};
use paper::Failure;
use paper::accuracy::median;
use paper::clock::process_cpu_seconds as cpu_seconds;
use paper::figure::{Axis, Corner, Figure, Mark, Panel, Place, Point, colors};
use paper::table::Table;
use std::path::Path;
use std::process::Command;

/// The paper's column, on wider and wider bases.
const COLUMN_DENSITY: f64 = 40.0;

/// Resident memory of this process in GiB, where the system tells it.
fn memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kibibytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kibibytes / f64::from(1 << 20))
}

/// What is measured of a system.
#[derive(ValueEnum, Debug, Clone, Copy)]
pub(crate) enum Alone {
    Local,
    Chains,
}

/// Prints nanoseconds of CPU time per trial or event, and the largest memory so far.
pub(crate) fn alone(of: Alone, particles: usize) -> Result<(), Failure> {
    let width = (particles as f64 / COLUMN_DENSITY).sqrt();
    let slab = Slab::new(400.0, width, width)?;
    let scene = Scene::new(slab, particles, UniformField::default(), Isothermal::new(20.0)?)?;
    let moves: Moves = match of {
        Alone::Local => LocalMoves::new(0.5)?.into(),
        Alone::Chains => EventChains::default().local_moves(None).into(),
    };
    let mut simulation = Simulation::builder(scene).moves(moves).seed(1).build()?;
    let work = |move_counts: &MoveCounts| match of {
        Alone::Local => move_counts.trials,
        Alone::Chains => move_counts.events,
    };
    // The lattice of the start loosens; in the largest systems that is all there is time for.
    simulation.equilibrate((4_000_000 / particles as u64).clamp(2, 20), &mut ())?;
    let mut nanoseconds = Vec::new();
    for _ in 0..3 {
        let (start, before) = (cpu_seconds(), work(simulation.move_counts()));
        let mut seconds = 0.0;
        while seconds < 0.3 {
            simulation.run(1, &mut ())?;
            seconds = cpu_seconds() - start;
        }
        nanoseconds.push(1e9 * seconds / (work(simulation.move_counts()) - before) as f64);
    }
    println!("{} {}", median(nanoseconds), memory().unwrap_or(f64::NAN));
    Ok(())
}

/// The same in a process of its own: what one simulation has freed stays with its process.
fn measure(of: &str, particles: usize) -> Result<[f64; 2], Failure> {
    let mut command = Command::new(std::env::current_exe()?);
    let output = command.args(["--alone", of, "--largest", &particles.to_string()]).output()?;
    let text = String::from_utf8(output.stdout)?;
    let numbers: Vec<f64> = text.split_whitespace().map(str::parse).collect::<Result<_, _>>()?;
    <[f64; 2]>::try_from(numbers).map_err(|_| format!("{of}, {particles} spheres: no result").into())
}

pub(crate) fn run(largest: usize, directory: &Path) -> Result<(), Failure> {
    let mut table = Table::new(["spheres", "ns / trial", "GiB", "ns / event", "GiB"]);
    let (mut trials, mut events) = (Vec::new(), Vec::new());
    let sizes = [10_000, 30_000, 100_000, 300_000, 1_000_000, 3_000_000, 10_000_000];
    for particles in sizes.into_iter().filter(|&particles| particles <= largest) {
        let [trial, of_local] = measure("local", particles)?;
        let [event, of_chains] = measure("chains", particles)?;
        trials.push((particles, trial));
        events.push((particles, event));
        let gibibytes = |memory: f64| format!("{memory:.2}");
        table.row(
            &particles.to_string(),
            [format!("{trial:.1}"), gibibytes(of_local), format!("{event:.1}"), gibibytes(of_chains)],
        );
    }
    println!("\nover the number of spheres: the column at T = 20, S = 0.5\n{table}");
    draw(&trials, &events, &directory.join("sizes"))?;
    println!("written to {}", directory.display());
    Ok(())
}

fn draw(trials: &[(usize, f64)], events: &[(usize, f64)], path: &Path) -> Result<(), Failure> {
    let slowest = trials.iter().chain(events).map(|&(_, time)| time).fold(0.0, f64::max);
    let place = Place { left: 0.0, top: 0.07, width: 1.0, height: 0.93 };
    let mut panel = Panel::new(
        place,
        Axis::new("log₁₀ of the number of spheres", 3.8, 7.2).with_numbers(7),
        Axis::new("nanoseconds of CPU time", 0.0, (1.3 * slowest / 50.0).ceil() * 50.0),
    )
    .with_legend(Corner::TopLeft);
    for (label, color, data) in
        [("trial move, S = 0.5", colors::BLUE, trials), ("event of a chain", colors::VERMILION, events)]
    {
        let points = || data.iter().map(|&(particles, time)| ((particles as f64).log10(), time));
        panel = panel.line("", color, Mark::Line, points()).points(
            label,
            color,
            Mark::Points,
            points().map(|(x, y)| Point { x, y, error: 0.0 }),
        );
    }
    Figure::new("Time per move over the size of the system: column, T = 20 mgd, N/A = 40")
        .panel(panel)
        .save(path)
}
