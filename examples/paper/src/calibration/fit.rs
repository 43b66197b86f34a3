//! From the calibration files to the constants of `gradient_mc::model`.

use super::adsorption::Rows;
use super::data::{Base, ColumnRow, Data, Formula, LayerRow, Moves, Plan};
use super::functional::Functional;
use super::scenes::Parameters;
use crate::Failure;
use crate::least_squares::least_squares;
use gradient_mc::model::constants::{self, Noise};
use gradient_mc::model::{Accuracy, MonteCarloPlan, Quantity};

/// Leading coefficient of the layers, exact: (7/32)(6/π) η².
const LEADING: f64 = 21.0 / (16.0 * std::f64::consts::PI);
/// An error is resolved if it exceeds the noise by this factor.
const RESOLVED: f64 = 3.0;
/// Bases narrower than this are not recommended, and not fitted to.
const NARROWEST: f64 = 4.0;
/// Extents of columns that have a bulk above the layers.
const TALL: f64 = 8.0;
/// Largest number of sweeps that the theory start may save.
const LARGEST_HEAD_START: u32 = 1000;

/// The constants, as the library has them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constants {
    pub layers: [f64; 4],
    pub layers_scatter: f64,
    pub layers_shape: [f64; 8],
    pub functional: [f64; 2],
    pub functional_shape: [f64; 8],
    pub functional_allowance: [f64; 3],
    pub adsorption: f64,
    pub functional_adsorption: [f64; 2],
    pub bulk: f64,
    pub allowance: [f64; 3],
    pub finite_base: f64,
    pub moves: [[f64; 2]; 2],
    pub noise: [[Noise; 2]; 3],
}

impl Constants {
    /// The constants in use.
    pub const USED: Self = Self {
        layers: constants::LAYERS,
        layers_scatter: constants::LAYERS_SCATTER,
        layers_shape: constants::LAYERS_SHAPE,
        functional: constants::FUNCTIONAL,
        functional_shape: constants::FUNCTIONAL_SHAPE,
        functional_allowance: constants::FUNCTIONAL_ALLOWANCE,
        adsorption: constants::ADSORPTION,
        functional_adsorption: constants::FUNCTIONAL_ADSORPTION,
        bulk: constants::BULK,
        allowance: constants::ALLOWANCE,
        finite_base: constants::FINITE_BASE,
        moves: constants::MOVES,
        noise: constants::NOISE,
    };

    /// All numbers in order.
    pub fn numbers(&self) -> Vec<f64> {
        let mut numbers = self.layers.to_vec();
        numbers.push(self.layers_scatter);
        numbers.extend(self.layers_shape);
        numbers.extend(self.functional);
        numbers.extend(self.functional_shape);
        numbers.extend(self.functional_allowance);
        numbers.push(self.adsorption);
        numbers.extend(self.functional_adsorption);
        numbers.push(self.bulk);
        numbers.extend(self.allowance);
        numbers.push(self.finite_base);
        numbers.extend(self.moves.as_flattened());
        for Noise { inefficiency, head_start, scatter, seeds } in self.noise.as_flattened() {
            numbers.extend(inefficiency);
            numbers.extend([head_start, scatter, seeds]);
        }
        numbers
    }
}

/// How well ideal gas and theory are described: root mean squares of ln(measured/expected) for n, P
/// and Z, and how many they are.
#[derive(Debug, Clone, Copy)]
pub struct Quality {
    pub formulas: [(f64, usize); 3],
}

/// Fits the constants. The allowances of the formulas are based on the estimates of the library with
/// the constants in use.
pub fn fit(data: &Data) -> Result<(Constants, Quality), Failure> {
    let (layers, layers_scatter) = fit_layers(&data.columns);
    let mut formulas = [(0.0, 0); 3];
    for (quantity, scatter) in formulas.iter_mut().enumerate() {
        *scatter = scatter_of_formulas(&data.formulas, quantity)?;
    }
    let noise = [0, 1, 2].map(|quantity| {
        [0, 1].map(|family| {
            let of_kind = |plan: &&Plan| is(plan.family, family) && is(plan.quantity, quantity);
            let plans: Vec<&Plan> = data.plans.iter().filter(of_kind).collect();
            fit_noise(&data.columns, &plans)
        })
    });
    let functional = Functional::fit(&data.columns, &data.layers)?;
    let rows = Rows::new(&data.formulas)?;
    let constants = Constants {
        functional: functional.amplitudes,
        functional_shape: functional.shape,
        functional_allowance: rows.allowances(),
        adsorption: rows.of_theory(),
        functional_adsorption: rows.of_functional(),
        layers,
        layers_scatter,
        layers_shape: fit_shape(&data.layers),
        bulk: fit_bulk(&data.columns, &data.plans),
        // Two standard deviations.
        allowance: formulas.map(|(scatter, _)| libm::exp(2.0 * scatter)),
        finite_base: fit_bases(&data.bases),
        moves: [0, 1].map(|family| fit_moves(&data.moves, family)),
        noise,
    };
    Ok((constants, Quality { formulas }))
}

/// Whether the field of a row is this index.
pub(super) fn is(field: f64, index: usize) -> bool {
    (field - index as f64).abs() < 0.5
}

/// The parts of the bins near a wall in the sum of |Δn|: the mean over columns, each in units of
/// its own, weighted with the errors.
fn fit_shape(layers: &[LayerRow]) -> [f64; 8] {
    let (mut sums, mut weights) = ([0.0; 8], [0.0; 8]);
    for column in layers.chunk_by(|one, next| is(one.column - next.column, 0)) {
        let unit = column.iter().map(|row| row.difference.abs()).sum::<f64>() * column[0].difference.signum();
        for (bin, row) in column.iter().enumerate() {
            let weight = unit * unit / (row.error * row.error);
            sums[bin] += weight * row.difference / unit;
            weights[bin] += weight;
        }
    }
    let mean: [f64; 8] = std::array::from_fn(|bin| sums[bin] / weights[bin]);
    let all: f64 = mean.iter().map(|part| part.abs()).sum();
    mean.map(|part| part / all)
}

/// B(η)/η² = LEADING + b₁η + b₂η² + b₃η³, weighted with the errors and a scatter of a few
/// hundredths; and the scatter that is left.
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

/// Total variation distance above the layers in units of that of the ideal gas: the mean square in
/// excess of noise, and one standard error more.
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

/// Root mean square of ln(measured/expected) over ideal gas and theory, where the error is
/// resolved, and the number of cases.
fn scatter_of_formulas(formulas: &[Formula], quantity: usize) -> Result<(f64, usize), Failure> {
    let mut squares = Vec::new();
    for (column, parameters) in Parameters::calibration().into_iter().enumerate() {
        let (particles, side) = Parameters::WIDE;
        let scene = parameters.scene(particles, side)?;
        let choice = scene.model_for(Accuracy::new(Quantity::ALL[quantity], 0.5)?)?;
        let of_kind = formulas
            .iter()
            .filter(|row| is(row.column, column) && is(row.quantity, quantity) && !is(row.formula, 2));
        for row in of_kind.filter(|row| row.error > RESOLVED * row.noise) {
            let measured = (row.error * row.error - row.noise * row.noise).sqrt();
            let expected = choice.candidates()[usize::from(is(row.formula, 1))].expected_error;
            let logarithm = libm::log(measured / expected);
            squares.push(logarithm * logarithm);
        }
    }
    Ok(((squares.iter().sum::<f64>() / squares.len() as f64).sqrt(), squares.len()))
}

/// ln g = a + b η + c ln h + d [T varies], the sweeps that the theory start counts for, the scatter
/// of ln error, and that of seeds.
fn fit_noise(columns: &[ColumnRow], plans: &[&Plan]) -> Noise {
    let mut best: Option<Noise> = None;
    for sweeps in 0..=LARGEST_HEAD_START {
        let head_start = f64::from(sweeps);
        let rows: Vec<([f64; 4], f64, f64)> = plans
            .iter()
            .map(|plan| {
                let square = (plan.error * plan.error - plan.noise * plan.noise).max(0.0);
                let counted = (1.0 - MonteCarloPlan::EQUILIBRATION) * plan.sweeps * plan.particles;
                let independent = plan.spread * plan.spread / counted;
                let value = libm::log(square / independent * (1.0 + head_start / plan.sweeps));
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                let varies = f64::from(u8::from(columns[plan.column as usize].decay_rate != 0.0));
                ([1.0, plan.densest, libm::log(plan.extent), varies], value, 1.0)
            })
            .filter(|(_, value, _)| value.is_finite())
            .collect();
        let inefficiency = least_squares(&rows);
        let squares: f64 = rows
            .iter()
            .map(|(features, value, _)| {
                let fitted: f64 =
                    features.iter().zip(inefficiency).map(|(feature, factor)| feature * factor).sum();
                (value - fitted) * (value - fitted)
            })
            .sum();
        // g is a square.
        let scatter = 0.5 * (squares / rows.len() as f64).sqrt();
        if best.is_none_or(|best| scatter < best.scatter) {
            best = Some(Noise { inefficiency, head_start, scatter, seeds: 0.0 });
        }
    }
    let squares: Vec<f64> =
        plans.iter().filter(|plan| plan.scatter > 0.0).map(|plan| plan.scatter * plan.scatter).collect();
    let seeds = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    let none = Noise { inefficiency: [0.0; 4], head_start: 0.0, scatter: 0.0, seeds };
    best.map_or(none, |best| Noise { seeds, ..best })
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

/// Trials and events per sphere and sweep, linear in the packing fraction where it is densest;
/// relative deviations count.
fn fit_moves(moves: &[Moves], family: usize) -> [f64; 2] {
    let rows: Vec<([f64; 2], f64, f64)> = moves
        .iter()
        .filter(|row| is(row.family, family))
        .map(|row| ([1.0, row.densest], row.moves, 1.0 / (row.moves * row.moves)))
        .collect();
    least_squares(&rows)
}
