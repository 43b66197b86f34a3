//! The library of the studies of `gradient-mc`. A study is a program under `src/bin` that
//! reproduces figures of doi:10.1103/PhysRevE.83.061306 or compares methods.
//!
//! A study is made of
//!
//! 1. its own options in addition to the common ones, and [`study::main`], which reads them, makes
//!    the directory, handles signals and sets the exit code: 0 done, 1 a claim fails, 2 an error,
//!    130 interrupted;
//! 2. runs: [`Session::run_all`] does many on all cores, with a bar, a seed each
//!    ([`Session::seed`]) and from both [sides](study::Side) of the steady state. The same command
//!    continues an interrupted study ([`Watch`]) from the directory `unfinished` beside the
//!    results;
//! 3. a [`Report`]: CSV files, pictures ([`figure`]) with captions, and tables on the terminal
//!    ([`table`]);
//! 4. claims: each is a number with an error and an allowed range ([`verdict`]). They decide the
//!    exit code;
//! 5. warnings about the runs ([`warnings`]).
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
//! `all_figures` puts the pictures, captions and claims of the four studies that draw the figures
//! of the paper on one page. The library also contains [`homogeneous`] Monte Carlo, with which the
//! gradient is compared; the [`calibration`] of the models of `gradient-mc`; and a [plain] program,
//! the reference of the benchmarks.

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

/// Any error of a study.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;

/// How a study without an error ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// Complete, and all claims hold.
    Finished,
    /// Ended by a signal; the data so far are written.
    Interrupted,
    /// Complete, but the data contradict a claim.
    ClaimFailed,
}

/// Turns the outcome of a study into the exit code of the process, and prints the chain of errors.
pub fn conclude(outcome: Result<Ending, Failure>) -> ExitCode {
    match outcome {
        Ok(Ending::Finished) => ExitCode::SUCCESS,
        Ok(Ending::ClaimFailed) => ExitCode::FAILURE,
        // The exit code of a process ended by Ctrl-C, as in shells.
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
