//! Whether a sphere at a position would overlap another.

use super::grid::{Grid, Neighbor, Site};
use super::layer::{Layer, NONE};
use super::page::{Page, SLOTS};
use super::reach::NEIGHBORS;
use wide::{f32x4, u32x4};

/// Bound on the error of a squared distance in single precision, near one.
///
/// Sides are below 1.5, so a coordinate relative to a cell, that of a corner, and the difference
/// from a page's are off by at most 2⁻²⁴ each, and one relative to a neighboring cell by 2⁻²³ more:
/// 6·2⁻²⁴ along each axis, the rounding of double precision included. In the square this is
/// 2√3·6·2⁻²⁴, and its own rounding adds 3·2⁻²⁴: less than 24·2⁻²⁴, a third of what is allowed for.
const ROUNDING: f32 = 1.0 / (1 << 18) as f32;
/// Below this value spheres certainly overlap.
const CERTAIN: f32x4 = f32x4::new([1.0 - ROUNDING; SLOTS]);
/// From this value on they certainly do not overlap.
const CLEAR: f32x4 = f32x4::new([1.0 + ROUNDING; SLOTS]);

/// A test for overlaps of a sphere at a position.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Probe {
    pub(crate) site: Site,
    /// Code of the sphere itself.
    pub(crate) ignored: u32,
    /// Cells that are still to be visited, as [`occupied_in_reach`] gives them.
    pub(crate) candidates: u64,
}

/// The cells with which a sphere in a part of a cell is compared after a displacement in the
/// direction of `octant`, the likeliest first. `layers` are the layers before, at and after that of
/// the sphere, here and below.
#[inline]
pub(crate) fn occupied_in_reach(grid: &Grid, layers: &[Layer], cell: u32, part: u32, octant: usize) -> u64 {
    let nearby = |layer: usize| u64::from(layers[layer].nearby[cell as usize]) << (9 * layer);
    let occupied = nearby(0) | nearby(1) | nearby(2);
    (occupied | occupied << 32) & grid.in_reach(part, octant)
}

/// The position to compare with, repeated for each slot of a page.
struct Middle {
    coordinates: [f32x4; 3],
    ignored: u32x4,
}

impl Middle {
    /// Squared distances of the spheres of a page in single precision; very large for the ignored
    /// sphere.
    #[inline]
    fn squared_distances(&self, neighbor: &Neighbor, page: &Page) -> f32x4 {
        let [x, y, z] = self.coordinates;
        let dx = x - neighbor.shift[0] - page.x;
        let dy = y - neighbor.shift[1] - page.y;
        let dz = z - neighbor.shift[2] - page.z;
        dx * dx + dy * dy + dz * dz + page.masked(self.ignored)
    }

    /// The smallest squared distance over all pages of a cell, for each slot.
    #[cold]
    #[inline(never)]
    fn nearest_in_chain(&self, neighbor: &Neighbor, layer: &Layer, head: u32) -> f32x4 {
        let mut nearest = CLEAR;
        let mut page = head >> 1;
        while page != NONE {
            nearest = nearest.fast_min(self.squared_distances(neighbor, &layer.pages[page as usize]));
            page = layer.next[page as usize];
        }
        nearest
    }
}

impl Probe {
    #[inline]
    fn middle(&self) -> Middle {
        Middle { coordinates: self.site.relative.map(f32x4::splat), ignored: u32x4::splat(self.ignored) }
    }

    /// Visits the next `VISITS` cells without a branch. Returns whether an overlap is certain, and
    /// the remaining cells. Undecided pairs are left to [`overlaps`](Self::overlaps).
    // Passed by value: a probe in memory would be read in other pieces than it was written, which
    // slows dense sweeps by an eighth.
    #[inline(always)]
    // Both sides always: a condition is cheaper than a branch.
    #[allow(clippy::inline_always, clippy::needless_bitwise_bool)]
    pub(crate) fn overlaps_early<const VISITS: usize>(self, grid: &Grid, layers: &[Layer]) -> (bool, u64) {
        let cell = self.site.cell as usize;
        let middle = self.middle();
        let mut candidates = self.candidates;
        let mut nearest = CLEAR;
        let mut heads = 0;
        for _ in 0..VISITS {
            // After all cells have been visited, the first one is visited again, which is harmless.
            let neighbor = &grid.neighbors[candidates.trailing_zeros() as usize & 31];
            candidates &= candidates.wrapping_sub(1);
            let layer = &layers[neighbor.layer];
            let head = layer.heads[cell.wrapping_add(neighbor.cell)];
            let page = &layer.pages[(head >> 1) as usize];
            nearest = nearest.fast_min(middle.squared_distances(neighbor, page));
            heads |= head;
        }
        let certain = nearest.simd_lt(CERTAIN).any();
        let decided = certain | (!nearest.simd_lt(CLEAR).any() & (heads & 1 == 0));
        (certain, if decided { candidates } else { self.candidates })
    }

    /// Visits all cells that are left.
    #[inline]
    pub(crate) fn overlaps(&self, grid: &Grid, layers: &[Layer]) -> bool {
        let cell = self.site.cell as usize;
        let middle = self.middle();
        let mut candidates = self.candidates;
        while candidates != 0 {
            let neighbor = &grid.neighbors[candidates.trailing_zeros() as usize & 31];
            candidates &= candidates - 1;
            let layer = &layers[neighbor.layer];
            let head = layer.heads[cell.wrapping_add(neighbor.cell)];
            let page = &layer.pages[(head >> 1) as usize];
            let mut squared = middle.squared_distances(neighbor, page);
            if head & 1 == 1 {
                squared = middle.nearest_in_chain(neighbor, layer, head);
            }
            if squared.simd_lt(CLEAR).any() {
                // Undecided pairs are rare, so all remaining cells are compared exactly.
                return squared.simd_lt(CERTAIN).any() || self.overlaps_exactly(grid, layers);
            }
        }
        false
    }

    /// The same in double precision, for the few undecided pairs.
    #[cold]
    #[inline(never)]
    fn overlaps_exactly(&self, grid: &Grid, layers: &[Layer]) -> bool {
        grid.neighbors[..NEIGHBORS].iter().any(|neighbor| {
            let layer = &layers[neighbor.layer];
            layer.occupants_of((self.site.cell as usize).wrapping_add(neighbor.cell)).any(|occupant| {
                occupant != self.ignored
                    && grid.squared_distance(self.site.position, layer.sphere_of(occupant).position) < 1.0
            })
        })
    }
}
