//! What the feedback of a temperature that varies costs: sweeps that measure and adapt, and sweeps
//! that record the balance of forces, against sweeps in the same potential, frozen and unobserved.

use crate::median;
use gradient_mc::drive::{EquationOfStateClosure, SelfConsistent};
use gradient_mc::field::UniformField;
use gradient_mc::moves::{EventChains, LocalMoves, Moves};
use gradient_mc::temperature::ExponentialTemperature;
use gradient_mc::{Scene, Simulation, Slab};
use paper::Failure;
use paper::clock::process_cpu_seconds as cpu_seconds;
use paper::table::Table;

pub(crate) fn run(turns: usize) -> Result<(), Failure> {
    let mut table = Table::new(["spheres, moves", "adapting / frozen", "recording / frozen"]);
    for (particles, width) in [(1000, 5.0), (25_000, 25.0)] {
        let slab = Slab::new(400.0, width, width)?;
        let temperature = ExponentialTemperature::new(20.0, 0.02)?;
        let scene = Scene::new(slab, particles, UniformField::default(), temperature)?;
        let moves: [(&str, Moves); 2] =
            [("local", LocalMoves::new(0.75)?.into()), ("chains", EventChains::default().into())];
        for (name, moves) in moves {
            let closed =
                || Simulation::builder(scene).scheme(EquationOfStateClosure::default()).moves(moves).build();
            let mut adapting =
                Simulation::builder(scene).scheme(SelfConsistent::default()).moves(moves).build()?;
            // What production records, equilibration does not.
            let (mut recording, mut frozen) = (closed()?, closed()?);
            // Past the first steps, which are short.
            adapting.equilibrate(600, &mut ())?;
            recording.equilibrate(600, &mut ())?;
            frozen.equilibrate(600, &mut ())?;
            let sweeps = 2_000_000 / particles as u64;
            let mut ratios = [Vec::new(), Vec::new()];
            for _ in 0..turns {
                let start = cpu_seconds();
                adapting.equilibrate(sweeps, &mut ())?;
                let first = cpu_seconds();
                frozen.equilibrate(sweeps, &mut ())?;
                let second = cpu_seconds();
                recording.run(sweeps, &mut ())?;
                let third = cpu_seconds();
                ratios[0].push((first - start) / (second - first));
                ratios[1].push((third - second) / (second - first));
            }
            let cells = ratios.map(|ratios| format!("{:.3}", median(ratios)));
            table.row(&format!("{particles}, {name}"), cells);
        }
    }
    println!(
        "\ncost of the effective field: T = 20 exp(-0.02 x), medians of {turns} turns, CPU time\n{table}"
    );
    Ok(())
}
