//! The interface of a task to its study: progress, interruption, and continuation of an interrupted
//! task.

use super::Failure;
use super::clock::Stopwatch;
use super::interrupt::Interrupt;
use super::progress::Progress;
use super::unfinished::kept;
use gradient_mc::checkpoint::{Persist, Run};
use gradient_mc::drive::Scheme;
use gradient_mc::{Field, Observer, Simulation, TemperatureProfile};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::cell::{Cell, RefCell};
use std::path::PathBuf;
use std::time::Duration;

/// Time between checkpoints: the largest time that a killed process loses.
const BETWEEN_CHECKPOINTS: Duration = Duration::from_secs(60);

/// Error of a run that a signal ended early.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("interrupted")]
pub struct Interrupted;

/// The interface of one task.
///
/// The sweeps of a task are made in stages, each with its own checkpoint, always in the same order.
/// If an interrupted task is run again, complete stages are read and the interrupted stage
/// continues.
#[derive(Debug)]
pub struct Watch<'a> {
    interrupt: &'a Interrupt,
    progress: &'a Progress,
    /// Folder of the checkpoints.
    folder: PathBuf,
    stages: Cell<usize>,
    stopwatch: RefCell<Stopwatch>,
}

impl<'a> Watch<'a> {
    pub(super) fn new(interrupt: &'a Interrupt, progress: &'a Progress, folder: PathBuf) -> Self {
        let (stages, stopwatch) = (Cell::new(0), RefCell::new(Stopwatch::start()));
        Self { interrupt, progress, folder, stages, stopwatch }
    }

    /// Runs a stage of equilibration with an observer; each sweep counts `size` units of progress.
    /// Fails with [`Interrupted`] after a signal.
    pub fn equilibrate<F, T, S, O>(
        &self,
        simulation: &mut Simulation<F, T, S>,
        sweeps: u64,
        size: u64,
        observer: &mut O,
    ) -> Result<(), Failure>
    where
        F: Field,
        T: TemperatureProfile,
        S: Scheme<F, T, Drive: Persist, Adaptation: Persist>,
        O: Observer + Persist,
    {
        self.stage(simulation, [sweeps, 0], size, observer)
    }

    /// The same for production.
    pub fn run<F, T, S, O>(
        &self,
        simulation: &mut Simulation<F, T, S>,
        sweeps: u64,
        size: u64,
        observer: &mut O,
    ) -> Result<(), Failure>
    where
        F: Field,
        T: TemperatureProfile,
        S: Scheme<F, T, Drive: Persist, Adaptation: Persist>,
        O: Observer + Persist,
    {
        self.stage(simulation, [0, sweeps], size, observer)
    }

    fn stage<F, T, S, O>(
        &self,
        simulation: &mut Simulation<F, T, S>,
        [equilibration, production]: [u64; 2],
        size: u64,
        observer: &mut O,
    ) -> Result<(), Failure>
    where
        F: Field,
        T: TemperatureProfile,
        S: Scheme<F, T, Drive: Persist, Adaptation: Persist>,
        O: Observer + Persist,
    {
        let number = self.stages.replace(self.stages.get() + 1);
        let (mut reported, mut is_saved) = (simulation.sweep(), true);
        let ended = Run::new(self.folder.join(format!("stage_{number}")), equilibration, production)
            .observe_equilibration()
            .checkpoint_every(BETWEEN_CHECKPOINTS)
            .stop_on(self.interrupt.flag())
            .progress(|now| {
                // Reports the signal, if there was one.
                self.interrupt.pressed();
                if let Some(error) = now.unsaved.filter(|_| is_saved) {
                    eprintln!(
                        "warning: the checkpoint was not written, the run continues: {}",
                        explained(error)
                    );
                }
                is_saved = now.unsaved.is_none();
                if reported < now.began {
                    self.progress.resume((now.began - reported) * size);
                    reported = now.began;
                }
                self.progress.advance((now.sweep - reported) * size);
                reported = now.sweep;
            })
            .on(simulation, &mut (&mut *self.stopwatch.borrow_mut(), observer))?;
        if ended.is_finished() { Ok(()) } else { Err(Interrupted.into()) }
    }

    /// CPU seconds of the task so far, including earlier processes up to their checkpoints.
    pub fn cpu_seconds(&self) -> f64 {
        self.stopwatch.borrow().seconds()
    }

    /// Fails with [`Interrupted`] after a signal.
    pub fn check(&self) -> Result<(), Failure> {
        if self.interrupt.pressed() { Err(Interrupted.into()) } else { Ok(()) }
    }

    /// The result of a task without stages: the stored one of an earlier process, or a new one. It
    /// counts `size` units of progress.
    pub(super) fn kept<Output: Serialize + DeserializeOwned>(
        &self,
        task: &str,
        size: u64,
        make: impl FnOnce() -> Result<Output, Failure>,
    ) -> Result<Output, Failure> {
        let mut made = false;
        let output = kept(&self.folder, task, || {
            made = true;
            make()
        })?;
        if made {
            self.progress.advance(size);
        } else {
            self.progress.resume(size);
        }
        Ok(output)
    }
}

/// An error with its causes, each once.
pub fn explained(error: &(dyn std::error::Error + 'static)) -> String {
    let causes = std::iter::successors(error.source(), |error| error.source());
    causes.map(ToString::to_string).fold(error.to_string(), |text, cause| {
        if text.contains(&cause) { text } else { format!("{text}\n  because: {cause}") }
    })
}
