//! The picture: errors against CPU time.

use crate::{Checkpoint, Errors, Method};
use paper::Failure;
use paper::figure::RGBColor;
use paper::figure::{Axis, Corner, Figure, Mark, Panel, Place, Point, colors};
use std::path::Path;

/// Draws `<path>.svg` and `<path>.png`.
pub(crate) fn draw(runs: &[(Method, Vec<Checkpoint>)], target: f64, path: &Path) -> Result<(), Failure> {
    Figure::new("Error against CPU time: column of hard spheres, T = 20 mgd, N/A = 40")
        .panel(panel(runs, target, 0.0, "relative error of h_c", |errors| errors.center_of_mass))
        .panel(panel(runs, target, 0.5, "relative error of P(x)", |errors| errors.pressure))
        .save(path)
}

fn panel(
    runs: &[(Method, Vec<Checkpoint>)],
    target: f64,
    left: f64,
    label: &str,
    error: fn(&Errors) -> f64,
) -> Panel {
    let seconds = || runs.iter().flat_map(|(_, all)| all).map(|checkpoint| checkpoint.seconds);
    let power = |exponent: f64| libm::pow(10.0, exponent);
    let low = power(seconds().fold(f64::INFINITY, f64::min).log10().floor());
    let high = power(seconds().fold(0.0, f64::max).log10().ceil());
    let place = Place { left, top: 0.07, width: 0.5, height: 0.93 };
    let mut panel =
        Panel::new(place, Axis::logarithmic("CPU seconds", low, high), Axis::logarithmic(label, 1e-4, 1e4))
            .line("half a per cent", colors::GRAY, Mark::Dashed, [(low, target), (high, target)]);
    if left < 0.25 {
        panel = panel.with_legend(Corner::TopRight);
    }
    let palette = [
        RGBColor(214, 143, 0),
        RGBColor(86, 170, 220),
        colors::BLUE,
        colors::GREEN,
        colors::PURPLE,
        colors::VERMILION,
        colors::INK,
    ];
    for ((method, checkpoints), color) in runs.iter().zip(palette) {
        let at = |checkpoint: &Checkpoint| (checkpoint.seconds, error(&checkpoint.errors));
        let points: Vec<(f64, f64)> = checkpoints.iter().map(at).collect();
        let marks = points.clone().into_iter().map(|(x, y)| Point { x, y, error: 0.0 });
        panel = panel.line("", color, Mark::Line, points).points(method.label(), color, Mark::Points, marks);
    }
    panel
}
