//! Tables of results: one with a row for each scene, and one with a row for each replica.

use crate::Failure;
use crate::case::Case;
use crate::dispatch::State;
use crate::files::{self, Noted, Record};
use crate::run::Job;
use gradient_mc::observers::MeasuredEquationOfState;
use gradient_mc::statistics::Estimate;
use gradient_mc::{Error, Simulation};
use std::io;

/// The results of a scene.
#[derive(Debug, Clone)]
pub struct Measured {
    /// Number of finished replicas.
    pub replicas: usize,
    /// Their total number of sweeps of production.
    pub sweeps: u64,
    /// Mean height of the center of mass, in diameters.
    pub center_of_mass: Option<Estimate>,
    /// Z at the packing fractions of the table; `None` if the column does not reach one.
    pub compressibility_factors: Vec<Option<Estimate>>,
    /// Warnings of all replicas.
    pub warnings: Vec<Noted>,
}

/// The content of the tables of results.
#[derive(Debug)]
pub struct Written {
    /// Scenes in `results.csv`.
    pub measured: Vec<(Case, Measured)>,
    /// Scenes that could not be merged, by name.
    pub failures: Vec<(String, Failure)>,
}

/// `None` for an error about too few data.
fn if_enough<T>(result: Result<T, Error>) -> Result<Option<T>, Error> {
    match result {
        Ok(value) => Ok(Some(value)),
        Err(Error::TooFewObservations { .. }) => Ok(None),
        Err(error) => Err(error),
    }
}

impl Job {
    /// Merges the finished replicas of a scene, in their order.
    ///
    /// # Errors
    /// [`Failure::Simulation`] if there are none, or if a checkpoint cannot be read.
    pub fn measured(&self, case: &Case) -> Result<Measured, Failure> {
        let records: Vec<(usize, Record)> = (0..case.replicas)
            .filter_map(|replica| Some((replica, self.folder.record(case, replica)?)))
            .collect();
        let paths = records.iter().map(|&(replica, _)| self.folder.checkpoint(case, replica));
        let scene = case.scene()?;
        let observers = case.observers(&scene)?;
        let (center_of_mass, fit) = Simulation::builder(scene).pooled(paths, &observers)?;
        let fit = if_enough(fit.result())?;
        let factor = |&fraction: &f64| {
            let measured = fit.as_ref().filter(|fit| fraction <= fit.highest_packing_fraction());
            let Some(measured) = measured else { return Ok(None) };
            Ok(measured.combined().compressibility_factor_at(&[fraction])?.into_iter().next())
        };
        let factors = self.table.packing_fractions.iter().map(factor).collect::<Result<_, Error>>()?;
        let of_replicas = records.iter().flat_map(|(_, record)| record.warnings.iter().cloned());
        let of_all = center_of_mass
            .warnings()
            .into_iter()
            .chain(fit.iter().flat_map(MeasuredEquationOfState::warnings));
        Ok(Measured {
            replicas: records.len(),
            sweeps: records.iter().map(|(_, record)| record.sweeps).sum(),
            center_of_mass: if_enough(center_of_mass.estimate())?,
            compressibility_factors: factors,
            warnings: of_replicas.chain(of_all.map(|warning| Noted::from(&warning))).collect(),
        })
    }

    /// Writes `results.csv` with every scene that has a finished replica, and `runs.csv`. `state`
    /// gives the state of tasks without a record. Returns the results, and the scenes that could
    /// not be merged.
    ///
    /// # Errors
    /// [`Failure::File`] if a table cannot be written.
    pub fn write_results(&self, state: impl Fn(usize) -> State) -> Result<Written, Failure> {
        let (mut measured, mut failures) = (Vec::new(), Vec::new());
        for case in &self.table.cases {
            if (0..case.replicas).any(|replica| self.folder.record(case, replica).is_some()) {
                match self.measured(case) {
                    Ok(of_case) => measured.push((case.clone(), of_case)),
                    Err(failure) => failures.push((case.name.clone(), failure)),
                }
            }
        }
        let parameters = self.parameters();
        self.write_measured(&parameters, &measured)?;
        self.write_runs(&parameters, state)?;
        Ok(Written { measured, failures })
    }

    /// Columns for the parameters of fields and temperatures in the scenes.
    fn parameters(&self) -> Vec<&'static str> {
        let mut names = Vec::new();
        for case in &self.table.cases {
            for (name, _) in case.field.named().1.into_iter().chain(case.temperature.named().1) {
                if !names.contains(&name) {
                    names.push(name);
                }
            }
        }
        names.sort_unstable();
        names
    }

    fn write_measured(&self, parameters: &[&str], all: &[(Case, Measured)]) -> Result<(), Failure> {
        let units =
            "# units: lengths in d, field in g, temperature in m g d; errors are one standard error\n";
        let mut columns = head(parameters);
        let more = ["replicas", "sweeps", "center_of_mass", "center_of_mass_error"];
        columns.extend(more.map(String::from));
        for fraction in &self.table.packing_fractions {
            columns.push(format!("compressibility_factor_at_{fraction}"));
            columns.push(format!("compressibility_factor_at_{fraction}_error"));
        }
        columns.push("warnings".into());
        let rows = all.iter().map(|(case, measured)| {
            let mut row = of_scene(case, parameters);
            row.extend([measured.replicas.to_string(), measured.sweeps.to_string()]);
            for estimate in std::iter::once(&measured.center_of_mass).chain(&measured.compressibility_factors)
            {
                let Estimate { mean, standard_error, .. } =
                    estimate.unwrap_or(Estimate::new(f64::NAN, f64::NAN));
                row.extend([format!("{mean:?}"), format!("{standard_error:?}")]);
            }
            row.push(summary(case, measured).join("; "));
            row
        });
        self.write_table("results.csv", units, &columns, rows)
    }

    fn write_runs(&self, parameters: &[&str], state: impl Fn(usize) -> State) -> Result<(), Failure> {
        let units = "# units: lengths in d, field in g, temperature in m g d\n";
        let mut columns = head(parameters);
        let more = ["replica", "seed", "equilibration", "sweeps", "state", "warnings"];
        columns.extend(more.map(String::from));
        let rows = self.table.tasks().into_iter().enumerate().map(|(number, task)| {
            let (case, replica) = (&self.table.cases[task.case], task.replica);
            let mut row = of_scene(case, parameters);
            row.extend(
                [replica as u64, case.replica(replica).seed(), case.equilibration].map(|n| n.to_string()),
            );
            let record = self.folder.record(case, replica);
            let sweeps = record.as_ref().map_or(String::new(), |record| record.sweeps.to_string());
            let state = if record.is_some() { State::Finished } else { state(number) };
            let warnings = record.map_or(Vec::new(), |record| record.warnings);
            let texts: Vec<String> = warnings.into_iter().map(|warning| warning.text).collect();
            row.extend([sweeps, state.to_string(), texts.join("; ")]);
            row
        });
        self.write_table("runs.csv", units, &columns, rows)
    }

    fn write_table(
        &self,
        name: &str,
        units: &str,
        columns: &[String],
        rows: impl IntoIterator<Item = Vec<String>>,
    ) -> Result<(), Failure> {
        let path = self.folder.results(name);
        let mut table = csv::Writer::from_writer(units.as_bytes().to_vec());
        let put = table
            .write_record(columns)
            .and_then(|()| rows.into_iter().try_for_each(|row| table.write_record(row)));
        match put.map_err(io::Error::from).and_then(|()| table.into_inner().map_err(io::Error::other)) {
            Ok(bytes) => files::write(&path, bytes),
            Err(source) => Err(Failure::File { path, source }),
        }
    }
}

/// Columns that identify a scene.
fn head(parameters: &[&str]) -> Vec<String> {
    let before = ["scene", "height", "width_y", "width_z", "spheres", "field", "temperature"];
    before.iter().chain(parameters).map(|&name| name.to_owned()).collect()
}

fn of_scene(case: &Case, parameters: &[&str]) -> Vec<String> {
    let ((field, of_field), (temperature, of_temperature)) = (case.field.named(), case.temperature.named());
    let [width_y, width_z] = case.base;
    let lengths = [case.height, width_y, width_z].map(|length| format!("{length:?}"));
    let mut row = vec![case.name.clone()];
    row.extend(lengths);
    row.extend([case.spheres.to_string(), field.into(), temperature.into()]);
    for parameter in parameters {
        let value = of_field.iter().chain(&of_temperature).find(|(name, _)| name == parameter);
        row.push(value.map_or(String::new(), |(_, value)| format!("{value:?}")));
    }
    row
}

/// Kinds of warnings with the number of their runs, and missing replicas.
fn summary(case: &Case, measured: &Measured) -> Vec<String> {
    let mut kinds: Vec<(&str, usize)> = Vec::new();
    for warning in &measured.warnings {
        match kinds.iter_mut().find(|(kind, _)| *kind == warning.kind) {
            Some((_, count)) => *count += 1,
            None => kinds.push((&warning.kind, 1)),
        }
    }
    let mut lines: Vec<String> =
        kinds.into_iter().map(|(kind, count)| format!("{kind} ({count} of {})", measured.replicas)).collect();
    if measured.replicas < case.replicas {
        lines.push(format!("only {} of {} replicas are finished", measured.replicas, case.replicas));
    }
    let missed = |target: f64| measured.center_of_mass.is_none_or(|height| height.standard_error > target);
    if case.target_error.is_some_and(missed) {
        lines.push("target error not reached".into());
    }
    lines
}

/// The results of a scene in one line.
#[must_use]
pub fn line(case: &Case, measured: &Measured, packing_fractions: &[f64]) -> String {
    let text =
        |estimate: &Option<Estimate>| estimate.map_or("unknown".into(), |estimate| estimate.to_string());
    let mut parts = vec![format!("{}: center of mass {}", case.name, text(&measured.center_of_mass))];
    for (fraction, factor) in packing_fractions.iter().zip(&measured.compressibility_factors) {
        parts.push(format!("Z({fraction}) {}", text(factor)));
    }
    parts.extend(summary(case, measured));
    parts.join(", ")
}
