//! The trials of one domain.

use super::LocalMoves;
use super::batch::{BATCH, Place, Rules, Slice, Targets, Trial, Trials};
use super::domains::Domains;
use crate::Scene;
use crate::configuration::{Grid, NOBODY, neighbors_of};
use crate::drive::{Drive, log_acceptance};
use crate::observer::AcceptedMove;
use crate::random::{Generator, index, unit};
use nalgebra::Vector3;
use rand::Rng;

/// Number of cells searched in preparation where most trials overlap.
const CROWDED: usize = 4;

/// A separate function keeps the branch, which is predicted, so that later instructions need not
/// wait.
#[cold]
#[inline(never)]
fn again(pending: &mut u32, stale: u32) {
    *pending |= stale;
}

/// The results of the trials of a slab.
#[derive(Debug, Clone, Default)]
pub(super) struct Outcome {
    pub(super) trials: u64,
    pub(super) accepted: u64,
    /// Trials rejected because they would leave their domain.
    pub(super) left_domain: u64,
    /// Filled only if moves are recorded.
    pub(super) moves: Vec<AcceptedMove>,
    /// A height at which the potential is not a number, which ends the visit.
    pub(super) invalid: Option<f64>,
}

impl Outcome {
    pub(super) fn clear(&mut self) {
        (self.trials, self.accepted, self.left_domain, self.invalid) = (0, 0, 0, None);
        self.moves.clear();
    }
}

/// The places of the spheres of a tile.
#[derive(Debug, Clone, Default)]
struct Census {
    /// Spheres that move.
    moving: Vec<Place>,
    /// Spheres of the layers before and after; only if there are several tiles.
    looked_at: Vec<Place>,
}

/// Memory that visits reuse: a census of each tile.
#[derive(Debug, Clone, Default)]
pub(super) struct Scratch(Vec<Census>);

impl Scratch {
    pub(super) fn for_spheres(count: usize) -> Self {
        Self(vec![Census { moving: Vec::with_capacity(count), looked_at: Vec::new() }])
    }
}

/// Shared data of all domains.
pub(super) struct Common<'a, F, T, D> {
    pub(super) scene: &'a Scene<F, T>,
    pub(super) drive: &'a D,
    pub(super) grid: &'a Grid,
    pub(super) moves: &'a LocalMoves,
    pub(super) domains: &'a Domains,
    pub(super) record: bool,
}

impl Slice<'_> {
    /// Makes as many trials in each tile as it has spheres, with the generator that `generator_of`
    /// gives for the tile.
    pub(super) fn visit<F, T, D: Drive<F, T>>(
        &mut self,
        common: &Common<'_, F, T, D>,
        generator_of: impl Fn(usize) -> Generator,
        outcome: &mut Outcome,
        Scratch(tiles): &mut Scratch,
    ) {
        self.list(common.domains, tiles);
        let cells =
            (self.layers.len() - 2) * common.grid.cells[1] * common.grid.cells[2] / common.domains.tiles();
        for (tile, census) in tiles.iter_mut().enumerate().take(common.domains.tiles()) {
            let generator = &mut generator_of(tile);
            self.read(common.domains, census);
            let places = &mut census.moving;
            if common.record {
                // Room for all trials, so that the memory does not grow again when more are
                // accepted.
                outcome.moves.reserve(places.len());
            }
            // Where most trials overlap, most of them are decided in preparation.
            if 10 * places.len() > 3 * cells {
                self.try_all::<F, T, D, CROWDED>(common, tile, generator, outcome, places);
            } else if !places.is_empty() {
                self.try_all::<F, T, D, 2>(common, tile, generator, outcome, places);
            }
            if outcome.invalid.is_some() {
                return;
            }
        }
    }

    /// Makes the trials of a tile. Batches search `EARLY` cells in preparation.
    fn try_all<F, T, D: Drive<F, T>, const EARLY: usize>(
        &mut self,
        common: &Common<'_, F, T, D>,
        tile: usize,
        generator: &mut Generator,
        outcome: &mut Outcome,
        places: &mut [Place],
    ) {
        let Common { scene, drive, grid, moves, domains, record } = *common;
        let slab = scene.slab();
        let rules = Rules {
            grid,
            widths: slab.widths(),
            lowest: slab.lowest_center(),
            highest: slab.highest_center(),
            tile_of: domains.tile_of(),
            tile,
        };
        let scales = moves
            .sizes
            .map(|size| [size, size.min(moves.across)].map(|size| size * (1.0 / (1_u64 << 32) as f64)));
        let mut trials = Trials::<BATCH>::new();
        let mut targets = Targets::new(slab.widths(), moves.maximum_displacement());
        let mut left = places.len();
        while left > 0 {
            let batch = left.min(BATCH);
            left -= batch;
            // The last batch is drawn in full; the surplus is not used.
            for trial in 0..BATCH {
                trials.random[0][trial] = generator.next_u64();
                trials.random[1][trial] = generator.next_u64();
                let size = if moves.count == 1 { 0 } else { index(generator, moves.count) };
                [trials.scale[0][trial], trials.scale[1][trial]] = scales[size];
            }
            trials.prepare::<EARLY>(&rules, self, places);
            targets.follow(&trials);
            // Only trials that may be accepted. This is hardly predictable, but costs one wrong
            // guess per batch.
            let all = !(u32::MAX << batch);
            let mut leaving = trials.leaving() & all;
            let mut pending = if EARLY == CROWDED { trials.pending() & all } else { all };
            while pending != 0 {
                let number = pending.trailing_zeros() as usize;
                pending &= pending - 1;
                let trial = if targets.is_stale(number) {
                    // The result must be that of sequential trials.
                    let mut again = trials.alone(number);
                    again.prepare::<EARLY>(&rules, self, places);
                    leaving = leaving & !(1 << number) | again.leaving() << number;
                    again.get(0)
                } else {
                    trials.get(number)
                };
                let Some(trial) = trial else { continue };
                let Trial { place, local, from_height, probe, .. } = trial;
                if probe.overlaps(grid, neighbors_of(self.layers, local)) {
                    continue;
                }
                let site = probe.site;
                let height = site.position[0];
                let exponent = log_acceptance(drive, scene, from_height, height);
                if exponent.is_nan() {
                    let fails_at = |height: f64| !drive.reduced_potential(scene, height).is_finite();
                    outcome.invalid = Some(if fails_at(from_height) { from_height } else { height });
                    // The trials after it are not made.
                    outcome.trials += number as u64 + 1;
                    outcome.left_domain += u64::from((leaving & !(u32::MAX << number)).count_ones());
                    return;
                }
                if exponent < 0.0 {
                    let threshold = unit(generator);
                    // exp(v) ≥ 1 + v decides most cases.
                    if threshold >= 1.0 + exponent && threshold >= libm::exp(exponent) {
                        continue;
                    }
                }
                let own = &self.layers[place.layer as usize].spheres[place.index as usize];
                if place.layer as usize == local && own.cell == site.cell {
                    self.layers[local].shift(grid, place.index, &site);
                } else {
                    // One path for another cell of the same or of another layer, because the case
                    // is not predictable.
                    let number = self.layers[place.layer as usize].remove(grid, place.index);
                    let index = self.layers[local].insert(grid, &site, number);
                    #[allow(clippy::cast_possible_truncation)]
                    let layer = local as u32;
                    places[trial.chosen] = Place { layer, index };
                }
                targets.disturb(site.position);
                if EARLY == CROWDED {
                    let stale = targets.stale_after(number) & all;
                    if stale != 0 {
                        again(&mut pending, stale);
                    }
                }
                outcome.accepted += 1;
                if record {
                    let displacement = Vector3::from(trials.displacements(number));
                    outcome.moves.push(AcceptedMove { from_height, displacement, chain_axis: None });
                }
            }
            outcome.trials += batch as u64;
            outcome.left_domain += u64::from(leaving.count_ones());
        }
    }

    /// Lists the spheres of each tile.
    fn list(&self, domains: &Domains, tiles: &mut Vec<Census>) {
        if tiles.len() < domains.tiles() {
            tiles.resize_with(domains.tiles(), Census::default);
        }
        for census in tiles.iter_mut() {
            census.moving.clear();
            census.looked_at.clear();
        }
        let tile_of = domains.tile_of();
        let last = self.layers.len() - 1;
        for (number, layer) in (0..).zip(self.layers.iter()) {
            let moving = number > 0 && (number as usize) < last;
            if tile_of.is_empty() {
                if !moving {
                    continue;
                }
                // Written without a branch; the place of a gap is overwritten.
                let places = &mut tiles[0].moving;
                let mut listed = places.len();
                places.resize(listed + layer.spheres.len(), Place::default());
                for (index, sphere) in (0..).zip(&layer.spheres) {
                    places[listed] = Place { layer: number, index };
                    listed += usize::from(sphere.number != NOBODY);
                }
                places.truncate(listed);
            } else {
                for (index, sphere) in (0..).zip(&layer.spheres) {
                    if sphere.number != NOBODY {
                        let census = &mut tiles[usize::from(tile_of[sphere.cell as usize])];
                        let places = if moving { &mut census.moving } else { &mut census.looked_at };
                        places.push(Place { layer: number, index });
                    }
                }
            }
        }
    }

    /// Reads the data of a tile in advance, so that random accesses by the trials find them in the
    /// cache. Here the processor need not wait for one read before the next.
    fn read(&self, domains: &Domains, census: &Census) {
        let mut read = 0;
        if domains.tiles() == 1 {
            self.layers.iter().for_each(|layer| read ^= layer.read());
        } else {
            census
                .moving
                .iter()
                .chain(&census.looked_at)
                .for_each(|place| read ^= self.layers[place.layer as usize].read_around(place.index));
        }
        std::hint::black_box(read);
    }
}
