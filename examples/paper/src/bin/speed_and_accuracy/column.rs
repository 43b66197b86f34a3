//! A simulated column, with one interface for all methods.

use crate::method::{Method, Moves, Scheme, Start};
use crate::profile::{COLUMN_DENSITY, ColumnObserver, HEIGHT, Profile};
use crate::system::System;
use crate::theory;
use gradient_mc::drive::{
    self, Automatic, AveragedThenFrozen, EquationOfStateClosure, Instantaneous, RunningAverage,
    SelfConsistent,
};
use gradient_mc::field::UniformField;
use gradient_mc::moves::{EventChains, LocalMoves};
use gradient_mc::observers::EquationOfStateFit;
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Error, Every, Field, Scene, Simulation, Slab, TemperatureProfile, start};
use paper::Failure;
use paper::clock::cpu_seconds;

/// The paper's largest displacement.
const DISPLACEMENT: f64 = 0.75;
/// Diameters at the base that a short run takes for layers.
const LAYERS: f64 = 8.0;

/// What was measured in a stretch of a run.
#[derive(Debug, Clone)]
pub(crate) struct Stretch {
    pub(crate) profile: Profile,
    /// CPU seconds of the measurement.
    pub(crate) seconds: f64,
}

/// A column at the end of its equilibration so far.
pub(crate) trait Column: Send {
    /// Goes on equilibrating; CPU seconds.
    fn equilibrate(&mut self, sweeps: u64) -> Result<f64, Failure>;

    /// The results of a production run that starts here. The column itself is unchanged.
    fn measure(&self, sweeps: u64, moves: Moves) -> Result<Stretch, Failure>;
}

impl<F, T, S> Column for Simulation<F, T, S>
where
    F: Field + Clone,
    T: TemperatureProfile + Clone,
    S: drive::Scheme<F, T, Drive: Clone, Adaptation: Clone>,
{
    fn equilibrate(&mut self, sweeps: u64) -> Result<f64, Failure> {
        let start = cpu_seconds();
        Simulation::equilibrate(self, sweeps, &mut ())?;
        Ok(cpu_seconds() - start)
    }

    fn measure(&self, sweeps: u64, moves: Moves) -> Result<Stretch, Failure> {
        // Neighboring sweeps are correlated; short runs sample every sweep.
        let interval = (sweeps / 250).clamp(1, 5);
        let mut production = self.clone();
        let start = cpu_seconds();
        let mut observer = Every::new(interval, ColumnObserver::new()?);
        let mut fit = match moves {
            Moves::OwnEquation => Some(EquationOfStateFit::new(production.scene())?),
            _ => None,
        };
        production.run(sweeps, &mut (&mut observer, &mut fit))?;
        let scene = production.scene();
        let lid_pressure = production.open_end_pressure();
        let mut profile =
            observer.observer.profile(scene.slab().base_area(), scene.particles(), lid_pressure)?;
        if let Some(fit) = fit {
            let (solved, layers) = match fit.result() {
                Ok(measured) => (scene.hydrostatics(&measured.collisions()), measured.heights()[0]),
                Err(Error::TooFewObservations { .. }) => {
                    (scene.hydrostatics(&fit.collisions_without_errors()?), LAYERS)
                }
                Err(error) => return Err(error.into()),
            };
            // The equation of state of a short run may give no profile.
            let bulk = solved.map_or_else(|_| Profile::unknown(), |solved| theory::binned(&solved));
            profile.take_above(&bulk, layers);
        }
        let seconds = cpu_seconds() - start;
        Ok(Stretch { profile, seconds })
    }
}

/// Spheres over a square base of this side.
pub(crate) fn particles(width: f64) -> usize {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let particles = (COLUMN_DENSITY * width * width).round() as usize;
    particles
}

/// A column of a system, at its start, and the CPU seconds that it took to put it there.
pub(crate) fn build(system: System, method: Method, seed: u64) -> Result<(Box<dyn Column>, f64), Failure> {
    let begin = cpu_seconds();
    let slab = Slab::new(HEIGHT, method.width, method.width)?;
    let particles = particles(method.width);
    let column = match system {
        System::Isothermal => {
            let temperature = Isothermal::new(system.base_temperature())?;
            let scene = Scene::new(slab, particles, UniformField::default(), temperature)?;
            with_moves(scene, Automatic, method, seed)?
        }
        System::VaryingField => {
            let temperature = Isothermal::new(system.base_temperature())?;
            let scene = Scene::new(slab, particles, system.field()?, temperature)?;
            with_moves(scene, Automatic, method, seed)?
        }
        System::VaryingTemperature => {
            let scene = Scene::new(slab, particles, UniformField::default(), system.temperature()?)?;
            match method.scheme {
                Scheme::SelfConsistent => with_moves(scene, SelfConsistent::default(), method, seed)?,
                Scheme::Closure => with_moves(scene, EquationOfStateClosure::default(), method, seed)?,
                Scheme::RunningAverage => with_moves(scene, RunningAverage::default(), method, seed)?,
                Scheme::AveragedThenFrozen => with_moves(scene, AveragedThenFrozen::default(), method, seed)?,
                Scheme::Instantaneous => with_moves(scene, Instantaneous::default(), method, seed)?,
            }
        }
    };
    Ok((column, cpu_seconds() - begin))
}

fn with_moves<F, T, S>(
    scene: Scene<F, T>,
    scheme: S,
    method: Method,
    seed: u64,
) -> Result<Box<dyn Column>, Failure>
where
    F: Field + Clone + 'static,
    T: TemperatureProfile + Clone + 'static,
    S: drive::Scheme<F, T, Drive: Clone, Adaptation: Clone> + 'static,
{
    let moves = match method.moves {
        Moves::Paper => LocalMoves::new(DISPLACEMENT)?.into(),
        Moves::Tuned => LocalMoves::tuned().into(),
        Moves::ChainsAndTuned => EventChains::default().local_moves(Some(LocalMoves::tuned())).into(),
        Moves::ChainsAlone => EventChains::default().local_moves(None).into(),
        Moves::OwnEquation => EventChains::default().vertical_fraction(0.5)?.local_moves(None).into(),
    };
    let moves: gradient_mc::moves::Moves = moves;
    let start: Box<dyn start::Start> = match method.start {
        Start::Uniform => Box::new(start::RandomInsertion::default()),
        Start::ClosePacked => Box::new(start::ClosePacked),
        Start::Theory => Box::new(start::Theory),
    };
    let builder = Simulation::builder(scene).scheme(scheme).start(start);
    Ok(Box::new(builder.moves(moves).seed(seed).build()?))
}
