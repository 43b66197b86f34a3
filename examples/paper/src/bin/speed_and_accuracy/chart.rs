//! The pictures.

use crate::contest::{Contest, Task, Way};
use crate::gradient::{Column, Route};
use crate::method::{Method, Moves, Scheme, Start};
use crate::point::{Point, Quantity};
use crate::reference::Reference;
use crate::system::System;
use paper::figure::RGBColor;
use paper::figure::{self, Axis, Corner, Figure, Mark, Panel, Place, colors};
use paper::pareto;

/// Ends of the axes: CPU seconds, with room for a legend left of the microseconds, and errors.
const TIMES: [f64; 2] = [1e-9, 1e3];
const ERRORS: [f64; 2] = [1e-4, 2.0];

fn color(moves: Moves) -> RGBColor {
    match moves {
        Moves::Paper => colors::VERMILION,
        Moves::Tuned => colors::GREEN,
        Moves::ChainsAndTuned => colors::BLUE,
        Moves::ChainsAlone => colors::PURPLE,
        Moves::OwnEquation => colors::SKY,
    }
}

fn scheme_color(scheme: Scheme) -> RGBColor {
    match scheme {
        Scheme::SelfConsistent => colors::GREEN,
        Scheme::Closure => colors::INK,
        Scheme::RunningAverage => colors::BLUE,
        Scheme::AveragedThenFrozen => colors::PURPLE,
        Scheme::Instantaneous => colors::VERMILION,
    }
}

/// Points of one system and their reference.
#[derive(Clone, Copy)]
pub(crate) struct Data<'a> {
    pub(crate) system: System,
    pub(crate) points: &'a [Point],
    pub(crate) reference: &'a Reference,
}

impl Data<'_> {
    /// (seconds, error) of every point.
    pub(crate) fn coordinates(&self, quantity: Quantity) -> Vec<(f64, f64)> {
        self.points.iter().map(|point| (point.seconds, quantity.of(&point.errors))).collect()
    }

    pub(crate) fn front(&self, quantity: Quantity) -> Vec<usize> {
        pareto::front(&self.coordinates(quantity))
    }

    /// An empty panel with the floor of the reference, the front and the theories.
    fn panel(&self, quantity: Quantity, place: Place, title: &str) -> Panel {
        let floor = quantity.of(&self.reference.errors);
        let coordinates = self.coordinates(quantity);
        // A staircase up to the next point of the front.
        let mut stairs: Vec<(f64, f64)> = Vec::new();
        for index in self.front(quantity) {
            if let Some(&(_, error)) = stairs.last() {
                stairs.push((coordinates[index].0, error));
            }
            stairs.push(coordinates[index]);
        }
        if let Some(&(_, error)) = stairs.last() {
            stairs.push((TIMES[1], error));
        }
        let theories = |with_walls: bool| {
            let chosen = self.points.iter().filter(move |point| match &point.way {
                crate::point::Way::Theory { walls, .. } => *walls == with_walls,
                crate::point::Way::Simulation { .. } => false,
            });
            chosen.map(move |point| mark(point, quantity)).collect::<Vec<_>>()
        };
        Panel::new(
            place,
            Axis::logarithmic("CPU seconds", TIMES[0], TIMES[1]),
            Axis::logarithmic(quantity.label(), ERRORS[0], ERRORS[1]),
        )
        .with_title(title)
        .line("error of the reference", colors::GRAY, Mark::Dashed, [(TIMES[0], floor), (TIMES[1], floor)])
        .line("Pareto front", RGBColor(205, 205, 205), Mark::Line, stairs)
        .points("theory, base at x = 0", colors::GRAY, Mark::Points, theories(false))
        .points("theory, between walls", colors::INK, Mark::Points, theories(true))
    }

    /// The points of a method on one thread, joined, rings where it is over-confident; those on two
    /// threads as dots.
    fn series(
        &self,
        panel: Panel,
        method: Method,
        quantity: Quantity,
        label: &str,
        color: RGBColor,
    ) -> Panel {
        let of = |threads: usize| -> Vec<&Point> {
            let own = |point: &&Point| {
                point.simulation(threads).is_some_and(|(own, _)| own == method)
                    && quantity.of(&point.errors).is_finite()
            };
            self.points.iter().filter(own).collect()
        };
        let single = of(1);
        let line: Vec<(f64, f64)> =
            single.iter().map(|point| (point.seconds, quantity.of(&point.errors))).collect();
        let style = if method.start == Start::Theory { Mark::Line } else { Mark::Dashed };
        let (rings, good): (Vec<&Point>, Vec<&Point>) =
            single.into_iter().partition(|point| point.is_over_confident(quantity, self.reference));
        let marks = |points: Vec<&Point>| -> Vec<figure::Point> {
            points.into_iter().map(|point| mark(point, quantity)).collect()
        };
        panel
            .line(label, color, style, line)
            .points("", color, Mark::Dots, marks(of(2)))
            .points("", color, Mark::Points, marks(good))
            .points("", color, Mark::Rings, marks(rings))
    }
}

fn mark(point: &Point, quantity: Quantity) -> figure::Point {
    figure::Point { x: point.seconds, y: quantity.of(&point.errors), error: 0.0 }
}

fn quarter(column: usize, row: usize) -> Place {
    Place { left: 0.5 * column as f64, top: 0.035 + 0.4825 * row as f64, width: 0.5, height: 0.4825 }
}

/// All moves of a system: n above, P below; small base at the left, full base at the right.
pub(crate) fn system(data: Data<'_>) -> Figure {
    let title = format!(
        "Error against CPU time, {}; full lines: theory start, dashed: random start",
        data.system.title()
    );
    let mut figure = Figure::new(&title).with_size(1600, 1400);
    for (row, quantity) in Quantity::BOTH.into_iter().enumerate() {
        for (column, full) in [false, true].into_iter().enumerate() {
            let base = if full { "25 x 25" } else { "5 x 5" };
            let title =
                format!("{}, base {base} (dots: two threads; rings: over-confident)", quantity.symbol());
            let mut panel = data.panel(quantity, quarter(column, row), &title);
            for method in Method::all(data.system) {
                if method.is_full() == full && method.scheme == Scheme::SelfConsistent {
                    let label = if method.start == Start::Theory { method.moves.label() } else { "" };
                    panel = data.series(panel, method, quantity, label, color(method.moves));
                }
            }
            if row + column == 0 {
                panel = panel.with_legend(Corner::BottomLeft);
            }
            figure = figure.panel(panel);
        }
    }
    figure
}

/// The schemes for temperatures that vary, with tuned moves from the theory start.
pub(crate) fn schemes(data: Data<'_>) -> Figure {
    let title =
        format!("Schemes for the effective field, {}; tuned local moves, theory start", data.system.title());
    let mut figure = Figure::new(&title).with_size(1600, 1400);
    for (row, quantity) in Quantity::BOTH.into_iter().enumerate() {
        for (column, full) in [false, true].into_iter().enumerate() {
            let base = if full { "25 x 25" } else { "5 x 5" };
            let title =
                format!("{}, base {base} (dots: two threads; rings: over-confident)", quantity.symbol());
            let mut panel = data.panel(quantity, quarter(column, row), &title);
            for method in Method::all(data.system) {
                if method.is_full() == full && method.moves == Moves::Tuned && method.start == Start::Theory {
                    let color = scheme_color(method.scheme);
                    panel = data.series(panel, method, quantity, method.scheme.label(), color);
                }
            }
            if row + column == 0 {
                panel = panel.with_legend(Corner::BottomLeft);
            }
            figure = figure.panel(panel);
        }
    }
    figure
}

/// Estimated against true errors of all simulations.
pub(crate) fn claims(all: &[Data<'_>]) -> Figure {
    const RANGE: [f64; 2] = [1e-4, 1.0];
    let mut figure = Figure::new("Estimated and true errors of all simulations, one thread; above the dashed line the true error is more than twice the estimate")
        .with_size(1600, 1050);
    for (row, quantity) in Quantity::BOTH.into_iter().enumerate() {
        for (column, data) in all.iter().enumerate() {
            let part = 1.0 / all.len() as f64;
            let place = Place {
                left: part * column as f64,
                top: 0.045 + 0.4775 * row as f64,
                width: part,
                height: 0.4775,
            };
            let floor = quantity.of(&data.reference.errors);
            let mut panel = Panel::new(
                place,
                Axis::logarithmic("estimated error", RANGE[0], RANGE[1]),
                Axis::logarithmic("true error", RANGE[0], RANGE[1]),
            )
            .with_title(&format!("{}, {}", quantity.symbol(), data.system.title()))
            .line("", colors::GRAY, Mark::Line, [(RANGE[0], RANGE[0]), (RANGE[1], RANGE[1])])
            .line(
                "",
                colors::GRAY,
                Mark::Dashed,
                (0..=60).map(|step| {
                    let claim = RANGE[0] * libm::pow(RANGE[1] / RANGE[0], f64::from(step) / 60.0);
                    (claim, 2.0 * claim.hypot(floor))
                }),
            );
            for moves in Moves::ALL {
                for over_confident in [false, true] {
                    let chosen = data.points.iter().filter_map(|point| {
                        let (method, _) = point.simulation(1)?;
                        let own = point.is_over_confident(quantity, data.reference) == over_confident;
                        (own && method.moves == moves).then_some(())?;
                        let claimed = quantity.of(point.claims.as_ref()?);
                        Some(figure::Point { x: claimed, y: quantity.of(&point.errors), error: 0.0 })
                    });
                    let (label, style) =
                        if over_confident { ("", Mark::Rings) } else { (moves.label(), Mark::Points) };
                    panel = panel.points(label, color(moves), style, chosen);
                }
            }
            if row + column == 0 {
                panel = panel.with_legend(Corner::BottomRight);
            }
            figure = figure.panel(panel);
        }
    }
    figure
}

/// A panel of the contest for the equation of state.
fn contest_panel(contest: &Contest, task: Task, target: f64, place: Place) -> Panel {
    const RANGE: [f64; 2] = [1e-2, 1e2];
    const ERROR: [f64; 2] = [5e-4, 3.0];
    let (title, error) = match task {
        Task::Densities(..) => {
            (format!("equation of state at packing fractions, {}", task.label()), "rms of Z/Z(KLM) − 1")
        }
        _ => (format!("the whole {} homogeneous points", task.label()), "largest error of Z(η)"),
    };
    let mut panel = Panel::new(
        place,
        Axis::logarithmic("CPU seconds, of all runs together", RANGE[0], RANGE[1]),
        Axis::logarithmic(error, ERROR[0], ERROR[1]),
    )
    .with_title(&title)
    .with_legend(Corner::TopRight)
    .line("", colors::GRAY, Mark::Dashed, [(RANGE[0], target), (RANGE[1], target)]);
    let ways = [
        (Way::Gradient(Column::Designed, Route::Collisions), colors::BLUE),
        (Way::Gradient(Column::RandomStart, Route::Collisions), colors::GREEN),
        (Way::Gradient(Column::RandomStart, Route::Ranks), colors::VERMILION),
        (Way::Gradient(Column::Uniform, Route::Both), colors::SKY),
        (Way::Local, colors::GRAY),
        (Way::Chains, colors::PURPLE),
        (Way::ChainsAtPace, colors::INK),
    ];
    for (way, color) in ways {
        let points: Vec<(f64, f64)> = contest
            .points(way, task)
            .iter()
            .map(|point| (point.time(true), point.error))
            // Not a number while a column has yet to reach some of the packing fractions.
            .filter(|(_, error)| error.is_finite())
            .collect();
        let style = if way.is_gradient() { Mark::Line } else { Mark::Dashed };
        let marks = points.clone().into_iter().map(|(x, y)| figure::Point { x, y, error: 0.0 });
        panel = panel.line(&way.label(), color, style, points).points("", color, Mark::Points, marks);
    }
    panel
}

/// The chart: total variation distances of the three systems, and the contest.
pub(crate) fn overview(all: &[Data<'_>], contest: &Contest, target: f64) -> Figure {
    let mut figure = Figure::new("Speed against accuracy").with_size(1600, 1400);
    for (index, data) in all.iter().enumerate() {
        let title = format!("n(x), {}; full lines 25 x 25, dashed 5 x 5", data.system.title());
        let quantity = Quantity::Density;
        let mut panel = data.panel(quantity, quarter(index % 2, index / 2), &title);
        for method in Method::all(data.system) {
            // From the random start; the theory start is in the pictures of the systems.
            if method.start == Start::Uniform && method.scheme == Scheme::SelfConsistent {
                let label = if method.is_full() { method.moves.label() } else { "" };
                // Here the line style distinguishes the bases.
                let shown = panel;
                panel = data.series_of_base(shown, method, quantity, label);
            }
        }
        if index == 0 {
            panel = panel.with_legend(Corner::BottomLeft);
        }
        figure = figure.panel(panel);
    }
    figure.panel(contest_panel(contest, Task::SEVENTEEN, target, quarter(1, 1)))
}

impl Data<'_> {
    /// As [`series`](Self::series), with the base in place of the start and without the second
    /// thread.
    fn series_of_base(&self, panel: Panel, method: Method, quantity: Quantity, label: &str) -> Panel {
        let own = |point: &&Point| {
            point.simulation(1).is_some_and(|(own, _)| own == method)
                && quantity.of(&point.errors).is_finite()
        };
        let points: Vec<&Point> = self.points.iter().filter(own).collect();
        let line: Vec<(f64, f64)> =
            points.iter().map(|point| (point.seconds, quantity.of(&point.errors))).collect();
        let style = if method.is_full() { Mark::Line } else { Mark::Dashed };
        let (rings, good): (Vec<&Point>, Vec<&Point>) =
            points.into_iter().partition(|point| point.is_over_confident(quantity, self.reference));
        let color = color(method.moves);
        panel
            .line(label, color, style, line)
            .points("", color, Mark::Points, good.into_iter().map(|point| mark(point, quantity)))
            .points("", color, Mark::Rings, rings.into_iter().map(|point| mark(point, quantity)))
    }
}

/// The gradient compared with homogeneous runs: at nine, seventeen and sixty-five packing
/// fractions, and for the whole curve.
pub(crate) fn contest(contest: &Contest, target: f64) -> Figure {
    let tasks = [Task::NINE, Task::SEVENTEEN, Task::SIXTY_FIVE, Task::Curve(8)];
    let title = "The equation of state from one gradient run, and from homogeneous runs, from scratch";
    tasks.into_iter().enumerate().fold(Figure::new(title).with_size(1600, 1400), |figure, (index, task)| {
        figure.panel(contest_panel(contest, task, target, quarter(index % 2, index / 2)))
    })
}
