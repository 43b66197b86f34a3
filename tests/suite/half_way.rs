//! Failures of user code during a sweep: counters record them, and observers stay valid.

use gradient_mc::drive::{Drive, EffectivePotential, Scheme};
use gradient_mc::field::UniformField;
use gradient_mc::moves::{EventChains, LocalMoves, Moves};
use gradient_mc::observers::{
    Bins, ChainPressureProfile, DisplacementProfile, EquationOfStateFit, EquationOfStateProfile,
};
use gradient_mc::start::Positions;
use gradient_mc::temperature::{ExponentialTemperature, Isothermal};
use gradient_mc::{
    AcceptedMove, Error, Field, Frame, Observer, ObserverError, Recorder, Scene, Simulation, Slab,
    TemperatureProfile, Vector3,
};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A drive whose potential is not a number above a height.
#[derive(Debug, Clone, Copy)]
struct NoNumberAbove(f64);

impl<F, T> Drive<F, T> for NoNumberAbove {
    fn reduced_potential(&self, _: &Scene<F, T>, height: f64) -> f64 {
        if height > self.0 { f64::NAN } else { 0.0 }
    }
}

impl<F, T> Scheme<F, T> for NoNumberAbove {
    type Drive = Self;
    type Adaptation = ();
    fn drive(self, _: &Scene<F, T>) -> Result<(Self, ()), Error> {
        Ok((self, ()))
    }
}

/// Counts the moves that it hears of.
#[derive(Debug, Default)]
struct Heard(u64);

impl Observer for Heard {
    fn observe(&mut self, _: &Frame<'_>) -> Result<(), ObserverError> {
        Ok(())
    }
    fn recorder(&mut self) -> Option<&mut dyn Recorder> {
        Some(self)
    }
}

impl Recorder for Heard {
    fn record_move(&mut self, _: &AcceptedMove) {
        self.0 += 1;
    }
}

#[test]
fn counters_tell_what_a_failed_sweep_did() {
    // A gas that fills the box up to where the potential ends, in several slabs of domains; and a
    // sphere that starts beyond it.
    for (spheres, reaches) in [(400, 34.0), (1, 33.8)] {
        let slab = Slab::new(60.0, 8.0, 8.0).unwrap();
        let scene =
            Scene::new(slab, spheres, UniformField::default(), Isothermal::new(5.0).unwrap()).unwrap();
        let lattice = |index: usize| {
            let [x, y, z] = [index / 36, index / 6 % 6, index % 6].map(|step| 0.6 + 1.3 * step as f64);
            Vector3::new(if spheres == 1 { 33.9 } else { x }, y, z)
        };
        let mut simulation = Simulation::builder(scene)
            .scheme(NoNumberAbove(reaches))
            .start(Positions((0..spheres).map(lattice).collect()))
            .moves(LocalMoves::new(0.6).unwrap())
            .seed(3)
            .build()
            .unwrap();
        let mut heard = Heard::default();
        let mut failed = 0;
        while failed < 5 {
            let before = *simulation.move_counts();
            let Err(error) = simulation.equilibrate(1, &mut heard) else { continue };
            failed += 1;
            let Error::InvalidPotential { height, potential, .. } = error else { panic!("{error}") };
            // Where the potential is no number, be it the place where a sphere was.
            assert!(potential.is_nan() && height > reaches, "{error}");
            assert!(error.to_string().contains("not a number"), "{error}");
            let counts = *simulation.move_counts();
            let sweep = counts.since(&before);
            assert!(sweep.trials > 0 && sweep.trials <= spheres as u64, "{sweep:?}");
            assert!(sweep.accepted < sweep.trials, "{sweep:?}");
            assert_eq!((counts.incomplete_sweeps, counts.accepted), (failed, heard.0));
        }
        let whole = simulation.sweep() * spheres as u64;
        let trials = simulation.move_counts().trials;
        assert!(trials > whole && trials <= whole + failed * spheres as u64, "{trials} {whole}");
    }
}

/// What happens where a switch is on.
#[derive(Debug, Clone, Copy)]
enum Fault {
    NoNumber,
    Panic,
}

/// The uniform field and T = 5 exp(-0.02 x), until a switch is on: then it fails above a height.
#[derive(Debug, Clone)]
struct Faulty {
    fault: Fault,
    above: f64,
    on: Arc<AtomicBool>,
}

impl Faulty {
    fn pass(&self, height: f64, value: f64) -> f64 {
        match self.fault {
            _ if height < self.above || !self.on.load(Ordering::Relaxed) => value,
            Fault::NoNumber => f64::NAN,
            Fault::Panic => panic!("a fault of the user's own"),
        }
    }
}

impl Field for Faulty {
    fn potential(&self, height: f64) -> f64 {
        self.pass(height, height)
    }
    fn acceleration(&self, height: f64) -> f64 {
        self.pass(height, 1.0)
    }
}

impl TemperatureProfile for Faulty {
    fn temperature(&self, height: f64) -> f64 {
        self.pass(height, 5.0 * (-0.02 * height).exp())
    }
}

#[test]
fn intervals_with_a_failed_sweep_do_not_count() {
    for moves in [Moves::from(LocalMoves::new(0.5).unwrap()), EventChains::default().into()] {
        let on = Arc::new(AtomicBool::new(false));
        let field = Faulty { fault: Fault::NoNumber, above: 1.0, on: on.clone() };
        let slab = Slab::new(40.0, 5.0, 5.0).unwrap();
        let scene = Scene::new(slab, 100, field, Isothermal::new(5.0).unwrap()).unwrap();
        let mut simulation = Simulation::builder(scene).moves(moves).seed(1).build().unwrap();
        let displacement = DisplacementProfile::new(&slab, Bins::count(1)).unwrap();
        let chains = ChainPressureProfile::new(&slab, Bins::count(1)).unwrap();
        let fit = EquationOfStateFit::new(simulation.scene()).unwrap();
        let mut observers = (displacement, chains, fit);
        simulation.run(20, &mut observers).unwrap();
        // Where the fault is met in the middle of a sweep, and of a chain; ten times in one interval, and
        // once more.
        for times in [10, 1] {
            on.store(true, Ordering::Relaxed);
            for _ in 0..times {
                simulation.run(1, &mut observers).unwrap_err();
            }
            on.store(false, Ordering::Relaxed);
            simulation.run(10, &mut observers).unwrap();
        }
        assert_eq!(simulation.sweep(), 40);
        assert_eq!((observers.0.observations(), observers.1.observations()), (37, 40));
        // The last interval of 32 began at the frame after the last failure, the 31st.
        simulation.run(21, &mut observers).unwrap();
        assert_eq!(observers.2.intervals(), 0);
        simulation.run(1, &mut observers).unwrap();
        assert_eq!(observers.2.intervals(), 1);
        if simulation.move_counts().trials > 0 && simulation.move_counts().chains == 0 {
            // One trial per sphere and sweep.
            let rate = observers.0.points().unwrap()[0].accepted_per_sweep.mean;
            assert!(rate < 1.0, "{rate}");
        }
        assert_eq!(simulation.move_counts().incomplete_sweeps, 11);
    }
}

#[test]
fn an_observer_whose_user_panics_is_as_before() {
    let on = Arc::new(AtomicBool::new(false));
    let slab = Slab::new(40.0, 5.0, 5.0).unwrap();
    let temperature = Faulty { fault: Fault::Panic, above: 20.0, on: on.clone() };
    let scene = Scene::new(slab, 100, UniformField::default(), temperature).unwrap();
    let simulation = Simulation::builder(scene).seed(1).build().unwrap();
    let mut states = EquationOfStateProfile::new(&slab, Bins::count(40)).unwrap();
    let mut chains = ChainPressureProfile::new(&slab, Bins::count(40)).unwrap();
    let before = format!("{states:?} {chains:?}");
    on.store(true, Ordering::Relaxed);
    let frame = simulation.frame();
    assert!(catch_unwind(AssertUnwindSafe(|| states.observe(&frame))).is_err());
    assert!(catch_unwind(AssertUnwindSafe(|| chains.observe(&frame))).is_err());
    assert_eq!(format!("{states:?} {chains:?}"), before);
    on.store(false, Ordering::Relaxed);
    states.observe(&frame).unwrap();
    chains.observe(&frame).unwrap();
}

#[test]
fn a_potential_that_cannot_be_set_stays_what_it_was() {
    let slab = Slab::new(40.0, 5.0, 5.0).unwrap();
    let temperature = ExponentialTemperature::new(5.0, 0.02).unwrap();
    let scene = Scene::new(slab, 100, UniformField::default(), temperature).unwrap();
    let mut potential = EffectivePotential::new(&scene, 0.5).unwrap();
    potential.set(0.25, |_| 6.0).unwrap();
    let before = format!("{potential:?}");
    let failed = potential.set(0.5, |bin| if bin < 40 { 7.0 } else { f64::INFINITY });
    assert!(matches!(failed, Err(Error::InvalidPotential { height, .. }) if height > 20.0), "{failed:?}");
    let fault = |bin: usize| if bin < 40 { 7.0 } else { panic!("a fault of the user's own") };
    assert!(catch_unwind(AssertUnwindSafe(|| potential.set(0.5, fault))).is_err());
    assert_eq!(format!("{potential:?}"), before);
}
