//! The trials of one domain.

use super::LocalMoves;
use super::domains::Stretch;
use crate::Scene;
use crate::configuration::{Grid, Layer, NOBODY, Probe, neighbours_of, wrap};
use crate::drive::{Drive, log_acceptance};
use crate::observer::AcceptedMove;
use crate::random::{Generator, index, unit};
use nalgebra::Vector3;
use rand::Rng;
use wide::f32x8;

/// Where a sphere of the domain is.
#[derive(Debug, Clone, Copy, Default)]
struct Place {
    layer: u32,
    index: u32,
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

/// Uniform on the odd integers in (−2³², 2³²), from 32 random bits: a trial and its reverse are proposed
/// with the same probability.
#[inline]
fn odd_integer(bits: u64) -> f64 {
    ((bits << 1 | 1).cast_signed() - (1 << 32)) as f64
}

/// Trials that are prepared together.
///
/// What becomes of a trial is hardly ever predictable, and a processor that has guessed wrong would have to
/// start the next one from nothing. One that comes near another, accepted after it was prepared, is
/// prepared again: the outcome is that of one trial after the other.
const BATCH: usize = 8;
/// Cells visited in preparation.
const EARLY: usize = 2;

/// A trial, drawn and looked at.
#[derive(Debug, Clone, Copy, Default)]
struct Trial {
    /// A number of the sphere, and three of the displacement, in 32 bits each.
    random: [u64; 2],
    /// Largest displacement, over 2³².
    scale: f64,
    chosen: usize,
    place: Place,
    probe: Probe,
    /// Layer that it leads to.
    local: u32,
    refused: bool,
}

impl Trial {
    #[inline]
    fn displacement(&self) -> [f64; 3] {
        [self.random[0] >> 32, self.random[1] & 0xffff_ffff, self.random[1] >> 32]
            .map(|bits| self.scale * odd_integer(bits))
    }

    /// Which way the displacement points: one bit for each axis along which it is positive.
    #[inline]
    fn octant(&self) -> usize {
        usize::from(self.random[0] >> 63 == 1)
            | usize::from(self.random[1] >> 31 & 1 == 1) << 1
            | usize::from(self.random[1] >> 63 == 1) << 2
    }
}

/// What trials of a domain have in common.
struct Rules<'a> {
    grid: &'a Grid,
    widths: [f64; 2],
    lowest: f64,
    highest: f64,
    rows: Stretch,
    columns: Stretch,
    tiled: bool,
}

/// Where the trials of a batch lead, in single precision, and which have to be prepared again.
struct Targets {
    coordinates: [f32x8; 3],
    stale: u32,
    widths: [f32x8; 2],
    reach: f32x8,
}

impl Targets {
    /// Marks the trials that a move to `position` may affect.
    #[inline]
    fn disturb(&mut self, position: [f64; 3]) {
        // Single precision is enough for a test with room to spare.
        #[allow(clippy::cast_possible_truncation)]
        let [x, y, z] = position.map(|coordinate| f32x8::splat(coordinate as f32));
        let dx = (self.coordinates[0] - x).abs();
        let dy = (self.coordinates[1] - y).abs();
        let dz = (self.coordinates[2] - z).abs();
        let (dy, dz) = (dy.fast_min(self.widths[0] - dy), dz.fast_min(self.widths[1] - dz));
        self.stale |= dx.fast_max(dy).fast_max(dz).simd_lt(self.reach).to_bitmask();
    }
}

impl Slice<'_> {
    /// Looks at trials as far as it can without a branch, step by step: each step waits for memory once,
    /// not once for every trial.
    #[inline]
    fn prepare(&self, rules: &Rules<'_>, places: &[Place], trials: &mut [Trial]) {
        let Rules { grid, widths, lowest, highest, rows, columns, tiled, .. } = *rules;
        #[allow(clippy::cast_possible_truncation)]
        let (first, moving) = (self.first as u32, (self.layers.len() - 2) as u32);
        for trial in trials.iter_mut() {
            trial.chosen = ((trial.random[0] & 0xffff_ffff) * places.len() as u64 >> 32) as usize;
            trial.place = places[trial.chosen];
        }
        for trial in trials.iter_mut() {
            let displacement = trial.displacement();
            let own = &self.layers[trial.place.layer as usize];
            let [x, y, z] = own.spheres[trial.place.index as usize].position;
            let height = x + displacement[0];
            let inside = (height >= lowest) & (height <= highest);
            // One that is refused is looked at where it starts.
            let position = [
                if inside { height } else { x },
                wrap(y + displacement[1], widths[0]),
                wrap(z + displacement[2], widths[1]),
            ];
            trial.refused = !inside;
            trial.probe.position = position;
        }
        for trial in trials.iter_mut() {
            let spot = grid.spot(trial.probe.position);
            let local = (spot.layer + 1).wrapping_sub(first);
            let beyond = local.wrapping_sub(1) >= moving;
            // One that leaves the domain is looked at wherever.
            trial.local = if beyond { 1 } else { local };
            trial.refused |= beyond;
            if tiled {
                trial.refused |= !(rows.contains(spot.y as usize) & columns.contains(spot.z as usize));
            }
            let near = (trial.place.layer + 1).wrapping_sub(local) < 3;
            let own = &self.layers[trial.place.layer as usize];
            let ignored = if near { own.occupant(trial.place.index) } else { NOBODY };
            trial.probe = Probe::new(grid, spot, trial.probe.position, ignored);
        }
        for trial in trials.iter_mut() {
            let octant = trial.octant();
            trial.probe.look_around(grid, neighbours_of(self.layers, trial.local as usize), octant);
        }
        if EARLY > 0 {
            for trial in trials.iter_mut() {
                trial.refused |= trial
                    .probe
                    .overlaps_early::<EARLY>(grid, neighbours_of(self.layers, trial.local as usize));
            }
        }
    }

    /// Makes as many trials as there are spheres in the domain.
    pub(super) fn visit<F, T, D: Drive<F, T>>(
        &mut self,
        common: &Common<'_, F, T, D>,
        [rows, columns]: [Stretch; 2],
        generator: &mut Generator,
        outcome: &mut Outcome,
        Scratch { places }: &mut Scratch,
    ) {
        let Common { scene, drive, grid, moves, record } = *common;
        self.list(grid, [rows, columns], places);
        let slab = *scene.slab();
        let rules = Rules {
            grid,
            widths: slab.widths(),
            lowest: slab.lowest_center(),
            highest: slab.highest_center(),
            rows,
            columns,
            tiled: !(rows.is_whole() && columns.is_whole()),
        };
        let size = moves.maximum_displacement();
        let scales = moves.sizes.map(|size| size * (1.0 / (1_u64 << 32) as f64));
        #[allow(clippy::cast_possible_truncation)]
        let mut targets = Targets {
            coordinates: [f32x8::splat(0.0); 3],
            stale: 0,
            widths: rules.widths.map(|width| f32x8::splat(width as f32)),
            reach: f32x8::splat(f64::max(1.25 + size, 0.25 + 2.0 * size) as f32),
        };
        let mut trials = [Trial::default(); BATCH];
        let mut left = places.len();
        while left > 0 {
            let batch = left.min(BATCH);
            left -= batch;
            let mut coordinates = [[0.0; BATCH]; 3];
            for trial in &mut trials[..batch] {
                trial.random = [generator.next_u64(), generator.next_u64()];
                let size = if moves.count == 1 { 0 } else { index(generator, moves.count) };
                trial.scale = scales[size];
            }
            self.prepare(&rules, places, &mut trials[..batch]);
            for (number, trial) in trials[..batch].iter().enumerate() {
                for axis in 0..3 {
                    #[allow(clippy::cast_possible_truncation)]
                    let coordinate = trial.probe.position[axis] as f32;
                    coordinates[axis][number] = coordinate;
                }
            }
            targets.coordinates = coordinates.map(f32x8::new);
            targets.stale = 0;
            for (number, trial) in trials[..batch].iter_mut().enumerate() {
                if targets.stale >> number & 1 == 1 {
                    self.prepare(&rules, places, std::slice::from_mut(trial));
                }
                if trial.refused {
                    continue;
                }
                let Trial { probe: Probe { spot, position, .. }, place, chosen, local, .. } = *trial;
                let local = local as usize;
                if trial.probe.overlaps(grid, neighbours_of(self.layers, local)) {
                    continue;
                }
                let own = &self.layers[place.layer as usize].spheres[place.index as usize];
                let (from_height, height) = (own.position[0], position[0]);
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
                if (place.layer as usize == local) & (own.cell == spot.cell) {
                    self.layers[local].shift(grid, place.index, &spot, position);
                } else {
                    let sphere = self.layers[place.layer as usize].remove(grid, place.index);
                    let index = self.layers[local].insert(grid, &spot, position, sphere.number);
                    #[allow(clippy::cast_possible_truncation)]
                    let layer = local as u32;
                    places[chosen] = Place { layer, index };
                }
                targets.disturb(position);
                outcome.accepted += 1;
                if record {
                    let displacement = Vector3::from(trial.displacement());
                    outcome.moves.push(AcceptedMove { from_height, displacement });
                }
            }
        }
    }

    /// Lists the spheres of the domain.
    fn list(&self, grid: &Grid, [rows, columns]: [Stretch; 2], places: &mut Vec<Place>) {
        places.clear();
        let whole = rows.is_whole() && columns.is_whole();
        for (number, layer) in (0..).zip(self.layers.iter()).take(self.layers.len() - 1).skip(1) {
            if whole {
                places.extend(layer.indices().map(|index| Place { layer: number, index }));
                continue;
            }
            for row in rows.cells() {
                for column in columns.cells() {
                    let spheres = layer.indices_in(grid.cell(row, column));
                    places.extend(spheres.map(|index| Place { layer: number, index }));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn displacements_are_symmetric_to_the_last_bit() {
        let largest = (1_u64 << 32) as f64;
        for bits in [0, 1, 0x7fff_ffff, 0x8000_0000, 0xffff_fffe, 0xffff_ffff] {
            let value = odd_integer(bits);
            assert_eq!(value, -odd_integer(0xffff_ffff - bits));
            assert!(value.abs() < largest && (value > 0.0) == (bits >> 31 == 1));
        }
    }
}
