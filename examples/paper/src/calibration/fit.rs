//! From the calibration files to the constants of `src/model/constants.rs`.

use super::data::{Base, ColumnRow, Plan, Seeds};
use std::fmt::Write;

/// Leading coefficient of the layers, exact: (7/32)(6/π) η².
const LEADING: f64 = 21.0 / (16.0 * std::f64::consts::PI);
/// Part of the sweeps of a plan that equilibrate.
const EQUILIBRATION: f64 = 0.25;
/// A column tells of an error that is this much above its noise.
const RESOLVED: f64 = 3.0;
/// Bases narrower than this are not recommended, and not fitted to.
const NARROWEST: f64 = 4.0;
/// Extents of columns that have a bulk above the layers.
const TALL: f64 = 8.0;
/// Plans of which the time to set them up is a small part.
const LONG: f64 = 500.0;
/// Most sweeps that the theory start may count for.
const LARGEST_HEAD_START: u32 = 1000;

/// The constants, as the library has them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constants {
    pub layers: [f64; 4],
    pub layers_scatter: f64,
    pub bulk: f64,
    pub allowance: f64,
    pub finite_base: f64,
    pub ideal_cost: [f64; 2],
    pub theory_cost: [f64; 2],
    pub start_cost: [f64; 2],
    pub inefficiency: [[f64; 4]; 2],
    pub head_start: [f64; 2],
    pub plan_allowance: [f64; 2],
    pub seed_scatter: [f64; 2],
    pub sweep_cost: [[f64; 2]; 2],
}

/// How well the constants describe what they were fitted to: root mean squares of ln(measured/expected).
#[derive(Debug, Clone, Copy)]
pub struct Quality {
    pub formulas: f64,
    pub plans: [f64; 2],
}

/// The fit.
pub fn fit(columns: &[ColumnRow], plans: &[Plan], bases: &[Base], seeds: &[Seeds]) -> (Constants, Quality) {
    let (layers, layers_scatter) = fit_layers(columns);
    let bulk = fit_bulk(columns, plans);
    let formulas = scatter_of_formulas(columns, layers, layers_scatter, bulk);
    let fits = [0.0, 1.0].map(|family| fit_inefficiency(columns, plans, family));
    let start_cost = [false, true].map(|varies| {
        let of_kind = columns.iter().filter(|row| (row.decay_rate != 0.0) == varies);
        let logarithms: Vec<f64> =
            of_kind.map(|row| libm::log(row.start_seconds / row.theory_seconds)).collect();
        libm::exp(logarithms.iter().sum::<f64>() / logarithms.len() as f64)
    });
    let constants = Constants {
        layers,
        layers_scatter,
        bulk,
        // Two standard deviations.
        allowance: libm::exp(2.0 * formulas),
        finite_base: fit_bases(bases),
        ideal_cost: power_law(columns, |row| row.ideal_seconds),
        theory_cost: power_law(columns, |row| row.theory_seconds),
        start_cost,
        inefficiency: fits.map(|(coefficients, ..)| coefficients),
        head_start: fits.map(|(_, head_start, _)| head_start),
        // One standard deviation; what a single seed adds comes on top.
        seed_scatter: [0.0, 1.0].map(|family| fit_seed_scatter(seeds, family)),
        plan_allowance: fits.map(|(.., scatter)| libm::exp(scatter)),
        sweep_cost: [0.0, 1.0].map(|family| fit_sweep_cost(columns, plans, family)),
    };
    (constants, Quality { formulas, plans: fits.map(|(.., scatter)| scatter) })
}

/// B(η)/η² = LEADING + b₁η + b₂η² + b₃η³, weighted with the errors and a scatter of a few hundredths; and the scatter that is left.
fn fit_layers(columns: &[ColumnRow]) -> ([f64; 4], f64) {
    const SCATTER: f64 = 0.03;
    let rows: Vec<([f64; 3], f64, f64)> = columns
        .iter()
        .map(|row| {
            let eta = row.packing_fraction;
            let error = row.layers_error / (eta * eta);
            let weight = 1.0 / (error * error + SCATTER * SCATTER);
            ([eta, eta * eta, eta * eta * eta], row.layers / (eta * eta) - LEADING, weight)
        })
        .collect();
    let [first, second, third] = least_squares(&rows);
    let polynomial = [LEADING, first, second, third];
    let (mut squares, mut weights) = (0.0, 0.0);
    for ((powers, value, weight), row) in rows.iter().zip(columns) {
        let fitted = first * powers[0] + second * powers[1] + third * powers[2];
        let error = row.layers_error / (row.packing_fraction * row.packing_fraction);
        squares += weight * ((value - fitted) * (value - fitted) - error * error);
        weights += weight;
    }
    // One standard error more, since the mean square in excess of the errors may come out as nothing.
    let error = (2.0 * rows.len() as f64).sqrt() / weights;
    (polynomial, ((squares / weights).max(0.0) + error).sqrt())
}

/// Total variation distance above the layers in units of that of the ideal gas: the mean square in excess of noise, and one standard error more.
fn fit_bulk(columns: &[ColumnRow], plans: &[Plan]) -> f64 {
    let (mut sum, mut weights) = (0.0, 0.0);
    for (column, row) in columns.iter().enumerate() {
        // Flat columns have next to nothing above the layers.
        let is_tall =
            plans.iter().any(|plan| (plan.column - column as f64).abs() < 0.5 && plan.extent > TALL);
        if !is_tall {
            continue;
        }
        let unit = row.excluded_volume * row.excluded_volume;
        // The square of a sum of absolute values scatters by less than itself.
        let error = row.bulk_noise * row.bulk_noise / unit;
        sum += (row.bulk * row.bulk / unit - error) / (error * error);
        weights += 1.0 / (error * error);
    }
    ((sum / weights).max(0.0) + 1.0 / weights.sqrt()).sqrt()
}

/// What the library expects of the theory, and of the ideal gas.
fn expected(row: &ColumnRow, layers: [f64; 4], scatter: f64, bulk: f64) -> [f64; 2] {
    let eta = row.packing_fraction;
    let polynomial = layers.iter().rev().fold(0.0, |sum, coefficient| sum * eta + coefficient);
    let theory =
        (eta * eta * polynomial.hypot(scatter) / row.column_density).hypot(bulk * row.excluded_volume);
    [row.excluded_volume.hypot(theory), theory]
}

/// Root mean square of ln(measured/expected) over ideal gas and theory, where it can be told from noise.
fn scatter_of_formulas(columns: &[ColumnRow], layers: [f64; 4], scatter: f64, bulk: f64) -> f64 {
    let mut squares = Vec::new();
    for row in columns {
        let pairs = [row.ideal_error, row.theory_error].into_iter().zip(expected(row, layers, scatter, bulk));
        for (measured, expected) in pairs.filter(|(measured, _)| *measured > RESOLVED * row.noise) {
            let measured = (measured * measured - row.noise * row.noise).sqrt();
            let logarithm = libm::log(measured / expected);
            squares.push(logarithm * logarithm);
        }
    }
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

/// ln g = a + b η + c ln h + d [T varies], and the sweeps that the theory start counts for; with the scatter of ln error.
fn fit_inefficiency(columns: &[ColumnRow], plans: &[Plan], family: f64) -> ([f64; 4], f64, f64) {
    let mut best: Option<([f64; 4], f64, f64)> = None;
    for sweeps in 0..=LARGEST_HEAD_START {
        let head_start = f64::from(sweeps);
        let rows: Vec<([f64; 4], f64, f64)> = plans
            .iter()
            .filter(|plan| plan.is_of(family))
            .map(|plan| {
                let square = (plan.error * plan.error - plan.noise * plan.noise).max(0.0);
                let counted = (1.0 - EQUILIBRATION) * plan.sweeps * plan.particles;
                // ½ √(2/π) Σ √(p(1 − p)/samples), squared
                let independent = plan.spread * plan.spread / (2.0 * std::f64::consts::PI * counted);
                let value = libm::log(square / independent * (1.0 + head_start / plan.sweeps));
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                let varies = f64::from(u8::from(columns[plan.column as usize].decay_rate != 0.0));
                ([1.0, plan.densest, libm::log(plan.extent), varies], value, 1.0)
            })
            .filter(|(_, value, _)| value.is_finite())
            .collect();
        let coefficients = least_squares(&rows);
        let squares: f64 = rows
            .iter()
            .map(|(features, value, _)| {
                let fitted: f64 =
                    features.iter().zip(coefficients).map(|(feature, factor)| feature * factor).sum();
                (value - fitted) * (value - fitted)
            })
            .sum();
        // g is a square.
        let scatter = 0.5 * (squares / rows.len() as f64).sqrt();
        if best.is_none_or(|(.., least)| scatter < least) {
            best = Some((coefficients, head_start, scatter));
        }
    }
    best.unwrap_or(([0.0; 4], 0.0, 0.0))
}

/// Root mean square of the relative scatter of seeds.
fn fit_seed_scatter(seeds: &[Seeds], family: f64) -> f64 {
    let squares: Vec<f64> = seeds
        .iter()
        .filter(|row| (row.family - family).abs() < 0.5)
        .map(|row| row.scatter * row.scatter)
        .collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

/// Error of a base in units of that of the ideal gas over the number of spheres.
fn fit_bases(bases: &[Base]) -> f64 {
    let (mut above, mut below) = (0.0, 0.0);
    for base in bases.iter().filter(|base| base.side >= NARROWEST) {
        let unit = base.excluded_volume / base.particles;
        let square = base.error * base.error - base.noise * base.noise;
        let weight = 1.0 / (base.noise * base.noise * base.noise * base.noise);
        above += weight * square * unit * unit;
        below += weight * unit * unit * unit * unit;
    }
    (above / below).max(0.0).sqrt()
}

/// CPU seconds per sphere and sweep, linear in the packing fraction where it is densest; relative deviations count.
fn fit_sweep_cost(columns: &[ColumnRow], plans: &[Plan], family: f64) -> [f64; 2] {
    let rows: Vec<([f64; 2], f64, f64)> = plans
        .iter()
        .filter(|plan| plan.is_of(family) && plan.sweeps > LONG)
        .map(|plan| {
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let start = columns[plan.column as usize].start_seconds;
            let cost = (plan.seconds - start) / (plan.sweeps * plan.particles);
            ([1.0, plan.densest], cost, 1.0 / (cost * cost))
        })
        .collect();
    least_squares(&rows)
}

/// Factor and power of the height of the slab.
fn power_law(columns: &[ColumnRow], of: impl Fn(&ColumnRow) -> f64) -> [f64; 2] {
    let rows: Vec<([f64; 2], f64, f64)> =
        columns.iter().map(|row| ([1.0, libm::log(row.height)], libm::log(of(row)), 1.0)).collect();
    let [logarithm, power] = least_squares(&rows);
    [libm::exp(logarithm), power]
}

/// Weighted linear least squares by the normal equations: rows of features, value and weight.
fn least_squares<const N: usize>(rows: &[([f64; N], f64, f64)]) -> [f64; N] {
    let mut matrix = [[0.0; N]; N];
    let mut right = [0.0; N];
    for (features, value, weight) in rows {
        for i in 0..N {
            right[i] += weight * features[i] * value;
            for j in 0..N {
                matrix[i][j] += weight * features[i] * features[j];
            }
        }
    }
    // Gauss, with the largest pivot.
    for pivot in 0..N {
        let largest = (pivot..N).max_by(|&a, &b| matrix[a][pivot].abs().total_cmp(&matrix[b][pivot].abs()));
        let largest = largest.unwrap_or(pivot);
        matrix.swap(pivot, largest);
        right.swap(pivot, largest);
        for row in pivot + 1..N {
            let factor = matrix[row][pivot] / matrix[pivot][pivot];
            let (upper, lower) = matrix.split_at_mut(row);
            for (value, above) in lower[0].iter_mut().zip(upper[pivot]).skip(pivot) {
                *value -= factor * above;
            }
            right[row] -= factor * right[pivot];
        }
    }
    let mut solution = [0.0; N];
    for row in (0..N).rev() {
        let known: f64 = (row + 1..N).map(|column| matrix[row][column] * solution[column]).sum();
        solution[row] = (right[row] - known) / matrix[row][row];
    }
    solution
}

impl Constants {
    /// The file `src/model/constants.rs`.
    pub fn source(&self) -> String {
        let mut text = String::from(
            "//! Fitted to `examples/paper/calibration/` and written by `cargo run --release -p paper --bin calibrate_models`; a test in\n\
             //! `examples/paper/tests/model_for.rs` fits them again. Not to be edited.\n\n\
             #![allow(clippy::unreadable_literal, reason = \"generated\")]\n",
        );
        let mut constant = |documentation: &str, name: &str, kind: &str, value: String| {
            // Writing to a string does not fail.
            let _ = write!(text, "\n/// {documentation}\npub(crate) const {name}: {kind} = {value};\n");
        };
        let list = |values: &[f64]| {
            format!("[{}]", values.iter().map(|value| number(*value)).collect::<Vec<_>>().join(", "))
        };
        let table = |rows: &[Vec<f64>]| {
            format!("[{}]", rows.iter().map(|row| list(row)).collect::<Vec<_>>().join(", "))
        };
        let rows = |values: &[[f64; 4]; 2]| table(&values.map(|row| row.to_vec()));
        constant("Coefficients of B(η)/η², a polynomial in η.", "LAYERS", "[f64; 4]", list(&self.layers));
        constant("What that misses of B/η².", "LAYERS_SCATTER", "f64", number(self.layers_scatter));
        constant(
            "Total variation distance above the layers, in units of that of the ideal gas.",
            "BULK",
            "f64",
            number(self.bulk),
        );
        constant(
            "Factor by which ideal gas or theory may be worse than expected.",
            "ALLOWANCE",
            "f64",
            number(self.allowance),
        );
        constant(
            "Total variation distance by a finite base, in units of that of the ideal gas over the number of spheres.",
            "FINITE_BASE",
            "f64",
            number(self.finite_base),
        );
        constant(
            "CPU seconds of the ideal gas: factor and power of the height.",
            "IDEAL_COST",
            "[f64; 2]",
            list(&self.ideal_cost),
        );
        constant(
            "CPU seconds of the theory: factor and power of the height.",
            "THEORY_COST",
            "[f64; 2]",
            list(&self.theory_cost),
        );
        constant(
            "CPU seconds to set up a run, in units of those of the theory: isothermal, and where T varies.",
            "START_COST",
            "[f64; 2]",
            list(&self.start_cost),
        );
        constant(
            "Variance of a run in units of that of as many independent spheres, for tuned local moves and event chains: logarithm, and its slopes with packing fraction, logarithm of the extent, and varying T.",
            "INEFFICIENCY",
            "[[f64; 4]; 2]",
            rows(&self.inefficiency),
        );
        constant(
            "Sweeps that the theory start counts for, for either family.",
            "HEAD_START",
            "[f64; 2]",
            list(&self.head_start),
        );
        constant(
            "Standard deviation of the noise of single seeds, in units of its root mean square, for either family.",
            "SEED_SCATTER",
            "[f64; 2]",
            list(&self.seed_scatter),
        );
        constant(
            "Factor by which the noise of a plan may be more than expected, for either family.",
            "PLAN_ALLOWANCE",
            "[f64; 2]",
            list(&self.plan_allowance),
        );
        constant(
            "CPU seconds per sphere and sweep for either family, and their slope with packing fraction.",
            "SWEEP_COST",
            "[[f64; 2]; 2]",
            table(&self.sweep_cost.map(|row| row.to_vec())),
        );
        text
    }
}

/// Five significant digits.
fn number(value: f64) -> String {
    let rounded: f64 = format!("{value:.4e}").parse().unwrap_or(value);
    if rounded != 0.0 && rounded.abs() < 1e-3 { format!("{rounded:e}") } else { format!("{rounded:?}") }
}

impl Plan {
    /// Whether its moves are those of a family: 0 tuned local moves, 1 event chains.
    fn is_of(&self, family: f64) -> bool {
        (self.family - family).abs() < 0.5
    }
}
