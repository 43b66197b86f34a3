//! Fields and temperatures with jumps or spikes.

use crate::column::{self, Length, run, theory};
use crate::map::{Findings, Map, Trial};
use crate::said;
use crate::verdict::Quantity;
use gradient_mc::drive::SelfConsistent;
use gradient_mc::field::{FieldFn, UniformField};
use gradient_mc::moves::{EventChains, LocalMoves, Moves};
use gradient_mc::statistics::blocking;
use gradient_mc::temperature::{Isothermal, TabulatedTemperature, TemperatureFn};
use gradient_mc::{
    Every, Field, Frame, Observer, ObserverError, Scene, Simulation, Slab, TemperatureProfile,
};
use paper::Failure;

/// Where it happens.
const STEP: f64 = 4.0;
/// Of the single sphere.
const TEMPERATURE: f64 = 2.0;
const HEIGHT: f64 = 30.0;

/// Widths over which something changes; zero is a jump.
const WIDTHS: [f64; 7] = [3.0, 1.0, 0.3, 0.1, 0.01, 0.001, 0.0];

fn local() -> Result<Moves, gradient_mc::Error> {
    Ok(LocalMoves::mixture(&[0.5, 1.5])?.into())
}

#[allow(clippy::unnecessary_wraps, reason = "same signature as the other constructor")]
fn chains() -> Result<Moves, gradient_mc::Error> {
    Ok(EventChains::default().into())
}

/// From 0 to 1 over the width around the step, linearly.
fn ramp(height: f64, width: f64) -> f64 {
    if width > 0.0 {
        ((height - STEP) / width + 0.5).clamp(0.0, 1.0)
    } else {
        f64::from(u8::from(height >= STEP))
    }
}

/// Spheres above the step, as a fraction, frame by frame.
#[derive(Default)]
struct Above(Vec<f64>);

impl Observer for Above {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        let above = frame.heights().filter(|&height| height > STEP).count();
        self.0.push(above as f64 / frame.particles() as f64);
        Ok(())
    }
}

/// Gravity, and a push of one temperature where the field rises over a narrow range.
struct Barrier {
    width: f64,
}

impl Field for Barrier {
    fn potential(&self, height: f64) -> f64 {
        height + TEMPERATURE * ramp(height, self.width)
    }
}

/// A step in the field or in the potential, seen by one sphere, for which everything is known
/// exactly.
pub(crate) fn fields() -> Map {
    let mut map = Map::new(
        "field_step",
        "Field with a step or barrier of height T over a width, one sphere",
        "width of the step / d",
    );
    for width in WIDTHS {
        let place = if width > 0.0 { width } else { 1e-5 };
        let label = width.to_string();
        // From 1 to 3 over the width.
        let step = move |height: f64| 1.0 + 2.0 * ramp(height, width);
        let step_potential = move |height: f64| height + 2.0 * integral(height, width);
        let barrier = move |height: f64| Barrier { width }.potential(height);
        // One temperature, within the width; nothing to speak of beyond.
        let spike = move |height: f64| {
            let inside = (height - STEP).abs() < 0.5 * width;
            1.0 + if inside { TEMPERATURE / width } else { 0.0 }
        };
        for (name, moves) in [("local", local as Maker), ("chains", chains as Maker)] {
            let slab = || Slab::new(HEIGHT, 4.0, 4.0);
            map.add_labeled(&format!("step of a(x), {name}"), place, &label, move |trial| {
                one_sphere(FieldFn::new(step, &slab()?)?, step_potential, moves, trial)
            });
            map.add_labeled(&format!("barrier in φ(x), {name}"), place, &label, move |trial| {
                one_sphere(Barrier { width }, barrier, moves, trial)
            });
            if width > 0.0 {
                map.add_labeled(&format!("spike of a(x), {name}"), place, &label, move |trial| {
                    one_sphere(FieldFn::new(spike, &slab()?)?, barrier, moves, trial)
                });
            }
        }
    }
    map
}

type Maker = fn() -> Result<Moves, gradient_mc::Error>;

/// ∫ of the ramp.
fn integral(height: f64, width: f64) -> f64 {
    let within = ramp(height, width) * width;
    let beyond = (height - STEP - 0.5 * width).max(0.0);
    0.5 * within * ramp(height, width) + beyond
}

/// The part above the step against that of exp(−φ/T).
fn one_sphere(
    field: impl Field,
    potential: impl Fn(f64) -> f64,
    moves: Maker,
    trial: Trial,
) -> Result<Findings, Failure> {
    let slab = Slab::new(HEIGHT, 4.0, 4.0)?;
    let scene = Scene::new(slab, 1, field, Isothermal::new(TEMPERATURE)?)?;
    let moves = moves()?;
    let mut simulation = Simulation::builder(scene).moves(moves).seed(trial.seed).build()?;
    simulation.equilibrate(trial.sweeps(10_000), &mut ())?;
    let mut above = Every::new(10, Above::default());
    simulation.run(trial.sweeps(500_000), &mut above)?;
    let measured = blocking(&above.observer.0)?;
    let boltzmann = |height: f64| libm::exp(-(potential(height) - potential(STEP)) / TEMPERATURE);
    let (low, high) = (slab.lowest_center(), slab.highest_center());
    // The midpoint rule on a grid with the step at an edge.
    let sum = |from: f64, to: f64| {
        const PANELS: u32 = 200_000;
        let panel = (to - from) / f64::from(PANELS);
        (0..PANELS).map(|index| boltzmann(from + panel * (f64::from(index) + 0.5))).sum::<f64>() * panel
    };
    let (below, above) = (sum(low, STEP), sum(STEP, high));
    let truth = above / (above + below);
    let quantity = Quantity::relative("part above the step", measured, truth).tolerating(0.01, 0.05);
    Ok(Findings { quantities: vec![quantity], said: said::by(&simulation), ..Findings::default() })
}

/// A step of the temperature from 3 to 1.5, with and without a ramp.
pub(crate) fn temperatures() -> Map {
    let mut map = Map::new(
        "temperature_step",
        "Temperature with a step from 3 to 1.5 over a width, N/A = 2",
        "width of the step / d",
    );
    let step = |width: f64| TemperatureFn(move |height: f64| 3.0 - 1.5 * ramp(height, width));
    for width in WIDTHS {
        let place = if width > 0.0 { width } else { 1e-5 };
        let label = width.to_string();
        for (name, moves) in [("local", local as Maker), ("chains", chains as Maker)] {
            map.add_labeled(&format!("closure, {name}"), place, &label, move |trial| {
                column_of(step(width), moves, trial)
            });
            if width > 0.0 {
                map.add_labeled(&format!("table, {name}"), place, &label, move |trial| {
                    let half = 0.5 * width;
                    let table = vec![(0.0, 3.0), (STEP - half, 3.0), (STEP + half, 1.5), (HEIGHT, 1.5)];
                    column_of(TabulatedTemperature::new(table)?, moves, trial)
                });
            }
        }
    }
    map
}

fn column_of(temperature: impl TemperatureProfile, moves: Maker, trial: Trial) -> Result<Findings, Failure> {
    let scene = column::scene(HEIGHT, 5.0, 2.0, UniformField::default(), temperature)?;
    let moves = moves()?;
    let best = theory(&scene)?;
    let builder = Simulation::builder(scene).scheme(SelfConsistent::default()).moves(moves).seed(trial.seed);
    let run = run(builder.build()?, Length { equilibration: 20_000, sweeps: 30_000 }, trial)?;
    let center = run.center_of_mass(best.center_of_mass(), 0.03)?.tolerating(0.01, 0.01);
    let below = run.equation_of_state([1.5, 3.0])?.tolerating(0.015, 0.015);
    let above = run.equation_of_state([5.5, 9.0])?.tolerating(0.015, 0.015);
    Ok(run.with([center, below, above]))
}
