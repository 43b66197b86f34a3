//! Averages of vectors in bounded memory.

use super::jackknife::{Jackknife, correlation, errors};
use super::memory::{Correlation, Memory, Pooled};
use super::{Estimate, MINIMUM_BLOCKS};
use crate::{Error, Merge};

/// Averages of vectors that arrive one by one, with errors of means and of functions of means.
///
/// Observations are summed into blocks of equal length. When
/// [`MAXIMUM_BLOCKS`](Self::MAXIMUM_BLOCKS) blocks are complete, neighbors are merged and the block
/// length doubles; so after the first 64 observations there are always 64 to 127 complete blocks,
/// and memory does not grow with the length of the run.
///
/// # Errors of correlated data
/// The squared error of a mean of N numbers is σ² g/N · ν/(ν − 2), component by component. Here
/// g = 2τ, with τ = ½ + Σ ρ(k) the correlation time of the blocks, summed to the lag W ≥ 3 τ and
/// corrected for the mean that is subtracted (Madras and Sokal, doi:10.1007/BF01022990; Wolff,
/// doi:10.1016/S0010-4655(03)00467-3); g is at least 1. The variance so found is known as one with
/// ν = 2B/(2(2W + 1) + g) degrees of freedom is, with B blocks, and the last factor is what
/// Student's distribution of that many has more in variance than the normal one: errors from few
/// independent numbers are wider. The error is on average 9 to 20 % too large and scatters by some
/// 20 %. From 10 independent numbers on the deviations from the truth are as large as the errors
/// within some 10 % for an exponential memory, and within a quarter for one of two times. Below, τ
/// of a single series is too uncertain: there the profiles take the mean of ρ over neighboring
/// bins, which scatters less, and are right within a quarter from some three independent
/// configurations on (`docs/stability.md`).
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
    /// What is observed, and for what.
    what: &'static str,
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
            what: "observations for a standard error",
        }
    }

    /// Those of an observer: what it says to be too few.
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

    /// The same for components that are rows of equal lengths, one after the other, in which so
    /// many neighbors to either side share their memory, one number for each row.
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

    /// The errors of the means of all observations, of what complete blocks say, for every
    /// component.
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

    /// Number of independent observations of some components taken together, within a replica:
    /// their correlations are averaged. NaN before there are 16 blocks.
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

    /// Functions of the means, such as ratios, with errors by the jackknife over blocks:
    /// correlations between components and in time are accounted for, as in
    /// [`standard_errors`](Self::standard_errors).
    ///
    /// The value is `function` of the means of all observations. Its bias is of the order of the
    /// squared error, as that of any ratio of averages, and is not corrected. `function` is called
    /// once for every block, and must return the same number of values each time: it is as if
    /// values that are missing in any call were NaN.
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

    /// Values of `function`, of all and of all but every block, kept so that functions of them can
    /// be had later.
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
        Ok(Jackknife::new(values, without, blocks * length / self.observations() as f64))
    }

    /// Sums over complete blocks of every replica that has any.
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

/// The shorter blocks of the two are first merged to the length of the longer. Blocks of different
/// replicas are never merged with each other, so a replica's slow modes stay visible as a
/// difference between blocks. Memory grows with the number of replicas.
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
    /// Whether there are whole blocks, no more than there can be.
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

/// Replaces blocks by the sums of neighboring pairs, and returns the last block if it has no
/// partner.
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
