//! The simulation: a scene, its drive, a configuration and a generator.

use crate::centers::Centers;
#[cfg(feature = "checkpoint")]
use crate::checkpoint::Identity;
use crate::configuration::Configuration;
use crate::diagnostics::{self, Case};
use crate::drive::{Adaptation, Automatic, Certificate, Drive, Driven, ForceBalance, Scheme};
use crate::failed_observer::FailedObserver;
use crate::frame::{Frame, MoveCounts, Phase};
use crate::monitor::Monitor;
use crate::moves::{Engine, Moves, Sweep, TunedDisplacements};
use crate::observer::Observer;
use crate::random::Generator;
use crate::scene::AnyScene;
use crate::start::{Start, Theory};
use crate::{Error, Field, Scene, TemperatureProfile, Warning, temperature};
use nalgebra::Vector3;
use rand::SeedableRng;
use std::fmt;
use std::sync::Arc;

/// Gradient Monte Carlo of hard spheres in a field `F` and a temperature profile `T`.
///
/// The three systems of doi:10.1103/PhysRevE.83.061306 are
///
/// ```
/// use gradient_mc::{Simulation, field::*, temperature::*};
/// type UniformTemperatureAndField = Simulation<UniformField, Isothermal>;
/// type VaryingField = Simulation<ExponentialField, Isothermal>;
/// type VaryingTemperature = Simulation<UniformField, ExponentialTemperature>;
/// ```
///
/// The third parameter `S` is the scheme: how the effective field is found if the temperature
/// varies with height (see [`drive`](crate::drive)). The default, [`Automatic`], works for any
/// temperature profile and adds nothing to an isothermal simulation.
///
/// A simulation has two phases. [`equilibrate`](Self::equilibrate) lets the configuration and the
/// effective field relax. [`run`](Self::run) is production: observers sample, and with the default
/// scheme the effective field is frozen. Observers are called after every sweep, in both phases.
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
pub struct Simulation<F, T, S: Scheme<F, T> = Automatic> {
    driven: Driven<F, T, S::Drive>,
    adaptation: S::Adaptation,
    engine: Engine,
    configuration: Configuration,
    generator: Generator,
    sweep: u64,
    move_counts: MoveCounts,
    phase: Phase,
    /// Number of the last sweep before the current phase.
    before_phase: u64,
    monitor: Monitor,
    /// Present if the temperature varies with height.
    balance: Option<Box<ForceBalance>>,
    #[cfg(feature = "checkpoint")]
    identity: Identity,
}

/// Builder of a [`Simulation`]: sets its scheme, start, moves and seed, in any order.
///
/// ```
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// use gradient_mc::{moves::LocalMoves, start::ClosePacked};
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 360, UniformField::default(), Isothermal::new(5.0)?)?;
/// let builder = Simulation::builder(scene).start(ClosePacked).moves(LocalMoves::tuned()).seed(1);
/// // The same seed gives the same run.
/// let (mut one, mut other) = (builder.clone().build()?, builder.build()?);
/// one.run(10, &mut ())?;
/// other.run(10, &mut ())?;
/// assert_eq!(one.positions(), other.positions());
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Clone)]
pub struct SimulationBuilder<F, T, S = Automatic> {
    scene: Scene<F, T>,
    scheme: S,
    start: Arc<dyn Start>,
    moves: Option<Moves>,
    seed: u64,
}

impl<F: Field, T: TemperatureProfile> Simulation<F, T> {
    /// Starts to build a simulation of `scene`. Defaults: the [`Automatic`] scheme, a start at the
    /// theory profile, [`Moves::default`] and seed 0.
    pub fn builder(scene: Scene<F, T>) -> SimulationBuilder<F, T> {
        SimulationBuilder { scene, scheme: Automatic, start: Arc::new(Theory), moves: None, seed: 0 }
    }
}

impl<F: Field, T: TemperatureProfile, S> SimulationBuilder<F, T, S> {
    /// Sets the scheme: how the effective field is found if the temperature varies with height. See
    /// [`drive`](crate::drive) for the choices.
    pub fn scheme<R: Scheme<F, T>>(self, scheme: R) -> SimulationBuilder<F, T, R> {
        let Self { scene, start, moves, seed, .. } = self;
        SimulationBuilder { scene, scheme, start, moves, seed }
    }

    /// Sets the initial configuration; see [`start`](crate::start) for the choices.
    #[must_use]
    pub fn start(self, start: impl Start + 'static) -> Self {
        Self { start: Arc::new(start), ..self }
    }

    /// Sets the moves of a sweep; see [`moves`](crate::moves) for the choices.
    #[must_use]
    pub fn moves(self, moves: impl Into<Moves>) -> Self {
        Self { moves: Some(moves.into()), ..self }
    }

    /// Sets the seed of the random number [`Generator`]. The same seed gives the same run on every
    /// machine.
    #[must_use]
    pub fn seed(self, seed: u64) -> Self {
        Self { seed, ..self }
    }

    /// Builds the simulation: makes the potential, places the spheres and checks their positions.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] if a maximum displacement is too large for the slab;
    /// [`Error::UnsuitableMoves`] if the scheme does not accept the moves; [`Error::OutsideSlab`]
    /// or [`Error::Overlap`] if the start places a sphere outside the slab or two spheres too
    /// close; [`Error::WrongParticleCount`] if the start places another number of spheres than the
    /// scene has; the errors of the scheme and of the start.
    pub fn build(self) -> Result<Simulation<F, T, S>, Error>
    where
        S: Scheme<F, T>,
    {
        self.place(|scene, start, generator| {
            let positions: Vec<[f64; 3]> =
                start.place(scene, generator)?.into_iter().map(Into::into).collect();
            if positions.len() != scene.particles() {
                return Err(Error::WrongParticleCount {
                    expected: scene.particles(),
                    found: positions.len(),
                });
            }
            Configuration::new(*scene.slab(), &positions)
        })
    }

    /// Builds everything except the configuration, which `spheres` returns.
    fn place(
        self,
        spheres: impl FnOnce(&AnyScene<'_>, &dyn Start, &mut Generator) -> Result<Configuration, Error>,
    ) -> Result<Simulation<F, T, S>, Error>
    where
        S: Scheme<F, T>,
    {
        let Self { scene, scheme, start, moves, seed } = self;
        let moves = Moves::chosen(moves, scheme.depends_on_moves())?;
        moves.check(scene.slab())?;
        let (drive, adaptation) = scheme.drive(&scene)?;
        let mut generator = Generator::seed_from_u64(seed);
        let configuration = spheres(&scene.as_any(), start.as_ref(), &mut generator)?;
        let engine = Engine::new(moves);
        let varies = temperature::constant(scene.temperature(), scene.slab()).is_none();
        let certifiable = !adaptation.follows_every_configuration();
        Ok(Simulation {
            #[cfg(feature = "checkpoint")]
            identity: Identity::new(&scene, &drive, &moves, seed),
            monitor: Monitor::new(scene.slab(), engine.has_only_local_moves()),
            balance: varies.then(|| Box::new(ForceBalance::new(&scene.as_any(), certifiable))),
            driven: Driven { scene, drive },
            adaptation,
            engine,
            configuration,
            generator,
            sweep: 0,
            move_counts: MoveCounts::default(),
            phase: Phase::Equilibration,
            before_phase: 0,
        })
    }
}

#[cfg(feature = "checkpoint")]
mod saved;

impl<F: Field, T: TemperatureProfile, S: Scheme<F, T>> Simulation<F, T, S> {
    /// Runs `sweeps` sweeps of equilibration, in which the scheme may change the effective field,
    /// and calls `observer` after each sweep. Pass `&mut ()` to observe nothing.
    ///
    /// # Errors
    /// [`Error::Observer`] if the observer fails, with its error as the source;
    /// [`Error::InvalidPotential`] if field or temperature are not finite at some height; the
    /// errors of the scheme. The configuration stays valid, and the run can be continued.
    pub fn equilibrate<O: Observer + ?Sized>(&mut self, sweeps: u64, observer: &mut O) -> Result<(), Error> {
        if self.phase == Phase::Production {
            self.begin(Phase::Equilibration);
        }
        self.advance(sweeps, observer)
    }

    /// Runs `sweeps` sweeps of production and calls `observer` after each sweep. Further calls
    /// continue the same production; production starts anew only after another call of
    /// [`equilibrate`](Self::equilibrate).
    ///
    /// # Errors
    /// Those of [`equilibrate`](Self::equilibrate).
    pub fn run<O: Observer + ?Sized>(&mut self, sweeps: u64, observer: &mut O) -> Result<(), Error> {
        if self.phase == Phase::Equilibration {
            let Self { driven: Driven { scene, drive }, adaptation, balance, .. } = self;
            adaptation.start_production(drive, &scene.as_any())?;
            if let Some(balance) = balance {
                balance.set_measured_share(adaptation.measured_share());
            }
            self.begin(Phase::Production);
        }
        self.advance(sweeps, observer)
    }

    fn begin(&mut self, phase: Phase) {
        (self.phase, self.before_phase) = (phase, self.sweep);
    }

    fn advance<O: Observer + ?Sized>(&mut self, sweeps: u64, observer: &mut O) -> Result<(), Error> {
        for _ in 0..sweeps {
            let Self { driven, configuration, generator, move_counts, phase, .. } = self;
            // All observers see the same frame; the adaptation changes the potential only
            // afterwards.
            let mut all = (&mut self.monitor, &mut self.balance, &mut self.adaptation, &mut *observer);
            let swept = self.engine.sweep(Sweep {
                scene: &driven.scene,
                drive: &driven.drive,
                configuration,
                generator,
                move_counts,
                phase: *phase,
                recorder: all.recorder(),
            });
            if let Err(error) = swept {
                // This sweep has no frame. The count tells recorders that the moves they have
                // recorded are those of an incomplete sweep.
                self.move_counts.incomplete_sweeps += 1;
                return Err(error);
            }
            self.sweep += 1;
            let seen = all.observe(&Frame {
                scene: driven.scene.as_any(),
                potential: driven,
                centers: Centers::new(configuration),
                sweep: self.sweep,
                phase: *phase,
                sweep_of_phase: self.sweep - self.before_phase,
                move_counts,
            });
            self.adaptation.adapt(&mut driven.drive, &driven.scene.as_any())?;
            seen.map_err(|error| FailedObserver::after(self.sweep, error))?;
        }
        Ok(())
    }

    /// Warnings about the production run so far. No warnings is no proof of correctness. The table
    /// lists what is checked and which warnings may result.
    ///
    /// | checked | warnings |
    /// |---|---|
    /// | height of the center of mass as a series: its drift, its mean early and late, and its variance compared with the equilibrium value; autocorrelation times of this height, of the numbers of spheres below two heights, and of the first layers at the base | [`TooShort`](Warning::TooShort), [`NotMixed`](Warning::NotMixed), [`NothingMoved`](Warning::NothingMoved) |
    /// | mean height of the center of mass compared with [`Hydrostatics::between_walls`](crate::Hydrostatics::between_walls), where that theory is accurate | [`FarFromTheory`](Warning::FarFromTheory), [`NoTheory`](Warning::NoTheory) |
    /// | acceptance by height in every 128th sweep, if all moves are local | [`LowAcceptance`](Warning::LowAcceptance) |
    /// | balance of forces and effective field, if the temperature varies | [`FeedbackNotConverged`](Warning::FeedbackNotConverged), [`FieldOfTheory`](Warning::FieldOfTheory), [`CountingNoise`](Warning::CountingNoise), [`ChangesWhileMeasuring`](Warning::ChangesWhileMeasuring), [`SteepGradient`](Warning::SteepGradient), [`DensityJump`](Warning::DensityJump) |
    /// | density, and pressure from the weight of the spheres above | [`Metastable`](Warning::Metastable), [`BoxIncommensurate`](Warning::BoxIncommensurate) |
    /// | height and widths of the box | [`LidTooLow`](Warning::LidTooLow), [`NarrowBox`](Warning::NarrowBox) |
    ///
    /// [`NotMixed`](Warning::NotMixed) is also given if the effective number of independent
    /// configurations is below 2.5, for the column or for the layers at the base. A call solves the
    /// theory of the scene, which takes some milliseconds (one or two seconds if T changes by its
    /// own size within a diameter). The data are recorded every few sweeps from the start of
    /// production. Each replica gives its own warnings.
    ///
    /// ```
    /// use gradient_mc::{Scene, Simulation, Slab, Warning, field::UniformField, temperature::Isothermal};
    /// use gradient_mc::{moves::LocalMoves, start::RandomInsertion};
    /// let scene = Scene::new(Slab::new(100.0, 5.0, 5.0)?, 250, UniformField::default(), Isothermal::new(4.0)?)?;
    /// let mut simulation = Simulation::builder(scene).seed(1).build()?;
    /// simulation.equilibrate(500, &mut ())?;
    /// simulation.run(3000, &mut ())?;
    /// assert_eq!(simulation.warnings(), []);
    /// // Small moves, and a start far above: it is still falling.
    /// let builder = Simulation::builder(scene).start(RandomInsertion::default());
    /// let mut simulation = builder.moves(LocalMoves::new(0.1)?).build()?;
    /// simulation.run(300, &mut ())?;
    /// for warning in simulation.warnings() {
    ///     println!("{warning}");
    /// }
    /// assert!(simulation.warnings().iter().any(|warning| matches!(warning, Warning::FarFromTheory { .. })));
    /// # Ok::<(), gradient_mc::Error>(())
    /// ```
    pub fn warnings(&self) -> Vec<Warning> {
        let Self { driven: Driven { scene, drive }, adaptation, monitor, engine, .. } = self;
        let balance = self.balance.as_deref();
        Case { scene, drive, adaptation, monitor, balance, engine }.warnings()
    }

    /// The balance of forces recorded in the production run so far. `None` in an isothermal scene,
    /// where the balance always holds. Records of replicas can be merged.
    ///
    /// ```
    /// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::ExponentialTemperature};
    /// let temperature = ExponentialTemperature::new(5.0, 0.02)?;
    /// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 180, UniformField::default(), temperature)?;
    /// let mut simulation = Simulation::builder(scene).seed(1).build()?;
    /// simulation.equilibrate(300, &mut ())?;
    /// simulation.run(200, &mut ())?;
    /// let balance = simulation.force_balance().ok_or("isothermal")?;
    /// assert_eq!(balance.observations(), 40);
    /// for point in balance.ratios()?.iter().filter(|point| point.load > 0.05) {
    ///     println!("{:4.1}  {}", point.height, point.ratio);
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn force_balance(&self) -> Option<&ForceBalance> {
        self.balance.as_deref()
    }

    /// The current configuration, in the form in which observers get it.
    pub fn frame(&self) -> Frame<'_> {
        Frame {
            scene: self.driven.scene.as_any(),
            potential: &self.driven,
            centers: Centers::new(&self.configuration),
            sweep: self.sweep,
            phase: self.phase,
            sweep_of_phase: self.sweep - self.before_phase,
            move_counts: &self.move_counts,
        }
    }

    /// Checks whether the effective field of the production run so far is self-consistent, to a
    /// relative `tolerance`, and whether the column was stationary. The check compares the pressure
    /// held up by the forces of the effective field with the weight of the column; see
    /// [`ForceBalance`].
    ///
    /// An isothermal scene has no effective field, so only the column is checked. The result is
    /// [`Isothermal`](crate::drive::Convergence::Isothermal) if the column was stationary.
    ///
    /// ```
    /// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::ExponentialTemperature};
    /// let temperature = ExponentialTemperature::new(5.0, 0.02)?;
    /// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 180, UniformField::default(), temperature)?;
    /// let mut simulation = Simulation::builder(scene).seed(1).build()?;
    /// simulation.equilibrate(1000, &mut ())?;
    /// simulation.run(1000, &mut ())?;
    /// let certificate = simulation.certificate(0.05)?;
    /// assert!(certificate.is_converged(), "{certificate}");
    /// # Ok::<(), gradient_mc::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] if the tolerance is not between 0 and 1;
    /// [`Error::TooFewObservations`] if production has fewer than 320 sweeps.
    pub fn certificate(&self, tolerance: f64) -> Result<Certificate, Error> {
        let Self { monitor, .. } = self;
        let certificate = match self.force_balance() {
            Some(balance) => balance.certificate(tolerance)?,
            None => Certificate::isothermal(monitor.center_of_mass(), monitor.sweeps(), tolerance)?,
        };
        let (_, independent) = diagnostics::slowest(monitor);
        Ok(certificate.mixed(independent))
    }

    /// The scene that is simulated.
    pub fn scene(&self) -> &Scene<F, T> {
        &self.driven.scene
    }

    /// The drive, which gives the current reduced potential u(x) = U(x)/T.
    pub fn drive(&self) -> &S::Drive {
        &self.driven.drive
    }

    /// The adaptation, which changes the reduced potential during equilibration.
    pub fn adaptation(&self) -> &S::Adaptation {
        &self.adaptation
    }

    /// Pressure on the wall at the [open end](Scene::open_end), in m g/d², that the current
    /// potential assumes. Pressure profiles are summed from this value. It has no standard error,
    /// and is 0 in an isothermal scene.
    pub fn open_end_pressure(&self) -> f64 {
        self.driven.drive.open_end_pressure()
    }

    /// Number of sweeps so far, equilibration included.
    pub fn sweep(&self) -> u64 {
        self.sweep
    }

    /// Counts of the moves tried and accepted so far.
    pub fn move_counts(&self) -> &MoveCounts {
        &self.move_counts
    }

    /// The current maximum displacements of [`LocalMoves::tuned`](crate::moves::LocalMoves::tuned),
    /// used alone or between event chains. `None` if the simulation has no tuned local moves.
    pub fn tuned_displacements(&self) -> Option<&TunedDisplacements> {
        self.engine.local()?.tuning()
    }

    /// Centers of the spheres, in diameters. Another simulation can start from them with
    /// [`start::Positions`](crate::start::Positions) and another seed.
    pub fn positions(&self) -> Vec<Vector3<f64>> {
        self.configuration.positions().iter().map(|&position| position.into()).collect()
    }
}

impl<F: Clone, T: Clone, S: Scheme<F, T, Drive: Clone, Adaptation: Clone>> Clone for Simulation<F, T, S> {
    fn clone(&self) -> Self {
        Self {
            driven: self.driven.clone(),
            adaptation: self.adaptation.clone(),
            engine: self.engine.clone(),
            configuration: self.configuration.clone(),
            generator: self.generator.clone(),
            sweep: self.sweep,
            move_counts: self.move_counts,
            phase: self.phase,
            before_phase: self.before_phase,
            monitor: self.monitor.clone(),
            balance: self.balance.clone(),
            #[cfg(feature = "checkpoint")]
            identity: self.identity.clone(),
        }
    }
}

impl<F, T, S: Scheme<F, T>> fmt::Debug for Simulation<F, T, S> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Simulation")
            .field("slab", self.driven.scene.slab())
            .field("particles", &self.driven.scene.particles())
            .field("sweep", &self.sweep)
            .field("phase", &self.phase)
            .finish_non_exhaustive()
    }
}

impl<F, T, S> fmt::Debug for SimulationBuilder<F, T, S> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("SimulationBuilder")
            .field("slab", self.scene.slab())
            .field("particles", &self.scene.particles())
            .field("moves", &self.moves)
            .field("seed", &self.seed)
            .finish_non_exhaustive()
    }
}
