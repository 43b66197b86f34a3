//! Trial moves per CPU second on one core: `cargo bench --bench throughput`.
//!
//! Two homogeneous scenes without gravity bound what a column contains: a dense fluid (packing
//! fraction 0.45, S = 0.12), where overlap tests dominate, and the paper's dilute start (n = 0.1,
//! S = 0.75), where memory does. Each figure is the median of several turns taken alternately, in time
//! of this thread, which a busy machine disturbs least.

#![allow(clippy::print_stdout)]

use gradient_mc::{Error, Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
use rustix::time::{ClockId, clock_gettime};

const PARTICLES: usize = 25_000;
const TURNS: usize = 7;

/// CPU seconds of this thread.
fn cpu_seconds() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

struct Case {
    name: &'static str,
    simulation: Simulation<UniformField, Isothermal>,
    sweeps: u64,
    rates: Vec<f64>,
}

impl Case {
    fn new(name: &'static str, number_density: f64, displacement: f64, sweeps: u64) -> Result<Self, Error> {
        let slab = Slab::new(PARTICLES as f64 / (625.0 * number_density), 25.0, 25.0)?;
        let scene = Scene::new(slab, PARTICLES, UniformField::new(0.0)?, Isothermal::new(1.0)?)?;
        let mut simulation = Simulation::builder(scene).maximum_displacement(displacement).seed(1).build()?;
        simulation.equilibrate(200, &mut ())?;
        Ok(Self { name, simulation, sweeps, rates: Vec::new() })
    }

    fn turn(&mut self) -> Result<(), Error> {
        let start = cpu_seconds();
        self.simulation.run(self.sweeps, &mut ())?;
        self.rates.push((self.sweeps * PARTICLES as u64) as f64 / (cpu_seconds() - start));
        Ok(())
    }

    fn median(&self) -> f64 {
        let mut rates = self.rates.clone();
        rates.sort_by(f64::total_cmp);
        rates[rates.len() / 2]
    }
}

fn main() -> Result<(), Error> {
    let dense = 0.45 * 6.0 / std::f64::consts::PI;
    let mut cases = [
        Case::new("dense: packing fraction 0.45, S = 0.12", dense, 0.12, 100)?,
        Case::new("dilute: n = 0.1, S = 0.75", 0.1, 0.75, 100)?,
    ];
    for _ in 0..TURNS {
        for case in &mut cases {
            case.turn()?;
        }
    }
    for case in &cases {
        println!(
            "{:<40} {:>6.2} million trial moves per CPU second (acceptance {:.3})",
            case.name,
            case.median() / 1e6,
            case.simulation.tally().acceptance()
        );
    }
    Ok(())
}
