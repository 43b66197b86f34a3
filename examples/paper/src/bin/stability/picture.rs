//! Pictures of maps: a cell for every point, colored by the result of the method.

use crate::map::{Measured, Point};
use crate::verdict::Outcome;
use paper::figure::RGBColor;
use paper::figure::{Axis, Cell, Figure, Mark, Panel, Place, colors};

/// Tints of Okabe and Ito's colors, apart for color-blind readers and dark letters readable on all.
fn color(outcome: Outcome) -> RGBColor {
    match outcome {
        Outcome::Right => RGBColor(190, 228, 214),
        Outcome::Slow => RGBColor(247, 228, 130),
        Outcome::Wrong => RGBColor(240, 150, 90),
        Outcome::Stuck => RGBColor(214, 140, 190),
        Outcome::Refused => RGBColor(150, 190, 228),
    }
}

/// Pixels.
const WIDTH: u32 = 1600;
const ROW: f64 = 46.0;
const TITLE: f64 = 44.0;
/// Rows' names take as much room as so many columns of a map with `COLUMNS`.
const HEAD: f64 = 0.17;
const TOP: f64 = 92.0;

/// One picture of several maps, one below the other.
pub(crate) fn draw(title: &str, maps: &[&Measured]) -> Figure {
    let heights: Vec<f64> =
        maps.iter().map(|map| TITLE + ROW * (rows(map).len() as f64 + 1.0) + 14.0).collect();
    let total = TOP + heights.iter().sum::<f64>();
    // Some hundreds to some thousands.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let mut figure = Figure::new(title).with_size(WIDTH, total as u32);
    figure = figure.panel(legend(total));
    let mut top = TOP;
    for (map, height) in maps.iter().zip(&heights) {
        let place = Place { left: 0.0, top: top / total, width: 1.0, height: height / total };
        figure = figure.panel(panel(map, place));
        top += height;
    }
    figure
}

/// Names of rows, as they first appear.
fn rows(map: &Measured) -> Vec<&str> {
    let mut rows = Vec::new();
    for point in &map.points {
        if !rows.contains(&&point.series[..]) {
            rows.push(&point.series[..]);
        }
    }
    rows
}

/// Places and labels of columns, in the order of the parameter.
fn columns(map: &Measured) -> Vec<(f64, &str)> {
    let mut columns: Vec<(f64, &str)> =
        map.points.iter().map(|point| (point.parameter, &point.label[..])).collect();
    columns.sort_by(|a, b| a.0.total_cmp(&b.0));
    columns.dedup_by(|a, b| a.1 == b.1);
    columns
}

fn bare(place: Place, width: f64, height: f64) -> Panel {
    Panel::new(place, Axis::new("", 0.0, width), Axis::new("", -height, 0.0)).without_axes()
}

fn legend(total: f64) -> Panel {
    let place = Place { left: 0.0, top: 48.0 / total, width: 1.0, height: 40.0 / total };
    let mut panel = bare(place, 100.0, 1.0);
    for (index, outcome) in Outcome::ALL.into_iter().enumerate() {
        let left = 1.0 + 11.0 * index as f64;
        let cell = Cell { x: [left, left + 10.0], y: [-0.95, -0.05], color: color(outcome) };
        panel = panel.cells([cell]).note(left + 5.0, -0.5, outcome.word(), colors::INK);
    }
    panel
        .note(67.0, -0.5, "numbers: error in %", colors::INK)
        .cells([Cell { x: [77.0, 78.5], y: [-0.95, -0.05], color: colors::INK }])
        .note(84.0, -0.5, "with a warning or error", colors::INK)
        .line("", colors::INK, Mark::Line, frame([91.5, 99.0], [-0.95, -0.05]))
        .note(95.25, -0.5, "silent failure", colors::INK)
}

fn frame([left, right]: [f64; 2], [low, high]: [f64; 2]) -> [(f64, f64); 5] {
    [(left, low), (right, low), (right, high), (left, high), (left, low)]
}

fn panel(map: &Measured, place: Place) -> Panel {
    let (rows, columns) = (rows(map), columns(map));
    let width = columns.len() as f64;
    // The names of the rows stand left of zero.
    let head = width * HEAD / (1.0 - HEAD);
    let mut panel = bare(place, head + width, rows.len() as f64 + 1.0).with_title(map.title).note(
        0.5 * head,
        -0.5,
        map.parameter,
        colors::GRAY,
    );
    for (column, (_, label)) in columns.iter().enumerate() {
        panel = panel.note(head + column as f64 + 0.5, -0.5, label, colors::INK);
    }
    for (row, name) in rows.iter().enumerate() {
        let top = -(row as f64 + 1.0);
        panel = panel.note(0.5 * head, top - 0.5, name, colors::INK);
        for point in map.points.iter().filter(|point| point.series == *name) {
            let Some(column) = columns.iter().position(|(_, label)| *label == point.label) else {
                continue;
            };
            let left = head + column as f64;
            let (x, y) = ([left + 0.02, left + 0.98], [top - 0.96, top - 0.04]);
            let cell = Cell { x, y, color: color(point.outcome) };
            panel = panel.cells([cell]).note(left + 0.5, top - 0.5, &words(point), colors::INK);
            if !point.said.is_empty() {
                panel = panel.cells([Cell { x: [left + 0.94, left + 0.98], y, color: colors::INK }]);
            }
            if point.is_silent_failure() {
                panel = panel.line("", colors::INK, Mark::Line, frame(x, y));
            }
        }
    }
    panel
}

/// What stands in a cell.
fn words(point: &Point) -> String {
    point.worst().map_or("no number".to_owned(), |quantity| percent(quantity.error.mean))
}

/// Two or three figures, with a true minus sign.
pub(crate) fn percent(error: f64) -> String {
    let percent = 100.0 * error;
    let magnitude = percent.abs();
    let text = if percent.is_nan() {
        return "NaN".to_owned();
    } else if magnitude >= 1000.0 {
        format!("{percent:+.0e}")
    } else if magnitude >= 10.0 {
        format!("{percent:+.0}")
    } else if magnitude >= 1.0 {
        format!("{percent:+.1}")
    } else {
        format!("{percent:+.2}")
    };
    text.replace('-', "−")
}
