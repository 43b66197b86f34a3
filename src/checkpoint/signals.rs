//! Signals that end a run with everything written.

use crate::Error;
#[cfg(unix)]
use signal_hook::consts::{SIGHUP, SIGUSR1};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether the process was told to stop: by SIGINT (Ctrl-C), SIGTERM, SIGHUP or SIGUSR1, which
/// queues can be told to send some time before the end. For [`Run::stop_on`](super::Run::stop_on).
///
/// A second SIGINT ends the process at once, with exit code 130; checkpoints that were written are
/// intact.
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
    /// Listens from now on, until the process ends.
    ///
    /// # Errors
    /// [`Error::Custom`] with what the system said.
    pub fn listen() -> Result<Self, Error> {
        /// As shells have it.
        const INTERRUPTED: i32 = 128 + SIGINT;
        let flag = Arc::new(AtomicBool::new(false));
        let listen = || {
            // In this order: the first SIGINT still finds the flag down.
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

    /// True once a signal has come.
    #[must_use]
    pub fn flag(&self) -> &AtomicBool {
        &self.0
    }

    /// Whether a signal has come.
    #[must_use]
    pub fn received(&self) -> bool {
        self.0.load(Ordering::SeqCst)
    }
}
