//! Work on all cores.

use super::Failure;
use gradient_mc::{Error, Outcome, Replicas};
use std::sync::Mutex;

/// Calls `work` for every task on `threads` threads (0: all cores), and returns the results in the
/// order of the tasks. An error of one task does not affect the others.
pub fn in_parallel<Task: Send, Output: Send>(
    threads: usize,
    tasks: Vec<Task>,
    work: impl Fn(Task) -> Result<Output, Failure> + Sync,
) -> Result<Vec<Result<Output, Failure>>, Error> {
    let tasks: Vec<Mutex<Option<Task>>> = tasks.into_iter().map(|task| Mutex::new(Some(task))).collect();
    let outcomes = Replicas::new(1).threads(threads).run_each(&tasks, |task, _| {
        let task = task.lock().ok().and_then(|mut task| task.take()).ok_or("a task can only be run once")?;
        Ok(work(task))
    })?;
    Ok(outcomes.into_iter().flat_map(Outcome::into_replicas).collect())
}

/// Number of threads that [`in_parallel`] uses for this argument.
pub fn thread_count(threads: usize) -> usize {
    Replicas::new(1).threads(threads).thread_count()
}
