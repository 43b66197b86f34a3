//! A closed box: a lid that carries a part of the pressure. Weightless, it is one equation of state at one density; with weight, the
//! pressure on the lid is measured with the profile. Prints P at the lid and at the base, and P/(nTZ) − 1 half way.
//! `cargo run --release --example closed_box`

use gradient_mc::equation_of_state::ModifiedKolafa;
use gradient_mc::field::UniformField;
use gradient_mc::moves::EventChains;
use gradient_mc::observers::{Bins, EquationOfStateProfile};
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Error, Every, Scene, Simulation, Slab};

fn main() -> Result<(), Error> {
    let slab = Slab::new(20.0, 6.0, 6.0)?;
    let temperature = Isothermal::new(5.0)?;
    println!("a/g   P(lid)  theory   P(base)  theory   P/(nTZ) − 1 from x = 7 to 13");
    for acceleration in [0.0, 0.2, 1.0] {
        let field = UniformField::new(acceleration)?;
        let scene = Scene::new(slab, 250, field, temperature)?;
        let theory = scene.hydrostatics(&ModifiedKolafa)?;

        let mut simulation = Simulation::builder(scene).moves(EventChains::default()).seed(1).build()?;
        simulation.equilibrate(500, &mut ())?;
        let mut profile = Every::new(2, EquationOfStateProfile::new(&slab, Bins::of_width(0.05))?);
        simulation.run(20_000, &mut profile)?;
        let mut profile = profile.observer;

        // The lid's own pressure is T times the density of contact there: near the last bin that spheres reach.
        let points = profile.points()?;
        let [lid, base] =
            [points.last(), points.first()].map(|point| point.map_or(f64::NAN, |point| point.pressure.mean));
        // What is compared: with the pressure of the theory on the lid, which is known better.
        profile.set_lid_pressure(theory.lid_pressure())?;
        let deviation = profile.deviations_over(&[[7.0, 13.0]], &ModifiedKolafa)?[0];
        println!(
            "{acceleration:3.1}   {lid:6.3}  {:6.3}   {base:7.3}  {:6.3}   {deviation}",
            theory.lid_pressure(),
            theory.base_pressure(),
        );
        for warning in simulation.warnings() {
            println!("  warning: {warning}");
        }
    }
    Ok(())
}
