//! The common part of all studies: command line, output directory, and parallel runs.

use super::interrupt::Interrupt;
use super::output::create_directory;
use super::progress::Progress;
use super::unfinished::Unfinished;
use super::watch::{Interrupted, Watch, explained};
use super::{Ending, Failure, conclude, replicas};
use clap::{Args, FromArgMatches};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::ffi::OsString;
use std::fmt::Debug;
#[cfg(test)]
use std::path::Path;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

/// The options of every study.
#[derive(Args, Debug, Clone)]
pub struct SharedArguments {
    /// Seed of the random numbers; each run gets its own stream
    #[arg(long, default_value_t = 1)]
    pub seed: u64,

    /// Number of threads, up to 1024; 0 uses all cores. The results do not depend on it
    #[arg(long, default_value_t = 0, value_parser = thread_count)]
    pub threads: usize,

    /// Directory for the CSV files and pictures [default: out/PROGRAM]
    #[arg(long)]
    pub out: Option<PathBuf>,

    /// Start again instead of continuing an interrupted run
    #[arg(long)]
    pub fresh: bool,

    /// Run only some seconds, to test the program. Its claims have no meaning, and the exit code
    /// only tells whether it finished
    #[arg(long)]
    pub short: bool,
}

/// Reads a number of threads, with an upper limit.
fn thread_count(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(threads) if threads <= 1024 => Ok(threads),
        Ok(_) => Err("use at most 1024".into()),
        Err(error) => Err(format!("{error}")),
    }
}

/// A running study.
#[derive(Debug, Clone)]
pub struct Session {
    pub seed: u64,
    pub threads: usize,
    pub short: bool,
    /// Whether to start again instead of continuing an interrupted run.
    pub fresh: bool,
    /// The option `--out`, if given.
    pub out: Option<PathBuf>,
    /// The output directory, which exists.
    pub directory: PathBuf,
    pub interrupt: Interrupt,
    /// The data from which an interrupted study continues.
    pub unfinished: Arc<Unfinished>,
}

/// The main function of a study: reads the command line with its own options `Own`, runs the study,
/// and returns the exit code. The data of interrupted runs are removed when it is complete.
pub fn main<Own: Args + Debug>(
    name: &'static str,
    run: fn(&Own, &Session) -> Result<Ending, Failure>,
) -> ExitCode {
    let (own, shared) = parse::<Own>(name, std::env::args_os()).unwrap_or_else(|error| error.exit());
    let short = shared.short;
    let outcome = Session::new(name, shared, &own).and_then(|session| {
        let ending = run(&own, &session);
        let unfinished = session.unfinished;
        if matches!(ending, Ok(Ending::Finished | Ending::ClaimFailed)) || unfinished.is_empty() {
            unfinished.remove()?;
        } else {
            eprintln!("the same command continues from {}", unfinished.folder().display());
        }
        ending
    });
    conclude(match outcome {
        Ok(Ending::ClaimFailed) if short => Ok(Ending::Finished),
        outcome => outcome,
    })
}

/// Reads the options of this study, and the common ones.
pub fn parse<Own: Args>(
    name: &'static str,
    arguments: impl IntoIterator<Item = OsString>,
) -> Result<(Own, SharedArguments), clap::Error> {
    let command = Own::augment_args(SharedArguments::augment_args(clap::Command::new(name)));
    let matches = command.try_get_matches_from(arguments)?;
    Ok((Own::from_arg_matches(&matches)?, SharedArguments::from_arg_matches(&matches)?))
}

impl Session {
    /// Makes the directory, checks that it is writable and not used by another process, and starts
    /// to receive signals; once per process.
    fn new(name: &str, shared: SharedArguments, own: &impl Debug) -> Result<Self, Failure> {
        let SharedArguments { seed, threads, out, fresh, short } = shared;
        let directory = out.clone().unwrap_or_else(|| PathBuf::from("out").join(name));
        create_directory(&directory)?;
        let options = format!("{own:#?}\nseed: {seed}\nshort: {short}\n");
        let unfinished = Arc::new(Unfinished::open(&directory, &options, fresh)?);
        Ok(Self { seed, threads, short, fresh, out, directory, interrupt: Interrupt::listen()?, unfinished })
    }

    /// A session without signals, for tests.
    #[cfg(test)]
    pub(crate) fn silent(directory: &Path, threads: usize) -> Self {
        let unfinished = Arc::new(Unfinished::open(directory, "", false).unwrap());
        let interrupt = Interrupt::silent();
        Self {
            seed: 2,
            threads,
            short: true,
            fresh: false,
            out: None,
            directory: directory.into(),
            interrupt,
            unfinished,
        }
    }

    /// The seed of a run: the same for any number of threads.
    pub fn seed(&self, run: u64) -> u64 {
        // The generator scrambles its seed, so neighboring seeds are independent.
        self.seed.wrapping_mul(1_000_003).wrapping_add(run)
    }

    /// One of two settings: for a usual run or a short one.
    pub fn choose<T>(&self, usual: T, short: T) -> T {
        if self.short { short } else { usual }
    }

    /// The same session with this number of threads.
    #[must_use]
    pub fn on_threads(&self, threads: usize) -> Self {
        Self { threads, ..self.clone() }
    }

    /// Calls `work` for every task on all threads, with a progress bar, and returns the results in
    /// the order of the tasks. The largest tasks by `size` are started first, so that the threads
    /// end at about the same time; `size` is in the units of progress.
    ///
    /// An error of one task does not affect the others. A signal ends running tasks after a
    /// checkpoint.
    pub fn try_all<Task: Send, Output: Send>(
        &self,
        what: &'static str,
        tasks: Vec<Task>,
        size: impl Fn(&Task) -> u64,
        work: impl Fn(Task, &Watch<'_>) -> Result<Output, Failure> + Sync + Send,
    ) -> Result<Vec<Result<Output, Failure>>, Failure> {
        let progress = Progress::new(tasks.iter().map(&size).sum(), what);
        let mut tasks: Vec<(usize, Task)> = tasks.into_iter().enumerate().collect();
        tasks.sort_by_key(|(_, task)| std::cmp::Reverse(size(task)));
        let places: Vec<usize> = tasks.iter().map(|&(place, _)| place).collect();
        let done = replicas::in_parallel(self.threads, tasks, |(place, task)| {
            let watch = Watch::new(&self.interrupt, &progress, self.unfinished.of_task(what, place));
            watch.check()?;
            work(task, &watch)
        })?;
        progress.finish();
        let mut done: Vec<_> = places.into_iter().zip(done).collect();
        done.sort_by_key(|&(place, _)| place);
        Ok(done.into_iter().map(|(_, outcome)| outcome).collect())
    }

    /// [`try_all`](Self::try_all) for named tasks that are all needed: if some fail, it returns all
    /// their errors after the others have ended.
    pub fn run_all<Task: Send, Output: Send>(
        &self,
        what: &'static str,
        tasks: Vec<Task>,
        name: impl Fn(&Task) -> String,
        size: impl Fn(&Task) -> u64,
        work: impl Fn(Task, &Watch<'_>) -> Result<Output, Failure> + Sync + Send,
    ) -> Result<Vec<Output>, Failure> {
        let names: Vec<String> = tasks.iter().map(name).collect();
        let outcomes = self.try_all(what, tasks, size, work)?;
        let (mut outputs, mut failures, mut interrupted) = (Vec::new(), Vec::new(), false);
        for (name, outcome) in names.iter().zip(outcomes) {
            match outcome {
                Ok(output) => outputs.push(output),
                Err(failure) if failure.is::<Interrupted>() => interrupted = true,
                Err(failure) => failures.push(format!("{what}, {name}: {}", explained(&*failure))),
            }
        }
        if !failures.is_empty() {
            return Err(failures.join("\n").into());
        }
        if interrupted { Err(Interrupted.into()) } else { Ok(outputs) }
    }

    /// [`run_all`](Self::run_all) for short tasks of equal size. An interrupted task starts again,
    /// so that measured times are of one process; finished tasks are kept.
    pub fn run_each<Task: Send, Output: Send + Serialize + DeserializeOwned>(
        &self,
        what: &'static str,
        tasks: Vec<Task>,
        name: impl Fn(&Task) -> String + Sync,
        work: impl Fn(Task) -> Result<Output, Failure> + Sync + Send,
    ) -> Result<Vec<Output>, Failure> {
        self.run_all(what, tasks, &name, |_| 1, |task, watch| watch.kept(&name(&task), 1, || work(task)))
    }
}

/// Side from which a column relaxes to its steady state. If columns from both sides agree, both are
/// equilibrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// From a random gas, far too high.
    Above,
    /// From a crystal on the base, far too low.
    Below,
}

impl Side {
    pub const BOTH: [Self; 2] = [Self::Above, Self::Below];

    /// The side of the run with this number, alternating.
    pub fn of(run: u64) -> Self {
        if run.is_multiple_of(2) { Self::Above } else { Self::Below }
    }
}

/// Rounds a number that is not negative and far below 2^53, such as a number of spheres, bins or
/// sweeps.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
pub fn count(number: f64) -> usize {
    number.round() as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use gradient_mc::checkpoint::{Archive, Persist};
    use gradient_mc::field::UniformField;
    use gradient_mc::observers::CenterOfMass;
    use gradient_mc::temperature::Isothermal;
    use gradient_mc::{Frame, Observer, ObserverError, ObserverFn, Scene, Simulation, Slab};
    use std::sync::Mutex;
    use tempfile::tempdir;

    #[derive(Args, Debug)]
    struct Own {
        /// A number
        #[arg(long, default_value_t = 7)]
        number: u64,
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
            let directory = tempdir().unwrap();
            let session = Session::silent(directory.path(), threads);
            let squares = session.run_all(
                "squares",
                vec![3_u64, 1, 2],
                u64::to_string,
                |&task| task,
                |task, _| Ok(task * task),
            );
            assert_eq!(squares.unwrap(), [9, 1, 4]);
        }
    }

    fn column() -> Simulation<UniformField, Isothermal> {
        let slab = Slab::new(30.0, 4.0, 4.0).unwrap();
        let scene = Scene::new(slab, 40, UniformField::default(), Isothermal::new(4.0).unwrap()).unwrap();
        Simulation::builder(scene).build().unwrap()
    }

    /// Three stages, and what they end with; a signal comes after so many sweeps.
    fn stages(session: &Session, signal: u64) -> Result<Vec<(Vec<f64>, u64)>, Failure> {
        let work = |_: u8, watch: &Watch<'_>| {
            let (mut simulation, mut center) =
                (column(), (CenterOfMass::new(), SignalAfter(signal, session)));
            watch.equilibrate(&mut simulation, 20, 1, &mut center)?;
            watch.run(&mut simulation, 20, 1, &mut center)?;
            let mut other = column();
            watch.equilibrate(&mut other, 10, 1, &mut ())?;
            Ok((center.0.heights().to_vec(), simulation.sweep() + other.sweep()))
        };
        session.run_all("columns", vec![0], u8::to_string, |_| 50, work)
    }

    struct SignalAfter<'a>(u64, &'a Session);

    impl Observer for SignalAfter<'_> {
        fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
            if frame.sweep() == self.0 {
                self.1.interrupt.press();
            }
            Ok(())
        }
    }

    impl Persist for SignalAfter<'_> {
        fn persist(&mut self, _: &mut Archive<'_>) -> Result<(), gradient_mc::Error> {
            Ok(())
        }
    }

    #[test]
    fn a_task_goes_on_within_the_stage_in_which_it_was_interrupted() {
        let (undisturbed, interrupted) = (tempdir().unwrap(), tempdir().unwrap());
        let expected = stages(&Session::silent(undisturbed.path(), 1), 0).unwrap();
        assert_eq!((expected[0].0.len(), expected[0].1), (40, 50));
        for signal in [7, 33] {
            let failure = stages(&Session::silent(interrupted.path(), 1), signal).unwrap_err();
            assert!(failure.is::<Interrupted>(), "{failure}");
        }
        assert_eq!(stages(&Session::silent(interrupted.path(), 1), 0).unwrap(), expected);
    }

    #[test]
    fn an_error_in_one_task_costs_none_of_the_others() {
        let directory = tempdir().unwrap();
        let session = Session::silent(directory.path(), 1);
        let done = Mutex::new(Vec::new());
        let work = |task: u64| {
            if task == 2 {
                let mut cause = ObserverFn::new(|_| Err("a cause".into()));
                column().run(1, &mut cause)?;
            }
            done.lock().unwrap().push(task);
            Ok(10 * task)
        };
        let failure =
            session.run_each("numbers", vec![1, 2, 3], u64::to_string, work).unwrap_err().to_string();
        assert!(failure.starts_with("numbers, 2: "), "{failure}");
        assert_eq!(failure.matches("a cause").count(), 1, "{failure}");
        assert_eq!(*done.lock().unwrap(), [1, 3]);
        // What is done is not done again.
        let again = session.run_each("numbers", vec![1, 2, 3], u64::to_string, |task: u64| Ok(task));
        assert_eq!(again.unwrap(), [10, 2, 30]);
        session.interrupt.press();
        let failure = session.run_each("others", vec![1], u64::to_string, |task: u64| Ok(task)).unwrap_err();
        assert!(failure.is::<Interrupted>(), "{failure}");
    }

    #[test]
    fn seeds_of_runs_are_apart_and_short_runs_are_short() {
        let directory = tempdir().unwrap();
        let session = Session::silent(directory.path(), 1);
        assert_eq!(session.seed(5), 2_000_011);
        assert_eq!((session.choose(100, 1), count(2.5), count(0.2)), (1, 3, 0));
        assert_eq!([0, 1, 2].map(Side::of), [Side::Above, Side::Below, Side::Above]);
    }
}
