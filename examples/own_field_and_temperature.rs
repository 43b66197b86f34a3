//! A field and a temperature of one's own: a centrifuge whose pull grows linearly with height, heated from below, each one method.
//! Prints density and P/(nTZ) over height with error bars, and whether the effective field belongs to the density that it made.
//! `cargo run --release --example own_field_and_temperature`

use gradient_mc::drive::SelfConsistent;
use gradient_mc::equation_of_state::ModifiedKolafa;
use gradient_mc::moves::EventChains;
use gradient_mc::observers::{Bins, EquationOfStateProfile};
use gradient_mc::{Error, Every, Field, Scene, Simulation, Slab, TemperatureProfile};

/// a(x) = 1 + rate x: the potential is its integral.
struct Centrifuge {
    rate: f64,
}

impl Field for Centrifuge {
    fn potential(&self, height: f64) -> f64 {
        height + 0.5 * self.rate * height * height
    }
}

/// Falls from that of the plate to that of the surroundings far above.
struct HotPlate {
    plate: f64,
    far: f64,
    depth: f64,
}

impl TemperatureProfile for HotPlate {
    fn temperature(&self, height: f64) -> f64 {
        self.far + (self.plate - self.far) / (1.0 + height / self.depth)
    }
}

fn main() -> Result<(), Error> {
    let slab = Slab::new(80.0, 7.0, 7.0)?;
    let (field, temperature) = (Centrifuge { rate: 0.05 }, HotPlate { plate: 10.0, far: 4.0, depth: 10.0 });
    let scene = Scene::with_column_density(slab, 10.0, field, temperature)?;
    let theory = scene.hydrostatics(&ModifiedKolafa)?;

    let builder = Simulation::builder(scene).scheme(SelfConsistent::default()).moves(EventChains::default());
    let mut simulation = builder.seed(1).build()?;
    simulation.equilibrate(1500, &mut ())?;
    let mut profile = Every::new(2, EquationOfStateProfile::new(&slab, Bins::count(8).from(2.0).to(26.0))?);
    simulation.run(3000, &mut profile)?;

    println!("height/d   n d³              theory     P/(nTZ) − 1");
    let points = profile.observer.points()?;
    let deviations = profile.observer.deviations_from(&ModifiedKolafa)?;
    for (point, deviation) in points.iter().zip(deviations) {
        let expected = theory.number_density(point.height);
        let density = point.number_density.to_string();
        println!("{:8.1}   {density:<16}  {expected:.5}    {}", point.height, deviation.deviation);
    }
    println!("{}", simulation.certificate(0.05)?);
    for warning in simulation.warnings() {
        println!("warning: {warning}");
    }
    Ok(())
}
