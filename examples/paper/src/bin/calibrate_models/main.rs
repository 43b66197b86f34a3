//! Calibrates `Scene::model_for`: the errors of ideal gas and hydrostatic theory, and the lengths
//! of Monte Carlo plans.
//!
//! Runs two dozen columns, writes `examples/paper/calibration/*.csv`, fits the constants of the
//! estimates to these files, and prints the constants for `src/model/constants.rs` (`--fit` does
//! only this). `--unseen 40` instead draws forty scenes that are not used in the fit, measures
//! references for them, runs the chosen models, and counts how often they are right. It writes
//! `examples/paper/tests/reference/model_*.csv`, which `tests/model_for.rs` reads. Run it in the
//! directory of the repository.

#[macro_use]
extern crate paper;

mod measure;
mod reference;
mod unseen;

use paper::calibration::data::Data;
use paper::calibration::fit;
use paper::{Ending, Failure, Session, output, study};
use std::path::PathBuf;
use std::process::ExitCode;

/// Calibrates the estimates of `Scene::model_for` (about five minutes on one core).
#[derive(clap::Args, Debug)]
struct Arguments {
    /// Only fit the constants to existing calibration files
    #[arg(long, conflicts_with = "unseen")]
    fit: bool,
    /// Judge the choices for this many scenes that are not used in the fit, instead of calibrating
    /// (forty take about ten minutes on one core)
    #[arg(long, value_name = "SCENES")]
    unseen: Option<usize>,
}

fn main() -> ExitCode {
    study::main("calibrate_models", run)
}

fn run(arguments: &Arguments, session: &Session) -> Result<Ending, Failure> {
    // The repository; the output directory for short runs.
    let usual = if session.short { session.directory.clone() } else { PathBuf::from(".") };
    let out = session.out.clone().unwrap_or(usual);
    if let Some(scenes) = arguments.unseen {
        unseen::judge_all(scenes, &out.join("examples/paper/tests/reference"), session)?;
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
