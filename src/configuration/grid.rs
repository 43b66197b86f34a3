//! The cells: unit cells at least one diameter wide, in layers of equal height.

use super::reach::{PARTS, Reach};
use crate::Slab;
use wide::f32x4;

/// Position of one of the 27 cells relative to the middle one, in one cache line.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct Neighbor {
    /// Shift of its corner along x, y, z, repeated for each slot of a page.
    pub(super) shift: [f32x4; 3],
    /// Shift of its index in the layer, to be added with wrapping.
    pub(super) cell: usize,
    /// 0 in the layer before, 1, 2 in the layer after.
    pub(super) layer: usize,
}

/// The division of a slab into cells.
///
/// The cells of a layer form a table with a margin of one cell on all sides, which repeats the
/// cells of the opposite side. Therefore the neighbors of any cell have the same offsets in the
/// table.
#[derive(Debug, Clone)]
pub(crate) struct Grid {
    /// Cells along x, y, z.
    pub(crate) cells: [usize; 3],
    /// Sides of a cell.
    pub(crate) sides: [f64; 3],
    /// Parts of cells per unit length.
    inverse_parts: [f64; 3],
    /// Index of the last part of a cell along x, y, z.
    last_parts: [u32; 3],
    /// Length of a row in the table of cells in a layer.
    row: u32,
    /// Which cells of a layer have neighbors in the margin.
    edges: Box<[bool]>,
    /// Periodic widths along y, z.
    pub(crate) widths: [f64; 2],
    /// Boxed, because it is aligned to a cache line.
    pub(super) neighbors: Box<[Neighbor; 32]>,
    reach: Reach,
    /// Squared distance at which a sphere of an event chain touches another.
    pub(super) contact: f64,
}

/// The cell of a position, and the part of the cell.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Spot {
    pub(crate) layer: u32,
    pub(crate) y: u32,
    pub(crate) z: u32,
    /// Index of the cell in its layer.
    pub(crate) cell: u32,
    pub(crate) part: u32,
}

/// The place of a sphere in a layer.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Site {
    pub(crate) position: [f64; 3],
    /// Position relative to the cell.
    pub(crate) relative: [f32; 3],
    /// Index of the cell in the layer.
    pub(crate) cell: u32,
}

/// Number of cells that divide `extent` into sides of at least one diameter and less than 1.5.
pub(super) fn division(extent: f64) -> usize {
    /// Intended side. Larger cells need fewer visits, but their pages overflow.
    const SIDE: f64 = 1.15;
    // Extents are at least 2 and at most 1e6.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let [most, cells] = [extent.floor() as usize, (extent / SIDE).round() as usize];
    let cells = cells.clamp(most.min(3), most);
    // A side that exceeds one diameter by rounding only could hide a neighbor two cells away.
    let marginal = extent > cells as f64 && extent / (cells as f64) < 1.0 + 1e-12;
    if marginal && cells > 3 { cells - 1 } else { cells }
}

impl Grid {
    pub(crate) fn new(slab: &Slab) -> Self {
        let widths = slab.widths();
        let extents = [slab.height(), widths[0], widths[1]];
        let cells = extents.map(division);
        let sides = [0, 1, 2].map(|axis| extents[axis] / cells[axis] as f64);
        let inverse_parts = [0, 1, 2].map(|axis| PARTS as f64 * (cells[axis] as f64 / extents[axis]));
        // Two coordinates differ by a few roundings of the largest, and a square by twice as many.
        let contact = 1.0 + 1e-14 + 32.0 * f64::EPSILON * extents.into_iter().fold(1.0, f64::max);
        let row = cells[2] + 2;
        let edge = |index: usize, cells: usize| index <= 1 || index >= cells;
        let edges = (0..(cells[1] + 2) * row)
            .map(|cell| edge(cell / row, cells[1]) || edge(cell % row, cells[2]))
            .collect();
        let neighbors = Box::new(std::array::from_fn(|bit| {
            let offsets = [bit / 9, bit / 3 % 3, bit % 3];
            #[allow(clippy::cast_possible_truncation)]
            let shift =
                [0, 1, 2].map(|axis| f32x4::splat((offsets[axis] as f64 - 1.0) as f32 * sides[axis] as f32));
            let cell = (offsets[1] * row + offsets[2]).wrapping_sub(row + 1);
            Neighbor { shift, cell, layer: offsets[0].min(2) }
        }));
        #[allow(clippy::cast_possible_truncation)]
        let (row, last_parts) = (row as u32, cells.map(|cells| (PARTS * cells - 1) as u32));
        Self {
            cells,
            sides,
            inverse_parts,
            last_parts,
            row,
            edges,
            widths,
            neighbors,
            reach: Reach::new(sides),
            contact,
        }
    }

    /// Squared distance at which a sphere of an event chain touches another.
    pub(crate) fn contact(&self) -> f64 {
        self.contact
    }

    /// Size of the table of cells in a layer.
    pub(crate) fn table(&self) -> usize {
        (self.cells[1] + 2) * (self.cells[2] + 2)
    }

    /// Index in the layer of the cell in a row and a column.
    #[inline]
    pub(crate) fn cell(&self, y: usize, z: usize) -> usize {
        (y + 1) * (self.cells[2] + 2) + z + 1
    }

    /// Part of a cell along `axis`.
    #[inline]
    fn part(&self, axis: usize, value: f64) -> u32 {
        // Adding this leaves an integer in the low bits, which is faster than a saturating
        // conversion.
        const INTEGER: f64 = 1.5 * (1_u64 << 52) as f64;
        // Rounding to the nearest, half a part lower, is truncation. (At edges between parts, but
        // not between cells, it may be the lower one; there it does not matter.)
        #[allow(clippy::cast_possible_truncation)]
        let part = (value * self.inverse_parts[axis] - 0.5 + INTEGER).to_bits() as u32;
        part.min(self.last_parts[axis])
    }

    #[inline]
    pub(crate) fn spot(&self, position: [f64; 3]) -> Spot {
        let [x, y, z] = [0, 1, 2].map(|axis| self.part(axis, position[axis]));
        // A small constant.
        #[allow(clippy::cast_possible_truncation)]
        let parts = PARTS as u32;
        let part = Reach::part([x, y, z]);
        let [layer, y, z] = [x / parts, y / parts, z / parts];
        Spot { layer, y, z, cell: (y + 1) * self.row + z + 1, part }
    }

    /// Coordinates relative to the lowest corner of the cell.
    #[inline]
    // Single precision is meant: see `Page`.
    #[allow(clippy::cast_possible_truncation)]
    pub(crate) fn relative(&self, spot: &Spot, position: [f64; 3]) -> [f32; 3] {
        // Cells along an axis fit an i32, from which conversion is quicker.
        let corner = |axis: usize, cell: u32| f64::from(cell.cast_signed()) * self.sides[axis];
        [
            (position[0] - corner(0, spot.layer)) as f32,
            (position[1] - corner(1, spot.y)) as f32,
            (position[2] - corner(2, spot.z)) as f32,
        ]
    }

    #[inline]
    pub(crate) fn site(&self, spot: &Spot, position: [f64; 3]) -> Site {
        Site { position, relative: self.relative(spot, position), cell: spot.cell }
    }

    #[inline]
    pub(super) fn in_reach(&self, part: u32, octant: usize) -> u64 {
        self.reach.cells(part, octant)
    }

    /// Length of a row in the table of cells in a layer.
    #[inline]
    pub(super) fn row(&self) -> usize {
        self.row as usize
    }

    /// Whether a neighbor of a cell is in the margin, where the cell may be repeated.
    #[inline]
    pub(super) fn at_edge(&self, cell: usize) -> bool {
        self.edges[cell]
    }

    /// Where a cell is repeated in the margin, and the cell itself.
    #[cold]
    pub(super) fn images(&self, cell: usize) -> [usize; 4] {
        let image = |index: usize, cells: usize| match index {
            1 => cells + 1,
            _ if index == cells => 0,
            _ => index,
        };
        let (y, z) = (cell / self.row(), cell % self.row());
        let (rows, columns) = ([y, image(y, self.cells[1])], [z, image(z, self.cells[2])]);
        [0, 1, 2, 3].map(|corner| rows[corner / 2] * self.row() + columns[corner % 2])
    }

    /// The nine cells around and including one; not those in the margin, but the ones repeated
    /// there.
    #[cold]
    pub(super) fn repeated_neighbors(&self, cell: usize) -> [usize; 9] {
        let around = |index: usize, cells: usize| {
            [if index == 1 { cells } else { index - 1 }, index, if index == cells { 1 } else { index + 1 }]
        };
        let rows = around(cell / self.row(), self.cells[1]);
        let columns = around(cell % self.row(), self.cells[2]);
        std::array::from_fn(|neighbor| rows[neighbor / 3] * self.row() + columns[neighbor % 3])
    }

    /// Squared distance in double precision, which decides about overlaps.
    ///
    /// Absolute differences are taken first, so that the bits are the same for both spheres of a
    /// pair.
    #[inline]
    pub(super) fn squared_distance(&self, a: [f64; 3], b: [f64; 3]) -> f64 {
        let dx = a[0] - b[0];
        let dy = (a[1] - b[1]).abs();
        let dz = (a[2] - b[2]).abs();
        let (dy, dz) = (dy.min(self.widths[0] - dy), dz.min(self.widths[1] - dz));
        dx * dx + dy * dy + dz * dz
    }
}
