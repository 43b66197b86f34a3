//! Ctrl-C: stop at the next chance and keep what was measured.

use super::Failure;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether Ctrl-C was pressed. The first press asks for a clean stop, the second ends the process.
#[derive(Debug, Clone)]
pub struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Starts listening; once per process.
    pub fn listen() -> Result<Self, Failure> {
        let pressed = Arc::new(AtomicBool::new(false));
        let seen = Arc::clone(&pressed);
        ctrlc::set_handler(move || {
            if seen.swap(true, Ordering::SeqCst) {
                std::process::exit(130);
            }
            eprintln!("stopping after the sweeps under way; once more to give up what was measured");
        })?;
        Ok(Self(pressed))
    }

    /// One that listens to nobody.
    #[cfg(test)]
    pub(crate) fn silent() -> Self {
        Self(Arc::default())
    }

    /// As Ctrl-C does.
    #[cfg(test)]
    pub(crate) fn press(&self) {
        self.0.store(true, Ordering::SeqCst);
    }

    /// Whether a clean stop was asked for.
    pub fn pressed(&self) -> bool {
        self.0.load(Ordering::SeqCst)
    }
}
