//! What a second thread gains, on the clock on the wall: meaningful on an idle machine only.

use crate::packing::fluid;
use gradient_mc::{Simulation, moves::LocalMoves};
use paper::Failure;
use paper::accuracy::median;
use paper::clock::process_cpu_seconds as cpu_seconds;
use std::time::Instant;

const TURNS: usize = 9;
const SWEEPS: u64 = 60;

pub(crate) fn run() -> Result<(), Failure> {
    if !cfg!(feature = "rayon") {
        println!("\nthreads: sweeps share them only with `--features rayon`");
        return Ok(());
    }
    println!();
    // In a small system a sweep lasts a millisecond, and threads wait for each other.
    for (name, packing_fraction, size, particles, width) in [
        ("dense, 25 000 spheres", 0.45, 0.12, 25_000, 25.0),
        ("dilute, 25 000 spheres", 0.0524, 0.75, 25_000, 25.0),
        ("dense, 400 000 spheres", 0.45, 0.12, 400_000, 60.0),
        ("dilute, 400 000 spheres", 0.0524, 0.75, 400_000, 60.0),
    ] {
        let scene = fluid(particles, width, packing_fraction)?;
        let sweeps = SWEEPS * 25_000 / particles as u64 + 1;
        let moves = LocalMoves::new(size)?;
        let pools = [1, 2].map(|threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build());
        let [one, two] = pools;
        let pools = [one?, two?];
        let build = || Simulation::builder(scene).moves(moves).seed(1).build();
        let mut simulations = [build()?, build()?];
        for simulation in &mut simulations {
            simulation.equilibrate(10, &mut ())?;
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
        let same = simulations[0].positions() == simulations[1].positions();
        println!(
            "two threads / one, {name}: {:.2} (they had {:.2} cores); same bits: {same}",
            median(ratios),
            median(cores)
        );
        if !same {
            return Err("the outcome depends on the number of threads".into());
        }
    }
    Ok(())
}
