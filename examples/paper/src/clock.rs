//! CPU time of a piece of work.

use cpu_time::{ProcessTime, ThreadTime};
use gradient_mc::checkpoint::{Archive, Persist};
use gradient_mc::{Error, Frame, Observer, ObserverError};

/// CPU seconds of this thread.
pub fn cpu_seconds() -> f64 {
    ThreadTime::now().as_duration().as_secs_f64()
}

/// CPU seconds of this process, including all threads of a sweep.
pub fn process_cpu_seconds() -> f64 {
    ProcessTime::now().as_duration().as_secs_f64()
}

/// CPU seconds of a piece of work on one thread. As an observer it is part of checkpoints, so the
/// time of earlier processes up to the checkpoint is included.
#[derive(Debug, Clone, Copy)]
pub struct Stopwatch {
    before: f64,
    began: f64,
}

impl Stopwatch {
    /// Starts the measurement.
    pub fn start() -> Self {
        Self { before: 0.0, began: cpu_seconds() }
    }

    /// CPU seconds so far. Call it on the thread that started or read the stopwatch.
    pub fn seconds(&self) -> f64 {
        self.before + cpu_seconds() - self.began
    }
}

impl Observer for Stopwatch {
    fn observe(&mut self, _: &Frame<'_>) -> Result<(), ObserverError> {
        Ok(())
    }
}

impl Persist for Stopwatch {
    fn persist(&mut self, archive: &mut Archive<'_>) -> Result<(), Error> {
        let mut seconds = self.seconds();
        archive.value("processor seconds", &mut seconds)?;
        if archive.is_reading() {
            *self = Self { before: seconds, ..Self::start() };
        }
        Ok(())
    }
}
