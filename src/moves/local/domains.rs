//! How a sweep cuts the box into domains.

use crate::configuration::Grid;
use crate::random::{Generator, index};

/// A stretch of a periodic axis, in cells.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stretch {
    first: usize,
    length: usize,
    cells: usize,
}

impl Stretch {
    #[inline]
    pub(super) fn contains(self, cell: usize) -> bool {
        let distance = if cell >= self.first { cell - self.first } else { cell + self.cells - self.first };
        distance < self.length
    }

    pub(super) fn length(self) -> usize {
        self.length
    }

    pub(super) fn is_whole(self) -> bool {
        self.length == self.cells
    }

    pub(super) fn cells(self) -> impl Iterator<Item = usize> {
        (self.first..self.first + self.length)
            .map(move |cell| if cell < self.cells { cell } else { cell - self.cells })
    }
}

/// How large domains are.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sizes {
    /// Least thickness of a slab and width of a tile, in units of S: they lose a share S/2 of the
    /// trials over the one and the other.
    pub(super) thickness: f64,
    pub(super) width: f64,
    /// Fewest spheres of a slab, on average.
    pub(super) least: usize,
    /// Spheres of a domain that fit the cache.
    pub(super) most: f64,
}

impl Sizes {
    /// Found by measurement: thinner slabs keep more cores busy.
    pub(super) const GOOD: Self = Self { thickness: 14.0, width: 50.0, least: 512, most: 2500.0 };
}

/// Slabs of several layers, and tiles of the base; a domain is a tile of a slab.
///
/// Cuts cost the trials that would cross them, a share of S/2 over the distance between cuts, and buy
/// spheres that fit the cache and, between slabs, work for every core. A small system is one domain. The cuts
/// depend on sizes and the generator, never on where the spheres are.
#[derive(Debug, Clone)]
pub(super) struct Domains {
    sizes: Sizes,
    /// Layers at which slabs begin, and the end.
    cuts: Vec<usize>,
    tiles: Vec<[Stretch; 2]>,
}

impl Domains {
    /// Fewest layers of a slab.
    const LEAST_LAYERS: f64 = 3.0;
    /// Fewest layers of the first and the last: those that are swept at the same time each look at one of
    /// the slab between them.
    const LEAST_AT_END: usize = 2;

    pub(super) fn new(sizes: Sizes) -> Self {
        Self { sizes, cuts: Vec::new(), tiles: Vec::new() }
    }

    /// Cuts for one sweep of `particles` spheres with displacements up to `size`.
    pub(super) fn cut(&mut self, grid: &Grid, particles: usize, size: f64, generator: &mut Generator) {
        let [layers, rows, columns] = grid.cells;
        let Sizes { thickness, width, least, most } = self.sizes;
        let cells_along = |axis: usize, length: f64| length * size / grid.sides[axis];
        let thinnest = cells_along(0, thickness).max(Self::LEAST_LAYERS);
        // At most the number of layers.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let slabs =
            ((layers as f64 / thinnest) as usize).min(particles.checked_div(least).unwrap_or(layers)).max(1);
        self.cuts.clear();
        self.cuts.reserve(slabs + 3);
        self.cuts.push(0);
        let thickness = layers / slabs;
        if slabs > 1 {
            let mut cut = Self::LEAST_AT_END + index(generator, thickness);
            while cut + Self::LEAST_AT_END <= layers {
                self.cuts.push(cut);
                cut += thickness;
            }
        }
        self.cuts.push(layers);
        let per_cell = particles as f64 / (layers * rows * columns) as f64;
        let square = (most / (per_cell * thickness as f64)).sqrt();
        let tiles = |axis: usize| {
            let widest = square.max(cells_along(axis, width));
            // At most the number of cells.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let tiles = (grid.cells[axis] as f64 / widest).round() as usize;
            tiles.max(1)
        };
        let (tiles_y, tiles_z) = (tiles(1), tiles(2));
        let (shift_y, shift_z) = (index(generator, rows), index(generator, columns));
        self.tiles.clear();
        for y in 0..tiles_y {
            for z in 0..tiles_z {
                self.tiles.push([stretch(y, tiles_y, shift_y, rows), stretch(z, tiles_z, shift_z, columns)]);
            }
        }
    }

    /// Number of slabs.
    pub(super) fn slabs(&self) -> usize {
        self.cuts.len() - 1
    }

    /// First layer of a slab, and that behind its last.
    pub(super) fn slab(&self, slab: usize) -> [usize; 2] {
        [self.cuts[slab], self.cuts[slab + 1]]
    }

    pub(super) fn tiles(&self) -> &[[Stretch; 2]] {
        &self.tiles
    }
}

/// One of several equal stretches of an axis.
fn stretch(number: usize, of: usize, shift: usize, cells: usize) -> Stretch {
    let (begin, end) = (number * cells / of, (number + 1) * cells / of);
    Stretch { first: (begin + shift) % cells, length: end - begin, cells }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Slab;
    use rand::SeedableRng;

    #[test]
    fn domains_tile_the_box_and_cuts_go_everywhere() {
        for (extents, particles, size) in [
            ([60.0, 12.0, 12.0], 5000, 0.12),
            ([300.0, 25.0, 25.0], 20_000, 0.75),
            ([40.0, 90.0, 70.0], 90_000, 0.2),
        ] {
            let grid = Grid::new(&Slab::new(extents[0], extents[1], extents[2]).unwrap());
            let mut domains = Domains::new(Sizes::GOOD);
            let mut generator = Generator::seed_from_u64(1);
            let mut inside_some_slab = vec![false; grid.cells[0]];
            let mut inside_some_tile = vec![false; grid.cells[1]];
            for _ in 0..2000 {
                domains.cut(&grid, particles, size, &mut generator);
                assert!(domains.slabs() > 1);
                assert_eq!((domains.cuts[0], *domains.cuts.last().unwrap()), (0, grid.cells[0]));
                for slab in 0..domains.slabs() {
                    let [begin, end] = domains.slab(slab);
                    // Those that are swept at the same time are two layers apart.
                    assert!(end >= begin + 2);
                    inside_some_slab[begin + 1..end].fill(true);
                }
                let mut covered = vec![0; grid.cells[1] * grid.cells[2]];
                for [rows, columns] in domains.tiles() {
                    for y in rows.cells() {
                        assert!(rows.contains(y));
                        columns.cells().for_each(|z| covered[y * grid.cells[2] + z] += 1);
                    }
                    rows.cells().skip(1).for_each(|y| inside_some_tile[y] = true);
                }
                assert!(covered.iter().all(|&times| times == 1));
            }
            assert!(inside_some_slab[1..].iter().all(|&inside| inside), "a cut that is always there");
            assert!(inside_some_tile.iter().all(|&inside| inside), "a cut that is always there");
        }
    }

    #[test]
    fn a_small_system_is_one_domain() {
        let grid = Grid::new(&Slab::new(40.0, 4.0, 3.0).unwrap());
        let mut domains = Domains::new(Sizes::GOOD);
        for particles in [1, 100, 500] {
            domains.cut(&grid, particles, 1.25, &mut Generator::seed_from_u64(1));
            assert_eq!((domains.slabs(), domains.tiles().len()), (1, 1));
        }
    }
}
