//! Tables on the terminal, and everything as CSV.

use crate::chart::Data;
use crate::contest::{Contest, Crossing, Task, Way, crossing};
use crate::point::{Point, Quantity};
use crate::profile::Errors;
use paper::table::Table;
use paper::{Failure, Report, output};
use std::fmt;
use std::io::Write;

/// A method with all its points, the cheapest first.
pub(crate) struct Family<'a> {
    pub(crate) name: String,
    pub(crate) points: Vec<&'a Point>,
}

/// Points by the name of what made them, in their order.
pub(crate) fn families<'a>(data: &Data<'a>) -> Vec<Family<'a>> {
    let mut families: Vec<Family<'a>> = Vec::new();
    for point in data.points {
        let name = point.name();
        match families.iter_mut().find(|family| family.name == name) {
            Some(family) => family.points.push(point),
            None => families.push(Family { name, points: vec![point] }),
        }
    }
    families
}

impl Family<'_> {
    /// CPU seconds until the error stays below a target.
    pub(crate) fn time_to(&self, quantity: Quantity, target: f64) -> Option<f64> {
        let points: Vec<(f64, f64)> =
            self.points.iter().map(|point| (point.seconds, quantity.of(&point.errors))).collect();
        Some(crossing(&points, target, 1.0)?.seconds)
    }

    pub(crate) fn over_confident(&self, data: &Data<'_>, quantity: Quantity) -> usize {
        self.points.iter().filter(|point| point.is_over_confident(quantity, data.reference)).count()
    }
}

/// A time with two digits.
pub(crate) fn time(seconds: Option<f64>) -> String {
    match seconds {
        None => "-".to_owned(),
        Some(seconds) if seconds < 1e-3 => format!("{:.0} µs", 1e6 * seconds),
        Some(seconds) if seconds < 1.0 => format!("{:.0} ms", 1e3 * seconds),
        Some(seconds) => format!("{seconds:.1} s"),
    }
}

fn percent(value: f64) -> String {
    if value.is_nan() { "-".to_owned() } else { format!("{:.2}", 100.0 * value) }
}

/// Every method on one thread: times to 1 % and 0.3 %, and its last point.
pub(crate) fn system_table(data: &Data<'_>) -> Table {
    let mut table = Table::new([
        data.system.title(),
        "n to 1 %".into(),
        "n to 0.3 %".into(),
        "P to 1 %".into(),
        "P to 0.3 %".into(),
        "longest run".into(),
        "n, %".into(),
        "estimated".into(),
        "P, %".into(),
        "estimated".into(),
        "bulk n, %".into(),
        "bulk P, %".into(),
        "h_c, %".into(),
        "over-confident".into(),
    ]);
    let own = &data.reference.errors;
    let mut cells = vec![String::new(); 13];
    cells[4] = time(Some(data.reference.seconds));
    cells[6] = percent(own.misplaced);
    cells[8] = percent(own.pressure);
    table.row("the reference, estimated error", cells);
    for family in families(data) {
        let Some(last) = family.points.last() else { continue };
        if last.threads() > 1 {
            continue;
        }
        let to = |quantity, target| time(family.time_to(quantity, target));
        let claim = |quantity: Quantity| {
            last.claims.as_ref().map_or("-".to_owned(), |claims| percent(quantity.of(claims)))
        };
        let over = Quantity::BOTH.map(|quantity| family.over_confident(data, quantity));
        table.row(
            &family.name,
            [
                to(Quantity::Density, 0.01),
                to(Quantity::Density, 0.003),
                to(Quantity::Pressure, 0.01),
                to(Quantity::Pressure, 0.003),
                time(Some(last.seconds)),
                percent(last.errors.misplaced),
                claim(Quantity::Density),
                percent(last.errors.pressure),
                claim(Quantity::Pressure),
                percent(last.errors.bulk_density),
                percent(last.errors.bulk_pressure),
                percent(last.errors.center_of_mass),
                if last.claims.is_none() {
                    "no estimate".to_owned()
                } else {
                    format!("n {}, P {} of {}", over[0], over[1], family.points.len())
                },
            ],
        );
    }
    table
}

/// The points on the fronts.
pub(crate) fn front_table(data: &Data<'_>, quantity: Quantity) -> Table {
    let mut table = Table::new([
        format!("Pareto front, {}, {}", quantity.symbol(), data.system.title()),
        "time".into(),
        "error, %".into(),
    ]);
    for index in data.front(quantity) {
        let point = &data.points[index];
        let name = if point.sweeps() > 0 {
            format!("{}, {} sweeps", point.name(), point.sweeps())
        } else {
            point.name()
        };
        table.row(&name, [time(Some(point.seconds)), format!("{:.3}", 100.0 * quantity.of(&point.errors))]);
    }
    table
}

/// The error of the mean of two replicas over that of one, for the longest runs.
pub(crate) fn threads_table(all: &[Data<'_>]) -> Table {
    let mut table = Table::new([
        "error of two threads over that of one, median over the longest runs of all simulations",
        "n",
        "P",
        "CPU seconds",
    ]);
    for data in all {
        let families = families(data);
        let mut ratios: [Vec<f64>; 3] = Default::default();
        for double in families.iter().filter(|family| family.points.iter().any(|point| point.threads() > 1)) {
            let single = families.iter().find(|family| format!("{}, 2 threads", family.name) == double.name);
            let last = |family: &Family<'_>| family.points.last().map(|&point| point.clone());
            if let (Some(one), Some(two)) = (single.and_then(last), last(double)) {
                ratios[0].push(two.errors.misplaced / one.errors.misplaced);
                ratios[1].push(two.errors.pressure / one.errors.pressure);
                ratios[2].push(two.seconds / one.seconds);
            }
        }
        let median = |values: &mut Vec<f64>| {
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 2).map_or("-".to_owned(), |value| format!("{value:.2}"))
        };
        let cells = ratios.each_mut().map(median);
        table.row(&data.system.title(), cells);
    }
    table
}

/// CPU seconds of every way to a target, for several tasks.
pub(crate) fn contest_table(contest: &Contest, tasks: &[Task], target: f64, from_scratch: bool) -> Table {
    let from = if from_scratch { "from scratch" } else { "once equilibrated" };
    let mut head = vec![format!("CPU seconds to {} %, {from}", 100.0 * target)];
    head.extend(tasks.iter().map(|task| task.label()));
    let mut table = Table::new(head);
    for way in Contest::ways() {
        let cells = tasks.iter().map(|&task| match time_to(contest, way, task, target, from_scratch) {
            Some(found) => found.to_string(),
            None => "-".to_owned(),
        });
        table.row(&way.label(), cells.collect::<Vec<_>>());
    }
    table
}

/// Where the gradient runs are off.
pub(crate) fn deviations_table(contest: &Contest) -> Table {
    let rows = contest.gradient_deviations();
    let mut head = vec!["Z/Z(KLM) − 1 of the longest gradient runs, %, at".to_owned()];
    if let Some((_, deviations)) = rows.first() {
        head.extend(deviations.iter().map(|(eta, _)| eta.to_string()));
    }
    let mut table = Table::new(head);
    for (way, deviations) in rows {
        let cells = deviations.iter().map(|(_, deviation)| {
            format!("{:.2} ± {:.2}", 100.0 * deviation.mean, 100.0 * deviation.standard_error)
        });
        table.row(&way.label(), cells.collect::<Vec<_>>());
    }
    table
}

/// CPU seconds to a target of the best gradient and of the best homogeneous way; none where it is
/// not even near.
pub(crate) fn best(
    contest: &Contest,
    task: Task,
    target: f64,
    from_scratch: bool,
) -> [Option<(Way, Crossing)>; 2] {
    [true, false].map(|gradient| {
        Contest::ways()
            .filter(|way| way.is_gradient() == gradient && *way != Way::ChainsAtPace)
            .filter_map(|way| Some((way, time_to(contest, way, task, target, from_scratch)?)))
            .min_by(|one, other| one.1.seconds.total_cmp(&other.1.seconds))
    })
}

/// CPU seconds of a way to a target.
pub(crate) fn time_to(
    contest: &Contest,
    way: Way,
    task: Task,
    target: f64,
    from_scratch: bool,
) -> Option<Crossing> {
    /// So many times the target are near enough to extrapolate.
    const NEAR: f64 = 4.0;
    let points = contest.points(way, task);
    let times: Vec<(f64, f64)> = points.iter().map(|point| (point.time(from_scratch), point.error)).collect();
    crossing(&times, target, NEAR)
}

impl fmt::Display for Crossing {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let about = if self.extrapolated { "≈ " } else { "" };
        write!(formatter, "{about}{:.3}", self.seconds)
    }
}

/// Writes every point of every system.
pub(crate) fn write_points(all: &[Data<'_>], report: &Report) -> Result<(), Failure> {
    let path = &report.directory.join("speed_and_accuracy.csv");
    let mut file = Vec::new();
    writeln!(
        file,
        "# CPU seconds of the slowest thread; errors: total variation distance, largest error of P over P at the base, relative rms \
         over the bulk, relative of h_c; estimated errors are empty where there is no estimate"
    )?;
    let mut writer = csv::Writer::from_writer(file);
    writer.write_record([
        "system",
        "method",
        "threads",
        "sweeps",
        "cpu_seconds",
        "total_variation_distance",
        "claimed_total_variation_distance",
        "pressure_error",
        "claimed_pressure_error",
        "bulk_density_error",
        "claimed_bulk_density_error",
        "bulk_pressure_error",
        "claimed_bulk_pressure_error",
        "center_of_mass_error",
        "claimed_center_of_mass_error",
        "density_over_confident",
        "pressure_over_confident",
        "density_front",
        "pressure_front",
    ])?;
    for data in all {
        let fronts = Quantity::BOTH.map(|quantity| data.front(quantity));
        for (index, point) in data.points.iter().enumerate() {
            let mut record = vec![
                data.system.name().to_owned(),
                point.name(),
                point.threads().to_string(),
                point.sweeps().to_string(),
                format!("{:.4e}", point.seconds),
            ];
            let (errors, claims) = (&point.errors, point.claims.as_ref());
            let parts: [fn(&Errors) -> f64; 5] = [
                |errors| errors.misplaced,
                |errors| errors.pressure,
                |errors| errors.bulk_density,
                |errors| errors.bulk_pressure,
                |errors| errors.center_of_mass,
            ];
            for of in parts {
                record.push(format!("{:.4e}", of(errors)));
                let claim = claims.map(of).filter(|claim| !claim.is_nan());
                record.push(claim.map_or(String::new(), |claim| format!("{claim:.4e}")));
            }
            record.extend(
                Quantity::BOTH.map(|quantity| point.is_over_confident(quantity, data.reference).to_string()),
            );
            record.extend(fronts.each_ref().map(|front| front.contains(&index).to_string()));
            writer.write_record(record)?;
        }
    }
    output::write(path, writer.into_inner()?)
}

/// Writes every point of the contest.
pub(crate) fn write_contest(contest: &Contest, report: &Report) -> Result<(), Failure> {
    let path = &report.directory.join("equation_of_state.csv");
    let mut file = Vec::new();
    writeln!(
        file,
        "# CPU seconds of all runs together; error, against the modified Kolafa equation, rms over replicas: rms over packing fractions of Z; largest of Z over the curve; of the excess chemical potential at 0.45"
    )?;
    let mut writer = csv::Writer::from_writer(file);
    writer.write_record(["task", "way", "equilibration_seconds", "measurement_seconds", "error"])?;
    for task in Task::DENSITIES.into_iter().chain(Task::CURVES) {
        for way in Contest::ways() {
            for point in contest.points(way, task) {
                let numbers = [point.seconds[0], point.seconds[1], point.error];
                let mut record = vec![task.label(), way.label()];
                record.extend(numbers.map(|number| format!("{number:.4e}")));
                writer.write_record(record)?;
            }
        }
    }
    output::write(path, writer.into_inner()?)
}
