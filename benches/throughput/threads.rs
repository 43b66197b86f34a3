//! What a second thread gains, on the clock on the wall: meaningful on an idle machine only.

use crate::median;
use crate::packing::fluid;
use gradient_mc::field::UniformField;
use gradient_mc::moves::{EventChains, LocalMoves, Moves};
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Scene, Simulation, Slab};
use paper::Failure;
use paper::clock::process_cpu_seconds as cpu_seconds;
use paper::table::Table;
use std::time::Instant;

const TURNS: usize = 9;

/// One turn of one thread and one of two: the ratio of their times, and how many cores the two had.
#[derive(Debug, Clone, Copy)]
struct Gain {
    ratio: f64,
    cores: f64,
}

/// Medians over turns; fails if the numbers of threads give different configurations.
fn gain(scene: Scene<UniformField, Isothermal>, moves: Moves, sweeps: u64) -> Result<Gain, Failure> {
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let build = || Simulation::builder(scene).moves(moves).seed(1).build();
    let (pools, mut simulations) = ([pool(1)?, pool(2)?], [build()?, build()?]);
    for simulation in &mut simulations {
        simulation.equilibrate(20, &mut ())?;
    }
    let (mut ratios, mut cores) = (Vec::new(), Vec::new());
    for _ in 0..TURNS {
        let mut seconds = [0.0; 2];
        for ((simulation, pool), seconds) in simulations.iter_mut().zip(&pools).zip(&mut seconds) {
            let (wall, cpu) = (Instant::now(), cpu_seconds());
            pool.install(|| simulation.run(sweeps, &mut ()))?;
            *seconds = wall.elapsed().as_secs_f64();
            if pool.current_num_threads() == 2 {
                cores.push((cpu_seconds() - cpu) / *seconds);
            }
        }
        ratios.push(seconds[0] / seconds[1]);
    }
    if simulations[0].positions() != simulations[1].positions() {
        return Err("the outcome depends on the number of threads".into());
    }
    Ok(Gain { ratio: median(ratios), cores: median(cores) })
}

pub(crate) fn run() -> Result<(), Failure> {
    if !cfg!(feature = "rayon") {
        println!("\nthreads: sweeps share them only with `--features rayon`");
        return Ok(());
    }
    let mut table = Table::new(["two threads / one", "local moves", "(cores)", "event chains", "(cores)"]);
    for (particles, width) in [(25_000, 25.0), (400_000, 60.0)] {
        // Some two hundredths of a second per turn.
        let sweeps = 1_500_000 / particles as u64;
        let column = Slab::new(400.0, width, width)?;
        for (name, scene, size) in [
            ("dense", fluid(particles, width, 0.45)?, 0.12),
            ("dilute", fluid(particles, width, 0.0524)?, 0.75),
            ("column", Scene::new(column, particles, UniformField::default(), Isothermal::new(20.0)?)?, 0.5),
        ] {
            let local = gain(scene, LocalMoves::new(size)?.into(), sweeps)?;
            let chains = gain(scene, EventChains::default().local_moves(None).into(), sweeps)?;
            let cells = [local.ratio, local.cores, chains.ratio, chains.cores];
            table.row(&format!("{name}, {particles} spheres"), cells.map(|cell| format!("{cell:.2}")));
        }
    }
    println!("\n{table}");
    Ok(())
}
