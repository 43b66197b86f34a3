//! The feedback if the temperature varies: bins, schemes, equilibration, spheres.

use crate::column::{self, Length, run, theory};
use crate::map::{Findings, Map, Trial};
use gradient_mc::drive::{
    AveragedThenFrozen, EquationOfStateClosure, Instantaneous, RunningAverage, Scheme, SelfConsistent,
};
use gradient_mc::field::UniformField;
use gradient_mc::moves::{EventChains, LocalMoves, Moves};
use gradient_mc::start::{RandomInsertion, Start, Theory};
use gradient_mc::temperature::ExponentialTemperature;
use gradient_mc::{Scene, Simulation};
use paper::Failure;

type Gradient = Scene<UniformField, ExponentialTemperature>;

/// A column so low that local moves relax it: T = 4 exp(−0.12 x).
fn low(column_density: f64, width: f64) -> Result<Gradient, gradient_mc::Error> {
    let temperature = ExponentialTemperature::new(4.0, 0.12)?;
    column::scene(40.0, width, column_density, UniformField::default(), temperature)
}

/// The paper's steepest gradient: T = 20 exp(−0.05 x).
fn paper() -> Result<Gradient, gradient_mc::Error> {
    let temperature = ExponentialTemperature::new(20.0, 0.05)?;
    column::scene(200.0, 5.0, 40.0, UniformField::default(), temperature)
}

struct Setup<S, P> {
    scheme: S,
    start: P,
    moves: Moves,
    length: Length,
    range: [f64; 2],
}

impl<S: Scheme<UniformField, ExponentialTemperature>, P: Start + 'static> Setup<S, P> {
    fn run(self, scene: Gradient, trial: Trial) -> Result<Findings, Failure> {
        let builder = Simulation::builder(scene).scheme(self.scheme).start(self.start).moves(self.moves);
        let run = run(builder.seed(trial.seed).build()?, self.length, trial)?;
        let center = run.center_of_mass(theory(&scene)?.center_of_mass(), 0.05)?.tolerating(0.01, 0.01);
        let equation_of_state = run.equation_of_state(self.range)?.tolerating(0.015, 0.015);
        Ok(run.with([center, equation_of_state]))
    }
}

/// Bins of the density that enters the field.
pub(crate) fn bins() -> Map {
    const BINS: [f64; 7] = [0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0];
    fn setup<S>(scheme: S) -> Setup<S, Theory> {
        let length = Length { equilibration: 10_000, sweeps: 25_000 };
        // 0.75, the paper's; the slab is wide enough.
        Setup { scheme, start: Theory, moves: LocalMoves::tuned().into(), length, range: [3.0, 9.0] }
    }
    let mut map = Map::new("feedback_bins", "Feedback: bins of the effective field", "bin width / d");
    for bin in BINS {
        map.add("instantaneous", bin, move |trial| {
            let scene = low(6.0, 7.0)?;
            let moves = LocalMoves::new(0.75)?.into();
            Setup { moves, ..setup(Instantaneous::new(bin)?) }.run(scene, trial)
        });
        map.add("self-consistent", bin, move |trial| {
            setup(SelfConsistent::default().bin_width(bin)?).run(low(6.0, 7.0)?, trial)
        });
        map.add("closure", bin, move |trial| {
            setup(EquationOfStateClosure::default().bin_width(bin)?).run(low(6.0, 7.0)?, trial)
        });
    }
    map
}

/// Equilibration before the field is frozen, from far above.
pub(crate) fn patience() -> Map {
    const SWEEPS: [u32; 6] = [0, 30, 100, 300, 1000, 3000];
    fn setup<S>(scheme: S, sweeps: u32) -> Result<Setup<S, RandomInsertion>, gradient_mc::Error> {
        let length = Length { equilibration: sweeps.into(), sweeps: 1500 };
        let (start, moves) = (RandomInsertion::new(0.25)?, EventChains::default().into());
        Ok(Setup { scheme, start, moves, length, range: [8.0, 40.0] })
    }
    let mut map = Map::new(
        "feedback_equilibration",
        "Feedback: sweeps before production, from far above",
        "sweeps of equilibration",
    );
    for sweeps in SWEEPS {
        let place = f64::from(sweeps);
        map.add("self-consistent", place, move |trial| {
            setup(SelfConsistent::default(), sweeps)?.run(paper()?, trial)
        });
        map.add("averaged, then frozen", place, move |trial| {
            setup(AveragedThenFrozen::default(), sweeps)?.run(paper()?, trial)
        });
        map.add("running average", place, move |trial| {
            setup(RunningAverage::default(), sweeps)?.run(paper()?, trial)
        });
        map.add("instantaneous", place, move |trial| {
            setup(Instantaneous::default().any_moves(), sweeps)?.run(paper()?, trial)
        });
    }
    map
}

/// Few spheres.
pub(crate) fn few() -> Map {
    /// Spheres per area of the base, from one sphere over 4 x 4 on.
    const SPHERES: [u32; 6] = [1, 2, 5, 15, 50, 150];
    let mut map =
        Map::new("feedback_spheres", "Feedback: few spheres over a base 4 x 4", "number of spheres");
    for spheres in SPHERES {
        let place = f64::from(spheres);
        map.add("self-consistent", place, move |trial| {
            few_spheres(SelfConsistent::default(), spheres, trial)
        });
        map.add("instantaneous", place, move |trial| few_spheres(Instantaneous::default(), spheres, trial));
        map.add("instantaneous, bins 2 d", place, move |trial| {
            few_spheres(Instantaneous::new(2.0)?, spheres, trial)
        });
    }
    map
}

fn few_spheres<S>(scheme: S, spheres: u32, trial: Trial) -> Result<Findings, Failure>
where
    S: Scheme<UniformField, ExponentialTemperature>,
{
    let scene = low(f64::from(spheres) / 16.0, 4.0)?;
    let sweeps = u64::from(3_000_000 / (spheres + 10));
    let length = Length { equilibration: sweeps / 2, sweeps };
    let moves = LocalMoves::mixture(&[0.75, 2.0])?;
    let simulation = Simulation::builder(scene).scheme(scheme).moves(moves).seed(trial.seed).build()?;
    let run = run(simulation, length, trial)?;
    // Among few spheres none excludes volume to itself: n of the theory is right to (N − 1)/N of what Z
    // − 1 does.
    let theory = theory(&scene)?;
    let center = run.center_of_mass(theory.center_of_mass(), 0.03)?.tolerating(0.02, 0.02);
    Ok(run.with([center]))
}
