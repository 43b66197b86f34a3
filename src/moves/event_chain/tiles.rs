//! Runs chains tile by tile.

use super::EventChains;
use super::cut::{Cut, Sizes};
use super::enter::Entrance;
use super::force_bound::ForceBounds;
use super::length::ChainLength;
use super::visit::{Common, Frozen, Outcome, Tile};
use crate::configuration::Layer;
use crate::drive::Drive;
use crate::moves::{Sweep, local::derived};
use crate::random::{Generator, index, unit};
use crate::{Error, Field, TemperatureProfile};
use rand::Rng;
use std::sync::{Mutex, PoisonError};

impl Sizes {
    /// The fastest by measurement.
    pub(super) const GOOD: Self = Self { spheres: 6000.0, least: [6.0, 6.0], together: 32 };
}

/// Data of chains between sweeps.
#[derive(Debug)]
pub(super) struct Tiles {
    pub(super) sizes: Sizes,
    pub(super) frozen: Frozen,
    /// Path that is still due, of vertical and of lateral chains, in diameters per sphere; negative
    /// if too much is used.
    pub(super) owed: [f64; 2],
    /// Numbers of all tiles; those to be visited come first.
    order: Vec<u32>,
    outcomes: Vec<Outcome>,
    entrance: Entrance,
    /// One for each thread.
    scratch: Mutex<Vec<Tile>>,
}

impl Clone for Tiles {
    fn clone(&self) -> Self {
        Self { owed: self.owed, frozen: self.frozen, ..Self::new(self.sizes) }
    }
}

/// Visits to tiles for chains along one axis.
#[derive(Debug, Clone, Copy)]
struct Turn {
    cut: Cut,
    /// Number of tiles that are visited.
    visits: usize,
    /// Mean path of the chains of one visit, in diameters per mobile sphere.
    path: f64,
    /// Mean length of a chain.
    length: f64,
    /// Path of all visits, in diameters per sphere of the system.
    pays: f64,
}

impl Turn {
    fn frequency(&self) -> f64 {
        1.0 / self.pays
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
            owed: [0.0; 2],
            order: Vec::new(),
            outcomes: Vec::new(),
            entrance: Entrance::default(),
            scratch: Mutex::default(),
        }
    }

    /// The chains of a sweep, of mean `lengths` along the axes.
    pub(super) fn sweep<F: Field, T: TemperatureProfile, D: Drive<F, T>>(
        &mut self,
        sweep: &mut Sweep<'_, F, T, D>,
        chains: &EventChains,
        bounds: &ForceBounds,
        lengths: [f64; 3],
        length: &ChainLength,
    ) -> Result<Sums, Error> {
        /// Path of a visit of lateral chains over that of vertical ones. Lateral visits are shorter
        /// and more frequent, because they renew the constraints of vertical ones.
        const LATERAL: f64 = 0.25;
        let mut sums = Sums::default();
        let (slab, spheres) = (*sweep.configuration.slab(), sweep.configuration.len() as f64);
        let turns = [0, 1, 2].map(|axis| {
            let cut = Cut::new(axis, &slab, sweep.configuration.len(), &self.sizes);
            let (tiles, mobile) = (cut.tiles(), cut.mobile());
            // At least one chain in a tile with the mean number of spheres.
            let least = lengths[axis] / (spheres * mobile / tiles as f64).max(1.0);
            let wanted = length.path_per_visit * if axis == 0 { 1.0 } else { LATERAL };
            let path = wanted.max(least);
            // Paths and numbers of visits must not depend on the configuration.
            let visits = tiles.min(self.sizes.together);
            Turn {
                cut,
                visits,
                path,
                length: lengths[axis],
                pays: path * mobile * visits as f64 / tiles as f64,
            }
        });
        for (owed, turns, share) in
            [(0, &turns[..1], chains.vertical_fraction), (1, &turns[1..], 1.0 - chains.vertical_fraction)]
        {
            // Both lateral axes with half of the path.
            let first = turns[0].frequency() / turns.iter().map(Turn::frequency).sum::<f64>();
            // A sweep that uses too much path leaves less for later ones. Unused path of a failed
            // sweep is not carried over.
            self.owed[owed] = self.owed[owed].min(0.0) + share * length.path_per_sphere;
            while self.owed[owed] > 0.0 {
                let turn = &turns[usize::from(unit(sweep.generator) >= first)];
                self.owed[owed] -= turn.pays;
                self.visit(sweep, chains, bounds, turn, &mut sums)?;
            }
        }
        Ok(sums)
    }

    /// Visits some tiles of a cut, drawn at random.
    fn visit<F: Field, T: TemperatureProfile, D: Drive<F, T>>(
        &mut self,
        sweep: &mut Sweep<'_, F, T, D>,
        chains: &EventChains,
        bounds: &ForceBounds,
        turn: &Turn,
        sums: &mut Sums,
    ) -> Result<(), Error> {
        let &Turn { cut, visits, path, length, .. } = turn;
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
            chains: path / length,
            length,
            record: recorder.is_some(),
        };
        // The groups decide the order of spheres in layers, so they must not depend on the number
        // of threads.
        let group = self.sizes.together;
        self.outcomes.resize_with(self.outcomes.len().max(group.min(visits)), Outcome::default);
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
            self.entrance.enter(cut.axis, grid, layers, outcomes);
            // In the order of the tiles, not of completion.
            for outcome in outcomes.iter_mut() {
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

/// Calls `visit` for each tile.
#[cfg(not(feature = "rayon"))]
fn each(numbers: &[u32], outcomes: &mut [Outcome], visit: impl Fn(u32, &mut Outcome)) {
    numbers.iter().zip(outcomes).for_each(|(&number, outcome)| visit(number, outcome));
}

/// Calls `visit` for each tile, in parallel.
#[cfg(feature = "rayon")]
fn each(numbers: &[u32], outcomes: &mut [Outcome], visit: impl Fn(u32, &mut Outcome) + Sync) {
    use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};
    if let (&[number], [outcome, ..]) = (numbers, &mut *outcomes) {
        return visit(number, outcome);
    }
    numbers.par_iter().zip(outcomes).with_max_len(1).for_each(|(&number, outcome)| visit(number, outcome));
}

#[cfg(test)]
mod tests;
