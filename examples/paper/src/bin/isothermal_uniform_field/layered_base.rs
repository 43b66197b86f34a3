//! The layers at the base, which the paper leaves out: against density functional theory and the
//! contact theorem.

use super::layers::{Layer, of_theory};
use super::protocol::DRAWN;
use super::state::State;
use super::style::color_of;
use super::theory::Layers;
use gradient_mc::statistics::Estimate;
use paper::accuracy::root_mean_square;
use paper::figure::{Axis, Corner, Figure, Mark, Panel, Place, Point, colors};
use paper::functionals::independent_base;
use paper::groups::largest;
use paper::row;
use paper::{Failure, Report};

/// Up to this height.
const HIGHEST: f64 = 8.0;
/// White Bear II at T₀ = 15 and above: what it may be off in a bin of 0.1, as a fraction of n.
const FUNCTIONAL: f64 = 0.03;
/// Up to this temperature places and heights of layers are compared; those of hotter columns are
/// low and broad.
const COMPARED: f64 = 15.0;
/// Largest error of the place of a layer that says something, in diameters.
const LARGEST_ERROR: f64 = 0.02;
/// Of the functionals, in their order.
const COLORS: [paper::figure::RGBColor; 5] =
    [colors::GRAY, colors::SKY, colors::INK, colors::BROWN, colors::PURPLE];
/// The temperature of the independent simulation.
const INDEPENDENT: f64 = 5.0;

pub(crate) fn report(states: &[State<'_>], report: &mut Report) -> Result<(), Failure> {
    let drawn: Vec<&State<'_>> = states.iter().filter(|state| DRAWN.contains(&state.temperature)).collect();
    let mut figure =
        Figure::new("Layers at the base, against the White Bear II functional").with_size(1600, 800);
    for (column, state) in drawn.iter().enumerate() {
        figure = figure.panel(profile(state, column)).panel(deviation(state, column));
    }
    report.picture(
        "layered_base",
        &figure,
        "Above: number density near the base in bins of 0.1 d (points), the White Bear II functional (line) and the local theory \
         between walls (dashed). Below, with different scales: deviations of the simulation (points) and of the other functionals (lines, legend at T₀ = 30) from White Bear II.",
    )?;
    write_tables(states, report)?;
    claims(states, report)
}

fn place(column: usize, below: bool) -> Place {
    let left = column as f64 / 3.0;
    if below {
        Place { left, top: 0.63, width: 1.0 / 3.0, height: 0.37 }
    } else {
        Place { left, top: 0.06, width: 1.0 / 3.0, height: 0.57 }
    }
}

fn profile(state: &State<'_>, column: usize) -> Panel {
    let temperature = state.temperature;
    let bins = state.base.bins.iter().filter(|(height, _)| *height < HIGHEST);
    let highest = bins.clone().map(|(_, density)| density.mean).fold(0.0, f64::max);
    let top = libm::ceil(2.2 * highest) / 2.0;
    let theory = &state.theory;
    let local = (0..=80).map(|step| 0.1 * f64::from(step)).filter(|&height| height > theory.kolafa.base());
    let mut panel = Panel::new(
        place(column, false),
        Axis::new("height x / d", 0.0, HIGHEST).with_numbers(9),
        Axis::new("n d³", 0.0, top).with_numbers(6),
    )
    .with_title(&format!("T₀ = {temperature}"))
    .with_legend(Corner::TopRight);
    // All in the last picture, where they are one line and leave room for their names.
    let white_bear = paper::functionals::WHITE_BEAR_2;
    let shown = |&(number, _): &(usize, _)| column == 2 || number == white_bear;
    for (number, functional) in theory.functionals.iter().enumerate().filter(shown) {
        let line = functional.base.iter().copied().filter(|(height, _)| *height < HIGHEST);
        panel = panel.line(functional.name, COLORS[number], Mark::Line, line);
    }
    panel
        .line(
            "local theory between walls",
            colors::GRAY,
            Mark::Dashed,
            local.map(|height| (height, theory.kolafa.number_density(height))),
        )
        .points("simulation, bins of 0.1 d", color_of(temperature), Mark::Points, bins.map(density_point))
}

fn density_point((height, density): &(f64, Estimate)) -> Point {
    Point::of(*height, *density)
}

/// Simulation over functional, minus 1, with its error, for every common bin.
fn from_functional<'a>(
    state: &'a State<'_>,
    functional: &'a Layers,
) -> impl Iterator<Item = (f64, Estimate)> + 'a {
    let pairs = state.base.bins.iter().zip(&functional.base);
    pairs
        .filter(|((height, _), _)| *height < HIGHEST)
        .map(|((height, density), (_, functional))| (*height, *density / *functional - 1.0))
}

fn deviation(state: &State<'_>, column: usize) -> Panel {
    let white_bear = state.theory.white_bear();
    let points =
        from_functional(state, white_bear).map(|(height, deviation)| Point::percent(height, deviation));
    // Most of what the densest column shows is ten times as large.
    let most = if state.temperature < 10.0 { 40.0 } else { 8.0 };
    let mut panel = Panel::new(
        place(column, true),
        Axis::new("height x / d", 0.0, HIGHEST).with_numbers(9),
        Axis::new("n / n(White Bear II) − 1  (%)", -most, most).with_numbers(9),
    );
    for (functional, color) in state.theory.functionals.iter().zip(COLORS) {
        let ratios = functional.base.iter().zip(&white_bear.base);
        let line = ratios
            .filter(|((height, _), _)| *height < HIGHEST)
            .map(|((height, density), (_, known))| (*height, 100.0 * (density / known - 1.0)));
        panel = panel.line("", color, Mark::Line, line);
    }
    panel.points("", color_of(state.temperature), Mark::Points, points)
}

/// Root mean square over the bins of the deviation from a functional, and of its error.
fn root_mean_squares(state: &State<'_>, functional: &Layers) -> [f64; 2] {
    [|bin: Estimate| bin.mean, |bin: Estimate| bin.standard_error].map(|value: fn(Estimate) -> f64| {
        root_mean_square(from_functional(state, functional).map(|(_, deviation)| value(deviation)))
    })
}

fn write_tables(states: &[State<'_>], report: &Report) -> Result<(), Failure> {
    let bins = states.iter().flat_map(|state| {
        let functionals = &state.theory.functionals;
        state.base.bins.iter().enumerate().map(move |(bin, &(height, density))| {
            let mut row = row![state.temperature, height, density];
            row.extend(
                functionals
                    .iter()
                    .map(|functional| functional.base.get(bin).map_or(f64::NAN, |&(_, density)| density)),
            );
            row
        })
    });
    report.table(
        "layered_base",
        "temperature in m g d; height in d, middles of bins of 0.1; densities in 1/d^3; errors are one standard error",
        "temperature, height, number_density, number_density_error, rosenfeld, white_bear, white_bear_2, tarazona, lutsko_stable",
        bins,
    )?;
    let peaks = states.iter().flat_map(|state| {
        let contact = state.base.contact_density;
        let wall =
            row![state.temperature, 1.0, 0.5, 0.0, contact, f64::NAN, f64::NAN, state.contact_density(),];
        let (_, functional) = of_theory(&state.theory.white_bear().base);
        let layers = state.base.layers.iter().enumerate().map(move |(number, layer)| {
            let (_, height) = functional.get(number).copied().unwrap_or((f64::NAN, f64::NAN));
            row![
                state.temperature,
                number as f64 + 2.0,
                layer.position,
                layer.height,
                layer.binned_height,
                height,
            ]
        });
        std::iter::once(wall).chain(layers).collect::<Vec<_>>()
    });
    report.table(
        "layered_base_peaks",
        "temperature in m g d; positions in d; densities in 1/d^3; layer 1 is the contact with the wall, where the reference is the \
         contact theorem; of the others it is the mean over 0.1 d by White Bear II, to be compared with binned_height; errors are \
         one standard error",
        "temperature, layer, position, position_error, height, height_error, binned_height, \
         binned_height_error, reference",
        peaks,
    )
}

fn claims(states: &[State<'_>], report: &mut Report) -> Result<(), Failure> {
    for state in states {
        let (temperature, exact) = (state.temperature, state.contact_density());
        report.verdicts.agrees(
            "base",
            &format!("contact density n(0.5+) at T = {temperature}, exactly {exact:.4}"),
            state.base.contact_density,
            (exact, 4.0),
            0.015 * exact,
        );
        for (number, layer) in state.base.layers.iter().enumerate() {
            let Layer { position, height, .. } = layer;
            println!("T = {temperature:2}, layer {}: n = {height} at x = {position}", number + 2);
        }
        two_routes(state, report);
        if temperature == INDEPENDENT {
            independently(state, report)?;
        }
        for functional in &state.theory.functionals {
            let [deviation, noise] = root_mean_squares(state, functional);
            let largest = from_functional(state, functional)
                .max_by(|(_, one), (_, other)| one.mean.abs().total_cmp(&other.mean.abs()));
            if let Some((height, largest)) = largest {
                println!(
                    "T = {temperature:2}, {}: rms deviation {:.2} %, of which noise {:.2}; largest {} % at x = {height:.2}",
                    functional.name,
                    100.0 * deviation,
                    100.0 * noise,
                    100.0 * largest
                );
            }
        }
        against_functional(state, report);
    }
    Ok(())
}

/// The base at T₀ = 5 by a program that has nothing in common with this library.
fn independently(state: &State<'_>, report: &mut Report) -> Result<(), Failure> {
    let differences = state.base.bins.iter().zip(independent_base()?).map(|((_, density), other)| {
        let difference = density.minus_independent(other);
        (difference.mean / difference.standard_error).abs()
    });
    report.verdicts.at_most(
        "base",
        &format!(
            "largest difference between n(x) in bins of 0.1 and an independent program, in standard errors, T = {}",
            state.temperature
        ),
        Estimate::exact(largest(differences)),
        4.5,
    );
    Ok(())
}

/// The base by two families of moves.
fn two_routes(state: &State<'_>, report: &mut Report) {
    let differences = state.base.bins.iter().zip(&state.base_by_own_moves).map(|((_, local), own)| {
        let difference = local.minus_independent(*own);
        (difference.mean / difference.standard_error).abs()
    });
    // The largest of 80 differences of equal numbers is above 4 errors once in 200 cases.
    report.verdicts.at_most(
        "base",
        &format!(
            "largest difference between n(x) in bins of 0.1 by small local moves and by {}, in standard errors, T = {}",
            state.columns.first().map_or("", |column| column.task.family.name()),
            state.temperature
        ),
        Estimate::exact(largest(differences)),
        4.5,
    );
}

/// Profile and peaks against White Bear II.
///
/// At T₀ = 15 (packing fraction 0.32) it is good to some per cent. At T₀ = 5 (0.45) the simulation
/// has sharper layers, the second 0.04 d lower: an independent program agrees with the simulation
/// (`docs/results/uniform_field.md`), and molecular dynamics found significant deviations of
/// functionals of this kind at high densities (doi:10.5488/CMP.19.23001).
fn against_functional(state: &State<'_>, report: &mut Report) {
    let (temperature, verdicts) = (state.temperature, &mut report.verdicts);
    let white_bear = state.theory.white_bear();
    let [deviation, noise] = root_mean_squares(state, white_bear);
    let deviation = Estimate::exact(deviation);
    let claim = format!(
        "rms of n/n(White Bear II) − 1 at T = {temperature} in bins of 0.1, x < {HIGHEST}, of which noise {noise:.4}"
    );
    if temperature < 10.0 {
        verdicts.at_least(
            "base",
            &format!("{claim}: the functional is inaccurate here"),
            deviation,
            3.0 * noise,
        );
    } else {
        verdicts.at_most("base", &claim, deviation, 0.02);
        let beyond = from_functional(state, white_bear)
            .map(|(_, bin)| (bin.mean.abs() - FUNCTIONAL) / bin.standard_error);
        verdicts.at_most(
            "base",
            &format!("the largest of these at T = {temperature} minus {FUNCTIONAL}, in standard errors"),
            Estimate::exact(largest(beyond)),
            3.0,
        );
    }
    if temperature > COMPARED {
        return;
    }
    let (_, functional) = of_theory(&white_bear.base);
    for (number, (layer, (position, height))) in state.base.layers.iter().zip(functional).enumerate() {
        let name = format!("layer {} at T = {temperature}, by bins of 0.1", number + 2);
        let reach = if temperature < 10.0 { 0.06 } else { 0.03 };
        let error = layer.binned_position.standard_error;
        // One that is not known would say nothing.
        let allowed = if error <= LARGEST_ERROR { reach + 4.0 * error } else { f64::NAN };
        verdicts.between(
            "base",
            &format!(
                "{name}: position of its peak, within {reach} and four errors of White Bear II, {position:.3}"
            ),
            layer.binned_position,
            position - allowed,
            position + allowed,
        );
        if temperature > 10.0 {
            verdicts.between(
                "base",
                &format!("{name}: largest n, White Bear II {height:.4}"),
                layer.binned_height,
                (1.0 - FUNCTIONAL) * height,
                (1.0 + FUNCTIONAL) * height,
            );
        }
    }
}
