//! Local moves.

use super::cells::Cells;
use rand::{Rng, RngExt};

/// Makes as many trials as there are spheres; returns the number accepted.
pub(crate) fn sweep(cells: &mut Cells, maximum_displacement: f64, generator: &mut impl Rng) -> u64 {
    // Some hundreds.
    #[allow(clippy::cast_possible_truncation)]
    let particles = cells.particles() as u32;
    let mut accepted = 0;
    for _ in 0..particles {
        let sphere = generator.random_range(0..particles);
        let (cell, slot) = cells.places[sphere as usize];
        let mut trial = cells.grid[cell as usize].center(slot as usize);
        for coordinate in &mut trial {
            *coordinate += maximum_displacement * (2.0 * generator.random::<f64>() - 1.0);
        }
        let target = cells.settle(cell, &mut trial);
        if cells.is_free(sphere, target, trial) {
            cells.place(sphere, target, trial);
            accepted += 1;
        }
    }
    accepted
}
