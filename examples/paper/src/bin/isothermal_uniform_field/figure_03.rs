//! Figure 3: the density profile of the whole column, with theory; on a logarithmic scale, with the
//! ideal gas.

use super::protocol::{DRAWN, HEIGHT};
use super::state::State;
use super::style::{WHOLE, color_of};
use gradient_mc::statistics::Estimate;
use paper::figure::{Axis, Corner, Figure, Mark, Panel, Point, colors};
use paper::groups::{edges_of_equal_numbers, farthest_from_zero, magnitude, means_over, ranges_between};
use paper::row;
use paper::{Failure, Report};

/// Below this height there are layers, which the local theory does not describe.
pub(crate) const BULK_BEGINS: f64 = 8.0;
/// Where the theory's packing fraction falls below this, the paper's figure 3a has left the axis.
const DILUTE: f64 = 0.01;
/// Below this packing fraction an ideal gas is within one per cent.
const IDEAL: f64 = 0.001;
/// Down to this packing fraction the paper's eq. (27) is judged, as its figure 3a can show it. It
/// knows no wall, so its columns are 0.15 to 0.25 d too low, which at T₀ = 5 is 3 % of n in the
/// dilute top.
const DENSE: f64 = 0.1;
/// Ranges of heights with equally many spheres in which densities are compared.
const GROUPS: usize = 12;

pub(crate) fn report(states: &[State<'_>], report: &mut Report) -> Result<(), Failure> {
    let drawn = || states.iter().filter(|state| DRAWN.contains(&state.temperature));
    report.picture(
        "figure_03a",
        &Figure::new("Figure 3a: number density against height at steady state").panel(linear(drawn())?),
        "Number density against height for three temperatures; lines are hydrostatics between walls with the modified \
         Kolafa-Labík-Malijevský equation. Some of the bins of 0.5 d are drawn; the layers at the base are in figure 4.",
    )?;
    report.picture(
        "figure_03b",
        &Figure::new("Figure 3b: number density against height, logarithmic").panel(logarithmic(drawn())?),
        "The same on a logarithmic scale. Full lines: the ideal gas of the same chemical potential, \
        the limit at the dilute top. Dashed: the theory of figure 3a.",
    )?;
    let mut rows = Vec::new();
    for state in states {
        for point in state.profile.points()? {
            rows.push(row![
                state.temperature,
                point.height,
                point.number_density,
                state.theory.kolafa.number_density(point.height),
                state.theory.paper.number_density(point.height),
                state.theory.ideal_gas(state.temperature, point.height),
            ]);
        }
    }
    for name in ["figure_03a", "figure_03b"] {
        report.table(
            name,
            "temperature in m g d; height in d; densities in 1/d^3, means over bins of 0.5 d; errors are one standard error; theory: \
             hydrostatics between walls, modified Kolafa-Labik-Malijevsky equation; equation_27: the paper's, Carnahan-Starling \
             from x = 0; ideal gas of the theory's chemical potential",
            "temperature, height, number_density, number_density_error, theory, equation_27, \
             ideal_gas",
            &rows,
        )?;
    }
    for state in states {
        bulk(state, report)?;
        top(state, report)?;
    }
    Ok(())
}

fn linear<'a>(states: impl Iterator<Item = &'a State<'a>>) -> Result<Panel, Failure> {
    let mut panel = Panel::new(
        WHOLE,
        Axis::new("height x / d", 0.0, 200.0).with_numbers(11),
        Axis::new("n d³", 0.0, 1.0).with_numbers(6),
    )
    .with_legend(Corner::TopRight);
    for state in states {
        let (temperature, theory) = (state.temperature, &state.theory.kolafa);
        let line = (0..=2000)
            .map(|step| 0.1 * f64::from(step))
            .filter(|&height| height >= theory.base())
            .map(|height| (height, theory.number_density(height)));
        let mut next = 0.0;
        let points: Vec<Point> = state
            .profile
            .points()?
            .iter()
            .filter(|point| {
                // All bins of the layers; further up they would run into each other.
                let shown = point.height >= next;
                if shown {
                    next = point.height + if point.height < BULK_BEGINS { 0.4 } else { 1.9 };
                }
                shown
            })
            .map(|point| Point::of(point.height, point.number_density))
            .collect();
        panel = panel
            .points(&format!("T₀ = {temperature}, simulation"), color_of(temperature), Mark::Points, points)
            .line("", color_of(temperature), Mark::Line, line);
    }
    Ok(panel.line("hydrostatics between walls", colors::INK, Mark::Line, []))
}

fn logarithmic<'a>(states: impl Iterator<Item = &'a State<'a>>) -> Result<Panel, Failure> {
    let mut panel = Panel::new(
        WHOLE,
        Axis::new("height x / d", 0.0, HEIGHT).with_numbers(9),
        Axis::logarithmic("n d³", 1e-6, 10.0),
    )
    .with_legend(Corner::TopRight);
    for state in states {
        let (temperature, theory) = (state.temperature, &state.theory.kolafa);
        let heights = || (0..=400).map(f64::from);
        let ideal = heights().map(|height| (height, state.theory.ideal_gas(temperature, height)));
        let line = heights()
            .filter(|&height| (theory.base()..theory.top()).contains(&height))
            .map(|height| (height, theory.number_density(height)));
        // Wider bins where there is hardly a sphere.
        let points = grouped(state, 4.0)?;
        panel = panel
            .points(&format!("T₀ = {temperature}, simulation"), color_of(temperature), Mark::Points, points)
            .line("", color_of(temperature), Mark::Line, ideal)
            .line("", color_of(temperature), Mark::Dashed, line);
    }
    Ok(panel.line("ideal gas", colors::INK, Mark::Line, []).line(
        "hydrostatics between walls",
        colors::INK,
        Mark::Dashed,
        [],
    ))
}

/// Densities over wider bins.
fn grouped(state: &State<'_>, width: f64) -> Result<Vec<Point>, Failure> {
    let edges: Vec<f64> =
        (0..400).map(|bin| 0.5 + width * f64::from(bin)).take_while(|&x| x < HEIGHT).collect();
    let ranges = ranges_between(&edges);
    let means = state.profile.jackknife(|states| means_over(states, &ranges, |bin| bin.number_density))?;
    let points = ranges.iter().zip(means).filter(|(_, mean)| mean.mean > 0.0);
    Ok(points.map(|([low, high], mean)| Point::of(f64::midpoint(*low, *high), mean)).collect())
}

/// Deviation of densities from a theory over ranges of heights, as fractions.
fn deviations(
    state: &State<'_>,
    ranges: &[[f64; 2]],
    theory: impl Fn(f64) -> f64,
) -> Result<Vec<Estimate>, Failure> {
    Ok(state.profile.jackknife(|bins| {
        let over = |&[low, high]: &[f64; 2]| {
            let bins = bins.iter().filter(|bin| (low..high).contains(&bin.height));
            let (measured, expected) = bins.fold((0.0, 0.0), |(measured, expected), bin| {
                (measured + bin.number_density, expected + theory(bin.height))
            });
            measured / expected - 1.0
        };
        ranges.iter().map(over).collect::<Vec<f64>>()
    })?)
}

/// The density outside the layers and the dilute top against theory.
fn bulk(state: &State<'_>, report: &mut Report) -> Result<(), Failure> {
    let theory = &state.theory.kolafa;
    for (name, largest_allowed, lowest_packing, profile) in [
        ("theory between walls", 0.01, DILUTE, theory),
        ("eq. (27) of the paper, without walls", 0.02, DENSE, &state.theory.paper),
    ] {
        let highest = height_of(state, lowest_packing);
        let ranges = ranges_between(&edges_of_equal_numbers(theory, [BULK_BEGINS, highest], GROUPS));
        let found = deviations(state, &ranges, |height| profile.number_density(height))?;
        let largest = magnitude(farthest_from_zero(found));
        report.verdicts.at_most(
            "3a",
            &format!(
                "largest |n/n(theory) − 1| at T = {} in {GROUPS} groups of heights from {BULK_BEGINS} to {highest:.0}, {name}",
                state.temperature
            ),
            largest,
            largest_allowed,
        );
    }
    Ok(())
}

/// Where the theory's packing fraction falls below a value.
pub(crate) fn height_of(state: &State<'_>, packing_fraction: f64) -> f64 {
    let theory = &state.theory.kolafa;
    let mut height = BULK_BEGINS;
    while theory.packing_fraction(height) > packing_fraction && height < HEIGHT - 1.0 {
        height += 0.5;
    }
    height
}

/// The ideal gas at the top, and that it begins with the chemical potential, not with the density
/// of the base.
fn top(state: &State<'_>, report: &mut Report) -> Result<(), Failure> {
    let temperature = state.temperature;
    let low = height_of(state, IDEAL);
    let range = [[low, HEIGHT]];
    let gas = deviations(state, &range, |height| state.theory.ideal_gas(temperature, height))?;
    report.verdicts.agrees(
        "3b",
        &format!("n over the ideal gas of the same chemical potential at T = {temperature}, x > {low:.0}"),
        1.0 + gas[0],
        (1.0, 4.0),
        0.08,
    );
    let base = state.theory.paper.number_density(0.0);
    let wrong = deviations(state, &range, |height| base * libm::exp(-height / temperature))?;
    report.verdicts.at_least(
        "3b",
        &format!("the same for an ideal gas with the density at the base as prefactor, T = {temperature}: wrong by a factor"),
        1.0 + wrong[0],
        2.0,
    );
    let uppermost = [[HEIGHT - 20.5, HEIGHT - 0.5]];
    let lid = state.profile.jackknife(|bins| means_over(bins, &uppermost, |bin| bin.number_density))?;
    report.verdicts.at_most(
        "3b",
        &format!("density in the uppermost 20 d at T = {temperature}; at most 1e-4 in the paper"),
        lid[0],
        1e-4,
    );
    Ok(())
}
