//! Chains of a wide system, tile by tile.

use super::cut::{Cut, Sizes};
use super::visit::{Common, Frozen, Outcome, Tile};
use super::{EventChains, ForceBounds};
use crate::configuration::Layer;
use crate::drive::Drive;
use crate::moves::{Sweep, local::derived};
use crate::random::{Generator, index};
use crate::{Error, Field, Slab, TemperatureProfile};
use rand::Rng;
use std::sync::{Mutex, PoisonError};

impl Sizes {
    /// Found by measurement.
    pub(super) const GOOD: Self =
        Self { spheres: 32_000.0, least: [20.0, 8.0], path: 5.0, together: 16, tiles: 4 };
}

/// What chains of wide systems keep between sweeps.
#[derive(Debug)]
pub(super) struct Tiles {
    pub(super) sizes: Sizes,
    pub(super) frozen: Frozen,
    /// Path that chains along each axis are behind with, in diameters per sphere; negative when they are ahead.
    owed: [f64; 3],
    /// Numbers of tiles, of which some are drawn.
    order: Vec<u32>,
    outcomes: Vec<Outcome>,
    /// One for every thread.
    scratch: Mutex<Vec<Tile>>,
}

impl Clone for Tiles {
    fn clone(&self) -> Self {
        Self { owed: self.owed, frozen: self.frozen, ..Self::new(self.sizes) }
    }
}

/// Sums over the visits of a sweep.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sums {
    pub(super) path: f64,
    pub(super) events: u64,
    pub(super) field_events: u64,
}

impl Tiles {
    pub(super) fn new(sizes: Sizes) -> Self {
        Self {
            sizes,
            frozen: Frozen::Turns,
            owed: [0.0; 3],
            order: Vec::new(),
            outcomes: Vec::new(),
            scratch: Mutex::default(),
        }
    }

    /// What chains along each axis are behind with: all that is kept from one sweep to the next.
    #[cfg(feature = "checkpoint")]
    pub(super) fn owed_mut(&mut self) -> &mut [f64; 3] {
        &mut self.owed
    }

    /// Whether a system is wide enough.
    pub(super) fn suit(&self, slab: &Slab, particles: usize) -> bool {
        Cut::new(0, slab, particles, &self.sizes).tiles() >= self.sizes.tiles
    }

    /// The chains of a sweep, of mean `lengths` along the axes, that make a path of `path` per sphere.
    pub(super) fn sweep<F: Field, T: TemperatureProfile, D: Drive<F, T>>(
        &mut self,
        sweep: &mut Sweep<'_, F, T, D>,
        chains: &EventChains,
        bounds: &ForceBounds,
        lengths: [f64; 3],
        path: f64,
    ) -> Result<Sums, Error> {
        let mut sums = Sums::default();
        let lateral = 0.5 * (1.0 - chains.vertical_fraction);
        for (axis, share) in [chains.vertical_fraction, lateral, lateral].into_iter().enumerate() {
            let slab = *sweep.configuration.slab();
            let cut = Cut::new(axis, &slab, sweep.configuration.len(), &self.sizes);
            self.owed[axis] += path * share;
            if self.owed[axis] <= 0.0 {
                continue;
            }
            // What a visit to one of the tiles pays back. Numbers of visits depend on sizes only.
            let tiles = cut.tiles();
            let payment = self.sizes.path * cut.mobile() / tiles as f64;
            // At most the number of tiles.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let due = (self.owed[axis] / payment).ceil() as usize;
            let visits = due.max(self.sizes.together).min(tiles);
            self.owed[axis] -= payment * visits as f64;
            self.visit(sweep, chains, bounds, cut, visits, lengths[axis], &mut sums)?;
        }
        Ok(sums)
    }

    /// Visits some tiles of a cut, drawn at random.
    #[allow(clippy::too_many_arguments)]
    fn visit<F: Field, T: TemperatureProfile, D: Drive<F, T>>(
        &mut self,
        sweep: &mut Sweep<'_, F, T, D>,
        chains: &EventChains,
        bounds: &ForceBounds,
        cut: Cut,
        visits: usize,
        length: f64,
        sums: &mut Sums,
    ) -> Result<(), Error> {
        let Sweep { scene, drive, configuration, generator, move_counts, phase, recorder } = sweep;
        let shifted = cut.shifted(generator);
        // At most as many as cells, which fit a u32.
        #[allow(clippy::cast_possible_truncation)]
        let tiles = cut.tiles() as u32;
        self.order.clear();
        self.order.extend(0..tiles);
        for place in 0..visits {
            let other = place + index(generator, tiles as usize - place);
            self.order.swap(place, other);
        }
        let keys = [generator.next_u64(), generator.next_u64()];
        let (grid, layers) = configuration.parts_mut();
        let common = Common {
            scene,
            drive: *drive,
            bounds,
            grid,
            rule: chains.field_event,
            frozen: self.frozen,
            phase: *phase,
            axis: cut.axis,
            path: self.sizes.path,
            length,
            record: recorder.is_some(),
        };
        let group = at_once(common.record);
        if self.outcomes.len() < group {
            self.outcomes.resize_with(group, Outcome::default);
        }
        for numbers in self.order[..visits].chunks(group) {
            let outcomes = &mut self.outcomes[..numbers.len()];
            let scratch = &self.scratch;
            let seen: &[Layer] = layers;
            each(numbers, outcomes, |number, outcome| {
                let spare = scratch.lock().unwrap_or_else(PoisonError::into_inner).pop();
                let mut tile = spare.unwrap_or_default();
                let generator: &mut Generator = &mut derived(keys, [cut.axis, number as usize]);
                tile.visit(&common, seen, shifted.tile(number as usize), generator, outcome);
                scratch.lock().unwrap_or_else(PoisonError::into_inner).push(tile);
            });
            // In the order of the tiles, whoever was done first.
            for outcome in outcomes.iter_mut() {
                for &(layer, index, along) in &outcome.moved {
                    let mut position = layers[layer as usize].spheres[index as usize].position;
                    position[cut.axis] = along;
                    let spot = grid.spot(position);
                    let (to, site) = (spot.layer as usize + 1, grid.site(&spot, position));
                    if to == layer as usize {
                        layers[to].shift(grid, index, &site);
                    } else {
                        let number = layers[layer as usize].remove(grid, index);
                        layers[to].insert(grid, &site, number);
                    }
                }
                move_counts.events += outcome.events;
                move_counts.chains += outcome.chains;
                if cut.axis == 0 {
                    sums.path += outcome.path;
                    sums.events += outcome.events;
                    sums.field_events += outcome.field_events;
                }
                if let Some(recorder) = recorder {
                    outcome.tell(cut.axis, *recorder);
                }
            }
            if let Some(error) = outcomes.iter_mut().find_map(|outcome| outcome.error.take()) {
                return Err(error);
            }
        }
        Ok(())
    }
}

/// Number of tiles that are visited before what became of them is entered.
#[cfg(not(feature = "rayon"))]
fn at_once(_: bool) -> usize {
    1
}

/// Number of tiles that are visited at the same time before what became of them is entered. The outcome
/// does not depend on it.
#[cfg(feature = "rayon")]
fn at_once(record: bool) -> usize {
    // What is recorded takes memory.
    rayon::current_num_threads() * if record { 1 } else { 16 }
}

/// Calls `visit` for each tile.
#[cfg(not(feature = "rayon"))]
fn each(numbers: &[u32], outcomes: &mut [Outcome], visit: impl Fn(u32, &mut Outcome)) {
    numbers.iter().zip(outcomes).for_each(|(&number, outcome)| visit(number, outcome));
}

/// Calls `visit` for each tile, for several at the same time.
#[cfg(feature = "rayon")]
fn each(numbers: &[u32], outcomes: &mut [Outcome], visit: impl Fn(u32, &mut Outcome) + Sync) {
    use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};
    numbers.par_iter().zip(outcomes).with_max_len(1).for_each(|(&number, outcome)| visit(number, outcome));
}

#[cfg(test)]
mod tests;
