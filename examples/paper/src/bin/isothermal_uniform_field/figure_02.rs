//! Figure 2: the center of mass falls to its plateau; inset: plateau against temperature.

use super::column::Column;
use super::protocol::{DRAWN, Family, Protocol, TEMPERATURES};
use super::state::State;
use super::steadiness::steady_from;
use super::style::color_of;
use super::theory::{accuracy, between_walls};
use gradient_mc::equation_of_state::ModifiedKolafa;
use gradient_mc::observers::CenterOfMass;
use gradient_mc::statistics::Estimate;
use paper::figure::{Axis, Corner, Figure, Mark, Panel, Place, Point, colors};
use paper::row;
use paper::{Failure, Report, Side};

/// The axes end above the start at 200, to leave room.
const HIGHEST: f64 = 300.0;
/// Largest acceptable error bar of a plateau, by faster moves and by those of the paper.
const LARGEST_ERROR: f64 = 0.02;
const LARGEST_ERROR_OF_PAPER: f64 = 0.2;

pub(crate) fn report(
    states: &[State<'_>],
    steady: &[Column],
    falling: &[Column],
    report: &mut Report,
) -> Result<(), Failure> {
    // With the paper's protocol the columns that are measured fell by its moves.
    let falling: Vec<&Column> = if falling.is_empty() {
        steady.iter().filter(|column| DRAWN.contains(&column.task.temperature)).collect()
    } else {
        falling.iter().collect()
    };
    let ours: Vec<&Column> = steady
        .iter()
        .filter(|column| DRAWN.contains(&column.task.temperature) && column.task.width == widest(steady))
        .collect();
    let figure = Figure::new("Figure 2: relaxation of the center of mass to its plateau, N/A = 40, H = 400")
        .panel(linear(&falling, states))
        .panel(inset(states)?)
        .panel(logarithmic(&falling, &ours, states));
    report.picture(
        "figure_02",
        &figure,
        "Height of the center of mass against Monte Carlo sweeps. Left, as in the paper: local moves, S = 0.75, from a random \
        gas; lines are the plateaus of the theory between walls. Inset: plateau against temperature, with the theory, and at \
        each point the slope computed from the fluctuations of h_c. Right: the same on a logarithmic scale, with tuned local moves or \
        event chains from a random gas and from a crystal on the base; all reach the same plateau.",
    )?;
    write_tables(states, &falling, &ours, report)?;
    plateaus(states, report)?;
    slopes(states, report);
    paper_moves(states, &falling, report);
    relaxation(steady, report);
    Ok(())
}

fn widest(columns: &[Column]) -> f64 {
    columns.iter().map(|column| column.task.width).fold(0.0, f64::max)
}

/// Means of the series over intervals whose ends are given by `next`.
fn thinned(series: &CenterOfMass, next: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
    let mut points = Vec::new();
    let mut end = next(0.0);
    let (mut sweeps, mut heights, mut count) = (0.0, 0.0, 0.0);
    for (&sweep, &height) in series.sweeps().iter().zip(series.heights()) {
        let sweep = sweep as f64;
        if sweep > end && count > 0.0 {
            points.push((sweeps / count, heights / count));
            (sweeps, heights, count) = (0.0, 0.0, 0.0);
            end = next(sweep);
        }
        sweeps += sweep;
        heights += height;
        count += 1.0;
    }
    if count > 0.0 {
        points.push((sweeps / count, heights / count));
    }
    points
}

fn last_sweep(columns: &[&Column]) -> f64 {
    let last = columns.iter().filter_map(|column| column.center_of_mass.sweeps().last());
    last.max().map_or(1.0, |&sweep| sweep as f64)
}

fn dots(points: Vec<(f64, f64)>) -> impl Iterator<Item = Point> {
    points.into_iter().map(|(x, y)| Point { x, y, error: 0.0 })
}

/// The paper's picture.
fn linear(falling: &[&Column], states: &[State<'_>]) -> Panel {
    let place = Place { left: 0.0, top: 0.07, width: 0.5, height: 0.93 };
    let end = last_sweep(falling) / 1000.0;
    let mut panel = Panel::new(
        place,
        Axis::new("sweeps t / 1000, moves of the paper", 0.0, end),
        Axis::new("h_c / d", 0.0, HIGHEST).with_numbers(8),
    );
    for state in states.iter().filter(|state| DRAWN.contains(&state.temperature)) {
        let plateau = state.theory.kolafa.center_of_mass();
        panel = panel.line("", color_of(state.temperature), Mark::Dashed, [(0.0, plateau), (end, plateau)]);
    }
    for column in falling {
        let points = thinned(&column.center_of_mass, |sweep| sweep + 10.0 * end);
        let points = points.into_iter().map(|(sweep, height)| (sweep / 1000.0, height)).collect();
        panel = panel.points("", color_of(column.task.temperature), Mark::Dots, dots(points));
    }
    panel
}

fn inset(states: &[State<'_>]) -> Result<Panel, Failure> {
    let place = Place { left: 0.225, top: 0.09, width: 0.265, height: 0.44 };
    let theory = (8..=64)
        .map(|half| {
            let temperature = 0.5 * f64::from(half);
            Ok((temperature, between_walls(temperature, ModifiedKolafa)?.center_of_mass()))
        })
        .collect::<Result<Vec<_>, Failure>>()?;
    let mut panel = Panel::new(
        place,
        Axis::new("T₀ / mgd", 0.0, 35.0).with_numbers(7),
        Axis::new("plateau h_c / d", 0.0, 75.0).with_numbers(5),
    )
    .inset()
    .with_legend(Corner::TopLeft)
    .line("theory", colors::GRAY, Mark::Line, theory);
    for (number, state) in states.iter().enumerate() {
        let (temperature, reach) = (state.temperature, 3.5);
        let tangent = [-reach, reach]
            .map(|step| (temperature + step, state.center_of_mass.mean + step * state.response.mean));
        let label = if number == 0 { "slope from fluctuations" } else { "" };
        panel = panel.line(label, colors::VERMILION, Mark::Dashed, tangent);
    }
    let points = states.iter().map(|state| Point::of(state.temperature, state.center_of_mass));
    Ok(panel.points("simulation", colors::INK, Mark::Points, points))
}

fn logarithmic(falling: &[&Column], ours: &[&Column], states: &[State<'_>]) -> Panel {
    let place = Place { left: 0.5, top: 0.07, width: 0.5, height: 0.93 };
    let end = libm::pow(10.0, libm::ceil(libm::log10(last_sweep(falling))));
    let mut panel = Panel::new(
        place,
        Axis::logarithmic("sweeps t", 10.0, end),
        Axis::new("h_c / d", 0.0, HIGHEST).with_numbers(8),
    )
    .with_legend(Corner::TopRight);
    for state in states.iter().filter(|state| DRAWN.contains(&state.temperature)) {
        let plateau = state.theory.kolafa.center_of_mass();
        panel = panel.line("", color_of(state.temperature), Mark::Dashed, [(10.0, plateau), (end, plateau)]);
    }
    let grown = |sweep: f64| f64::max(1.25 * sweep, 10.0);
    for column in falling {
        let temperature = column.task.temperature;
        panel = panel.points(
            &format!("T₀ = {temperature}, moves of the paper"),
            color_of(temperature),
            Mark::Dots,
            dots(thinned(&column.center_of_mass, grown)),
        );
    }
    for column in ours.iter().filter(|column| column.task.family != Family::Paper) {
        let temperature = column.task.temperature;
        let label = if column.task.side == Side::Above {
            format!("T₀ = {temperature}, {}, from both sides", column.task.family.name())
        } else {
            String::new()
        };
        let points = dots(thinned(&column.center_of_mass, grown));
        panel = panel.points(&label, color_of(temperature), Mark::Rings, points);
    }
    panel
}

fn write_tables(
    states: &[State<'_>],
    falling: &[&Column],
    ours: &[&Column],
    report: &Report,
) -> Result<(), Failure> {
    let rows = falling.iter().chain(ours).flat_map(|column| {
        let task = column.task;
        let by_paper = f64::from(u8::from(task.family == Family::Paper));
        let from_above = f64::from(u8::from(task.side == Side::Above));
        let points = thinned(&column.center_of_mass, |sweep| f64::max(1.1 * sweep, 5.0));
        points
            .into_iter()
            .map(move |(sweep, height)| [task.temperature, task.width, by_paper, from_above, sweep, height])
    });
    report.table(
        "figure_02",
        "temperature in m g d; width of the base and height in d; paper_moves: 1 for the moves of the paper, 0 for others; from_above: 1 for \
        the random start, 0 for the close-packed one; means over intervals of sweeps",
        "temperature, base_width, paper_moves, from_above, sweep, center_of_mass",
        rows,
    )?;
    report.table(
        "figure_02_inset",
        "temperature in m g d, heights in d; errors are one standard error; theory is that between walls with the modified \
         Kolafa-Labik-Malijevsky equation; slope is N Var(h_c)/T^2",
        "temperature, center_of_mass, center_of_mass_error, center_of_mass_theory, \
         center_of_mass_white_bear, slope, slope_error, slope_theory",
        states.iter().map(|state| {
            row![
                state.temperature,
                state.center_of_mass,
                state.theory.kolafa.center_of_mass(),
                state.theory.white_bear().center_of_mass,
                state.response,
                state.theory.slope,
            ]
        }),
    )
}

/// The plateaus against theory, from both sides, and over both bases.
fn plateaus(states: &[State<'_>], report: &mut Report) -> Result<(), Failure> {
    let accuracy = accuracy()?;
    let by_paper = |column: &&Column| column.task.family == Family::Paper;
    let all_by_paper = states.iter().flat_map(|state| &state.columns).all(by_paper);
    let largest_error = if all_by_paper { LARGEST_ERROR_OF_PAPER } else { LARGEST_ERROR };
    let verdicts = &mut report.verdicts;
    for state in states {
        let (temperature, measured) = (state.temperature, state.center_of_mass);
        let error = Estimate::exact(measured.standard_error);
        verdicts.at_most(
            "2",
            &format!("error of the plateau h_c at T = {temperature}"),
            error,
            largest_error,
        );
        // Four standard errors, and the uncertainty of the theory.
        let reach = 4.0 * measured.standard_error + accuracy;
        let mut near = |claim: &str, expected: f64| {
            verdicts.between(
                "2",
                &format!(
                    "plateau h_c at T = {temperature}, within 4 errors and {accuracy:.3} of {expected:.3}, {claim}"
                ),
                measured,
                expected - reach,
                expected + reach,
            );
        };
        near("theory between walls", state.theory.kolafa.center_of_mass());
        near(
            "White Bear II, corrected for the error of the Carnahan-Starling equation",
            state.theory.corrected_white_bear(),
        );
        if let (Some(above), Some(below)) = (state.from(Side::Above), state.from(Side::Below)) {
            verdicts.agrees(
                "2",
                &format!("h_c at T = {temperature} from above, {above}, minus from below, {below}"),
                above.minus_independent(below),
                (0.0, 4.0),
                3.0 * largest_error,
            );
        }
        let [wide, narrow] = Protocol::WIDTHS;
        if let (Some(over_wide), Some(over_narrow)) = (state.over(wide), state.over(narrow)) {
            verdicts.agrees(
                "2",
                &format!("h_c at T = {temperature} over {narrow} x {narrow}, {over_narrow}, minus over {wide} x {wide}, {over_wide}"),
                over_narrow.minus_independent(over_wide),
                (0.0, 4.0),
                3.0 * largest_error,
            );
        }
    }
    Ok(())
}

/// The inset: its slope, from fluctuations at one temperature and from two temperatures.
fn slopes(states: &[State<'_>], report: &mut Report) {
    for state in states {
        let temperature = state.temperature;
        report.verdicts.agrees(
            "2 inset",
            &format!(
                "slope dh_c/dT at T = {temperature} from the fluctuations of h_c, theory {:.3}",
                state.theory.slope
            ),
            state.response,
            (state.theory.slope, 4.0),
            0.16 * state.theory.slope,
        );
    }
    for pair in states.windows(2) {
        let step = pair[1].temperature - pair[0].temperature;
        let rise = pair[1].center_of_mass.minus_independent(pair[0].center_of_mass);
        let expected =
            (pair[1].theory.kolafa.center_of_mass() - pair[0].theory.kolafa.center_of_mass()) / step;
        report.verdicts.agrees(
            "2 inset",
            &format!(
                "mean slope from T = {} to {}, theory {expected:.4}",
                pair[0].temperature, pair[1].temperature
            ),
            rise / step,
            (expected, 4.0),
            0.01,
        );
    }
}

/// Claims that the moves of the paper reach the same plateau, and after how many sweeps.
///
/// A run of one column holds few independent heights, too few for an error bar of its own: the
/// plateau, over the last third of the sweeps, is compared in units of the standard deviation of
/// `h_c` in equilibrium, which the response gives exactly. The mean of a third scatters by about
/// half of that.
fn paper_moves(states: &[State<'_>], falling: &[&Column], report: &mut Report) {
    for column in falling {
        let temperature = column.task.temperature;
        let Some(state) = states.iter().find(|state| state.temperature == temperature) else { continue };
        let simulated = state.columns.iter().any(|column| column.task.family != Family::Paper);
        let (plateau, whose) = if simulated {
            (state.center_of_mass.mean, format!("that by faster moves, {}", state.center_of_mass))
        } else {
            // With the paper's protocol there is no other simulation.
            let theory = state.theory.kolafa.center_of_mass();
            (theory, format!("that of the theory between walls, {theory:.3}"))
        };
        let deviation = temperature * libm::sqrt(state.theory.slope / column.task.particles() as f64);
        let steady = steady_from(&column.center_of_mass)
            .map_or("not before the second half".into(), |sweep| format!("from sweep {sweep} on"));
        println!("T = {temperature:2}, moves of the paper: steady {steady}; {:.1} CPU s", column.busy);
        let smooth = thinned(&column.center_of_mass, |sweep| f64::max(1.02 * sweep, 100.0));
        let arrival = smooth.iter().find(|(_, height)| *height < plateau + deviation);
        report.verdicts.at_most(
            "2",
            &format!(
                "sweeps of the moves of the paper until h_c at T = {temperature} is within one standard deviation, {deviation:.2}, of \
                the plateau; the paper discards 500000"
            ),
            Estimate::exact(arrival.map_or(f64::NAN, |&(sweep, _)| sweep)),
            500_000.0,
        );
        let heights = column.center_of_mass.heights();
        let last = &heights[heights.len() - heights.len() / 3..];
        let mean = last.iter().sum::<f64>() / last.len() as f64;
        report.verdicts.between(
            "2",
            &format!(
                "h_c at T = {temperature} over the last third by the moves of the paper, {mean:.2}, minus {whose}, in \
                standard deviations of h_c"
            ),
            Estimate::exact((mean - plateau) / deviation),
            -2.0,
            2.0,
        );
    }
}

/// Claims that the columns are steady before production.
fn relaxation(steady: &[Column], report: &mut Report) {
    for temperature in TEMPERATURES {
        let columns = steady.iter().filter(|column| column.task.temperature == temperature);
        let mut latest: Option<(f64, &Column)> = None;
        for column in columns {
            let sweeps = steady_from(&column.center_of_mass).map_or(f64::INFINITY, |sweep| sweep as f64);
            let side = if column.task.side == Side::Above { "above" } else { "below" };
            let time = column.steady().autocorrelation().map_or(
                "(unknown: more than 1/50 of the run)".into(),
                |found| {
                    let scale = column.task.interval as f64;
                    (scale * found.time).to_string()
                },
            );
            println!(
                "T = {temperature:2}, {}, {} wide, from {side}: steady from sweep {sweeps} on; h_c {}, autocorrelation time {time} sweeps, {:.1} CPU s",
                column.task.family.name(),
                column.task.width,
                column.steady().estimate().map_or("too short".into(), |height| height.to_string()),
                column.busy,
            );
            if latest.is_none_or(|(most, _)| sweeps > most) {
                latest = Some((sweeps, column));
            }
        }
        if let Some((sweeps, column)) = latest {
            report.verdicts.at_most(
                "2",
                &format!(
                    "sweeps of {} until the slowest column at T = {temperature} is steady; at most those of equilibration",
                    column.task.family.name()
                ),
                Estimate::exact(sweeps),
                column.task.equilibration as f64,
            );
        }
    }
}
