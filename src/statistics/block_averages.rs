//! Averages of vectors in bounded memory.

use super::{Estimate, MINIMUM_BLOCKS, larger};
use crate::{Error, Merge};

/// Averages of vectors that arrive one by one, with errors of means and of functions of means.
///
/// Observations are summed into blocks of equal length. When [`MAXIMUM_BLOCKS`](Self::MAXIMUM_BLOCKS)
/// blocks are complete, neighbors are merged and the block length doubles; so after the first 64
/// observations there are always 64 to 127 complete blocks, and memory does not grow with the length of
/// the run.
///
/// # Errors of correlated data
/// An error is computed from the blocks as they are, from pairs of them, and so on while at least 16
/// blocks remain; the largest is returned, component by component (Flyvbjerg and Petersen,
/// doi:10.1063/1.457480). For independent blocks the largest of these estimates, each uncertain by
/// 1/√(2(blocks − 1)), is on average 4 to 7 % too large and scatters by 9 to 13 %: that is the price of
/// not having to look at the plateau. It is too small if even the longest blocks, a sixteenth to a
/// thirty-second of the run, are not long against the correlation time: by 11 % where they are five
/// times as long (measured on autoregressive series).
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
        let mut levels = Level {
            sums: std::mem::take(&mut self.replica_sums),
            blocks: std::mem::take(&mut self.replica_blocks),
        };
        self.remainder_observations += self.block_length * levels.coarsen(&mut self.remainder);
        self.replica_sums = levels.sums;
        self.replica_blocks = levels.blocks;
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
        let mut errors = vec![0.0; self.components];
        self.for_each_level(|sums, length, share| {
            let count = (sums.len() / self.components) as f64;
            let mut center = vec![0.0; self.components];
            for block in sums.chunks_exact(self.components) {
                add(&mut center, block);
            }
            for value in &mut center {
                *value /= count;
            }
            let mut squares = vec![0.0; self.components];
            for block in sums.chunks_exact(self.components) {
                for ((square, sum), center) in squares.iter_mut().zip(block).zip(&center) {
                    let difference = (sum - center) / length;
                    *square += difference * difference;
                }
            }
            for (error, square) in errors.iter_mut().zip(squares) {
                *error = larger(*error, (square / (count - 1.0) * share).sqrt());
            }
        })?;
        Ok(errors)
    }

    /// [`mean`](Self::mean) and [`standard_errors`](Self::standard_errors) together.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] below 16 complete blocks.
    pub fn estimates(&self) -> Result<Vec<Estimate>, Error> {
        let errors = self.standard_errors()?;
        Ok(self.mean().into_iter().zip(errors).map(|(mean, error)| Estimate::new(mean, error)).collect())
    }

    /// Functions of the means, such as ratios, with errors by the jackknife over blocks: correlations
    /// between components and in time are accounted for, at the same block lengths and with the same
    /// choice of the largest error as in [`standard_errors`](Self::standard_errors).
    ///
    /// The value is `function` of the means of all observations. Its bias is of the order of the
    /// squared error, as that of any ratio of averages, and is not corrected. `function` is called
    /// about 200 times, and must return the same number of values each time: it is as if values that
    /// are missing in any call were NaN.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] below 16 complete blocks.
    pub fn jackknife<R: AsRef<[f64]>>(
        &self,
        mut function: impl FnMut(&[f64]) -> R,
    ) -> Result<Vec<Estimate>, Error> {
        self.require_blocks()?;
        let values = function(&self.mean()).as_ref().to_vec();
        let mut errors = vec![0.0; values.len()];
        let mut means = vec![0.0; self.components];
        self.for_each_level(|sums, length, share| {
            let count = (sums.len() / self.components) as f64;
            let mut total = vec![0.0; self.components];
            for block in sums.chunks_exact(self.components) {
                add(&mut total, block);
            }
            // Welford's recurrence for the mean and the sum of squares of the left-out values.
            let mut centers = vec![0.0; values.len()];
            let mut squares = vec![0.0; values.len()];
            for (index, block) in sums.chunks_exact(self.components).enumerate() {
                for ((mean, total), sum) in means.iter_mut().zip(&total).zip(block) {
                    *mean = (total - sum) / ((count - 1.0) * length);
                }
                let without = function(&means);
                let without = without.as_ref().iter().copied().chain(std::iter::repeat(f64::NAN));
                for ((center, square), value) in centers.iter_mut().zip(&mut squares).zip(without) {
                    let difference = value - *center;
                    *center += difference / (index as f64 + 1.0);
                    *square += difference * (value - *center);
                }
            }
            // (n − 1)/n times the sum of squares is the squared error of the mean of n blocks;
            // n · share is what the observations outside them improve on it.
            for (error, square) in errors.iter_mut().zip(squares) {
                *error = larger(*error, ((count - 1.0) * square * share).sqrt());
            }
        })?;
        Ok(values.into_iter().zip(errors).map(|(value, error)| Estimate::new(value, error)).collect())
    }

    /// Fails below [`MINIMUM_BLOCKS`] complete blocks.
    fn require_blocks(&self) -> Result<(), Error> {
        if self.block_sums().len() >= MINIMUM_BLOCKS {
            return Ok(());
        }
        let observations = self.observations();
        let saturated = |number: u64| usize::try_from(number).unwrap_or(usize::MAX);
        let needed = (MINIMUM_BLOCKS as u64 * self.block_length).max(observations + 1);
        Err(Error::TooFewObservations {
            what: "observations for a standard error",
            available: saturated(observations),
            needed: saturated(needed),
        })
    }

    /// Calls `visit` with the sums of blocks, the observations in each, and the fraction of all
    /// observations that one block is, for every level with at least [`MINIMUM_BLOCKS`] blocks.
    fn for_each_level(&self, mut visit: impl FnMut(&[f64], f64, f64)) -> Result<(), Error> {
        self.require_blocks()?;
        let observations = self.observations();
        let mut level = Level {
            sums: [&self.replica_sums[..], &self.sums].concat(),
            blocks: self.replica_blocks.iter().copied().chain([self.sums.len() / self.components]).collect(),
        };
        let mut length = self.block_length as f64;
        let mut dropped = vec![0.0; self.components];
        while level.count() >= MINIMUM_BLOCKS {
            visit(&level.sums, length, length / observations as f64);
            level.coarsen(&mut dropped);
            length *= 2.0;
        }
        Ok(())
    }
}

/// The shorter blocks of the two are first merged to the length of the longer. Blocks of different
/// replicas are never merged with each other, so a replica's slow modes stay visible as a difference
/// between blocks. Memory grows with the number of replicas.
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

/// Sums over blocks of one length, replica after replica.
struct Level {
    sums: Vec<f64>,
    /// Number of blocks of every replica.
    blocks: Vec<usize>,
}

impl Level {
    fn count(&self) -> usize {
        self.blocks.iter().sum()
    }

    /// Merges neighbors within every replica; odd blocks are added to `dropped`, and counted in the
    /// result.
    fn coarsen(&mut self, dropped: &mut [f64]) -> u64 {
        let components = dropped.len();
        let mut odd_blocks = 0;
        let mut coarse = Vec::with_capacity(self.sums.len() / 2);
        let mut rest = &self.sums[..];
        for blocks in &mut self.blocks {
            let (replica, others) = rest.split_at(*blocks * components);
            rest = others;
            let mut replica = replica.to_vec();
            let odd = merge_pairs(&mut replica, components);
            if !odd.is_empty() {
                add(dropped, &odd);
                odd_blocks += 1;
            }
            coarse.append(&mut replica);
            *blocks /= 2;
        }
        self.sums = coarse;
        odd_blocks
    }
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
#[allow(clippy::float_cmp)] // compares only what is exact
mod tests {
    use super::*;
    use crate::statistics::test_series::{Autoregressive, autoregressive};
    use approx::assert_relative_eq;

    fn averages(series: impl IntoIterator<Item = f64>) -> BlockAverages {
        let mut averages = BlockAverages::new(1).unwrap();
        for value in series {
            averages.push(&[value]).unwrap();
        }
        averages
    }

    #[test]
    fn blocks_are_bounded_and_the_mean_is_of_everything() {
        let mut averages = BlockAverages::new(2).unwrap();
        let mut sum = 0.0;
        for (index, value) in Autoregressive::new(0.3, 3).take(10_007).enumerate() {
            averages.push(&[value, 1.0]).unwrap();
            sum += value;
            let count = index + 1;
            assert_eq!(averages.observations(), count as u64);
            let blocks = averages.blocks().len();
            assert!(blocks < 128 && (count < 64 || blocks >= 64));
            if count % 997 == 0 {
                assert_relative_eq!(averages.mean()[0], sum / count as f64, epsilon = 1e-13);
            }
        }
        assert_eq!(averages.block_length(), 128);
        assert_eq!(averages.blocks().len(), 10_007 / 128);
        assert!(averages.blocks().all(|block| (block[1] - 1.0).abs() < 1e-15));
        assert_eq!(averages.standard_errors().unwrap()[1], 0.0);
    }

    #[test]
    fn errors_of_autoregressive_series_are_right() {
        const SERIES: u64 = 400;
        // Measured ratios to the exact error, each ± 13 %/√400 = 0.7 %, within four of those: the
        // documented bias.
        for (correlation, length, low, high) in [
            (0.0, 4096_u32, 1.04, 1.10),
            (0.0, 8190, 1.02, 1.08),
            (0.9, 4096, 0.98, 1.05),
            (0.98, 4096, 0.86, 0.92),
        ] {
            let exact = ((1.0 + correlation) / (1.0 - correlation) / f64::from(length)).sqrt();
            let ratio = (0..SERIES)
                .map(|seed| {
                    let series = autoregressive(correlation, length as usize, seed);
                    averages(series).standard_errors().unwrap()[0] / exact
                })
                .sum::<f64>()
                / SERIES as f64;
            assert!(ratio > low && ratio < high, "{correlation}, {length}: {ratio}");
        }
    }

    #[test]
    fn jackknife_of_the_mean_is_the_standard_error_and_ratios_cancel_common_noise() {
        let mut averages = BlockAverages::new(2).unwrap();
        let mut noise = Autoregressive::new(0.0, 9);
        for common in Autoregressive::new(0.8, 8).take(5000) {
            // Correlated numerator and denominator, 2 % common and 0.2 % own noise.
            let denominator = 1.0 + 0.02 * common;
            averages.push(&[3.0 * denominator + 0.006 * noise.next().unwrap(), denominator]).unwrap();
        }
        let errors = averages.standard_errors().unwrap();
        let identity = averages.jackknife(<[f64]>::to_vec).unwrap();
        for ((estimate, error), mean) in identity.iter().zip(&errors).zip(averages.mean()) {
            assert_relative_eq!(estimate.standard_error, *error, max_relative = 1e-6);
            assert_eq!(estimate.mean, mean);
        }
        let ratio = averages.jackknife(|means| [means[0] / means[1]]).unwrap()[0];
        let exact = 0.006 / 5000.0_f64.sqrt();
        // The error of 4 to 7 % upward bias and 13 % scatter, three of them.
        assert!((ratio.standard_error / exact - 1.05).abs() < 0.4, "{}", ratio.standard_error / exact);
        assert!(ratio.deviation_from(3.0).abs() < 4.0);
        assert!(errors[0] > 3.0 * ratio.standard_error);
    }

    #[test]
    fn merging_replicas_is_pushing_everything() {
        let series = autoregressive(0.5, 3 * 512, 4);
        let whole = averages(series.iter().copied());
        let mut pooled = averages(series[..512].iter().copied());
        pooled.merge(&averages(series[512..1024].iter().copied())).unwrap();
        pooled.merge(&averages(series[1024..].iter().copied())).unwrap();
        assert_eq!(pooled.observations(), 1536);
        assert_relative_eq!(pooled.mean()[0], whole.mean()[0], epsilon = 1e-14);
        // Replicas of 512 keep 64 blocks of 8 each; the whole has 96 of 16.
        assert_eq!((pooled.block_length(), pooled.blocks().len()), (8, 192));
        assert_eq!((whole.block_length(), whole.blocks().len()), (16, 96));
        assert!(pooled.standard_errors().unwrap()[0] > 0.9 * whole.standard_errors().unwrap()[0]);
    }

    #[test]
    fn replicas_of_any_lengths_lose_nothing_and_are_never_joined_to_blocks() {
        // Replica r holds only the number r: a block that crossed a boundary would mix them.
        let mut pooled = averages([]);
        let (mut sum, mut count) = (0.0, 0_u32);
        for (replica, length) in [(1.0, 777_u32), (2.0, 5), (3.0, 10_001), (4.0, 130), (5.0, 0), (6.0, 4000)]
        {
            let mut other = averages((0..length).map(|_| replica));
            // Merging merged accumulators, and pushing to one afterwards.
            other.merge(&averages([replica; 3])).unwrap();
            other.push(&[replica]).unwrap();
            pooled.merge(&other).unwrap();
            pooled.push(&[0.0]).unwrap();
            sum += replica * f64::from(length + 4);
            count += length + 5;
        }
        for _ in 0..300 {
            pooled.push(&[0.0]).unwrap();
        }
        count += 300;
        assert_eq!(pooled.observations(), u64::from(count));
        assert_relative_eq!(pooled.mean()[0], sum / f64::from(count), max_relative = 1e-14);
        assert!(pooled.blocks().all(|block| block[0].fract() == 0.0));
    }

    #[test]
    fn misuse_is_a_typed_error_and_broken_numbers_stay_in_their_component() {
        assert!(matches!(BlockAverages::new(0), Err(Error::InvalidParameter { .. })));
        assert!(matches!(BlockAverages::new(usize::MAX), Err(Error::InvalidParameter { .. })));
        let mut two = BlockAverages::new(2).unwrap();
        assert!(matches!(two.push(&[1.0]), Err(Error::InvalidParameter { .. })));
        assert!(matches!(two.merge(&averages([])), Err(Error::InvalidParameter { .. })));
        assert!(two.mean()[0].is_nan());
        for index in 0..15 {
            two.push(&[f64::from(index), f64::from(index)]).unwrap();
        }
        let what = "observations for a standard error";
        let few = Err(Error::TooFewObservations { what, available: 15, needed: 16 });
        assert_eq!(format!("{:?}", two.standard_errors()), format!("{:?}", few as Result<(), Error>));
        two.push(&[f64::NAN, 1.0]).unwrap();
        let estimates = two.estimates().unwrap();
        assert!(estimates[0].mean.is_nan() && estimates[0].standard_error.is_nan());
        assert!(estimates[1].standard_error > 0.0);
        // Values missing from some calls count as NaN.
        let mut calls = 0;
        let uneven = two.jackknife(|means| {
            calls += 1;
            if calls == 1 { means.to_vec() } else { means[1..].to_vec() }
        });
        assert!(uneven.unwrap()[1].standard_error.is_nan());
    }
}
