//! Scenes chosen at run time: different fields and temperatures in one `Vec`, each on its own
//! thread.
//!
//! ```sh
//! cargo run --release --example scene_at_run_time
//! cargo run --release --example scene_at_run_time -- exponential:0.02 linear:5:-0.03
//! ```

use gradient_mc::field::{ExponentialField, LinearField, UniformField};
use gradient_mc::observers::CenterOfMass;
use gradient_mc::temperature::{ExponentialTemperature, Isothermal, LinearTemperature};
use gradient_mc::{Error, Field, Scene, Simulation, Slab, TemperatureProfile};
use std::process::ExitCode;

type ChosenScene = Scene<Box<dyn Field>, Box<dyn TemperatureProfile>>;

/// A field by its name and numbers: `uniform:1`, `exponential:0.02`, `linear:1:0.05`.
fn field(text: &str) -> Result<Box<dyn Field>, Box<dyn std::error::Error>> {
    Ok(match parts(text)? {
        ("uniform", [acceleration, ..]) => Box::new(UniformField::new(acceleration)?),
        ("exponential", [rate, ..]) => Box::new(ExponentialField::new(rate)?),
        ("linear", [base, slope]) => Box::new(LinearField::new(base, slope)?),
        (name, _) => return Err(format!("unknown field {name}: use uniform, exponential or linear").into()),
    })
}

/// A temperature by its name and numbers: `isothermal:5`, `exponential:5:0.02`, `linear:5:-0.03`.
fn temperature(text: &str) -> Result<Box<dyn TemperatureProfile>, Box<dyn std::error::Error>> {
    Ok(match parts(text)? {
        ("isothermal", [temperature, ..]) => Box::new(Isothermal::new(temperature)?),
        ("exponential", [base, rate]) => Box::new(ExponentialTemperature::new(base, rate)?),
        ("linear", [base, slope]) => Box::new(LinearTemperature::new(base, slope)?),
        (name, _) => {
            return Err(format!("unknown temperature {name}: use isothermal, exponential or linear").into());
        }
    })
}

/// The name and up to two numbers; missing numbers are 0.
fn parts(text: &str) -> Result<(&str, [f64; 2]), std::num::ParseFloatError> {
    let mut parts = text.split(':');
    let name = parts.next().unwrap_or_default();
    let mut number = || parts.next().map_or(Ok(0.0), str::parse);
    Ok((name, [number()?, number()?]))
}

/// One line about a scene: mean height of its center of mass, and whether its effective field is
/// self-consistent.
fn measure(scene: ChosenScene) -> Result<String, Error> {
    let mut simulation = Simulation::builder(scene).seed(1).build()?;
    let mut center_of_mass = CenterOfMass::new();
    simulation.equilibrate(500, &mut ())?;
    simulation.run(1000, &mut center_of_mass)?;
    Ok(format!("{}; {}", center_of_mass.estimate()?, simulation.certificate(0.1)?))
}

fn main() -> Result<ExitCode, Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut names: Vec<[&str; 2]> = arguments.chunks_exact(2).map(|pair| [&*pair[0], &*pair[1]]).collect();
    if names.is_empty() {
        names.push(["uniform:1", "isothermal:5"]);
        names.push(["exponential:0.02", "isothermal:5"]);
        names.push(["uniform:1", "exponential:5:0.02"]);
    }
    let slab = Slab::new(60.0, 6.0, 6.0)?;
    let mut scenes = Vec::new();
    for [of_field, of_temperature] in &names {
        scenes.push(Scene::new(slab, 360, field(of_field)?, temperature(of_temperature)?)?);
    }
    let lines: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = scenes.into_iter().map(|scene| scope.spawn(|| measure(scene))).collect();
        threads.into_iter().map(|thread| thread.join().expect("no panic")).collect()
    });
    for (name, line) in names.iter().zip(lines) {
        println!("{}, {}: center of mass {}", name[0], name[1], line?);
    }
    Ok(ExitCode::SUCCESS)
}
