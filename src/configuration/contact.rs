//! The first sphere that a sphere meets when it moves straight along an axis.

use super::Configuration;
use super::grid::periodic_neighbours;
use super::layer::{Layer, Sphere};

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

    /// The spheres of a cell.
    #[inline]
    fn consider_cell(&mut self, layer: &Layer, cell: usize) {
        for index in layer.indices_in(cell) {
            self.consider(&layer.spheres[index as usize]);
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
        let position = self.position(sphere);
        // The scene limits the number of spheres to u32.
        #[allow(clippy::cast_possible_truncation)]
        let moving = sphere as u32;
        let mut search = Search {
            moving,
            position,
            axis,
            forward,
            contact: self.grid.contact,
            widths: self.grid.widths,
            nearest: limit,
            found: u32::MAX,
            separation: f64::NAN,
        };
        let start = [0, 1, 2].map(|axis| self.grid.coordinate(axis, position[axis]));
        let mut layer = start[axis];
        // From the position to the near side of the layer, less what a sphere there reaches out.
        let side = self.grid.sides[axis];
        let within = position[axis] - layer as f64 * side;
        let mut reach = if forward { -within } else { within - side } - 1.0 - 1e-9;
        loop {
            self.consider_layer(&mut search, start, layer);
            reach += side;
            if reach > search.nearest {
                break;
            }
            layer = match (axis, forward) {
                (0, true) if layer + 1 == self.grid.cells[0] => break,
                (0, false) if layer == 0 => break,
                (_, true) => {
                    if layer + 1 == self.grid.cells[axis] {
                        0
                    } else {
                        layer + 1
                    }
                }
                (_, false) => {
                    if layer == 0 {
                        self.grid.cells[axis] - 1
                    } else {
                        layer - 1
                    }
                }
            };
        }
        (search.found != u32::MAX).then_some(Contact {
            distance: search.nearest,
            sphere: search.found as usize,
            separation: search.separation,
        })
    }

    /// The spheres of the nine cells around `start` across the axis, in one layer along it.
    #[inline]
    fn consider_layer(&self, search: &mut Search, start: [usize; 3], layer: usize) {
        let across = |axis: usize| periodic_neighbours(start[axis], self.grid.cells[axis]);
        let cell = |y: usize, z: usize| self.grid.cell(y, z);
        match search.axis {
            0 => {
                for y in across(1) {
                    for z in across(2) {
                        search.consider_cell(&self.layers[layer + 1], cell(y, z));
                    }
                }
            }
            axis => {
                for height in start[0]..start[0] + 3 {
                    for other in across(3 - axis) {
                        let (y, z) = if axis == 1 { (layer, other) } else { (other, layer) };
                        search.consider_cell(&self.layers[height], cell(y, z));
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
