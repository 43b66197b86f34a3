//! Time that work takes, free of what else the machine does.

use rustix::time::{ClockId, clock_gettime};

/// CPU seconds of this thread.
pub fn cpu_seconds() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}
