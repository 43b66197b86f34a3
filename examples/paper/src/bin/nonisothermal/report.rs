//! Tables and files.

use super::column::{COLUMN_DENSITY, HEIGHT, TEMPERATURE};
use super::outcome::Outcome;
use super::run::{MAXIMUM_DISPLACEMENT, Protocol};
use paper::groups::farthest_from_zero;
use paper::row;
use paper::table::{Table, percent};
use paper::{Failure, Report};

/// Scene and protocol in words.
pub(crate) fn what_was_run(protocol: &Protocol, seed: u64) -> String {
    let Protocol { width, replicas, equilibration, sweeps, mobility_sweeps, paper_sweeps } = protocol;
    let ours = format!(
        "T = {TEMPERATURE} exp(−βx), uniform field, N/A = {COLUMN_DENSITY}, box {HEIGHT} x {width} x {width}; {replicas} runs for \
        each β, from above and below, {equilibration} sweeps of equilibration and {sweeps} of production (twice as many from β = 0.03 on), then \
        {mobility_sweeps} sweeps of moves up to {MAXIMUM_DISPLACEMENT} for figure 15; seed {seed}"
    );
    match paper_sweeps {
        None => ours,
        Some(sweeps) => format!(
            "{ours}; protocol of the paper: one run from n = 0.1, {sweeps} sweeps of equilibration and of production, field from instantaneous \
            counts in bins of 0.1"
        ),
    }
}

/// One row per column.
pub(crate) fn table(ours: &[Outcome], papers: &[Outcome]) -> Table {
    let mut table = Table::new([
        "β",
        "h_c",
        "theory",
        "above − below",
        "x_m",
        "theory",
        "P β/n there",
        "|n/theory − 1|, %",
        "|P/(nTZ) − 1|, %",
        "top/ideal gas",
        "top/theory",
        "ideal-gas prefactor C",
        "n(0.5) of theory",
    ]);
    let missing = || "–".to_owned();
    for (outcome, method) in
        ours.iter().map(|outcome| (outcome, "")).chain(papers.iter().map(|outcome| (outcome, ", paper")))
    {
        let column = &outcome.column;
        let maximum = outcome.maximum;
        table.row(
            &format!("{}{method}", column.decay_rate),
            [
                outcome.center_of_mass.to_string(),
                format!("{:.3}", column.theory.center_of_mass()),
                outcome.difference_of_sides.map_or_else(missing, |difference| difference.to_string()),
                maximum.map_or_else(missing, |maximum| maximum.height.to_string()),
                column.maximum().map_or_else(missing, |height| format!("{height:.2}")),
                maximum.map_or_else(missing, |maximum| maximum.balance.to_string()),
                percent(farthest_from_zero(outcome.densities.iter().copied())),
                percent(farthest_from_zero(outcome.deviations.iter().copied())),
                outcome.dilute[0].to_string(),
                outcome.dilute[1].to_string(),
                format!("{:.3e}", column.prefactor),
                format!("{:.4}", column.theory.number_density(0.5)),
            ],
        );
    }
    table
}

/// The data of each figure; the paper's protocol has a file of its own.
pub(crate) fn write(ours: &[Outcome], papers: &[Outcome], report: &Report) -> Result<(), Failure> {
    for (outcomes, method) in [(ours, ""), (papers, "_paper")] {
        if outcomes.is_empty() {
            continue;
        }
        let densities = || {
            outcomes.iter().flat_map(|outcome| {
                outcome.rows.iter().map(|row| {
                    let height = row.height();
                    row![
                        outcome.column.decay_rate,
                        height,
                        row.number_density,
                        outcome.column.theory.number_density(height),
                        outcome.column.ideal_gas(height),
                    ]
                })
            })
        };
        for figure in ["figure_14a", "figure_14b"] {
            report.table(&format!("{figure}{method}"),
                "height in d, number densities in d^-3; theory between walls, modified Kolafa; ideal_gas with the prefactor of the \
                 chemical potential",
                "decay_rate, height, number_density, number_density_error, theory, ideal_gas",
                densities(),
            )?;
        }
        report.table(
            &format!("figure_15{method}"),
            "lengths in d; moves per sphere and sweep",
            "decay_rate, height, mean_accepted_displacement, mean_accepted_displacement_error, \
             accepted_per_sweep, packing_fraction_of_theory",
            outcomes.iter().flat_map(|outcome| {
                let theory = &outcome.column.theory;
                outcome.mobility.iter().filter(|point| point.mean_displacement.mean.is_finite()).map(
                    |point| {
                        row![
                            outcome.column.decay_rate,
                            point.height,
                            point.mean_displacement,
                            point.accepted_per_sweep.mean,
                            theory.packing_fraction(point.height),
                        ]
                    },
                )
            }),
        )?;
        report.table(
            &format!("figure_16{method}"),
            "height in d; pressure over temperature in d^-3",
            "decay_rate, height, packing_fraction, packing_fraction_error, \
             pressure_over_temperature, pressure_over_temperature_error",
            outcomes.iter().flat_map(|outcome| {
                outcome.states.iter().map(|row| {
                    let eta = row.packing_fraction();
                    let ratio = row.pressure_over_temperature;
                    row![outcome.column.decay_rate, row.height(), eta, ratio,]
                })
            }),
        )?;
    }
    Ok(())
}
