//! Your own field, temperature profile, equation of state and observer in one run: a centrifuge
//! heated from below, compared with theory. `cargo run --release --example own_parts`

use gradient_mc::observers::{Bins, EquationOfStateProfile};
use gradient_mc::{EquationOfState, Error, Field, Frame, Observer, ObserverError, TemperatureProfile};
use gradient_mc::{Every, Scene, Simulation, Slab};

/// a(x) = 1 + x/20: the potential is its integral.
struct Centrifuge;
impl Field for Centrifuge {
    fn potential(&self, height: f64) -> f64 {
        height + height * height / 40.0
    }
}

/// T decreases from 10 at the base to 4 far above.
struct HotPlate;
impl TemperatureProfile for HotPlate {
    fn temperature(&self, height: f64) -> f64 {
        4.0 + 6.0 / (1.0 + height / 10.0)
    }
}

/// Carnahan and Starling, doi:10.1063/1.1672048.
struct CarnahanStarling;
impl EquationOfState for CarnahanStarling {
    fn compressibility_factor(&self, eta: f64) -> f64 {
        (1.0 + eta + eta * eta - eta * eta * eta) / ((1.0 - eta) * (1.0 - eta) * (1.0 - eta))
    }
}

/// The largest height of any sphere so far.
struct Highest(f64);
impl Observer for Highest {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.0 = frame.heights().fold(self.0, f64::max);
        Ok(())
    }
}

fn main() -> Result<(), Error> {
    let slab = Slab::new(80.0, 7.0, 7.0)?;
    let scene = Scene::with_column_density(slab, 10.0, &Centrifuge, &HotPlate)?;
    let theory = scene.hydrostatics(&CarnahanStarling)?;
    let mut simulation = Simulation::builder(scene).seed(1).build()?;
    simulation.equilibrate(1500, &mut ())?;
    let bins = Bins::of_width(3.0).from(2.0).to(26.0);
    let mut observers = (Every::new(2, EquationOfStateProfile::new(&slab, bins)?), Highest(0.0));
    simulation.run(3000, &mut observers)?;
    let (profile, highest) = (&observers.0.observer, observers.1.0);
    println!("height/d   n d³ (simulation)  n d³ (theory)  P/(nTZ) - 1");
    for (point, state) in profile.points()?.iter().zip(profile.deviations_from(&CarnahanStarling)?) {
        let expected = theory.number_density(point.height);
        let density = point.number_density.to_string();
        println!("{:8.1}   {density:<17}  {expected:<13.5}  {}", point.height, state.deviation);
    }
    println!("highest sphere: {highest:.1} d\n{}", simulation.certificate(0.05)?);
    simulation.warnings().iter().for_each(|warning| println!("warning: {warning}"));
    Ok(())
}
