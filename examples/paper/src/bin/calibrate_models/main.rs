//! Calibrates `Scene::model_for`: how far ideal gas and hydrostatic theory are off, how long Monte Carlo plans have to be, and what
//! all of them cost.
//!
//! Runs two dozen columns, writes `examples/paper/calibration/*.csv`, fits the constants of the estimates to these, and writes
//! `src/model/constants.rs` (`--fit` does only this). `--references` measures the forty scenes of `tests/model_for.rs` instead,
//! to which nothing is fitted, and writes `tests/reference/model_*.csv` of this package. Run it in the directory of the repository.

mod measure;
mod reference;
mod references;

use paper::calibration::data::{Base, ColumnRow, Plan, Seeds};
use paper::calibration::fit;
use paper::{Ending, Failure, Session, output, study};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Calibrates the estimates of `Scene::model_for`: some five minutes on one core.
#[derive(clap::Args, Debug)]
struct Arguments {
    /// Fits the constants to the calibration files that are there
    #[arg(long, conflicts_with = "references")]
    fit: bool,
    /// Measures the long plans only, and fits
    #[arg(long, conflicts_with_all = ["references", "fit"])]
    long_plans: bool,
    /// Measures the scenes of the test instead of those of the calibration: some five minutes as well
    #[arg(long)]
    references: bool,
}

fn main() -> ExitCode {
    study::main("calibrate_models", run)
}

fn run(arguments: &Arguments, session: &Session) -> Result<Ending, Failure> {
    // The repository, unless the numbers are worth nothing.
    let usual = if session.short { session.directory.clone() } else { PathBuf::from(".") };
    let out = session.out.clone().unwrap_or(usual);
    if arguments.references {
        references::make(&out.join("examples/paper/tests/reference"), session)?;
        return Ok(Ending::Finished);
    }
    let directory = out.join("examples/paper/calibration");
    output::create_directory(&directory)?;
    let [columns_path, plans_path, bases_path, long_plans_path, seeds_path] =
        ["columns.csv", "plans.csv", "bases.csv", "long_plans.csv", "seeds.csv"]
            .map(|name| directory.join(name));
    let plan_units = "column: row of columns.csv from 0; family: 0 tuned local moves, 1 event chains with them; total variation distances; \
                      diameters; CPU seconds";
    if !arguments.fit && !arguments.long_plans {
        let measured = measure::all(session)?;
        let units = "m g d, per diameter, per square diameter, diameters; total variation distances; layers in spheres per square \
                     diameter; CPU seconds";
        write(&columns_path, units, ColumnRow::HEADER, measured.iter().map(|(column, ..)| column.values()))?;
        let plans = measured.iter().flat_map(|(_, plans, _)| plans);
        write(&plans_path, plan_units, Plan::HEADER, plans.map(Plan::values))?;
        let bases = measured.iter().flat_map(|(.., bases)| bases);
        let units = "column: row of columns.csv from 0; diameters; total variation distances";
        write(&bases_path, units, Base::HEADER, bases.map(Base::values))?;
    }
    if !arguments.fit {
        let measured = measure::long_plans(session)?;
        let plans = measured.iter().flatten().map(|(plan, _)| plan.values());
        write(&long_plans_path, plan_units, Plan::HEADER, plans)?;
        let units = "column: row of columns.csv from 0; family: 0 tuned local moves, 1 event chains with them; total variation distance; \
                     standard deviation over seeds in units of it";
        write(&seeds_path, units, Seeds::HEADER, measured.iter().flatten().map(|(_, seeds)| seeds.values()))?;
    }
    // From the files, whose digits are all that a test has.
    let (columns, bases) = (ColumnRow::read(&columns_path)?, Base::read(&bases_path)?);
    let mut plans = Plan::read(&plans_path)?;
    plans.extend(Plan::read(&long_plans_path)?);
    let (constants, quality) = fit::fit(&columns, &plans, &bases, &Seeds::read(&seeds_path)?);
    let source = out.join("src/model/constants.rs");
    output::create_directory(&out.join("src/model"))?;
    std::fs::write(&source, constants.source())?;
    println!("{constants:#?}");
    println!(
        "ln(measured/expected): {:.3} of formulas, {:.3} and {:.3} of plans",
        quality.formulas, quality.plans[0], quality.plans[1]
    );
    println!("wrote {}: cargo fmt", source.display());
    Ok(Ending::Finished)
}

fn write<const COLUMNS: usize>(
    path: &Path,
    units: &str,
    header: [&str; COLUMNS],
    rows: impl IntoIterator<Item = [f64; COLUMNS]>,
) -> Result<(), Failure> {
    output::write_csv(
        path,
        &format!("cargo run --release -p paper --bin calibrate_models; {units}"),
        &header.join(","),
        rows,
    )
}
