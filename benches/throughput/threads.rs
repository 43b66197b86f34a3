//! What a second thread gains, on the clock on the wall: meaningful on an idle machine only.

use crate::common::Failure;
use crate::packing::fluid;
use crate::{cpu_seconds, median};
use gradient_mc::{Simulation, moves::LocalMoves};
use std::time::Instant;

const TURNS: usize = 9;
const SWEEPS: u64 = 60;

pub(crate) fn run() -> Result<(), Failure> {
    if !cfg!(feature = "rayon") {
        println!("\nthreads: sweeps share them only with `--features rayon`");
        return Ok(());
    }
    println!();
    for (name, packing_fraction, size) in [("dense", 0.45, 0.12), ("dilute", 0.0524, 0.75)] {
        let scene = fluid(25_000, 25.0, packing_fraction)?;
        let moves = LocalMoves::new(size, scene.slab())?;
        let pools = [1, 2].map(|threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build());
        let [one, two] = pools;
        let pools = [one?, two?];
        let build = || Simulation::builder(scene).moves(moves).seed(1).build();
        let mut simulations = [build()?, build()?];
        let (mut ratios, mut cores) = (Vec::new(), Vec::new());
        for _ in 0..TURNS {
            let mut seconds = [0.0; 2];
            for ((simulation, pool), seconds) in simulations.iter_mut().zip(&pools).zip(&mut seconds) {
                let (wall, cpu) = (Instant::now(), cpu_seconds());
                pool.install(|| simulation.run(SWEEPS, &mut ()))?;
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
