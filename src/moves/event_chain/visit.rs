//! The chains of one visit to a tile.

use super::constraints::{Candidate, Columns, Constraints};
use super::cut::{Cut, Section};
use super::force_bound::ForceBounds;
use super::stall_guard::StallGuard;
use super::{FieldEvent, field_event};
use crate::configuration::{Grid, Layer};
use crate::drive::Drive;
use crate::frame::Phase;
use crate::observer::{AcceptedMove, Collision, Recorder};
use crate::random::{Generator, exponential, index, unit};
use crate::{Error, Field, Scene, TemperatureProfile};
use nalgebra::Vector3;

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
    /// Mean of the chains of a visit together, per mobile sphere.
    pub(super) path: f64,
    /// Mean of a chain.
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

/// What a recorder is told.
#[derive(Debug, Clone, Copy)]
pub(super) enum Event {
    Move(AcceptedMove),
    Collision(Collision),
    Chain(f64),
}

/// What the chains of a visit came to.
#[derive(Debug, Default)]
pub(super) struct Outcome {
    pub(super) events: u64,
    pub(super) chains: u64,
    pub(super) path: f64,
    pub(super) field_events: u64,
    /// Filled only if somebody wants to know.
    recorded: Vec<Event>,
    /// Layer and index of spheres that moved, and where they are now along the axis.
    pub(super) moved: Vec<(u32, u32, f64)>,
    pub(super) error: Option<Error>,
}

impl Outcome {
    fn clear(&mut self) {
        (self.events, self.chains, self.path, self.field_events) = (0, 0, 0.0, 0);
        self.recorded.clear();
        self.moved.clear();
        self.error = None;
    }

    /// Tells what happened, in the order in which it did.
    pub(super) fn tell(&self, axis: usize, recorder: &mut dyn Recorder) {
        for event in &self.recorded {
            match event {
                Event::Move(accepted) => recorder.record_move(accepted),
                Event::Collision(collision) => recorder.record_collision(collision),
                Event::Chain(length) => recorder.record_chain(axis, *length),
            }
        }
    }
}

/// A sphere as it is found.
#[derive(Debug, Clone, Copy)]
struct Found {
    along: f64,
    across: [f64; 2],
    number: u32,
    layer: u32,
    index: u32,
    mobile: bool,
}

/// A copy of what a tile contains, and the memory for the next.
#[derive(Debug, Clone, Default)]
pub(super) struct Tile {
    found: Vec<Found>,
    candidates: Vec<Candidate>,
    constraints: Constraints,
    /// Coordinates of the spheres along the axis, the mobile ones first. Beyond the ends of a periodic axis they go on.
    along: Vec<f64>,
    /// Heights of the spheres, for recorders of chains across.
    heights: Vec<f64>,
    mobile: usize,
}

/// What ends a straight piece.
enum Stop {
    End,
    Contact { sphere: usize, reach: f64 },
    Wall,
    Field { bound: f64 },
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
        self.gather(common.axis, common.grid, layers, sections);
        if self.mobile == 0 {
            return;
        }
        self.constrain(common, sections);
        // In proportion to the number of spheres, or those of crowded tiles would move less; random, so that the last chain, which
        // is cut short, is not commensurate with anything.
        let mut left = (0.5 + unit(generator)) * common.path * self.mobile as f64;
        while left > 0.0 {
            let length = (2.0 * common.length * unit(generator)).min(left);
            left -= length;
            let mut rest = length;
            let ended = self.chain(common, &mut rest, generator, outcome);
            let path = length - rest;
            outcome.path += path;
            if let Err(error) = ended {
                outcome.error = Some(error);
                break;
            }
            outcome.chains += 1;
            if common.record {
                outcome.recorded.push(Event::Chain(path));
            }
        }
        self.list_moved(common, outcome);
    }

    /// Lists the spheres in and beside a tile.
    fn gather(&mut self, axis: usize, grid: &Grid, layers: &[Layer], sections: [Section; 2]) {
        self.found.clear();
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
        // The first layer is what is beyond the wall.
        for number in wrapped(0).map(|layer| layer + 1) {
            let layer = &layers[number];
            for y in wrapped(1) {
                for z in wrapped(2) {
                    for index in layer.indices_in(grid.cell(y, z)) {
                        let sphere = &layer.spheres[index as usize];
                        let [first, second] =
                            [0, 1].map(|side: usize| sections[side].locate(sphere.position[across[side]]));
                        let (Some((first, in_first)), Some((second, in_second))) = (first, second) else {
                            continue;
                        };
                        // Layers are at most as many as fit a u32.
                        #[allow(clippy::cast_possible_truncation)]
                        let layer = number as u32;
                        self.found.push(Found {
                            along: sphere.position[axis],
                            across: [first, second],
                            number: sphere.number,
                            layer,
                            index,
                            mobile: in_first && in_second,
                        });
                    }
                }
            }
        }
        // Numbers make the order unique, whatever the cells did with it.
        self.found.sort_unstable_by(|a, b| a.along.total_cmp(&b.along).then(a.number.cmp(&b.number)));
        self.mobile = self.found.iter().filter(|found| found.mobile).count();
    }

    /// Numbers the spheres and finds out who can touch whom.
    fn constrain<F, T, D>(&mut self, common: &Common<'_, F, T, D>, sections: [Section; 2]) {
        let columns =
            Columns::new(sections.map(|section| section.extent()), sections.map(|section| section.repeats()));
        self.candidates.clear();
        self.along.clear();
        self.along.resize(self.found.len(), 0.0);
        let (mut mobile, mut frozen) = (0, self.mobile);
        for found in &self.found {
            let next = if found.mobile { &mut mobile } else { &mut frozen };
            self.along[*next] = found.along;
            // The scene limits the number of spheres to u32.
            #[allow(clippy::cast_possible_truncation)]
            let sphere = *next as u32;
            *next += 1;
            let column = columns.column(found.across);
            self.candidates.push(Candidate { across: found.across, sphere, column });
        }
        if common.record && common.axis != 0 {
            self.heights.clear();
            self.heights.resize(self.found.len(), 0.0);
            for candidate in &self.candidates {
                self.heights[candidate.sphere as usize] = candidate.across[0] + sections[0].low();
            }
        }
        let period = (common.axis > 0).then(|| common.grid.widths[common.axis - 1]);
        self.constraints.find(&columns, &self.candidates, self.mobile, common.grid.contact(), period);
    }

    /// A chain with `left` to go, as in an undivided system, except that spheres beside the tile are walls.
    fn chain<F: Field, T: TemperatureProfile, D: Drive<F, T>>(
        &mut self,
        common: &Common<'_, F, T, D>,
        left: &mut f64,
        generator: &mut Generator,
        outcome: &mut Outcome,
    ) -> Result<(), Error> {
        let slab = common.scene.slab();
        let vertical = common.axis == 0;
        let (lowest, highest) = (slab.lowest_center(), slab.highest_center());
        let mut sphere = index(generator, self.mobile);
        let mut forward = unit(generator) < 0.5;
        let mut stall_guard = StallGuard::between_frozen(*left, common.phase);
        let mut clock = if vertical { exponential(generator) } else { f64::INFINITY };
        loop {
            let from = self.along[sphere];
            let (mut distance, mut stop) = (*left, Stop::End);
            if vertical {
                let to_wall = if forward { highest - from } else { from - lowest };
                if to_wall < distance {
                    (distance, stop) = (to_wall, Stop::Wall);
                }
            }
            let (mut nearest, mut touched, mut touch) = (distance, u32::MAX, 0.0);
            for link in self.constraints.links(sphere, forward) {
                let ahead = self.along[link.other as usize] - from;
                let gap = if forward { ahead } else { -ahead } - link.reach;
                if gap < nearest {
                    (nearest, touched, touch) = (gap, link.other, link.reach);
                }
            }
            if touched != u32::MAX {
                // A pair that already touches to rounding passes the motion on at once.
                distance = nearest.max(0.0);
                stop = Stop::Contact { sphere: touched as usize, reach: touch };
            }
            if vertical
                && let Some((event, bound)) =
                    common.bounds.thinning_event(&mut clock, from, forward, distance)
            {
                (distance, stop) = (event, Stop::Field { bound });
            }
            let signed = if forward { distance } else { -distance };
            let to = if vertical { (from + signed).clamp(lowest, highest) } else { from + signed };
            self.along[sphere] = to;
            *left -= distance;
            if common.record {
                let mut displacement = Vector3::zeros();
                displacement[common.axis] = signed;
                let from_height = if vertical { from } else { self.heights[sphere] };
                let chain_axis = Some(common.axis);
                outcome.recorded.push(Event::Move(AcceptedMove { from_height, displacement, chain_axis }));
            }
            if !stall_guard.lasts(*left)? {
                return Ok(());
            }
            match stop {
                Stop::End => return Ok(()),
                Stop::Wall => {
                    outcome.events += 1;
                    forward = !forward;
                }
                Stop::Contact { sphere: other, reach } => {
                    outcome.events += 1;
                    if common.record {
                        let heights = if vertical { &self.along } else { &self.heights };
                        let (from_height, to_height) = (heights[sphere], heights[other]);
                        let period = if vertical { 0.0 } else { common.grid.widths[common.axis - 1] };
                        // Spheres that touch are at most one diameter apart, and a period is three at least.
                        let separation = if reach < -0.5 { reach + period } else { reach };
                        let axis = common.axis;
                        outcome.recorded.push(Event::Collision(Collision {
                            axis,
                            from_height,
                            to_height,
                            separation,
                        }));
                    }
                    if other < self.mobile {
                        sphere = other;
                    } else {
                        match common.frozen {
                            Frozen::Turns => forward = !forward,
                            #[cfg(test)]
                            Frozen::Ends => return Ok(()),
                        }
                    }
                }
                Stop::Field { bound } => {
                    clock = exponential(generator);
                    let force = common.drive.reduced_force(common.scene, to);
                    let uphill = if forward { force } else { -force };
                    if uphill.is_nan() || uphill > bound {
                        return Err(Error::InvalidForce { height: to, force, bound });
                    }
                    if unit(generator) * bound < uphill {
                        outcome.events += 1;
                        outcome.field_events += 1;
                        stall_guard.field_event();
                        let force_of = |other: usize| {
                            (self.along[other], common.drive.reduced_force(common.scene, self.along[other]))
                        };
                        (sphere, forward) =
                            field_event(common.rule, generator, self.mobile, sphere, force, force_of)?;
                    }
                }
            }
        }
    }

    /// Notes where spheres have gone.
    fn list_moved<F, T, D>(&self, common: &Common<'_, F, T, D>, outcome: &mut Outcome) {
        let mobile = self.found.iter().filter(|found| found.mobile);
        for (found, &along) in mobile.zip(&self.along) {
            // The same to the last bit: it has not moved.
            if found.along.to_bits() != along.to_bits() {
                let along = if common.axis == 0 {
                    along
                } else {
                    let width = common.grid.widths[common.axis - 1];
                    let within = along - width * (along / width).floor();
                    if within >= width { 0.0 } else { within.max(0.0) }
                };
                outcome.moved.push((found.layer, found.index, along));
            }
        }
    }
}
