//! The picture of a case: the profile and its layers at the base on the left, the equation of state
//! and the deviation from it on the right.

use super::report::{BULK_BEGINS, Bin, Factor, Report};
use gradient_mc::EquationOfState;
use gradient_mc::equation_of_state::{CarnahanStarling, ModifiedKolafa, number_density};
use gradient_mc::statistics::Estimate;
use paper::Failure;
use paper::figure::{Axis, Corner, Figure, Mark, Panel, Place, Point, colors};
use std::path::Path;

/// Draws `<path>.svg` and `<path>.png`.
pub(crate) fn draw(report: &Report, path: &Path) -> Result<(), Failure> {
    let title = format!(
        "{}   (N = {}, N/A = {})",
        report.case.title(),
        report.particles,
        super::Protocol::COLUMN_DENSITY
    );
    Figure::new(&title)
        .panel(profile(report))
        .panel(layers(report))
        .panel(equation_of_state(report))
        .panel(deviation(report))
        .save(path)
}

fn profile(report: &Report) -> Panel {
    let place = Place { left: 0.0, top: 0.07, width: 0.5, height: 0.54 };
    let highest = report.bins.iter().rev().find(|bin| bin.number_density_theory > 0.003);
    let top = round_up(highest.map_or(1.0, |bin| bin.height), 10.0);
    let densest = report.bins.iter().map(|bin| bin.number_density_theory).fold(0.0, f64::max);
    let spacing = top / 60.0;
    // Every n-th bin would look like scatter in the layers; the panel of the layers shows all bins.
    let mut next = BULK_BEGINS;
    let points = report.bins.iter().filter(move |bin| {
        let shown = bin.height >= next;
        if shown {
            next = bin.height + 0.999 * spacing;
        }
        shown
    });
    Panel::new(
        place,
        Axis::new("height x / d", 0.0, top).with_numbers(8),
        Axis::new("n d³", 0.0, round_up(1.15 * densest, 0.1)).with_numbers(5),
    )
    .with_legend(Corner::TopRight)
    .points(
        &format!("simulation (some bins, x > {BULK_BEGINS} d)"),
        colors::INK,
        Mark::Points,
        points.map(density_point),
    )
    .line("hydrostatics, Carnahan–Starling", colors::VERMILION, Mark::Line, theory(report))
}

/// The layers at the wall, which the local theory does not describe.
fn layers(report: &Report) -> Panel {
    let place = Place { left: 0.0, top: 0.615, width: 0.5, height: 0.385 };
    let bins = report.bins.iter().filter(|bin| bin.height < BULK_BEGINS);
    let highest = bins.clone().map(|bin| bin.number_density.mean).fold(0.0, f64::max);
    Panel::new(
        place,
        Axis::new("height x / d, layers at the base", 0.0, BULK_BEGINS).with_numbers(8),
        Axis::new("n d³", 0.0, round_up(1.05 * highest, 0.5)).with_numbers(4),
    )
    .with_legend(Corner::TopRight)
    .line("", colors::VERMILION, Mark::Line, theory(report))
    .points("simulation (all bins)", colors::INK, Mark::Points, bins.map(density_point))
}

fn equation_of_state(report: &Report) -> Panel {
    let place = Place { left: 0.5, top: 0.07, width: 0.5, height: 0.56 };
    let densest = densest(report);
    let at =
        |equation: &dyn EquationOfState, eta: f64| number_density(eta) * equation.compressibility_factor(eta);
    let curve = |equation: &'static dyn EquationOfState| {
        (0..=400).map(move |step| f64::from(step) / 400.0 * densest).map(move |eta| (eta, at(equation, eta)))
    };
    let spacing = densest / 45.0;
    let mut next = 0.0;
    let mut bins: Vec<&Bin> = report.bulk().collect();
    bins.sort_by(|first, second| first.packing_fraction().total_cmp(&second.packing_fraction()));
    let points = bins.into_iter().filter(|bin| {
        let shown = bin.packing_fraction() >= next;
        if shown {
            next = bin.packing_fraction() + spacing;
        }
        shown
    });
    Panel::new(
        place,
        Axis::new("packing fraction η", 0.0, densest).with_numbers(8),
        Axis::new("P / T  (d⁻³)", 0.0, round_up(1.02 * at(&CarnahanStarling, densest), 0.5)),
    )
    .without_x_labels()
    .with_legend(Corner::TopLeft)
    .points(
        "simulation (some of the bins)",
        colors::INK,
        Mark::Points,
        points.map(|bin| Point {
            x: bin.packing_fraction(),
            y: bin.pressure.mean / bin.temperature,
            error: bin.pressure.standard_error / bin.temperature,
        }),
    )
    .line("Carnahan–Starling", colors::VERMILION, Mark::Line, curve(&CarnahanStarling))
    .line("modified Kolafa–Labík–Malijevský", colors::BLUE, Mark::Dashed, curve(&ModifiedKolafa))
    // Only for the legend, because the panel below has no space for one.
    .points("below: ranks, from all heights together", colors::GREEN, Mark::Points, [])
    .points("below: collisions, from all heights together", colors::PURPLE, Mark::Points, [])
}

fn deviation(report: &Report) -> Panel {
    let place = Place { left: 0.5, top: 0.645, width: 0.5, height: 0.355 };
    let densest = densest(report);
    let against =
        |eta: f64, factor: Estimate| factor * (1.0 / CarnahanStarling.compressibility_factor(eta)) - 1.0;
    let routes: [fn(&Factor) -> Estimate; 2] = [|factor| factor.ranks, |factor| factor.collisions];
    // Slightly shifted, so that both error bars are visible.
    let points = |route: usize| {
        let shift = (route as f64 - 0.5) * 0.008 * densest;
        report.factors.iter().map(move |factor| {
            let eta = factor.packing_fraction;
            Point::percent(eta + shift, against(eta, routes[route](factor)))
        })
    };
    let curve = (1..=400).map(|step| f64::from(step) / 400.0 * densest).map(|eta| {
        let factor = Estimate::exact(ModifiedKolafa.compressibility_factor(eta));
        (eta, 100.0 * against(eta, factor).mean)
    });
    // All points are inside the panel; long error bars may be clipped.
    let largest = (0..2).flat_map(points).map(|point| point.y.abs()).filter(|y| y.is_finite());
    let range = round_up(1.2 * largest.fold(0.4, f64::max), 0.25);
    Panel::new(
        place,
        Axis::new("packing fraction η", 0.0, densest).with_numbers(8),
        Axis::new("Z / Z(CS) − 1  (%)", -range, range).with_numbers(5),
    )
    .points("", colors::GREEN, Mark::Points, points(0))
    .points("", colors::PURPLE, Mark::Points, points(1))
    .line("", colors::VERMILION, Mark::Line, [(0.0, 0.0), (densest, 0.0)])
    .line("", colors::BLUE, Mark::Dashed, curve)
}

fn density_point(bin: &Bin) -> Point {
    Point::of(bin.height, bin.number_density)
}

fn theory(report: &Report) -> impl Iterator<Item = (f64, f64)> + '_ {
    report.bins.iter().map(|bin| (bin.height, bin.number_density_theory))
}

/// Packing fraction at which the equation-of-state panels end.
fn densest(report: &Report) -> f64 {
    round_up(1.03 * report.bulk().map(Bin::packing_fraction).fold(0.05, f64::max), 0.05)
}

fn round_up(value: f64, step: f64) -> f64 {
    (value / step - 1e-9).ceil() * step
}
