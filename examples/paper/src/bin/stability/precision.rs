//! Single precision: a plain loop in it, and the library, which decides in double.

use crate::map::{Findings, Map, Trial};
use crate::said::{self, Said};
use crate::sizes::overlaps;
use crate::verdict::Quantity;
use gradient_mc::moves::LocalMoves;
use gradient_mc::start::Positions;
use gradient_mc::statistics::Estimate;
use gradient_mc::temperature::Isothermal;
use gradient_mc::{
    AcceptedMove, Field, Frame, Observer, ObserverError, Recorder, Scene, Simulation, Slab, Vector3,
};
use paper::Failure;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const WIDTH: f64 = 4.0;
const TEMPERATURE: f64 = 5.0;
const SPHERES: usize = 160;
/// Of the plain loop: the start is inserted at random up to half as many diameters from the trough.
const EXTENT: f64 = 30.0;
const MAXIMUM_DISPLACEMENT: f64 = 0.01;
const SWEEPS: u64 = 4000;

/// A trough around a height: gravity turns round there.
#[derive(Debug, Clone, Copy)]
struct Trough {
    height: f64,
}

impl Field for Trough {
    fn potential(&self, height: f64) -> f64 {
        (height - self.height).abs()
    }

    fn acceleration(&self, height: f64) -> f64 {
        if height < self.height { -1.0 } else { 1.0 }
    }
}

/// A column in a trough; at larger heights single precision is coarser.
pub(crate) fn heights() -> Map {
    const HEIGHTS: [f64; 5] = [1e2, 1e3, 1e4, 1e5, 2e5];
    let mut map =
        Map::new("single_precision", "Single precision: 160 spheres around a height, S = 0.01", "height / d");
    for height in HEIGHTS {
        map.add("plain loop, single", height, move |trial| plain(height, single, trial));
        map.add("plain loop, double", height, move |trial| plain(height, |value| value, trial));
        map.add("library", height, move |trial| library(height, trial));
    }
    map
}

/// Rounds a number to single precision.
fn single(value: f64) -> f64 {
    // The truncation is intended.
    #[allow(clippy::cast_possible_truncation)]
    let single = value as f32;
    f64::from(single)
}

/// Spheres inserted at random, with coordinates as they are kept.
fn inserted(height: f64, kept: impl Fn(f64) -> f64, generator: &mut Pcg64Mcg) -> Vec<[f64; 3]> {
    let mut positions: Vec<[f64; 3]> = Vec::new();
    while positions.len() < SPHERES {
        let mut along = |start: f64, extent: f64| kept(start + extent * generator.random::<f64>());
        let trial = [along(height - 0.5 * EXTENT, EXTENT), along(0.0, WIDTH), along(0.0, WIDTH)];
        if positions.iter().all(|&other| square(trial, other, &kept) >= 1.0) {
            positions.push(trial);
        }
    }
    positions
}

/// Square of the distance, every operation rounded as numbers are kept. Sums and products of
/// doubles, rounded to single precision, are those of single precision, since a double has more
/// than twice the digits.
fn square(a: [f64; 3], b: [f64; 3], kept: &impl Fn(f64) -> f64) -> f64 {
    let across = |axis: usize| {
        let distance = kept(a[axis] - b[axis]).abs();
        distance.min(kept(WIDTH - distance))
    };
    let (x, y, z) = (kept(a[0] - b[0]), across(1), across(2));
    kept(kept(kept(x * x) + kept(y * y)) + kept(z * z))
}

/// Mean square of displacements against S²/3, and pairs that overlap.
fn quantities(square: Estimate, pairs: f64) -> [Quantity; 2] {
    let expected = MAXIMUM_DISPLACEMENT * MAXIMUM_DISPLACEMENT / 3.0;
    let steps = Quantity::relative("mean square of steps", square, expected).tolerating(0.03, 0.03);
    let pairs = Quantity::absolute("overlapping pairs", Estimate::exact(pairs)).tolerating(0.5, 0.5);
    [steps, pairs]
}

/// The simplest program: all pairs, coordinates as stored.
fn plain(height: f64, kept: impl Fn(f64) -> f64, trial: Trial) -> Result<Findings, Failure> {
    let mut generator = Pcg64Mcg::seed_from_u64(trial.seed);
    let mut positions = inserted(height, &kept, &mut generator);
    let (mut steps, mut squares, mut pairs) = (0.0, 0.0, 0.0);
    let mut overlapping = None;
    let sweeps = trial.sweeps(SWEEPS);
    for sweep in 0..sweeps {
        for _ in 0..SPHERES {
            let sphere = generator.random_range(0..SPHERES);
            let old = positions[sphere];
            let mut trial = old.map(|from| {
                kept(from + kept(MAXIMUM_DISPLACEMENT * (2.0 * generator.random::<f64>() - 1.0)))
            });
            for coordinate in &mut trial[1..] {
                *coordinate = kept(coordinate.rem_euclid(WIDTH));
            }
            let rise = (trial[0] - height).abs() - (old[0] - height).abs();
            let accepted = rise <= 0.0 || generator.random::<f64>() < libm::exp(-rise / TEMPERATURE);
            let free = |(other, &position): (usize, &[f64; 3])| {
                other == sphere || square(trial, position, &kept) >= 1.0
            };
            if accepted && positions.iter().enumerate().all(free) {
                steps += 1.0;
                squares += (trial[0] - old[0]) * (trial[0] - old[0]);
                positions[sphere] = trial;
            }
        }
        if sweep % 4 == 0 {
            let found = overlaps(&vectors(&positions), WIDTH);
            pairs += found.0;
            if found.0 > 0.0 {
                overlapping = Some(positions.clone());
            }
        }
    }
    let mean = squares / steps;
    let slab = Slab::new(2.0 * height, WIDTH, WIDTH)?;
    let scene = Scene::new(slab, SPHERES, Trough { height }, Isothermal::new(TEMPERATURE)?)?;
    let start = Positions(vectors(overlapping.as_ref().unwrap_or(&positions)));
    // Whether the library would go on from there.
    let said = Simulation::builder(scene).start(start).build().err().map(|error| Said::error(&error));
    Ok(Findings {
        // The variance of the square of a uniform number is 4/45.
        quantities: quantities(Estimate::new(mean, mean * (0.8 / steps).sqrt()), pairs).into(),
        said: said.into_iter().collect(),
        remark: format!("{pairs} overlapping pairs in {} configurations", sweeps / 4),
        foreign: true,
    })
}

fn vectors(positions: &[[f64; 3]]) -> Vec<Vector3<f64>> {
    positions.iter().map(|&position| position.into()).collect()
}

/// Squares of vertical displacements, as accepted.
#[derive(Default)]
struct Steps {
    count: f64,
    squares: f64,
    pairs: f64,
}

impl Recorder for Steps {
    fn record_move(&mut self, accepted: &AcceptedMove) {
        self.count += 1.0;
        self.squares += accepted.displacement.x * accepted.displacement.x;
    }
}

impl Observer for Steps {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        if frame.sweep().is_multiple_of(4) {
            let positions: Vec<Vector3<f64>> = frame.positions().collect();
            self.pairs += overlaps(&positions, WIDTH).0;
        }
        Ok(())
    }

    fn recorder(&mut self) -> Option<&mut dyn Recorder> {
        Some(self)
    }
}

fn library(height: f64, trial: Trial) -> Result<Findings, Failure> {
    let slab = Slab::new(2.0 * height, WIDTH, WIDTH)?;
    let scene = Scene::new(slab, SPHERES, Trough { height }, Isothermal::new(TEMPERATURE)?)?;
    let positions = inserted(height, |value| value, &mut Pcg64Mcg::seed_from_u64(trial.seed));
    let moves = LocalMoves::new(MAXIMUM_DISPLACEMENT)?;
    let builder = Simulation::builder(scene).start(Positions(vectors(&positions))).moves(moves);
    let mut simulation = builder.seed(trial.seed).build()?;
    let mut steps = Steps::default();
    // A sweep passes through all layers of the box, empty or not.
    let sweeps = trial.sweeps(if height > 5e4 { SWEEPS / 20 } else { SWEEPS });
    simulation.run(sweeps, &mut steps)?;
    let mean = steps.squares / steps.count;
    let square = Estimate::new(mean, mean * (0.8 / steps.count).sqrt());
    Ok(Findings {
        quantities: quantities(square, steps.pairs).into(),
        said: said::by(&simulation),
        remark: format!("{} overlapping pairs in {} configurations", steps.pairs, sweeps / 4),
        foreign: false,
    })
}
