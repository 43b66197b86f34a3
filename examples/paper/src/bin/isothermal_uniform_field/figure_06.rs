//! Figure 6: the equation of state from all columns.

use super::figure_03::{BULK_BEGINS, height_of};
use super::protocol::DRAWN;
use super::state::State;
use super::style::color_of;
use gradient_mc::EquationOfState;
use gradient_mc::equation_of_state::{CarnahanStarling, ModifiedKolafa, number_density};
use gradient_mc::observers::EquationOfStatePoint;
use gradient_mc::statistics::Estimate;
use paper::figure::{Axis, Corner, Figure, Mark, Panel, Place, Point, colors};
use paper::groups::{edges_of_equal_numbers, farthest_from_zero, largest, magnitude, ranges_between};
use paper::row;
use paper::{Failure, Report};

/// Up to where packing fractions are drawn.
const DENSEST: f64 = 0.5;
/// Where the packing fraction falls below this, counts are too few.
const DILUTE: f64 = 0.02;
/// Ranges of heights with equally many spheres.
const GROUPS: usize = 8;

/// Deviation of P from n T Z in a range of heights.
#[derive(Debug, Clone, Copy)]
struct Group {
    packing_fraction: f64,
    from_carnahan_starling: Estimate,
    from_kolafa: Estimate,
}

pub(crate) fn report(states: &[State<'_>], report: &mut Report) -> Result<(), Failure> {
    let mut points = Vec::new();
    let mut groups = Vec::new();
    for state in states {
        let bulk =
            |point: &EquationOfStatePoint| point.height > BULK_BEGINS && point.packing_fraction.mean > DILUTE;
        points.push((state, state.profile.points()?.into_iter().filter(bulk).collect::<Vec<_>>()));
        groups.push((state, in_groups(state)?));
    }
    let figure = Figure::new("Figure 6: equation of state from the columns: P/T₀ against packing fraction")
        .panel(equation_of_state(&points))
        .panel(deviation(&groups));
    report.picture(
        "figure_06",
        &figure,
        "Left, as in the paper: pressure over temperature against packing fraction, from one column for each temperature, x > 8 d; \
         lines are two equations of state. Right: deviation from Carnahan-Starling over groups of heights with equally many \
         spheres, with the difference between the two equations.",
    )?;
    report.table(
        "figure_06",
        "temperature in m g d; height in d; pressure over temperature in 1/d^3; bins of 0.5 d; errors are one standard error",
        "temperature, height, packing_fraction, packing_fraction_error, \
         pressure_over_temperature, pressure_over_temperature_error",
        points.iter().flat_map(|(state, points)| {
            points.iter().map(|point| {
                row![
                    state.temperature,
                    point.height,
                    point.packing_fraction,
                    point.pressure.mean / point.temperature,
                    point.pressure.standard_error / point.temperature,
                ]
            })
        }),
    )?;
    for (state, groups) in &groups {
        for (name, allowed, deviation) in [
            ("modified Kolafa-Labík-Malijevský", 0.01, group_from_kolafa as fn(&Group) -> Estimate),
            ("Carnahan-Starling", 0.02, group_from_carnahan_starling),
        ] {
            let found = groups.iter().map(deviation);
            report.verdicts.at_most(
                "6",
                &format!(
                    "largest |P/(nTZ) − 1| at T = {} in {GROUPS} groups of heights, {name}",
                    state.temperature
                ),
                magnitude(farthest_from_zero(found)),
                allowed,
            );
        }
        let in_errors = groups.iter().map(|group| group.from_kolafa.deviation_from(0.0).abs());
        report.verdicts.at_most(
            "6",
            &format!("the same at T = {} in standard errors, the better equation", state.temperature),
            Estimate::exact(largest(in_errors)),
            4.0,
        );
        let errors = groups.iter().map(|group| group.from_kolafa.standard_error);
        report.verdicts.at_most(
            "6",
            &format!("largest of these standard errors at T = {}", state.temperature),
            Estimate::exact(largest(errors)),
            0.005,
        );
    }
    Ok(())
}

fn group_from_kolafa(group: &Group) -> Estimate {
    group.from_kolafa
}

fn group_from_carnahan_starling(group: &Group) -> Estimate {
    group.from_carnahan_starling
}

fn in_groups(state: &State<'_>) -> Result<Vec<Group>, Failure> {
    let theory = &state.theory.kolafa;
    let highest = height_of(state, DILUTE);
    let ranges = ranges_between(&edges_of_equal_numbers(theory, [BULK_BEGINS, highest], GROUPS));
    let carnahan_starling = state.profile.deviations_over(&ranges, &CarnahanStarling)?;
    let kolafa = state.profile.deviations_over(&ranges, &ModifiedKolafa)?;
    let rows = ranges.iter().zip(carnahan_starling.into_iter().zip(kolafa));
    Ok(rows
        .map(|([low, high], (from_carnahan_starling, from_kolafa))| Group {
            packing_fraction: theory.packing_fraction(f64::midpoint(*low, *high)),
            from_carnahan_starling,
            from_kolafa,
        })
        .collect())
}

fn equation_of_state(measured: &[(&State<'_>, Vec<EquationOfStatePoint>)]) -> Panel {
    let place = Place { left: 0.0, top: 0.07, width: 0.5, height: 0.93 };
    let mut panel = Panel::new(
        place,
        Axis::new("packing fraction η", 0.0, DENSEST).with_numbers(6),
        Axis::new("P / T₀  (d⁻³)", 0.0, 8.0).with_numbers(9),
    )
    .with_legend(Corner::TopLeft);
    for (state, points) in measured.iter().filter(|(state, _)| DRAWN.contains(&state.temperature)) {
        let mut next = f64::INFINITY;
        let shown = points.iter().filter(move |point| {
            // Upwards is towards lower packing fractions.
            let shown = point.packing_fraction.mean < next;
            if shown {
                next = point.packing_fraction.mean - 0.012;
            }
            shown
        });
        let shown = shown.map(|point| Point {
            x: point.packing_fraction.mean,
            y: point.pressure.mean / point.temperature,
            error: point.pressure.standard_error / point.temperature,
        });
        let label = format!("T₀ = {}, simulation (some bins)", state.temperature);
        panel = panel.points(&label, color_of(state.temperature), Mark::Points, shown);
    }
    let curve = |equation: &'static dyn EquationOfState| {
        (1..=500).map(move |step| {
            let eta = 0.001 * f64::from(step);
            (eta, number_density(eta) * equation.compressibility_factor(eta))
        })
    };
    panel.line("Carnahan–Starling", colors::GRAY, Mark::Line, curve(&CarnahanStarling)).line(
        "modified Kolafa–Labík–Malijevský",
        colors::INK,
        Mark::Dashed,
        curve(&ModifiedKolafa),
    )
}

fn deviation(measured: &[(&State<'_>, Vec<Group>)]) -> Panel {
    let place = Place { left: 0.5, top: 0.07, width: 0.5, height: 0.93 };
    let mut panel = Panel::new(
        place,
        Axis::new("packing fraction η", 0.0, DENSEST).with_numbers(6),
        Axis::new("P / P(CS) − 1  (%)", -1.5, 1.5).with_numbers(7),
    )
    .with_legend(Corner::TopLeft);
    for (state, groups) in measured.iter().filter(|(state, _)| DRAWN.contains(&state.temperature)) {
        let points =
            groups.iter().map(|group| Point::percent(group.packing_fraction, group.from_carnahan_starling));
        panel = panel.points(
            &format!("T₀ = {}", state.temperature),
            color_of(state.temperature),
            Mark::Points,
            points,
        );
    }
    let difference = (1..=500).map(|step| {
        let eta = 0.001 * f64::from(step);
        let ratio = ModifiedKolafa.compressibility_factor(eta) / CarnahanStarling.compressibility_factor(eta);
        (eta, 100.0 * (ratio - 1.0))
    });
    panel.line("Carnahan–Starling", colors::GRAY, Mark::Line, [(0.0, 0.0), (DENSEST, 0.0)]).line(
        "modified Kolafa–Labík–Malijevský",
        colors::INK,
        Mark::Dashed,
        difference,
    )
}
