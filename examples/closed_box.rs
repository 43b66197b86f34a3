//! A closed box: a lid that carries a part of the pressure. Weightless, P is the same everywhere; with weight, P(base) − P(lid) is the
//! weight of the column. Prints P at both walls, from the density that touches them, and P/(nTZ) − 1 half way, with error bars.
//! `cargo run --release --example closed_box`

use gradient_mc::equation_of_state::ModifiedKolafa;
use gradient_mc::field::UniformField;
use gradient_mc::moves::EventChains;
use gradient_mc::observers::{Bins, DensityProfile, EquationOfStateProfile};
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Error, Every, Scene, Simulation, Slab};

/// Height of the bins that touch the walls: thin, so that their mean is the density of contact.
const THIN: f64 = 0.02;

fn main() -> Result<(), Error> {
    let slab = Slab::new(20.0, 6.0, 6.0)?;
    let (lowest, highest, temperature) = (slab.lowest_center(), slab.highest_center(), 5.0);
    println!("a/g   P(lid)     theory   P(base)    theory   P/(nTZ) − 1 from x = 7 to 13");
    for acceleration in [0.0, 0.2, 1.0] {
        let field = UniformField::new(acceleration)?;
        let scene = Scene::new(slab, 250, field, Isothermal::new(temperature)?)?;
        let theory = scene.hydrostatics(&ModifiedKolafa)?;

        let mut simulation = Simulation::builder(scene).moves(EventChains::default()).seed(1).build()?;
        simulation.equilibrate(500, &mut ())?;
        let lid = DensityProfile::new(&slab, Bins::count(1).from(highest - THIN).to(highest))?;
        let base = DensityProfile::new(&slab, Bins::count(1).from(lowest).to(lowest + THIN))?;
        let mut profile = EquationOfStateProfile::new(&slab, Bins::of_width(0.5))?;
        // The weight above a height is measured; what the lid carries is not, and comes from the theory.
        profile.set_open_end_pressure(theory.lid_pressure())?;
        let mut observers = Every::new(2, (lid, base, profile));
        simulation.run(15_000, &mut observers)?;

        let (lid, base, profile) = observers.observer;
        let contact = |wall: &DensityProfile| -> Result<_, Error> {
            let density = wall.points()?[0].number_density;
            Ok((density * temperature).to_string())
        };
        let deviation = profile.deviations_over(&[[7.0, 13.0]], &ModifiedKolafa)?[0];
        println!(
            "{acceleration:3.1}   {:<9}  {:6.3}   {:<9}  {:6.3}   {deviation}",
            contact(&lid)?,
            theory.lid_pressure(),
            contact(&base)?,
            theory.base_pressure(),
        );
        for warning in simulation.warnings() {
            println!("  warning: {warning}");
        }
    }
    Ok(())
}
