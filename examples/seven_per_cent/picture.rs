//! The picture: the bias of instantaneous counts for bins and bases, the schemes that have none, and what crossing
//! bins has to do with it.

use super::Finished;
use super::prediction::{Prediction, part_outside};
use super::run::{Band, MovesChoice, SchemeChoice, Side};
use super::scan::{BIN, Scan, full_bias};
use crate::common::Failure;
use crate::common::figure::{Axis, Corner, Figure, Mark, Panel, Place, Point, colors};
use gradient_mc::statistics::Estimate;
use std::path::Path;

/// Draws `<path>.svg` and `<path>.png`.
pub(crate) fn draw(
    runs: &[Finished],
    scans: &[(Scan, Estimate)],
    prediction: &Prediction,
    path: &Path,
) -> Result<(), Failure> {
    Figure::new(
        "P/(nTZ) − 1 at T₀ = 20, β = 0.05: counting noise in the effective field, and schemes without it",
    )
    .panel(instantaneous(runs, prediction, 156.25, Place { left: 0.0, top: 0.07, width: 0.5, height: 0.465 }))
    .panel(instantaneous(runs, prediction, 625.0, Place { left: 0.5, top: 0.07, width: 0.5, height: 0.465 }))
    .panel(others(runs, Place { left: 0.0, top: 0.535, width: 0.5, height: 0.465 }))
    .panel(crossing(scans, Place { left: 0.5, top: 0.535, width: 0.5, height: 0.465 }))
    .save(path)
}

fn points(bands: &[Band], shift: f64) -> impl Iterator<Item = Point> + '_ {
    bands.iter().map(move |band| Point {
        x: band.height + shift,
        y: 100.0 * band.deviation.mean,
        error: 100.0 * band.deviation.standard_error,
    })
}

const COLORS: [plotters::style::RGBColor; 5] =
    [colors::PURPLE, colors::VERMILION, colors::BLUE, colors::GREEN, colors::INK];

fn height_axis(label: &str) -> Axis {
    Axis::new(label, 6.0, 58.0).with_numbers(10)
}

fn instantaneous(runs: &[Finished], prediction: &Prediction, area: f64, place: Place) -> Panel {
    let chosen: Vec<&Finished> = runs
        .iter()
        .filter(|(setup, _)| setup.scheme == SchemeChoice::Instantaneous && (setup.area - area).abs() < 1e-9)
        .collect();
    let values = chosen.iter().flat_map(|(_, outcome)| &outcome.bands[0]);
    let highest = values.map(|band| 100.0 * band.deviation.mean).fold(5.0, f64::max);
    let label = format!("height x / d, histogram of the last sweep, A = {area}");
    let mut panel = Panel::new(
        place,
        height_axis(&label),
        Axis::new("P/(nTZ) − 1, %", -2.0, (1.15 * highest).ceil()).with_numbers(6),
    )
    .with_legend(Corner::TopRight)
    .line("", colors::GREY, Mark::Line, [(6.0, 0.0), (58.0, 0.0)]);
    let mut bins: Vec<f64> = Vec::new();
    for (setup, outcome) in &chosen {
        let local = matches!(setup.moves, MovesChoice::Local(_));
        if !bins.contains(&setup.acceptance_bin) {
            bins.push(setup.acceptance_bin);
        }
        let index =
            if local { 4 } else { bins.iter().position(|&bin| bin >= setup.acceptance_bin).unwrap_or(0) };
        let color = COLORS[index.min(4)];
        let first = setup.side == Side::Above || chosen.len() < 5;
        let label = match (setup.moves, first) {
            (MovesChoice::Local(size), true) => {
                format!("bins {}, the paper's moves, S = {size}", setup.acceptance_bin)
            }
            (MovesChoice::Chains, true) => format!("bins {}", setup.acceptance_bin),
            _ => String::new(),
        };
        let curve = (0..=100).map(|step| 7.0 + 0.5 * f64::from(step)).map(|height| {
            let part = setup.part_outside();
            (height, 100.0 * part * prediction.deviation(area, setup.acceptance_bin, height))
        });
        let shift = if setup.side == Side::Above { -0.25 } else { 0.25 };
        panel = panel.line("", color, Mark::Line, curve).points(
            &label,
            color,
            Mark::Points,
            points(&outcome.bands[0], shift),
        );
    }
    panel
}

fn others(runs: &[Finished], place: Place) -> Panel {
    let kinds = [
        (SchemeChoice::Closure, "closure by an equation of state", colors::GREEN),
        (SchemeChoice::SelfConsistent, "self-consistent", colors::BLUE),
        (SchemeChoice::AveragedThenFrozen, "averaged, then frozen", colors::PURPLE),
        (SchemeChoice::RunningAverage, "running average", colors::GREY),
    ];
    let mut panel = Panel::new(
        place,
        height_axis("height x / d, other schemes, all bins and bases"),
        Axis::new("P/(nTZ) − 1, %", -4.0, 4.0).with_numbers(8),
    )
    .with_legend(Corner::TopRight)
    .line("", colors::GREY, Mark::Line, [(6.0, 0.0), (58.0, 0.0)]);
    for (number, (scheme, name, color)) in (0_u32..).zip(kinds) {
        let mut label = name;
        for (setup, outcome) in runs.iter().filter(|(setup, _)| setup.scheme == scheme) {
            let side = if setup.side == Side::Above { -0.25 } else { 0.25 };
            let shift = side + f64::from(number) * 0.6 - 0.9;
            panel = panel.points(label, color, Mark::Dots, points(&outcome.bands[0], shift));
            label = "";
        }
    }
    panel
}

fn crossing(scans: &[(Scan, Estimate)], place: Place) -> Panel {
    let full = 100.0 * full_bias(scans);
    let curve = (1..=200).map(|step| f64::from(step) / 200.0 * 7.0);
    let curve = curve.map(|ratio| (ratio, full * part_outside(ratio * BIN, BIN)));
    let measured = scans.iter().map(|(scan, deviation)| Point {
        x: scan.maximum_displacement / BIN,
        y: 100.0 * deviation.mean,
        error: 100.0 * deviation.standard_error,
    });
    Panel::new(
        place,
        Axis::new("S over the width of a bin (a small column, instantaneous)", 0.0, 7.0).with_numbers(8),
        Axis::new("P/(nTZ) − 1, %", -0.1 * full, 1.4 * full).with_numbers(6),
    )
    .with_legend(Corner::BottomRight)
    .line("part of the way outside the own bin", colors::VERMILION, Mark::Line, curve)
    .points("local moves", colors::INK, Mark::Points, measured)
}
