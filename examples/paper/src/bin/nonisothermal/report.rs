//! Tables and files.

use super::column::{COLUMN_DENSITY, HEIGHT, TEMPERATURE};
use super::outcome::Outcome;
use super::run::{MAXIMUM_DISPLACEMENT, Protocol};
use paper::captions::write_captions;
use paper::groups::farthest_from_zero;
use paper::table::{Table, percent};
use paper::{Failure, output};
use std::path::Path;

/// Scene and protocol in words.
pub(crate) fn what_was_run(protocol: &Protocol, seed: u64) -> String {
    let Protocol { width, replicas, equilibration, sweeps, mobility_sweeps, paper_sweeps } = protocol;
    let ours = format!(
        "T = {TEMPERATURE} exp(−βx), uniform field, N/A = {COLUMN_DENSITY}, box {HEIGHT} x {width} x {width}; ours: {replicas} runs for \
         each β, from above and below, {equilibration} sweeps discarded and {sweeps} measured (twice as many at β = 0.05), then \
         {mobility_sweeps} sweeps of moves up to {MAXIMUM_DISPLACEMENT} for figure 15; seed {seed}"
    );
    match paper_sweeps {
        None => ours,
        Some(sweeps) => format!(
            "{ours}; the paper's: one run from n = 0.1, {sweeps} sweeps discarded and measured, field from instantaneous bins of 0.1"
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
        "prefactor of the law",
        "n(0.5) of theory",
    ]);
    let missing = || "–".to_owned();
    for (outcome, method) in ours
        .iter()
        .map(|outcome| (outcome, ""))
        .chain(papers.iter().map(|outcome| (outcome, ", the paper's")))
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
pub(crate) fn write(ours: &[Outcome], papers: &[Outcome], directory: &Path) -> Result<(), Failure> {
    for (outcomes, method) in [(ours, ""), (papers, "_paper")] {
        if outcomes.is_empty() {
            continue;
        }
        let densities = || {
            outcomes.iter().flat_map(|outcome| {
                outcome.rows.iter().map(|row| {
                    let height = row.height();
                    [
                        outcome.column.decay_rate,
                        height,
                        row.number_density.mean,
                        row.number_density.standard_error,
                        outcome.column.theory.number_density(height),
                        outcome.column.ideal_gas(height),
                    ]
                })
            })
        };
        for figure in ["figure_14a", "figure_14b"] {
            output::write_csv(
                &directory.join(format!("{figure}{method}.csv")),
                "height in d, number densities in d^-3; theory between walls, modified Kolafa; ideal_gas with the prefactor of the \
                 chemical potential",
                ["decay_rate", "height", "number_density", "number_density_error", "theory", "ideal_gas"],
                densities(),
            )?;
        }
        output::write_csv(
            &directory.join(format!("figure_15{method}.csv")),
            "lengths in d; moves per sphere and sweep",
            [
                "decay_rate",
                "height",
                "mean_accepted_displacement",
                "mean_accepted_displacement_error",
                "accepted_per_sweep",
                "packing_fraction_of_theory",
            ],
            outcomes.iter().flat_map(|outcome| {
                let theory = &outcome.column.theory;
                outcome.mobility.iter().filter(|point| point.mean_displacement.mean.is_finite()).map(
                    |point| {
                        [
                            outcome.column.decay_rate,
                            point.height,
                            point.mean_displacement.mean,
                            point.mean_displacement.standard_error,
                            point.accepted_per_sweep.mean,
                            theory.packing_fraction(point.height),
                        ]
                    },
                )
            }),
        )?;
        output::write_csv(
            &directory.join(format!("figure_16{method}.csv")),
            "height in d; pressure over temperature in d^-3",
            [
                "decay_rate",
                "height",
                "packing_fraction",
                "packing_fraction_error",
                "pressure_over_temperature",
                "pressure_over_temperature_error",
            ],
            outcomes.iter().flat_map(|outcome| {
                outcome.states.iter().map(|row| {
                    let eta = row.packing_fraction();
                    let ratio = row.pressure_over_temperature;
                    [
                        outcome.column.decay_rate,
                        row.height(),
                        eta.mean,
                        eta.standard_error,
                        ratio.mean,
                        ratio.standard_error,
                    ]
                })
            }),
        )?;
    }
    Ok(())
}

/// What the pictures show.
pub(crate) fn captions(protocol: &Protocol, directory: &Path) -> Result<(), Failure> {
    let paper = if protocol.paper_sweeps.is_some() {
        " Open circles: the paper's own protocol, whose field follows every configuration."
    } else {
        ""
    };
    write_captions(
        directory,
        [
            (
                "figure_14a.png",
                format!(
                    "Number density against height, T = 20 exp(−βx). Points: simulation; lines: local theory between \
                     walls. From β = 0.02 on the column is densest inside, where P = n/β.{paper}"
                ),
            ),
            (
                "figure_14b.png",
                "The same on a logarithmic scale. Dashed: the ideal-gas law. What stands before it is set by the \
                 chemical potential of the column (C), not by the density at the base, with which the law would be off by a \
                 factor of more than a hundred."
                    .to_owned(),
            ),
            (
                "figure_15.png",
                "Mean accepted displacement of moves up to 0.75 d. Left against height, as in the paper: fluid \
                 everywhere. Right against packing fraction: one curve, so no part of any column is frozen or glassy."
                    .to_owned(),
            ),
            (
                "figure_16.png",
                format!(
                    "P/T against packing fraction, without the layers at the base (x < 8): one curve for all β, that \
                     of the equation of state. Below: the difference from modified Kolafa, in per cent, in ranges of height \
                     that hold equally many spheres.{paper}"
                ),
            ),
        ],
    )
}
