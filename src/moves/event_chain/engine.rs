//! The engine of event chains.

use super::EventChains;
use super::cut::Sizes;
use super::force_bound::ForceBounds;
use super::length::ChainLength;
use super::tiles::Tiles;
use crate::drive::Drive;
use crate::frame::Phase;
use crate::moves::{Sweep, local};
use crate::{Error, Field, TemperatureProfile};

/// The chosen chains and their data between sweeps.
#[derive(Debug, Clone)]
pub(crate) struct Engine {
    pub(super) chains: EventChains,
    pub(super) length: Box<ChainLength>,
    bounds: ForceBounds,
    pub(super) tiles: Box<Tiles>,
    pub(in crate::moves) local: Option<local::Engine>,
}

impl Engine {
    pub(in crate::moves) fn new(chains: EventChains) -> Self {
        Self {
            chains,
            length: Box::new(ChainLength::new(&chains)),
            bounds: ForceBounds::default(),
            tiles: Box::new(Tiles::new(Sizes::GOOD)),
            local: chains.local_moves.map(local::Engine::new),
        }
    }

    /// A sweep: chains with at most the [`path_per_sphere`](EventChains::path_per_sphere) on
    /// average over sweeps, then local moves.
    pub(in crate::moves) fn sweep<F: Field, T: TemperatureProfile, D: Drive<F, T>>(
        &mut self,
        sweep: &mut Sweep<'_, F, T, D>,
    ) -> Result<(), Error> {
        self.bounds.follow(sweep.drive, sweep.scene)?;
        let slab = *sweep.configuration.slab();
        if !self.length.begun {
            let heights = sweep.configuration.heights();
            let forces = heights.map(|height| sweep.drive.reduced_force(sweep.scene, height).abs());
            self.length.begin(forces.sum::<f64>() / sweep.configuration.len() as f64);
        }
        if sweep.phase == Phase::Equilibration {
            self.length.tune(slab.height());
        }
        let mean = self.length.mean();
        let [width_y, width_z] = slab.widths();
        let lengths = [mean, mean.min(width_y), mean.min(width_z)];
        let sums = self.tiles.sweep(sweep, &self.chains, &self.bounds, lengths, &self.length)?;
        self.length.learn(sums.path, sums.events, sums.field_events);
        self.local.as_mut().map_or(Ok(()), |moves| moves.sweep(sweep))
    }
}
