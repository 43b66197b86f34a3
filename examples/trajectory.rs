//! A column that falls, as a trajectory for OVITO: `cargo run --release --example trajectory`.
//!
//! Writes `out/trajectory/column.xyz`, or the file that is named as an argument.

use gradient_mc::field::UniformField;
use gradient_mc::observers::ExtendedXyz;
use gradient_mc::start::RandomInsertion;
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Every, Scene, Simulation, Slab};
use std::error::Error;
use std::fs::{self, File};

fn main() -> Result<(), Box<dyn Error>> {
    let slab = Slab::new(80.0, 8.0, 7.5)?;
    let scene = Scene::with_column_density(slab, 8.0, UniformField::default(), Isothermal::new(2.0)?)?;

    fs::create_dir_all("out/trajectory")?;
    let path = std::env::args().nth(1).unwrap_or_else(|| "out/trajectory/column.xyz".to_owned());
    let mut trajectory = Every::new(10, ExtendedXyz::new(File::create(&path)?));
    let mut simulation = Simulation::builder(scene).start(RandomInsertion::default()).seed(1).build()?;
    simulation.run(500, &mut trajectory)?;
    println!("50 frames in {path}");
    Ok(())
}
