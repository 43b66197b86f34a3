//! Runs one task: a replica from its start or its checkpoint to its end.

use crate::files::{Folder, Noted, Record};
use crate::table::{Table, Task};
use gradient_mc::Simulation;
use gradient_mc::checkpoint::Run;
use std::error::Error as _;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

/// Why a replica failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Failure {
    /// An error of the simulation or its checkpoint.
    #[error(transparent)]
    Simulation(#[from] gradient_mc::Error),
    /// An error of another file.
    #[error("{}", path.display())]
    File {
        /// Path of the file.
        path: PathBuf,
        /// Error of the system.
        source: io::Error,
    },
    /// A panic, with its message.
    #[error("panicked: {0}")]
    Panicked(String),
}

impl Failure {
    /// Whether another process has locked the run.
    fn is_held(&self) -> bool {
        let source = self.source().and_then(|source| source.downcast_ref::<io::Error>());
        source.is_some_and(|source| source.kind() == io::ErrorKind::WouldBlock)
    }

    /// The error and its causes in one line, each once.
    #[must_use]
    pub fn explained(&self) -> String {
        let causes = std::iter::successors(self.source(), |&error| error.source());
        causes.map(ToString::to_string).fold(self.to_string(), |text, cause| {
            if text.contains(&cause) { text } else { format!("{text}: {cause}") }
        })
    }
}

/// The data shared by all tasks of a process.
#[derive(Debug)]
pub struct Job {
    /// The table of scenes.
    pub table: Table,
    /// The folder of results.
    pub folder: Folder,
    /// Time between checkpoints.
    pub checkpoint_every: Duration,
    /// Time after which a silent process is given up, and for which a task waits for a lock.
    pub patience: Duration,
    /// True if all tasks must stop.
    pub stop: AtomicBool,
}

impl Job {
    /// Runs a task; returns false if it was stopped. `progress` is called with the work before this
    /// call and the work so far, in spheres times sweeps.
    ///
    /// # Errors
    /// [`Failure`] if the simulation or a file fails, or the task panics.
    pub fn run(&self, task: Task, progress: impl Fn([u64; 2])) -> Result<bool, Failure> {
        catch_unwind(AssertUnwindSafe(|| self.simulate(task, progress))).unwrap_or_else(|panic| {
            let text = panic.downcast_ref::<String>().map(String::as_str);
            let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("unknown reason");
            Err(Failure::Panicked(text.into()))
        })
    }

    /// Waits while another process has locked the checkpoint: that of a job that was submitted
    /// twice, or that a killed `mpirun` left running.
    fn simulate(&self, task: Task, progress: impl Fn([u64; 2])) -> Result<bool, Failure> {
        let start = Instant::now();
        loop {
            match self.attempt(task, &progress) {
                Err(failure) if failure.is_held() && start.elapsed() < self.patience => {
                    if self.is_stopping() {
                        return Ok(false);
                    }
                    thread::sleep(Duration::from_millis(50));
                }
                ended => return ended,
            }
        }
    }

    fn attempt(&self, Task { case, replica }: Task, progress: impl Fn([u64; 2])) -> Result<bool, Failure> {
        let case = &self.table.cases[case];
        let scene = case.scene()?;
        let mut observers = case.observers(&scene)?;
        let builder = Simulation::builder(scene).seed(case.replica(replica).seed());
        let (spheres, path) = (case.spheres as u64, self.folder.checkpoint(case, replica));
        let (simulation, ended) = Run::new(path, case.equilibration, case.sweeps)
            .checkpoint_every(self.checkpoint_every)
            .stop_on(&self.stop)
            .until(|observers| case.has_reached(observers))
            .progress(|now| progress([now.began, now.sweep].map(|sweeps| sweeps.saturating_mul(spheres))))
            .of(builder, &mut observers)?;
        if ended.is_finished() {
            let warnings = simulation.warnings().iter().map(Noted::from).collect();
            let sweeps = ended.sweep - case.equilibration;
            let record = Record { identity: case.identity(replica), sweeps, warnings };
            self.folder.finish(case, replica, &record)?;
        }
        Ok(ended.is_finished())
    }

    /// Whether a task is finished, by any process.
    #[must_use]
    pub fn is_finished(&self, Task { case, replica }: Task) -> bool {
        self.folder.record(&self.table.cases[case], replica).is_some()
    }

    /// Whether all tasks must stop.
    #[must_use]
    pub fn is_stopping(&self) -> bool {
        self.stop.load(Ordering::SeqCst)
    }

    /// Description of a task for messages.
    #[must_use]
    pub fn describe(&self, Task { case, replica }: Task) -> String {
        let case = &self.table.cases[case];
        format!("{}, replica {replica} (seed {})", case.name, case.replica(replica).seed())
    }
}
