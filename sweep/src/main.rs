//! The program: reads the command line and the table, and has the ranks do what it says.

use clap::Parser;
use gradient_mc::checkpoint::Signals;
use gradient_mc_sweep::crew::Ended;
use gradient_mc_sweep::dispatch::State;
use gradient_mc_sweep::link::{Link, Message};
use gradient_mc_sweep::results::{self, Written};
use gradient_mc_sweep::{Failure, Folder, Job, Table, crew};
use std::cmp::Reverse;
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Simulates every scene of a table, on as many cores as there are ranks and threads, and writes
/// one table of results. The same command goes on where it was stopped or killed. Exit code: 0
/// finished, 1 some run failed, 2 bad table or command, 75 stopped by a signal
#[derive(Parser, Debug)]
#[command(name = "gradient-mc-sweep")]
struct Arguments {
    /// The table of scenes (TOML)
    table: PathBuf,

    /// Folder of results and checkpoints, which all ranks see [default: out/TABLE]
    #[arg(long)]
    out: Option<PathBuf>,

    /// Runs at a time, of every rank
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: u16,

    /// Only says what is in the table
    #[arg(long, group = "instead")]
    check: bool,

    /// Does only this share of the runs, counted from 0: 3/100
    #[arg(long, group = "instead", value_parser = share)]
    share: Option<[usize; 2]>,

    /// Simulates nothing: writes the tables of what is finished
    #[arg(long, group = "instead")]
    merge: bool,

    /// Seconds between checkpoints
    #[arg(long, default_value = "60", value_parser = seconds)]
    checkpoint_every: Duration,

    /// Seconds after which a rank that says nothing is given up; ranks say something every second
    #[arg(long, default_value = "60", value_parser = seconds)]
    patience: Duration,
}

/// Bad table or command line.
const REFUSED: u8 = 2;
/// "Try again later", as <sysexits.h> has it.
const STOPPED: u8 = 75;

fn share(text: &str) -> Result<[usize; 2], String> {
    let parts =
        text.split_once('/').and_then(|(part, parts)| Some([part.parse().ok()?, parts.parse().ok()?]));
    parts.filter(|[part, parts]| part < parts).ok_or_else(|| "write it as 0/4, 1/4, 2/4 or 3/4".into())
}

fn seconds(text: &str) -> Result<Duration, String> {
    text.parse()
        .map_err(|_| "not a number".into())
        .and_then(|seconds| Duration::try_from_secs_f64(seconds).map_err(|error| error.to_string()))
}

/// A line to a stream that nobody may read on.
fn say(mut stream: impl io::Write, line: impl std::fmt::Display) {
    writeln!(stream, "{line}").ok();
}

fn main() -> ExitCode {
    #[cfg(feature = "mpi")]
    let link = gradient_mc_sweep::MpiLink::new();
    #[cfg(not(feature = "mpi"))]
    let link = Some(gradient_mc_sweep::link::Alone);
    let Some(mut link) = link else {
        say(io::stderr(), "error: MPI does not start");
        return ExitCode::FAILURE;
    };
    ExitCode::from(run(&mut link))
}

fn run(link: &mut dyn Link) -> u8 {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            if link.rank() == 0 {
                error.print().ok();
            }
            return if error.use_stderr() { REFUSED } else { 0 };
        }
    };
    let outcome = if link.rank() == 0 { lead(&arguments, link) } else { follow(&arguments, link) };
    outcome.unwrap_or_else(|(code, why)| {
        say(io::stderr(), format_args!("error: {why}"));
        code
    })
}

type Refusal = (u8, String);

fn failed(failure: impl Into<Failure>) -> Refusal {
    (1, failure.into().explained())
}

impl Arguments {
    fn job(&self, table: Table) -> Result<Job, Refusal> {
        let name = self.table.file_stem().unwrap_or_default();
        let out = self.out.clone().unwrap_or_else(|| Path::new("out").join(name));
        Ok(Job {
            table,
            folder: Folder::new(&out).map_err(failed)?,
            checkpoint_every: self.checkpoint_every,
            patience: self.patience,
            stop: AtomicBool::new(false),
        })
    }

    /// Reads the table.
    fn read(&self) -> Result<(String, Table), Refusal> {
        let path = self.table.display();
        let text =
            std::fs::read_to_string(&self.table).map_err(|error| (REFUSED, format!("{path}: {error}")))?;
        let table = Table::read(&text).map_err(|error| (REFUSED, format!("{path}, {error}")))?;
        Ok((text, table))
    }
}

/// Whether a signal has come.
fn signals() -> Result<impl Fn() -> bool, Refusal> {
    let signals = Signals::listen().map_err(failed)?;
    Ok(move || signals.received())
}

fn follow(arguments: &Arguments, link: &mut dyn Link) -> Result<u8, Refusal> {
    let signaled = signals()?;
    let Some(text) = crew::await_table(link, arguments.patience) else {
        return Ok(0);
    };
    let table = Table::read(&text).map_err(|error| (REFUSED, error.to_string()))?;
    let job = arguments.job(table)?;
    if !crew::follow(&job, link, arguments.threads.into(), &signaled) {
        say(io::stderr(), format_args!("error: rank {} hears nothing of rank 0", link.rank()));
        link.abort(1);
    }
    Ok(0)
}

/// What there is to run or to merge; nothing if the table was only to be checked.
fn prepare(arguments: &Arguments) -> Result<Option<(String, Job)>, Refusal> {
    let (text, table) = arguments.read()?;
    if arguments.check {
        describe(&table);
        return Ok(None);
    }
    Ok(Some((text, arguments.job(table)?)))
}

fn lead(arguments: &Arguments, link: &mut dyn Link) -> Result<u8, Refusal> {
    let signaled = signals()?;
    let prepared = prepare(arguments);
    let runs = matches!(prepared, Ok(Some(_))) && !arguments.merge;
    for rank in 1..link.ranks() {
        let table = prepared.as_ref().ok().and_then(|prepared| prepared.as_ref()).filter(|_| runs);
        link.send(rank, &table.map_or(Message::End, |(text, _)| Message::Table(text.clone())));
    }
    let Some((_, job)) = prepared? else { return Ok(0) };
    let mut ended = Ended { states: vec![State::Waiting; job.table.tasks().len()], lost_ranks: 0 };
    if runs {
        ended = crew::lead(&job, link, arguments.threads.into(), queue(&job, arguments.share), &signaled);
    }
    let code = report(&job, &ended, arguments)?;
    if ended.lost_ranks > 0 {
        // The end of MPI would wait for them.
        link.abort(1);
    }
    Ok(code)
}

/// Tasks that are not finished, the longest first, so that no rank is left alone with one at the
/// end.
fn queue(job: &Job, share: Option<[usize; 2]>) -> Vec<usize> {
    let [part, parts] = share.unwrap_or([0, 1]);
    let tasks = job.table.tasks();
    let is_due = |&number: &usize| number % parts == part && !job.is_finished(tasks[number]);
    let mut queue: Vec<usize> = (0..tasks.len()).filter(is_due).collect();
    queue.sort_by_key(|&number| Reverse(job.table.cases[tasks[number].case].work()));
    queue
}

fn describe(table: &Table) {
    let work: u64 =
        table.tasks().iter().fold(0, |sum, task| sum.saturating_add(table.cases[task.case].work()));
    let (scenes, runs) = (table.cases.len(), table.tasks().len());
    say(
        io::stdout(),
        format_args!("{scenes} scenes, {runs} runs, {:.1e} sweeps of a sphere at most", work as f64),
    );
}

/// Writes the results and says what became of the runs; the exit code.
fn report(job: &Job, ended: &Ended, arguments: &Arguments) -> Result<u8, Refusal> {
    let count = |is: fn(&State) -> bool| ended.states.iter().filter(|state| is(state)).count();
    let failed_runs = count(|state| matches!(state, State::Failed(_) | State::Lost { .. }));
    let mut is_bad = failed_runs > 0;
    if arguments.share.is_none() {
        let Written { measured, failures } =
            job.write_results(|number| ended.states[number].clone()).map_err(failed)?;
        for (case, of_case) in &measured {
            say(io::stdout(), results::line(case, of_case, &job.table.packing_fractions));
        }
        for (name, failure) in &failures {
            say(io::stderr(), format_args!("error: {name}: {}", failure.explained()));
        }
        is_bad |= !failures.is_empty();
        say(io::stdout(), format_args!("written to {}", job.folder.results("results.csv").display()));
    }
    if failed_runs > 0 {
        say(
            io::stderr(),
            format_args!("error: {failed_runs} runs failed; the same command tries them again"),
        );
    }
    if job.is_stopping() {
        say(io::stderr(), "stopped; the same command goes on");
        return Ok(STOPPED);
    }
    Ok(u8::from(is_bad))
}
