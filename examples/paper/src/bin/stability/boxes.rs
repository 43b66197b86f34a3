//! The box: how wide, how high.

use crate::column::{self, Length, run, theory};
use crate::map::{Findings, Map, Trial};
use gradient_mc::Simulation;
use gradient_mc::field::UniformField;
use gradient_mc::moves::{EventChains, LocalMoves};
use gradient_mc::temperature::Isothermal;
use paper::Failure;

/// The lateral box.
pub(crate) fn widths() -> Map {
    const WIDTHS: [f64; 6] = [3.0, 3.5, 4.0, 5.0, 6.0, 8.0];
    let mut map = Map::new("lateral_box", "Lateral box", "width of the base / d");
    for (temperature, range) in [(20.0, [4.0, 40.0]), (5.0, [4.0, 16.0]), (3.0, [20.0, 26.0])] {
        for width in WIDTHS {
            map.add(&format!("T = {temperature}"), width, move |trial| {
                wide(temperature, range, width, trial)
            });
        }
    }
    map
}

fn wide(temperature: f64, range: [f64; 2], width: f64, trial: Trial) -> Result<Findings, Failure> {
    let scene = column::scene(260.0, width, 40.0, UniformField::default(), Isothermal::new(temperature)?)?;
    // As many sphere sweeps everywhere; the narrower the box, the more the column fluctuates.
    let sweeps = paper::study::count((80_000.0 / (width * width)).floor()) as u64;
    let length = Length { equilibration: 500 + sweeps / 4, sweeps };
    let simulation = Simulation::builder(scene).moves(EventChains::default()).seed(trial.seed).build()?;
    let run = run(simulation, length, trial)?;
    let center = run.center_of_mass(theory(&scene)?.center_of_mass(), 0.03)?.tolerating(0.003, 0.005);
    let equation_of_state = run.equation_of_state(range)?.tolerating(0.01, 0.02);
    Ok(run.with([center, equation_of_state]))
}

/// The height of the lid.
pub(crate) fn lids() -> Map {
    const HEIGHTS: [f64; 7] = [15.0, 25.0, 40.0, 70.0, 100.0, 150.0, 250.0];
    let mut map = Map::new("lid", "Height of the lid", "height of the lid / d");
    for (label, told) in [("P(lid) left out", false), ("P(lid) from the theory", true)] {
        for height in HEIGHTS {
            map.add(label, height, move |trial| lid(height, told, trial));
        }
    }
    map
}

fn lid(height: f64, told: bool, trial: Trial) -> Result<Findings, Failure> {
    let scene = column::scene(height, 5.0, 10.0, UniformField::default(), Isothermal::new(20.0)?)?;
    let builder = Simulation::builder(scene).moves(LocalMoves::tuned()).seed(trial.seed);
    let mut run = run(builder.build()?, Length { equilibration: 3000, sweeps: 12_000 }, trial)?;
    let theory = theory(&scene)?;
    if told {
        run.profile.set_open_end_pressure(theory.lid_pressure())?;
    }
    let center = run.center_of_mass(theory.center_of_mass(), 0.03)?;
    let equation_of_state = run.equation_of_state([4.0, 12.0])?;
    Ok(run.with([center, equation_of_state]))
}
