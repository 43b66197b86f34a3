//! Cuts the box into domains for a sweep.

use crate::configuration::Grid;
use crate::random::{Generator, index};

/// Sizes of domains.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sizes {
    /// Least thickness of a slab and width of a tile, in units of S. A share of trials of S/2 over
    /// each is lost.
    pub(super) thickness: f64,
    pub(super) width: f64,
    /// Smallest mean number of spheres in a slab.
    pub(super) least: usize,
    /// Spheres of a tile that fit the cache.
    pub(super) most: f64,
}

impl Sizes {
    /// The fastest by measurement. Thinner slabs give work to more threads.
    pub(super) const GOOD: Self = Self { thickness: 14.0, width: 16.0, least: 512, most: 3500.0 };
    /// For tuned displacements: thin slabs, so that the density varies little within each, and
    /// several of them in small systems too.
    pub(super) const TUNED: Self = Self { thickness: 4.0, width: 4.0, least: 16, most: 3500.0 };
}

/// Division into slabs of several layers and tiles of the base, usually strips. A domain is a tile
/// of a slab.
///
/// Trials that cross a cut are rejected, a share of S/2 over the distance between cuts. In return
/// the spheres of a domain fit the cache, and slabs can be swept in parallel. A small system is one
/// domain. Cuts depend on sizes and the generator, not on the configuration.
#[derive(Debug, Clone)]
pub(super) struct Domains {
    sizes: Sizes,
    /// First layers of the slabs, and the end of the last.
    cuts: Vec<usize>,
    tiles: usize,
    /// Tile of each cell of a layer; empty if there is only one.
    tile_of: Vec<u16>,
}

impl Domains {
    /// Fewest layers of a slab.
    const LEAST_LAYERS: f64 = 3.0;
    /// Fewest layers of the first and the last slab: two slabs that are swept in parallel each read
    /// one layer of the slab between them.
    const LEAST_AT_END: usize = 2;

    pub(super) fn new(sizes: Sizes) -> Self {
        Self { sizes, cuts: Vec::new(), tiles: 1, tile_of: Vec::new() }
    }

    /// Cuts for one sweep of `particles` spheres with displacements up to `sizes` along x, and
    /// along y and z.
    pub(super) fn cut(&mut self, grid: &Grid, particles: usize, sizes: [f64; 2], generator: &mut Generator) {
        let [layers, rows, columns] = grid.cells;
        let Sizes { width, least, most, .. } = self.sizes;
        let thinnest = self.thinnest(grid, sizes[0]);
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
        // Strips along z, which are contiguous in memory, as wide as fit the cache; cut along z too
        // if they do not fit.
        let per_cell = particles as f64 / (layers * rows * columns) as f64 * thickness as f64;
        let tiles = |axis: usize, fitting: f64| {
            let cells = grid.cells[axis] as f64;
            // At most the number of cells; more than 255 by 255 would not fit a u16.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let tiles = (cells / fitting.max(width * sizes[1] / grid.sides[axis])).round() as usize;
            tiles.clamp(1, 255)
        };
        let tiles_y = tiles(1, most / (per_cell * columns as f64));
        let row = per_cell * rows as f64 / tiles_y as f64;
        let tiles_z = if row * columns as f64 > 3.0 * most { tiles(2, most / row) } else { 1 };
        let (shift_y, shift_z) = (index(generator, rows), index(generator, columns));
        self.tiles = tiles_y * tiles_z;
        self.tile_of.clear();
        if self.tiles > 1 {
            self.tile_of.resize(grid.table(), 0);
            for y in 0..rows {
                let tile_y = (y + shift_y) % rows * tiles_y / rows;
                for z in 0..columns {
                    let tile_z = (z + shift_z) % columns * tiles_z / columns;
                    // At most 255 by 255.
                    #[allow(clippy::cast_possible_truncation)]
                    let tile = (tile_y * tiles_z + tile_z) as u16;
                    self.tile_of[grid.cell(y, z)] = tile;
                }
            }
        }
    }

    /// Least thickness of a slab in layers, for displacements along x up to `size`.
    pub(super) fn thinnest(&self, grid: &Grid, size: f64) -> f64 {
        (self.sizes.thickness * size / grid.sides[0]).max(Self::LEAST_LAYERS)
    }

    /// Number of slabs.
    pub(super) fn slabs(&self) -> usize {
        self.cuts.len() - 1
    }

    /// First layer of a slab, and the one after its last.
    pub(super) fn slab(&self, slab: usize) -> [usize; 2] {
        [self.cuts[slab], self.cuts[slab + 1]]
    }

    /// Number of tiles.
    pub(super) fn tiles(&self) -> usize {
        self.tiles
    }

    /// Tile of each cell of a layer; empty if there is only one.
    pub(super) fn tile_of(&self) -> &[u16] {
        &self.tile_of
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Slab;
    use rand::SeedableRng;

    #[test]
    fn domains_tile_the_box_and_cuts_go_everywhere() {
        for (extents, particles, size, tiles) in [
            ([60.0, 12.0, 12.0], 5000, 0.12, 1),
            ([300.0, 25.0, 25.0], 20_000, 0.75, 1),
            ([40.0, 190.0, 70.0], 190_000, 0.2, 2),
            ([20.0, 50.0, 900.0], 400_000, 0.1, 4),
        ] {
            let grid = Grid::new(&Slab::new(extents[0], extents[1], extents[2]).unwrap());
            let mut domains = Domains::new(Sizes::GOOD);
            let mut generator = Generator::seed_from_u64(1);
            let mut inside_some_slab = vec![false; grid.cells[0]];
            let mut inside_some_tile = vec![false; grid.cells[1]];
            for _ in 0..500 {
                domains.cut(&grid, particles, [size; 2], &mut generator);
                assert!(domains.slabs() > 1);
                assert_eq!((domains.cuts[0], *domains.cuts.last().unwrap()), (0, grid.cells[0]));
                for slab in 0..domains.slabs() {
                    let [begin, end] = domains.slab(slab);
                    // Slabs that are swept in parallel are two layers apart.
                    assert!(end >= begin + 2);
                    inside_some_slab[begin + 1..end].fill(true);
                }
                if tiles == 1 {
                    assert_eq!((domains.tiles(), domains.tile_of().len()), (1, 0));
                    inside_some_tile.fill(true);
                    continue;
                }
                assert!(domains.tiles() >= tiles);
                // Tiles have no holes, and none is empty.
                let mut cells = vec![0; domains.tiles()];
                for (y, inside) in inside_some_tile.iter_mut().enumerate() {
                    let before = (y + grid.cells[1] - 1) % grid.cells[1];
                    for z in 0..grid.cells[2] {
                        let tile = domains.tile_of()[grid.cell(y, z)];
                        cells[usize::from(tile)] += 1;
                        *inside |= domains.tile_of()[grid.cell(before, z)] == tile;
                    }
                }
                assert!(cells.iter().all(|&cells| cells > 0));
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
            domains.cut(&grid, particles, [1.25; 2], &mut Generator::seed_from_u64(1));
            assert_eq!((domains.slabs(), domains.tiles()), (1, 1));
        }
    }
}
