//! Signals: stop at the next chance and keep what was measured.

use super::Failure;
use gradient_mc::checkpoint::Signals;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether the process was told to stop: by Ctrl-C, by SIGTERM or SIGUSR1, as queues do, or because
/// its terminal is gone (SIGHUP). The first asks for a clean stop; a second Ctrl-C ends the
/// process, with the last checkpoints intact.
#[derive(Debug, Clone)]
pub struct Interrupt {
    signals: Option<Signals>,
    /// Whether somebody has been told that one has come.
    noticed: Arc<AtomicBool>,
}

impl Interrupt {
    /// Starts listening; once per process.
    pub fn listen() -> Result<Self, Failure> {
        Ok(Self { signals: Some(Signals::listen()?), noticed: Arc::default() })
    }

    /// One that listens to nobody.
    #[cfg(test)]
    pub(crate) fn silent() -> Self {
        Self { signals: None, noticed: Arc::default() }
    }

    /// As a signal does.
    #[cfg(test)]
    pub(crate) fn press(&self) {
        self.noticed.store(true, Ordering::SeqCst);
    }

    /// Whether a clean stop was asked for.
    pub fn pressed(&self) -> bool {
        if self.flag().load(Ordering::SeqCst) && !self.noticed.swap(true, Ordering::SeqCst) {
            eprintln!("stopping after what is under way; Ctrl-C once more stops at once");
        }
        self.noticed.load(Ordering::SeqCst)
    }

    /// True once a clean stop was asked for.
    pub fn flag(&self) -> &AtomicBool {
        self.signals.as_ref().map_or(&self.noticed, Signals::flag)
    }
}
