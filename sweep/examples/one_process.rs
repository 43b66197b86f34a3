//! Runs a table by `Replicas` alone on one thread, without checkpoints, ranks or messages: the
//! reference for the overhead of a sweep.
//!
//! ```sh
//! cargo build --release -p gradient-mc-sweep --features mpi --examples --bins
//! time target/release/examples/one_process sweep/ten_seconds.toml
//! time mpirun -n 2 target/release/gradient-mc-sweep sweep/ten_seconds.toml
//! ```

use gradient_mc::{Replicas, Simulation};
use gradient_mc_sweep::{Case, Table};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: one_process TABLE")?;
    let table = Table::read(&std::fs::read_to_string(path)?)?;
    for scenes in table.cases.chunk_by(|one: &Case, other: &Case| one.seed == other.seed) {
        let replicas = Replicas::new(scenes[0].replicas).seed(scenes[0].seed).threads(1);
        let outcomes = replicas.run_each(scenes, |case, replica| {
            let scene = case.scene()?;
            let mut observers = case.observers(&scene)?;
            let mut simulation = Simulation::builder(scene).seed(replica.seed()).build()?;
            simulation.equilibrate(case.equilibration, &mut ())?;
            simulation.run(case.sweeps, &mut observers)?;
            Ok((observers, simulation.warnings().len()))
        })?;
        for (case, outcome) in scenes.iter().zip(outcomes) {
            let (observers, warnings): (Vec<_>, Vec<usize>) = outcome.into_replicas().into_iter().unzip();
            let (center_of_mass, fit) = gradient_mc::Merge::pooled(&observers)?;
            let factors = fit.result()?;
            let factors = factors.combined().compressibility_factor_at(&table.packing_fractions)?;
            let warnings: usize = warnings.iter().sum();
            println!("{}: {}, {factors:?}, {warnings} warnings", case.name, center_of_mass.estimate()?);
        }
    }
    Ok(())
}
