//! What every study has: one command line, a directory to write to, and one way to do many runs at once.

use super::interrupt::Interrupt;
use super::output::create_directory;
use super::progress::Progress;
use super::{Ending, Failure, conclude, replicas};
use clap::{Args, FromArgMatches};
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::ExitCode;

/// The options that every study has.
#[derive(Args, Debug, Clone)]
pub struct SharedArguments {
    /// Seed of the random numbers; run k takes the stream that belongs to seed and k
    #[arg(long, default_value_t = 1)]
    pub seed: u64,

    /// Threads, up to 1024; 0 takes all cores. The results do not depend on it
    #[arg(long, default_value_t = 0, value_parser = thread_count)]
    pub threads: usize,

    /// Directory for the CSV files and pictures [default: out/PROGRAM]
    #[arg(long)]
    pub out: Option<PathBuf>,

    /// A run of seconds that takes every path of the program. Its claims mean nothing: the exit code only says whether it came to
    /// its end
    #[arg(long)]
    pub short: bool,
}

/// A number of threads that a machine can be asked for without standing still.
fn thread_count(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(threads) if threads <= 1024 => Ok(threads),
        Ok(_) => Err("take at most 1024".into()),
        Err(error) => Err(format!("{error}")),
    }
}

/// That a signal has come: an error that ends a run early.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("interrupted: figures need complete runs")]
pub struct Interrupted;

/// A study that was started.
#[derive(Debug, Clone)]
pub struct Session {
    pub seed: u64,
    pub threads: usize,
    pub short: bool,
    /// As it was asked for, if it was.
    pub out: Option<PathBuf>,
    /// Where everything is written; it exists.
    pub directory: PathBuf,
    pub interrupt: Interrupt,
}

/// The program of a study: reads the command line, of which `Own` are the options that only this study has, runs it, and turns
/// what comes of it into the exit code.
pub fn main<Own: Args>(name: &'static str, run: fn(&Own, &Session) -> Result<Ending, Failure>) -> ExitCode {
    let (own, shared) = parse::<Own>(name, std::env::args_os()).unwrap_or_else(|error| error.exit());
    let short = shared.short;
    let outcome = Session::new(name, shared).and_then(|session| run(&own, &session));
    conclude(match outcome {
        Ok(Ending::ClaimFailed) if short => Ok(Ending::Finished),
        outcome => outcome,
    })
}

/// The options of this study, and those of every study.
pub fn parse<Own: Args>(
    name: &'static str,
    arguments: impl IntoIterator<Item = OsString>,
) -> Result<(Own, SharedArguments), clap::Error> {
    let command = Own::augment_args(SharedArguments::augment_args(clap::Command::new(name)));
    let matches = command.try_get_matches_from(arguments)?;
    Ok((Own::from_arg_matches(&matches)?, SharedArguments::from_arg_matches(&matches)?))
}

impl Session {
    /// Makes the directory, sees that it can be written to, and listens to signals: once per process.
    fn new(name: &str, shared: SharedArguments) -> Result<Self, Failure> {
        let SharedArguments { seed, threads, out, short } = shared;
        let directory = out.clone().unwrap_or_else(|| PathBuf::from("out").join(name));
        create_directory(&directory)?;
        Ok(Self { seed, threads, short, out, directory, interrupt: Interrupt::listen()? })
    }

    /// The seed of a run: the same for any number of threads.
    pub fn seed(&self, run: u64) -> u64 {
        // The generator scrambles its seed, so neighbors are as good as any.
        self.seed.wrapping_mul(1_000_003).wrapping_add(run)
    }

    /// One of two settings: of a run that counts, and of a short one.
    pub fn choose<T>(&self, usual: T, short: T) -> T {
        if self.short { short } else { usual }
    }

    /// The same session on so many threads.
    #[must_use]
    pub fn on_threads(&self, threads: usize) -> Self {
        Self { threads, ..self.clone() }
    }

    /// Does `work` on every task, on all threads, with a bar; results in the order of the tasks. The largest by `size` come first, so
    /// that the threads end together; `size` is in the units in which the work reports progress.
    pub fn run_all<Task: Send, Output: Send>(
        &self,
        what: &'static str,
        tasks: Vec<Task>,
        size: impl Fn(&Task) -> u64,
        work: impl Fn(Task, &Watch<'_>) -> Result<Output, Failure> + Sync + Send,
    ) -> Result<Vec<Output>, Failure> {
        let progress = Progress::new(tasks.iter().map(&size).sum(), what);
        let watch = Watch { interrupt: &self.interrupt, progress: &progress };
        let mut tasks: Vec<(usize, Task)> = tasks.into_iter().enumerate().collect();
        tasks.sort_by_key(|(_, task)| std::cmp::Reverse(size(task)));
        let done =
            replicas::in_parallel(self.threads, tasks, |(place, task)| Ok((place, work(task, &watch)?)));
        progress.finish();
        if self.interrupt.pressed() {
            return Err(Interrupted.into());
        }
        let mut done = done?;
        done.sort_by_key(|&(place, _)| place);
        Ok(done.into_iter().map(|(_, output)| output).collect())
    }

    /// The same where all tasks count alike.
    pub fn run_each<Task: Send, Output: Send>(
        &self,
        what: &'static str,
        tasks: Vec<Task>,
        work: impl Fn(Task) -> Result<Output, Failure> + Sync + Send,
    ) -> Result<Vec<Output>, Failure> {
        self.run_all(
            what,
            tasks,
            |_| 1,
            |task, watch| {
                watch.check()?;
                let output = work(task)?;
                watch.advance(1);
                Ok(output)
            },
        )
    }
}

/// What a run reports its progress to, and what tells it to stop.
#[derive(Debug, Clone, Copy)]
pub struct Watch<'a> {
    interrupt: &'a Interrupt,
    progress: &'a Progress,
}

impl Watch<'_> {
    /// Makes `sweeps` sweeps, each worth `size` units of progress. [`Interrupted`] ends it early.
    pub fn sweeps(
        &self,
        sweeps: u64,
        size: u64,
        mut run: impl FnMut(u64) -> Result<(), gradient_mc::Error>,
    ) -> Result<(), Failure> {
        let made = replicas::in_chunks(sweeps, self.interrupt, &Progress::hidden(), |chunk| {
            self.progress.advance(chunk * size);
            run(chunk)
        })?;
        if made < sweeps { Err(Interrupted.into()) } else { Ok(()) }
    }

    /// Reports progress.
    pub fn advance(&self, units: u64) {
        self.progress.advance(units);
    }

    /// [`Interrupted`] if a signal has come.
    pub fn check(&self) -> Result<(), Failure> {
        if self.interrupt.pressed() { Err(Interrupted.into()) } else { Ok(()) }
    }
}

/// From which side a column comes to its steady state: if two from both sides agree, both are there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// A random gas, far too high.
    Above,
    /// A crystal on the base, far too low.
    Below,
}

impl Side {
    pub const BOTH: [Self; 2] = [Self::Above, Self::Below];

    /// Sides by turns: of the run with this number.
    pub fn of(run: u64) -> Self {
        if run.is_multiple_of(2) { Self::Above } else { Self::Below }
    }
}

/// The whole number nearest to `number`, which is not negative and far below 2^53: spheres of a column, bins of a range, sweeps.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
pub fn count(number: f64) -> usize {
    number.round() as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Args, Debug)]
    struct Own {
        /// A number
        #[arg(long, default_value_t = 7)]
        number: u64,
    }

    fn session(threads: usize) -> Session {
        Session {
            seed: 2,
            threads,
            short: true,
            out: None,
            directory: PathBuf::new(),
            interrupt: Interrupt::silent(),
        }
    }

    #[test]
    fn own_options_stand_beside_those_of_every_study() {
        let parsed = |line: &str| parse::<Own>("study", line.split(' ').map(OsString::from));
        let (own, shared) = parsed("study --number 3 --short --threads 2").unwrap();
        assert_eq!((own.number, shared.seed, shared.threads, shared.short), (3, 1, 2, true));
        assert!(parsed("study").is_ok_and(|(own, shared)| own.number == 7 && !shared.short));
        assert!(parsed("study --threads 1025").is_err() && parsed("study --unknown").is_err());
    }

    #[test]
    fn results_are_in_the_order_of_the_tasks_for_any_number_of_threads() {
        for threads in [1, 3] {
            let squares = session(threads).run_all(
                "squares",
                vec![3_u64, 1, 2],
                |&task| task,
                |task, watch| {
                    watch.sweeps(task, 1, |_| Ok(()))?;
                    Ok(task * task)
                },
            );
            assert_eq!(squares.unwrap(), [9, 1, 4]);
        }
    }

    #[test]
    fn an_interrupt_ends_runs_and_is_told_from_other_failures() {
        let session = session(1);
        let work = |_: u64, watch: &Watch<'_>| {
            watch.check()?;
            session.interrupt.press();
            watch.sweeps(10, 1, |_| Ok(()))
        };
        let failure = session.run_all("nothing", vec![1, 2], |_| 1, work).unwrap_err();
        assert!(failure.is::<Interrupted>(), "{failure}");
        let other = super::tests::session(1).run_all(
            "nothing",
            vec![1],
            |_| 1,
            |_, _| Err::<(), Failure>("broken".into()),
        );
        assert!(!other.unwrap_err().is::<Interrupted>());
    }

    #[test]
    fn seeds_of_runs_are_apart_and_short_runs_are_short() {
        let session = session(1);
        assert_eq!(session.seed(5), 2_000_011);
        assert_eq!((session.choose(100, 1), count(2.5), count(0.2)), (1, 3, 0));
        assert_eq!([0, 1, 2].map(Side::of), [Side::Above, Side::Below, Side::Above]);
    }
}
