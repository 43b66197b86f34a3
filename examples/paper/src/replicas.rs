//! Work on all cores.

use super::Failure;
use gradient_mc::{Error, Outcome, Replicas};
use std::sync::Mutex;

/// Does `work` on every task, on `threads` threads (0: all cores); what comes of each, in their
/// order. An error in one costs none of the others.
pub fn in_parallel<Task: Send, Output: Send>(
    threads: usize,
    tasks: Vec<Task>,
    work: impl Fn(Task) -> Result<Output, Failure> + Sync,
) -> Result<Vec<Result<Output, Failure>>, Error> {
    let tasks: Vec<Mutex<Option<Task>>> = tasks.into_iter().map(|task| Mutex::new(Some(task))).collect();
    let outcomes = Replicas::new(1).threads(threads).run_each(&tasks, |task, _| {
        let task = task.lock().ok().and_then(|mut task| task.take()).ok_or("a task can be done once")?;
        Ok(work(task))
    })?;
    Ok(outcomes.into_iter().flat_map(Outcome::into_replicas).collect())
}

/// Number of threads that [`in_parallel`] takes for this request.
pub fn thread_count(threads: usize) -> usize {
    Replicas::new(1).threads(threads).thread_count()
}
