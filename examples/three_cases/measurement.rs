//! One replica: equilibration, then production in consecutive intervals. An interrupted replica
//! continues.

use super::protocol::{Protocol, StartChoice};
use gradient_mc::checkpoint::{Archive, Persist};
use gradient_mc::drive::{ForceBalance, Scheme};
use gradient_mc::observers::{Bins, CenterOfMass, EquationOfStateFit, EquationOfStateProfile};
use gradient_mc::start::{ClosePacked, RandomInsertion, Start, Theory};
use gradient_mc::{
    Error, Every, Field, Frame, Observer, ObserverError, Scene, Simulation, TemperatureProfile, Warning,
};
use paper::{Failure, Interrupted, Watch};
use std::time::Duration;

/// Sweeps between two samples; neighboring sweeps are strongly correlated, and sampling takes time.
const OBSERVATION_INTERVAL: u64 = 5;

/// The results of one replica.
pub(crate) struct Replica {
    /// Profiles of the intervals that have begun.
    pub(crate) profiles: Vec<EquationOfStateProfile>,
    pub(crate) center_of_mass: CenterOfMass,
    /// Z from ranks and from collisions.
    pub(crate) fit: EquationOfStateFit,
    /// Balance of forces, which tests the effective field; `None` without an effective field.
    pub(crate) force_balance: Option<ForceBalance>,
    /// Warnings about the run.
    pub(crate) warnings: Vec<Warning>,
    /// CPU time of the replica, including earlier processes.
    pub(crate) busy: Duration,
    /// Number of sweeps of production.
    pub(crate) measured: u64,
}

/// The parameters of a replica in addition to scene and scheme.
#[derive(Clone, Copy)]
pub(crate) struct Task<'a> {
    pub(crate) protocol: &'a Protocol,
    pub(crate) seed: u64,
    pub(crate) watch: &'a Watch<'a>,
}

/// A profile for every interval.
struct Intervals {
    /// Number of sweeps of each interval.
    sweeps: Vec<u64>,
    profiles: Vec<EquationOfStateProfile>,
}

impl Observer for Intervals {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        let mut end = 0;
        for (sweeps, profile) in self.sweeps.iter().zip(&mut self.profiles) {
            end += sweeps;
            if frame.sweep_of_phase() <= end {
                return profile.observe(frame);
            }
        }
        Ok(())
    }
}

impl Persist for Intervals {
    fn persist(&mut self, archive: &mut Archive<'_>) -> Result<(), Error> {
        archive.same("sweeps of intervals", &self.sweeps)?;
        archive.part("profiles", &mut self.profiles)
    }
}

impl Task<'_> {
    /// Simulates one replica of a scene. An interrupted replica returns its data so far.
    pub(crate) fn simulate<F, T, S>(self, scene: Scene<F, T>, scheme: S) -> Result<Replica, Failure>
    where
        F: Field,
        T: TemperatureProfile,
        S: Scheme<F, T, Drive: Persist, Adaptation: Persist>,
    {
        let Self { protocol, seed, watch } = self;
        let slab = *scene.slab();
        let profile = || EquationOfStateProfile::new(&slab, Bins::count(protocol.bins()));
        let profiles = protocol.intervals.iter().map(|_| profile()).collect::<Result<_, _>>()?;
        let mut observer = (
            Every::new(OBSERVATION_INTERVAL, Intervals { sweeps: protocol.intervals.clone(), profiles }),
            Every::new(OBSERVATION_INTERVAL, CenterOfMass::new()),
            EquationOfStateFit::new(&scene)?,
        );
        let start: Box<dyn Start> = match protocol.start {
            StartChoice::RandomInsertion => Box::new(RandomInsertion::default()),
            StartChoice::Theory => Box::new(Theory),
            StartChoice::ClosePacked => Box::new(ClosePacked),
        };
        let builder = Simulation::builder(scene).scheme(scheme).start(start);
        let mut simulation = builder.moves(protocol.moves()?).seed(seed).build()?;
        let outcome = watch.equilibrate(&mut simulation, protocol.equilibration, 1, &mut ());
        let outcome =
            outcome.and_then(|()| watch.run(&mut simulation, protocol.production(), 1, &mut observer));
        if let Err(failure) = outcome
            && !failure.is::<Interrupted>()
        {
            return Err(failure);
        }
        let (profiles, center_of_mass, fit) = observer;
        let begun = profiles.observer.profiles.into_iter().filter(|profile| profile.observations() > 0);
        Ok(Replica {
            profiles: begun.collect(),
            center_of_mass: center_of_mass.observer,
            fit,
            force_balance: simulation.force_balance().cloned(),
            warnings: simulation.warnings(),
            busy: Duration::from_secs_f64(watch.cpu_seconds()),
            measured: simulation.sweep().saturating_sub(protocol.equilibration),
        })
    }
}
