//! What is printed: the table of the cases, and what it does and does not show.

use super::protocol::{MovesChoice, Protocol, StartChoice};
use super::report::{BULK_BEGINS, BULK_DENSITY, Comparison, Report};
use gradient_mc::statistics::Estimate;
use paper::progress::in_words;
use paper::replicas::thread_count;
use paper::table::Table;
use statrs::distribution::{ContinuousCDF, Normal};
use std::time::Duration;

/// The table: one column per case.
pub(crate) fn table(reports: &[Report]) -> Table {
    let mut table =
        Table::new(std::iter::once(String::new()).chain(reports.iter().map(|report| report.case.head())));
    let mut row = |label: &str, cell: &dyn Fn(&Report) -> String| table.row(label, reports.iter().map(cell));
    let estimate = |value: Option<Estimate>| value.map_or("too short".into(), |value| value.to_string());

    row("center of mass h_c, simulation", &|report| estimate(report.center_of_mass));
    row("center of mass, Carnahan-Starling theory", &|report| format!("{:.3}", report.center_of_mass_theory));
    row("drift of h_c, second half minus first", &|report| estimate(report.drift));
    let low = format!("packing fraction below {BULK_BEGINS} d, simulation");
    row(&low, &|report| format!("{:.4}", report.low_packing_fraction));
    row("  the same, theory", &|report| format!("{:.4}", report.low_packing_fraction_theory));
    row("packing fraction at the base, theory", &|report| {
        format!("{:.4}", report.base_packing_fraction_theory)
    });
    row("acceptance of trial moves", &|report| {
        if report.production.trials > 0 {
            format!("{:.4}", report.production.acceptance())
        } else {
            "nothing is rejected".into()
        }
    });
    row("bins in the bulk", &|report| report.bulk().count().to_string());
    for (name, comparison) in [
        ("Carnahan-Starling", Report::against_carnahan_starling as fn(&Report) -> Comparison),
        ("modified KLM", Report::against_modified_kolafa),
    ] {
        row(&format!("P against {name}: rms"), &|report| in_percent(comparison(report).rms));
        row("  rms expected of noise alone", &|report| percent(comparison(report).rms_of_noise));
        row("  largest deviation", &|report| in_percent(comparison(report).largest));
        row("  in standard errors, at packing fraction", &|report| {
            let Comparison { largest, largest_at, .. } = comparison(report);
            format!("{:.1} at {largest_at:.3}", largest.deviation_from(0.0).abs())
        });
    }
    row("  largest expected of noise, standard errors", &|report| {
        format!("{:.1}", largest_of_noise(report.bulk().count()))
    });
    row("paper's σ of P, eq. (32): mean, largest", &|report| {
        report
            .scatter
            .map_or("one run".into(), |range| format!("{}, {}", percent(range.mean), percent(range.largest)))
    });
    row("  runs it is taken over", &|report| report.runs.to_string());
    row("paper's δ from CS, eq. (33): mean, largest", &|report| {
        format!("{}, {}", percent(report.deviation.mean), percent(report.deviation.largest))
    });
    row("trial moves and events of chains, millions", &|report| {
        format!("{:.0}", report.moves() as f64 / 1e6)
    });
    row("  the same per second and core", &|report| format!("{:.2}", report.moves_per_second() / 1e6));
    row("processor time", &|report| format!("{:.1} s", report.busy.as_secs_f64()));
    table
}

fn in_percent(fraction: Estimate) -> String {
    format!("{} %", 100.0 * fraction)
}

fn percent(fraction: f64) -> String {
    format!("{:.3} %", 100.0 * fraction)
}

/// Median of the largest of so many magnitudes of independent normal numbers.
fn largest_of_noise(count: usize) -> f64 {
    let each = libm::pow(0.5, 1.0 / count.max(1) as f64);
    Normal::standard().inverse_cdf(f64::midpoint(1.0, each))
}

/// What the table means, and what it does not prove.
pub(crate) fn remarks(protocol: &Protocol, reports: &[Report], threads: usize, elapsed: Duration) -> String {
    let runs = if protocol.intervals.len() > 1 {
        "consecutive intervals of one simulation (Sec. III of the paper)"
    } else {
        "independent replicas (Sec. IV D of the paper)"
    };
    let mut text = format!(
        "{:.0} s on {} threads. Bulk: x > {BULK_BEGINS} and n > {BULK_DENSITY}. Errors are one standard error, \
         in brackets in units of the last digits;\n\
         they see correlations no longer than the measurement. σ is over {runs}.\n\
         The theory is local: it knows neither the wall nor the layers there, which lift a real column a little.\n",
        elapsed.as_secs_f64(),
        thread_count(threads),
    );
    for report in reports {
        if let Some(certificate) = report.certificate {
            text.push_str(&format!("{}: effective field {certificate}.\n", report.case.head()));
        }
        for warning in &report.warnings {
            text.push_str(&format!("{}: {warning}.\n", report.case.head()));
        }
        let Some(drift) = report.drift else { continue };
        let sigmas = drift.deviation_from(0.0);
        if sigmas.abs() > DRIFT_TOLERANCE {
            text.push_str(&format!(
                "{}: h_c drifts by {drift}, {:.0} standard errors: not yet steady, and the error of h_c is too \
                 small.\n",
                report.case.head(),
                sigmas.abs()
            ));
        }
    }
    if protocol.start == StartChoice::Theory {
        let OtherSide { particles, sweeps, memory } = OtherSide::of(protocol.moves);
        // As if no replica had been interrupted.
        let sweeps_made = protocol.sweeps_per_replica() * protocol.replicas * reports.len() as u64;
        let spheres_moved = protocol.particles as f64 * sweeps_made as f64;
        let busy: f64 = reports.iter().map(|report| report.busy.as_secs_f64()).sum();
        let work = particles as f64 * (2 * sweeps * protocol.replicas * reports.len() as u64) as f64;
        let seconds = work * busy / spheres_moved / thread_count(threads) as f64;
        let moves = protocol.moves_name();
        text.push_str(&format!(
            "\nEvery replica started at the profile of theory, and by these moves a column forgets its start over\n\
             some {memory} sweeps: h_c near theory proves nothing by itself, nor does a small drift. To see the steady\n\
             state reached from above and from below (about {} each):\n\n",
            in_words(Duration::from_secs_f64(seconds)),
        ));
        for (start, out) in [("random-insertion", "from_above"), ("close-packed", "from_below")] {
            text.push_str(&format!(
                "  cargo run --release --example three_cases -- --moves {moves} --particles {particles} \
                 --equilibration {sweeps} --sweeps {sweeps} --start {start} --out out/{out}\n"
            ));
        }
    }
    text
}

/// A drift of more standard errors than this is no accident.
const DRIFT_TOLERANCE: f64 = 3.0;

/// A run long enough for the column to forget where it started.
struct OtherSide {
    particles: u64,
    sweeps: u64,
    memory: &'static str,
}

impl OtherSide {
    fn of(moves: MovesChoice) -> Self {
        match moves {
            MovesChoice::Chains | MovesChoice::Tuned | MovesChoice::Both => {
                Self { particles: 4000, sweeps: 5000, memory: "thousand" }
            }
            MovesChoice::Local => Self { particles: 1000, sweeps: 100_000, memory: "ten thousand" },
        }
    }
}
