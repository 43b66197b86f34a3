//! Chooses the cheapest model of a scene that is accurate enough: ideal gas, hydrostatic theory,
//! density functional or Monte Carlo. The error of a model is the share of spheres at a wrong
//! height. Prints the chosen model for several tolerances, and why cheaper ones are not sufficient.
//! `cargo run --release --example model_for`

use gradient_mc::field::UniformField;
use gradient_mc::model::{Accuracy, Model, total_variation_distance};
use gradient_mc::moves::EventChains;
use gradient_mc::observers::{Bins, DensityProfile};
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Error, Scene, Simulation, Slab};

fn main() -> Result<(), Error> {
    let slab = Slab::new(30.0, 8.0, 8.0)?;
    let scene = Scene::new(slab, 64, UniformField::default(), Isothermal::new(2.0)?)?;

    // The reference: a long run, with bins of one diameter.
    let mut simulation = Simulation::builder(scene).moves(EventChains::default()).seed(7).build()?;
    let mut profile = DensityProfile::new(&slab, Bins::of_width(1.0))?;
    simulation.equilibrate(2000, &mut ())?;
    simulation.run(50_000, &mut profile)?;
    let truth = profile.means();
    // Error of the reference: half the sum of the error bars of all bins, over the number of
    // spheres in the column.
    let bars: f64 = profile.points()?.iter().map(|point| point.number_density.standard_error).sum();
    let known_to = 0.5 * bars / scene.column_density();

    println!(
        "tolerance  model                 share of spheres at a wrong height (error of the reference: {known_to:.4})"
    );
    for tolerance in [0.3, 0.05, 0.004] {
        let choice = scene.model_for(Accuracy::density(tolerance)?)?;
        let name = match choice.model() {
            Model::IdealGas(_) => "ideal gas".to_owned(),
            Model::Hydrostatics(_) => "hydrostatic theory".to_owned(),
            Model::DensityFunctional(_) => "density functional".to_owned(),
            Model::MonteCarlo(plan) => format!("{} sweeps", plan.sweeps()),
            _ => "another model".to_owned(),
        };
        let densities = choice.model().densities(&scene, 1)?;
        let error = total_variation_distance(&densities, &truth);
        println!("{tolerance:<9}  {name:<20}  {error:.4}");
        println!("{choice}\n");
    }
    for warning in simulation.warnings() {
        println!("warning: {warning}");
    }
    Ok(())
}
