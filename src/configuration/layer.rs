//! One layer of cells and the spheres in it.

use super::grid::{Grid, Spot, periodic_neighbours};
use super::page::{NOBODY, Page};

/// Stands for "no page"; page 0 is never used.
pub(super) const NONE: u32 = 0;

/// A sphere where it belongs.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
pub(crate) struct Sphere {
    pub(crate) position: [f64; 3],
    /// Which sphere of the configuration it is; [`NOBODY`] in a gap.
    pub(crate) number: u32,
    /// Cell in the layer; in a gap, the next one.
    pub(crate) cell: u32,
}

/// All cells with the same index along x.
#[derive(Debug, Clone)]
pub(crate) struct Layer {
    /// For each cell, which of the nine around and including it in this layer are occupied.
    pub(super) nearby: Vec<u16>,
    /// Twice the first page of each cell, plus one if others follow.
    pub(super) heads: Vec<u32>,
    pub(super) pages: Vec<Page>,
    /// The page that follows each page.
    pub(super) next: Vec<u32>,
    pub(super) spare_page: u32,
    /// With gaps, so that a sphere keeps its index as long as it stays.
    pub(crate) spheres: Vec<Sphere>,
    pub(super) gap: u32,
    /// Index of the layer modulo four.
    tag: u32,
}

impl Layer {
    /// A layer without cells.
    pub(super) const BEYOND: Self = Self {
        nearby: Vec::new(),
        heads: Vec::new(),
        pages: Vec::new(),
        next: Vec::new(),
        spare_page: NONE,
        spheres: Vec::new(),
        gap: NOBODY,
        tag: 0,
    };

    /// An empty layer with room for `reserve` spheres.
    pub(super) fn new(cells: usize, reserve: usize, index: usize) -> Self {
        let mut pages = Vec::with_capacity(reserve + 1);
        let mut next = Vec::with_capacity(reserve + 1);
        pages.push(Page::EMPTY);
        next.push(NONE);
        Self {
            nearby: vec![0; cells],
            heads: vec![NONE; cells],
            pages,
            next,
            spare_page: NONE,
            spheres: Vec::with_capacity(reserve),
            gap: NOBODY,
            // Below four.
            #[allow(clippy::cast_possible_truncation)]
            tag: (index % 4) as u32,
        }
    }

    /// What stands for a sphere in a page: different from that of every sphere in this layer, the two
    /// before and the one after.
    #[inline]
    pub(crate) fn occupant(&self, index: u32) -> u32 {
        index << 2 | self.tag
    }

    #[inline]
    pub(super) fn sphere_of(&self, occupant: u32) -> &Sphere {
        &self.spheres[(occupant >> 2) as usize]
    }

    /// Adds a sphere, and returns its index.
    #[inline]
    pub(crate) fn insert(&mut self, grid: &Grid, spot: &Spot, position: [f64; 3], number: u32) -> u32 {
        let cell = spot.cell as usize;
        // Cells of a layer and spheres fit a u32.
        #[allow(clippy::cast_possible_truncation)]
        let sphere = Sphere { position, number, cell: cell as u32 };
        let index = self.gap;
        let index = if index == NOBODY {
            self.spheres.push(sphere);
            #[allow(clippy::cast_possible_truncation)]
            let last = (self.spheres.len() - 1) as u32;
            last
        } else {
            let gap = &mut self.spheres[index as usize];
            self.gap = gap.cell;
            *gap = sphere;
            index
        };
        self.enter(grid, spot, index, position);
        index
    }

    /// Takes a sphere out.
    #[inline]
    pub(crate) fn remove(&mut self, grid: &Grid, index: u32) -> Sphere {
        let sphere = self.spheres[index as usize];
        self.leave(grid, index);
        let gap = &mut self.spheres[index as usize];
        gap.number = NOBODY;
        gap.cell = self.gap;
        self.gap = index;
        sphere
    }

    /// Moves a sphere to another position in the layer.
    #[inline]
    pub(crate) fn shift(&mut self, grid: &Grid, index: u32, spot: &Spot, position: [f64; 3]) {
        let cell = spot.cell as usize;
        let sphere = &mut self.spheres[index as usize];
        if sphere.cell as usize == cell {
            sphere.position = position;
            let occupant = self.occupant(index);
            let relative = grid.relative(spot, position);
            let mut link = self.heads[cell] >> 1;
            while link != NONE {
                let page = &mut self.pages[link as usize];
                if let Some(slot) = page.slot_of(occupant) {
                    page.set(slot, occupant, relative);
                    return;
                }
                link = self.next[link as usize];
            }
        } else {
            self.leave(grid, index);
            #[allow(clippy::cast_possible_truncation)]
            let cell = cell as u32;
            let sphere = &mut self.spheres[index as usize];
            (sphere.position, sphere.cell) = (position, cell);
            self.enter(grid, spot, index, position);
        }
    }

    /// Enters a sphere into the pages.
    #[inline]
    fn enter(&mut self, grid: &Grid, spot: &Spot, index: u32, position: [f64; 3]) {
        let cell = spot.cell as usize;
        let relative = grid.relative(spot, position);
        let occupant = self.occupant(index);
        let head = self.heads[cell];
        let mut link = head >> 1;
        while link != NONE {
            let page = &mut self.pages[link as usize];
            if let Some(slot) = page.slot_of(NOBODY) {
                page.set(slot, occupant, relative);
                return;
            }
            link = self.next[link as usize];
        }
        let number = self.spare_page;
        let number = if number == NONE {
            self.pages.push(Page::EMPTY);
            self.next.push(NONE);
            #[allow(clippy::cast_possible_truncation)]
            let last = (self.pages.len() - 1) as u32;
            last
        } else {
            self.spare_page = self.next[number as usize];
            number
        };
        self.pages[number as usize].set(0, occupant, relative);
        self.next[number as usize] = head >> 1;
        self.set_head(grid, spot, number << 1 | u32::from(head != NONE));
        if head == NONE {
            self.mark(grid, spot);
        }
    }

    /// Takes a sphere out of the pages.
    #[inline]
    fn leave(&mut self, grid: &Grid, index: u32) {
        let cell = self.spheres[index as usize].cell as usize;
        let occupant = self.occupant(index);
        let mut before = NONE;
        let mut link = self.heads[cell] >> 1;
        while link != NONE {
            let page = &mut self.pages[link as usize];
            if let Some(slot) = page.slot_of(occupant) {
                page.clear(slot);
                if page.is_empty() {
                    self.unlink(grid, index, before, link);
                }
                return;
            }
            (before, link) = (link, self.next[link as usize]);
        }
    }

    /// Takes an empty page from the chain of the cell of sphere `index`, where it follows page `before`.
    #[inline]
    fn unlink(&mut self, grid: &Grid, index: u32, before: u32, page: u32) {
        let spot = grid.spot(self.spheres[index as usize].position);
        let following = self.next[page as usize];
        self.next[page as usize] = self.spare_page;
        self.spare_page = page;
        let first = if before == NONE {
            following
        } else {
            self.next[before as usize] = following;
            self.heads[spot.cell as usize] >> 1
        };
        // The page that stands for none is followed by none.
        self.set_head(grid, &spot, first << 1 | u32::from(self.next[first as usize] != NONE));
        if first == NONE {
            self.mark(grid, &spot);
        }
    }

    /// Sets the head of a cell, in the margin too.
    #[inline]
    fn set_head(&mut self, grid: &Grid, spot: &Spot, head: u32) {
        self.heads[spot.cell as usize] = head;
        if grid.at_edge(spot) {
            let images = |index: usize, cells: usize| {
                // Counted with the margin.
                let image = if index == 0 {
                    cells + 1
                } else if index + 1 == cells {
                    0
                } else {
                    index + 1
                };
                [index + 1, image]
            };
            for y in images(spot.y as usize, grid.cells[1]) {
                for z in images(spot.z as usize, grid.cells[2]) {
                    self.heads[y * (grid.cells[2] + 2) + z] = head;
                }
            }
        }
    }

    /// Notes around a cell that it is occupied, or that it is no longer.
    #[inline]
    fn mark(&mut self, grid: &Grid, spot: &Spot) {
        // Seen from there, the cell lies on the other side.
        let row = grid.cells[2] + 2;
        let (y, z) = (spot.y as usize, spot.z as usize);
        let edge = grid.at_edge(spot);
        let (rows, columns) = if edge {
            (
                periodic_neighbours(y, grid.cells[1]).map(|y| (y + 1) * row),
                periodic_neighbours(z, grid.cells[2]).map(|z| z + 1),
            )
        } else {
            ([y * row, (y + 1) * row, (y + 2) * row], [z, z + 1, z + 2])
        };
        let mut bit = 1_u16 << 8;
        for first in rows {
            if edge {
                for column in columns {
                    self.nearby[first + column] ^= bit;
                    bit >>= 1;
                }
            } else {
                for nearby in &mut self.nearby[first + columns[0]..first + columns[0] + 3] {
                    *nearby ^= bit;
                    bit >>= 1;
                }
            }
        }
    }
}

impl Layer {
    /// Indices of the spheres, in an order that says nothing about where they are.
    pub(crate) fn indices(&self) -> impl Iterator<Item = u32> + '_ {
        // Spheres fit a u32.
        #[allow(clippy::cast_possible_truncation)]
        self.spheres
            .iter()
            .enumerate()
            .filter(|(_, sphere)| sphere.number != NOBODY)
            .map(|(index, _)| index as u32)
    }

    /// Indices of the spheres in a cell.
    pub(crate) fn indices_in(&self, cell: usize) -> impl Iterator<Item = u32> + '_ {
        self.occupants_of(cell).map(|occupant| occupant >> 2)
    }

    /// What stands for the spheres of a cell.
    pub(super) fn occupants_of(&self, cell: usize) -> impl Iterator<Item = u32> + '_ {
        let first = self.heads[cell] >> 1;
        std::iter::successors((first != NONE).then_some(first), |&page| {
            let next = self.next[page as usize];
            (next != NONE).then_some(next)
        })
        .flat_map(|page| self.pages[page as usize].occupants.to_array())
        .filter(|&occupant| occupant != NOBODY)
    }
}
