//! The chains of one visit to a tile.

use super::FieldEvent;
use super::columns::Columns;
use super::constraints::{Candidate, Constraints};
use super::cut::{Cut, Section};
use super::force_bound::ForceBounds;
use crate::configuration::{Grid, Layer, NOBODY};
use crate::drive::Drive;
use crate::frame::Phase;
use crate::observer::{ChainPiece, Recorder};
use crate::random::{Generator, unit};
use crate::{Error, Field, Scene, TemperatureProfile};

/// Shared data of all tiles of a cut.
#[derive(Debug)]
pub(super) struct Common<'a, F, T, D> {
    pub(super) scene: &'a Scene<F, T>,
    pub(super) drive: &'a D,
    pub(super) bounds: &'a ForceBounds,
    pub(super) grid: &'a Grid,
    pub(super) rule: FieldEvent,
    pub(super) frozen: Frozen,
    pub(super) phase: Phase,
    pub(super) axis: usize,
    /// Mean number of chains of a visit, per mobile sphere.
    pub(super) chains: f64,
    /// Mean length of a chain.
    pub(super) length: f64,
    pub(super) record: bool,
}

/// How a chain continues at a frozen sphere.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Frozen {
    /// It reverses.
    #[default]
    Turns,
    /// A wrong rule that tests must detect: the chain ends.
    #[cfg(test)]
    Ends,
}

/// A sphere that has moved.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moved {
    /// Its index in its layer.
    pub(super) index: u32,
    /// Its new coordinate along the axis.
    pub(super) along: f64,
}

/// The results of the chains of a visit.
#[derive(Debug, Default)]
pub(super) struct Outcome {
    pub(super) events: u64,
    pub(super) chains: u64,
    pub(super) path: f64,
    pub(super) field_events: u64,
    /// Filled only if moves are recorded.
    pub(super) pieces: Vec<ChainPiece>,
    lengths: Vec<f64>,
    /// Spheres that moved, layer by layer.
    moved: Vec<Moved>,
    /// The first layer, and the end of each layer's part.
    first_layer: usize,
    ends: Vec<u32>,
    pub(super) error: Option<Error>,
}

impl Outcome {
    fn clear(&mut self) {
        (self.events, self.chains, self.path, self.field_events) = (0, 0, 0.0, 0);
        self.pieces.clear();
        self.lengths.clear();
        self.moved.clear();
        self.ends.clear();
        self.error = None;
    }

    /// Number of spheres that moved.
    pub(super) fn moved(&self) -> usize {
        self.moved.len()
    }

    /// Spheres of a layer that moved.
    pub(super) fn moved_from(&self, layer: usize) -> &[Moved] {
        let Some(place) = layer.checked_sub(self.first_layer) else { return &[] };
        let Some(&end) = self.ends.get(place) else { return &[] };
        let begin = place.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.moved[begin as usize..end as usize]
    }

    /// Passes the records on in the order of events.
    pub(super) fn tell(&self, axis: usize, recorder: &mut dyn Recorder) {
        recorder.record_pieces(axis, &self.pieces);
        for &length in &self.lengths {
            recorder.record_chain(axis, length);
        }
    }
}

/// A sphere in or beside a tile.
#[derive(Debug, Clone, Copy)]
struct Found {
    along: f64,
    across: [f64; 2],
    number: u32,
    /// Its index in its layer.
    index: u32,
    column: u32,
    mobile: bool,
}

/// A copy of the spheres of a tile, and memory that is reused for the next tile.
#[derive(Debug, Clone, Default)]
pub(super) struct Tile {
    /// The spheres, layer by layer.
    found: Vec<Found>,
    /// The first layer, and the end of each layer's part.
    first_layer: usize,
    ends: Vec<u32>,
    /// Sorted: the bits of the coordinate along the axis, the number of the sphere, and its index
    /// in `found`.
    order: Vec<(u64, u32, u32)>,
    slices: Vec<u32>,
    /// For each sphere of `found`, its number in the tile.
    spheres: Vec<u32>,
    candidates: Vec<Candidate>,
    pub(super) constraints: Constraints,
    /// Coordinates of the spheres along the axis, the mobile ones first. They are not wrapped at
    /// the ends of a periodic axis.
    pub(super) along: Vec<f64>,
    /// Heights of the spheres, for recorders of lateral chains.
    pub(super) heights: Vec<f64>,
    pub(super) mobile: usize,
}

impl Tile {
    /// Runs the chains of a visit, without changing the configuration.
    pub(super) fn visit<F: Field, T: TemperatureProfile, D: Drive<F, T>>(
        &mut self,
        common: &Common<'_, F, T, D>,
        layers: &[Layer],
        sections: [Section; 2],
        generator: &mut Generator,
        outcome: &mut Outcome,
    ) {
        outcome.clear();
        let columns =
            Columns::new(sections.map(|section| section.extent()), sections.map(|section| section.repeats()));
        self.gather(common.axis, common.grid, layers, sections, &columns);
        if self.mobile == 0 {
            return;
        }
        self.sort();
        self.number(&columns);
        if common.record && common.axis != 0 {
            self.heights.resize(self.found.len(), 0.0);
            for candidate in &self.candidates {
                self.heights[candidate.sphere as usize] = candidate.across[0] + sections[0].low();
            }
        }
        let period = (common.axis > 0).then(|| common.grid.widths[common.axis - 1]);
        self.constraints.find(&columns, &self.candidates, self.mobile, common.grid.contact(), period);
        self.run(common, generator, outcome);
        self.list_moved(common, outcome);
    }

    /// Runs the chains.
    fn run<F: Field, T: TemperatureProfile, D: Drive<F, T>>(
        &mut self,
        common: &Common<'_, F, T, D>,
        generator: &mut Generator,
        outcome: &mut Outcome,
    ) {
        // Proportional to the number of mobile spheres; otherwise spheres in dense tiles would move
        // less.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let chains = (common.chains * self.mobile as f64 + unit(generator)) as u64;
        let vertical = common.axis == 0;
        let chain = match (vertical, common.record) {
            (true, false) => Self::chain::<F, T, D, true, false>,
            (true, true) => Self::chain::<F, T, D, true, true>,
            (false, false) => Self::chain::<F, T, D, false, false>,
            (false, true) => Self::chain::<F, T, D, false, true>,
        };
        let mut forward = unit(generator) < 0.5;
        for number in 0..chains {
            // A lateral chain in the direction of the one before does not retrace its path.
            // Vertical chains are reversed by the field anyway.
            if vertical && number > 0 {
                forward = unit(generator) < 0.5;
            }
            let length = 2.0 * common.length * unit(generator);
            let mut left = length;
            let ended = chain(self, common, &mut left, &mut forward, generator, outcome);
            let path = length - left;
            outcome.path += path;
            if let Err(error) = ended {
                outcome.error = Some(error);
                return;
            }
            outcome.chains += 1;
            if common.record {
                outcome.lengths.push(path);
            }
        }
    }

    /// Lists the spheres in and beside a tile.
    fn gather(
        &mut self,
        axis: usize,
        grid: &Grid,
        layers: &[Layer],
        sections: [Section; 2],
        columns: &Columns,
    ) {
        let Self { found, ends, .. } = self;
        found.clear();
        ends.clear();
        let across = Cut::ACROSS[axis];
        let mut ranges = grid.cells.map(|cells| (0, cells));
        for (section, axis) in sections.iter().zip(across) {
            ranges[axis] = section.cells(grid.cells[axis], grid.sides[axis]);
        }
        let wrapped = |axis: usize| {
            let (first, count) = ranges[axis];
            let cells = grid.cells[axis];
            (first..first + count).map(move |cell| if cell >= cells { cell - cells } else { cell })
        };
        let mut mobile = 0;
        let mut find = |found: &mut Vec<Found>, layer: &Layer, index: u32| {
            let sphere = &layer.spheres[index as usize];
            let [first, second] =
                [0, 1].map(|side: usize| sections[side].locate(sphere.position[across[side]]));
            let (Some((first, in_first)), Some((second, in_second))) = (first, second) else {
                return;
            };
            mobile += usize::from(in_first && in_second);
            found.push(Found {
                along: sphere.position[axis],
                across: [first, second],
                number: sphere.number,
                index,
                column: columns.column([first, second]),
                mobile: in_first && in_second,
            });
        };
        // If whole layers are in reach, spheres are read in the order of memory.
        let whole = (1..3).all(|axis| ranges[axis].1 == grid.cells[axis]);
        // The first layer is beyond the wall.
        let (first, count) = ranges[0];
        self.first_layer = first + 1;
        for layer in &layers[first + 1..=first + count] {
            if whole {
                for (index, sphere) in (0..).zip(&layer.spheres) {
                    if sphere.number != NOBODY {
                        find(found, layer, index);
                    }
                }
            } else {
                for y in wrapped(1) {
                    for z in wrapped(2) {
                        layer.indices_in(grid.cell(y, z)).for_each(|index| find(found, layer, index));
                    }
                }
            }
            // The scene limits the number of spheres to u32.
            #[allow(clippy::cast_possible_truncation)]
            ends.push(found.len() as u32);
        }
        self.mobile = mobile;
    }

    /// Sorts the spheres along the axis: first into slices, then within slices.
    fn sort(&mut self) {
        /// Mean number of spheres in a slice.
        const SPHERES: usize = 8;
        let Self { found, order, slices, .. } = self;
        let largest = found.iter().fold(0.0, |largest, found| found.along.max(largest));
        let count = found.len() / SPHERES + 1;
        let scale = count as f64 / largest;
        // Coordinates are not negative.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let slice = |along: f64| ((along * scale) as usize).min(count - 1);
        slices.clear();
        slices.resize(count + 1, 0);
        for found in found.iter() {
            slices[slice(found.along) + 1] += 1;
        }
        for slice in 1..=count {
            slices[slice] += slices[slice - 1];
        }
        order.resize(found.len(), (0, 0, 0));
        for (place, found) in (0..).zip(found.iter()) {
            let next = &mut slices[slice(found.along)];
            // The number of the sphere makes the order unique.
            order[*next as usize] = (found.along.to_bits(), found.number, place);
            *next += 1;
        }
        let mut begin = 0;
        for &end in &slices[..count] {
            order[begin..end as usize].sort_unstable();
            begin = end as usize;
        }
    }

    /// Numbers the spheres, mobile ones first and column by column, so that neighbors are close in
    /// memory.
    fn number(&mut self, columns: &Columns) {
        let Self { found, order, slices: next, spheres, candidates, along, .. } = self;
        next.clear();
        next.resize(columns.count() + 1, 0);
        for found in found.iter().filter(|found| found.mobile) {
            next[found.column as usize + 1] += 1;
        }
        for column in 1..next.len() {
            next[column] += next[column - 1];
        }
        candidates.clear();
        spheres.resize(found.len(), 0);
        along.resize(found.len(), 0.0);
        let frozen = columns.count();
        for &(_, _, place) in order.iter() {
            let found = &found[place as usize];
            let next = &mut next[if found.mobile { found.column as usize } else { frozen }];
            let sphere = *next;
            *next += 1;
            spheres[place as usize] = sphere;
            along[sphere as usize] = found.along;
            candidates.push(Candidate { across: found.across, sphere, column: found.column });
        }
    }

    /// Lists the spheres that moved.
    fn list_moved<F, T, D>(&self, common: &Common<'_, F, T, D>, outcome: &mut Outcome) {
        outcome.first_layer = self.first_layer;
        let mut begin = 0;
        for &end in &self.ends {
            let listed = outcome.moved.len();
            let places = begin as usize..end as usize;
            for (found, &sphere) in self.found[places.clone()].iter().zip(&self.spheres[places]) {
                let along = self.along[sphere as usize];
                // Equal bits: it has not moved.
                if found.mobile && found.along.to_bits() != along.to_bits() {
                    let along = if common.axis == 0 {
                        along
                    } else {
                        let width = common.grid.widths[common.axis - 1];
                        let within = along - width * (along / width).floor();
                        if within >= width { 0.0 } else { within.max(0.0) }
                    };
                    outcome.moved.push(Moved { index: found.index, along });
                }
            }
            // In an order that does not depend on the cells.
            outcome.moved[listed..].sort_unstable_by_key(|moved| moved.index);
            // The scene limits the number of spheres to u32.
            #[allow(clippy::cast_possible_truncation)]
            outcome.ends.push(outcome.moved.len() as u32);
            begin = end;
        }
    }
}
