//! Trajectories of a column that relaxes, for OVITO and others: `cargo run --release --example
//! trajectory`.
//!
//! Writes `column.xyz` and `column.gsd` to `out/trajectory`, or to the folder given as argument,
//! and starts another run from the last frame.

use gradient_mc::field::UniformField;
use gradient_mc::observers::{ExtendedXyz, Gsd};
use gradient_mc::start::{RandomInsertion, TrajectoryFrame};
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Every, Scene, Simulation, Slab};
use std::error::Error;
use std::fs::{self, File};
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let slab = Slab::new(80.0, 8.0, 7.5)?;
    let scene = Scene::with_column_density(slab, 8.0, UniformField::default(), Isothermal::new(2.0)?)?;

    let folder = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "out/trajectory".to_owned()));
    fs::create_dir_all(&folder)?;
    let (text, binary) = (folder.join("column.xyz"), folder.join("column.gsd"));
    // Removes the file of an earlier run.
    fs::remove_file(&binary).ok();
    let mut trajectory = Every::new(10, (ExtendedXyz::new(File::create(&text)?), Gsd::open(&binary)?));
    let mut simulation = Simulation::builder(scene).start(RandomInsertion::default()).seed(1).build()?;
    simulation.run(500, &mut trajectory)?;
    println!("50 frames in {} and {}", text.display(), binary.display());

    // Another run from the last frame; both formats are exact.
    let start = TrajectoryFrame::last(&binary)?;
    let again = Simulation::builder(scene).start(start).seed(2).build()?;
    assert_eq!(again.positions(), simulation.positions());
    Ok(())
}
