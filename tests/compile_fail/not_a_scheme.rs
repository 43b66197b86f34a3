//! A type that is not a scheme: the compiler prints the hint.

use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::ExponentialTemperature};

struct MyScheme;

fn main() -> Result<(), gradient_mc::Error> {
    let temperature = ExponentialTemperature::new(5.0, 0.02)?;
    let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 360, UniformField::default(), temperature)?;
    let _simulation = Simulation::builder(scene).scheme(MyScheme).build()?;
    Ok(())
}
