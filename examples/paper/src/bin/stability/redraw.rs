//! Maps that were measured before, from their CSV files.

use crate::map::{Map, Measured, Point};
use crate::said::Said;
use crate::verdict::{Outcome, Quantity};
use gradient_mc::statistics::Estimate;
use paper::Failure;
use std::path::Path;

/// Reads what [`Measured::write`] wrote; only the texts of warnings are lost.
pub(crate) fn read(map: &Map, directory: &Path) -> Result<Measured, Failure> {
    let path = directory.join(map.name).with_extension("csv");
    let failure = |what: &dyn std::fmt::Display| format!("{}: {what}", path.display());
    let mut reader = csv::Reader::from_path(&path).map_err(|error| failure(&error))?;
    let mut points: Vec<Point> = Vec::new();
    for record in reader.records() {
        let record = record?;
        let text = |column: usize| record.get(column).unwrap_or_default().to_owned();
        let number = |column: usize| text(column).parse::<f64>().map_err(|error| failure(&error));
        let (series, label) = (text(0), text(2));
        if points.last().is_none_or(|last| last.series != series || last.label != label) {
            let word = text(3);
            let outcome = Outcome::ALL.into_iter().find(|outcome| outcome.word() == word);
            let said = text(15);
            points.push(Point {
                series,
                parameter: number(1)?,
                label,
                outcome: outcome.ok_or_else(|| failure(&"not an outcome"))?,
                quantities: Vec::new(),
                said: said
                    .split_whitespace()
                    .map(|name| Said { name: name.to_owned(), text: String::new() })
                    .collect(),
                remark: text(18),
                foreign: text(17) == "true",
                cpu_seconds: number(14)?,
            });
        }
        let (name, Some(point)) = (text(4), points.last_mut()) else { continue };
        if name.is_empty() {
            continue;
        }
        let some = |value: f64| (!value.is_nan()).then_some(value);
        let drift_error = number(12)?;
        point.quantities.push(Quantity {
            name,
            error: Estimate::new(number(5)?, number(6)?),
            truth_error: number(7)?,
            tolerance: number(8)?,
            largest_error_bar: number(9)?,
            start: some(number(10)?),
            drift: some(number(11)?).map(|mean| Estimate::new(mean, drift_error)),
        });
    }
    Ok(Measured { name: map.name, title: map.title, parameter: map.parameter, points })
}
