//! No more model than the scene needs: the cheapest of ideal gas, hydrostatic theory, density
//! functional and Monte Carlo whose expected error, the share of spheres at a wrong height, stays
//! below what is asked; why the cheaper ones do not do; and the densities that it gives. `cargo run
//! --release --example model_for`

use gradient_mc::field::UniformField;
use gradient_mc::model::{Accuracy, Model, total_variation_distance};
use gradient_mc::moves::EventChains;
use gradient_mc::observers::{Bins, DensityProfile};
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Error, Scene, Simulation, Slab};

fn main() -> Result<(), Error> {
    let slab = Slab::new(30.0, 8.0, 8.0)?;
    let scene = Scene::new(slab, 64, UniformField::default(), Isothermal::new(2.0)?)?;

    // What is true: a long run, in bins of a diameter.
    let mut simulation = Simulation::builder(scene).moves(EventChains::default()).seed(7).build()?;
    let mut profile = DensityProfile::new(&slab, Bins::of_width(1.0))?;
    simulation.equilibrate(2000, &mut ())?;
    simulation.run(50_000, &mut profile)?;
    let truth = profile.means();
    // Its error: half the error bars of all bins, over the spheres in the column.
    let bars: f64 = profile.points()?.iter().map(|point| point.number_density.standard_error).sum();
    let known_to = 0.5 * bars / scene.column_density();

    println!(
        "asked     model                 share of spheres at a wrong height (the truth is known to {known_to:.4})"
    );
    for tolerance in [0.3, 0.05, 0.004] {
        let choice = scene.model_for(Accuracy::density(tolerance)?)?;
        let name = match choice.model() {
            Model::IdealGas(_) => "ideal gas".to_owned(),
            Model::Hydrostatics(_) => "hydrostatic theory".to_owned(),
            Model::DensityFunctional(_) => "density functional".to_owned(),
            Model::MonteCarlo(plan) => format!("{} sweeps", plan.sweeps()),
            _ => "another".to_owned(),
        };
        let densities = choice.model().densities(&scene, 1)?;
        let error = total_variation_distance(&densities, &truth);
        println!("{tolerance:<8}  {name:<20}  {error:.4}");
        println!("{choice}\n");
    }
    for warning in simulation.warnings() {
        println!("warning: {warning}");
    }
    Ok(())
}
