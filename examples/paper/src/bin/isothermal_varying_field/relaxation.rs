//! Figure 7: the center of mass against time, and where it comes to rest.

use super::column::Column;
use super::protocol::Protocol;
use super::results::{COLORS, Fluid, Results, frozen_theory};
use gradient_mc::observers::CenterOfMass;
use gradient_mc::statistics::Estimate;
use paper::figure::{Axis, Corner, Figure, Mark, Panel, Place, Point, colors};
use paper::groups::largest;
use paper::row;
use paper::verdict::Verdicts;
use paper::{Failure, Report};

pub(crate) fn draw(results: &Results, report: &mut Report) -> Result<(), Failure> {
    let last = results.fluids.iter().filter_map(|fluid| fluid.relaxation.center_of_mass.sweeps().last());
    let end = last.copied().max().unwrap_or(1) as f64;
    let mut falling = Panel::new(
        Place { left: 0.0, top: 0.08, width: 0.5, height: 0.92 },
        Axis::new("sweeps / 10⁵", 0.0, end / 1e5),
        Axis::new("height of the center of mass h_c / d", 0.0, 210.0),
    )
    .with_title("from a random gas, moves of the paper");
    let mut both = Panel::new(
        Place { left: 0.5, top: 0.08, width: 0.5, height: 0.92 },
        Axis::logarithmic("sweeps", 1.0, end),
        Axis::new("h_c / d", 0.0, 210.0),
    )
    .with_title("lines: moves of the paper; dots: faster moves")
    .with_legend(Corner::BottomLeft);
    for (fluid, color) in results.fluids.iter().zip(COLORS) {
        let series = || thinned(&fluid.relaxation.center_of_mass, 1e-3 * end);
        falling = falling.line("", color, Mark::Line, series().map(|(sweep, height)| (sweep / 1e5, height)));
        both = both.line(&fluid.label(), color, Mark::Line, series());
        if let Some(run) = fluid.runs.first().filter(|_| !results.paper) {
            let points = thinned(&run.center_of_mass, 0.0).map(|(x, y)| Point { x, y, error: 0.0 });
            both = both.points("", color, Mark::Dots, points);
        }
    }
    let figure = Figure::new("Figure 7: relaxation of the column   (T = 20, a = exp(αx), N/A = 40)");
    let figure = figure.panel(falling).panel(inset(results)?).panel(both);
    let caption = "Figure 7: relaxation of the center of mass from a random start, with the moves of the paper and with faster moves; inset: \
    its steady height against α, with hydrostatics between walls";
    report.picture("figure_07", &figure, caption)?;
    write(results, report)
}

/// Some of the series: each point as far behind the one before as a share of its own time.
fn thinned(series: &CenterOfMass, least: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
    let mut next = 0.0;
    series.sweeps().iter().zip(series.heights()).filter_map(move |(&sweep, &height)| {
        let sweep = sweep as f64;
        (sweep >= next).then(|| {
            next = sweep * 1.02 + least;
            (sweep, height)
        })
    })
}

/// Plateaus against α.
fn inset(results: &Results) -> Result<Panel, Failure> {
    let base = results.fluids.first().ok_or("no fluid column")?.column.base;
    let theory = (0..=40).map(|step| {
        let rate = 0.1 * f64::from(step) / 40.0;
        Ok((rate, frozen_theory(Column { rate, base })?.center_of_mass()))
    });
    let theory = theory.collect::<Result<Vec<_>, Failure>>()?;
    let simulated = results.fluids.iter().map(|fluid| point(fluid.column.rate, fluid.plateau));
    let frozen = results.crystals.iter().map(|crystal| Ok(point(0.1, crystal.center_of_mass.estimate()?)));
    Ok(Panel::new(
        Place { left: 0.24, top: 0.12, width: 0.25, height: 0.42 },
        Axis::new("α d", 0.0, 0.105).with_numbers(5),
        Axis::new("steady h_c / d", 15.0, 55.0).with_numbers(5),
    )
    .inset()
    .with_legend(Corner::TopRight)
    .line("theory", colors::INK, Mark::Line, theory)
    .points("fluid", colors::BLUE, Mark::Points, simulated)
    .points("crystal", colors::VERMILION, Mark::Rings, frozen.collect::<Result<Vec<_>, Failure>>()?))
}

fn point(x: f64, estimate: Estimate) -> Point {
    Point::of(x, estimate)
}

fn write(results: &Results, report: &mut Report) -> Result<(), Failure> {
    let mut rows = Vec::new();
    for fluid in &results.fluids {
        let rate = fluid.column.rate;
        for (ours, run) in
            std::iter::once((0.0, &fluid.relaxation)).chain(fluid.runs.iter().map(|run| (1.0, run)))
        {
            rows.extend(thinned(&run.center_of_mass, 0.0).map(|(sweep, height)| [rate, ours, sweep, height]));
        }
    }
    report.table(
        "figure_07",
        "alpha in 1/d; moves: 0 local moves of the paper, 1 tuned moves or event chains (one run after the other); heights in d",
        "alpha, moves, sweep, center_of_mass",
        rows,
    )?;
    let plateau = |fluid: &Fluid| row![fluid.column.rate, fluid.plateau, fluid.theory.center_of_mass()];
    let mut rows: Vec<Vec<f64>> = results.fluids.iter().map(plateau).collect();
    for crystal in &results.crystals {
        let rate = Protocol::CRYSTAL_RATE;
        let theory = frozen_theory(Column { rate, base: crystal.base })?;
        let measured = crystal.center_of_mass.estimate()?;
        rows.push(row![rate, measured, theory.center_of_mass()]);
    }
    report.table("figure_07_inset",
        "alpha in 1/d; heights in d; theory: hydrostatics between walls, modified Kolafa fluid and Speedy crystal; errors are one standard error",
        "alpha, center_of_mass, center_of_mass_error, center_of_mass_theory",
        rows,
    )
}

pub(crate) fn judge(results: &Results, verdicts: &mut Verdicts) {
    for fluid in &results.fluids {
        let theory = fluid.theory.center_of_mass();
        let off = fluid.plateau - theory;
        // The theory shifts the whole column by what the layers at the wall hold; between the layers and
        // the curvature of the field it is as good as some hundredths of a diameter.
        let claim = format!("{}: steady h_c minus theory ({theory:.3}), in d", fluid.label());
        verdicts.between("7 inset", &claim, off, -0.1, 0.1);
        let largest = 0.05;
        let claim = format!("{}: standard error of steady h_c, in d", fluid.label());
        verdicts.at_most("7 inset", &claim, Estimate::exact(fluid.plateau.standard_error), largest);
        let heights = fluid.relaxation.center_of_mass.heights();
        let end = &heights[heights.len() * 9 / 10..];
        let mean = end.iter().sum::<f64>() / end.len().max(1) as f64;
        // Of 155 to 176 diameters; the paper runs five times as long before it measures.
        let start = heights.first().copied().unwrap_or(f64::NAN);
        let left = 100.0 * (mean - fluid.plateau.mean) / (start - fluid.plateau.mean);
        let claim = format!(
            "{}: remaining part of the relaxation at the end of the run with the moves of the paper, in %",
            fluid.label()
        );
        verdicts.between("7", &claim, Estimate::exact(left), -1.0, 1.0);
    }
    let steps = results.fluids.windows(2).map(|pair| pair[1].plateau.mean - pair[0].plateau.mean);
    let largest = largest(steps);
    verdicts.at_most(
        "7 inset",
        "largest change of h_c from one α to the next, in d",
        Estimate::exact(largest),
        -1.0,
    );
}
