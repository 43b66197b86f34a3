//! What the studies share: command line, progress, replicas in parallel, CSV files and pictures; homogeneous Monte Carlo, the
//! opponent of the gradient; and the fit of the models of a column.

pub mod accuracy;
pub mod arguments;
pub mod calibration;
pub mod captions;
pub mod clock;
pub mod figure;
pub mod groups;
pub mod homogeneous;
pub mod interrupt;
pub mod least_squares;
pub mod output;
pub mod pareto;
pub mod progress;
pub mod replicas;
pub mod table;
pub mod verdict;
pub mod warnings;

use std::process::ExitCode;

/// Whatever stops an example.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;

/// How an example that did not fail came to its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// Everything was done, and what the example claims held.
    Finished,
    /// Ctrl-C: what was measured by then is written.
    Interrupted,
    /// Everything was done, and the data contradict what the example claims.
    ClaimFailed,
}

/// Turns the outcome of an example into the exit code of the process, and prints the chain of errors.
pub fn conclude(outcome: Result<Ending, Failure>) -> ExitCode {
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
