//! One replica: equilibrate, then measure in consecutive intervals.

use super::protocol::{Protocol, StartChoice};
use gradient_mc::drive::{ForceBalance, Scheme};
use gradient_mc::observers::{Bins, CenterOfMass, EquationOfStateFit, EquationOfStateProfile};
use gradient_mc::start::{ClosePacked, RandomInsertion, Start, Theory};
use gradient_mc::{Every, Field, Scene, Simulation, TemperatureProfile, Warning};
use paper::Failure;
use paper::clock::cpu_seconds;
use paper::interrupt::Interrupt;
use paper::progress::Progress;
use paper::replicas::in_chunks;
use std::time::Duration;

/// Sweeps between two looks at the configuration: counting spheres costs less than moving them, but
/// not nothing, and neighboring sweeps look alike.
const OBSERVATION_INTERVAL: u64 = 5;

/// What one replica measured.
pub(crate) struct Replica {
    /// Profiles of the intervals that were at least begun.
    pub(crate) profiles: Vec<EquationOfStateProfile>,
    pub(crate) center_of_mass: CenterOfMass,
    /// Z from ranks and from collisions.
    pub(crate) fit: EquationOfStateFit,
    /// Whether the effective field was the right one, where there is one.
    pub(crate) force_balance: Option<ForceBalance>,
    /// What the run says against itself.
    pub(crate) warnings: Vec<Warning>,
    /// Processor time of the whole replica.
    pub(crate) busy: Duration,
    /// Sweeps measured.
    pub(crate) measured: u64,
}

/// Simulates one replica of a scene.
pub(crate) fn simulate<F, T, S>(
    scene: Scene<F, T>,
    scheme: S,
    protocol: &Protocol,
    seed: u64,
    interrupt: &Interrupt,
    progress: &Progress,
) -> Result<Replica, Failure>
where
    F: Field,
    T: TemperatureProfile,
    S: Scheme<F, T>,
{
    let start: Box<dyn Start> = match protocol.start {
        StartChoice::RandomInsertion => Box::new(RandomInsertion::default()),
        StartChoice::Theory => Box::new(Theory),
        StartChoice::ClosePacked => Box::new(ClosePacked),
    };
    let builder = Simulation::builder(scene).scheme(scheme).start(start);
    let simulation = builder.moves(protocol.moves()?).seed(seed).build()?;
    measure(simulation, protocol, interrupt, progress)
}

fn measure<F: Field, T: TemperatureProfile, S: Scheme<F, T>>(
    mut simulation: Simulation<F, T, S>,
    protocol: &Protocol,
    interrupt: &Interrupt,
    progress: &Progress,
) -> Result<Replica, Failure> {
    let started = cpu_seconds();
    in_chunks(protocol.equilibration, interrupt, progress, |sweeps| simulation.equilibrate(sweeps, &mut ()))?;
    let mut center_of_mass = Every::new(OBSERVATION_INTERVAL, CenterOfMass::new());
    let mut fit = EquationOfStateFit::new(simulation.scene())?;
    let mut profiles = Vec::new();
    let mut measured = 0;
    for &sweeps in &protocol.intervals {
        let profile = EquationOfStateProfile::new(simulation.scene().slab(), Bins::count(protocol.bins()))?;
        let mut profile = Every::new(OBSERVATION_INTERVAL, profile);
        let done = in_chunks(sweeps, interrupt, progress, |sweeps| {
            simulation.run(sweeps, &mut (&mut profile, &mut center_of_mass, &mut fit))
        })?;
        if done == 0 {
            break;
        }
        measured += done;
        profiles.push(profile.observer);
    }
    Ok(Replica {
        profiles,
        center_of_mass: center_of_mass.observer,
        fit,
        force_balance: simulation.force_balance().cloned(),
        warnings: simulation.warnings(),
        busy: Duration::from_secs_f64(cpu_seconds() - started),
        measured,
    })
}
