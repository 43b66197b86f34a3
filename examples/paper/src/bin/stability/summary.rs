//! The table on the terminal: where each map fails, how, and with which warnings.

use crate::map::{Measured, Point};
use crate::picture::percent;
use crate::verdict::Outcome;
use paper::table::Table;

/// One row per series of every map.
pub(crate) fn table(maps: &[Measured]) -> Table {
    let mut table =
        Table::new(["map: series", "right", "fails at …", "how", "warnings", "right, with a warning"]);
    for map in maps {
        let mut names: Vec<&str> = Vec::new();
        for point in &map.points {
            if !names.contains(&&point.series[..]) {
                names.push(&point.series);
            }
        }
        for name in names {
            let points: Vec<&Point> = map.points.iter().filter(|point| point.series == name).collect();
            let right = points.iter().filter(|point| point.outcome == Outcome::Right).count();
            let failed = || points.iter().filter(|point| point.outcome != Outcome::Right);
            let warned =
                points.iter().filter(|point| point.outcome == Outcome::Right && !point.said.is_empty());
            let list = |words: &dyn Fn(&Point) -> String| {
                let mut listed: Vec<String> = Vec::new();
                for word in failed().map(|point| words(point)).filter(|word| !word.is_empty()) {
                    if !listed.contains(&word) {
                        listed.push(word);
                    }
                }
                if listed.is_empty() { "-".to_owned() } else { listed.join(", ") }
            };
            let mut said: Vec<&str> = Vec::new();
            for said_here in failed().flat_map(|point| &point.said) {
                if !said.contains(&&said_here.name[..]) {
                    said.push(&said_here.name);
                }
            }
            let silent: Vec<&str> = points
                .iter()
                .filter(|point| point.is_silent_failure())
                .map(|point| &point.label[..])
                .collect();
            let mut said = said.join(", ");
            if !silent.is_empty() {
                said = format!("{said} NO WARNING at {}", silent.join(", "));
            }
            table.row(
                &format!("{}: {name}", map.name),
                [
                    format!("{right}/{}", points.len()),
                    list(&|point| {
                        let error = point
                            .worst()
                            .map_or(String::new(), |worst| format!(" ({} %)", percent(worst.error.mean)));
                        format!("{}{error}", point.label)
                    }),
                    list(&|point| point.outcome.word().to_owned()),
                    said,
                    warned.map(|point| &point.label[..]).collect::<Vec<&str>>().join(", "),
                ],
            );
        }
    }
    table
}

/// Every point at which a number is wrong without a warning.
pub(crate) fn silent_failures(maps: &[Measured]) -> Vec<String> {
    let lines = maps.iter().flat_map(|map| {
        let silent = map.points.iter().filter(|point| point.is_silent_failure());
        silent.map(|point| {
            let worst = point.worst().map_or(String::new(), |worst| {
                format!(
                    "{} off by {} %, error bar {} %",
                    worst.name,
                    percent(worst.error.mean),
                    percent(worst.error.standard_error)
                )
            });
            format!(
                "{}: {}, {} = {}: {}, {worst}",
                map.name,
                point.series,
                map.parameter,
                point.label,
                point.outcome.word()
            )
        })
    });
    lines.collect()
}
