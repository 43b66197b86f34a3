//! The first sphere that a sphere meets when it moves straight along an axis.

use super::Configuration;
use super::grid::Spot;
use super::layer::{Layer, NONE, Sphere};
use super::page::{NOBODY, Page};
use wide::{f32x4, u32x4};

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

/// A straight move that is looking for its end.
struct Search {
    moving: u32,
    /// What stands for it in pages, where it may be met.
    own: u32x4,
    position: [f64; 3],
    axis: usize,
    forward: bool,
    /// Squared distance at which spheres touch.
    contact: f64,
    widths: [f64; 2],
    nearest: f64,
    found: u32,
    separation: f64,
}

impl Search {
    /// Distance from the moving sphere to a coordinate of another along a periodic axis.
    #[inline]
    fn image(&self, axis: usize, other: f64) -> f64 {
        let distance = (self.position[axis] - other).abs();
        distance.min(self.widths[axis - 1] - distance)
    }

    /// How far ahead a coordinate along the axis of motion is; negative behind it.
    #[inline]
    fn ahead(&self, other: f64) -> f64 {
        let distance =
            if self.forward { other - self.position[self.axis] } else { self.position[self.axis] - other };
        if self.axis == 0 || distance >= 0.0 { distance } else { distance + self.widths[self.axis - 1] }
    }

    #[inline]
    fn consider(&mut self, sphere: &Sphere) {
        let other = sphere.position;
        let ahead = self.ahead(other[self.axis]);
        let across = match self.axis {
            0 => [self.image(1, other[1]), self.image(2, other[2])],
            1 => [self.position[0] - other[0], self.image(2, other[2])],
            _ => [self.position[0] - other[0], self.image(1, other[1])],
        };
        let room = self.contact - across[0] * across[0] - across[1] * across[1];
        if room > 0.0 && ahead > 0.0 && sphere.number != self.moving {
            // A pair that already touches to rounding passes the motion on at once.
            let distance = (ahead - room.sqrt()).max(0.0);
            if distance < self.nearest {
                (self.nearest, self.found, self.separation) = (distance, sphere.number, ahead - distance);
            }
        }
    }

    /// Those spheres of a page that may be touched before the nearest known, one bit for each.
    ///
    /// In single precision, with a margin for its rounding, which grows with the `steps` gone.
    #[inline]
    fn within_reach(&self, relative: [f32x4; 3], shift: &[f32x4; 3], page: &Page, steps: u32) -> u32 {
        let apart = [
            page.x + shift[0] - relative[0],
            page.y + shift[1] - relative[1],
            page.z + shift[2] - relative[2],
        ];
        #[allow(clippy::cast_possible_truncation, clippy::cast_precision_loss)]
        let (nearest, margin) = (self.nearest as f32, 2e-5 + 1e-5 * steps as f32);
        let along = apart[self.axis];
        let ahead = if self.forward { along } else { -along };
        let beyond = (ahead - f32x4::splat(nearest)).fast_max(f32x4::splat(0.0));
        let squares = apart.map(|along| along * along);
        let across = squares[(self.axis + 1) % 3] + squares[(self.axis + 2) % 3] + page.masked(self.own);
        let near = (across + beyond * beyond).simd_lt(f32x4::splat(1.0 + margin));
        (near & ahead.simd_gt(f32x4::splat(-margin))).to_bitmask()
    }

    /// The spheres of a cell, given its first page.
    #[inline]
    fn consider_cell(
        &mut self,
        layer: &Layer,
        head: u32,
        relative: [f32x4; 3],
        shift: &[f32x4; 3],
        steps: u32,
    ) {
        let mut number = head >> 1;
        loop {
            let page = &layer.pages[number as usize];
            let mut slots = self.within_reach(relative, shift, page, steps);
            while slots != 0 {
                let occupant = page.occupants.to_array()[slots.trailing_zeros() as usize & 3];
                slots &= slots - 1;
                self.consider(layer.sphere_of(occupant));
            }
            if head & 1 == 0 {
                return;
            }
            number = layer.next[number as usize];
            if number == NONE {
                return;
            }
        }
    }
}

impl Configuration {
    /// The first sphere that `sphere` touches on its way along `axis` (`forward` or
    /// backward) within `limit`, if there is one.
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
        let place = self.places[sphere];
        let position = self.position(sphere);
        // The scene limits the number of spheres to u32.
        #[allow(clippy::cast_possible_truncation)]
        let moving = sphere as u32;
        let mut search = Search {
            moving,
            own: u32x4::splat(self.layers[place.layer as usize].occupant(place.index)),
            position,
            axis,
            forward,
            contact: self.grid.contact,
            widths: self.grid.widths,
            nearest: limit,
            found: u32::MAX,
            separation: f64::NAN,
        };
        let grid = &self.grid;
        let spot = grid.spot(position);
        let mut at = [spot.layer as usize, spot.y as usize, spot.z as usize];
        let mut relative = grid.relative(&spot, position).map(f32x4::splat);
        // From the position to the near side of the plane of cells, less what a sphere there reaches out.
        let side = grid.sides[axis];
        let within = position[axis] - at[axis] as f64 * side;
        let mut reach = if forward { -within } else { within - side } - 1.0 - 1e-9;
        for steps in 0.. {
            self.consider_plane(&mut search, &spot, at, relative, steps);
            reach += side;
            if reach > search.nearest {
                break;
            }
            let last = grid.cells[axis] - 1;
            at[axis] = match (axis, forward) {
                (0, true) if at[0] == last => break,
                (0, false) if at[0] == 0 => break,
                (_, true) if at[axis] == last => 0,
                (_, true) => at[axis] + 1,
                (_, false) if at[axis] == 0 => last,
                (_, false) => at[axis] - 1,
            };
            if axis == 0 {
                // Elsewhere the same may stand for another.
                search.own = u32x4::splat(NOBODY);
            }
            let gone = f64::from(steps + 1) * side;
            #[allow(clippy::cast_possible_truncation)]
            let relative_along = if forward { within - gone } else { within + gone } as f32;
            relative[axis] = f32x4::splat(relative_along);
        }
        (search.found != u32::MAX).then_some(Contact {
            distance: search.nearest,
            sphere: search.found as usize,
            separation: search.separation,
        })
    }

    /// The spheres of the cell at `at` and of those around it across the axis of motion.
    #[inline]
    fn consider_plane(
        &self,
        search: &mut Search,
        start: &Spot,
        at: [usize; 3],
        relative: [f32x4; 3],
        steps: u32,
    ) {
        let Some(layers) = self.layers.get(at[0]..at[0] + 3) else { return };
        let cell = self.grid.cell(at[1], at[2]);
        let nearby = |layer: usize| u32::from(layers[layer].nearby[cell]) << (9 * layer);
        let occupied = if search.axis == 0 { nearby(1) } else { nearby(0) | nearby(1) | nearby(2) };
        let mut cells = occupied & self.grid.across(start, search.axis);
        while cells != 0 {
            let neighbour = &self.grid.neighbours[cells.trailing_zeros() as usize & 31];
            cells &= cells - 1;
            let layer = &layers[neighbour.layer];
            let head = layer.heads[cell.wrapping_add(neighbour.cell)];
            search.consider_cell(layer, head, relative, &neighbour.shift, steps);
        }
    }
}

#[cfg(test)]
mod tests;
