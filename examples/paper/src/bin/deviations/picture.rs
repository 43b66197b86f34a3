//! The pictures.

use super::checks::LINE;
use super::outcome::{Analysis, Outcome};
use gradient_mc::equation_of_state::{CarnahanStarling, EquationOfState, ModifiedKolafa};
use gradient_mc::statistics::Estimate;
use paper::figure::RGBColor;
use paper::figure::{Axis, Corner, Figure, Mark, Panel, Place, Point, colors};
use paper::{Failure, Report};

const LEFT: Place = Place { left: 0.0, top: 0.07, width: 0.5, height: 0.93 };
const RIGHT: Place = Place { left: 0.5, top: 0.07, width: 0.5, height: 0.93 };
/// Of the left panel.
const LOWEST: f64 = 1e-6;
const HIGHEST: f64 = 1.0;

pub(crate) fn draw(outcomes: &[Outcome], report: &mut Report) -> Result<(), Failure> {
    let both = "Left: δ (33) and σ (32) as defined in the paper, in bins of 0.1 d, with its lines: dashed at 2 %, and \
    vertical at the packing fraction where the density changes most. Right: P/(nTZ) − 1 with error bars over \
    ranges of height, Carnahan-Starling (rings) and modified Kolafa (dots).";
    for (panel, title, caption) in [
        ("17a", "Figure 17a: uniform field, T₀ = 5", format!("Isothermal, uniform field, T₀ = 5. {both}")),
        (
            "17b",
            "Figure 17b: varying field, T₀ = 20, α = 0.05 and 0.1",
            format!(
                "Isothermal, varying field, T₀ = 20: α = 0.05, and the fluid above the crystal at α = 0.1. {both}"
            ),
        ),
        (
            "17c",
            "Figure 17c: temperature gradient, T₀ = 20, β = 0.05",
            format!(
                "Temperature gradient, T₀ = 20, β = 0.05. {both} Green and purple: the field of the paper with the same counting \
                noise, from above and from below, which gives the 7 % of the paper. Dashed line on the right: deviation of any local \
                equation where the density changes within a diameter, to lowest order."
            ),
        ),
    ] {
        let of_panel: Vec<&Outcome> = outcomes.iter().filter(|outcome| outcome.case.panel == panel).collect();
        let densest = of_panel.iter().flat_map(|outcome| &outcome.ours.points);
        let densest = densest.map(|point| point.packing_fraction).fold(0.0, f64::max);
        // To the next twentieth.
        let densest = (20.0 * densest).ceil() / 20.0;
        let figure =
            Figure::new(title).panel(papers_measures(&of_panel, densest)).panel(modern(&of_panel, densest));
        report.picture(&format!("figure_{panel}"), &figure, &caption)?;
    }
    Ok(())
}

fn packing(densest: f64) -> Axis {
    Axis::new("packing fraction", 0.0, densest).with_numbers(6)
}

fn bins(analysis: &Analysis, value: impl Fn(&super::papers::PaperPoint) -> f64) -> Vec<Point> {
    let points = analysis.points.iter();
    points
        .map(|point| Point { x: point.packing_fraction, y: value(point).clamp(LOWEST, HIGHEST), error: 0.0 })
        .collect()
}

fn papers_measures(outcomes: &[&Outcome], densest: f64) -> Panel {
    let mut panel = Panel::new(LEFT, packing(densest), Axis::logarithmic("δ and σ", LOWEST, HIGHEST))
        .with_title("analysis of the paper: five runs, bins of 0.1 d")
        .with_legend(Corner::BottomLeft)
        .line("2 %", colors::INK, Mark::Dashed, [(0.0, LINE), (densest, LINE)]);
    let palettes = [[colors::BLUE, colors::VERMILION], [colors::GREEN, colors::PURPLE]];
    for (outcome, [first, second]) in outcomes.iter().zip(palettes) {
        let name =
            if outcomes.len() > 1 { format!(", α = {}", outcome.case.growth_rate) } else { String::new() };
        panel = panel
            .points(
                &format!("σ, eq. (32){name}"),
                second,
                Mark::Dots,
                bins(&outcome.ours, |point| point.scatter),
            )
            .points(
                &format!("δ, eq. (33){name}"),
                first,
                Mark::Dots,
                bins(&outcome.ours, |point| point.deviation),
            );
        let (steepest, _) = outcome.case.steepest();
        panel = panel.line("", colors::GRAY, Mark::Dashed, [(steepest, LOWEST), (steepest, HIGHEST)]);
        for (runs, color) in outcome.papers.iter().zip([colors::GREEN, colors::PURPLE]) {
            panel = panel.points(
                &format!("δ, {}", runs.name),
                color,
                Mark::Dots,
                bins(&runs.first, |point| point.deviation),
            );
        }
    }
    panel
}

fn modern(outcomes: &[&Outcome], densest: f64) -> Panel {
    let mut panel =
        Panel::new(RIGHT, packing(densest), Axis::new("P/(nTZ) − 1, %", -4.0, 5.0).with_numbers(9))
            .with_title("with error bars, over ranges of height")
            .with_legend(Corner::TopRight);
    for line in [-100.0 * LINE, 100.0 * LINE] {
        panel = panel.line("", colors::INK, Mark::Dashed, [(0.0, line), (densest, line)]);
    }
    let curve = (0..=300).map(|step| densest * f64::from(step) / 300.0);
    let difference = |eta: f64| {
        // What a column that obeys the better equation shows against the other.
        100.0
            * (ModifiedKolafa.compressibility_factor(eta) / CarnahanStarling.compressibility_factor(eta)
                - 1.0)
    };
    panel = panel.line("", colors::GRAY, Mark::Line, [(0.0, 0.0), (densest, 0.0)]).line(
        "modified Kolafa over Carnahan-Starling",
        colors::GRAY,
        Mark::Dashed,
        curve.filter(|eta| *eta < 0.5).map(|eta| (eta, difference(eta))),
    );
    for (outcome, colors) in
        outcomes.iter().zip([[colors::VERMILION, colors::BLUE], [colors::PURPLE, colors::GREEN]])
    {
        let name =
            if outcomes.len() > 1 { format!(", α = {}", outcome.case.growth_rate) } else { String::new() };
        let series = |deviations: &[Estimate]| -> Vec<Point> {
            let groups = outcome.case.groups.iter().zip(deviations);
            groups
                .map(|(&group, deviation)| {
                    Point::percent(outcome.case.mean_packing_fraction(group), *deviation)
                })
                .collect()
        };
        let [rings, dots]: [RGBColor; 2] = colors;
        let groups = outcome.case.groups.iter().zip(&outcome.nonlocal);
        let expected =
            groups.map(|(&group, nonlocal)| (outcome.case.mean_packing_fraction(group), 100.0 * nonlocal));
        panel = panel
            .line("", dots, Mark::Dashed, expected)
            .points(
                &format!("Carnahan-Starling{name}"),
                rings,
                Mark::Rings,
                series(&outcome.ours.carnahan_starling),
            )
            .points(
                &format!("modified Kolafa{name}"),
                dots,
                Mark::Points,
                series(&outcome.ours.modified_kolafa),
            );
    }
    panel
}
