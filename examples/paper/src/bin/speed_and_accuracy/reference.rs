//! The profiles that errors are measured against: long runs, stored with this example.

use crate::column;
use crate::method::{Method, Moves, Scheme, Start};
use crate::profile::{BINS, COLUMN_DENSITY, Errors, Profile, middle};
use crate::system::System;
use paper::output::{create_directory, read_csv, write_csv};
use paper::{Failure, Session, Side, accuracy};
use std::path::{Path, PathBuf};

/// A stored profile and its properties.
#[derive(Debug, Clone)]
pub(crate) struct Reference {
    pub(crate) profile: Profile,
    /// Its estimated errors; smaller errors of other results are not resolved.
    pub(crate) errors: Errors,
    /// CPU seconds that it took, of all replicas together.
    pub(crate) seconds: f64,
}

/// Side of the base; a smaller one tests whether it is wide enough.
const WIDTH: f64 = 12.0;
const CONTROL_WIDTH: f64 = 8.0;
const REPLICAS: u64 = 6;
/// Sweeps that a replica measures.
const SWEEPS: u64 = 6000;

/// Sweeps to equilibrate: some ten times as many as a column takes to fall; as many as measured
/// where they make the effective field.
fn equilibration(system: System) -> u64 {
    if system == System::VaryingTemperature { SWEEPS } else { 2000 }
}

const COLUMNS: &str = "height, number_density, number_density_error, pressure, pressure_error";

/// Where the stored profiles are.
pub(crate) fn directory() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src/bin/speed_and_accuracy/reference")
}

impl Reference {
    /// The profile stored with this example.
    pub(crate) fn stored(system: System) -> Result<Self, Failure> {
        Self::parse(match system {
            System::Isothermal => include_str!("reference/isothermal.csv"),
            System::VaryingField => include_str!("reference/varying_field.csv"),
            System::VaryingTemperature => include_str!("reference/varying_temperature.csv"),
        })
    }

    /// The profile stored in a directory, since this program was compiled.
    pub(crate) fn read(system: System, directory: &Path) -> Result<Self, Failure> {
        Self::parse(&std::fs::read_to_string(directory.join(system.name()).with_extension("csv"))?)
    }

    fn parse(text: &str) -> Result<Self, Failure> {
        let rows = read_csv::<5>(text)?;
        if rows.len() != BINS {
            return Err("there is no reference: make it with --long".into());
        }
        let column = |index: usize| rows.iter().map(|row| row[index]).collect();
        let profile = Profile {
            density: column(1),
            density_errors: column(2),
            pressure: column(3),
            pressure_errors: column(4),
            center_of_mass: noted(text, "center_of_mass")?,
            center_of_mass_error: noted(text, "center_of_mass_error")?,
        };
        Ok(Self { errors: profile.claims(), profile, seconds: noted(text, "cpu_seconds")? })
    }
}

/// A number in the comment lines.
fn noted(text: &str, name: &str) -> Result<f64, Failure> {
    let number = text
        .lines()
        .filter_map(|line| line.strip_prefix("# "))
        .flat_map(|line| line.split(", "))
        .find_map(|part| part.strip_prefix(name)?.strip_prefix(" = "))
        .ok_or_else(|| format!("the reference has no {name}"))?;
    Ok(number.parse()?)
}

/// Replicas over one base, of one system.
struct Runs {
    profiles: Vec<Profile>,
    seconds: f64,
}

impl Runs {
    fn mean(&self) -> Profile {
        Profile::mean_with_scatter(&self.profiles.iter().collect::<Vec<_>>())
    }

    /// Means of the replicas from above and from below.
    fn sides(&self) -> [Profile; 2] {
        [0, 1].map(|side| {
            let of_side: Vec<&Profile> = self.profiles.iter().skip(side).step_by(2).collect();
            Profile::mean_with_scatter(&of_side)
        })
    }
}

/// How far two profiles are apart, and how far they would be if they differed by their errors only.
fn distance(one: &Profile, other: &Profile) -> [f64; 2] {
    let together: Vec<f64> =
        one.density_errors.iter().zip(&other.density_errors).map(|(a, b)| a.hypot(*b)).collect();
    [
        accuracy::total_variation_distance(&one.density, &other.density, COLUMN_DENSITY),
        accuracy::expected_total_variation_distance(&together, COLUMN_DENSITY),
    ]
}

/// Makes the references of all systems and stores them in `directory`.
pub(crate) fn make(session: &Session, directory: &Path) -> Result<(), Failure> {
    create_directory(directory)?;
    let sweeps = session.choose(SWEEPS, 100);
    let mut tasks: Vec<(System, f64, u64)> = Vec::new();
    for width in [WIDTH, CONTROL_WIDTH] {
        for system in System::ALL {
            tasks.extend((0..REPLICAS).map(|replica| (system, width, replica)));
        }
    }
    let name = |(system, width, replica): &(System, f64, u64)| {
        format!("{}, base {width}, replica {replica}", system.title())
    };
    let outcomes = session.run_each("reference runs", tasks, name, |(system, width, replica)| {
        let start = match Side::of(replica) {
            Side::Above => Start::Uniform,
            Side::Below => Start::ClosePacked,
        };
        let method = Method { moves: Moves::ChainsAndTuned, start, width, scheme: Scheme::SelfConsistent };
        let base = if width < WIDTH { 1000 } else { 0 };
        let seed = session.seed(base + replica);
        let (mut column, mut seconds) = column::build(system, method, seed)?;
        seconds += column.equilibrate(session.choose(equilibration(system), 100))?;
        let stretch = column.measure(sweeps, method.moves)?;
        Ok((stretch.profile, seconds + stretch.seconds))
    })?;
    let mut runs: Vec<Runs> = outcomes
        .chunks(usize::try_from(REPLICAS)?)
        .map(|replicas| Runs {
            profiles: replicas.iter().map(|(profile, _)| profile.clone()).collect(),
            seconds: replicas.iter().map(|(_, seconds)| seconds).sum(),
        })
        .collect();
    let controls = runs.split_off(System::ALL.len());
    for ((system, runs), control) in System::ALL.into_iter().zip(runs).zip(controls) {
        store(system, session.seed, &runs, &control, &directory.join(system.name()).with_extension("csv"))?;
    }
    Ok(())
}

fn store(system: System, seed: u64, runs: &Runs, control: &Runs, path: &Path) -> Result<(), Failure> {
    let (profile, small) = (runs.mean(), control.mean());
    let errors = profile.claims();
    let [sides, sides_expected] = {
        let [above, below] = runs.sides();
        distance(&above, &below)
    };
    let [bases, bases_expected] = distance(&profile, &small);
    let lines = [
        format!("{}, N/A = {COLUMN_DENSITY}, slab 400 high", system.title()),
        format!("cargo run --release -p paper --bin speed_and_accuracy -- --long --seed {seed}"),
        format!(
            "{REPLICAS} replicas over {WIDTH} x {WIDTH}, from above and below in turn; event chains with tuned local moves; \
             {} sweeps to equilibrate and {SWEEPS} measured each",
            equilibration(system)
        ),
        format!("seed = {seed}, cpu_seconds = {:.1}", runs.seconds),
        format!(
            "center_of_mass = {:.5}, center_of_mass_error = {:.5}",
            profile.center_of_mass, profile.center_of_mass_error
        ),
        format!(
            "expected total variation distance: {:.2e}; largest error of P over P at the base: {:.2e}; of {CONTROL_WIDTH} x \
             {CONTROL_WIDTH} {:.2e} and {:.2e}",
            errors.misplaced,
            errors.pressure,
            small.claims().misplaced,
            small.claims().pressure,
        ),
        format!("total variation distance between above and below: {sides:.2e}, expected from errors {sides_expected:.2e}"),
        format!(
            "total variation distance between {WIDTH} x {WIDTH} and {CONTROL_WIDTH} x {CONTROL_WIDTH}: {bases:.2e}, expected \
             from errors {bases_expected:.2e}; h_c of the smaller base {:.5} +- {:.5}",
            small.center_of_mass, small.center_of_mass_error
        ),
        "lengths in d, densities in d^-3 (means over bins one diameter high), pressures in m g/d^2 (at the middles); \
         errors from the scatter of the replicas"
            .to_owned(),
    ];
    let rows = (0..BINS).map(|bin| {
        [
            middle(bin),
            profile.density[bin],
            profile.density_errors[bin],
            profile.pressure[bin],
            profile.pressure_errors[bin],
        ]
    });
    write_csv(path, &lines.join("\n# "), COLUMNS, rows)
}
