//! Calibrates `Scene::model_for`: how far ideal gas and hydrostatic theory are off, and how long Monte Carlo plans have to be.
//!
//! Runs two dozen columns, writes `examples/paper/calibration/*.csv`, fits the constants of the estimates to these, and prints
//! what is to stand in `src/model/constants.rs` (`--fit` does only this). `--references` measures the forty scenes of `tests/model_for.rs` instead,
//! to which nothing is fitted, and writes `tests/reference/model_*.csv` of this package. Run it in the directory of the repository.

mod measure;
mod reference;
mod references;

use clap::Parser;
use paper::calibration::data::Data;
use paper::calibration::fit;
use paper::{Ending, Failure, conclude, output};
use std::path::PathBuf;
use std::process::ExitCode;

/// Calibrates the estimates of `Scene::model_for`: some five minutes on one core.
#[derive(Parser, Debug)]
#[command(name = "calibrate_models")]
struct Arguments {
    /// Seed of the random numbers; every run of every scene has a seed of its own that follows from it
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Fits the constants to the calibration files that are there
    #[arg(long, conflicts_with = "references")]
    fit: bool,
    /// Measures the scenes of the test instead of those of the calibration: some five minutes as well
    #[arg(long)]
    references: bool,
    /// Threads; 0 takes all cores. The results do not depend on it, the times do a little
    #[arg(long, default_value_t = 0)]
    threads: usize,
    /// Directory of the repository
    #[arg(long, default_value = ".")]
    out: PathBuf,
}

fn main() -> ExitCode {
    conclude(run(&Arguments::parse()))
}

fn run(arguments: &Arguments) -> Result<Ending, Failure> {
    if arguments.references {
        references::make(
            &arguments.out.join("examples/paper/tests/reference"),
            arguments.seed,
            arguments.threads,
        )?;
        return Ok(Ending::Finished);
    }
    let directory = arguments.out.join("examples/paper/calibration");
    output::create_directory(&directory)?;
    if !arguments.fit {
        measure::all(arguments.seed, arguments.threads)?.write(&directory)?;
    }
    // From the files, whose digits are all that a test has.
    let (fitted, quality) = fit::fit(&Data::read(&directory)?)?;
    println!("{fitted:#?}\nfor src/model/constants.rs; {quality:#?}");
    Ok(Ending::Finished)
}
