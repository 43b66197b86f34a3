//! What the examples share: command line, progress, replicas in parallel, CSV files and pictures.

// Each example is a program of its own and uses a part of this.
#![allow(dead_code, reason = "no example uses all of it")]

pub(crate) mod accuracy;
pub(crate) mod arguments;
pub(crate) mod captions;
pub(crate) mod clock;
pub(crate) mod figure;
pub(crate) mod groups;
pub(crate) mod interrupt;
pub(crate) mod output;
pub(crate) mod progress;
pub(crate) mod replicas;
pub(crate) mod table;
pub(crate) mod verdict;
pub(crate) mod warnings;

use std::process::ExitCode;

/// Whatever stops an example.
pub(crate) type Failure = Box<dyn std::error::Error + Send + Sync>;

/// How an example that did not fail came to its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ending {
    /// Everything was done, and what the example claims held.
    Finished,
    /// Ctrl-C: what was measured by then is written.
    Interrupted,
    /// Everything was done, and the data contradict what the example claims.
    ClaimFailed,
}

/// Turns the outcome of an example into the exit code of the process, and prints the chain of errors.
pub(crate) fn conclude(outcome: Result<Ending, Failure>) -> ExitCode {
    match outcome {
        Ok(Ending::Finished) => ExitCode::SUCCESS,
        Ok(Ending::ClaimFailed) => ExitCode::FAILURE,
        // What a shell reports for a process that Ctrl-C ended.
        Ok(Ending::Interrupted) => ExitCode::from(130),
        Err(failure) => {
            eprintln!("error: {failure}");
            let mut cause = failure.source();
            while let Some(error) = cause {
                eprintln!("  because: {error}");
                cause = error.source();
            }
            ExitCode::from(2)
        }
    }
}
