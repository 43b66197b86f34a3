//! Calibrates `Scene::model_for`: the errors of ideal gas and hydrostatic theory, and the lengths
//! of Monte Carlo plans.
//!
//! Runs two dozen columns, writes `examples/paper/calibration/*.csv`, fits the constants of the
//! estimates to these files, and prints the constants for `src/model/constants.rs` (`--fit` does
//! only this). `--references` measures the forty scenes of `tests/model_for.rs` instead, which are
//! not used in the fit, and writes `tests/reference/model_*.csv` of this package. Run it in the
//! directory of the repository.

#[macro_use]
extern crate paper;

mod measure;
mod reference;
mod references;

use paper::calibration::data::Data;
use paper::calibration::fit;
use paper::{Ending, Failure, Session, output, study};
use std::path::PathBuf;
use std::process::ExitCode;

/// Calibrates the estimates of `Scene::model_for` (about five minutes on one core).
#[derive(clap::Args, Debug)]
struct Arguments {
    /// Only fit the constants to existing calibration files
    #[arg(long, conflicts_with = "references")]
    fit: bool,
    /// Measure the scenes of the test instead of those of the calibration (about five minutes)
    #[arg(long)]
    references: bool,
}

fn main() -> ExitCode {
    study::main("calibrate_models", run)
}

fn run(arguments: &Arguments, session: &Session) -> Result<Ending, Failure> {
    // The repository; the output directory for short runs.
    let usual = if session.short { session.directory.clone() } else { PathBuf::from(".") };
    let out = session.out.clone().unwrap_or(usual);
    if arguments.references {
        references::make(&out.join("examples/paper/tests/reference"), session)?;
        return Ok(Ending::Finished);
    }
    let directory = out.join("examples/paper/calibration");
    output::create_directory(&directory)?;
    if !arguments.fit {
        measure::all(session)?.write(&directory)?;
    }
    // From the files, because the test has only their digits.
    let (fitted, quality) = fit::fit(&Data::read(&directory)?)?;
    println!("{fitted:#?}\nfor src/model/constants.rs; {quality:#?}");
    Ok(Ending::Finished)
}
