//! Averages of vectors in bounded memory.

mod merge;
#[cfg(feature = "checkpoint")]
mod saved;

use super::memory::{self, Correlation, Memory, Pooled};
use super::{Estimate, MINIMUM_BLOCKS};
use crate::Error;
use nalgebra::{DMatrix, DVector};

/// Averages of vectors that arrive one by one, with errors of means and of functions of means.
///
/// Observations are summed into blocks of equal length. When [`MAXIMUM_BLOCKS`](Self::MAXIMUM_BLOCKS)
/// blocks are complete, neighbors are merged and the block length doubles; so after the first 64
/// observations there are always 64 to 127 complete blocks, and memory does not grow with the length of
/// the run.
///
/// # Errors of correlated data
/// The squared error of a mean of N numbers is σ² g/N · ν/(ν − 2), component by component. Here
/// g = 2τ, with τ = ½ + Σ ρ(k) the correlation time of the blocks, summed to the lag W ≥ 3 τ and
/// corrected for the mean that is subtracted (Madras and Sokal, doi:10.1007/BF01022990; Wolff,
/// doi:10.1016/S0010-4655(03)00467-3); g is at least 1. The variance so found is known as one with
/// ν = 2B/(2(2W + 1) + g) degrees of freedom is, with B blocks, and the last factor is what Student's
/// distribution of that many has more in variance than the normal one: errors from few independent
/// numbers are wider. The error is on average 9 to 20 % too large and scatters by some 20 %. From 10
/// independent numbers on the deviations from the truth are as large as the errors within some 10 %
/// for an exponential memory, and within a quarter for one of two times. Below, τ of a single series is
/// too uncertain: there the profiles take the mean of ρ over neighboring bins, which scatters less, and
/// are right within a quarter from some three independent configurations on (`docs/stability.md`).
///
/// Replicas that are merged keep their own means. If those scatter more than the blocks explain
/// (beyond the quantile 0.99 of χ²), the scatter is the error:
/// R/(R − 1) Σ wᵣ² (mᵣ − m)², with weights wᵣ that add up to 1.
///
/// ```
/// use gradient_mc::statistics::BlockAverages;
/// let mut averages = BlockAverages::new(2)?;
/// for i in 0..1000 {
///     let noise = f64::from(i * 7919 % 1009) / 1009.0 - 0.5;
///     averages.push(&[6.0 + noise, 2.0 + noise / 3.0])?;
/// }
/// // The noise cancels in the ratio, and the jackknife knows.
/// let ratio = averages.jackknife(|means| [means[0] / means[1]])?[0];
/// assert!((ratio.mean - 3.0).abs() < 1e-6 && ratio.standard_error < 1e-6);
/// assert!(averages.standard_errors()?[0] > 1e-3);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct BlockAverages {
    components: usize,
    block_length: u64,
    /// Sums over the complete blocks of this accumulator, block after block.
    sums: Vec<f64>,
    /// Sum over the incomplete block, and the observations in it.
    partial: Vec<f64>,
    partial_observations: u64,
    /// Sums over the complete blocks of replicas merged in, replica after replica.
    replica_sums: Vec<f64>,
    /// Number of blocks of each of those replicas.
    replica_blocks: Vec<usize>,
    /// What is left of the replicas beyond their complete blocks: it counts in the mean only.
    remainder: Vec<f64>,
    remainder_observations: u64,
}

impl BlockAverages {
    /// Complete blocks at which neighbors are merged.
    pub const MAXIMUM_BLOCKS: usize = 128;
    /// Largest number of components.
    pub const MAXIMUM_COMPONENTS: usize = 1 << 20;

    /// An accumulator of vectors with this many components.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] unless there are between 1 and 2²⁰ components.
    pub fn new(components: usize) -> Result<Self, Error> {
        if components == 0 || components > Self::MAXIMUM_COMPONENTS {
            return Err(Error::InvalidParameter {
                name: "number of components",
                value: components as f64,
                requirement: "it must be between 1 and 2^20",
            });
        }
        Ok(Self::of(components))
    }

    /// Averages of a number of components that is known to be right.
    pub(crate) fn of(components: usize) -> Self {
        Self {
            components,
            block_length: 1,
            sums: Vec::new(),
            partial: vec![0.0; components],
            partial_observations: 0,
            replica_sums: Vec::new(),
            replica_blocks: Vec::new(),
            remainder: vec![0.0; components],
            remainder_observations: 0,
        }
    }

    /// Number of components.
    #[must_use]
    pub fn components(&self) -> usize {
        self.components
    }

    fn require_components(&self, found: usize) -> Result<(), Error> {
        if found == self.components {
            return Ok(());
        }
        let requirement = "it must be the number that the accumulator was made for";
        Err(Error::InvalidParameter { name: "number of components", value: found as f64, requirement })
    }

    /// Adds one observation.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] for a vector of another length; nothing is added then.
    pub fn push(&mut self, observation: &[f64]) -> Result<(), Error> {
        self.require_components(observation.len())?;
        for (sum, value) in self.partial.iter_mut().zip(observation) {
            *sum += value;
        }
        self.partial_observations += 1;
        if self.partial_observations == self.block_length {
            self.sums.extend_from_slice(&self.partial);
            self.partial.fill(0.0);
            self.partial_observations = 0;
            if self.sums.len() == Self::MAXIMUM_BLOCKS * self.components {
                self.coarsen();
            }
        }
        Ok(())
    }

    /// Doubles the block length. An odd block of this accumulator goes on being filled, one of a
    /// replica joins the remainder.
    fn coarsen(&mut self) {
        let odd = merge_pairs(&mut self.sums, self.components);
        if !odd.is_empty() {
            add(&mut self.partial, &odd);
            self.partial_observations += self.block_length;
        }
        let mut coarse = Vec::with_capacity(self.replica_sums.len() / 2);
        let mut rest = &self.replica_sums[..];
        for blocks in &mut self.replica_blocks {
            let (replica, others) = rest.split_at(*blocks * self.components);
            rest = others;
            let mut replica = replica.to_vec();
            let odd = merge_pairs(&mut replica, self.components);
            if !odd.is_empty() {
                add(&mut self.remainder, &odd);
                self.remainder_observations += self.block_length;
            }
            coarse.append(&mut replica);
            *blocks /= 2;
        }
        self.replica_sums = coarse;
        self.block_length *= 2;
    }

    /// Observations added so far, those of merged replicas included.
    #[must_use]
    pub fn observations(&self) -> u64 {
        self.blocks().len() as u64 * self.block_length
            + self.partial_observations
            + self.remainder_observations
    }

    /// Observations in a block.
    #[must_use]
    pub fn block_length(&self) -> u64 {
        self.block_length
    }

    fn block_sums(&self) -> impl ExactSizeIterator<Item = &[f64]> + Clone {
        // Both are whole numbers of blocks; a chained iterator would not know its length.
        let replicas = self.replica_sums.len() / self.components;
        let blocks = replicas + self.sums.len() / self.components;
        (0..blocks).map(move |block| {
            let (sums, block) =
                if block < replicas { (&self.replica_sums, block) } else { (&self.sums, block - replicas) };
            &sums[block * self.components..(block + 1) * self.components]
        })
    }

    /// Means of the complete blocks: first those of merged replicas, then this accumulator's in the
    /// order of time.
    #[must_use]
    pub fn blocks(&self) -> impl ExactSizeIterator<Item = Vec<f64>> + Clone {
        let length = self.block_length as f64;
        self.block_sums().map(move |sums| sums.iter().map(|sum| sum / length).collect())
    }

    /// Mean of every component over all observations, those in the incomplete block included; NaN
    /// before the first.
    #[must_use]
    pub fn mean(&self) -> Vec<f64> {
        let mut means: Vec<f64> = self
            .partial
            .iter()
            .zip(&self.remainder)
            .map(|(partial, remainder)| partial + remainder)
            .collect();
        for block in self.block_sums() {
            add(&mut means, block);
        }
        let observations = self.observations() as f64;
        for mean in &mut means {
            *mean /= observations;
        }
        means
    }

    /// Standard error of every component of [`mean`](Self::mean); see the type for its statistics.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] below 16 complete blocks.
    pub fn standard_errors(&self) -> Result<Vec<f64>, Error> {
        self.standard_errors_of_rows(&[])
    }

    /// The same for components that are rows of equal lengths, one after the other, in which so many neighbors to either
    /// side share their memory, one number for each row.
    pub(crate) fn standard_errors_of_rows(&self, reaches: &[usize]) -> Result<Vec<f64>, Error> {
        let replicas = self.replicas()?;
        let series: Vec<_> = (0..self.components).map(|index| self.series(&replicas, index)).collect();
        Ok(self.errors(&series, reaches).into_iter().map(|pooled| pooled.standard_error).collect())
    }

    /// Means of component `index` in every block of every replica.
    fn series(&self, replicas: &[&[f64]], index: usize) -> Vec<Vec<f64>> {
        let length = self.block_length as f64;
        let of_replica =
            |sums: &&[f64]| sums.chunks_exact(self.components).map(|block| block[index] / length).collect();
        replicas.iter().map(of_replica).collect()
    }

    /// The errors of the means of all observations, of what complete blocks say, for every component.
    fn errors(&self, series: &[Vec<Vec<f64>>], reaches: &[usize]) -> Vec<Pooled> {
        let blocks = self.block_sums().len() as f64;
        errors(series, reaches, blocks * self.block_length as f64 / self.observations() as f64)
    }

    /// Components that have contradicting means in the replicas; none before there are 16 blocks.
    pub(crate) fn contradictions(&self) -> Vec<usize> {
        let Ok(replicas) = self.replicas() else { return Vec::new() };
        if replicas.len() < 2 {
            return Vec::new();
        }
        let series: Vec<_> = (0..self.components).map(|index| self.series(&replicas, index)).collect();
        let errors = self.errors(&series, &[]).into_iter().enumerate();
        errors.filter(|(_, pooled)| pooled.contradict).map(|(index, _)| index).collect()
    }

    /// Number of independent observations of some components taken together, within a replica: their
    /// correlations are averaged. NaN before there are 16 blocks.
    pub(crate) fn independent(&self, components: impl IntoIterator<Item = usize>) -> f64 {
        let Ok(replicas) = self.replicas() else { return f64::NAN };
        let series = components.into_iter().map(|index| self.series(&replicas, index));
        let correlations: Vec<Correlation> = series.map(|replicas| correlation(&replicas)).collect();
        let blocks = replicas.iter().map(|sums| sums.len() / self.components).sum::<usize>() as f64;
        Memory::of(&correlations.iter().collect::<Vec<_>>()).independent(blocks)
    }

    /// [`mean`](Self::mean) and [`standard_errors`](Self::standard_errors) together.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] below 16 complete blocks.
    pub fn estimates(&self) -> Result<Vec<Estimate>, Error> {
        self.estimates_of_rows(&[])
    }

    /// The same for components that are rows in which neighbors are alike, as in
    /// [`standard_errors_of_rows`](Self::standard_errors_of_rows).
    pub(crate) fn estimates_of_rows(&self, reaches: &[usize]) -> Result<Vec<Estimate>, Error> {
        let errors = self.standard_errors_of_rows(reaches)?;
        Ok(self.mean().into_iter().zip(errors).map(|(mean, error)| Estimate::new(mean, error)).collect())
    }

    /// Functions of the means, such as ratios, with errors by the jackknife over blocks: correlations
    /// between components and in time are accounted for, as in
    /// [`standard_errors`](Self::standard_errors).
    ///
    /// The value is `function` of the means of all observations. Its bias is of the order of the
    /// squared error, as that of any ratio of averages, and is not corrected. `function` is called
    /// once for every block, and must return the same number of values each time: it is as if values
    /// that are missing in any call were NaN.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] below 16 complete blocks.
    pub fn jackknife<R: AsRef<[f64]>>(
        &self,
        function: impl FnMut(&[f64]) -> R,
    ) -> Result<Vec<Estimate>, Error> {
        self.jackknife_of_rows(&[], function)
    }

    /// The same for values that are rows in which neighbors are alike, as in
    /// [`standard_errors_of_rows`](Self::standard_errors_of_rows).
    pub(crate) fn jackknife_of_rows<R: AsRef<[f64]>>(
        &self,
        reaches: &[usize],
        function: impl FnMut(&[f64]) -> R,
    ) -> Result<Vec<Estimate>, Error> {
        Ok(self.jackknifed(function)?.estimates_of_rows(reaches, <[f64]>::to_vec))
    }

    /// Values of `function`, of all and of all but every block, kept so that functions of them can be had later.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] below 16 complete blocks.
    pub(crate) fn jackknifed<R: AsRef<[f64]>>(
        &self,
        mut function: impl FnMut(&[f64]) -> R,
    ) -> Result<Jackknife, Error> {
        let replicas = self.replicas()?;
        let values = function(&self.mean()).as_ref().to_vec();
        let mut total = vec![0.0; self.components];
        for block in self.block_sums() {
            add(&mut total, block);
        }
        let blocks = self.block_sums().len() as f64;
        let length = self.block_length as f64;
        let mut means = vec![0.0; self.components];
        let mut without = Vec::with_capacity(replicas.len());
        for sums in replicas {
            let mut of_replica = Vec::new();
            for block in sums.chunks_exact(self.components) {
                for ((mean, total), sum) in means.iter_mut().zip(&total).zip(block) {
                    *mean = (total - sum) / ((blocks - 1.0) * length);
                }
                of_replica.push(function(&means).as_ref().to_vec());
            }
            without.push(of_replica);
        }
        Ok(Jackknife { values, without, share: blocks * length / self.observations() as f64 })
    }

    /// Sums over complete blocks of every replica that has any.
    fn replicas(&self) -> Result<Vec<&[f64]>, Error> {
        let blocks = self.block_sums().len();
        if blocks < MINIMUM_BLOCKS {
            let observations = self.observations();
            let saturated = |number: u64| usize::try_from(number).unwrap_or(usize::MAX);
            let needed = (MINIMUM_BLOCKS as u64 * self.block_length).max(observations + 1);
            return Err(Error::TooFewObservations {
                what: "observations for a standard error",
                available: saturated(observations),
                needed: saturated(needed),
            });
        }
        let mut rest = &self.replica_sums[..];
        let mut replicas = Vec::with_capacity(self.replica_blocks.len() + 1);
        for blocks in &self.replica_blocks {
            let (replica, others) = rest.split_at(blocks * self.components);
            replicas.push(replica);
            rest = others;
        }
        replicas.push(&self.sums[..]);
        replicas.retain(|replica| !replica.is_empty());
        Ok(replicas)
    }
}

/// The errors of the means of all observations, of which a `share` is in complete blocks, of what these say.
fn errors(series: &[Vec<Vec<f64>>], reaches: &[usize], share: f64) -> Vec<Pooled> {
    let correlations: Vec<Correlation> = series.iter().map(|replicas| correlation(replicas)).collect();
    let row = (series.len() / reaches.len().max(1)).max(1);
    let pooled = series.iter().enumerate().map(|(index, replicas)| {
        let reach = reaches.get(index / row).copied().unwrap_or(0);
        let first = index / row * row;
        let last = (first + row).min(series.len());
        // The component itself comes first.
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

/// Functions of the means of all observations, and of all but every block.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Jackknife {
    values: Vec<f64>,
    /// Replica by replica and block by block.
    without: Vec<Vec<Vec<f64>>>,
    /// Of the observations that are in complete blocks.
    share: f64,
}

impl Jackknife {
    /// The functions of the means of all observations.
    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }

    /// Covariances of functions of those functions: the errors are those of [`estimates`](Self::estimates), the correlations
    /// those of what single blocks say.
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

    /// Functions of those functions, with errors. `function` must return the same number of values each time: it is as if
    /// values that are missing in any call were NaN.
    pub(crate) fn estimates<R: AsRef<[f64]>>(&self, function: impl FnMut(&[f64]) -> R) -> Vec<Estimate> {
        self.estimates_of_rows(&[], function)
    }

    /// The same for values that are rows in which neighbors are alike.
    fn estimates_of_rows<R: AsRef<[f64]>>(
        &self,
        reaches: &[usize],
        mut function: impl FnMut(&[f64]) -> R,
    ) -> Vec<Estimate> {
        let values = function(&self.values).as_ref().to_vec();
        let others = self.without.iter().map(Vec::len).sum::<usize>() as f64 - 1.0;
        // What every block says, value by value and replica by replica: (n − 1) times the value without it.
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

/// Of blocks with later ones of the same replica.
fn correlation(replicas: &[Vec<f64>]) -> Correlation {
    Correlation::of(&replicas.iter().map(|replica| &replica[..]).collect::<Vec<_>>())
}

/// Replaces blocks by the sums of neighboring pairs, and returns the last block if it has no partner.
fn merge_pairs(sums: &mut Vec<f64>, components: usize) -> Vec<f64> {
    let pairs = sums.len() / components / 2;
    let odd = sums.split_off(2 * pairs * components);
    for pair in 0..pairs {
        for component in 0..components {
            let first = 2 * pair * components + component;
            sums[pair * components + component] = sums[first] + sums[first + components];
        }
    }
    sums.truncate(pairs * components);
    odd
}

fn add(sums: &mut [f64], values: &[f64]) {
    for (sum, value) in sums.iter_mut().zip(values) {
        *sum += value;
    }
}

#[cfg(test)]
mod tests;
