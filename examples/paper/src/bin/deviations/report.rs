//! Tables and files.

use super::checks::{FEW, LINE};
use super::outcome::{Analysis, Outcome};
use super::run::RUNS;
use gradient_mc::statistics::deviations::expected_scatter;
use paper::groups::farthest_from_zero;
use paper::row;
use paper::table::{Table, percent};
use paper::{Failure, Report};

/// One row for each set of five runs.
pub(crate) fn table(outcomes: &[Outcome]) -> Table {
    let mut table = Table::new([
        "in %".to_owned(),
        "largest P/(nTZ) − 1, CS".into(),
        "modified Kolafa".into(),
        "in standard errors".into(),
        "2 % over the largest".into(),
        "median δ".into(),
        format!("bins with δ < 2 %, ν > {FEW}"),
        "median σ".into(),
        "standard error from σ".into(),
    ]);
    for outcome in outcomes {
        let ours = std::iter::once((outcome.case.label(), &outcome.ours));
        let papers = outcome.papers.iter().map(|runs| (format!("  {}", runs.name), &runs.first));
        for (label, analysis) in ours.chain(papers) {
            let largest = farthest_from_zero(analysis.carnahan_starling.iter().copied());
            let median = analysis.median(|point| point.scatter);
            let runs = usize::try_from(RUNS).unwrap_or(usize::MAX);
            // Of the mean of the runs, if they are independent and Gaussian.
            let error = median / expected_scatter(runs) / (runs as f64).sqrt();
            table.row(
                &label,
                [
                    percent(largest),
                    percent(farthest_from_zero(analysis.modified_kolafa.iter().copied())),
                    format!("{:.1}", Analysis::most_significant(&analysis.modified_kolafa)),
                    format!("{:.1}", LINE / largest.mean.abs()),
                    format!("{:.2}", 100.0 * analysis.median(|point| point.deviation)),
                    format!("{:.1}", 100.0 * analysis.part_below(LINE, FEW, |point| point.deviation)),
                    format!("{:.2}", 100.0 * median),
                    format!("{:.2}", 100.0 * error),
                ],
            );
        }
    }
    table
}

/// Every range of heights of every column.
pub(crate) fn groups(outcomes: &[Outcome]) -> Table {
    let mut table = Table::new([
        "P/(nTZ) − 1, %",
        "heights",
        "packing fraction",
        "Carnahan-Starling",
        "modified Kolafa",
        "not local",
        "the paper's, CS",
    ]);
    for Outcome { case, nonlocal, ours, papers } in outcomes {
        for (index, &group) in case.groups.iter().enumerate() {
            let of_paper: Vec<String> =
                papers.iter().map(|runs| percent(runs.mean(|run| run.carnahan_starling[index]))).collect();
            table.row(
                &case.label(),
                [
                    format!("{:.1} to {:.1}", group[0], group[1]),
                    format!("{:.3}", case.mean_packing_fraction(group)),
                    percent(ours.carnahan_starling[index]),
                    percent(ours.modified_kolafa[index]),
                    format!("{:.2}", 100.0 * nonlocal[index]),
                    of_paper.join(", "),
                ],
            );
        }
    }
    table
}

/// The data of each panel: the paper's measures, and ours.
pub(crate) fn write(outcomes: &[Outcome], report: &Report) -> Result<(), Failure> {
    for panel in ["17a", "17b", "17c"] {
        let of_panel = || outcomes.iter().filter(|outcome| outcome.case.panel == panel);
        let sets = || {
            of_panel().flat_map(|outcome| {
                let papers = outcome.papers.iter().map(|runs| &runs.first);
                let sets = std::iter::once(&outcome.ours).chain(papers);
                sets.enumerate().map(move |(set, analysis)| (&outcome.case, set as f64, analysis))
            })
        };
        report.table(&format!("figure_{panel}"),
            "height in d; deviation (33) with its error, and scatter (32), from five runs in bins of 0.1 d, Carnahan-Starling; set 0: default runs, 1 and 2: \
             runs as the paper made them (without --paper: from above, from below)",
            "temperature, growth_rate, decay_rate, set, height, packing_fraction, deviation, \
             deviation_error, scatter",
            sets().flat_map(|(case, set, analysis)| {
                let column = [case.temperature, case.growth_rate, case.decay_rate];
                analysis.points.iter().map(move |point| {
                    [
                        column[0],
                        column[1],
                        column[2],
                        set,
                        point.height,
                        point.packing_fraction,
                        point.deviation,
                        point.deviation_error,
                        point.scatter,
                    ]
                })
            }),
        )?;
        report.table(&format!("figure_{panel}_ranges"),
            "heights in d; P/(nTZ) − 1 over ranges of height, errors by the jackknife; sets as in the other file",
            "growth_rate, decay_rate, set, lowest_height, highest_height, \
             packing_fraction_of_theory, carnahan_starling, carnahan_starling_error, \
             modified_kolafa, modified_kolafa_error",
            sets().flat_map(|(case, set, analysis)| {
                let rows = case.groups.iter().zip(&analysis.carnahan_starling).zip(&analysis.modified_kolafa);
                rows.map(move |((&group, carnahan_starling), modified_kolafa)| {
                    row![
                        case.growth_rate,
                        case.decay_rate,
                        set,
                        group[0],
                        group[1],
                        case.mean_packing_fraction(group),
                        carnahan_starling,
                        modified_kolafa,
                    ]
                })
            }),
        )?;
    }
    Ok(())
}
