//! Columns near and beyond freezing: low temperatures, steep fields and temperatures.

use crate::column::{self, Length, run, theory};
use crate::map::{Findings, Map, Trial};
use gradient_mc::drive::SelfConsistent;
use gradient_mc::field::{ExponentialField, UniformField};
use gradient_mc::moves::EventChains;
use gradient_mc::start::{ClosePacked, RandomInsertion, Start, Theory};
use gradient_mc::temperature::{ExponentialTemperature, Isothermal};
use gradient_mc::{Field, Simulation};
use paper::Failure;

const COLUMN_DENSITY: f64 = 40.0;
const WIDTH: f64 = 5.0;

fn isothermal(
    field: impl Field + Copy,
    temperature: f64,
    start: impl Start + 'static,
    height: f64,
    trial: Trial,
) -> Result<Findings, Failure> {
    let scene = column::scene(height, WIDTH, COLUMN_DENSITY, field, Isothermal::new(temperature)?)?;
    let builder = Simulation::builder(scene).start(start).moves(EventChains::default()).seed(trial.seed);
    let run = run(builder.build()?, Length { equilibration: 800, sweeps: 1000 }, trial)?;
    // The equation of state of the solid is good to half a per cent.
    let center = run.center_of_mass(theory(&scene)?.center_of_mass(), 0.03)?;
    Ok(run.with([center.tolerating(0.005, 0.005)]))
}

/// T₀ down to glass and crystal.
pub(crate) fn cold() -> Map {
    const TEMPERATURES: [f64; 8] = [20.0, 10.0, 6.0, 4.0, 3.5, 3.0, 2.0, 1.0];
    let mut map =
        Map::new("cold", "Colder columns: uniform field, freezing below T = 3.46", "temperature T / mgd");
    for temperature in TEMPERATURES {
        map.add("from above", temperature, move |trial| {
            isothermal(UniformField::default(), temperature, RandomInsertion::new(0.3)?, 250.0, trial)
        });
        map.add("from below", temperature, move |trial| {
            isothermal(UniformField::default(), temperature, ClosePacked, 250.0, trial)
        });
        map.add("theory start", temperature, move |trial| {
            isothermal(UniformField::default(), temperature, Theory, 250.0, trial)
        });
    }
    map
}

/// α up to and past freezing.
pub(crate) fn fields() -> Map {
    const RATES: [f64; 6] = [0.0, 0.02, 0.05, 0.07, 0.1, 0.2];
    let mut map = Map::new(
        "field_rate",
        "Fields that increase with height: a = exp(αx), T = 20",
        "rate α of the field",
    );
    for rate in RATES {
        map.add("from above", rate, move |trial| {
            isothermal(ExponentialField::new(rate)?, 20.0, RandomInsertion::new(0.3)?, 140.0, trial)
        });
        map.add("from below", rate, move |trial| {
            isothermal(ExponentialField::new(rate)?, 20.0, ClosePacked, 140.0, trial)
        });
        map.add("theory start", rate, move |trial| {
            isothermal(ExponentialField::new(rate)?, 20.0, Theory, 140.0, trial)
        });
    }
    map
}

/// β up to and past freezing.
pub(crate) fn temperatures() -> Map {
    const RATES: [f64; 6] = [0.02, 0.05, 0.07, 0.1, 0.15, 0.2];
    let mut map = Map::new(
        "temperature_rate",
        "Temperatures that decrease with height: T = 20 exp(−βx), self-consistent field",
        "decay rate β of the temperature",
    );
    for rate in RATES {
        map.add("from above", rate, move |trial| cooling(rate, RandomInsertion::new(0.3)?, trial));
        map.add("from below", rate, move |trial| cooling(rate, ClosePacked, trial));
    }
    map
}

fn cooling(rate: f64, start: impl Start + 'static, trial: Trial) -> Result<Findings, Failure> {
    let temperature = ExponentialTemperature::new(20.0, rate)?;
    let scene = column::scene(140.0, WIDTH, COLUMN_DENSITY, UniformField::default(), temperature)?;
    let builder = Simulation::builder(scene).scheme(SelfConsistent::default()).start(start);
    let simulation = builder.moves(EventChains::default()).seed(trial.seed).build()?;
    let run = run(simulation, Length { equilibration: 1200, sweeps: 1200 }, trial)?;
    let theory = theory(&scene)?;
    let center = run.center_of_mass(theory.center_of_mass(), 0.05)?.tolerating(0.01, 0.01);
    // Above the layers at the base and below the steep top.
    let equation_of_state = run.equation_of_state([8.0, 0.7 * theory.density_maximum().0.max(16.0)])?;
    Ok(run.with([center, equation_of_state.tolerating(0.015, 0.015)]))
}
