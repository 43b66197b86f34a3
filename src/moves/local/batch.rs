//! Batches of trials.

use crate::configuration::{Grid, Layer, NOBODY, Probe, Site, Spot, neighbors_of, occupied_in_reach, wrap};
use wide::f32x8;

/// The place of a sphere in a slice.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Place {
    pub(super) layer: u32,
    pub(super) index: u32,
}

/// Layers whose spheres move, and one layer on either side whose spheres do not.
pub(super) struct Slice<'a> {
    /// The first and the last are only read.
    pub(super) layers: &'a mut [Layer],
    /// Index along x of the first layer whose spheres move.
    pub(super) first: usize,
}

/// Trials in a batch.
pub(super) const BATCH: usize = 8;
/// Shared data of the trials of a domain.
pub(super) struct Rules<'a> {
    pub(super) grid: &'a Grid,
    pub(super) widths: [f64; 2],
    pub(super) lowest: f64,
    pub(super) highest: f64,
    /// Tile of each cell of a layer, empty if there is only one; below, the tile of the domain.
    pub(super) tile_of: &'a [u16],
    pub(super) tile: usize,
}

/// A batch of trials in preparation.
///
/// The outcome of a trial is hardly predictable, and each wrong guess of the processor would delay
/// the next trial. So several trials are prepared together without a branch, step by step: each
/// step waits for memory once, and does arithmetic on all.
#[derive(Debug, Clone)]
pub(super) struct Trials<const COUNT: usize> {
    /// Random bits: 32 each for the choice of the sphere and three displacements.
    pub(super) random: [[u64; COUNT]; 2],
    /// Largest displacement along x, and along y and z, over 2³².
    pub(super) scale: [[f64; COUNT]; 2],
    chosen: [u32; COUNT],
    place: [Place; COUNT],
    from_height: [f64; COUNT],
    position: [[f64; COUNT]; 3],
    relative: [[f32; COUNT]; 3],
    /// Layer, y and z of the cell, its index in the layer, and the part of the cell.
    cell: [[u32; COUNT]; 5],
    /// Layer in the slice.
    local: [u32; COUNT],
    ignored: [u32; COUNT],
    candidates: [u64; COUNT],
    refused: [bool; COUNT],
    /// Trials that would leave the domain, but not the slab.
    leaving: [bool; COUNT],
}

/// One prepared trial.
#[derive(Debug, Clone, Copy)]
pub(super) struct Trial {
    pub(super) chosen: usize,
    pub(super) place: Place,
    pub(super) from_height: f64,
    pub(super) local: usize,
    pub(super) probe: Probe,
}

/// An odd integer in (−2³², 2³²), from 32 random bits: v and −v are equally likely, to the last
/// bit.
#[inline]
fn odd_integer(bits: u64) -> f64 {
    // A number whose last bit has the value 1.
    const ONES: f64 = (1_u64 << 52) as f64;
    let odd = (bits & 0xffff_ffff) << 1 | 1;
    f64::from_bits(ONES.to_bits() | odd) - (ONES + (1_u64 << 32) as f64)
}

impl<const COUNT: usize> Trials<COUNT> {
    pub(super) fn new() -> Self {
        Self {
            random: [[0; COUNT]; 2],
            scale: [[0.0; COUNT]; 2],
            chosen: [0; COUNT],
            place: [Place::default(); COUNT],
            from_height: [0.0; COUNT],
            position: [[0.0; COUNT]; 3],
            relative: [[0.0; COUNT]; 3],
            cell: [[0; COUNT]; 5],
            local: [0; COUNT],
            ignored: [0; COUNT],
            candidates: [0; COUNT],
            refused: [false; COUNT],
            leaving: [false; COUNT],
        }
    }

    #[inline]
    fn displacement(&self, axis: usize, trial: usize) -> f64 {
        let bits = match axis {
            0 => self.random[0][trial] >> 32,
            1 => self.random[1][trial],
            _ => self.random[1][trial] >> 32,
        };
        self.scale[usize::from(axis > 0)][trial] * odd_integer(bits)
    }

    pub(super) fn displacements(&self, trial: usize) -> [f64; 3] {
        [0, 1, 2].map(|axis| self.displacement(axis, trial))
    }

    /// Octant of a displacement: one bit for each axis, set if it is positive.
    #[inline]
    fn octant(&self, trial: usize) -> usize {
        let [first, second] = [self.random[0][trial], self.random[1][trial]];
        usize::from(first >> 63 == 1)
            | usize::from(second >> 31 & 1 == 1) << 1
            | usize::from(second >> 63 == 1) << 2
    }

    /// Prepares the drawn trials as far as is possible without a branch. `EARLY` cells are searched
    /// for overlaps.
    // Both sides always: a condition is cheaper than a branch.
    #[allow(clippy::needless_bitwise_bool)]
    // Each loop is over one step of all trials.
    #[allow(clippy::needless_range_loop)]
    // One call per batch costs nothing, but four inlined copies would overflow the instruction
    // cache.
    #[inline(never)]
    pub(super) fn prepare<const EARLY: usize>(
        &mut self,
        rules: &Rules<'_>,
        slice: &Slice<'_>,
        places: &[Place],
    ) {
        let Rules { grid, widths, lowest, highest, tile_of, tile } = *rules;
        let layers = &*slice.layers;
        // Layers along an axis, and spheres, fit a u32.
        #[allow(clippy::cast_possible_truncation)]
        let (first, moving) = (slice.first as u32, (layers.len() - 2) as u32);
        for trial in 0..COUNT {
            let chosen = ((self.random[0][trial] & 0xffff_ffff) * places.len() as u64) >> 32;
            #[allow(clippy::cast_possible_truncation)]
            let chosen = chosen as u32;
            self.chosen[trial] = chosen;
            self.place[trial] = places[chosen as usize];
        }
        for trial in 0..COUNT {
            let Place { layer, index } = self.place[trial];
            let position = layers[layer as usize].spheres[index as usize].position;
            for axis in 0..3 {
                self.position[axis][trial] = position[axis];
            }
        }
        for trial in 0..COUNT {
            let from = self.position[0][trial];
            let to = from + self.displacement(0, trial);
            let inside = (to >= lowest) & (to <= highest);
            self.from_height[trial] = from;
            // A rejected trial stays where it starts.
            self.position[0][trial] = if inside { to } else { from };
            self.refused[trial] = !inside;
        }
        for axis in 1..3 {
            for trial in 0..COUNT {
                let to = self.position[axis][trial] + self.displacement(axis, trial);
                self.position[axis][trial] = wrap(to, widths[axis - 1]);
            }
        }
        for trial in 0..COUNT {
            let position = [0, 1, 2].map(|axis| self.position[axis][trial]);
            let spot = grid.spot(position);
            let relative = grid.relative(&spot, position);
            for axis in 0..3 {
                self.relative[axis][trial] = relative[axis];
            }
            let Spot { layer, y, z, cell, part } = spot;
            for (to, from) in self.cell.iter_mut().zip([layer, y, z, cell, part]) {
                to[trial] = from;
            }
        }
        for trial in 0..COUNT {
            let local = (self.cell[0][trial] + 1).wrapping_sub(first);
            let beyond = local.wrapping_sub(1) >= moving;
            // For a trial that leaves the domain any valid layer will do.
            self.local[trial] = if beyond { 1 } else { local };
            self.leaving[trial] = beyond;
        }
        if !tile_of.is_empty() {
            for trial in 0..COUNT {
                self.leaving[trial] |= usize::from(tile_of[self.cell[3][trial] as usize]) != tile;
            }
        }
        for trial in 0..COUNT {
            self.leaving[trial] &= !self.refused[trial];
            self.refused[trial] |= self.leaving[trial];
        }
        for trial in 0..COUNT {
            let Place { layer, index } = self.place[trial];
            let near = (layer + 1).wrapping_sub(self.local[trial]) < 3;
            let own = layers[layer as usize].occupant(index);
            self.ignored[trial] = if near { own } else { NOBODY };
        }
        for trial in 0..COUNT {
            let around = neighbors_of(layers, self.local[trial] as usize);
            let [cell, part] = [self.cell[3][trial], self.cell[4][trial]];
            self.candidates[trial] = occupied_in_reach(grid, around, cell, part, self.octant(trial));
        }
        for trial in 0..COUNT {
            let around = neighbors_of(layers, self.local[trial] as usize);
            let (overlaps, left) = self.probe(trial).overlaps_early::<EARLY>(grid, around);
            self.refused[trial] |= overlaps;
            self.candidates[trial] = left;
        }
    }

    #[inline]
    fn probe(&self, trial: usize) -> Probe {
        Probe {
            site: Site {
                position: [0, 1, 2].map(|axis| self.position[axis][trial]),
                relative: [0, 1, 2].map(|axis| self.relative[axis][trial]),
                cell: self.cell[3][trial],
            },
            ignored: self.ignored[trial],
            candidates: self.candidates[trial],
        }
    }

    /// The trials that are not rejected yet, one bit for each.
    #[inline]
    pub(super) fn pending(&self) -> u32 {
        self.refused.iter().enumerate().map(|(trial, &refused)| u32::from(!refused) << trial).sum()
    }

    /// The trials that would leave the domain, one bit for each.
    #[inline]
    pub(super) fn leaving(&self) -> u32 {
        self.leaving.iter().enumerate().map(|(trial, &leaving)| u32::from(leaving) << trial).sum()
    }

    /// A trial, unless it is rejected already.
    #[inline]
    pub(super) fn get(&self, trial: usize) -> Option<Trial> {
        if self.refused[trial] {
            return None;
        }
        Some(Trial {
            chosen: self.chosen[trial] as usize,
            place: self.place[trial],
            from_height: self.from_height[trial],
            local: self.local[trial] as usize,
            probe: self.probe(trial),
        })
    }

    /// A single trial, to be prepared again.
    pub(super) fn alone(&self, trial: usize) -> Trials<1> {
        Trials {
            random: self.random.map(|random| [random[trial]]),
            scale: self.scale.map(|scale| [scale[trial]]),
            ..Trials::new()
        }
    }
}

/// Targets of the trials of a batch in single precision, and the trials that a move may have
/// affected.
pub(super) struct Targets {
    position: [f32x8; 3],
    widths: [f32x8; 2],
    reach: f32x8,
    stale: u32,
}

// Single precision is enough, because the test has a margin.
#[allow(clippy::cast_possible_truncation)]
impl Targets {
    /// For displacements up to `size`.
    pub(super) fn new(widths: [f64; 2], size: f64) -> Self {
        // A move affects trials whose targets are within a diameter of its start or end, and those
        // of its own sphere. The start is less than `size` from the end.
        let reach = f64::max(1.25 + size, 0.25 + 2.0 * size);
        Self {
            position: [f32x8::splat(0.0); 3],
            widths: widths.map(|width| f32x8::splat(width as f32)),
            reach: f32x8::splat(reach as f32),
            stale: 0,
        }
    }

    pub(super) fn follow(&mut self, trials: &Trials<BATCH>) {
        self.position = trials.position.map(|along| f32x8::new(along.map(|coordinate| coordinate as f32)));
        self.stale = 0;
    }

    /// Marks the trials that a move to `position` may affect.
    #[inline]
    pub(super) fn disturb(&mut self, position: [f64; 3]) {
        let [x, y, z] = position.map(|coordinate| f32x8::splat(coordinate as f32));
        let dx = (self.position[0] - x).abs();
        let dy = (self.position[1] - y).abs();
        let dz = (self.position[2] - z).abs();
        let (dy, dz) = (dy.fast_min(self.widths[0] - dy), dz.fast_min(self.widths[1] - dz));
        self.stale |= dx.fast_max(dy).fast_max(dz).simd_lt(self.reach).to_bitmask();
    }

    /// The marked trials after a given one, one bit for each.
    #[inline]
    pub(super) fn stale_after(&self, trial: usize) -> u32 {
        self.stale & u32::MAX << 1 << trial
    }

    #[inline]
    pub(super) fn is_stale(&self, trial: usize) -> bool {
        self.stale >> trial & 1 == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn displacements_are_symmetric_to_the_last_bit() {
        for bits in [0, 1, 0x7fff_ffff, 0x8000_0000, 0xffff_fffe, 0xffff_ffff] {
            let value = odd_integer(bits);
            let exact = (2 * bits + 1).cast_signed() - (1 << 32);
            assert_eq!(value.to_bits(), (exact as f64).to_bits());
            assert_eq!(value.to_bits(), (-odd_integer(0xffff_ffff - bits)).to_bits());
            assert_eq!(value > 0.0, bits >> 31 == 1);
        }
    }
}
