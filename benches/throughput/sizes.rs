//! Time per trial and per event over the number of spheres.

use crate::median;
use gradient_mc::field::UniformField;
use gradient_mc::moves::{EventChains, LocalMoves, Moves};
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Scene, Simulation, Slab};
use paper::Failure;
use paper::clock::process_cpu_seconds as cpu_seconds;
use paper::figure::{Axis, Corner, Figure, Mark, Panel, Place, Point, colors};
use paper::table::Table;
use std::path::Path;

/// The paper's column, on wider and wider bases.
const COLUMN_DENSITY: f64 = 40.0;

/// Resident memory of this process in GiB, where the system tells it.
fn memory() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kibibytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kibibytes / f64::from(1 << 20))
}

pub(crate) fn run(largest: usize, directory: &Path) -> Result<(), Failure> {
    let mut table = Table::new(["spheres", "ns / trial", "ns / event", "largest memory so far, GiB"]);
    let (mut trials, mut events) = (Vec::new(), Vec::new());
    let sizes = [10_000, 30_000, 100_000, 300_000, 1_000_000, 3_000_000, 10_000_000];
    for particles in sizes.into_iter().filter(|&particles| particles <= largest) {
        let width = (particles as f64 / COLUMN_DENSITY).sqrt();
        let slab = Slab::new(400.0, width, width)?;
        let scene = Scene::new(slab, particles, UniformField::default(), Isothermal::new(20.0)?)?;
        let time = |moves: Moves, work: &dyn Fn(&gradient_mc::MoveCounts) -> u64| -> Result<f64, Failure> {
            let mut simulation = Simulation::builder(scene).moves(moves).seed(1).build()?;
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
            Ok(median(nanoseconds))
        };
        let trial = time(LocalMoves::new(0.5)?.into(), &|move_counts| move_counts.trials)?;
        let event = time(EventChains::default().local_moves(None).into(), &|move_counts| move_counts.events)?;
        trials.push((particles, trial));
        events.push((particles, event));
        let memory = memory().map_or("?".into(), |memory| format!("{memory:.2}"));
        table.row(&particles.to_string(), [format!("{trial:.1}"), format!("{event:.1}"), memory]);
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
