//! The pairs of spheres of a tile that can touch, as long as all spheres move along one axis.
//!
//! Two spheres less than one diameter apart across the axis cannot pass each other, so their order
//! does not change. Two spheres with a third always between them cannot touch. The remaining pairs
//! form a graph with few edges (the constraint graph of Li, Todo, Maggs and Krauth,
//! doi:10.1016/j.cpc.2020.107702), which is found once for a whole visit.

use super::columns::{Around, Columns};
use super::shadows::{self, Mask, Shadows};
use wide::f32x8;

/// Spheres that a sphere can touch ahead of it, or behind it. Fills one cache line.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct Links {
    /// Differences of the coordinates along the axis at contact, minus one period if the contact is
    /// with an image. −∞ in an empty slot.
    pub(super) reach: [f64; Self::SLOTS],
    pub(super) other: [u32; Self::SLOTS],
    used: u32,
    /// Index of the links that continue these; 0 if there are none.
    pub(super) more: u32,
}

impl Links {
    pub(super) const SLOTS: usize = 4;
    const EMPTY: Self =
        Self { reach: [f64::NEG_INFINITY; Self::SLOTS], other: [0; Self::SLOTS], used: 0, more: 0 };
}

/// A sphere as the search for neighbors sees it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    /// Relative to the tile.
    pub(super) across: [f64; 2],
    pub(super) sphere: u32,
    pub(super) column: u32,
}

/// Flag in the number of a sphere that marks its image one period before it.
const IMAGE: u32 = 1 << 31;

/// Entries that are compared at the same time.
#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
struct Block {
    /// Relative to the column, in single precision.
    across: [[f32; Self::ENTRIES]; 2],
    spheres: [u32; Self::ENTRIES],
}

impl Block {
    const ENTRIES: usize = 8;
    /// [`ENTRIES`](Self::ENTRIES) in the type of the counts.
    const FULL: u32 = 8;
    /// A coordinate out of reach.
    const NOWHERE: f32 = 1e9;
    const EMPTY: Self = Self { across: [[Self::NOWHERE; Self::ENTRIES]; 2], spheres: [0; Self::ENTRIES] };
}

/// The spheres entered so far, each in its own column and in the neighbors of that.
#[derive(Debug, Clone, Default)]
struct Lists {
    /// The first block of each column, and the number of entries.
    ranges: Vec<[u32; 2]>,
    around: Vec<Around>,
    blocks: Vec<Block>,
}

impl Lists {
    /// Empties the lists and makes room to enter all candidates `times` times.
    fn clear(&mut self, columns: &Columns, candidates: &[Candidate], times: u32) {
        let Self { ranges, around, blocks } = self;
        columns.all_around(around);
        ranges.clear();
        ranges.resize(around.len(), [0; 2]);
        for candidate in candidates {
            ranges[candidate.column as usize][1] += 1;
        }
        // Neighborhood is mutual: a column receives the entries of its neighbors.
        let mut begin = 0;
        for (column, around) in around.iter().enumerate() {
            let entries: u32 = around.iter().map(|(other, _)| ranges[other][1]).sum();
            ranges[column][0] = begin;
            begin += (times * entries).div_ceil(Block::FULL);
        }
        for [_, entries] in ranges.iter_mut() {
            *entries = 0;
        }
        // A block is emptied when its first entry comes.
        if blocks.len() < begin as usize {
            blocks.resize(begin as usize, Block::EMPTY);
        }
    }

    #[inline]
    fn enter(&mut self, columns: &Columns, candidate: &Candidate, relative: [f32; 2], sphere: u32) {
        for (column, shift) in self.around[candidate.column as usize].iter() {
            let [begin, entries] = &mut self.ranges[column];
            let (block, place) = (*entries as usize / Block::ENTRIES, *entries as usize % Block::ENTRIES);
            *entries += 1;
            let block = &mut self.blocks[*begin as usize + block];
            if place == 0 {
                *block = Block::EMPTY;
            }
            let shift = columns.shift(shift);
            block.across[0][place] = relative[0] + shift[0];
            block.across[1][place] = relative[1] + shift[1];
            block.spheres[place] = sphere;
        }
    }
}

/// The constraint graph of a tile.
#[derive(Debug, Clone, Default)]
pub(super) struct Constraints {
    /// For each mobile sphere the links behind it and those ahead, then the links that continue
    /// these.
    links: Vec<Links>,
    /// Reused memory.
    lists: Lists,
    across: Vec<[f64; 2]>,
}

impl Constraints {
    /// Finds the pairs that can touch. Candidates are sorted along the axis; spheres with numbers
    /// below `mobile` can move. `contact` is the squared distance at contact, `period` the period
    /// along the axis.
    pub(super) fn find(
        &mut self,
        columns: &Columns,
        candidates: &[Candidate],
        mobile: usize,
        contact: f64,
        period: Option<f64>,
    ) {
        /// One diameter squared, plus a margin for single precision.
        const WITHIN: f32 = 1.0 + 1e-5;
        let shadows = Shadows::get();
        self.links.clear();
        // Room for the links that continue others, so that memory seldom grows.
        self.links.reserve(3 * mobile);
        self.links.resize(2 * mobile, Links::EMPTY);
        self.across.resize(candidates.len(), [0.0; 2]);
        for candidate in candidates {
            self.across[candidate.sphere as usize] = candidate.across;
        }
        self.lists.clear(columns, candidates, if period.is_some() { 2 } else { 1 });
        if period.is_some() {
            for candidate in candidates {
                let relative = columns.relative(candidate.column, candidate.across);
                self.lists.enter(columns, candidate, relative, candidate.sphere | IMAGE);
            }
        }
        for candidate in candidates {
            let relative = columns.relative(candidate.column, candidate.across);
            let [begin, entries] = self.lists.ranges[candidate.column as usize];
            let end = begin + entries.div_ceil(Block::FULL);
            let frozen = candidate.sphere as usize >= mobile;
            let mut hidden = Mask::default();
            'nearest_first: for block in self.lists.blocks[begin as usize..end as usize].iter().rev() {
                let Block { across: [first, second], spheres } = block;
                let (a, b) = (f32x8::new(*first) - relative[0], f32x8::new(*second) - relative[1]);
                let mut near = (a * a + b * b).simd_lt(f32x8::splat(WITHIN)).to_bitmask();
                while near != 0 {
                    let slot = (near.ilog2() as usize) % Block::ENTRIES;
                    near ^= 1 << slot;
                    let (sphere, image) = (spheres[slot] & !IMAGE, spheres[slot] & IMAGE != 0);
                    if image && sphere == candidate.sphere {
                        // The sphere's own image: one period is searched.
                        break 'nearest_first;
                    }
                    let displacement = [first[slot] - relative[0], second[slot] - relative[1]];
                    let pixel = shadows::pixel(displacement);
                    if !shadows::contains(&hidden, pixel) && (!frozen || (sphere as usize) < mobile) {
                        let squared =
                            columns.squared_distance(self.across[sphere as usize], candidate.across);
                        if squared < contact {
                            let reach = (contact - squared).sqrt();
                            let reach = if image { reach - period.unwrap_or(0.0) } else { reach };
                            link(&mut self.links, mobile, candidate.sphere, false, reach, sphere);
                            link(&mut self.links, mobile, sphere, true, reach, candidate.sphere);
                        }
                    }
                    if shadows.hide(displacement, pixel, &mut hidden) {
                        break 'nearest_first;
                    }
                }
            }
            self.lists.enter(columns, candidate, relative, candidate.sphere);
        }
    }

    /// The first links of a mobile sphere in one direction.
    #[inline]
    pub(super) fn links(&self, sphere: usize, forward: bool) -> &Links {
        &self.links[2 * sphere + usize::from(forward)]
    }

    /// The links that continue these.
    #[inline]
    pub(super) fn more(&self, links: &Links) -> Option<&Links> {
        if links.more == 0 { None } else { Some(&self.links[links.more as usize]) }
    }
}

/// Records that `sphere`, if it is mobile, can touch `other`.
#[inline]
fn link(all: &mut Vec<Links>, mobile: usize, sphere: u32, forward: bool, reach: f64, other: u32) {
    if sphere as usize >= mobile {
        return;
    }
    let mut row = 2 * sphere as usize + usize::from(forward);
    loop {
        let links = &mut all[row];
        if let Some(slot) = links.reach.get_mut(links.used as usize) {
            *slot = reach;
            links.other[links.used as usize] = other;
            links.used += 1;
            return;
        }
        if links.more == 0 {
            // There are a few per sphere, so their number fits a u32.
            #[allow(clippy::cast_possible_truncation)]
            let new = all.len() as u32;
            all[row].more = new;
            all.push(Links::EMPTY);
        }
        row = all[row].more as usize;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Generator, unit};
    use rand::SeedableRng;

    /// Spheres without overlaps in a box that is periodic across the axis, and along it if
    /// `periodic`.
    fn fluid(extents: [f64; 3], attempts: usize, periodic: bool) -> Vec<[f64; 3]> {
        let mut generator = Generator::seed_from_u64(3);
        let mut spheres: Vec<[f64; 3]> = Vec::new();
        for _ in 0..attempts {
            let new = extents.map(|extent| extent * unit(&mut generator));
            let far = |other: &[f64; 3]| {
                let squared = |axis: usize| {
                    let distance = (new[axis] - other[axis]).abs();
                    let repeats = axis > 0 || periodic;
                    let distance = if repeats { distance.min(extents[axis] - distance) } else { distance };
                    distance * distance
                };
                squared(0) + squared(1) + squared(2) >= 1.0
            };
            if spheres.iter().all(far) {
                spheres.push(new);
            }
        }
        spheres.sort_by(|a, b| a[0].total_cmp(&b[0]));
        spheres
    }

    #[test]
    fn the_nearest_contact_is_that_among_all_pairs() {
        for (extents, periodic) in
            [([12.0, 5.0, 3.0], false), ([12.0, 5.0, 3.0], true), ([4.0, 8.0, 9.5], true)]
        {
            let spheres = fluid(extents, 20_000, periodic);
            let repeats = [Some(extents[1]), Some(extents[2])];
            let columns = Columns::new([[0.0, extents[1]], [0.0, extents[2]]], repeats);
            let contact = 1.0 + 1e-13;
            let candidates: Vec<Candidate> = (0..)
                .zip(&spheres)
                .map(|(sphere, &[_, y, z])| Candidate {
                    across: [y, z],
                    sphere,
                    column: columns.column([y, z]),
                })
                .collect();
            let mut constraints = Constraints::default();
            let mobile = spheres.len();
            constraints.find(&columns, &candidates, mobile, contact, periodic.then_some(extents[0]));
            let mut links = 0;
            for (sphere, from) in spheres.iter().enumerate() {
                for forward in [false, true] {
                    let ahead = |other: &[f64; 3]| {
                        let along = other[0] - from[0];
                        if forward { along } else { -along }
                    };
                    let mut found = f64::INFINITY;
                    let rows = std::iter::successors(Some(constraints.links(sphere, forward)), |row| {
                        constraints.more(row)
                    });
                    for row in rows {
                        links += row.used as usize;
                        for (&other, reach) in row.other.iter().zip(row.reach) {
                            found = found.min(ahead(&spheres[other as usize]) - reach);
                        }
                    }
                    let mut expected = f64::INFINITY;
                    for (_, to) in spheres.iter().enumerate().filter(|&(other, _)| other != sphere) {
                        let across = |axis: usize| {
                            let distance = (to[axis] - from[axis]).abs();
                            distance.min(extents[axis] - distance)
                        };
                        let room = contact - across(1) * across(1) - across(2) * across(2);
                        let mut along = ahead(to);
                        if periodic && along < 0.0 {
                            along += extents[0];
                        }
                        if room > 0.0 && along > 0.0 {
                            expected = expected.min(along - room.sqrt());
                        }
                    }
                    let same = (found - expected).abs() < 1e-12 || found.to_bits() == expected.to_bits();
                    assert!(same, "{sphere} {forward}: {found} {expected}");
                }
            }
            // Few, although some ten spheres are less than a diameter away across the axis.
            assert!(links < 8 * mobile, "{links} for {mobile}");
        }
    }
}
