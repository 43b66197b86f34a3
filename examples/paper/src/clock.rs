//! Time that work takes, free of what else the machine does.

use cpu_time::{ProcessTime, ThreadTime};

/// CPU seconds of this thread.
pub fn cpu_seconds() -> f64 {
    ThreadTime::now().as_duration().as_secs_f64()
}

/// CPU seconds of this process: the threads that may share a sweep are counted, others sleep.
pub fn process_cpu_seconds() -> f64 {
    ProcessTime::now().as_duration().as_secs_f64()
}
