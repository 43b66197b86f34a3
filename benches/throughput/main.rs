//! Trial moves and chain events per CPU second: `cargo bench --bench throughput`; with
//! `--features rayon`, also what a second thread gains; with `-- --largest 10000000`, up to ten
//! million spheres.
//!
//! Two homogeneous scenes without gravity are the limits of a column: a dense fluid (packing
//! fraction 0.45, S = 0.12), where overlap tests dominate, and the paper's dilute start (n = 0.1,
//! S = 0.75), where memory access does. In each, three programs take turns: a plain implementation
//! of the paper's algorithm, the library, and the library with a drive specialized by hand, which
//! shows the cost of generic code. Ratios are medians over turns, in CPU time; absolute times drift
//! on a busy machine.

#![allow(clippy::print_stdout)]

mod feedback;
mod packing;
mod sizes;
mod threads;

use clap::{Parser, ValueEnum};
use gradient_mc::drive::{Drive, Scheme};
use gradient_mc::field::UniformField;
use gradient_mc::moves::{EventChains, LocalMoves, Moves};
use gradient_mc::start::Positions;
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Error, Scene, Simulation, Slab};
use paper::Failure;
use paper::clock::process_cpu_seconds as cpu_seconds;
use paper::plain::PlainColumn;
use std::path::PathBuf;

const PARTICLES: usize = 25_000;
const TURNS: usize = 15;
const SWEEPS: u64 = 40;
const WIDTH: f64 = 25.0;
const TEMPERATURE: f64 = 20.0;

/// φ/T of a weightless gas, all that an isothermal scene could be specialized to.
#[derive(Debug, Clone, Copy)]
struct ByHand;

impl<F, T> Drive<F, T> for ByHand {
    #[inline]
    fn reduced_potential(&self, _: &Scene<F, T>, height: f64) -> f64 {
        0.0 * height
    }
}

impl<F, T> Scheme<F, T> for ByHand {
    type Drive = Self;
    type Adaptation = ();
    fn drive(self, _: &Scene<F, T>) -> Result<(Self, ()), Error> {
        Ok((self, ()))
    }
}

/// Million trial moves per CPU second of one turn.
fn rate(mut turn: impl FnMut() -> Result<(), Error>) -> Result<f64, Error> {
    let start = cpu_seconds();
    turn()?;
    Ok(1e-6 * (SWEEPS * PARTICLES as u64) as f64 / (cpu_seconds() - start))
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn compare(name: &str, number_density: f64, displacement: f64) -> Result<(), Error> {
    let height = PARTICLES as f64 / (WIDTH * WIDTH * number_density);
    let slab = Slab::new(height, WIDTH, WIDTH)?;
    let scene = Scene::new(slab, PARTICLES, UniformField::new(0.0)?, Isothermal::new(TEMPERATURE)?)?;
    let mut start = Simulation::builder(scene).moves(LocalMoves::new(displacement)?).seed(1).build()?;
    start.equilibrate(300, &mut ())?;
    let positions = start.positions();
    let moves = LocalMoves::new(displacement)?;
    let builder = || Simulation::builder(scene).start(Positions(positions.clone())).moves(moves).seed(2);
    let mut plain = PlainColumn::new(height, WIDTH, TEMPERATURE, displacement, &positions, 1);
    let mut library = builder().build()?;
    let mut by_hand = builder().scheme(ByHand).build()?;
    let mut rates = [Vec::new(), Vec::new(), Vec::new()];
    for _ in 0..TURNS {
        rates[0].push(rate(|| {
            (0..SWEEPS).for_each(|_| plain.sweep());
            Ok(())
        })?);
        rates[1].push(rate(|| library.run(SWEEPS, &mut ()))?);
        rates[2].push(rate(|| by_hand.run(SWEEPS, &mut ()))?);
    }
    let ratio = |of: usize, to: usize| median(rates[of].iter().zip(&rates[to]).map(|(a, b)| a / b).collect());
    println!("{name}, acceptance {:.3}", library.move_counts().acceptance());
    for (label, rates) in ["plain loop", "library", "library, drive by hand"].iter().zip(&rates) {
        println!("  {label:<24} {:>6.2} million trial moves per CPU second", median(rates.clone()));
    }
    println!("  library / plain loop     {:>6.2}", ratio(1, 0));
    println!("  library / by hand        {:>6.3}", ratio(1, 2));
    Ok(())
}

#[derive(Parser, Debug)]
struct Arguments {
    /// Spheres of the largest system
    #[arg(long, default_value_t = 1_000_000)]
    largest: usize,
    /// Only the parts whose names contain this: peers, packing, feedback, sizes, threads
    #[arg(default_value = "")]
    part: String,
    /// Turns of the part feedback, of which medians are taken
    #[arg(long, default_value_t = 21)]
    turns: usize,
    /// Instead, so many sweeps of one hot loop and nothing else, for a program that counts
    /// instructions
    #[arg(long)]
    count: Option<u64>,
    /// The loop that is counted
    #[arg(long, value_enum, default_value_t = HotLoop::Dense)]
    of: HotLoop,
    /// Instead, one line of the part sizes: of the largest system
    #[arg(long, value_enum)]
    alone: Option<sizes::Alone>,
    /// Directory for the picture
    #[arg(long, default_value = "out/throughput")]
    out: PathBuf,
    /// What cargo adds
    #[arg(long, hide = true)]
    bench: bool,
}

/// Where a run spends its time.
#[derive(ValueEnum, Debug, Clone, Copy)]
enum HotLoop {
    /// Local moves at packing fraction 0.45, S = 0.12
    Dense,
    /// Local moves at n = 0.1, S = 0.75
    Dilute,
    /// Event chains in a column at T = 20
    Chains,
}

/// Makes sweeps of one hot loop; the difference of two counts is free of what prepares them.
fn count(of: HotLoop, sweeps: u64) -> Result<(), Failure> {
    let (scene, moves): (_, Moves) = match of {
        HotLoop::Dense => (packing::fluid(4000, 12.0, 0.45)?, LocalMoves::new(0.12)?.into()),
        HotLoop::Dilute => {
            (packing::fluid(4000, 25.0, 0.1 * std::f64::consts::PI / 6.0)?, LocalMoves::new(0.75)?.into())
        }
        HotLoop::Chains => {
            let slab = Slab::new(400.0, 10.0, 10.0)?;
            let scene = Scene::new(slab, 4000, UniformField::default(), Isothermal::new(TEMPERATURE)?)?;
            (scene, EventChains::default().local_moves(None).into())
        }
    };
    let mut simulation = Simulation::builder(scene).moves(moves).seed(1).build()?;
    simulation.equilibrate(50, &mut ())?;
    let before = *simulation.move_counts();
    simulation.run(sweeps, &mut ())?;
    let done = simulation.move_counts().since(&before);
    println!("{of:?}: {} trials, {} events", done.trials, done.events);
    Ok(())
}

fn main() -> Result<(), Failure> {
    let arguments = Arguments::parse();
    if let Some(sweeps) = arguments.count {
        return count(arguments.of, sweeps);
    }
    if let Some(of) = arguments.alone {
        return sizes::alone(of, arguments.largest);
    }
    let wanted = |part: &str| part.contains(&arguments.part);
    if wanted("peers") {
        compare("dense: packing fraction 0.45, S = 0.12", 0.45 * 6.0 / std::f64::consts::PI, 0.12)?;
        compare("dilute: n = 0.1, S = 0.75", 0.1, 0.75)?;
    }
    if wanted("packing") {
        packing::run()?;
    }
    if wanted("feedback") {
        feedback::run(arguments.turns)?;
    }
    if wanted("threads") {
        threads::run()?;
    }
    if wanted("sizes") {
        paper::output::create_directory(&arguments.out)?;
        sizes::run(arguments.largest, &arguments.out)?;
    }
    Ok(())
}
