//! The first sphere that a sphere meets when it moves straight along an axis.

use super::Configuration;
use super::grid::Spot;
use super::layer::{Layer, NONE, Sphere};
use super::page::{NOBODY, Page};
use wide::f32x4;

/// What stops a sphere that moves along an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Contact {
    /// Distance that the sphere can go.
    pub(crate) distance: f64,
    /// Sphere that it touches then.
    pub(crate) sphere: usize,
    /// From the one to the other along the axis when they touch, in the direction of the motion.
    pub(crate) separation: f64,
}

impl Contact {
    /// Whether it is met first. Of two that are touched at once, as in a crystal, the number decides, not the order in memory,
    /// which a run that goes on from a snapshot does not share.
    #[inline]
    fn comes_before(&self, nearest: &Self) -> bool {
        self.distance < nearest.distance
            || (self.distance.to_bits() == nearest.distance.to_bits()
                && nearest.sphere != NOBODY as usize
                && self.sphere < nearest.sphere)
    }
}

/// Bound on the error of coordinates and their squares in single precision, within two cells.
const ROUNDING: f32 = 1.0 / (1 << 16) as f32;

/// A straight move that is looking for its end.
#[derive(Clone, Copy)]
struct Way {
    moving: u32,
    position: [f64; 3],
    spot: Spot,
    forward: bool,
    limit: f64,
}

/// Cells that are looked at together: at one index along the axis, in one layer.
#[derive(Clone, Copy)]
struct Plane<'a> {
    layer: &'a Layer,
    /// Number of cells along the way from that of the start.
    step: u32,
}

/// The way in single precision, which tells what spheres may block it; double precision decides.
struct Outlook<const AXIS: usize> {
    /// Position relative to its cell, seen from the cells before, at and after it, across the way.
    across: [[f32; 3]; 2],
    along: f32x4,
    sign: f32x4,
    side: f32,
}

impl<const AXIS: usize> Outlook<AXIS> {
    /// The axes across the way.
    const ACROSS: [usize; 2] = [[1, 2], [0, 2], [0, 1]][AXIS];

    /// The spheres of a page that may be in the way: not behind, less than one diameter off across, and
    /// within reach of `nearest`. One bit for each.
    #[inline]
    fn in_the_way(&self, page: &Page, [first, second]: [f32x4; 2], advance: f32x4, nearest: f32) -> u32 {
        let coordinates = [page.x, page.y, page.z];
        let [one, other] = Self::ACROSS.map(|axis| coordinates[axis]);
        let (a, b) = (first - one, second - other);
        let room = f32x4::splat(1.0 + ROUNDING) - a * a - b * b;
        let ahead = self.sign * (coordinates[AXIS] - self.along) + advance;
        let beyond = (ahead - f32x4::splat(nearest)).fast_max(f32x4::ZERO);
        (room.simd_gt(beyond * beyond) & ahead.simd_gt(f32x4::splat(-ROUNDING))).to_bitmask()
    }
}

impl Configuration {
    /// The first sphere that `sphere` touches on its way along `axis` (`forward` or backward) within
    /// `limit`, if there is one.
    ///
    /// Spheres touch at a distance that exceeds one diameter by a few roundings of the largest coordinate,
    /// so that no move to a contact makes an overlap. Along a periodic axis `limit` must not exceed half
    /// the width.
    #[inline]
    pub(crate) fn first_contact(
        &self,
        sphere: usize,
        axis: usize,
        forward: bool,
        limit: f64,
    ) -> Option<Contact> {
        // The scene limits the number of spheres to u32.
        #[allow(clippy::cast_possible_truncation)]
        let moving = sphere as u32;
        let position = self.position(sphere);
        let way = Way { moving, position, spot: self.grid.spot(position), forward, limit };
        // Compiled once for each axis.
        match axis {
            0 => self.first_contact_along::<0>(&way),
            1 => self.first_contact_along::<1>(&way),
            _ => self.first_contact_along::<2>(&way),
        }
    }

    #[inline]
    fn first_contact_along<const AXIS: usize>(&self, way: &Way) -> Option<Contact> {
        let relative = self.grid.relative(&way.spot, way.position);
        // Single precision is meant.
        #[allow(clippy::cast_possible_truncation)]
        let sides = self.grid.sides.map(|side| side as f32);
        let outlook = Outlook::<AXIS> {
            across: Outlook::<AXIS>::ACROSS
                .map(|axis| [relative[axis] + sides[axis], relative[axis], relative[axis] - sides[axis]]),
            along: f32x4::splat(relative[AXIS]),
            sign: f32x4::splat(if way.forward { 1.0 } else { -1.0 }),
            side: sides[AXIS],
        };
        let mut nearest = Contact { distance: way.limit, sphere: NOBODY as usize, separation: f64::NAN };
        self.look_along::<AXIS>(way, &mut nearest, |nearest, plane, cell, offsets| {
            let across = [0, 1].map(|side| f32x4::splat(outlook.across[side][offsets[side]]));
            let advance = f32x4::splat(outlook.side * plane.step as f32);
            let head = plane.layer.heads[cell];
            let mut link = head >> 1;
            loop {
                let page = &plane.layer.pages[link as usize];
                // Single precision is meant.
                #[allow(clippy::cast_possible_truncation)]
                let reach = nearest.distance as f32 + ROUNDING;
                let mut near = outlook.in_the_way(page, across, advance, reach);
                while near != 0 {
                    let occupant = page.occupants.to_array()[near.trailing_zeros() as usize & 3];
                    near &= near - 1;
                    if let Some(contact) = self.contact::<AXIS>(way, plane.layer.sphere_of(occupant))
                        && contact.comes_before(nearest)
                    {
                        *nearest = contact;
                    }
                }
                if head & 1 == 0 {
                    return;
                }
                link = plane.layer.next[link as usize];
                if link == NONE {
                    return;
                }
            }
        });
        (nearest.sphere != NOBODY as usize).then_some(nearest)
    }

    /// How another sphere blocks the way, if it does.
    #[inline]
    fn contact<const AXIS: usize>(&self, way: &Way, other: &Sphere) -> Option<Contact> {
        let [a, b] = Outlook::<AXIS>::ACROSS.map(|axis| {
            let distance = (way.position[axis] - other.position[axis]).abs();
            if axis == 0 { distance } else { distance.min(self.grid.widths[axis - 1] - distance) }
        });
        let room = self.grid.contact - a * a - b * b;
        let along = other.position[AXIS] - way.position[AXIS];
        let ahead = if way.forward { along } else { -along };
        // What is behind along a periodic axis is ahead as well.
        let ahead = if AXIS == 0 || ahead >= 0.0 { ahead } else { ahead + self.grid.widths[AXIS - 1] };
        if room <= 0.0 || ahead <= 0.0 || other.number == way.moving {
            return None;
        }
        // A pair that already touches to rounding passes the motion on at once.
        let distance = (ahead - room.sqrt()).max(0.0);
        Some(Contact { distance, sphere: other.number as usize, separation: ahead - distance })
    }

    /// Shows the occupied cells along the way to `enter`, plane by plane, as far as the nearest contact.
    #[inline]
    fn look_along<'a, const AXIS: usize>(
        &'a self,
        way: &Way,
        nearest: &mut Contact,
        mut enter: impl FnMut(&mut Contact, Plane<'a>, usize, [usize; 2]),
    ) {
        let mut along = [way.spot.layer, way.spot.y, way.spot.z][AXIS] as usize;
        let (cells, side) = (self.grid.cells[AXIS], self.grid.sides[AXIS]);
        // From the position to the near side of the next cells, less what a sphere there reaches out.
        let within = way.position[AXIS] - along as f64 * side;
        let mut reach = if way.forward { side - within } else { within } - 1.0 - 1e-9;
        let mut step = 0;
        loop {
            self.look_across::<AXIS>(&way.spot, along, step, |plane, cell, offsets| {
                enter(nearest, plane, cell, offsets);
            });
            if reach > nearest.distance {
                return;
            }
            reach += side;
            step += 1;
            let at_end = if way.forward { along + 1 == cells } else { along == 0 };
            along = match (at_end, way.forward) {
                (true, _) if AXIS == 0 => return,
                (true, true) => 0,
                (true, false) => cells - 1,
                (false, true) => along + 1,
                (false, false) => along - 1,
            };
        }
    }

    /// The occupied cells among the nine around the start across the way, at one index along it.
    #[inline]
    fn look_across<'a, const AXIS: usize>(
        &'a self,
        spot: &Spot,
        along: usize,
        step: u32,
        mut enter: impl FnMut(Plane<'a>, usize, [usize; 2]),
    ) {
        let plane = |number: usize| Plane { layer: &self.layers[number], step };
        if AXIS == 0 {
            // The first layer is what is beyond the wall.
            let plane = plane(along + 1);
            let cell = spot.cell as usize;
            each(plane.layer.nearby[cell], |bit| {
                let neighbor = cell.wrapping_add(self.grid.neighbors[bit].cell);
                enter(plane, neighbor, [bit / 3, bit % 3]);
            });
            return;
        }
        // Of the nine cells around one in the same layer, those that lie across.
        let (cell, in_plane) = if AXIS == 1 {
            (self.grid.cell(along, spot.z as usize), 0b000_111_000)
        } else {
            (self.grid.cell(spot.y as usize, along), 0b010_010_010)
        };
        for height in 0..3 {
            // A layer beyond a wall has no cells.
            let plane = plane(spot.layer as usize + height);
            let nearby = plane.layer.nearby.get(cell).copied().unwrap_or(0);
            each(nearby & in_plane, |bit| {
                let neighbor = cell.wrapping_add(self.grid.neighbors[bit].cell);
                enter(plane, neighbor, [height, if AXIS == 1 { bit % 3 } else { bit / 3 }]);
            });
        }
    }
}

/// Calls `visit` with the number of each bit that is set.
#[inline]
fn each(mut bits: u16, mut visit: impl FnMut(usize)) {
    while bits != 0 {
        visit(bits.trailing_zeros() as usize);
        bits &= bits - 1;
    }
}

#[cfg(test)]
mod tests;
