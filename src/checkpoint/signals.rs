//! Signals that end a run after a checkpoint.

use crate::Error;
#[cfg(unix)]
use signal_hook::consts::{SIGHUP, SIGUSR1};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Receives the signals SIGINT (Ctrl-C), SIGTERM, SIGHUP and SIGUSR1, to end a run by
/// [`Run::stop_on`](super::Run::stop_on). Queues can send SIGUSR1 some time before the time limit.
///
/// A second SIGINT ends the process at once, with exit code 130; written checkpoints stay intact.
///
/// ```
/// use gradient_mc::checkpoint::Signals;
/// let signals = Signals::listen()?;
/// assert!(!signals.received());
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Signals(Arc<AtomicBool>);

impl Signals {
    /// Starts to receive signals, until the process ends.
    ///
    /// # Errors
    /// [`Error::Custom`] with the error of the system.
    pub fn listen() -> Result<Self, Error> {
        /// Exit code of a process that SIGINT ended, as in shells.
        const INTERRUPTED: i32 = 128 + SIGINT;
        let flag = Arc::new(AtomicBool::new(false));
        let listen = || {
            // The order matters: at the first SIGINT the flag is still false.
            flag::register_conditional_shutdown(SIGINT, INTERRUPTED, Arc::clone(&flag))?;
            #[cfg(unix)]
            let others = [SIGTERM, SIGHUP, SIGUSR1];
            #[cfg(not(unix))]
            let others = [SIGTERM];
            for signal in [SIGINT].into_iter().chain(others) {
                flag::register(signal, Arc::clone(&flag))?;
            }
            Ok::<(), std::io::Error>(())
        };
        listen().map_err(|error| Error::Custom(error.into()))?;
        Ok(Self(flag))
    }

    /// The flag, true after a signal.
    #[must_use]
    pub fn flag(&self) -> &AtomicBool {
        &self.0
    }

    /// Whether a signal has been received.
    #[must_use]
    pub fn received(&self) -> bool {
        self.0.load(Ordering::SeqCst)
    }
}
