//! Runs on all cores, and sweeps in chunks between which a run can be stopped.

use super::Failure;
use super::interrupt::Interrupt;
use super::progress::Progress;
use gradient_mc::{Error, Outcome, Replicas};
use std::sync::Mutex;

/// Does `work` on every task, on `threads` threads (0: all cores); results in the order of the tasks.
pub fn in_parallel<Task, Output>(
    threads: usize,
    tasks: Vec<Task>,
    work: impl Fn(Task) -> Result<Output, Failure> + Sync,
) -> Result<Vec<Output>, Failure>
where
    Task: Send,
    Output: Send,
{
    let tasks: Vec<Mutex<Option<Task>>> = tasks.into_iter().map(|task| Mutex::new(Some(task))).collect();
    let outcomes = Replicas::new(1).threads(threads).run_each(&tasks, |task, _| {
        let task = task.lock().ok().and_then(|mut task| task.take()).ok_or("a task can be done once")?;
        work(task)
    });
    let outcomes = outcomes.map_err(|error| match error {
        Error::Replica { source, .. } => source,
        error => error.into(),
    })?;
    Ok(outcomes.into_iter().flat_map(Outcome::into_replicas).collect())
}

/// Number of threads that [`in_parallel`] takes for this request.
pub fn thread_count(threads: usize) -> usize {
    Replicas::new(1).threads(threads).thread_count()
}

/// Makes `sweeps` sweeps in chunks, reporting each; returns how many were made before an interrupt.
pub fn in_chunks(
    sweeps: u64,
    interrupt: &Interrupt,
    progress: &Progress,
    mut run: impl FnMut(u64) -> Result<(), gradient_mc::Error>,
) -> Result<u64, Failure> {
    const CHUNK: u64 = 25;
    let mut done = 0;
    while done < sweeps && !interrupt.pressed() {
        let chunk = CHUNK.min(sweeps - done);
        run(chunk)?;
        done += chunk;
        progress.advance(chunk);
    }
    Ok(done)
}
