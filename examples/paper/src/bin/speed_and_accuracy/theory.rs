//! The methods without a simulation.

use crate::column::particles;
use crate::point::{Point, Way};
use crate::profile::{BINS, COLUMN_DENSITY, Errors, HEIGHT, Profile, middle};
use crate::reference::Reference;
use crate::system::System;
use gradient_mc::equation_of_state::{
    CarnahanStarling, EquationOfState, FluidSolid, IdealGas, ModifiedKolafa, PercusYevickCompressibility,
    PercusYevickVirial, SpeedySolid, VirialSeries,
};
use gradient_mc::model::{Accuracy, Model};
use gradient_mc::{Error, HydrostaticProfile, Hydrostatics, Scene, Slab};
use paper::Failure;
use paper::accuracy::BIN_HEIGHT;
use paper::clock::cpu_seconds;

/// A theory without a result, and the reason.
#[derive(Debug)]
pub(crate) struct Refusal {
    pub(crate) system: System,
    pub(crate) name: String,
    pub(crate) reason: String,
}

/// All theories of a system.
pub(crate) fn points(
    system: System,
    reference: &Reference,
    refusals: &mut Vec<Refusal>,
) -> Result<Vec<Point>, Failure> {
    let slab = Slab::new(HEIGHT, 25.0, 25.0)?;
    let (field, temperature) = (system.field()?, system.temperature()?);
    let series = VirialSeries::default();
    let fluid_solid = FluidSolid::default();
    let equations: [(&str, &dyn EquationOfState); 8] = [
        ("ideal gas", &IdealGas),
        ("Carnahan-Starling", &CarnahanStarling),
        ("modified Kolafa", &ModifiedKolafa),
        ("Percus-Yevick, compressibility", &PercusYevickCompressibility),
        ("Percus-Yevick, virial", &PercusYevickVirial),
        ("virial series", &series),
        ("fluid and solid", &fluid_solid),
        ("Speedy's solid", &SpeedySolid),
    ];
    let claims = Claims::new(system, slab)?;
    let mut points = Vec::new();
    let mut add = |name: String, walls: bool, solve: &dyn Fn() -> Result<Profile, Error>| {
        let point = |(seconds, profile): (f64, Profile)| Point {
            way: Way::Theory { name: name.clone(), walls },
            seconds,
            errors: profile.errors(&reference.profile),
            claims: claims.of(&name, walls),
        };
        match timed(solve) {
            Ok(timed) => points.push(point(timed)),
            Err(error) => refusals.push(Refusal { system, name, reason: error.to_string() }),
        }
    };
    add("ideal gas, closed form".to_owned(), false, &|| Ok(ideal_gas(system)));
    for (name, equation) in equations {
        let theory = Hydrostatics::new(&field, &temperature, equation);
        let name = format!("hydrostatics, {name}");
        add(name.clone(), false, &|| Ok(binned(&theory.column_density(COLUMN_DENSITY)?)));
        add(name, true, &|| Ok(binned(&theory.between_walls(&slab, COLUMN_DENSITY)?)));
    }
    Ok(points)
}

/// What [`Scene::model_for`] expects of the theories that it considers.
struct Claims {
    ideal_gas: Option<Errors>,
    /// Between walls, with the equation of state of fluid and solid, whose fluid is the modified
    /// Kolafa equation.
    hydrostatics: Option<Errors>,
}

impl Claims {
    fn new(system: System, slab: Slab) -> Result<Self, Failure> {
        let scene = Scene::new(slab, particles(slab.widths()[0]), system.field()?, system.temperature()?)?;
        // What it expects does not depend on the tolerance.
        let choice = scene.model_for(Accuracy::density(0.01)?)?;
        let (mut ideal_gas, mut hydrostatics) = (None, None);
        for candidate in choice.candidates() {
            // P is said to be no further off in a uniform field; of the rest nothing is said.
            let pressure = if system.field_rate() > 0.0 { f64::NAN } else { candidate.expected_error };
            let claim = Errors {
                misplaced: candidate.expected_error,
                pressure,
                bulk_density: f64::NAN,
                bulk_pressure: f64::NAN,
                center_of_mass: f64::NAN,
            };
            match candidate.model {
                Model::IdealGas(_) => ideal_gas = Some(claim),
                Model::Hydrostatics(_) => hydrostatics = Some(claim),
                _ => {}
            }
        }
        Ok(Self { ideal_gas, hydrostatics })
    }

    fn of(&self, name: &str, walls: bool) -> Option<Errors> {
        match (name, walls) {
            ("ideal gas, closed form", _) => self.ideal_gas,
            ("hydrostatics, modified Kolafa" | "hydrostatics, fluid and solid", true) => self.hydrostatics,
            _ => None,
        }
    }
}

/// A profile in bins.
pub(crate) fn binned(theory: &HydrostaticProfile) -> Profile {
    let mut below = theory.column_below(0.0);
    let density = (0..BINS)
        .map(|bin| {
            let next = theory.column_below((bin + 1) as f64 * BIN_HEIGHT);
            let mean = (next - below) / BIN_HEIGHT;
            below = next;
            mean
        })
        .collect();
    let pressure = (0..BINS).map(|bin| theory.pressure(middle(bin))).collect();
    Profile { density, pressure, center_of_mass: theory.center_of_mass(), ..Profile::default() }
}

/// Equations (10) and (28) of doi:10.1103/PhysRevE.83.061306 at the middles of the bins, normalized
/// to N/A: n ∝ exp(−(e^{(α+β)x} − 1)/((α+β) T₀) + βx), P = n T.
fn ideal_gas(system: System) -> Profile {
    let (temperature, beta) = (system.base_temperature(), system.temperature_decay());
    let rate = system.field_rate() + beta;
    let weight = |x: f64| if rate == 0.0 { x } else { libm::expm1(rate * x) / rate };
    let shape: Vec<f64> =
        (0..BINS).map(middle).map(|x| libm::exp(beta * x - weight(x) / temperature)).collect();
    let factor = COLUMN_DENSITY / (shape.iter().sum::<f64>() * BIN_HEIGHT);
    let density: Vec<f64> = shape.iter().map(|shape| factor * shape).collect();
    let temperature_at = |bin: usize| temperature * libm::exp(-beta * middle(bin));
    let pressure = density.iter().enumerate().map(|(bin, density)| density * temperature_at(bin)).collect();
    let moment: f64 = density.iter().enumerate().map(|(bin, density)| density * middle(bin)).sum();
    let center_of_mass = moment * BIN_HEIGHT / COLUMN_DENSITY;
    Profile { density, pressure, center_of_mass, ..Profile::default() }
}

/// A result and the CPU seconds that it takes: the median over as many repeats as fit a tenth of a
/// second.
fn timed(solve: &dyn Fn() -> Result<Profile, Error>) -> Result<(f64, Profile), Error> {
    const ENOUGH: f64 = 0.1;
    const FEWEST: usize = 5;
    let profile = solve()?;
    let mut times = Vec::new();
    while times.len() < FEWEST || times.iter().sum::<f64>() < ENOUGH {
        let start = cpu_seconds();
        std::hint::black_box(solve()?);
        times.push(cpu_seconds() - start);
    }
    times.sort_by(f64::total_cmp);
    Ok((times[times.len() / 2], profile))
}
