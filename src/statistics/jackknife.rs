//! Errors of functions of means.

use super::Estimate;
use super::memory::{self, Correlation, Memory, Pooled};
use nalgebra::{DMatrix, DVector};

/// Values of functions of the means of all observations, and of all but one block.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Jackknife {
    values: Vec<f64>,
    /// Values without one block, by replica and block.
    without: Vec<Vec<Vec<f64>>>,
    /// Fraction of the observations that are in complete blocks.
    share: f64,
}

impl Jackknife {
    pub(super) fn new(values: Vec<f64>, without: Vec<Vec<Vec<f64>>>, share: f64) -> Self {
        Self { values, without, share }
    }

    /// The functions of the means of all observations.
    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }

    /// Covariances of functions of these values: the errors are those of
    /// [`estimates`](Self::estimates), the correlations those of the pseudovalues of single blocks.
    pub(crate) fn covariance<R: AsRef<[f64]>>(&self, mut function: impl FnMut(&[f64]) -> R) -> DMatrix<f64> {
        let center = function(&self.values).as_ref().to_vec();
        let estimates = self.estimates(&mut function);
        let mut products = DMatrix::zeros(center.len(), center.len());
        for block in self.without.iter().flatten() {
            let mut distance = DVector::from_column_slice(function(block).as_ref());
            distance -= DVector::from_column_slice(&center);
            products += &distance * distance.transpose();
        }
        DMatrix::from_fn(center.len(), center.len(), |row, column| {
            let correlation =
                products[(row, column)] / (products[(row, row)] * products[(column, column)]).sqrt();
            correlation * estimates[row].standard_error * estimates[column].standard_error
        })
    }

    /// Functions of these values, with errors. `function` must always return the same number of
    /// values; missing values are treated as NaN.
    pub(crate) fn estimates<R: AsRef<[f64]>>(&self, function: impl FnMut(&[f64]) -> R) -> Vec<Estimate> {
        self.estimates_of_rows(&[], function)
    }

    /// [`estimates`](Self::estimates) for values in rows, in which neighbors have similar
    /// autocorrelation times.
    pub(super) fn estimates_of_rows<R: AsRef<[f64]>>(
        &self,
        reaches: &[usize],
        mut function: impl FnMut(&[f64]) -> R,
    ) -> Vec<Estimate> {
        let values = function(&self.values).as_ref().to_vec();
        let others = self.without.iter().map(Vec::len).sum::<usize>() as f64 - 1.0;
        // Pseudovalues, by value and replica: (n − 1) times the value without the block.
        let mut said = vec![vec![Vec::new(); self.without.len()]; values.len()];
        for (replica, blocks) in self.without.iter().enumerate() {
            for block in blocks {
                let without = function(block);
                let without = without.as_ref().iter().copied().chain(std::iter::repeat(f64::NAN));
                for ((of_value, value), without) in said.iter_mut().zip(&values).zip(without) {
                    of_value[replica].push(others * (value - without));
                }
            }
        }
        let estimates = values.iter().zip(errors(&said, reaches, self.share));
        estimates.map(|(&value, error)| Estimate::new(value, error.standard_error)).collect()
    }
}

/// The errors of the means of all observations, from complete blocks, which hold a fraction `share`
/// of them.
pub(super) fn errors(series: &[Vec<Vec<f64>>], reaches: &[usize], share: f64) -> Vec<Pooled> {
    let correlations: Vec<Correlation> = series.iter().map(|replicas| correlation(replicas)).collect();
    let row = (series.len() / reaches.len().max(1)).max(1);
    let pooled = series.iter().enumerate().map(|(index, replicas)| {
        let reach = reaches.get(index / row).copied().unwrap_or(0);
        let first = index / row * row;
        let last = (first + row).min(series.len());
        // The component itself is the first.
        let alike = [index]
            .into_iter()
            .chain(index.saturating_sub(reach).max(first)..index)
            .chain(index + 1..(index + reach + 1).min(last));
        let alike: Vec<&Correlation> = alike.map(|other| &correlations[other]).collect();
        let replicas: Vec<&[f64]> = replicas.iter().map(|replica| &replica[..]).collect();
        let pooled = memory::pooled(&replicas, &correlations[index], &Memory::of(&alike));
        Pooled { standard_error: pooled.standard_error * share.sqrt(), ..pooled }
    });
    pooled.collect()
}

/// Correlation of blocks with later blocks of the same replica.
pub(super) fn correlation(replicas: &[Vec<f64>]) -> Correlation {
    Correlation::of(&replicas.iter().map(|replica| &replica[..]).collect::<Vec<_>>())
}
