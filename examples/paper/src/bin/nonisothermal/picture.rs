//! The pictures.

use super::column::{Column, LOWEST};
use super::outcome::Outcome;
use super::rows::Row;
use gradient_mc::equation_of_state::{
    CarnahanStarling, EquationOfState, ModifiedKolafa, number_density, packing_fraction,
};
use paper::figure::RGBColor;
use paper::figure::{Axis, Corner, Figure, Mark, Panel, Place, Point, colors};
use paper::{Failure, Report};

const COLORS: [RGBColor; 5] = [colors::INK, colors::BLUE, colors::GREEN, colors::VERMILION, colors::PURPLE];

const ALL: Place = Place { left: 0.0, top: 0.07, width: 1.0, height: 0.93 };
const LEFT: Place = Place { left: 0.0, top: 0.07, width: 0.5, height: 0.93 };
const RIGHT: Place = Place { left: 0.5, top: 0.07, width: 0.5, height: 0.93 };

pub(crate) fn draw(ours: &[Outcome], papers: &[Outcome], report: &mut Report) -> Result<(), Failure> {
    let paper = if papers.is_empty() {
        ""
    } else {
        " Open circles: the protocol of the paper, whose field is computed from every configuration."
    };
    let caption = format!(
        "Number density against height, T = 20 exp(−βx). Points: simulation; lines: local theory between \
         walls. For β of 0.02 and more the density has a maximum above the base, where P = n/β.{paper}"
    );
    report.picture("figure_14a", &densities(ours, papers), &caption)?;
    let caption = "The same on a logarithmic scale. Dashed: the ideal-gas law. Its prefactor C is given by the \
    chemical potential of the column; with the density at the base as prefactor the law is wrong by a factor of more \
    than a hundred.";
    report.picture("figure_14b", &dilute(ours), caption)?;
    let caption = "Mean accepted displacement of moves up to 0.75 d. Left against height, as in the paper: fluid at \
    all heights. Right against packing fraction: one curve, so no part of any column is frozen or glassy.";
    report.picture("figure_15", &mobility(ours, papers), caption)?;
    let caption = format!(
        "P/T against packing fraction, without the layers at the base (x < 8): one curve for all β, that \
        of the equation of state. Below: the difference from modified Kolafa, in per cent, in ranges of height \
        with equal numbers of spheres.{paper}"
    );
    report.picture("figure_16", &equation_of_state(ours, papers), &caption)
}

/// A curve of heights.
fn curve(highest: f64, value: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
    (0..=1200).map(|step| 0.5 + (highest - 0.5) * f64::from(step) / 1200.0).map(|x| (x, value(x))).collect()
}

fn density_points(rows: &[Row]) -> impl Iterator<Item = Point> {
    rows.iter().map(|row| Point::of(row.height(), row.number_density))
}

fn densities(ours: &[Outcome], papers: &[Outcome]) -> Figure {
    const HIGHEST: f64 = 140.0;
    let mut panel = Panel::new(
        ALL,
        Axis::new("height x / d", 0.0, HIGHEST).with_numbers(8),
        Axis::new("number density n d³", 0.0, 0.8),
    )
    .with_legend(Corner::TopRight);
    // The layers at the base, where all curves begin.
    let place = Place { left: 0.075, top: 0.53, width: 0.3, height: 0.36 };
    let mut inset =
        Panel::new(place, Axis::new("x / d", 0.0, 6.0), Axis::new("n d³", 0.0, 2.0).with_numbers(5)).inset();
    for (outcome, color) in ours.iter().zip(COLORS) {
        let column = &outcome.column;
        panel = panel
            .line("", color, Mark::Line, curve(HIGHEST, |x| column.theory.number_density(x)))
            .points(&column.label(), color, Mark::Dots, density_points(&outcome.rows));
        inset = inset.points("", color, Mark::Dots, density_points(&outcome.rows));
    }
    for (outcome, color) in papers.iter().zip(COLORS) {
        let label = if outcome.column.decay_rate > 0.04 { "rings: protocol of the paper" } else { "" };
        let sparse: Vec<Row> =
            outcome.rows.iter().filter(|row| row.height() > 6.5).step_by(3).copied().collect();
        panel = panel.points(label, color, Mark::Rings, density_points(&sparse));
    }
    Figure::new(
        "Figure 14a: density in a temperature gradient, T = 20 exp(−βx); points: simulation, lines: theory",
    )
    .panel(panel)
    .panel(inset)
}

fn dilute(ours: &[Outcome]) -> Figure {
    const HIGHEST: f64 = 220.0;
    let mut panel = Panel::new(
        ALL,
        Axis::new("height x / d", 0.0, HIGHEST).with_numbers(11),
        Axis::logarithmic("number density n d³", 1e-5, 10.0),
    )
    .with_legend(Corner::TopRight);
    for (outcome, color) in ours.iter().zip(COLORS) {
        let column = &outcome.column;
        let label = format!("{}; C = {}", column.label(), power(column.prefactor));
        panel = panel
            .line("", color, Mark::Line, curve(HIGHEST, |x| column.theory.number_density(x).max(1e-9)))
            .line("", color, Mark::Dashed, curve(HIGHEST, |x| column.ideal_gas(x).max(1e-9)))
            .points(&label, color, Mark::Dots, density_points(&outcome.rows));
    }
    let panel = panel.line("ideal-gas law, C in place of n(0)", colors::GRAY, Mark::Dashed, []);
    Figure::new("Figure 14b: the dilute top; points: simulation, lines: theory, dashed: ideal-gas law")
        .panel(panel)
}

/// Two digits and a power of ten.
fn power(value: f64) -> String {
    let text = format!("{value:.1e}");
    let Some((digits, exponent)) = text.split_once('e') else { return text };
    let raised = exponent.chars().map(|digit| {
        ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit.to_digit(10).unwrap_or(0) as usize]
    });
    format!("{digits}·10{}", raised.collect::<String>())
}

fn mobility(ours: &[Outcome], papers: &[Outcome]) -> Figure {
    let y = || Axis::new("mean accepted displacement / d", 0.3, 0.8).with_numbers(11);
    let mut left = Panel::new(LEFT, Axis::new("height x / d", 0.0, 140.0).with_numbers(8), y())
        .with_legend(Corner::BottomRight);
    let mut right = Panel::new(RIGHT, Axis::new("packing fraction (theory)", 0.0, 0.4).with_numbers(5), y())
        .with_legend(Corner::BottomLeft);
    for (outcome, color) in ours.iter().zip(COLORS) {
        let column = &outcome.column;
        // In the dilute top a mean over few moves is too uncertain.
        let occupied = || {
            outcome
                .mobility
                .iter()
                .filter(|point| column.theory.number_density(point.height) > 1e-3 && point.height < 140.0)
        };
        let points = occupied().map(|point| Point::of(point.height, point.mean_displacement));
        left = left.points(&column.label(), color, Mark::Dots, points);
        let points = occupied().filter(|point| (LOWEST..column.highest()).contains(&point.height));
        let points = points
            .map(|point| Point::of(column.theory.packing_fraction(point.height), point.mean_displacement));
        right = right.points(&column.label(), color, Mark::Dots, points);
    }
    for (outcome, color) in papers.iter().zip(COLORS) {
        let points = outcome.mobility.iter().step_by(3).filter(|point| point.height < 140.0);
        left = left.points(
            "",
            color,
            Mark::Rings,
            points.map(|point| Point::of(point.height, point.mean_displacement)),
        );
    }
    Figure::new("Figure 15: mean accepted displacement of moves up to 0.75 d").panel(left).panel(right)
}

/// The points of figure 16.
fn states(rows: &[Row]) -> impl Iterator<Item = Point> {
    rows.iter().map(|row| Point::of(row.packing_fraction().mean, row.pressure_over_temperature))
}

fn equation_of_state(ours: &[Outcome], papers: &[Outcome]) -> Figure {
    const DENSEST: f64 = 0.4;
    let packing = |text: &str| Axis::new(text, 0.0, DENSEST).with_numbers(9);
    let theory = |factor: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
        let etas = (0..=400).map(|step| DENSEST * f64::from(step) / 400.0);
        etas.map(|eta| (eta, number_density(eta) * factor(eta))).collect()
    };
    let upper = Place { left: 0.0, top: 0.07, width: 1.0, height: 0.57 };
    let lower = Place { left: 0.0, top: 0.64, width: 1.0, height: 0.36 };
    let mut curves = Panel::new(upper, packing(""), Axis::new("P/T · d³", 0.0, 6.0))
        .with_legend(Corner::TopLeft)
        .without_x_labels()
        .line(
            "Carnahan-Starling",
            colors::GRAY,
            Mark::Line,
            theory(&|eta| CarnahanStarling.compressibility_factor(eta)),
        )
        .line(
            "modified Kolafa",
            colors::INK,
            Mark::Dashed,
            theory(&|eta| ModifiedKolafa.compressibility_factor(eta)),
        );
    let against_carnahan_starling = |eta: f64| {
        100.0
            * (CarnahanStarling.compressibility_factor(eta) / ModifiedKolafa.compressibility_factor(eta)
                - 1.0)
    };
    let etas = (0..=400).map(|step| DENSEST * f64::from(step) / 400.0);
    let mut differences =
        Panel::new(lower, packing("packing fraction η"), Axis::new("P/(nTZ) − 1, %", -1.5, 1.5))
            .line("", colors::INK, Mark::Dashed, [(0.0, 0.0), (DENSEST, 0.0)])
            .line("", colors::GRAY, Mark::Line, etas.map(|eta| (eta, against_carnahan_starling(eta))));
    for (outcome, color) in ours.iter().zip(COLORS) {
        curves = curves.points(&outcome.column.label(), color, Mark::Dots, states(&outcome.states));
        differences = differences.points("", color, Mark::Points, deviations(outcome));
    }
    for (outcome, color) in papers.iter().zip(COLORS) {
        let label = if outcome.column.decay_rate > 0.04 { "rings: protocol of the paper" } else { "" };
        curves = curves.points(label, color, Mark::Rings, states(&outcome.states));
        differences = differences.points("", color, Mark::Rings, deviations(outcome));
    }
    Figure::new("Figure 16: P/T against packing fraction in temperature gradients, T = 20 exp(−βx)")
        .with_size(1600, 900)
        .panel(curves)
        .panel(differences)
}

/// In per cent, at the packing fraction that theory has in the middle of each group.
fn deviations(outcome: &Outcome) -> Vec<Point> {
    let groups = outcome.column.groups.iter().zip(&outcome.deviations);
    groups
        .map(|(&range, deviation)| {
            at_mean_density(&outcome.column, range, deviation.mean, deviation.standard_error)
        })
        .collect()
}

fn at_mean_density(column: &Column, [low, high]: [f64; 2], deviation: f64, error: f64) -> Point {
    let spheres = column.theory.column_below(high) - column.theory.column_below(low);
    Point { x: packing_fraction(spheres / (high - low)), y: 100.0 * deviation, error: 100.0 * error }
}
