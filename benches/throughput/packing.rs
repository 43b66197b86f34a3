//! Trial moves and chain events over the packing fraction.

use gradient_mc::equation_of_state::number_density;
use gradient_mc::field::UniformField;
use gradient_mc::moves::{EventChains, LocalMoves, Moves};
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Scene, Simulation, Slab};
use paper::Failure;
use paper::accuracy::median;
use paper::clock::process_cpu_seconds as cpu_seconds;
use paper::table::Table;

const PARTICLES: usize = 25_000;
const WIDTH: f64 = 25.0;
const TURNS: usize = 5;

/// A homogeneous fluid between walls, without weight.
pub(crate) fn fluid(
    particles: usize,
    width: f64,
    packing_fraction: f64,
) -> Result<Scene<UniformField, Isothermal>, Failure> {
    let height = particles as f64 / (width * width * number_density(packing_fraction));
    let slab = Slab::new(height, width, width)?;
    Ok(Scene::new(slab, particles, UniformField::new(0.0)?, Isothermal::new(20.0)?)?)
}

/// Largest displacement with which some 30 % to 50 % of the trials are accepted.
fn displacement(packing_fraction: f64) -> f64 {
    (0.06 / packing_fraction).clamp(0.1, 0.75)
}

pub(crate) fn run() -> Result<(), Failure> {
    let mut table = Table::new([
        "packing fraction",
        "S",
        "acceptance",
        "million trials / CPU s",
        "events / diameter",
        "million events / CPU s",
    ]);
    for packing_fraction in [0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.45, 0.49] {
        let scene = fluid(PARTICLES, WIDTH, packing_fraction)?;
        let size = displacement(packing_fraction);
        let local: Moves = LocalMoves::new(size)?.into();
        let chains: Moves = EventChains::default().local_moves(None).into();
        let mut local = Simulation::builder(scene).moves(local).seed(1).build()?;
        let mut chains = Simulation::builder(scene).moves(chains).seed(1).build()?;
        local.equilibrate(200, &mut ())?;
        chains.equilibrate(100, &mut ())?;
        let before = [*local.move_counts(), *chains.move_counts()];
        let (mut trials, mut events) = (Vec::new(), Vec::new());
        let mut sweeps = 0;
        for _ in 0..TURNS {
            let start = cpu_seconds();
            local.run(20, &mut ())?;
            trials.push(20.0 * PARTICLES as f64 / (cpu_seconds() - start));
            let (start, done) = (cpu_seconds(), chains.move_counts().events);
            chains.run(10, &mut ())?;
            sweeps += 10;
            events.push((chains.move_counts().events - done) as f64 / (cpu_seconds() - start));
        }
        let [local, chains] = [local.move_counts().since(&before[0]), chains.move_counts().since(&before[1])];
        let path = EventChains::PATH_PER_SPHERE * PARTICLES as f64 * f64::from(sweeps);
        table.row(
            &format!("{packing_fraction}"),
            [
                format!("{size:.2}"),
                format!("{:.3}", local.acceptance()),
                format!("{:.1}", 1e-6 * median(trials)),
                format!("{:.2}", chains.events as f64 / path),
                format!("{:.2}", 1e-6 * median(events)),
            ],
        );
    }
    println!("\nover the packing fraction, {PARTICLES} spheres\n{table}");
    Ok(())
}
