//! Trial moves per CPU second on one core, over sizes, and on several: `cargo bench --bench throughput`, with
//! `--features rayon` for the last.
//!
//! Two homogeneous scenes without gravity bound what a column contains: a dense fluid (packing
//! fraction 0.45, S = 0.12), where overlap tests dominate, and the paper's dilute start (n = 0.1,
//! S = 0.75), where memory does. In each, three programs take turns: the paper's algorithm written
//! plainly, the library, and the library with a drive specialised by hand, which shows what being
//! generic costs. Ratios are medians over turns, in CPU time of this thread: absolute figures drift
//! on a busy machine. Then the time per trial of dilute systems of 10⁴ to 10⁷ spheres, and the wall time on one and on two threads.

#![allow(clippy::print_stdout)]

mod plain;

use gradient_mc::drive::{Drive, Scheme};
use gradient_mc::field::UniformField;
use gradient_mc::start::{Positions, Uniform};
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Error, Scene, Simulation, Slab};
use plain::PlainColumn;
use rustix::time::{ClockId, clock_gettime};
use std::time::Instant;

const PARTICLES: usize = 25_000;
const TURNS: usize = 15;
const SWEEPS: u64 = 40;
const WIDTH: f64 = 25.0;
const TEMPERATURE: f64 = 20.0;

/// CPU seconds of this thread.
fn cpu_seconds() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// φ/T of a weightless gas, all that an isothermal scene could be specialised to.
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
    fn drive(self, _: &Scene<F, T>) -> Result<Self, Error> {
        Ok(self)
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
    let mut start = Simulation::builder(scene).maximum_displacement(displacement).seed(1).build()?;
    start.equilibrate(300, &mut ())?;
    let positions = start.positions();
    let builder = || {
        let start = Positions(positions.clone());
        Simulation::builder(scene).start(start).maximum_displacement(displacement).seed(2)
    };
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
    println!("{name}, acceptance {:.3}", library.tally().acceptance());
    for (label, rates) in ["plain loop", "library", "library, drive by hand"].iter().zip(&rates) {
        println!("  {label:<24} {:>6.2} million trial moves per CPU second", median(rates.clone()));
    }
    println!("  library / plain loop     {:>6.2}", ratio(1, 0));
    println!("  library / by hand        {:>6.3}", ratio(1, 2));
    Ok(())
}

/// CPU time per trial of the dilute start, in a slab as high as the paper's and as wide as it takes.
fn sizes() -> Result<(), Error> {
    println!("dilute systems of several sizes");
    for particles in [10_000, 100_000, 1_000_000, 10_000_000] {
        let width = f64::sqrt(particles as f64 / 40.0);
        let slab = Slab::new(400.0, width, width)?;
        let scene = Scene::new(slab, particles, UniformField::new(0.0)?, Isothermal::new(TEMPERATURE)?)?;
        let builder = Simulation::builder(scene).start(Uniform::new(0.1)).maximum_displacement(0.75);
        let mut simulation = builder.seed(1).build()?;
        let sweeps = (2_000_000 / particles).max(1) as u64;
        simulation.equilibrate(2 * sweeps, &mut ())?;
        let mut times = Vec::new();
        for _ in 0..5 {
            let start = cpu_seconds();
            simulation.run(sweeps, &mut ())?;
            times.push(1e9 * (cpu_seconds() - start) / (sweeps * particles as u64) as f64);
        }
        println!("  {particles:>8} spheres            {:>6.1} ns per trial move", median(times));
    }
    Ok(())
}

/// Wall time on two threads against one, and whether they agree.
fn threads(name: &str, scene: Scene<UniformField, Isothermal>, displacement: f64) -> Result<(), Error> {
    let builder = || Simulation::builder(scene).maximum_displacement(displacement).seed(3).build();
    let mut simulations = [builder()?, builder()?];
    let mut speedups = Vec::new();
    for turn in 0..TURNS {
        let mut seconds = [0.0; 2];
        for (threads, (simulation, seconds)) in (1..).zip(simulations.iter_mut().zip(&mut seconds)) {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let Ok(pool) = pool else { continue };
            let start = Instant::now();
            pool.install(|| simulation.run(SWEEPS, &mut ()))?;
            *seconds = start.elapsed().as_secs_f64();
        }
        if turn > 0 {
            speedups.push(seconds[0] / seconds[1]);
        }
    }
    let [one, two] = simulations.map(|simulation| simulation.positions());
    let agreement = if one == two { "same bits" } else { "DIFFERENT BITS" };
    println!("  {name:<24} {:>6.2} times as fast on two threads, {agreement}", median(speedups));
    Ok(())
}

fn run() -> Result<(), Error> {
    let dense = 0.45 * 6.0 / std::f64::consts::PI;
    compare("dense: packing fraction 0.45, S = 0.12", dense, 0.12)?;
    compare("dilute: n = 0.1, S = 0.75", 0.1, 0.75)?;
    sizes()?;
    if cfg!(feature = "rayon") {
        println!("two threads against one, wall time");
        let area = WIDTH * WIDTH;
        let scene = |height: f64, particles: usize, acceleration: f64| {
            let slab = Slab::new(height, WIDTH, WIDTH)?;
            Scene::new(slab, particles, UniformField::new(acceleration)?, Isothermal::new(TEMPERATURE)?)
        };
        threads("dense", scene(2.0 * PARTICLES as f64 / (area * dense), 2 * PARTICLES, 0.0)?, 0.12)?;
        threads("dilute", scene(400.0, PARTICLES, 0.0)?, 0.75)?;
        threads("the paper's column", scene(400.0, PARTICLES, 1.0)?, 0.5)?;
    }
    Ok(())
}

fn main() -> Result<(), Error> {
    // This thread is the whole pool, so that its CPU time is all there is.
    match rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build() {
        Ok(pool) => pool.install(run),
        Err(_) => run(),
    }
}
