//! The layers at the base by density functional theory: 40 spheres per area in a uniform field,
//! below a lid at 400.
//!
//! One file per functional, with the mean number density in bins of 0.1 d from 0.5 to 8 d. On the
//! terminal: the contact density, which is exactly the weight of the column over T₀; the height of
//! the center of mass; and the adsorption, the spheres per area in excess of the uniform fluid of
//! the same functional and chemical potential that begins at the wall. At T₀ = 5 also the deviation
//! of each functional from a simulation of the layers by an independent program.

#[macro_use]
extern crate paper;

use gradient_mc::field::UniformField;
use gradient_mc::functional::{DensityFunctional, LayeredProfile};
use gradient_mc::statistics::Estimate;
use gradient_mc::temperature::Isothermal;
use paper::accuracy::root_mean_square;
use paper::clock::cpu_seconds;
use paper::functionals::{self, BASE_BINS, base_bins, independent_base};
use paper::row;
use paper::study;
use paper::table::{Table, percent};
use paper::{Ending, Failure, Report, Session};
use std::process::ExitCode;

/// Solves the layers at the base of an isothermal column by density functionals.
#[derive(clap::Args, Debug)]
struct Arguments {
    /// Temperature T₀ in m g d
    #[arg(long, default_value_t = 15.0)]
    temperature: f64,
}

const COLUMN_DENSITY: f64 = 40.0;
const HEIGHT: f64 = 400.0;
/// Temperature of the independent simulation.
const SIMULATED: f64 = 5.0;

fn main() -> ExitCode {
    study::main("layered_base_theory", run)
}

fn run(arguments: &Arguments, session: &Session) -> Result<Ending, Failure> {
    let temperature = Isothermal::new(arguments.temperature)?;
    let exact = COLUMN_DENSITY / arguments.temperature;
    println!(
        "N/A = {COLUMN_DENSITY}, T0 = {}, lid at {HEIGHT}; contact density {exact:.6} exactly",
        arguments.temperature
    );
    let mut report = Report::new(session);
    let mut table = Table::new(["functional", "contact density", "h_c", "adsorption", "iterations", "CPU s"]);
    let mut simulated =
        Table::new(["functional", "rms deviation, %", "lowest, %", "at x", "highest, %", "at x"]);
    for functional in functionals::all() {
        let column =
            DensityFunctional::new(UniformField::default(), temperature, &*functional.functional).lid(HEIGHT);
        let started = cpu_seconds();
        let profile = column.column_density(COLUMN_DENSITY)?;
        let seconds = cpu_seconds() - started;
        report.table(
            functional.file,
            "height in d, middles of bins of 0.1; number_density in 1/d^3, means over the bins",
            "height, number_density",
            base_bins(&profile).map(|(height, density)| row![height, density]),
        )?;
        table.row(
            functional.name,
            [
                format!("{:.6}", profile.contact_density()),
                format!("{:.4}", profile.center_of_mass()),
                format!("{:.5}", column.adsorption(&profile)?),
                profile.iterations().to_string(),
                format!("{seconds:.3}"),
            ],
        );
        if (arguments.temperature - SIMULATED).abs() < 1e-9 {
            simulated.row(functional.name, deviations(&profile)?);
        }
        let contact = profile.contact_density() * arguments.temperature / profile.base_pressure() - 1.0;
        let claim =
            format!("{}: contact density times T over the weight of the column, minus 1", functional.name);
        report.verdicts.between("base", &claim, Estimate::exact(contact), -1e-5, 1e-5);
    }
    println!("\n{table}{BASE_BINS} bins per functional");
    if (arguments.temperature - SIMULATED).abs() < 1e-9 {
        println!("\nfunctional over an independent simulation, minus 1, in the lowest bins:\n\n{simulated}");
    }
    report.finish()
}

/// How far a functional is from the independent simulation.
fn deviations(profile: &LayeredProfile) -> Result<[String; 5], Failure> {
    let found: Vec<(f64, Estimate)> = base_bins(profile)
        .zip(independent_base()?)
        .map(|((height, density), simulated)| {
            (height, Estimate::exact(density).over_independent(simulated) - 1.0)
        })
        .collect();
    let by_mean = |one: &&(f64, Estimate), other: &&(f64, Estimate)| one.1.mean.total_cmp(&other.1.mean);
    let lowest = found.iter().min_by(by_mean).ok_or("no bins")?;
    let highest = found.iter().max_by(by_mean).ok_or("no bins")?;
    Ok([
        format!("{:.1}", 100.0 * root_mean_square(found.iter().map(|(_, deviation)| deviation.mean))),
        percent(lowest.1),
        format!("{:.2}", lowest.0),
        percent(highest.1),
        format!("{:.2}", highest.0),
    ])
}
