//! Neighbour search: cells at least one diameter wide, whose spheres' coordinates are kept in pages.
//!
//! Most cells of a tall column are empty, and a page exists only for a cell that is not: memory is
//! proportional to the number of spheres, four bytes per cell apart, and what a trial touches stays in
//! the cache. Cells along x are contiguous, so the 27 cells around a point are nine runs of three.

mod contact;

pub(crate) use contact::Contact;

use crate::Slab;

/// Empty cells before the first and behind the last along x stand in for what is beyond the walls.
const PADDING: usize = 1;
/// Spheres per page.
const SLOTS: usize = 4;
/// Stands for "no page"; page 0 is never used.
const NONE: u32 = 0;

/// Height of an empty slot: out of reach of every sphere, so that a page is always tested whole,
/// without a branch per slot.
const NOWHERE: f64 = 1e9;

/// Some of the spheres of one cell. A cell that overflows chains pages; only the first of a chain may
/// be partly filled.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
struct Page {
    x: [f64; SLOTS],
    y: [f64; SLOTS],
    z: [f64; SLOTS],
    occupants: [u32; SLOTS],
    next: u32,
    count: u32,
}

impl Page {
    const EMPTY: Self = Self {
        x: [NOWHERE; SLOTS],
        y: [0.0; SLOTS],
        z: [0.0; SLOTS],
        occupants: [u32::MAX; SLOTS],
        next: NONE,
        count: 0,
    };

    fn set(&mut self, slot: usize, [x, y, z]: [f64; 3]) {
        (self.x[slot], self.y[slot], self.z[slot]) = (x, y, z);
    }

    fn get(&self, slot: usize) -> [f64; 3] {
        [self.x[slot], self.y[slot], self.z[slot]]
    }

    /// Whether each slot holds a sphere other than `ignored` nearer than one diameter to `position`.
    #[inline]
    // Both sides always: a lane is cheaper than a branch.
    #[allow(clippy::needless_bitwise_bool)]
    fn overlaps(&self, position: [f64; 3], widths: [f64; 2], ignored: u32) -> [bool; SLOTS] {
        std::array::from_fn(|slot| {
            // Absolute differences first: then the distance is the same to the last bit whichever of the
            // two spheres is being moved.
            let dx = position[0] - self.x[slot];
            let dy = (position[1] - self.y[slot]).abs();
            let dz = (position[2] - self.z[slot]).abs();
            let (dy, dz) = (dy.min(widths[0] - dy), dz.min(widths[1] - dz));
            (dx * dx + dy * dy + dz * dz < 1.0) & (self.occupants[slot] != ignored)
        })
    }
}

#[derive(Debug, Clone)]
pub(crate) struct CellList {
    /// Cells along x, y, z, without padding.
    cells: [usize; 3],
    /// Cells per unit length along x, y, z.
    inverse_sides: [f64; 3],
    /// Periodic widths along y, z.
    widths: [f64; 2],
    /// Squared distance at which a sphere that moves straight touches another.
    contact: f64,
    /// First page of each cell.
    heads: Vec<u32>,
    pages: Vec<Page>,
    /// Pages out of use.
    free: Vec<u32>,
    /// Place of each sphere: `page * SLOTS + slot`.
    places: Vec<u32>,
}

/// Number of cells that divide `extent` into sides of at least one diameter.
fn division(extent: f64) -> usize {
    // Extents are at least 2 and at most 1e6.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let cells = extent.floor() as usize;
    // A side that exceeds one diameter by rounding only could hide a neighbour two cells away.
    let marginal = extent > cells as f64 && extent / (cells as f64) < 1.0 + 1e-12;
    if marginal && cells > 3 { cells - 1 } else { cells }
}

impl CellList {
    pub(crate) fn new(slab: &Slab) -> Self {
        let widths = slab.widths();
        let extents = [slab.height(), widths[0], widths[1]];
        let cells = extents.map(division);
        let mut inverse_sides = [0.0; 3];
        for axis in 0..3 {
            inverse_sides[axis] = cells[axis] as f64 / extents[axis];
        }
        Self {
            cells,
            inverse_sides,
            widths,
            // Two coordinates differ by a few roundings of the largest, and a square by twice as many.
            contact: 1.0 + 1e-14 + 32.0 * f64::EPSILON * extents.into_iter().fold(1.0, f64::max),
            heads: vec![NONE; (cells[0] + 2 * PADDING) * cells[1] * cells[2]],
            pages: vec![Page::EMPTY],
            free: Vec::new(),
            places: Vec::new(),
        }
    }

    /// Cell index along `axis`.
    #[inline]
    // Positions are inside the slab, so the product is small and not negative.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    fn coordinate(&self, axis: usize, value: f64) -> usize {
        ((value * self.inverse_sides[axis]) as usize).min(self.cells[axis] - 1)
    }

    /// Index of the padded cell at `x` in the row at `y`, `z`.
    #[inline]
    fn cell(&self, x: usize, y: usize, z: usize) -> usize {
        (z * self.cells[1] + y) * (self.cells[0] + 2 * PADDING) + x + PADDING
    }

    #[inline]
    fn cell_of(&self, position: [f64; 3]) -> usize {
        self.cell(
            self.coordinate(0, position[0]),
            self.coordinate(1, position[1]),
            self.coordinate(2, position[2]),
        )
    }

    /// The cells at, before and after `index` along a periodic axis.
    #[inline]
    fn periodic_neighbours(index: usize, cells: usize) -> [usize; 3] {
        [
            index,
            if index == 0 { cells - 1 } else { index - 1 },
            if index + 1 == cells { 0 } else { index + 1 },
        ]
    }

    /// First page and slot whose sphere is nearer than one diameter to `position` and is not `ignored`.
    #[inline]
    fn find_overlap(&self, position: [f64; 3], ignored: u32) -> Option<(usize, usize)> {
        let x = self.coordinate(0, position[0]);
        let y = self.coordinate(1, position[1]);
        let z = self.coordinate(2, position[2]);
        // First the occupied cells without a branch, then their spheres: which cells are occupied is not
        // predictable, and a wrong guess costs more than an idle slot.
        let mut occupied = [NONE; 28];
        let mut pages = 0;
        for z in Self::periodic_neighbours(z, self.cells[2]) {
            for y in Self::periodic_neighbours(y, self.cells[1]) {
                let first = self.cell(x, y, z) - 1;
                for &head in &self.heads[first..first + 3] {
                    occupied[pages] = head;
                    pages += usize::from(head != NONE);
                }
            }
        }
        for &head in &occupied[..pages] {
            let mut index = head as usize;
            loop {
                let page = &self.pages[index];
                let overlaps = page.overlaps(position, self.widths, ignored);
                if overlaps.iter().fold(false, |any, &this| any | this) {
                    return overlaps.iter().position(|&this| this).map(|slot| (index, slot));
                }
                if page.next == NONE {
                    break;
                }
                index = page.next as usize;
            }
        }
        None
    }

    /// Whether a sphere other than `sphere` overlaps one at `position`.
    #[inline]
    pub(crate) fn overlaps(&self, sphere: usize, position: [f64; 3]) -> bool {
        // The scene limits the number of spheres to u32.
        #[allow(clippy::cast_possible_truncation)]
        let ignored = sphere as u32;
        self.find_overlap(position, ignored).is_some()
    }

    /// A sphere that overlaps one at `position`, and the distance between the two.
    pub(crate) fn overlapping(&self, position: [f64; 3]) -> Option<(usize, f64)> {
        self.find_overlap(position, u32::MAX).map(|(page, slot)| {
            let page = &self.pages[page];
            let other = page.get(slot);
            let along = |axis: usize| {
                let distance = (position[axis] - other[axis]).abs();
                distance.min(self.widths[axis - 1] - distance)
            };
            let [dx, dy, dz] = [position[0] - other[0], along(1), along(2)];
            (page.occupants[slot] as usize, (dx * dx + dy * dy + dz * dz).sqrt())
        })
    }

    /// Adds the next sphere.
    pub(crate) fn insert(&mut self, position: [f64; 3]) {
        // The scene limits the number of spheres to u32.
        #[allow(clippy::cast_possible_truncation)]
        let sphere = self.places.len() as u32;
        self.places.push(0);
        self.place(sphere, self.cell_of(position), position);
    }

    /// Moves `sphere` from `old` to `position`.
    #[inline]
    pub(crate) fn relocate(&mut self, sphere: usize, old: [f64; 3], position: [f64; 3]) {
        let place = self.places[sphere] as usize;
        let (from, to) = (self.cell_of(old), self.cell_of(position));
        if from == to {
            self.pages[place / SLOTS].set(place % SLOTS, position);
        } else {
            self.vacate(place, from);
            // The scene limits the number of spheres to u32.
            #[allow(clippy::cast_possible_truncation)]
            self.place(sphere as u32, to, position);
        }
    }

    /// Takes the sphere at `place` out of `cell`; the last sphere of the cell's first page fills the
    /// gap.
    fn vacate(&mut self, place: usize, cell: usize) {
        let head = self.heads[cell];
        let page = &mut self.pages[head as usize];
        page.count -= 1;
        let last = page.count as usize;
        let (occupant, coordinates) = (page.occupants[last], page.get(last));
        if page.count == 0 {
            self.heads[cell] = page.next;
            self.free.push(head);
        }
        let gap = &mut self.pages[place / SLOTS];
        gap.occupants[place % SLOTS] = occupant;
        gap.set(place % SLOTS, coordinates);
        self.pages[head as usize].x[last] = NOWHERE;
        // `place` was a u32 before.
        #[allow(clippy::cast_possible_truncation)]
        let place_index = place as u32;
        self.places[occupant as usize] = place_index;
    }

    fn place(&mut self, sphere: u32, cell: usize, position: [f64; 3]) {
        let head = self.heads[cell];
        if head == NONE || self.pages[head as usize].count as usize == SLOTS {
            let index = self.free.pop().unwrap_or_else(|| {
                self.pages.push(Page::EMPTY);
                // Fewer pages than spheres are in use, and spheres times slots fit a u32.
                #[allow(clippy::cast_possible_truncation)]
                let last = (self.pages.len() - 1) as u32;
                last
            });
            let page = &mut self.pages[index as usize];
            (page.count, page.next) = (0, head);
            self.heads[cell] = index;
        }
        let head = self.heads[cell] as usize;
        let page = &mut self.pages[head];
        let slot = page.count as usize;
        page.count += 1;
        page.occupants[slot] = sphere;
        page.set(slot, position);
        // Pages times slots fit a u32.
        #[allow(clippy::cast_possible_truncation)]
        let place = (head * SLOTS + slot) as u32;
        self.places[sphere as usize] = place;
    }
}

#[cfg(test)]
mod tests;
