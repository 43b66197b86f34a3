//! The trials of one domain.

use super::LocalMoves;
use super::batch::{BATCH, Rules, Targets, Trial, Trials};
use super::domains::Stretch;
use crate::Scene;
use crate::configuration::{Grid, Layer, NOBODY, neighbours_of};
use crate::drive::{Drive, log_acceptance};
use crate::observer::AcceptedMove;
use crate::random::{Generator, index, unit};
use nalgebra::Vector3;
use rand::Rng;

/// Where a sphere of the domain is.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Place {
    pub(super) layer: u32,
    pub(super) index: u32,
}

/// What the trials of a slab came to.
#[derive(Debug, Clone, Default)]
pub(super) struct Outcome {
    pub(super) accepted: u64,
    /// Filled only if somebody wants to know.
    pub(super) moves: Vec<AcceptedMove>,
    /// A height at which the potential is not a number, which ends the visit.
    pub(super) invalid: Option<f64>,
}

impl Outcome {
    pub(super) fn clear(&mut self) {
        (self.accepted, self.invalid) = (0, None);
        self.moves.clear();
    }
}

/// Memory that visits use again.
#[derive(Debug, Clone, Default)]
pub(super) struct Scratch {
    /// Where the spheres of the domain are.
    places: Vec<Place>,
}

impl Scratch {
    pub(super) fn for_spheres(count: usize) -> Self {
        Self { places: Vec::with_capacity(count) }
    }
}

/// Layers whose spheres move, between two whose spheres do not.
pub(super) struct Slice<'a> {
    /// The first and the last are only looked at.
    pub(super) layers: &'a mut [Layer],
    /// Index along x of the first whose spheres move.
    pub(super) first: usize,
}

/// What all domains read.
pub(super) struct Common<'a, F, T, D> {
    pub(super) scene: &'a Scene<F, T>,
    pub(super) drive: &'a D,
    pub(super) grid: &'a Grid,
    pub(super) moves: &'a LocalMoves,
    pub(super) record: bool,
}

impl Slice<'_> {
    /// Makes as many trials as there are spheres in the domain.
    pub(super) fn visit<F, T, D: Drive<F, T>>(
        &mut self,
        common: &Common<'_, F, T, D>,
        [rows, columns]: [Stretch; 2],
        generator: &mut Generator,
        outcome: &mut Outcome,
        Scratch { places }: &mut Scratch,
    ) {
        let grid = common.grid;
        let cells = self.list(grid, [rows, columns], places);
        let stretches = [rows, columns];
        // Where most trials overlap, most of them are settled sooner.
        if 10 * places.len() > 3 * cells {
            self.try_all::<F, T, D, 4>(common, stretches, generator, outcome, places);
        } else if !places.is_empty() {
            self.try_all::<F, T, D, 2>(common, stretches, generator, outcome, places);
        }
    }

    /// The trials, of which those in a batch visit `EARLY` cells before any other.
    fn try_all<F, T, D: Drive<F, T>, const EARLY: usize>(
        &mut self,
        common: &Common<'_, F, T, D>,
        [rows, columns]: [Stretch; 2],
        generator: &mut Generator,
        outcome: &mut Outcome,
        places: &mut [Place],
    ) {
        let Common { scene, drive, grid, moves, record } = *common;
        let slab = scene.slab();
        let rules = Rules {
            grid,
            widths: slab.widths(),
            lowest: slab.lowest_center(),
            highest: slab.highest_center(),
            rows,
            columns,
            tiled: !(rows.is_whole() && columns.is_whole()),
        };
        let scales = moves.sizes.map(|size| size * (1.0 / (1_u64 << 32) as f64));
        let mut trials = Trials::<BATCH>::new();
        let mut targets = Targets::new(slab.widths(), moves.maximum_displacement());
        let mut left = places.len();
        while left > 0 {
            let batch = left.min(BATCH);
            left -= batch;
            // Those beyond the last are drawn too, and forgotten.
            for trial in 0..BATCH {
                trials.random[0][trial] = generator.next_u64();
                trials.random[1][trial] = generator.next_u64();
                let size = if moves.count == 1 { 0 } else { index(generator, moves.count) };
                trials.scale[trial] = scales[size];
            }
            trials.prepare::<EARLY>(&rules, self, places);
            targets.follow(&trials);
            for number in 0..batch {
                let trial = if targets.is_stale(number) {
                    // The outcome must be that of one trial after the other.
                    let mut again = trials.alone(number);
                    again.prepare::<EARLY>(&rules, self, places);
                    again.get(0)
                } else {
                    trials.get(number)
                };
                let Some(trial) = trial else { continue };
                let Trial { place, local, from_height, probe, .. } = trial;
                if probe.overlaps(grid, neighbours_of(self.layers, local)) {
                    continue;
                }
                let site = probe.site;
                let height = site.position[0];
                let exponent = log_acceptance(drive, scene, from_height, height);
                if exponent.is_nan() {
                    outcome.invalid = Some(height);
                    return;
                }
                if exponent < 0.0 {
                    let threshold = unit(generator);
                    // exp(v) is at least 1 + v, which mostly decides.
                    if threshold >= 1.0 + exponent && threshold >= libm::exp(exponent) {
                        continue;
                    }
                }
                let own = &self.layers[place.layer as usize].spheres[place.index as usize];
                if place.layer as usize == local && own.cell == site.cell {
                    self.layers[local].shift(grid, place.index, &site);
                } else {
                    // Into another cell of the layer or of another layer: which cannot be predicted.
                    let number = self.layers[place.layer as usize].remove(grid, place.index);
                    let index = self.layers[local].insert(grid, &site, number);
                    #[allow(clippy::cast_possible_truncation)]
                    let layer = local as u32;
                    places[trial.chosen] = Place { layer, index };
                }
                targets.disturb(site.position);
                outcome.accepted += 1;
                if record {
                    let displacement = Vector3::from(trials.displacements(number));
                    outcome.moves.push(AcceptedMove { from_height, displacement });
                }
            }
        }
    }

    /// Lists the spheres of the domain, and returns the number of its cells.
    fn list(&self, grid: &Grid, [rows, columns]: [Stretch; 2], places: &mut Vec<Place>) -> usize {
        places.clear();
        let whole = rows.is_whole() && columns.is_whole();
        for (number, layer) in (0..).zip(self.layers.iter()).take(self.layers.len() - 1).skip(1) {
            if whole {
                // Written without a branch, and overwritten where there is a gap.
                let mut listed = places.len();
                places.resize(listed + layer.spheres.len(), Place::default());
                for (index, sphere) in (0..).zip(&layer.spheres) {
                    places[listed] = Place { layer: number, index };
                    listed += usize::from(sphere.number != NOBODY);
                }
                places.truncate(listed);
                continue;
            }
            for row in rows.cells() {
                for column in columns.cells() {
                    let spheres = layer.indices_in(grid.cell(row, column));
                    places.extend(spheres.map(|index| Place { layer: number, index }));
                }
            }
        }
        rows.length() * columns.length() * (self.layers.len() - 2)
    }
}
