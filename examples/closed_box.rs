//! A closed box, whose lid carries a part of the pressure. Without a field, P is the same at all
//! heights; with a field, P(base) − P(lid) is the weight of the column per area. Prints P at both
//! walls and P/(nTZ) − 1 in the middle, with standard errors. `cargo run --release --example
//! closed_box`

use gradient_mc::equation_of_state::ModifiedKolafa;
use gradient_mc::field::UniformField;
use gradient_mc::moves::EventChains;
use gradient_mc::observers::{Bins, EquationOfStateProfile, WallPressure};
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Error, Every, Scene, Simulation, Slab, Wall};

fn main() -> Result<(), Error> {
    let slab = Slab::new(20.0, 6.0, 6.0)?;
    println!("a/g   P(lid)     theory   P(base)    theory   P/(nTZ) − 1 from x = 7 to 13");
    for acceleration in [0.0, 0.2, 1.0] {
        let field = UniformField::new(acceleration)?;
        let scene = Scene::new(slab, 250, field, Isothermal::new(5.0)?)?;
        let theory = scene.hydrostatics(&ModifiedKolafa)?;

        let mut simulation = Simulation::builder(scene).moves(EventChains::default()).seed(1).build()?;
        simulation.equilibrate(500, &mut ())?;
        let mut walls = WallPressure::new(simulation.scene())?;
        let mut profile = Every::new(2, EquationOfStateProfile::new(&slab, Bins::of_width(0.5))?);
        simulation.run(5000, &mut (&mut walls, &mut profile))?;

        // The profile measures the weight above a height; the pressure on the lid is added.
        let (lid, base) = (walls.at(Wall::Lid)?, walls.at(Wall::Base)?);
        profile.observer.set_open_end_pressure(lid)?;
        let deviation = profile.observer.deviations_over(&[[7.0, 13.0]], &ModifiedKolafa)?[0];
        println!(
            "{acceleration:3.1}   {:<9}  {:6.3}   {:<9}  {:6.3}   {deviation}",
            lid.to_string(),
            theory.lid_pressure(),
            base.to_string(),
            theory.base_pressure(),
        );
        for warning in simulation.warnings() {
            println!("  warning: {warning}");
        }
    }
    Ok(())
}
