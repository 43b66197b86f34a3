//! A map: a method at several values of a parameter at which it fails.

use crate::said::Said;
use crate::verdict::{Outcome, Quantity};
use gradient_mc::statistics::Estimate;
use paper::clock::cpu_seconds;
use paper::row;
use paper::{Failure, Session};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The result of a probe.
#[derive(Debug, Clone, Default)]
pub(crate) struct Findings {
    pub(crate) quantities: Vec<Quantity>,
    pub(crate) said: Vec<Said>,
    /// Numbers that are printed but not judged.
    pub(crate) remark: String,
    /// Whether the method is not that of the library, which need not warn.
    pub(crate) foreign: bool,
}

type Work = Box<dyn Fn(Trial) -> Result<Findings, Failure> + Send + Sync>;

/// The input of a probe.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Trial {
    pub(crate) seed: u64,
    pub(crate) short: bool,
}

impl Trial {
    /// A number of sweeps, smaller in short runs.
    pub(crate) fn sweeps(self, sweeps: u64) -> u64 {
        if self.short { sweeps.min((sweeps / 100).max(64)) } else { sweeps }
    }
}

/// One point to be measured.
pub(crate) struct Probe {
    /// Row of the map.
    series: String,
    /// Column of the map.
    parameter: f64,
    label: String,
    work: Work,
}

/// A method at several values of a parameter.
pub(crate) struct Map {
    /// Of the file.
    pub(crate) name: &'static str,
    pub(crate) title: &'static str,
    /// What varies along it.
    pub(crate) parameter: &'static str,
    pub(crate) probes: Vec<Probe>,
    /// Whether its points must run one at a time.
    pub(crate) alone: bool,
}

/// A point as measured.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Point {
    pub(crate) series: String,
    pub(crate) parameter: f64,
    pub(crate) label: String,
    pub(crate) outcome: Outcome,
    pub(crate) quantities: Vec<Quantity>,
    pub(crate) said: Vec<Said>,
    pub(crate) remark: String,
    pub(crate) foreign: bool,
    pub(crate) cpu_seconds: f64,
}

/// A map as measured.
#[derive(Debug, Clone)]
pub(crate) struct Measured {
    pub(crate) name: &'static str,
    pub(crate) title: &'static str,
    pub(crate) parameter: &'static str,
    pub(crate) points: Vec<Point>,
}

impl Map {
    pub(crate) fn new(name: &'static str, title: &'static str, parameter: &'static str) -> Self {
        Self { name, title, parameter, probes: Vec::new(), alone: false }
    }

    /// Adds a point, shown by its number.
    pub(crate) fn add(
        &mut self,
        series: &str,
        parameter: f64,
        work: impl Fn(Trial) -> Result<Findings, Failure> + Send + Sync + 'static,
    ) {
        let label = match parameter {
            far if far != 0.0 && !(1e-3..1e4).contains(&far) => format!("{far:e}"),
            number => number.to_string(),
        };
        self.add_labeled(series, parameter, &label, work);
    }

    /// Adds a point with a label of its own; `parameter` gives its place.
    pub(crate) fn add_labeled(
        &mut self,
        series: &str,
        parameter: f64,
        label: &str,
        work: impl Fn(Trial) -> Result<Findings, Failure> + Send + Sync + 'static,
    ) {
        let (series, label) = (series.to_owned(), label.to_owned());
        self.probes.push(Probe { series, parameter, label, work: Box::new(work) });
    }
}

impl Probe {
    fn run(self, trial: Trial) -> Result<Point, Failure> {
        let before = cpu_seconds();
        let found = (self.work)(trial);
        let cpu_seconds = cpu_seconds() - before;
        let (outcome, findings) = match found {
            Ok(findings) => {
                let outcome = findings.quantities.iter().map(Quantity::judge).max();
                (outcome.ok_or("a probe without a quantity")?, findings)
            }
            Err(failure) => {
                // Errors of the library are results; all others are failures of this program.
                let error = failure.downcast::<gradient_mc::Error>()?;
                let stuck = matches!(*error, gradient_mc::Error::ChainStuck { .. });
                let outcome = if stuck { Outcome::Stuck } else { Outcome::Refused };
                (outcome, Findings { said: vec![Said::error(&error)], ..Findings::default() })
            }
        };
        let Findings { quantities, said, remark, foreign } = findings;
        let Self { series, parameter, label, .. } = self;
        Ok(Point { series, parameter, label, outcome, quantities, said, remark, foreign, cpu_seconds })
    }
}

impl Point {
    /// The quantity that decided.
    pub(crate) fn worst(&self) -> Option<&Quantity> {
        let rank = |quantity: &Quantity| (quantity.judge(), quantity.error.mean.abs() / quantity.tolerance);
        self.quantities.iter().max_by(|a, b| {
            let (a, b) = (rank(a), rank(b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        })
    }

    /// Whether a number is wrong, beyond its error bar, without a warning or error.
    pub(crate) fn is_silent_failure(&self) -> bool {
        !self.foreign && self.said.is_empty() && self.quantities.iter().any(Quantity::is_off)
    }
}

/// Measures maps, one point after the other on each thread.
pub(crate) fn measure(maps: Vec<Map>, session: &Session) -> Result<Vec<Measured>, Failure> {
    let heads: Vec<_> = maps.iter().map(|map| (map.name, map.title, map.parameter)).collect();
    let (mut shared, mut alone) = (Vec::new(), Vec::new());
    for (index, map) in maps.into_iter().enumerate() {
        let tasks = if map.alone { &mut alone } else { &mut shared };
        for (place, probe) in map.probes.into_iter().enumerate() {
            // The same seed whichever maps are measured.
            let own: u64 = map.name.bytes().fold(place as u64, |hash, byte| {
                hash.wrapping_mul(0x0100_0000_01b3).wrapping_add(u64::from(byte))
            });
            tasks.push((index, probe, Trial { seed: session.seed.wrapping_add(own), short: session.short }));
        }
    }
    let work = |(index, probe, trial): (usize, Probe, Trial)| Ok((index, probe.run(trial)?));
    let name = |(index, probe, _): &(usize, Probe, Trial)| {
        format!("{}, {}, {}", heads[*index].0, probe.series, probe.label)
    };
    let mut points = session.run_each("stability", shared, name, work)?;
    points.extend(session.on_threads(1).run_each("stability, one after the other", alone, name, work)?);
    let mut measured: Vec<Measured> = heads
        .into_iter()
        .map(|(name, title, parameter)| Measured { name, title, parameter, points: Vec::new() })
        .collect();
    for (index, point) in points {
        measured[index].points.push(point);
    }
    Ok(measured)
}

impl Measured {
    /// One row per quantity of every point.
    pub(crate) fn write(&self, directory: &Path) -> Result<(), Failure> {
        let path = directory.join(self.name).with_extension("csv");
        let mut writer = csv::Writer::from_path(&path)
            .map_err(|error| format!("cannot write {}: {error}", path.display()))?;
        writer.write_record([
            "series",
            self.parameter,
            "label",
            "outcome",
            "quantity",
            "relative_error",
            "claimed_error_bar",
            "error_of_truth",
            "tolerance",
            "largest_error_bar",
            "error_at_start",
            "drift",
            "drift_error",
            "outcome_of_quantity",
            "cpu_seconds",
            "said",
            "silent_failure",
            "not_the_library",
            "remark",
        ])?;
        for point in &self.points {
            let said: Vec<&str> = point.said.iter().map(|said| &said.name[..]).collect();
            let row = |quantity: [String; 10]| {
                let [name, rest @ ..] = quantity;
                let head = [
                    point.series.clone(),
                    point.parameter.to_string(),
                    point.label.clone(),
                    point.outcome.word().to_owned(),
                    name,
                ];
                let tail = [
                    format!("{:.3}", point.cpu_seconds),
                    said.join(" "),
                    point.is_silent_failure().to_string(),
                    point.foreign.to_string(),
                    point.remark.clone(),
                ];
                head.into_iter().chain(rest).chain(tail).collect::<Vec<String>>()
            };
            if point.quantities.is_empty() {
                writer.write_record(row(std::array::from_fn(|_| String::new())))?;
            }
            for quantity in &point.quantities {
                let drift = quantity.drift.unwrap_or(Estimate::new(f64::NAN, f64::NAN));
                let numbers = row![
                    quantity.error,
                    quantity.truth_error,
                    quantity.tolerance,
                    quantity.largest_error_bar,
                    quantity.start.unwrap_or(f64::NAN),
                    drift,
                ];
                let mut cells = std::array::from_fn(|_| String::new());
                cells[0].clone_from(&quantity.name);
                for (cell, number) in cells[1..].iter_mut().zip(numbers) {
                    *cell = format!("{number:.6e}");
                }
                quantity.judge().word().clone_into(&mut cells[9]);
                writer.write_record(row(cells))?;
            }
        }
        writer.flush()?;
        Ok(())
    }
}
