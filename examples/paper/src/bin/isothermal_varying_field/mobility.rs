//! Figure 12: how far a sphere goes in a sweep of the paper's moves, by height.

use super::protocol::Protocol;
use super::results::{Results, color_of};
use gradient_mc::observers::{DisplacementPoint, DisplacementProfile};
use gradient_mc::statistics::Estimate;
use paper::figure::{Axis, Corner, Figure, Mark, Panel, Place, Point, colors};
use paper::row;
use paper::verdict::Verdicts;
use paper::{Failure, Report};

/// Every column with its α.
fn columns(results: &Results) -> Vec<(f64, &DisplacementProfile)> {
    let fluids = results.fluids.iter().map(|fluid| (fluid.column.rate, &fluid.mobility));
    let crystal = results.crystals.first().map(|crystal| (Protocol::CRYSTAL_RATE, &crystal.mobility));
    fluids.chain(crystal).collect()
}

pub(crate) fn draw(results: &Results, report: &mut Report) -> Result<(), Failure> {
    let panel = |left: f64, axis: Axis, title: &str| {
        Panel::new(
            Place { left, top: 0.08, width: 0.5, height: 0.92 },
            Axis::new("height x / d", 0.0, 60.0),
            axis,
        )
        .with_title(title)
    };
    let mut lengths = panel(
        0.0,
        Axis::new("mean accepted displacement / d", 0.0, 0.8),
        "Δr of the paper: mean length of accepted moves",
    )
    .with_legend(Corner::TopLeft);
    let mut paths = panel(
        0.5,
        Axis::logarithmic("path of a sphere in a sweep / d", 1e-4, 1.0),
        "with rejected trials: path per sphere and sweep",
    );
    let mut rows = Vec::new();
    let measured = columns(results);
    for (rate, mobility) in &measured {
        let color = color_of(*rate);
        let points = mobility.points()?;
        let series = |value: fn(&DisplacementPoint) -> Estimate| {
            points
                .iter()
                .filter(move |point| value(point).mean.is_finite())
                .map(move |point| Point::of(point.height, value(point)))
                .collect::<Vec<Point>>()
        };
        let label = format!("α = {rate}, S = {}", Protocol::maximum_displacement(*rate));
        lengths = lengths.points(&label, color, Mark::Points, series(|point| point.mean_displacement));
        paths = paths.points("", color, Mark::Points, series(|point| point.path_per_sweep));
        rows.extend(
            points.iter().map(|point| {
                row![
                    *rate,
                    point.height,
                    point.mean_displacement,
                    point.path_per_sweep,
                    point.accepted_per_sweep,
                ]
            }),
        );
    }
    if let Some(crystal) = results.crystals.first() {
        let height = crystal.fronts()?.bonds.mean;
        let front = [(height, 1e-4), (height, 1.0)];
        paths = paths.line("", colors::GRAY, Mark::Dashed, front).note(
            height + 9.0,
            1.6e-4,
            "front of the crystal",
            colors::GRAY,
        );
    }
    let figure =
        Figure::new("Figure 12: mobility   (T = 20, a = exp(αx), moves of the paper in the steady state)")
            .panel(lengths)
            .panel(paths);
    report.picture("figure_12", &figure, "Figure 12: mean accepted displacement over height")?;
    report.table(
        "figure_12",
        "alpha in 1/d; lengths in d; accepted moves per sphere and sweep; errors are one standard error",
        "alpha, height, mean_displacement, mean_displacement_error, path_per_sweep, \
         path_per_sweep_error, accepted_per_sweep, accepted_per_sweep_error",
        rows,
    )
}

/// Accepted moves at the base over those at a height where the column is dilute or ends.
fn value_near(profile: &DisplacementProfile, low: f64, high: f64) -> Result<Estimate, Failure> {
    let points = profile.points()?;
    let inside = points.iter().filter(|point| (low..high).contains(&point.height));
    Ok(Estimate::mean_of_independent(inside.map(|point| point.mean_displacement)))
}

pub(crate) fn judge(results: &Results, verdicts: &mut Verdicts) -> Result<(), Failure> {
    if let Some(crystal) = results.crystals.first() {
        let fronts = crystal.fronts()?;
        let off = fronts.mobility.minus_independent(fronts.bonds);
        let claim = format!(
            "α = 0.1: height of the decrease of Δr ({}; about 26 in the paper) minus front by bonds, in d",
            fronts.mobility
        );
        verdicts.between("12", &claim, off, -1.0, 1.0);
        let front = fronts.bonds.mean;
        let below = value_near(&crystal.mobility, front - 4.0, front - 2.0)?;
        let above = value_near(&crystal.mobility, front + 1.0, front + 3.0)?;
        let claim = "α = 0.1: Δr 1 to 3 d above the front over that 2 to 4 d below";
        verdicts.at_least("12", claim, above.over_independent(below), 1.2);
    }
    let bases: Vec<Estimate> =
        results.fluids.iter().map(|fluid| value_near(&fluid.mobility, 1.5, 4.5)).collect::<Result<_, _>>()?;
    if let (Some(fluid), Some(first), Some(last)) = (results.fluids.first(), bases.first(), bases.last()) {
        // What is said to be fluid must be mobile at the base.
        let middle = value_near(&fluid.mobility, 20.5, 24.5)?;
        let claim = "α = 0.0025: Δr at the base over that at x = 22";
        verdicts.at_least("12", claim, first.over_independent(middle), 0.7);
        verdicts.at_most(
            "12",
            "Δr at the base, α = 0.05 over α = 0.0025",
            last.over_independent(*first),
            0.7,
        );
    }
    Ok(())
}
