//! Figure 8: n(x) of the fluid columns, and the ideal gas that they end in.

use super::protocol::Protocol;
use super::results::{COLORS, Fluid, Results};
use gradient_mc::Field;
use gradient_mc::field::ExponentialField;
use gradient_mc::observers::BinState;
use gradient_mc::statistics::Estimate;
use paper::figure::{Axis, Corner, Figure, Mark, Panel, Place, Point, colors};
use paper::groups::{farthest_from_zero, means_over};
use paper::row;
use paper::verdict::Verdicts;
use paper::{Failure, Report};

/// Below are layers, above is the bulk.
const BULK_BEGINS: f64 = 8.0;

/// Number density over one bin in so many, as in the figures.
struct Shown {
    height: f64,
    number_density: Estimate,
}

/// The mean density over bins `width` wide above the layers, and single bins in them.
fn shown(fluid: &Fluid, width: f64) -> Result<Vec<Shown>, Failure> {
    let points = fluid.profile.points()?;
    let mut found = Vec::new();
    for point in points.iter().filter(|point| (0.5..BULK_BEGINS).contains(&point.height)) {
        found.push(Shown { height: point.height, number_density: point.number_density });
    }
    let top = fluid.theory.height_of_fraction(1.0 - 1e-7).min(Protocol::HEIGHT - 1.0);
    let mut low = BULK_BEGINS;
    let mut ranges = Vec::new();
    while low < top {
        ranges.push([low, low + width]);
        low += width;
    }
    let means = fluid.profile.jackknife(|states| mean_densities(states, &ranges))?;
    found.extend(
        ranges.iter().zip(means).map(|(range, number_density)| Shown {
            height: f64::midpoint(range[0], range[1]),
            number_density,
        }),
    );
    Ok(found)
}

/// Mean density over ranges of height.
fn mean_densities(states: &[BinState], ranges: &[[f64; 2]]) -> Vec<f64> {
    means_over(states, ranges, |state| state.number_density)
}

/// The ideal gas that the theory ends in: its prefactor is the activity, not the density at the
/// base.
pub(crate) fn ideal_gas(fluid: &Fluid) -> Result<impl Fn(f64) -> f64 + use<>, Failure> {
    let field = ExponentialField::new(fluid.column.rate)?;
    let dilute = fluid.theory.height_of_fraction(1.0 - 1e-8);
    let ln_activity =
        libm::log(fluid.theory.number_density(dilute)) + field.potential(dilute) / Protocol::TEMPERATURE;
    Ok(move |height: f64| libm::exp(ln_activity - field.potential(height) / Protocol::TEMPERATURE))
}

pub(crate) fn draw(results: &Results, report: &mut Report) -> Result<(), Failure> {
    let mut plain = Panel::new(
        Place { left: 0.0, top: 0.08, width: 0.5, height: 0.92 },
        Axis::new("height x / d", 0.0, 140.0).with_numbers(8),
        Axis::new("n d³", 0.0, 1.2),
    )
    .with_title("(a) points: simulation; lines: hydrostatics between walls")
    .with_legend(Corner::TopRight);
    let mut logarithmic = Panel::new(
        Place { left: 0.5, top: 0.08, width: 0.5, height: 0.92 },
        Axis::new("height x / d", 0.0, 250.0).with_numbers(6),
        Axis::logarithmic("n d³", 1e-5, 10.0),
    )
    .with_title("(b) lines: ideal gas of the same activity");
    for (fluid, color) in results.fluids.iter().zip(COLORS) {
        let points = |width: f64| -> Result<Vec<Point>, Failure> {
            let points = shown(fluid, width)?.into_iter().filter(|point| point.number_density.mean > 0.0);
            Ok(points.map(|point| Point::of(point.height, point.number_density)).collect())
        };
        let heights = || (0..=1000).map(|step| 0.25 * f64::from(step));
        let theory = heights().map(|height| (height, fluid.theory.number_density(height)));
        let ideal = ideal_gas(fluid)?;
        plain = plain.points(&fluid.label(), color, Mark::Dots, points(1.0)?).line(
            "",
            color,
            Mark::Line,
            theory.filter(|point| point.1 > 0.001),
        );
        logarithmic = logarithmic
            .line(
                "",
                colors::GRAY,
                Mark::Line,
                heights().map(|height| (height, ideal(height))).filter(|point| point.1 > 1e-6),
            )
            .points("", color, Mark::Dots, points(3.0)?);
    }
    let figure = Figure::new("Figure 8: number density   (T = 20, a = exp(αx), N/A = 40)");
    let figure = figure.panel(plain).panel(logarithmic);
    report.picture(
        "figure_08",
        &figure,
        "Figure 8: density over height with theory, and on a logarithmic scale with the ideal gas",
    )?;
    let mut rows = Vec::new();
    for fluid in &results.fluids {
        let ideal = ideal_gas(fluid)?;
        for point in shown(fluid, 1.0)? {
            rows.push(row![
                fluid.column.rate,
                point.height,
                point.number_density,
                fluid.theory.number_density(point.height),
                ideal(point.height),
            ]);
        }
    }
    report.table("figure_08",
        "alpha in 1/d; heights in d; densities in 1/d^3, bins of 0.1 below 8, means over 1 above; theory: hydrostatics between walls, modified Kolafa; ideal gas of its activity; errors are one standard error",
        "alpha, height, number_density, number_density_error, number_density_theory, \
         number_density_ideal_gas",
        rows,
    )
}

pub(crate) fn judge(results: &Results, verdicts: &mut Verdicts) -> Result<(), Failure> {
    for fluid in &results.fluids {
        let dense: Vec<[f64; 2]> = ranges(fluid, 4.0, [0.1, 10.0]);
        let dilute: Vec<[f64; 2]> = ranges(fluid, 1.0, [0.0005, 0.004]);
        let means = fluid.profile.jackknife(|states| mean_densities(states, &dense))?;
        let off = means.iter().zip(&dense).map(|(mean, &range)| {
            let expected = mean_between(&|height| fluid.theory.number_density(height), range);
            100.0 * (*mean / expected - 1.0)
        });
        let bulk = farthest_from_zero(off);
        let claim = format!(
            "{}: largest deviation of n over 4 d from theory, x > 8 and n > 0.1, in %",
            fluid.label()
        );
        verdicts.between("8a", &claim, bulk, -2.0, 2.0);
        // The whole tail in one number.
        let ideal = ideal_gas(fluid)?;
        let (Some(first), Some(last)) = (dilute.first(), dilute.last()) else {
            return Err("no range of heights is that dilute".into());
        };
        let tail = [[first[0], last[1]]];
        let mean = fluid.profile.jackknife(|states| mean_densities(states, &tail))?[0];
        let expected = mean_between(&ideal, tail[0]);
        let off = 100.0 * (mean / expected - 1.0);
        let claim = format!(
            "{}: deviation of n from the ideal gas of the activity of theory, 0.0005 < n < 0.004, {off} %, in standard errors",
            fluid.label()
        );
        verdicts.between("8b", &claim, Estimate::exact(off.deviation_from(0.0)), -4.0, 4.0);
        let claim = format!("{}: its error, in %", fluid.label());
        verdicts.at_most("8b", &claim, Estimate::exact(off.standard_error), 15.0);
    }
    Ok(())
}

/// The mean of a density of theory over a range of heights.
fn mean_between(density: &impl Fn(f64) -> f64, [low, high]: [f64; 2]) -> f64 {
    let bins = 400;
    let middles = (0..bins).map(|bin| low + (high - low) * (f64::from(bin) + 0.5) / f64::from(bins));
    middles.map(density).sum::<f64>() / f64::from(bins)
}

/// Ranges of heights above the layers, each so high, where the theory is between two densities.
fn ranges(fluid: &Fluid, height: f64, [least, most]: [f64; 2]) -> Vec<[f64; 2]> {
    let mut found = Vec::new();
    let mut low = BULK_BEGINS;
    while low + height < Protocol::HEIGHT {
        let density = |at: f64| fluid.theory.number_density(at);
        if density(low) <= most && density(low + height) >= least {
            found.push([low, low + height]);
        }
        low += height;
    }
    found
}
