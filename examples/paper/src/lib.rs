//! What the studies of `gradient-mc` share. A study is a program under `src/bin` that reproduces
//! figures of doi:10.1103/PhysRevE.83.061306 or compares methods.
//!
//! A study is made of
//!
//! 1. options of its own beside those of every study, and [`study::main`], which reads both, makes
//!    the directory, listens to signals and sets the exit code: 0 done, 1 a claim fails, 2 an
//!    error, 130 interrupted;
//! 2. runs: [`Session::run_all`] does many on all cores, with a bar, a seed each
//!    ([`Session::seed`]) and from both [sides](study::Side) of the steady state. They go on where
//!    an earlier process was stopped ([`Watch`]), by the same command; the directory `unfinished`
//!    beside the results holds what that takes until all is done;
//! 3. a [`Report`]: CSV files, pictures ([`figure`]) with captions, and tables on the terminal
//!    ([`table`]);
//! 4. claims in it: a number with an error and a range each ([`verdict`]). They decide the exit
//!    code;
//! 5. what the runs say against themselves ([`warnings`]).
//!
//! A whole study:
//!
//! ```no_run
//! use gradient_mc::observers::CenterOfMass;
//! use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
//! use paper::{Ending, Failure, Report, Session, Watch, row, study, warnings};
//!
//! /// Measures the height of the center of mass of a column.
//! #[derive(clap::Args, Debug)]
//! struct Arguments {
//!     /// Temperature, in m g d
//!     #[arg(long, default_value_t = 10.0)]
//!     temperature: f64,
//! }
//!
//! fn main() -> std::process::ExitCode {
//!     study::main("center", run)
//! }
//!
//! fn run(arguments: &Arguments, session: &Session) -> Result<Ending, Failure> {
//!     let scene = Scene::new(Slab::new(200.0, 6.0, 6.0)?, 360, UniformField::default(),
//!         Isothermal::new(arguments.temperature)?)?;
//!     let sweeps = session.choose(20_000, 100);
//!     let replica = |replica: u64, watch: &Watch<'_>| {
//!         let mut simulation = Simulation::builder(scene).seed(session.seed(replica)).build()?;
//!         let mut center = CenterOfMass::new();
//!         watch.equilibrate(&mut simulation, sweeps, 1, &mut ())?;
//!         watch.run(&mut simulation, sweeps, 1, &mut center)?;
//!         Ok((center.estimate()?, simulation.warnings()))
//!     };
//!     let measured = session.run_all("columns", (0..4).collect(), u64::to_string, |_| 2 * sweeps, replica)?;
//!     let mut report = Report::new(session);
//!     let rows = measured.iter().map(|(center, _)| row![center]);
//!     report.table("center", "heights in d", "center_of_mass, center_of_mass_error", rows)?;
//!     report.verdicts.agrees("center", "center of mass", measured[0].0, (13.0, 4.0), 0.1);
//!     warnings::print(measured.iter().map(|(_, warnings)| &warnings[..]));
//!     report.finish()
//! }
//! ```
//!
//! `all_figures` puts the pictures, captions and claims of the four studies that draw the paper's
//! figures on one page. Beside what studies share there are [`homogeneous`] Monte Carlo, the
//! opponent of the gradient; the [`calibration`] of the library's models; and a [plain] program,
//! the yardstick of the benches.

#![allow(
    clippy::must_use_candidate,
    clippy::missing_errors_doc,
    reason = "not published: every caller is in this package"
)]

#[macro_use]
mod print;

pub mod accuracy;
pub mod calibration;
pub mod captions;
pub mod clock;
pub mod figure;
pub mod functionals;
pub mod groups;
pub mod homogeneous;
pub mod interrupt;
pub mod least_squares;
pub mod output;
pub mod pareto;
pub mod plain;
pub mod progress;
pub mod replicas;
pub mod report;
pub mod study;
pub mod table;
pub mod unfinished;
pub mod verdict;
pub mod warnings;
pub mod watch;

#[doc(hidden)]
pub use print::print_line;
pub use report::Report;
pub use study::{Session, Side};
pub use watch::{Interrupted, Watch};

use std::process::ExitCode;

/// Whatever stops a study.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;

/// How a study that did not fail came to its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// Everything was done, and what the study claims held.
    Finished,
    /// By a signal: what was measured by then is written.
    Interrupted,
    /// Everything was done, and the data contradict what the study claims.
    ClaimFailed,
}

/// Turns the outcome of a study into the exit code of the process, and prints the chain of errors.
pub fn conclude(outcome: Result<Ending, Failure>) -> ExitCode {
    match outcome {
        Ok(Ending::Finished) => ExitCode::SUCCESS,
        Ok(Ending::ClaimFailed) => ExitCode::FAILURE,
        // What a shell reports for a process that Ctrl-C ended.
        Ok(Ending::Interrupted) => ExitCode::from(130),
        Err(failure) if failure.is::<Interrupted>() => {
            eprintln!("{failure}");
            ExitCode::from(130)
        }
        Err(failure) => {
            eprintln!("error: {}", watch::explained(&*failure));
            ExitCode::from(2)
        }
    }
}
