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

/// What all tiles of a cut read.
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

/// What becomes of a chain that runs into a frozen sphere.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Frozen {
    /// It turns round.
    #[default]
    Turns,
    /// Wrong, to show that tests notice: it ends.
    #[cfg(test)]
    Ends,
}

/// A sphere that has moved.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moved {
    /// In its layer.
    pub(super) index: u32,
    /// Where it is now along the axis.
    pub(super) along: f64,
}

/// What the chains of a visit came to.
#[derive(Debug, Default)]
pub(super) struct Outcome {
    pub(super) events: u64,
    pub(super) chains: u64,
    pub(super) path: f64,
    pub(super) field_events: u64,
    /// Filled only if somebody wants to know.
    pub(super) pieces: Vec<ChainPiece>,
    lengths: Vec<f64>,
    /// Spheres that moved, layer by layer.
    moved: Vec<Moved>,
    /// The first layer, and where those of each end.
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

    /// Tells what happened, in the order in which it did.
    pub(super) fn tell(&self, axis: usize, recorder: &mut dyn Recorder) {
        recorder.record_pieces(axis, &self.pieces);
        for &length in &self.lengths {
            recorder.record_chain(axis, length);
        }
    }
}

/// A sphere as it is found.
#[derive(Debug, Clone, Copy)]
struct Found {
    along: f64,
    across: [f64; 2],
    number: u32,
    /// In its layer.
    index: u32,
    column: u32,
    mobile: bool,
}

/// A copy of what a tile contains, and the memory for the next.
#[derive(Debug, Clone, Default)]
pub(super) struct Tile {
    /// Layer by layer.
    found: Vec<Found>,
    /// The first layer, and where those of each end.
    first_layer: usize,
    ends: Vec<u32>,
    /// Coordinate along the axis, as a whole number of the same order, number and place among those
    /// found, in this order.
    order: Vec<(u64, u32, u32)>,
    slices: Vec<u32>,
    /// Which sphere of the tile each of those found is.
    spheres: Vec<u32>,
    candidates: Vec<Candidate>,
    pub(super) constraints: Constraints,
    /// Coordinates of the spheres along the axis, the mobile ones first. Beyond the ends of a
    /// periodic axis they go on.
    pub(super) along: Vec<f64>,
    /// Heights of the spheres, for recorders of chains across.
    pub(super) heights: Vec<f64>,
    pub(super) mobile: usize,
}

impl Tile {
    /// Runs the chains of a visit; the configuration stays as it is.
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
        // In proportion to the number of spheres, or those of crowded tiles would move less.
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
            // One that goes on in the direction of the last undoes nothing. The field turns vertical ones
            // round anyway.
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
        // Where most of a layer is in reach, spheres are read in the order of memory.
        let whole = (1..3).all(|axis| ranges[axis].1 == grid.cells[axis]);
        // The first layer is what is beyond the wall.
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

    /// Brings the spheres into their order along the axis: roughly, then within slices.
    fn sort(&mut self) {
        /// Spheres of a slice, on average.
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
            // Numbers make the order unique, whatever the cells did with it.
            order[*next as usize] = (found.along.to_bits(), found.number, place);
            *next += 1;
        }
        let mut begin = 0;
        for &end in &slices[..count] {
            order[begin..end as usize].sort_unstable();
            begin = end as usize;
        }
    }

    /// Numbers the spheres, mobile ones first and column by column, so that those near each other
    /// are kept together.
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

    /// Notes where spheres have gone.
    fn list_moved<F, T, D>(&self, common: &Common<'_, F, T, D>, outcome: &mut Outcome) {
        outcome.first_layer = self.first_layer;
        let mut begin = 0;
        for &end in &self.ends {
            let listed = outcome.moved.len();
            let places = begin as usize..end as usize;
            for (found, &sphere) in self.found[places.clone()].iter().zip(&self.spheres[places]) {
                let along = self.along[sphere as usize];
                // The same to the last bit: it has not moved.
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
            // Whatever the order of the cells was.
            outcome.moved[listed..].sort_unstable_by_key(|moved| moved.index);
            // The scene limits the number of spheres to u32.
            #[allow(clippy::cast_possible_truncation)]
            outcome.ends.push(outcome.moved.len() as u32);
            begin = end;
        }
    }
}
