//! Figure 5: how far spheres move in the paper's trials, against height.

use super::figure_03::BULK_BEGINS;
use super::protocol::PAPER_DISPLACEMENT;
use super::state::State;
use super::style::color_of;
use gradient_mc::observers::DisplacementPoint;
use gradient_mc::statistics::Estimate;
use paper::figure::{Axis, Corner, Figure, Mark, Panel, Place, Point, colors};
use paper::groups::{farthest_from_zero, magnitude};
use paper::row;
use paper::{Failure, Report};

/// Mobility of one temperature.
struct Mobility<'a> {
    state: &'a State<'a>,
    points: Vec<DisplacementPoint>,
}

pub(crate) fn report(states: &[State<'_>], report: &mut Report) -> Result<(), Failure> {
    let mut measured = Vec::new();
    for state in states {
        if let Some(mobility) = state.columns.iter().find_map(|column| column.mobility.as_ref()) {
            measured.push(Mobility { state, points: mobility.points()? });
        }
    }
    let figure = Figure::new("Figure 5: mean length of accepted displacements, S = 0.75")
        .panel(against_height(&measured))
        .panel(against_packing(&measured));
    report.picture(
        "figure_05",
        &figure,
        "Left, as in the paper: mean length of the accepted displacements of local moves (S = 0.75) against height, in the steady \
        state; dashed: the exact value of a dilute gas. At T₀ = 5 it decreases near the base. Right: the same against the packing \
        fraction of the theory at this height: both temperatures give one curve, so the decrease is that of any dense fluid.",
    )?;
    report.table(
        "figure_05",
        "temperature in m g d; height in d, middles of bins of 0.5; displacements in d; errors are one standard error",
        "temperature, height, packing_fraction_theory, mean_displacement, \
         mean_displacement_error, accepted_per_sweep, accepted_per_sweep_error",
        measured.iter().flat_map(|mobility| {
            mobility.points.iter().filter(|point| point.mean_displacement.mean.is_finite()).map(|point| {
                row![
                    mobility.state.temperature,
                    point.height,
                    mobility.state.theory.kolafa.packing_fraction(point.height),
                    point.mean_displacement,
                    point.accepted_per_sweep,
                ]
            })
        }),
    )?;
    claims(&measured, report);
    Ok(())
}

fn against_height(measured: &[Mobility<'_>]) -> Panel {
    let place = Place { left: 0.0, top: 0.07, width: 0.5, height: 0.93 };
    let mut panel = Panel::new(
        place,
        Axis::new("height x / d", 0.0, 200.0).with_numbers(6),
        Axis::new("Δr per sweep / d", 0.0, 0.8).with_numbers(9),
    )
    .with_legend(Corner::BottomRight);
    for mobility in measured {
        let temperature = mobility.state.temperature;
        let mut next = 0.0;
        let points = mobility.points.iter().filter(move |point| {
            let shown = point.height >= next && point.mean_displacement.standard_error < 0.02;
            if shown {
                next = point.height + if point.height < BULK_BEGINS { 0.4 } else { 1.4 };
            }
            shown
        });
        let points = points.map(|point| Point::of(point.height, point.mean_displacement));
        let exact = dilute(temperature);
        panel = panel
            .points(&format!("T₀ = {temperature}"), color_of(temperature), Mark::Points, points)
            .line("", color_of(temperature), Mark::Dashed, [(0.0, exact), (200.0, exact)]);
    }
    panel.line("dilute gas, exact", colors::INK, Mark::Dashed, [])
}

fn against_packing(measured: &[Mobility<'_>]) -> Panel {
    let place = Place { left: 0.5, top: 0.07, width: 0.5, height: 0.93 };
    let mut panel = Panel::new(
        place,
        Axis::new("packing fraction η of theory, x > 8 d", 0.0, 0.5).with_numbers(6),
        Axis::new("Δr per sweep / d", 0.0, 0.8).with_numbers(9),
    )
    .with_legend(Corner::TopRight);
    for mobility in measured {
        let temperature = mobility.state.temperature;
        let bulk = mobility
            .points
            .iter()
            .filter(|point| point.height > BULK_BEGINS && point.mean_displacement.standard_error < 0.02);
        let points = bulk.map(|point| {
            Point::of(mobility.state.theory.kolafa.packing_fraction(point.height), point.mean_displacement)
        });
        panel = panel.points(&format!("T₀ = {temperature}"), color_of(temperature), Mark::Dots, points);
    }
    panel
}

/// Mean length of accepted displacements where no sphere is in the way: over the cube of trials,
/// each with its acceptance min(1, exp(−Δx/T)).
fn dilute(temperature: f64) -> f64 {
    const POINTS: u32 = 60;
    let along = || {
        (0..POINTS)
            .map(|point| PAPER_DISPLACEMENT * ((2.0 * f64::from(point) + 1.0) / f64::from(POINTS) - 1.0))
    };
    let (mut lengths, mut accepted) = (0.0, 0.0);
    for x in along() {
        let acceptance = libm::exp(-x.max(0.0) / temperature);
        for y in along() {
            for z in along() {
                lengths += acceptance * libm::hypot(x, libm::hypot(y, z));
                accepted += acceptance;
            }
        }
    }
    lengths / accepted
}

/// Mean over a range of heights, weighted by how well the bins are known.
fn mean_over(mobility: &Mobility<'_>, inside: impl Fn(f64) -> bool) -> Estimate {
    let bins =
        mobility.points.iter().filter(|point| inside(point.height)).map(|point| point.mean_displacement);
    Estimate::weighted_mean_of_independent(bins.filter(|bin| bin.standard_error > 0.0))
}

fn claims(measured: &[Mobility<'_>], report: &mut Report) {
    /// Bins of an ideal gas, by their packing fraction.
    const IDEAL: f64 = 0.003;
    const NEAR: [f64; 2] = [BULK_BEGINS, BULK_BEGINS + 4.0];
    let verdicts = &mut report.verdicts;
    for mobility in measured {
        let (temperature, theory) = (mobility.state.temperature, &mobility.state.theory.kolafa);
        // Where spheres are counted at all, so that errors are known.
        let gas = mean_over(mobility, |height| {
            let packing_fraction = theory.packing_fraction(height);
            packing_fraction < IDEAL && packing_fraction > 0.1 * IDEAL
        });
        let exact = dilute(temperature);
        verdicts.between(
            "5",
            &format!(
                "Δr at the dilute top at T = {temperature}, within 4 errors and 1 % of {exact:.4}, which is exact without \
                collisions and without trials that leave their domain"
            ),
            gas,
            0.99 * exact - 4.0 * gas.standard_error,
            exact + 4.0 * gas.standard_error,
        );
        let base = mean_over(mobility, |height| (NEAR[0]..NEAR[1]).contains(&height));
        let ratio = base / exact;
        let claim =
            format!("Δr between {} and {} d over that of a dilute gas, T = {temperature}", NEAR[0], NEAR[1]);
        if temperature < 10.0 {
            verdicts.at_most("5", &format!("{claim}: strong decrease"), ratio, 0.5);
        } else {
            verdicts.at_least("5", &format!("{claim}: weak decrease"), ratio, 0.5);
        }
    }
    if let [cold, hot] = measured {
        verdicts.at_most(
            "5",
            "largest difference in Δr between both temperatures at the same packing fraction, in d",
            one_curve(cold, hot),
            0.02,
        );
    }
}

/// How far the two lie from one curve of the packing fraction: over groups of 0.02, outside the
/// layers.
fn one_curve(first: &Mobility<'_>, second: &Mobility<'_>) -> Estimate {
    let mut differences = Vec::new();
    for group in 1..25 {
        let range = 0.02 * f64::from(group)..0.02 * f64::from(group + 1);
        let [one, other] = [first, second].map(|mobility| {
            let theory = &mobility.state.theory.kolafa;
            mean_over(mobility, |height| {
                height > BULK_BEGINS && range.contains(&theory.packing_fraction(height))
            })
        });
        if one.mean.is_finite() && other.mean.is_finite() {
            differences.push(one.minus_independent(other));
        }
    }
    magnitude(farthest_from_zero(differences))
}
