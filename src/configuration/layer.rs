//! One layer of cells and the spheres in it.

use super::grid::{Grid, Site};
use super::page::{NOBODY, Page};

/// Stands for "no page"; page 0 is never used.
pub(super) const NONE: u32 = 0;

/// A sphere in a layer.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
pub(crate) struct Sphere {
    pub(crate) position: [f64; 3],
    /// Number of the sphere; [`NOBODY`] in a gap.
    pub(crate) number: u32,
    /// Cell in the layer; in a gap, the next one.
    pub(crate) cell: u32,
}

/// All cells with the same index along x.
#[derive(Debug, Clone)]
// The size is a power of two, for fast indexing.
#[repr(align(128))]
pub(crate) struct Layer {
    /// For each cell, which of the nine around and including it in this layer are occupied.
    pub(super) nearby: Box<[u16]>,
    /// Twice the first page of each cell, plus one if others follow.
    pub(super) heads: Box<[u32]>,
    pub(super) pages: Vec<Page>,
    /// The page that follows each page.
    pub(super) next: Vec<u32>,
    pub(super) spare_page: u32,
    /// With gaps, so that a sphere keeps its index while it stays in the layer.
    pub(crate) spheres: Vec<Sphere>,
    pub(super) gap: u32,
    /// Index of the layer modulo four.
    tag: u32,
}

impl Layer {
    /// An empty layer with room for `reserve` spheres.
    pub(super) fn new(cells: usize, reserve: usize, index: usize) -> Self {
        let mut pages = Vec::with_capacity(reserve + 1);
        let mut next = Vec::with_capacity(reserve + 1);
        pages.push(Page::EMPTY);
        next.push(NONE);
        Self {
            nearby: vec![0; cells].into(),
            heads: vec![NONE; cells].into(),
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

    /// The code of a sphere in a page. It differs from those of all spheres in this layer, the two
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
    pub(crate) fn insert(&mut self, grid: &Grid, site: &Site, number: u32) -> u32 {
        let sphere = Sphere { position: site.position, number, cell: site.cell };
        let index = self.gap;
        let index = if index == NOBODY {
            self.spheres.push(sphere);
            // The scene limits the number of spheres to u32.
            #[allow(clippy::cast_possible_truncation)]
            let last = (self.spheres.len() - 1) as u32;
            last
        } else {
            let gap = &mut self.spheres[index as usize];
            self.gap = gap.cell;
            *gap = sphere;
            index
        };
        self.enter(grid, site, index);
        index
    }

    /// Takes a sphere out, and returns its number.
    #[inline]
    pub(crate) fn remove(&mut self, grid: &Grid, index: u32) -> u32 {
        self.leave(grid, index);
        let gap = &mut self.spheres[index as usize];
        gap.cell = self.gap;
        self.gap = index;
        std::mem::replace(&mut gap.number, NOBODY)
    }

    /// Moves a sphere to another site of the layer.
    #[inline]
    pub(crate) fn shift(&mut self, grid: &Grid, index: u32, site: &Site) {
        let sphere = &mut self.spheres[index as usize];
        if sphere.cell == site.cell {
            sphere.position = site.position;
            let occupant = self.occupant(index);
            let mut number = self.heads[site.cell as usize] >> 1;
            while number != NONE {
                let page = &mut self.pages[number as usize];
                if let Some(slot) = page.slot_of(occupant) {
                    page.set(slot, occupant, site.relative);
                    return;
                }
                number = self.next[number as usize];
            }
        } else {
            self.leave(grid, index);
            let sphere = &mut self.spheres[index as usize];
            (sphere.position, sphere.cell) = (site.position, site.cell);
            self.enter(grid, site, index);
        }
    }

    /// Enters a sphere into the pages.
    #[inline]
    pub(super) fn enter(&mut self, grid: &Grid, site: &Site, index: u32) {
        let occupant = self.occupant(index);
        let cell = site.cell as usize;
        let head = self.heads[cell];
        let mut number = head >> 1;
        while number != NONE {
            let page = &mut self.pages[number as usize];
            if let Some(slot) = page.slot_of(NOBODY) {
                page.set(slot, occupant, site.relative);
                return;
            }
            number = self.next[number as usize];
        }
        number = self.spare_page;
        if number == NONE {
            // There are no more pages than spheres, which fit a u32.
            #[allow(clippy::cast_possible_truncation)]
            let new = self.pages.len() as u32;
            number = new;
            self.pages.push(Page::EMPTY);
            self.next.push(NONE);
        } else {
            self.spare_page = self.next[number as usize];
        }
        self.pages[number as usize].set(0, occupant, site.relative);
        self.next[number as usize] = head >> 1;
        self.set_head(grid, cell, number << 1 | u32::from(head != NONE));
        if head == NONE {
            self.mark(grid, cell);
        }
    }

    /// Takes a sphere out of the pages.
    #[inline]
    fn leave(&mut self, grid: &Grid, index: u32) {
        let occupant = self.occupant(index);
        let cell = self.spheres[index as usize].cell as usize;
        let mut before = NONE;
        let mut number = self.heads[cell] >> 1;
        while number != NONE {
            let page = &mut self.pages[number as usize];
            if let Some(slot) = page.slot_of(occupant) {
                page.clear(slot);
                if page.is_empty() {
                    self.unlink(grid, cell, before, number);
                }
                return;
            }
            (before, number) = (number, self.next[number as usize]);
        }
    }

    /// Takes an empty page from the chain of a cell, where it follows page `before`.
    #[inline]
    fn unlink(&mut self, grid: &Grid, cell: usize, before: u32, page: u32) {
        let following = self.next[page as usize];
        self.next[page as usize] = self.spare_page;
        self.spare_page = page;
        let first = if before == NONE {
            following
        } else {
            self.next[before as usize] = following;
            self.heads[cell] >> 1
        };
        // Page 0, which stands for none, has no next page.
        self.set_head(grid, cell, first << 1 | u32::from(self.next[first as usize] != NONE));
        if first == NONE {
            self.mark(grid, cell);
        }
    }

    /// Sets the head of a cell, in the margin too.
    #[inline]
    fn set_head(&mut self, grid: &Grid, cell: usize, head: u32) {
        self.heads[cell] = head;
        if grid.at_edge(cell) {
            for image in grid.images(cell) {
                self.heads[image] = head;
            }
        }
    }

    /// Updates the bits of the surrounding cells about whether a cell is occupied.
    #[inline]
    fn mark(&mut self, grid: &Grid, cell: usize) {
        // Seen from there, the cell lies on the other side: the last bit belongs to the first.
        if grid.at_edge(cell) {
            for (bit, neighbor) in grid.repeated_neighbors(cell).into_iter().enumerate() {
                self.nearby[neighbor] ^= 1 << (8 - bit);
            }
        } else {
            let row = grid.row();
            for (first, shift) in [(cell - row - 1, 6), (cell - 1, 3), (cell + row - 1, 0)] {
                let [before, at, after] = [4, 2, 1].map(|bit: u16| bit << shift);
                if let [a, b, c] = &mut self.nearby[first..first + 3] {
                    *a ^= before;
                    *b ^= at;
                    *c ^= after;
                }
            }
        }
    }
}

impl Layer {
    /// Sorts spheres and pages by cell, so that neighbors are close in memory.
    pub(super) fn sort(&mut self, grid: &Grid) {
        // Gaps go to the end; numbers make the order unique.
        self.spheres.sort_unstable_by_key(|sphere| {
            let gap = sphere.number == NOBODY;
            (gap, if gap { 0 } else { sphere.cell }, sphere.number)
        });
        let count = self.spheres.partition_point(|sphere| sphere.number != NOBODY);
        self.spheres.truncate(count);
        self.gap = NOBODY;
        self.pages.truncate(1);
        self.next.truncate(1);
        self.spare_page = NONE;
        self.heads.fill(NONE);
        self.nearby.fill(0);
        for index in 0..count {
            let position = self.spheres[index].position;
            let site = grid.site(&grid.spot(position), position);
            // Spheres fit a u32.
            #[allow(clippy::cast_possible_truncation)]
            self.enter(grid, &site, index as u32);
        }
    }

    /// Reads a word of every cache line of the cells, and combines them.
    pub(crate) fn read(&self) -> u32 {
        let heads = self.heads.iter().step_by(16).fold(0, |read, head| read ^ head);
        let nearby = self.nearby.iter().step_by(32).fold(0, |read, nearby| read ^ nearby);
        let pages = self.pages.iter().fold(0, |read, page| read ^ page.occupants.as_array()[0]);
        heads ^ u32::from(nearby) ^ pages
    }

    /// As [`read`](Self::read), of a sphere and its cell.
    #[inline]
    pub(crate) fn read_around(&self, index: u32) -> u32 {
        let cell = self.spheres[index as usize].cell as usize;
        let page = &self.pages[(self.heads[cell] >> 1) as usize];
        page.occupants.as_array()[0] ^ u32::from(self.nearby[cell])
    }

    /// Indices of the spheres in a cell.
    pub(crate) fn indices_in(&self, cell: usize) -> impl Iterator<Item = u32> + '_ {
        self.occupants_of(cell).map(|occupant| occupant >> 2)
    }

    /// Codes of the spheres in a cell.
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
