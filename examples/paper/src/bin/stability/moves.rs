//! Moves: size of local moves, length of chains, jammed starts.

use crate::column::{self, Length, run, theory};
use crate::map::{Findings, Map, Trial};
use gradient_mc::field::UniformField;
use gradient_mc::moves::{EventChains, FieldEvent, LocalMoves, Moves};
use gradient_mc::start::{Positions, RandomInsertion, Start, Theory};
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Scene, Simulation, Slab, Vector3};
use paper::Failure;

/// The paper's column over a small base.
const COLUMN_DENSITY: f64 = 40.0;
const HEIGHT: f64 = 400.0;
const WIDTH: f64 = 5.0;

fn from_start(
    temperature: f64,
    start: impl Start + 'static,
    moves: impl Into<Moves>,
    length: Length,
    trial: Trial,
) -> Result<Findings, Failure> {
    let scene =
        column::scene(HEIGHT, WIDTH, COLUMN_DENSITY, UniformField::default(), Isothermal::new(temperature)?)?;
    let run =
        run(Simulation::builder(scene).start(start).moves(moves).seed(trial.seed).build()?, length, trial)?;
    // Theory between walls is within 0.03 of long runs.
    let center = run.center_of_mass(theory(&scene)?.center_of_mass(), 0.02)?;
    // The dense part, which large moves do not move.
    let equation_of_state = run.equation_of_state([4.0, 14.0])?.tolerating(0.015, 0.03);
    Ok(run.with([center, equation_of_state]))
}

/// The size S of local moves.
pub(crate) fn sizes() -> Map {
    const SIZES: [f64; 8] = [0.003, 0.03, 0.1, 0.3, 0.75, 1.5, 2.5, 3.0];
    const LENGTH: Length = Length { equilibration: 6000, sweeps: 6000 };
    let mut map =
        Map::new("local_moves", "Local moves: largest displacement S", "maximum displacement S / d");
    for temperature in [20.0, 5.0] {
        let from_above = format!("T = {temperature}, from above");
        for size in SIZES {
            map.add(&from_above, size, move |trial| {
                from_start(temperature, RandomInsertion::default(), LocalMoves::new(size)?, LENGTH, trial)
            });
        }
        map.add_labeled(&from_above, 10.0, "tuned", move |trial| {
            from_start(temperature, RandomInsertion::default(), LocalMoves::tuned(), LENGTH, trial)
        });
    }
    for size in SIZES {
        map.add("T = 5, theory start", size, move |trial| {
            from_start(5.0, Theory, LocalMoves::new(size)?, LENGTH, trial)
        });
    }
    map.add_labeled("T = 5, theory start", 10.0, "tuned", |trial| {
        from_start(5.0, Theory, LocalMoves::tuned(), LENGTH, trial)
    });
    map
}

/// The length of event chains.
pub(crate) fn chain_lengths() -> Map {
    const LENGTHS: [f64; 6] = [1.0, 10.0, 100.0, 1e3, 1e4, 1e6];
    const LENGTH: Length = Length { equilibration: 1500, sweeps: 2000 };
    let mut map = Map::new("chain_length", "Event chains: mean length", "mean length of chains / d");
    let mut row = |label: &str, temperature: f64, event: FieldEvent, local: bool| {
        let chains = move |length: Option<f64>| -> Result<Moves, gradient_mc::Error> {
            let chains = length.map_or(Ok(EventChains::default()), EventChains::with_length)?;
            let chains = chains.field_event(event);
            Ok(if local { chains.into() } else { chains.local_moves(None).into() })
        };
        for length in LENGTHS {
            map.add(label, length, move |trial| {
                from_start(temperature, RandomInsertion::default(), chains(Some(length))?, LENGTH, trial)
            });
        }
        map.add_labeled(label, 1e9, "tuned", move |trial| {
            from_start(temperature, RandomInsertion::default(), chains(None)?, LENGTH, trial)
        });
    };
    row("T = 20, relocate", 20.0, FieldEvent::Relocate, true);
    row("T = 20, reverse", 20.0, FieldEvent::Reverse, true);
    row("T = 20, chains alone", 20.0, FieldEvent::Relocate, false);
    row("T = 5, relocate", 5.0, FieldEvent::Relocate, true);
    map
}

/// Spheres that all but touch, at the beginning of a chain.
pub(crate) fn jams() -> Map {
    const GAPS: [f64; 6] = [1e-2, 1e-3, 1e-5, 1e-7, 1e-9, 0.0];
    let mut map = Map::new("jammed_start", "Event chains: a lattice whose spheres nearly touch", "gap / d");
    for (label, equilibration) in [("measured at once", 0), ("after 300 sweeps", 300)] {
        for gap in GAPS {
            map.add(label, gap, move |trial| jam(gap, equilibration, trial));
        }
    }
    map
}

/// A simple cubic lattice whose gaps close up across the width.
fn jam(gap: f64, equilibration: u64, trial: Trial) -> Result<Findings, Failure> {
    const SIDE: u32 = 5;
    const LAYERS: u32 = 8;
    const TEMPERATURE: f64 = 2.0;
    let spacing = 1.0 + gap;
    let slab = Slab::new(40.0, f64::from(SIDE) * spacing, f64::from(SIDE) * spacing)?;
    let at = |index: u32| (f64::from(index) + 0.25) * spacing;
    let lattice: Vec<Vector3<f64>> = (0..LAYERS)
        .flat_map(|layer| (0..SIDE).flat_map(move |row| (0..SIDE).map(move |column| (layer, row, column))))
        .map(|(layer, row, column)| Vector3::new(0.5 + f64::from(layer) * spacing, at(row), at(column)))
        .collect();
    let temperature = Isothermal::new(TEMPERATURE)?;
    let scene = Scene::new(slab, lattice.len(), UniformField::default(), temperature)?;
    let chains = EventChains::with_length(10.0)?.local_moves(None);
    let builder = Simulation::builder(scene).start(Positions(lattice)).moves(chains).seed(trial.seed);
    let run = run(builder.build()?, Length { equilibration, sweeps: 4000 }, trial)?;
    let center = run.center_of_mass(theory(&scene)?.center_of_mass(), 0.03)?;
    Ok(run.with([center.tolerating(0.01, 0.02)]))
}
