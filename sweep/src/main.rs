//! The program: reads the command line and the table, and runs the simulations.

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

/// Simulates every scene of a table on all ranks and threads, and writes one table of results. If
/// it was stopped or killed, the same command continues. Exit code: 0 finished, 1 a run failed, 2
/// invalid table or command, 75 stopped by a signal
#[derive(Parser, Debug)]
#[command(name = "gradient-mc-sweep")]
struct Arguments {
    /// Table of scenes (TOML)
    table: PathBuf,

    /// Folder of results and checkpoints, shared by all ranks [default: out/TABLE]
    #[arg(long)]
    out: Option<PathBuf>,

    /// Simultaneous runs of every rank
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: u16,

    /// Only check the table and print the number of runs
    #[arg(long, group = "instead")]
    check: bool,

    /// Run only this share of the runs, counted from 0, for example 3/100
    #[arg(long, group = "instead", value_parser = share)]
    share: Option<[usize; 2]>,

    /// Only write the tables of results of the finished runs
    #[arg(long, group = "instead")]
    merge: bool,

    /// Seconds between checkpoints
    #[arg(long, default_value = "60", value_parser = seconds)]
    checkpoint_every: Duration,

    /// Seconds without a message after which a rank is given up; ranks send one every second
    #[arg(long, default_value = "60", value_parser = seconds)]
    patience: Duration,
}

/// Exit code for an invalid table or command line.
const REFUSED: u8 = 2;
/// Exit code after a signal: `EX_TEMPFAIL` of <sysexits.h>.
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

/// Writes a line, and ignores errors of a closed stream.
fn say(mut stream: impl io::Write, line: impl std::fmt::Display) {
    writeln!(stream, "{line}").ok();
}

fn main() -> ExitCode {
    #[cfg(feature = "mpi")]
    let link = gradient_mc_sweep::MpiLink::new();
    #[cfg(not(feature = "mpi"))]
    let link = Some(gradient_mc_sweep::link::Alone);
    let Some(mut link) = link else {
        say(io::stderr(), "error: MPI cannot be initialized");
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

/// Whether a signal was received.
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
        say(io::stderr(), format_args!("error: rank {} gets no messages of rank 0", link.rank()));
        link.abort(1);
    }
    Ok(0)
}

/// The job to run or to merge; `None` if the table is only checked.
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
        // Finalizing MPI would wait for the lost ranks.
        link.abort(1);
    }
    Ok(code)
}

/// Unfinished tasks, the longest first, so that all ranks end at about the same time.
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
        format_args!("{scenes} scenes, {runs} runs, at most {:.1e} sweeps times spheres", work as f64),
    );
}

/// Writes and prints the results; returns the exit code.
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
        say(io::stderr(), format_args!("error: {failed_runs} runs failed; the same command repeats them"));
    }
    if job.is_stopping() {
        say(io::stderr(), "stopped; continue with the same command");
        return Ok(STOPPED);
    }
    Ok(u8::from(is_bad))
}
