//! What a checkpoint keeps of block averages.

use super::BlockAverages;

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
