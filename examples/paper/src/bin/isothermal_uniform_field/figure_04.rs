//! Figure 4: the layers at the base; inset: the lateral radial distribution of the first.

use super::layers::of_theory;
use super::protocol::DRAWN;
use super::state::State;
use super::style::{WHOLE, color_of};
use gradient_mc::observers::{Layer, RadialDistributionPoint};
use gradient_mc::statistics::Estimate;
use paper::figure::{Axis, Figure, Mark, Panel, Place, Point, colors};
use paper::groups::{farthest_from_zero, magnitude};
use paper::row;
use paper::{Failure, Report};

/// The temperature at which the paper counts five layers, and of which it shows g(r).
const DENSEST: f64 = 5.0;
/// The temperature at which layers are counted against White Bear II; hotter columns have few, at
/// the limit of what is clear.
const COUNTED: f64 = 15.0;
/// Beyond this distance a liquid has forgotten the sphere at the middle.
const FAR: f64 = 4.0;

pub(crate) fn report(states: &[State<'_>], report: &mut Report) -> Result<(), Failure> {
    let drawn: Vec<&State<'_>> = states.iter().filter(|state| DRAWN.contains(&state.temperature)).collect();
    let densest = states.first().ok_or("no column")?;
    let radial = densest.first_layer.points()?;
    let figure = Figure::new("Figure 4: layers at the base")
        .panel(layers(&drawn))
        .panel(inset(densest.temperature, &radial));
    report.picture(
        "figure_04",
        &figure,
        "Number density near the base in bins of 0.1 d (points), and the functionals White Bear II (lines) and that of Lutsko which \
         is stable (dashed) in the same bins; the others are in the picture of the layered base. Five clear layers \
         at T₀ = 5, fewer at higher temperatures. Inset: lateral radial distribution function of the spheres in the lowest bin at T₀ = 5, \
         as in a liquid.",
    )?;
    write_tables(states, densest.temperature, &radial, report)?;
    claims(states, densest.temperature, &radial, report);
    Ok(())
}

fn layers(states: &[&State<'_>]) -> Panel {
    let mut panel = Panel::new(
        WHOLE,
        Axis::new("height x / d", 0.0, 8.0).with_numbers(9),
        Axis::new("n d³", 0.0, 5.0).with_numbers(6),
    );
    for (row, state) in states.iter().enumerate() {
        let (temperature, color) = (state.temperature, color_of(state.temperature));
        let bins = &state.base.bins;
        let points = bins.iter().map(|&(height, density)| Point::of(height, density));
        panel = panel
            .note(1.2, 4.6 - 0.3 * row as f64, &format!("T₀ = {temperature}"), color)
            .points("", color, Mark::Points, points)
            .line("", color, Mark::Line, state.theory.white_bear().base.iter().copied());
        if let Some(stable) = state.theory.functionals.last() {
            panel = panel.line("", color, Mark::Dashed, stable.base.iter().copied());
        }
    }
    let functionals = "lines: White Bear II; dashed: Lutsko, stable";
    panel.note(1.75, 3.4, functionals, colors::INK)
}

/// The temperature is 5, unless the command line leaves that out.
fn inset(temperature: f64, radial: &[RadialDistributionPoint]) -> Panel {
    let place = Place { left: 0.42, top: 0.09, width: 0.56, height: 0.5 };
    let end = radial.last().map_or(6.0, |point| libm::ceil(point.distance));
    let points = radial.iter().map(|point| Point::of(point.distance, point.radial_distribution));
    Panel::new(
        place,
        Axis::new(&format!("lateral distance r / d, first layer at T₀ = {temperature}"), 0.0, end)
            .with_numbers(7),
        Axis::new("g(r)", 0.0, 5.0).with_numbers(6),
    )
    .inset()
    .line("", colors::GRAY, Mark::Dashed, [(0.0, 1.0), (end, 1.0)])
    .line(
        "",
        color_of(temperature),
        Mark::Line,
        radial.iter().map(|point| (point.distance, point.radial_distribution.mean)),
    )
    .points("", color_of(temperature), Mark::Dots, points)
}

fn write_tables(
    states: &[State<'_>],
    temperature: f64,
    radial: &[RadialDistributionPoint],
    report: &Report,
) -> Result<(), Failure> {
    let rows = states.iter().flat_map(|state| {
        state.base.bins.iter().map(|&(height, density)| row![state.temperature, height, density])
    });
    report.table(
        "figure_04",
        "temperature in m g d; height in d, middles of bins of 0.1; density in 1/d^3; errors are one standard error",
        "temperature, height, number_density, number_density_error",
        rows,
    )?;
    report.table(
        "figure_04_inset",
        &format!("lateral distance in d, of spheres between 0.5 and 0.6 at T = {temperature}; errors are one standard error"),
        "distance, radial_distribution, radial_distribution_error",
        radial.iter().map(|point| {
            row![point.distance, point.radial_distribution]
        }),
    )
}

fn claims(states: &[State<'_>], densest: f64, radial: &[RadialDistributionPoint], report: &mut Report) {
    let verdicts = &mut report.verdicts;
    let count = |state: &State<'_>| Estimate::exact(state.base.clear_layers as f64);
    for state in states {
        let temperature = state.temperature;
        let claim =
            format!("clear layers at T = {temperature}, separated by minima of visibility {}", Layer::CLEAR);
        if temperature == DENSEST {
            // The paper's eye sees five; the simulation's sixth is just above this visibility, the
            // functional's just below.
            verdicts.between("4", &format!("{claim}; five in the paper"), count(state), 5.0, 6.0);
        } else if temperature > COUNTED {
            // Fewer than in the column before, which is colder.
            let colder = states.iter().rev().find(|colder| colder.temperature < temperature);
            let most = colder.map_or(5.0, |colder| colder.base.clear_layers as f64);
            verdicts.at_most("4", &format!("{claim}; no more than in the colder column"), count(state), most);
        } else {
            let (expected, _) = of_theory(&state.theory.white_bear().base);
            let expected = expected as f64;
            verdicts.between(
                "4",
                &format!("{claim}; as White Bear II has"),
                count(state),
                expected,
                expected,
            );
        }
    }
    let nan = Estimate::new(f64::NAN, f64::NAN);
    let first = radial
        .iter()
        .max_by(|first, second| first.radial_distribution.mean.total_cmp(&second.radial_distribution.mean));
    let position = first.map_or(nan, |point| Estimate::exact(point.distance));
    verdicts.between(
        "4 inset",
        &format!("highest peak of g(r) of the first layer at T = {densest}, in d"),
        position,
        1.0,
        1.15,
    );
    let far = radial.iter().filter(|point| point.distance > FAR).map(|point| point.radial_distribution - 1.0);
    verdicts.at_most(
        "4 inset",
        &format!("largest |g − 1| beyond {FAR} d: no long-range order"),
        magnitude(farthest_from_zero(far)),
        0.1,
    );
}
