//! Your own observer, with its own error type: the density of spheres in contact with the base. By
//! the contact theorem n(½⁺) T = N/A exactly in a uniform field, because the base carries the whole
//! column. `cargo run --release --example own_observer`

use gradient_mc::field::UniformField;
use gradient_mc::statistics::BlockAverages;
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Error, Frame, Observer, ObserverError, Scene, Simulation, Slab, moves::LocalMoves};
use std::fmt;

/// Thickness of a layer in diameters, much smaller than the decay length of the density at the
/// wall.
const LAYER: f64 = 0.05;

/// Densities of three thin layers next to contact with the base.
struct LayersAtBase {
    base_area: f64,
    densities: BlockAverages,
}

/// The error of this observer.
#[derive(Debug)]
struct AnotherSlab;

impl fmt::Display for AnotherSlab {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "the observer was made for another base")
    }
}

impl std::error::Error for AnotherSlab {}

impl Observer for LayersAtBase {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        if (frame.slab().base_area() - self.base_area).abs() > 0.0 {
            return Err(AnotherSlab.into());
        }
        let mut densities = [0.0; 3];
        for height in frame.heights() {
            let above = height - frame.slab().lowest_center();
            for (layer, density) in densities.iter_mut().enumerate() {
                let low = layer as f64 * LAYER;
                if (low..low + LAYER).contains(&above) {
                    *density += 1.0 / (self.base_area * LAYER);
                }
            }
        }
        Ok(self.densities.push(&densities)?)
    }
}

fn main() -> Result<(), Error> {
    println!("T/mgd   n(½⁺) d³ measured   N/(AT)   difference in standard errors");
    for temperature in [5.0, 8.0] {
        let slab = Slab::new(150.0, 6.0, 6.0)?;
        let scene = Scene::new(slab, 360, UniformField::default(), Isothermal::new(temperature)?)?;
        let mut simulation = Simulation::builder(scene).moves(LocalMoves::tuned()).seed(1).build()?;
        let mut layers = LayersAtBase { base_area: slab.base_area(), densities: BlockAverages::new(3)? };
        simulation.equilibrate(2000, &mut ())?;
        simulation.run(100_000, &mut layers)?;

        // The parabola with these means, extrapolated to contact. The jackknife gives its error,
        // because the layers are correlated.
        let at_wall = |mean: &[f64]| [(11.0 * mean[0] - 7.0 * mean[1] + 2.0 * mean[2]) / 6.0];
        let contact = layers.densities.jackknife(at_wall)?[0];
        let exact = scene.column_density() / temperature;
        let off = contact.deviation_from(exact);
        println!("{temperature:5.1}   {:<17}   {exact:.4}   {off:+.1}", contact.to_string());
        for warning in simulation.warnings() {
            println!("  warning: {warning}");
        }
    }
    Ok(())
}
