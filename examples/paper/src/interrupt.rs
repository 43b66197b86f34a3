//! Signals: stop at the next possible point and keep the data.

use super::Failure;
use gradient_mc::checkpoint::Signals;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Receives the signals of Ctrl-C, SIGTERM, SIGUSR1 and SIGHUP. The first requests a clean stop; a
/// second Ctrl-C ends the process, with the last checkpoints intact.
#[derive(Debug, Clone)]
pub struct Interrupt {
    signals: Option<Signals>,
    /// Whether the signal has been reported.
    noticed: Arc<AtomicBool>,
}

impl Interrupt {
    /// Starts to receive signals; once per process.
    pub fn listen() -> Result<Self, Failure> {
        Ok(Self { signals: Some(Signals::listen()?), noticed: Arc::default() })
    }

    /// An instance without signals, for tests.
    #[cfg(test)]
    pub(crate) fn silent() -> Self {
        Self { signals: None, noticed: Arc::default() }
    }

    /// Sets the flag as a signal does.
    #[cfg(test)]
    pub(crate) fn press(&self) {
        self.noticed.store(true, Ordering::SeqCst);
    }

    /// Whether a clean stop was requested.
    pub fn pressed(&self) -> bool {
        if self.flag().load(Ordering::SeqCst) && !self.noticed.swap(true, Ordering::SeqCst) {
            eprintln!("stopping after the current step; press Ctrl-C again to stop at once");
        }
        self.noticed.load(Ordering::SeqCst)
    }

    /// The flag, true after a request of a clean stop.
    pub fn flag(&self) -> &AtomicBool {
        self.signals.as_ref().map_or(&self.noticed, Signals::flag)
    }
}
