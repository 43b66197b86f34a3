//! What the layers of the density functional miss, from the bins near the base that were measured
//! for the theory.

use super::data::{ColumnRow, LayerRow};
use super::fit::is;
use super::scenes::Parameters;
use crate::Failure;
use gradient_mc::equation_of_state::ModifiedKolafa;
use gradient_mc::model::{CorrectedLayers, densities};

/// From this packing fraction on columns resolve what the functional misses.
pub(super) const DENSE: f64 = 0.35;

/// The constants.
#[derive(Debug, Clone, Copy)]
pub(super) struct Functional {
    /// Of η⁶ and of η².
    pub(super) amplitudes: [f64; 2],
    pub(super) shape: [f64; 8],
}

/// One column: its packing fraction at the base, and how far the functional is off in the bins
/// there, with errors.
struct Column {
    eta: f64,
    bins: Vec<[f64; 2]>,
}

impl Column {
    /// What is misplaced, without what noise alone would make of it, and its error.
    fn misplaced(&self) -> [f64; 2] {
        let excess =
            |[difference, error]: &[f64; 2]| (difference * difference - error * error).max(0.0).sqrt();
        let squares: f64 = self.bins.iter().map(|[_, error]| error * error).sum();
        [0.5 * self.bins.iter().map(excess).sum::<f64>(), 0.5 * squares.sqrt()]
    }

    fn sixth(&self) -> f64 {
        let square = self.eta * self.eta;
        square * square * square
    }
}

impl Functional {
    pub(super) fn fit(columns: &[ColumnRow], layers: &[LayerRow]) -> Result<Self, Failure> {
        let mut measured = Vec::new();
        for (column, (parameters, row)) in Parameters::calibration().into_iter().zip(columns).enumerate() {
            let (particles, side) = Parameters::WIDE;
            let scene = parameters.scene(particles, side)?;
            let theory = scene.hydrostatics(&ModifiedKolafa)?;
            let functional = CorrectedLayers::new(&scene, &theory)?.densities(&scene);
            let shift = functional
                .iter()
                .zip(densities(&scene, &theory))
                .map(|(functional, theory)| functional - theory);
            let rows = layers.iter().filter(|row| is(row.column, column));
            let bins = rows.zip(shift).map(|(row, shift)| [row.difference + shift, row.error]).collect();
            measured.push(Column { eta: row.packing_fraction, bins });
        }
        let dense = || measured.iter().filter(|column| column.eta > DENSE);
        let (mut above, mut below) = (0.0, 0.0);
        for column in dense() {
            let ([misplaced, error], sixth) = (column.misplaced(), column.sixth());
            above += misplaced * sixth / (error * error);
            below += sixth * sixth / (error * error);
        }
        let amplitude = above / below;
        // The rest in units of η⁴: its mean square, and one standard error more.
        let (mut above, mut below) = (0.0, 0.0);
        for column in measured.iter().filter(|column| column.eta <= DENSE) {
            let ([misplaced, error], sixth) = (column.misplaced(), column.sixth());
            let unit = column.eta * column.eta * column.eta * column.eta;
            let rest = misplaced * misplaced - amplitude * amplitude * sixth * sixth;
            let weight = unit * unit / (2.0 * error * error * error * error);
            above += weight * rest / unit;
            below += weight;
        }
        let unresolved = ((above / below).max(0.0) + 1.0 / below.sqrt()).sqrt();
        let (mut sums, mut weights) = ([0.0; 8], [0.0; 8]);
        for column in dense() {
            let sixth = column.sixth();
            for (bin, [difference, error]) in column.bins.iter().enumerate() {
                sums[bin] += sixth * difference / (error * error);
                weights[bin] += sixth * sixth / (error * error);
            }
        }
        let mean: [f64; 8] = std::array::from_fn(|bin| sums[bin] / weights[bin]);
        let all: f64 = mean.iter().map(|part| part.abs()).sum();
        Ok(Self { amplitudes: [amplitude, unresolved], shape: mean.map(|part| part / all) })
    }
}
