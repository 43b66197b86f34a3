//! An adaptation of the field gets the same frames, single moves and collisions as an observer, and
//! the potential that it changes is used from the next sweep on.

use gradient_mc::drive::{Adaptation, EffectivePotential, Scheme};
use gradient_mc::field::UniformField;
use gradient_mc::moves::{EventChains, LocalMoves, Moves};
use gradient_mc::temperature::ExponentialTemperature;
use gradient_mc::{
    AcceptedMove, AnyScene, Collision, Error, Field, Frame, Observer, ObserverError, Phase, Recorder, Scene,
    Simulation, Slab, TemperatureProfile,
};

/// What was seen of a run.
#[derive(Debug, Clone, Default, PartialEq)]
struct Seen {
    /// Sweep, generation of the potential, u(20), and whether it was production, of each frame.
    frames: Vec<(u64, u64, f64, bool)>,
    moves: u64,
    collisions: u64,
    /// Sum of their separations.
    separations: f64,
    path: f64,
}

impl Observer for Seen {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        let production = frame.phase() == Phase::Production;
        self.frames.push((frame.sweep(), frame.generation(), frame.reduced_potential(20.0), production));
        Ok(())
    }
    fn recorder(&mut self) -> Option<&mut dyn Recorder> {
        Some(self)
    }
}

impl Recorder for Seen {
    fn record_move(&mut self, _: &AcceptedMove) {
        self.moves += 1;
    }
    fn record_collision(&mut self, collision: &Collision) {
        self.collisions += 1;
        self.separations += collision.separation;
    }
    fn record_chain(&mut self, _: usize, length: f64) {
        self.path += length;
    }
}

/// Z = 1 + Σs/l of all collisions so far, everywhere; while equilibrating.
#[derive(Debug, Default)]
struct ByCollisions {
    seen: Seen,
    factors: Vec<f64>,
    frozen: bool,
}

impl Observer for ByCollisions {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.seen.observe(frame)
    }
    fn recorder(&mut self) -> Option<&mut dyn Recorder> {
        self.seen.recorder()
    }
}

impl Adaptation<EffectivePotential> for ByCollisions {
    fn adapt(&mut self, potential: &mut EffectivePotential, scene: &AnyScene<'_>) -> Result<(), Error> {
        if self.frozen {
            return Ok(());
        }
        let factor = 1.0 + self.seen.separations / self.seen.path.max(1.0);
        self.factors.push(factor);
        let heights: Vec<f64> = potential.heights().collect();
        potential.set(0.0, |bin| factor * scene.temperature().temperature(heights[bin]))
    }
    fn start_production(&mut self, _: &mut EffectivePotential, _: &AnyScene<'_>) -> Result<(), Error> {
        self.frozen = true;
        Ok(())
    }
}

#[derive(Debug, Clone, Copy)]
struct FromCollisions;

impl<F: Field, T: TemperatureProfile> Scheme<F, T> for FromCollisions {
    type Drive = EffectivePotential;
    type Adaptation = ByCollisions;
    fn drive(self, scene: &Scene<F, T>) -> Result<(EffectivePotential, ByCollisions), Error> {
        Ok((EffectivePotential::new(scene, 0.1)?, ByCollisions::default()))
    }
}

fn simulation(moves: impl Into<Moves>) -> Simulation<UniformField, ExponentialTemperature, FromCollisions> {
    let temperature = ExponentialTemperature::new(5.0, 0.02).unwrap();
    let slab = Slab::new(60.0, 6.0, 6.0).unwrap();
    let scene = Scene::new(slab, 360, UniformField::default(), temperature).unwrap();
    Simulation::builder(scene).scheme(FromCollisions).moves(moves).seed(3).build().unwrap()
}

#[test]
fn an_adaptation_sees_what_an_observer_sees() {
    let local: Moves = LocalMoves::new(0.5).unwrap().into();
    for moves in [EventChains::default().into(), local, Moves::default()] {
        let mut simulation = simulation(moves);
        let mut observer = Seen::default();
        simulation.equilibrate(40, &mut observer).unwrap();
        simulation.run(30, &mut observer).unwrap();
        assert_eq!(simulation.adaptation().seen, observer);
        assert_eq!(observer.frames.len(), 70);
        assert!(observer.moves > 1000);
        assert_eq!(observer.collisions > 1000, !matches!(moves, Moves::Local(_)));
        // Whether or not somebody else asks.
        let mut alone = self::simulation(moves);
        alone.equilibrate(40, &mut ()).unwrap();
        alone.run(30, &mut ()).unwrap();
        assert_eq!(alone.adaptation().seen, observer);
    }
}

#[test]
fn a_potential_that_is_adapted_is_in_force_from_the_next_sweep_on() {
    // Chains in every sweep.
    let mut simulation = simulation(EventChains::default().path_per_sphere(2.0).unwrap());
    simulation.equilibrate(40, &mut ()).unwrap();
    simulation.run(30, &mut ()).unwrap();
    let frames = &simulation.adaptation().seen.frames;
    for (sweep, &(number, generation, potential, production)) in (1..).zip(frames) {
        assert_eq!((number, production), (sweep, sweep > 40));
        // Changed after each sweep of equilibration.
        assert_eq!(generation, (sweep - 1).min(40));
        let last = frames[frames.len() - 1].2;
        assert!(!production || potential.to_bits() == last.to_bits());
    }
    // What a sweep has measured is in force in the next; where no chain ended it measured nothing.
    let mut changes = 0;
    for (sweep, pair) in (0..).zip(frames[..41].windows(2)).skip(1) {
        let [before, after] =
            [sweep - 1, sweep].map(|sweep| simulation.adaptation().factors[sweep].to_bits());
        let measured = before != after;
        assert_eq!(pair[0].2.to_bits() != pair[1].2.to_bits(), measured);
        changes += u32::from(measured);
    }
    assert!(changes > 20, "{changes}");
    assert_eq!(simulation.frame().reduced_potential(20.0).to_bits(), frames[69].2.to_bits());
}
