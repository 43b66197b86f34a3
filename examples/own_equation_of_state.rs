//! Your own equation of state: Z up to the third virial coefficient, in one method. Derivative,
//! chemical potential and inverse are computed numerically. Prints the height of the center of mass
//! by hydrostatics with this equation and with the best equation, and by a simulation. `cargo run
//! --release --example own_equation_of_state`

use gradient_mc::equation_of_state::ModifiedKolafa;
use gradient_mc::field::UniformField;
use gradient_mc::moves::EventChains;
use gradient_mc::observers::CenterOfMass;
use gradient_mc::temperature::Isothermal;
use gradient_mc::{EquationOfState, Error, Scene, Simulation, Slab};

/// Z = 1 + 4η + 10η²: exact in the dilute limit, too small at high density.
#[derive(Clone, Copy)]
struct ThreeVirialCoefficients;

impl EquationOfState for ThreeVirialCoefficients {
    fn compressibility_factor(&self, packing_fraction: f64) -> f64 {
        1.0 + packing_fraction * (4.0 + 10.0 * packing_fraction)
    }
}

fn main() -> Result<(), Error> {
    println!("N/A d²   height of the center of mass/d");
    println!("         three coefficients   best equation   simulation");
    let slab = Slab::new(120.0, 6.0, 6.0)?;
    let temperature = Isothermal::new(5.0)?;
    for particles in [36, 108, 360] {
        let scene = Scene::new(slab, particles, UniformField::default(), temperature)?;
        let spheres = scene.column_density();
        let own = scene.hydrostatics(&ThreeVirialCoefficients)?;
        let best = scene.hydrostatics(&ModifiedKolafa)?;

        let mut simulation = Simulation::builder(scene).moves(EventChains::default()).seed(1).build()?;
        let mut center_of_mass = CenterOfMass::new();
        simulation.equilibrate(500, &mut ())?;
        simulation.run(20_000, &mut center_of_mass)?;
        println!(
            "{spheres:6.1}   {:18.3}   {:13.3}   {}",
            own.center_of_mass(),
            best.center_of_mass(),
            center_of_mass.estimate()?
        );
        // Theory profiles give warnings too, for example for a density outside the domain of the
        // equation.
        let mut warnings = simulation.warnings();
        warnings.extend(own.warnings());
        for warning in warnings {
            println!("  warning: {warning}");
        }
    }
    Ok(())
}
