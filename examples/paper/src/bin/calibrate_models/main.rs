//! Calibrates `Scene::model_for`: how far ideal gas and hydrostatic theory are off, and how long
//! Monte Carlo plans have to be.
//!
//! Runs two dozen columns, writes `examples/paper/calibration/*.csv`, fits the constants of the
//! estimates to these, and prints what is to stand in `src/model/constants.rs` (`--fit` does only
//! this). `--unseen 40` draws forty scenes to which nothing is fitted, instead, measures what is true
//! of them, takes the models that are chosen for them, and counts how often they are right; it writes
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

/// Calibrates the estimates of `Scene::model_for`: some five minutes on one core.
#[derive(clap::Args, Debug)]
struct Arguments {
    /// Fits the constants to the calibration files that are there
    #[arg(long, conflicts_with = "unseen")]
    fit: bool,
    /// Judges the choices for so many scenes to which nothing was fitted, instead: forty take some
    /// twenty minutes on one core
    #[arg(long, value_name = "SCENES")]
    unseen: Option<usize>,
}

fn main() -> ExitCode {
    study::main("calibrate_models", run)
}

fn run(arguments: &Arguments, session: &Session) -> Result<Ending, Failure> {
    // The repository, unless the numbers are worth nothing.
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
    // From the files, whose digits are all that a test has.
    let (fitted, quality) = fit::fit(&Data::read(&directory)?)?;
    println!("{fitted:#?}\nfor src/model/constants.rs; {quality:#?}");
    Ok(Ending::Finished)
}
