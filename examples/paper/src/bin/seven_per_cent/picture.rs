//! The picture: the bias of instantaneous counts for bins and bases, the schemes that have none,
//! and what crossing bins has to do with it.

use super::Drawn;
use super::prediction::{Prediction, part_outside};
use super::run::{Band, MovesChoice, SchemeChoice};
use super::scan::{BIN, Scan, full_bias};
use gradient_mc::statistics::Estimate;
use paper::figure::{Axis, Corner, Figure, Mark, Panel, Place, Point, colors};
use paper::{Failure, Report, Side};

pub(crate) fn draw(
    runs: &[Drawn],
    scans: &[(Scan, Estimate)],
    prediction: &Prediction,
    report: &mut Report,
) -> Result<(), Failure> {
    // The bases that the field of the last sweep was tried on.
    let mut areas: Vec<f64> = runs
        .iter()
        .filter(|(setup, _)| setup.scheme == SchemeChoice::Instantaneous)
        .map(|(setup, _)| setup.area)
        .collect();
    areas.dedup();
    let (top, bottom) = ((0.07, 0.465), (0.535, 0.465));
    let place = |left: f64, (top, height): (f64, f64)| Place { left, top, width: 0.5, height };
    let mut figure = Figure::new(
        "P/(nTZ) − 1 at T₀ = 20, β = 0.05: counting noise in the effective field, and schemes without it",
    )
    .panel(others(runs, place(0.0, bottom)))
    .panel(crossing(scans, place(0.5, bottom))?);
    let panels = areas.iter().zip([0.0, 0.5]);
    for (&area, left) in panels {
        figure = figure.panel(instantaneous(runs, prediction, area, place(left, top)));
    }
    if areas.len() == 1 {
        figure = figure.panel(widths(scans, place(0.5, top))?);
    }
    let caption = "P/(nTZ) − 1 by counting noise in a field that changes with every configuration, for several bins and bases, which explains the \
    7 % of the paper; schemes without this bias; and its dependence on the number of bins that a move crosses.";
    report.picture("seven_per_cent", &figure, caption)
}

fn points(bands: &[Band], shift: f64) -> impl Iterator<Item = Point> + '_ {
    bands.iter().map(move |band| Point::percent(band.height + shift, band.deviation))
}

const COLORS: [paper::figure::RGBColor; 4] = [colors::PURPLE, colors::VERMILION, colors::BLUE, colors::GREEN];

fn height_axis(label: &str) -> Axis {
    Axis::new(label, 6.0, 58.0).with_numbers(10)
}

fn instantaneous(runs: &[Drawn], prediction: &Prediction, area: f64, place: Place) -> Panel {
    let chosen: Vec<&Drawn> = runs
        .iter()
        .filter(|(setup, _)| setup.scheme == SchemeChoice::Instantaneous && (setup.area - area).abs() < 1e-9)
        .collect();
    let values = chosen.iter().flat_map(|(_, bands)| bands);
    // A column that has run away would press the others flat.
    let highest = values
        .map(|band| 100.0 * band.deviation.mean)
        .filter(|&deviation| deviation < 100.0)
        .fold(5.0, f64::max);
    let label = format!("height x / d, histogram of the last sweep, A = {area}");
    let mut panel = Panel::new(
        place,
        height_axis(&label),
        Axis::new("P/(nTZ) − 1, %", -8.0, (1.3 * highest).ceil()).with_numbers(6),
    )
    .with_legend(Corner::TopRight)
    .line("", colors::GRAY, Mark::Line, [(6.0, 0.0), (58.0, 0.0)]);
    let mut bins: Vec<f64> = Vec::new();
    let mut labels: Vec<String> = Vec::new();
    for (setup, bands) in &chosen {
        if !bins.contains(&setup.acceptance_bin) {
            bins.push(setup.acceptance_bin);
        }
        let index = bins.iter().position(|&bin| bin >= setup.acceptance_bin).unwrap_or(0);
        let (color, label) = match setup.moves {
            MovesChoice::Chains => (colors::GRAY, format!("bins {}, event chains", setup.acceptance_bin)),
            MovesChoice::Local(size) => (COLORS[index], format!("bins {}, S = {size}", setup.acceptance_bin)),
        };
        let shown = if labels.contains(&label) { String::new() } else { label.clone() };
        labels.push(label);
        if let Some(part) = setup.part_outside() {
            let curve = (0..=100).map(|step| 7.0 + 0.5 * f64::from(step)).map(|height| {
                (height, 100.0 * part * prediction.deviation(area, setup.acceptance_bin, height))
            });
            panel = panel.line("", color, Mark::Line, curve);
        }
        let shift = if setup.side == Side::Above { -0.25 } else { 0.25 };
        panel = panel.points(&shown, color, Mark::Points, points(bands, shift));
    }
    panel
}

fn others(runs: &[Drawn], place: Place) -> Panel {
    let kinds = [
        (SchemeChoice::Closure, "closure by an equation of state", colors::GREEN),
        (SchemeChoice::SelfConsistent, "self-consistent", colors::BLUE),
        (SchemeChoice::AveragedThenFrozen, "averaged, then frozen", colors::PURPLE),
        (SchemeChoice::RunningAverage, "running average", colors::GRAY),
    ];
    let mut panel = Panel::new(
        place,
        height_axis("height x / d, other schemes, all bins and bases"),
        Axis::new("P/(nTZ) − 1, %", -4.0, 4.0).with_numbers(8),
    )
    .with_legend(Corner::TopRight)
    .line("", colors::GRAY, Mark::Line, [(6.0, 0.0), (58.0, 0.0)]);
    for (number, (scheme, name, color)) in (0_u32..).zip(kinds) {
        let mut label = name;
        for (setup, bands) in runs.iter().filter(|(setup, _)| setup.scheme == scheme) {
            let side = if setup.side == Side::Above { -0.25 } else { 0.25 };
            let shift = side + f64::from(number) * 0.6 - 0.9;
            panel = panel.points(label, color, Mark::Dots, points(bands, shift));
            label = "";
        }
    }
    panel
}

/// Measured deviations of the scans that `choose` takes, over what it makes of them.
fn scanned(scans: &[(Scan, Estimate)], choose: impl Fn(&Scan) -> Option<f64>) -> (Vec<Point>, f64) {
    let chosen = scans.iter().filter_map(|(scan, deviation)| {
        choose(scan).map(|x| Point { x, y: 100.0 * deviation.mean, error: 100.0 * deviation.standard_error })
    });
    let points: Vec<Point> = chosen.collect();
    let highest = points.iter().map(|point| point.y).fold(1.0, f64::max);
    (points, highest)
}

fn crossing(scans: &[(Scan, Estimate)], place: Place) -> Result<Panel, Failure> {
    let full = 100.0 * full_bias(BIN)?;
    let curve = (1..=200).map(|step| f64::from(step) / 200.0 * 3.5);
    let curve = curve.map(|ratio| (ratio, full * part_outside(ratio * BIN, BIN)));
    let of_sizes =
        |scan: &Scan| (scan.bin.to_bits() == BIN.to_bits()).then(|| scan.maximum_displacement / BIN);
    let (measured, highest) = scanned(scans, of_sizes);
    Ok(Panel::new(
        place,
        Axis::new("S over the width of a bin (0.5 d; small column, local moves)", 0.0, 3.5).with_numbers(8),
        Axis::new("P/(nTZ) − 1, %", -0.2 * highest, 1.4 * highest).with_numbers(6),
    )
    .with_legend(Corner::BottomRight)
    .line("counting noise outside the own bin", colors::VERMILION, Mark::Line, curve)
    .points("histogram of the last sweep", colors::INK, Mark::Points, measured))
}

fn widths(scans: &[(Scan, Estimate)], place: Place) -> Result<Panel, Failure> {
    let size = 0.75_f64;
    let curve = (0..=60).map(|step| 0.12 + f64::from(step) * 0.0165);
    let curve = curve
        .map(|bin| Ok((bin, 100.0 * part_outside(size, bin) * full_bias(bin)?)))
        .collect::<Result<Vec<_>, Failure>>()?;
    let of_bins = |scan: &Scan| (scan.maximum_displacement.to_bits() == size.to_bits()).then_some(scan.bin);
    let (measured, highest) = scanned(scans, of_bins);
    Ok(Panel::new(
        place,
        Axis::new("width of the bins / d (small column, local moves, S = 0.75)", 0.0, 1.15).with_numbers(8),
        Axis::new("P/(nTZ) − 1, %", -0.2 * highest, 1.4 * highest).with_numbers(6),
    )
    .with_legend(Corner::TopRight)
    .line("counting noise outside the own bin", colors::VERMILION, Mark::Line, curve)
    .points("histogram of the last sweep", colors::INK, Mark::Points, measured))
}
