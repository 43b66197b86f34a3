//! The simulation: a scene, its drive, a configuration and a generator.

use crate::configuration::Configuration;
use crate::diagnostics::Case;
use crate::drive::{
    Adaptation, Certificate, ClosedForm, Drive, ForceBalance, IsothermalDrive, MappedDrive, Phase, Scheme,
};
use crate::monitor::{Both, Monitor};
use crate::moves::{Engine, LocalMoves, Moves, Sweep, TunedDisplacements};
use crate::observer::{Frame, MoveCounts, Observer, Recorder};
use crate::random::Generator;
use crate::start::{Start, Theory};
use crate::{Centers, Error, Field, Scene, TemperatureProfile, Warning};
use nalgebra::Vector3;
use rand::SeedableRng;

/// Gradient Monte Carlo of hard spheres in a field `F` and a temperature profile `T`.
///
/// The third parameter is how a temperature that varies enters (see [`drive`](crate::drive)); isothermal
/// scenes leave it out, and hold nothing for it. The three systems of
/// doi:10.1103/PhysRevE.83.061306 are
///
/// ```
/// use gradient_mc::{Simulation, drive::SelfConsistentDrive, field::*, temperature::*};
/// type UniformTemperatureAndField = Simulation<UniformField, Isothermal>;
/// type VaryingField = Simulation<ExponentialField, Isothermal>;
/// type VaryingTemperature = Simulation<UniformField, ExponentialTemperature, SelfConsistentDrive>;
/// ```
///
/// A run has two phases. [`equilibrate`](Self::equilibrate) lets the drive adapt;
/// [`run`](Self::run) measures, with whatever the drive froze. Observers look after every sweep.
///
/// ```
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// use gradient_mc::observers::CenterOfMass;
/// let slab = Slab::new(60.0, 6.0, 6.0)?;
/// let scene = Scene::new(slab, 360, UniformField::default(), Isothermal::new(5.0)?)?;
/// let mut simulation = Simulation::builder(scene).seed(1).build()?;
/// let mut center_of_mass = CenterOfMass::new();
/// simulation.equilibrate(100, &mut ())?;
/// simulation.run(400, &mut center_of_mass)?;
/// println!("center of mass: {}", center_of_mass.estimate()?);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Simulation<F, T, D = IsothermalDrive> {
    scene: Scene<F, T>,
    drive: D,
    engine: Engine,
    configuration: Configuration,
    generator: Generator,
    sweep: u64,
    move_counts: MoveCounts,
    phase: Phase,
    monitor: Monitor,
}

/// Collects the choices that make a [`Simulation`].
#[derive(Debug, Clone)]
pub struct SimulationBuilder<F, T, S = ClosedForm, P = Theory> {
    scene: Scene<F, T>,
    scheme: S,
    start: P,
    moves: Moves,
    seed: u64,
}

impl<F, T> Simulation<F, T> {
    /// Describes a simulation of `scene`: closed-form drive, theory start, displacements up to 0.75
    /// diameters and seed 0, until told otherwise.
    pub fn builder(scene: Scene<F, T>) -> SimulationBuilder<F, T> {
        let moves = LocalMoves::unchecked(0.75).into();
        SimulationBuilder { scene, scheme: ClosedForm, start: Theory, moves, seed: 0 }
    }
}

impl<F, T, S, P> SimulationBuilder<F, T, S, P> {
    /// How a temperature that varies enters; see [`drive`](crate::drive) for the choices.
    pub fn scheme<R>(self, scheme: R) -> SimulationBuilder<F, T, R, P> {
        let Self { scene, start, moves, seed, .. } = self;
        SimulationBuilder { scene, scheme, start, moves, seed }
    }

    /// Where the spheres are at first; see [`start`](crate::start) for the choices.
    pub fn start<Q: Start>(self, start: Q) -> SimulationBuilder<F, T, S, Q> {
        let Self { scene, scheme, moves, seed, .. } = self;
        SimulationBuilder { scene, scheme, start, moves, seed }
    }

    /// What sweeps consist of; see [`moves`](crate::moves) for the choices.
    #[must_use]
    pub fn moves(self, moves: impl Into<Moves>) -> Self {
        Self { moves: moves.into(), ..self }
    }

    /// Local moves with displacements of at most S along each axis, in diameters.
    #[must_use]
    pub fn maximum_displacement(self, maximum_displacement: f64) -> Self {
        self.moves(LocalMoves::unchecked(maximum_displacement))
    }

    /// Seed of the [`Generator`]: the same seed gives the same run on every machine.
    #[must_use]
    pub fn seed(self, seed: u64) -> Self {
        Self { seed, ..self }
    }

    /// Makes the drive, places the spheres and checks them.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] for the displacement; what the scheme and the start return;
    /// [`Error::OutsideSlab`] and [`Error::Overlap`] with the indices of the spheres;
    /// [`Error::WrongParticleCount`] if the start does not place as many as the scene has.
    pub fn build(self) -> Result<Simulation<F, T, S::Drive>, Error>
    where
        F: Field,
        T: TemperatureProfile,
        S: Scheme<F, T>,
        P: Start,
    {
        let Self { scene, scheme, start, moves, seed } = self;
        match moves {
            Moves::Local(moves) => moves.check(scene.slab())?,
            Moves::EventChains(chains) => chains.check(scene.slab())?,
        }
        let drive = scheme.drive(&scene)?;
        let mut generator = Generator::seed_from_u64(seed);
        let positions: Vec<[f64; 3]> =
            start.place(&scene, &mut generator)?.into_iter().map(Into::into).collect();
        if positions.len() != scene.particles() {
            return Err(Error::WrongParticleCount { expected: scene.particles(), found: positions.len() });
        }
        let configuration = Configuration::new(*scene.slab(), &positions)?;
        Ok(Simulation {
            monitor: Monitor::new(scene.slab()),
            scene,
            drive,
            engine: Engine::new(moves),
            configuration,
            generator,
            sweep: 0,
            move_counts: MoveCounts::default(),
            phase: Phase::Equilibration,
        })
    }
}

impl<F: Field, T: TemperatureProfile, D: Drive<F, T>> Simulation<F, T, D> {
    /// Runs `sweeps` sweeps during which the drive may adapt, and shows each to `observer`; `&mut ()`
    /// looks at nothing.
    ///
    /// # Errors
    /// [`Error::Observer`] with the observer's own error, [`Error::InvalidPotential`] where field or
    /// temperature turn out not to be finite, or what the drive returns. The configuration stays valid
    /// and the run can go on.
    pub fn equilibrate<O: Observer + ?Sized>(&mut self, sweeps: u64, observer: &mut O) -> Result<(), Error> {
        self.phase = Phase::Equilibration;
        self.advance(sweeps, observer)
    }

    /// Runs `sweeps` sweeps of production and shows each to `observer`. May be called again and
    /// again: the phase starts at the first call after an equilibration.
    ///
    /// # Errors
    /// As [`equilibrate`](Self::equilibrate).
    pub fn run<O: Observer + ?Sized>(&mut self, sweeps: u64, observer: &mut O) -> Result<(), Error> {
        if self.phase == Phase::Equilibration {
            self.drive.start_production(&self.scene)?;
            self.monitor.start(self.drive.generation());
            self.phase = Phase::Production;
        }
        self.advance(sweeps, observer)
    }

    fn advance<O: Observer + ?Sized>(&mut self, sweeps: u64, observer: &mut O) -> Result<(), Error> {
        for _ in 0..sweeps {
            let recorded = self.engine.has_only_local_moves() && Monitor::records(self.sweep);
            let mut both;
            let recorder: Option<&mut dyn Recorder> = if recorded {
                both = Both { observer: observer.recorder(), monitor: self.monitor.acceptance_mut() };
                Some(&mut both)
            } else {
                observer.recorder()
            };
            self.engine.sweep(Sweep {
                scene: &self.scene,
                drive: &self.drive,
                configuration: &mut self.configuration,
                generator: &mut self.generator,
                move_counts: &mut self.move_counts,
                phase: self.phase,
                recorder,
            })?;
            self.sweep += 1;
            let centers = Centers::new(&self.configuration);
            if recorded {
                self.monitor.count_trials(centers);
            }
            if self.phase == Phase::Production {
                self.monitor.after_sweep(centers);
            }
            self.drive.after_sweep(&self.scene, centers, self.phase)?;
            observer
                .observe(&self.frame())
                .map_err(|source| Error::Observer { sweep: self.sweep, source })?;
        }
        Ok(())
    }

    /// What speaks against the production run so far; empty if nothing does, which is no proof.
    ///
    /// | judged | raises |
    /// |---|---|
    /// | the series of the center of mass: its drift, its memory, and its variance against what equilibrium demands of it | [`TooShort`](Warning::TooShort), [`NotMixed`](Warning::NotMixed), [`NothingMoved`](Warning::NothingMoved) |
    /// | its mean against [`Hydrostatics::between_walls`](crate::Hydrostatics::between_walls), where that is good | [`FarFromTheory`](Warning::FarFromTheory), [`NoTheory`](Warning::NoTheory) |
    /// | every 128th sweep, if all moves are local | [`LowAcceptance`](Warning::LowAcceptance) |
    /// | the balance of forces and the field, where the temperature varies | [`FeedbackNotConverged`](Warning::FeedbackNotConverged), [`CountingNoise`](Warning::CountingNoise), [`ChangesWhileMeasuring`](Warning::ChangesWhileMeasuring), [`SteepGradient`](Warning::SteepGradient), [`DensityJump`](Warning::DensityJump) |
    /// | density, and pressure as the weight of what lies above | [`Metastable`](Warning::Metastable), [`BoxIncommensurate`](Warning::BoxIncommensurate) |
    /// | the box | [`LidTooLow`](Warning::LidTooLow), [`NarrowBox`](Warning::NarrowBox) |
    ///
    /// Of runs that have seen 4, 8, 16, 32 and 64 independent configurations, 94, 78, 38, 6 and 0.2 % are called not mixed.
    /// It is worked out when asked for, in some milliseconds (a second or two where T changes by its own size within a
    /// diameter), since the theory of the scene is solved; what it needs of
    /// the run is noted every few sweeps, from the first of production on. Replicas are judged each by itself.
    ///
    /// ```
    /// use gradient_mc::{Scene, Simulation, Slab, Warning, field::UniformField, temperature::Isothermal};
    /// use gradient_mc::{moves::EventChains, start::RandomInsertion};
    /// let scene = Scene::new(Slab::new(100.0, 5.0, 5.0)?, 250, UniformField::default(), Isothermal::new(4.0)?)?;
    /// let mut simulation = Simulation::builder(scene).moves(EventChains::default()).seed(1).build()?;
    /// simulation.equilibrate(500, &mut ())?;
    /// simulation.run(3000, &mut ())?;
    /// assert_eq!(simulation.warnings(), []);
    /// // Small moves, and a start far above: it is still falling.
    /// let mut simulation = Simulation::builder(scene).start(RandomInsertion::default()).maximum_displacement(0.1).build()?;
    /// simulation.run(300, &mut ())?;
    /// for warning in simulation.warnings() {
    ///     println!("{warning}");
    /// }
    /// assert!(simulation.warnings().iter().any(|warning| matches!(warning, Warning::FarFromTheory { .. })));
    /// # Ok::<(), gradient_mc::Error>(())
    /// ```
    pub fn warnings(&self) -> Vec<Warning> {
        let Self { scene, drive, monitor, engine, .. } = self;
        Case { scene, drive, monitor, engine }.warnings()
    }

    /// What the production run so far has seen of the balance of forces; nothing in an isothermal scene, where it
    /// holds by itself. Records of replicas can be merged.
    pub fn force_balance(&self) -> Option<&ForceBalance> {
        self.drive.force_balance()
    }

    /// The configuration as an observer sees it.
    pub fn frame(&self) -> Frame<'_> {
        Frame {
            slab: self.scene.slab(),
            field: self.scene.field(),
            temperature: self.scene.temperature(),
            centers: Centers::new(&self.configuration),
            sweep: self.sweep,
            move_counts: &self.move_counts,
        }
    }
}

impl<F: Field, T: TemperatureProfile, A: Adaptation> Simulation<F, T, MappedDrive<A>> {
    /// Whether the production run so far can be trusted: whether the field it was made in is that of the density which
    /// it made, to a relative `tolerance`, and whether the column was at rest.
    ///
    /// Only temperatures that vary need one; isothermal scenes have no field that could be wrong.
    ///
    /// ```
    /// use gradient_mc::{Scene, Simulation, Slab, drive::SelfConsistent, moves::EventChains};
    /// use gradient_mc::{field::UniformField, temperature::ExponentialTemperature};
    /// let temperature = ExponentialTemperature::new(5.0, 0.02)?;
    /// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 180, UniformField::default(), temperature)?;
    /// let builder = Simulation::builder(scene).scheme(SelfConsistent::default());
    /// let mut simulation = builder.moves(EventChains::default()).seed(1).build()?;
    /// simulation.equilibrate(1000, &mut ())?;
    /// simulation.run(1000, &mut ())?;
    /// let certificate = simulation.certificate(0.05)?;
    /// assert!(certificate.is_converged(), "{certificate}");
    /// # Ok::<(), gradient_mc::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] for a tolerance that is not between 0 and 1; [`Error::TooFewObservations`] for a
    /// production run below 320 sweeps.
    pub fn certificate(&self, tolerance: f64) -> Result<Certificate, Error> {
        self.force_balance()
            .map_or_else(|| Err(ForceBalance::too_few(0)), |balance| balance.certificate(tolerance))
    }
}

impl<F, T, D> Simulation<F, T, D> {
    /// What is simulated.
    pub fn scene(&self) -> &Scene<F, T> {
        &self.scene
    }

    /// The reduced potential in force.
    pub fn drive(&self) -> &D {
        &self.drive
    }

    /// Sweeps done so far, equilibration included.
    pub fn sweep(&self) -> u64 {
        self.sweep
    }

    /// Trials and acceptances so far.
    pub fn move_counts(&self) -> &MoveCounts {
        &self.move_counts
    }

    /// The maximum displacements of [`LocalMoves::tuned`] as they are now, alone or between event chains; none of
    /// other moves.
    pub fn tuned_displacements(&self) -> Option<&TunedDisplacements> {
        self.engine.local()?.tuning()
    }

    /// Centers of the spheres, in diameters; what a later run needs to go on from here with
    /// [`start::Positions`](crate::start::Positions).
    pub fn positions(&self) -> Vec<Vector3<f64>> {
        self.configuration.positions().iter().map(|&position| position.into()).collect()
    }
}
