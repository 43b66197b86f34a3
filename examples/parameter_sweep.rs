//! A sweep over six temperatures on two threads, with one table of results.
//!
//! `cargo run --release --example parameter_sweep`
//!
//! Writes `out/parameter_sweep/center_of_mass.csv`: the mean height of the center of mass of a
//! column for each temperature, its standard error from blocks and from the scatter of replicas,
//! and the height by theory.

use gradient_mc::equation_of_state::ModifiedKolafa;
use gradient_mc::field::UniformField;
use gradient_mc::moves::EventChains;
use gradient_mc::observers::CenterOfMass;
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Replicas, Scene, Simulation, Slab};
use std::fmt::Write;

const TEMPERATURES: [f64; 6] = [4.0, 5.0, 6.0, 7.0, 8.0, 9.0];

fn scene(temperature: f64) -> Result<Scene<UniformField, Isothermal>, gradient_mc::Error> {
    let slab = Slab::new(200.0, 6.0, 6.0)?;
    Scene::with_column_density(slab, 10.0, UniformField::default(), Isothermal::new(temperature)?)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let outcomes = Replicas::new(4).seed(1).threads(2).run_each(&TEMPERATURES, |&temperature, replica| {
        let builder = Simulation::builder(scene(temperature)?).moves(EventChains::default());
        let mut simulation = builder.seed(replica.seed()).build()?;
        simulation.equilibrate(1000, &mut ())?;
        let mut center_of_mass = CenterOfMass::new();
        simulation.run(10_000, &mut center_of_mass)?;
        Ok(center_of_mass)
    })?;
    let mut table = "# heights in d, temperatures in m g d; errors are one standard error\n\
                     temperature,center_of_mass,center_of_mass_error,error_from_replicas,theory\n"
        .to_owned();
    for (&temperature, outcome) in TEMPERATURES.iter().zip(&outcomes) {
        let center = outcome.merged()?.estimate()?;
        let from_replicas = outcome.scatter(CenterOfMass::estimate)?.standard_error;
        let theory = scene(temperature)?.hydrostatics(&ModifiedKolafa)?.center_of_mass();
        println!("T = {temperature}: center of mass {center}, theory {theory:.3}");
        writeln!(table, "{temperature},{},{},{from_replicas},{theory}", center.mean, center.standard_error)?;
    }
    std::fs::create_dir_all("out/parameter_sweep")?;
    std::fs::write("out/parameter_sweep/center_of_mass.csv", table)?;
    Ok(())
}
