//! Neighbour search: cells at least one diameter wide, each holding its spheres' coordinates.
//!
//! Cells along x are contiguous in memory, so the 27 cells around a point are nine runs of three.
//! Occupation counts are kept apart from the coordinates: most cells of a dilute column are empty,
//! and a byte per cell stays in the cache where the coordinates do not.

use crate::Slab;

/// Empty cells before the first and behind the last along x stand in for what is beyond the walls.
const PADDING: usize = 1;
/// Coordinates' places in a cell before any has overflowed.
const INITIAL_CAPACITY: usize = 4;

#[derive(Debug, Clone)]
pub(crate) struct CellList {
    /// Cells along x, y, z, without padding.
    cells: [usize; 3],
    /// Cells per unit length along x, y, z.
    inverse_sides: [f64; 3],
    /// Periodic widths along y, z.
    widths: [f64; 2],
    /// Places per cell.
    capacity: usize,
    /// Spheres in each cell.
    counts: Vec<u8>,
    /// Coordinates by place: `cell * capacity + slot`.
    coordinates: Vec<[f64; 3]>,
    /// Sphere at each place.
    occupants: Vec<u32>,
    /// Place of each sphere.
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
        let total = (cells[0] + 2 * PADDING) * cells[1] * cells[2];
        let mut inverse_sides = [0.0; 3];
        for axis in 0..3 {
            inverse_sides[axis] = cells[axis] as f64 / extents[axis];
        }
        Self {
            cells,
            inverse_sides,
            widths,
            capacity: INITIAL_CAPACITY,
            counts: vec![0; total],
            coordinates: vec![[0.0; 3]; total * INITIAL_CAPACITY],
            occupants: vec![0; total * INITIAL_CAPACITY],
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

    /// The cells before, at and after `index` along a periodic axis, with the image shift of each.
    #[inline]
    fn periodic_neighbours(index: usize, cells: usize, width: f64) -> [(usize, f64); 3] {
        let before = if index == 0 { (cells - 1, -width) } else { (index - 1, 0.0) };
        let after = if index + 1 == cells { (0, width) } else { (index + 1, 0.0) };
        [(index, 0.0), before, after]
    }

    /// First place whose sphere is nearer than one diameter to `position` and not at `ignored`.
    #[inline]
    fn find_overlap(&self, position: [f64; 3], ignored: usize) -> Option<usize> {
        let x = self.coordinate(0, position[0]);
        let y = self.coordinate(1, position[1]);
        let z = self.coordinate(2, position[2]);
        let rows_y = Self::periodic_neighbours(y, self.cells[1], self.widths[0]);
        let rows_z = Self::periodic_neighbours(z, self.cells[2], self.widths[1]);
        for (z, shift_z) in rows_z {
            for (y, shift_y) in rows_y {
                let first = self.cell(x, y, z) - 1;
                let Some(counts) = self.counts.get(first..first + 3) else { continue };
                for (offset, &count) in counts.iter().enumerate() {
                    let start = (first + offset) * self.capacity;
                    for (slot, other) in
                        self.coordinates[start..start + usize::from(count)].iter().enumerate()
                    {
                        let dx = position[0] - other[0];
                        // The difference first, the shift second: then the distance is the same to the
                        // last bit whichever of the two spheres is being moved.
                        let dy = (position[1] - other[1]) - shift_y;
                        let dz = (position[2] - other[2]) - shift_z;
                        if dx * dx + dy * dy + dz * dz < 1.0 && start + slot != ignored {
                            return Some(start + slot);
                        }
                    }
                }
            }
        }
        None
    }

    /// Whether a sphere other than `sphere` overlaps one at `position`.
    #[inline]
    pub(crate) fn overlaps(&self, sphere: usize, position: [f64; 3]) -> bool {
        self.find_overlap(position, self.places[sphere] as usize).is_some()
    }

    /// A sphere that overlaps one at `position`, and the distance between the two.
    pub(crate) fn overlapping(&self, position: [f64; 3]) -> Option<(usize, f64)> {
        self.find_overlap(position, usize::MAX).map(|place| {
            let other = self.coordinates[place];
            let along = |axis: usize| {
                let distance = (position[axis] - other[axis]).abs();
                distance.min(self.widths[axis - 1] - distance)
            };
            let [dx, dy, dz] = [position[0] - other[0], along(1), along(2)];
            (self.occupants[place] as usize, (dx * dx + dy * dy + dz * dz).sqrt())
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

    /// Moves `sphere` to `position`.
    #[inline]
    pub(crate) fn relocate(&mut self, sphere: usize, position: [f64; 3]) {
        let place = self.places[sphere] as usize;
        let (old, new) = (place / self.capacity, self.cell_of(position));
        if old == new {
            self.coordinates[place] = position;
        } else {
            self.vacate(place, old);
            // The scene limits the number of spheres to u32.
            #[allow(clippy::cast_possible_truncation)]
            self.place(sphere as u32, new, position);
        }
    }

    /// Takes the sphere at `place` out of `cell`; the cell's last sphere fills the gap.
    fn vacate(&mut self, place: usize, cell: usize) {
        self.counts[cell] -= 1;
        let last = cell * self.capacity + usize::from(self.counts[cell]);
        self.coordinates[place] = self.coordinates[last];
        self.occupants[place] = self.occupants[last];
        // `place` was a u32 before.
        #[allow(clippy::cast_possible_truncation)]
        let place_index = place as u32;
        self.places[self.occupants[place] as usize] = place_index;
    }

    fn place(&mut self, sphere: u32, cell: usize, position: [f64; 3]) {
        if usize::from(self.counts[cell]) == self.capacity {
            self.grow();
        }
        let place = cell * self.capacity + usize::from(self.counts[cell]);
        self.counts[cell] += 1;
        self.coordinates[place] = position;
        self.occupants[place] = sphere;
        #[allow(clippy::cast_possible_truncation)]
        let place_index = place as u32;
        self.places[sphere as usize] = place_index;
    }

    /// Makes room for more spheres per cell; happens a few times at most, in dense packings.
    #[cold]
    fn grow(&mut self) {
        let (old, new) = (self.capacity, self.capacity + 2);
        let total = self.counts.len();
        let mut coordinates = vec![[0.0; 3]; total * new];
        let mut occupants = vec![0; total * new];
        for cell in 0..total {
            for slot in 0..usize::from(self.counts[cell]) {
                coordinates[cell * new + slot] = self.coordinates[cell * old + slot];
                occupants[cell * new + slot] = self.occupants[cell * old + slot];
                #[allow(clippy::cast_possible_truncation)]
                let place = (cell * new + slot) as u32;
                self.places[self.occupants[cell * old + slot] as usize] = place;
            }
        }
        self.coordinates = coordinates;
        self.occupants = occupants;
        self.capacity = new;
    }
}
