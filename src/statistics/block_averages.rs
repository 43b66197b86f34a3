//! Averages of vectors in bounded memory.

use super::jackknife::{Jackknife, correlation, errors};
use super::memory::{Correlation, Memory, Pooled};
use super::{Estimate, MINIMUM_BLOCKS};
use crate::{Error, Merge};

/// Averages of a sequence of vectors in bounded memory, with standard errors of means and of
/// functions of means.
///
/// Observations are summed into blocks of equal length. When
/// [`MAXIMUM_BLOCKS`](Self::MAXIMUM_BLOCKS) blocks are complete, neighbors are merged and the block
/// length doubles; so after the first 64 observations there are always 64 to 127 complete blocks,
/// and the memory does not grow with the length of the run.
///
/// # Errors of correlated data
/// The squared error of the mean of N numbers is σ² g/N · ν/(ν − 2) for each component. Here g =
/// 2τ, at least 1, and τ = ½ + Σ ρ(k) is the autocorrelation time of the blocks, summed up to the
/// lag W ≥ 3 τ and corrected for the subtracted mean (Madras and Sokal, doi:10.1007/BF01022990;
/// Wolff, doi:10.1016/S0010-4655(03)00467-3). The estimate of σ² g has ν = 2B/(2(2W + 1) + g)
/// degrees of freedom for B blocks. The factor ν/(ν − 2) is the variance of Student's distribution,
/// and widens errors from few independent numbers.
///
/// The error is on average 9 to 20 % too large and scatters by about 20 %. With 10 or more
/// independent numbers it agrees with the true deviations within about 10 % for an exponential
/// autocorrelation, and within a quarter for one with two times. With fewer, τ of a single series
/// is too uncertain. Profiles therefore average ρ over neighboring bins, and their errors are right
/// within a quarter from about three independent configurations on (`docs/stability.md`).
///
/// Merged replicas keep their own means. If these scatter significantly more than the errors from
/// blocks (above the quantile 0.99 of χ²), the squared error is that of the scatter: R/(R − 1) Σ
/// wᵣ² (mᵣ − m)², with weights wᵣ whose sum is 1.
///
/// ```
/// use gradient_mc::statistics::BlockAverages;
/// let mut averages = BlockAverages::new(2)?;
/// for i in 0..1000 {
///     let noise = f64::from(i * 7919 % 1009) / 1009.0 - 0.5;
///     averages.push(&[6.0 + noise, 2.0 + noise / 3.0])?;
/// }
/// // The noise cancels in the ratio; the jackknife error includes this.
/// let ratio = averages.jackknife(|means| [means[0] / means[1]])?[0];
/// assert!((ratio.mean - 3.0).abs() < 1e-6 && ratio.standard_error < 1e-6);
/// assert!(averages.standard_errors()?[0] > 1e-3);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct BlockAverages {
    components: usize,
    block_length: u64,
    /// Sums over the complete blocks of this accumulator.
    sums: Vec<f64>,
    /// Sum over the incomplete block; below, its number of observations.
    partial: Vec<f64>,
    partial_observations: u64,
    /// Sums over the complete blocks of merged replicas.
    replica_sums: Vec<f64>,
    /// Number of blocks of each merged replica.
    replica_blocks: Vec<usize>,
    /// Sum over the incomplete blocks of merged replicas, used in the mean only.
    remainder: Vec<f64>,
    remainder_observations: u64,
    /// The kind of data and the estimate, for error messages.
    what: &'static str,
}

impl BlockAverages {
    /// Number of complete blocks at which neighbors are merged.
    pub const MAXIMUM_BLOCKS: usize = 128;
    /// Largest number of components.
    pub const MAXIMUM_COMPONENTS: usize = 1 << 20;

    /// Makes an empty accumulator of vectors with this number of components.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] if the number of components is not between 1 and 2²⁰.
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

    /// [`new`](Self::new) for a valid number of components.
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
            what: "observations for a standard error",
        }
    }

    /// Sets the text of the error for too few observations.
    pub(crate) fn said_of(self, what: &'static str) -> Self {
        Self { what, ..self }
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
        let requirement = "it must be that of the accumulator";
        Err(Error::InvalidParameter { name: "number of components", value: found as f64, requirement })
    }

    /// Adds one observation.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] if the vector has another length; nothing is added then.
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

    /// Doubles the block length. An odd last block of this accumulator becomes the incomplete
    /// block; that of a replica is added to the remainder.
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

    /// Averages, over blocks twice as long, of a function of the means of both halves of a block.
    /// The function writes `components` values. What is not half of a complete block is given
    /// twice.
    pub(crate) fn of_halves(&self, components: usize, function: impl Fn([&[f64]; 2], &mut [f64])) -> Self {
        // The values of two halves that are sums over this number of observations each.
        let values = |halves: [&[f64]; 2], observations: f64| {
            let [first, second] =
                halves.map(|sums| sums.iter().map(|sum| sum / observations).collect::<Vec<_>>());
            let mut values = vec![0.0; components];
            function([&first, &second], &mut values);
            values
        };
        let length = self.block_length as f64;
        let blocks = |sums: &[f64]| -> Vec<f64> {
            let halves = sums.chunks_exact(2 * self.components).map(|both| both.split_at(self.components));
            let values = halves.flat_map(|(first, second)| values([first, second], length));
            values.map(|value| 2.0 * length * value).collect()
        };
        let rest = |sums: &[f64], observations: u64| -> Vec<f64> {
            if observations == 0 {
                return vec![0.0; components];
            }
            let observations = observations as f64;
            values([sums, sums], observations).into_iter().map(|value| observations * value).collect()
        };
        let mut coarse = self.clone();
        coarse.coarsen();
        let mut replica_sums = Vec::new();
        let mut others = &self.replica_sums[..];
        for &count in &self.replica_blocks {
            let (replica, rest) = others.split_at(count * self.components);
            replica_sums.extend(blocks(replica));
            others = rest;
        }
        Self {
            components,
            sums: blocks(&self.sums),
            partial: rest(&coarse.partial, coarse.partial_observations),
            replica_sums,
            remainder: rest(&coarse.remainder, coarse.remainder_observations),
            ..coarse
        }
    }

    /// Number of observations so far, including merged replicas.
    #[must_use]
    pub fn observations(&self) -> u64 {
        self.blocks().len() as u64 * self.block_length
            + self.partial_observations
            + self.remainder_observations
    }

    /// Number of observations in a block.
    #[must_use]
    pub fn block_length(&self) -> u64 {
        self.block_length
    }

    fn block_sums(&self) -> impl ExactSizeIterator<Item = &[f64]> + Clone {
        // Both are whole numbers of blocks; a chained iterator has no exact length.
        let replicas = self.replica_sums.len() / self.components;
        let blocks = replicas + self.sums.len() / self.components;
        (0..blocks).map(move |block| {
            let (sums, block) =
                if block < replicas { (&self.replica_sums, block) } else { (&self.sums, block - replicas) };
            &sums[block * self.components..(block + 1) * self.components]
        })
    }

    /// Means of the complete blocks: first those of merged replicas, then those of this accumulator
    /// in the order of time.
    #[must_use]
    pub fn blocks(&self) -> impl ExactSizeIterator<Item = Vec<f64>> + Clone {
        let length = self.block_length as f64;
        self.block_sums().map(move |sums| sums.iter().map(|sum| sum / length).collect())
    }

    /// Mean of every component over all observations, including the incomplete block; NaN before
    /// the first observation.
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

    /// Standard error of every component of [`mean`](Self::mean); see the type for the method.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] for fewer than 16 complete blocks.
    pub fn standard_errors(&self) -> Result<Vec<f64>, Error> {
        self.standard_errors_of_rows(&[])
    }

    /// [`standard_errors`](Self::standard_errors) for components in rows of equal lengths.
    /// `reaches` is, for each row, the number of neighbors on either side with a common
    /// autocorrelation time.
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

    /// The errors of the means of all observations, from complete blocks, for every component.
    fn errors(&self, series: &[Vec<Vec<f64>>], reaches: &[usize]) -> Vec<Pooled> {
        let blocks = self.block_sums().len() as f64;
        errors(series, reaches, blocks * self.block_length as f64 / self.observations() as f64)
    }

    /// Components whose means disagree between replicas; empty for fewer than 16 blocks.
    pub(crate) fn contradictions(&self) -> Vec<usize> {
        let Ok(replicas) = self.replicas() else { return Vec::new() };
        if replicas.len() < 2 {
            return Vec::new();
        }
        let series: Vec<_> = (0..self.components).map(|index| self.series(&replicas, index)).collect();
        let errors = self.errors(&series, &[]).into_iter().enumerate();
        errors.filter(|(_, pooled)| pooled.contradict).map(|(index, _)| index).collect()
    }

    /// Effective number of independent observations within a replica, from the averaged
    /// correlations of some components; NaN for fewer than 16 blocks.
    pub(crate) fn independent(&self, components: impl IntoIterator<Item = usize>) -> f64 {
        let Ok(replicas) = self.replicas() else { return f64::NAN };
        let series = components.into_iter().map(|index| self.series(&replicas, index));
        let correlations: Vec<Correlation> = series.map(|replicas| correlation(&replicas)).collect();
        let blocks = replicas.iter().map(|sums| sums.len() / self.components).sum::<usize>() as f64;
        Memory::of(&correlations.iter().collect::<Vec<_>>()).independent(blocks)
    }

    /// [`mean`](Self::mean) and [`standard_errors`](Self::standard_errors) of every component.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] for fewer than 16 complete blocks.
    pub fn estimates(&self) -> Result<Vec<Estimate>, Error> {
        self.estimates_of_rows(&[])
    }

    /// The same for components that are rows in which neighbors are alike, as in
    /// [`standard_errors_of_rows`](Self::standard_errors_of_rows).
    pub(crate) fn estimates_of_rows(&self, reaches: &[usize]) -> Result<Vec<Estimate>, Error> {
        let errors = self.standard_errors_of_rows(reaches)?;
        Ok(self.mean().into_iter().zip(errors).map(|(mean, error)| Estimate::new(mean, error)).collect())
    }

    /// Values of a `function` of the means, such as ratios, with errors by the jackknife over
    /// blocks. They include correlations between components and in time, as in
    /// [`standard_errors`](Self::standard_errors).
    ///
    /// The values are those for the means of all observations. Their bias, of the order of the
    /// squared error, is not corrected. `function` is called once for every block and must always
    /// return the same number of values; missing values are treated as NaN.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] for fewer than 16 complete blocks.
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

    /// Values of `function` for all blocks and for all but one block, from which functions of them
    /// are computed later.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] for fewer than 16 complete blocks.
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
        Ok(Jackknife::new(values, without, blocks * length / self.observations() as f64))
    }

    /// Sums over complete blocks of every replica that has some.
    fn replicas(&self) -> Result<Vec<&[f64]>, Error> {
        let blocks = self.block_sums().len();
        if blocks < MINIMUM_BLOCKS {
            let observations = self.observations();
            let saturated = |number: u64| usize::try_from(number).unwrap_or(usize::MAX);
            let needed = (MINIMUM_BLOCKS as u64 * self.block_length).max(observations + 1);
            return Err(Error::TooFewObservations {
                what: self.what,
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

/// The shorter blocks of the two are first merged to the length of the longer ones. Blocks of
/// different replicas are never merged, so slow modes remain visible as differences between
/// replicas. The memory grows with the number of replicas.
impl Merge for BlockAverages {
    fn merge(&mut self, other: &Self) -> Result<(), Error> {
        self.require_components(other.components)?;
        let mut other = other.clone();
        while self.block_length < other.block_length {
            self.coarsen();
        }
        while other.block_length < self.block_length {
            other.coarsen();
        }
        self.replica_sums.extend_from_slice(&other.replica_sums);
        self.replica_sums.extend_from_slice(&other.sums);
        self.replica_blocks.extend_from_slice(&other.replica_blocks);
        self.replica_blocks.push(other.sums.len() / other.components);
        add(&mut self.remainder, &other.remainder);
        add(&mut self.remainder, &other.partial);
        self.remainder_observations += other.remainder_observations + other.partial_observations;
        Ok(())
    }
}

persist!(
    BlockAverages {
        same components,
        count block_length,
        value sums,
        slice partial,
        count partial_observations,
        value replica_sums,
        value replica_blocks,
        slice remainder,
        count remainder_observations,
    },
    |averages| averages.makes_sense()
);

#[cfg(feature = "checkpoint")]
impl BlockAverages {
    /// Whether the numbers of blocks are valid.
    fn makes_sense(&self) -> bool {
        let own = self.sums.len() / self.components;
        let replicas = self.replica_sums.len() / self.components;
        let listed = self.replica_blocks.iter().try_fold(0_usize, |sum, blocks| sum.checked_add(*blocks));
        self.block_length.is_power_of_two()
            && self.partial_observations < self.block_length
            && own < Self::MAXIMUM_BLOCKS
            && own * self.components == self.sums.len()
            && replicas * self.components == self.replica_sums.len()
            && listed == Some(replicas)
            && self.block_length.checked_mul((own + replicas) as u64).is_some_and(|count| count <= 1 << 60)
    }
}

/// Replaces blocks by the sums of neighboring pairs. Returns the last block if it has no partner.
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
