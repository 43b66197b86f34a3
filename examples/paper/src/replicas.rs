//! Independent replicas on all cores, with results that do not depend on how many there are.

use super::Failure;
use super::interrupt::Interrupt;
use super::progress::Progress;
use rayon::prelude::*;

/// Does `work` on every task, on `threads` threads (0: all cores); results in the order of the tasks.
pub fn in_parallel<Task, Output>(
    threads: usize,
    tasks: Vec<Task>,
    work: impl Fn(Task) -> Result<Output, Failure> + Sync + Send,
) -> Result<Vec<Output>, Failure>
where
    Task: Send,
    Output: Send,
{
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    // One task at a time to each thread: they are few and long.
    pool.install(|| tasks.into_par_iter().with_max_len(1).map(work).collect())
}

/// Number of threads that [`in_parallel`] takes for this request.
pub fn thread_count(threads: usize) -> usize {
    if threads > 0 { threads } else { std::thread::available_parallelism().map_or(1, usize::from) }
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
