//! Block averages of several runs in one.

use super::{BlockAverages, add};
use crate::{Error, Merge};

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
