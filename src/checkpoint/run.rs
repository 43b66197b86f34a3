//! Long runs with checkpoints in one call.

use super::file::beside;
use super::{Persist, Snapshot};
use crate::drive::Scheme;
use crate::frame::Phase;
use crate::{Error, Field, Observer, Simulation, SimulationBuilder, TemperatureProfile};
use std::fmt;
use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// A long run in one call: equilibration and production with a checkpoint every few minutes. If it
/// is interrupted, the same call continues it.
///
/// The result has the same bits with any number of interruptions. To extend a run, make the same
/// call with more sweeps of production.
///
/// ```
/// use gradient_mc::checkpoint::Run;
/// use gradient_mc::observers::CenterOfMass;
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 36, UniformField::default(), Isothermal::new(5.0)?)?;
/// let path = std::env::temp_dir().join(format!("gradient-mc-run-{}", std::process::id()));
/// # let paths = [path.clone(), path.with_extension("previous")];
/// let mut center_of_mass = CenterOfMass::new();
/// // Until the standard error of the height of the center of mass is below 0.1 diameters.
/// let run = Run::new(&path, 200, 100_000)
///     .until(|observer: &CenterOfMass| observer.estimate().is_ok_and(|height| height.standard_error < 0.1));
/// let (simulation, ended) = run.of(Simulation::builder(scene).seed(1), &mut center_of_mass)?;
/// println!("{ended}: {}", center_of_mass.estimate()?);
/// assert!(ended.is_finished() && simulation.sweep() < 100_000);
/// # for path in paths { std::fs::remove_file(path).ok(); }
/// # Ok::<(), gradient_mc::Error>(())
/// ```
pub struct Run<'a, O> {
    path: PathBuf,
    equilibration: u64,
    production: u64,
    observes_equilibration: bool,
    between_checkpoints: Duration,
    limit: Option<Duration>,
    stop: Option<&'a AtomicBool>,
    reached: Option<Reached<'a, O>>,
    progress: Option<Show<'a>>,
}

type Reached<'a, O> = Box<dyn Fn(&O) -> bool + 'a>;
type Show<'a> = Box<dyn FnMut(&Progress<'_>) + 'a>;

/// Progress of a run.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Progress<'a> {
    /// The phase of the run.
    pub phase: Phase,
    /// Number of sweeps done, including those before an interruption.
    pub sweep: u64,
    /// Largest number of sweeps of the run.
    pub sweeps: u64,
    /// Sweep at which this call started.
    pub began: u64,
    /// Time since this call started.
    pub elapsed: Duration,
    /// The error of the last checkpoint, if it could not be written. The run continues and tries
    /// again.
    pub unsaved: Option<&'a Error>,
}

/// How a [`Run`] ended. It prints as a sentence that tells how to continue.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Ended {
    /// The reason.
    pub reason: Reason,
    /// Number of sweeps done, including those before an interruption.
    pub sweep: u64,
    /// Largest number of sweeps of the run.
    pub sweeps: u64,
    /// The file of the checkpoint.
    pub path: PathBuf,
}

/// Why a [`Run`] ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Reason {
    /// All sweeps are done.
    Complete,
    /// The target of [`Run::until`] is reached.
    TargetReached,
    /// The time limit is reached.
    TimeLimit,
    /// The flag of [`Run::stop_on`] is set.
    Stopped,
}

impl Ended {
    /// Whether the run is complete, or its target reached.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        matches!(self.reason, Reason::Complete | Reason::TargetReached)
    }
}

impl fmt::Display for Ended {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { reason, sweep, sweeps, path } = self;
        let reason = match reason {
            Reason::Complete => return write!(formatter, "complete after {sweep} sweeps"),
            Reason::TargetReached => {
                return write!(formatter, "reached its target after {sweep} sweeps");
            }
            Reason::TimeLimit => "time limit reached",
            Reason::Stopped => "stopped",
        };
        let path = path.display();
        write!(formatter, "{reason} after {sweep} of {sweeps} sweeps; the same command continues from {path}")
    }
}

impl<O> fmt::Debug for Run<'_, O> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Run")
            .field("path", &self.path)
            .field("equilibration", &self.equilibration)
            .field("production", &self.production)
            .field("between_checkpoints", &self.between_checkpoints)
            .field("time_limit", &self.limit)
            .finish_non_exhaustive()
    }
}

impl<'a, O> Run<'a, O> {
    /// Makes a run of `equilibration` and `production` sweeps, with its checkpoint at `path`. The
    /// folder is created if needed.
    #[must_use]
    pub fn new(path: impl AsRef<Path>, equilibration: u64, production: u64) -> Self {
        Self {
            path: path.as_ref().into(),
            equilibration,
            production,
            observes_equilibration: false,
            between_checkpoints: Duration::from_secs(600),
            limit: None,
            stop: None,
            reached: None,
            progress: None,
        }
    }

    /// Calls the observer in equilibration too.
    #[must_use]
    pub fn observe_equilibration(self) -> Self {
        Self { observes_equilibration: true, ..self }
    }

    /// Sets the time between checkpoints; ten minutes by default. Checkpoints are also written at
    /// the beginning and at the end.
    #[must_use]
    pub fn checkpoint_every(self, interval: Duration) -> Self {
        Self { between_checkpoints: interval, ..self }
    }

    /// Ends the run after the first sweep beyond this time, counted from this call. Choose it
    /// smaller than the real limit by the time of one sweep and one checkpoint.
    #[must_use]
    pub fn time_limit(self, limit: Duration) -> Self {
        Self { limit: Some(limit), ..self }
    }

    /// Ends the run after the sweep in which this flag becomes true, set by another thread or by a
    /// signal (`Signals`, with the feature `signals`).
    #[must_use]
    pub fn stop_on(self, stop: &'a AtomicBool) -> Self {
        Self { stop: Some(stop), ..self }
    }

    /// Ends production early if `reached` returns true for the observer, for example for a standard
    /// error. It is called eight times per doubling of the number of sweeps, from the sixteenth
    /// sweep on, always at the same sweeps.
    ///
    /// Standard errors from few data are uncertain, and a run that ends at the first sufficiently
    /// small one favors underestimated errors. Therefore require a minimum amount of data too.
    #[must_use]
    pub fn until(self, reached: impl Fn(&O) -> bool + 'a) -> Self {
        Self { reached: Some(Box::new(reached)), ..self }
    }

    /// Calls `show` with the progress of the run, at most ten times per second, and at the end.
    #[must_use]
    pub fn progress(self, show: impl FnMut(&Progress<'_>) + 'a) -> Self {
        Self { progress: Some(Box::new(show)), ..self }
    }

    /// Runs a simulation with an observer of production: from the start, or from the checkpoint if
    /// there is one. If the checkpoint is damaged or missing, the previous one is used.
    ///
    /// # Errors
    /// Those of building, resuming and running; [`Error::CheckpointFile`] if the first or the last
    /// checkpoint cannot be written, or if another process has the run (the source is then an
    /// [`io::Error`] of the kind [`WouldBlock`](io::ErrorKind::WouldBlock); the locked file is
    /// `path.lock`). If a checkpoint in between fails, the run continues and [`Progress::unsaved`]
    /// holds the error. The last written checkpoint is always intact.
    pub fn of<F, T, S>(
        self,
        builder: SimulationBuilder<F, T, S>,
        observer: &mut O,
    ) -> Result<(Simulation<F, T, S>, Ended), Error>
    where
        F: Field,
        T: TemperatureProfile,
        S: Scheme<F, T, Drive: Persist, Adaptation: Persist>,
        O: Observer + Persist,
    {
        let _lock = self.lock()?;
        let saved = self.saved()?;
        let mut simulation = match &saved {
            Some(snapshot) => builder.resume(snapshot, observer)?,
            None => builder.build()?,
        };
        let ended = self.advance(&mut simulation, 0, observer)?;
        Ok((simulation, ended))
    }

    /// Runs one stage of several with an existing simulation, each stage with its own path. If
    /// `equilibration` is 0 and the simulation is in production, production continues.
    ///
    /// If a program is started again, it calls all its stages from the first one on. Complete
    /// stages are read, and the interrupted stage continues.
    ///
    /// ```
    /// use gradient_mc::checkpoint::Run;
    /// use gradient_mc::observers::CenterOfMass;
    /// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
    /// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 36, UniformField::default(), Isothermal::new(5.0)?)?;
    /// let folder = std::env::temp_dir().join(format!("gradient-mc-stages-{}", std::process::id()));
    /// let mut simulation = Simulation::builder(scene).build()?;
    /// let (mut falling, mut resting) = (CenterOfMass::new(), CenterOfMass::new());
    /// Run::new(folder.join("1"), 200, 0).observe_equilibration().on(&mut simulation, &mut falling)?;
    /// Run::new(folder.join("2"), 0, 300).on(&mut simulation, &mut resting)?;
    /// assert_eq!((falling.heights().len(), resting.heights().len(), simulation.sweep()), (200, 300, 500));
    /// # std::fs::remove_dir_all(folder).ok();
    /// # Ok::<(), gradient_mc::Error>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`of`](Self::of). If the checkpoint cannot be read, the simulation must not be used
    /// afterwards.
    pub fn on<F, T, S>(self, simulation: &mut Simulation<F, T, S>, observer: &mut O) -> Result<Ended, Error>
    where
        F: Field,
        T: TemperatureProfile,
        S: Scheme<F, T, Drive: Persist, Adaptation: Persist>,
        O: Observer + Persist,
    {
        let _lock = self.lock()?;
        let first = simulation.sweep();
        if let Some(snapshot) = self.saved()? {
            simulation.restore(&snapshot, observer)?;
        }
        self.advance(simulation, first, observer)
    }

    /// Runs the rest of the stage that began after sweep `first`.
    fn advance<F, T, S>(
        mut self,
        simulation: &mut Simulation<F, T, S>,
        first: u64,
        observer: &mut O,
    ) -> Result<Ended, Error>
    where
        F: Field,
        T: TemperatureProfile,
        S: Scheme<F, T, Drive: Persist, Adaptation: Persist>,
        O: Observer + Persist,
    {
        let start = Instant::now();
        let equilibrated = first.saturating_add(self.equilibration);
        let (began, sweeps) = (simulation.sweep(), equilibrated.saturating_add(self.production));
        self.require_same_stage(simulation, [first, equilibrated])?;
        let (mut saved, mut saved_sweep, mut shown, mut unsaved) = (start, None, start, None);
        let reason = loop {
            let sweep = simulation.sweep();
            let measured = sweep.saturating_sub(equilibrated);
            if is_due(measured) && self.reached.as_ref().is_some_and(|reached| reached(observer)) {
                break Reason::TargetReached;
            }
            if sweep >= sweeps {
                break Reason::Complete;
            }
            // At the beginning, to fail early if there is no space.
            if saved_sweep.is_none() {
                simulation.snapshot(observer)?.write(&self.path)?;
                saved_sweep = Some(sweep);
            }
            if self.stop.is_some_and(|stop| stop.load(Ordering::SeqCst)) {
                break Reason::Stopped;
            }
            let now = Instant::now();
            if self.limit.is_some_and(|limit| now - start >= limit) {
                break Reason::TimeLimit;
            }
            if now - saved >= self.between_checkpoints {
                unsaved = simulation.snapshot(observer)?.write(&self.path).err();
                (saved, saved_sweep) =
                    (Instant::now(), if unsaved.is_none() { Some(sweep) } else { saved_sweep });
            }
            if now - shown >= Duration::from_millis(100) {
                shown = now;
                self.show(simulation.frame().phase(), [began, sweep, sweeps], start, unsaved.as_ref());
            }
            if sweep >= equilibrated {
                simulation.run(1, observer)?;
            } else if self.observes_equilibration {
                simulation.equilibrate(1, observer)?;
            } else {
                simulation.equilibrate(1, &mut ())?;
            }
        };
        let sweep = simulation.sweep();
        // The checkpoint of a complete run is not written again.
        if sweep > saved_sweep.unwrap_or(began) || !self.path.exists() {
            simulation.snapshot(observer)?.write(&self.path)?;
        }
        self.show(simulation.frame().phase(), [began, sweep, sweeps], start, None);
        Ok(Ended { reason, sweep, sweeps, path: self.path })
    }

    /// Locks the run against other processes until the returned file is dropped.
    fn lock(&self) -> Result<File, Error> {
        let failed = |path: &Path, source: io::Error| {
            Err(Error::CheckpointFile { path: path.into(), source: source.into() })
        };
        if let Some(folder) = self.path.parent()
            && let Err(error) = fs::create_dir_all(folder)
        {
            return failed(folder, error);
        }
        let path = beside(&self.path, ".lock");
        let lock = match File::create(&path) {
            Ok(lock) => lock,
            Err(error) => return failed(&path, error),
        };
        match lock.try_lock() {
            Err(TryLockError::WouldBlock) => {
                failed(&self.path, io::Error::new(io::ErrorKind::WouldBlock, "another process has it"))
            }
            // Some file systems do not support locks.
            Ok(()) | Err(TryLockError::Error(_)) => Ok(lock),
        }
    }

    /// The checkpoint to continue from, if there is one.
    fn saved(&self) -> Result<Option<Snapshot>, Error> {
        let source = |error: &Error, is: fn(&(dyn std::error::Error + 'static)) -> bool| {
            std::error::Error::source(error).is_some_and(is)
        };
        let is_absent = |error: &Error| {
            source(error, |error| {
                error.downcast_ref().is_some_and(|error: &io::Error| error.kind() == io::ErrorKind::NotFound)
            })
        };
        let is_damaged = |error: &Error| {
            source(error, |error| matches!(error.downcast_ref(), Some(Error::CheckpointDamaged { .. })))
        };
        Snapshot::read(&self.path).map(Some).or_else(|error| {
            match Snapshot::read(beside(&self.path, ".previous")) {
                Ok(snapshot) => {
                    if is_damaged(&error) {
                        // Otherwise the next checkpoint would replace the good file by this one.
                        fs::remove_file(&self.path).ok();
                    }
                    Ok(Some(snapshot))
                }
                Err(previous) if is_absent(&error) && is_absent(&previous) => Ok(None),
                Err(_) => Err(error),
            }
        })
    }

    /// Fails if the checkpoint is of another stage, or has another number of sweeps of
    /// equilibration.
    fn require_same_stage<F: Field, T: TemperatureProfile, S: Scheme<F, T>>(
        &self,
        simulation: &Simulation<F, T, S>,
        [first, equilibrated]: [u64; 2],
    ) -> Result<(), Error> {
        let frame = simulation.frame();
        let (sweep, before_phase) = (frame.sweep(), frame.sweep() - frame.sweep_of_phase());
        let (fits, done) = match frame.phase() {
            Phase::Equilibration => (sweep <= equilibrated, sweep),
            // Continued production may have started in an earlier stage.
            Phase::Production if self.equilibration == 0 => (before_phase <= first, before_phase),
            Phase::Production => (before_phase == equilibrated || sweep == first, before_phase),
        };
        if fits && sweep >= first {
            return Ok(());
        }
        let (what, given) = ("number of sweeps of equilibration".into(), equilibrated.to_string());
        Err(Error::CheckpointMismatch { what, saved: done.to_string(), given })
    }

    fn show(
        &mut self,
        phase: Phase,
        [began, sweep, sweeps]: [u64; 3],
        start: Instant,
        unsaved: Option<&Error>,
    ) {
        if let Some(show) = &mut self.progress {
            show(&Progress { phase, sweep, sweeps, began, elapsed: start.elapsed(), unsaved });
        }
    }
}

/// Whether the target is checked after this number of sweeps of production: at eight evenly spaced
/// numbers between a power of two and the next.
fn is_due(sweeps: u64) -> bool {
    sweeps
        .checked_ilog2()
        .is_some_and(|doublings| doublings > 3 && sweeps.is_multiple_of(1 << (doublings - 3)))
}
