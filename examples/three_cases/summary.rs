//! Printed output: the table of the cases and remarks.

use super::protocol::{MovesChoice, Protocol, StartChoice};
use super::report::{BULK_BEGINS, BULK_DENSITY, Factor, Pulls, Report};
use gradient_mc::equation_of_state::{CarnahanStarling, ModifiedKolafa};
use gradient_mc::statistics::Estimate;
use paper::progress::in_words;
use paper::replicas::thread_count;
use paper::table::Table;
use std::time::Duration;

/// The table: one column per case.
pub(crate) fn table(reports: &[Report]) -> Table {
    let mut table =
        Table::new(std::iter::once(String::new()).chain(reports.iter().map(|report| report.case.head())));
    let mut row = |label: &str, cell: &dyn Fn(&Report) -> String| table.row(label, reports.iter().map(cell));
    let estimate = |value: Option<Estimate>| value.map_or("too few data".into(), |value| value.to_string());

    row("center of mass h_c, simulation", &|report| estimate(report.center_of_mass));
    row("center of mass, Carnahan-Starling theory", &|report| format!("{:.3}", report.center_of_mass_theory));
    row("drift of h_c, second half minus first", &|report| estimate(report.drift));
    let low = format!("packing fraction below {BULK_BEGINS} d, simulation");
    row(&low, &|report| format!("{:.4}", report.low_packing_fraction));
    row("  the same, theory", &|report| format!("{:.4}", report.low_packing_fraction_theory));
    for eta in [0.1, 0.2, 0.3] {
        row(&format!("Z at packing fraction {eta}"), &|report| {
            let factor = report.factors.iter().find(|factor| (factor.packing_fraction - eta).abs() < 1e-9);
            factor.map_or("density not reached".into(), |factor| factor.combined.to_string())
        });
    }
    let routes: [(&str, Route); 3] = [
        ("both routes", |factor| factor.combined),
        ("ranks", |factor| factor.ranks),
        ("collisions", |factor| factor.collisions),
    ];
    for (name, route) in routes {
        row(&format!("Z against modified KLM, {name}: rms, largest"), &|report| {
            in_errors(report.pulls(&ModifiedKolafa, route))
        });
    }
    row("Z against Carnahan-Starling: rms, largest", &|report| {
        in_errors(report.pulls(&CarnahanStarling, |factor| factor.combined))
    });
    row("σ of P, eq. (32) of the paper: mean, largest", &|report| {
        report
            .scatter
            .map_or("one run".into(), |range| format!("{}, {}", percent(range.mean), percent(range.largest)))
    });
    row("  number of runs for σ", &|report| report.runs.to_string());
    row("δ of P from CS, eq. (33) of the paper: mean, largest", &|report| {
        format!("{}, {}", percent(report.deviation.mean), percent(report.deviation.largest))
    });
    row("CPU time", &|report| format!("{:.1} s", report.busy.as_secs_f64()));
    table
}

/// Selects one of the values of Z.
type Route = fn(&Factor) -> Estimate;

/// Deviations in units of their standard errors.
fn in_errors(pulls: Option<Pulls>) -> String {
    pulls.map_or("too few data".into(), |Pulls { rms, largest, at }| {
        format!("{rms:.1}, {largest:+.1} at {at:.3}")
    })
}

fn percent(fraction: f64) -> String {
    format!("{:.3} %", 100.0 * fraction)
}

/// Remarks on the table.
pub(crate) fn remarks(protocol: &Protocol, reports: &[Report], threads: usize, elapsed: Duration) -> String {
    let runs = if protocol.intervals.len() > 1 {
        "consecutive intervals of one simulation (Sec. III of the paper)"
    } else {
        "independent replicas (Sec. IV D of the paper)"
    };
    let cuts: Vec<String> =
        reports.iter().filter_map(|report| Some(format!("{:.1}", report.heights?[0]))).collect();
    let layers = if cuts.is_empty() { String::new() } else { format!(", from x = {} on", cuts.join(", ")) };
    let mut text = format!(
        "{:.0} s on {} threads. Numbers in brackets are one standard error in units of the last digits; deviations of Z are in \
        standard errors.\n\
         Z is measured from the heights of ranks and from the collisions of event chains, above the layers at the base{}.\n\
         σ and δ are means over bins at x > {BULK_BEGINS} with n > {BULK_DENSITY}, σ over {runs}.\n\
         The theory is local: it neglects the layers at the wall, which raise the column slightly.\n",
        elapsed.as_secs_f64(),
        thread_count(threads),
        layers,
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
                "{}: h_c drifts by {drift}, {:.0} standard errors: the column is not stationary, and the error of h_c is \
                too small.\n",
                report.case.head(),
                sigmas.abs()
            ));
        }
    }
    if protocol.start == StartChoice::Theory {
        let OtherSide { particles, sweeps, memory } = OtherSide::of(protocol.moves);
        // Assumes that no replica was interrupted.
        let sweeps_made = protocol.sweeps_per_replica() * protocol.replicas * reports.len() as u64;
        let spheres_moved = protocol.particles as f64 * sweeps_made as f64;
        let busy: f64 = reports.iter().map(|report| report.busy.as_secs_f64()).sum();
        let work = particles as f64 * (2 * sweeps * protocol.replicas * reports.len() as u64) as f64;
        let seconds = work * busy / spheres_moved / thread_count(threads) as f64;
        let moves = protocol.moves_name();
        text.push_str(&format!(
            "\nEvery replica starts at the theoretical profile, and with these moves a column relaxes in about\n\
             {memory} sweeps. Agreement of h_c with theory, or a small drift, is therefore no proof of equilibrium.\n\
             To test it, compare runs that start too high and too low (about {} each):\n\n",
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

/// A drift is significant above this number of standard errors.
const DRIFT_TOLERANCE: f64 = 3.0;

/// A run that is long compared with the relaxation time.
struct OtherSide {
    particles: u64,
    sweeps: u64,
    memory: &'static str,
}

impl OtherSide {
    fn of(moves: MovesChoice) -> Self {
        match moves {
            MovesChoice::Chains | MovesChoice::Tuned | MovesChoice::Both => {
                Self { particles: 4000, sweeps: 5000, memory: "a thousand" }
            }
            MovesChoice::Local => Self { particles: 1000, sweeps: 100_000, memory: "ten thousand" },
        }
    }
}
