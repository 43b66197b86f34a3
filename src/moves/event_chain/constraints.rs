//! Which spheres of a tile can touch which, as long as all move along one axis only.
//!
//! Two spheres less than one diameter apart across the axis cannot pass each other. So who is ahead of whom does not change,
//! and a sphere with another always between them cannot be touched: what is left is a graph with few edges
//! (the constraint graph of Li, Todo, Maggs and Krauth, doi:10.1016/j.cpc.2020.107702), found once for a whole visit.

use std::sync::OnceLock;

/// A sphere that another may touch, ahead of it or behind.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Link {
    /// Difference of their coordinates along the axis when they touch; less one period where it is an image
    /// that is touched.
    pub(super) reach: f64,
    pub(super) other: u32,
}

/// A sphere as the search for neighbors sees it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Candidate {
    /// Relative to the tile.
    pub(super) across: [f64; 2],
    pub(super) sphere: u32,
    pub(super) column: u32,
}

/// Columns at least one diameter wide along the axis, in which candidates are listed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Columns {
    origins: [f64; 2],
    inverse_sides: [f64; 2],
    pub(super) counts: [usize; 2],
    /// Of the coordinates across, where these are periodic.
    repeats: [Option<f64>; 2],
}

impl Columns {
    pub(super) fn new(extents: [[f64; 2]; 2], repeats: [Option<f64>; 2]) -> Self {
        /// Room for the rounding of coordinates.
        const SIDE: f64 = 1.0 + 1e-6;
        let origins = extents.map(|[origin, _]| origin);
        // Extents are at most 1e6.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let counts = extents.map(|[_, extent]| ((extent / SIDE) as usize).max(1));
        let inverse_sides = [0, 1].map(|axis| counts[axis] as f64 / extents[axis][1]);
        Self { origins, inverse_sides, counts, repeats }
    }

    #[inline]
    pub(super) fn column(&self, across: [f64; 2]) -> u32 {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let [first, second] = [0, 1].map(|axis| {
            let column = ((across[axis] - self.origins[axis]) * self.inverse_sides[axis]) as usize;
            column.min(self.counts[axis] - 1)
        });
        #[allow(clippy::cast_possible_truncation)]
        let column = (first * self.counts[1] + second) as u32;
        column
    }

    /// Calls `enter` with the columns around and including one, and by what coordinates across differ when
    /// seen from there.
    #[inline]
    fn around(&self, column: u32, mut enter: impl FnMut(usize, [f64; 2])) {
        let at = [column as usize / self.counts[1], column as usize % self.counts[1]];
        // A step down, none, and up along one axis: the column, and by what the coordinate differs there.
        let steps = |axis: usize| {
            [0_usize, 1, 2].map(|step| {
                let to = at[axis] + step;
                let (count, repeats) = (self.counts[axis], self.repeats[axis]);
                match repeats {
                    _ if to >= 1 && to <= count => Some((to - 1, 0.0)),
                    None => None,
                    Some(period) if to == 0 => Some((count - 1, period)),
                    Some(period) => Some((0, -period)),
                }
            })
        };
        let seconds = steps(1);
        for (first, along_first) in steps(0).into_iter().flatten() {
            for (second, along_second) in seconds.iter().copied().flatten() {
                enter(first * self.counts[1] + second, [along_first, along_second]);
            }
        }
    }
}

/// A candidate in the list of a column.
#[derive(Debug, Clone, Copy)]
struct Entry {
    across: [f64; 2],
    sphere: u32,
    /// Whether it is the image one period before.
    image: bool,
}

/// Pixels along each side of the square around a sphere.
const PIXELS: usize = 16;

/// A set of pixels.
type Mask = [u64; PIXELS * PIXELS / 64];

/// What hides what: seen from one sphere, another in a pixel hides those behind it in other pixels.
#[derive(Debug)]
struct Shadows {
    /// Pixels hidden by a sphere anywhere in each.
    behind: Box<[Mask]>,
    /// Pixels in which spheres can be touched.
    all: Mask,
}

#[inline]
fn contains(mask: &Mask, pixel: usize) -> bool {
    mask[pixel / 64] >> (pixel % 64) & 1 == 1
}

impl Shadows {
    fn get() -> &'static Self {
        static SHADOWS: OnceLock<Shadows> = OnceLock::new();
        SHADOWS.get_or_init(Self::new)
    }

    /// The pixel of a displacement of at most about one diameter.
    #[inline]
    fn pixel(displacement: [f64; 2]) -> usize {
        // Adding this leaves an integer in the low bits: quicker than a conversion that saturates.
        const INTEGER: f64 = 1.5 * (1_u64 << 52) as f64;
        let [first, second] = displacement.map(|value| {
            // Rounding to the nearest, half a pixel lower, is truncation.
            let pixel = (value + 1.0) * (0.5 * PIXELS as f64) - 0.5 + INTEGER;
            #[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap, clippy::cast_sign_loss)]
            let pixel = (pixel.to_bits() as u32).cast_signed().clamp(0, PIXELS as i32 - 1) as usize;
            pixel
        });
        first * PIXELS + second
    }

    fn new() -> Self {
        /// Above all roundings, and above what square roots make of these.
        const MARGIN: f64 = 1e-6;
        let side = 2.0 / PIXELS as f64;
        let corner = |pixel: usize| [pixel / PIXELS, pixel % PIXELS].map(|index| index as f64 * side - 1.0);
        // Least and largest distance of points in two squares, the second of them a pixel.
        let distances = |from: [f64; 2], size: f64, pixel: usize| {
            let to = corner(pixel);
            let (mut least, mut largest) = (0.0, 0.0);
            for axis in 0..2 {
                let (below, above) = (to[axis] - from[axis] - size, to[axis] + side - from[axis]);
                let near = below.max(-above).max(0.0);
                let far = above.max(-below);
                (least, largest) = (least + near * near, largest + far * far);
            }
            [least, largest]
        };
        let height = |squared: f64| f64::max(1.0 - squared, 0.0).sqrt();
        let count = PIXELS * PIXELS;
        let mut all = Mask::default();
        let mut behind = vec![Mask::default(); count];
        for far in 0..count {
            let [least, _] = distances([0.0; 2], 0.0, far);
            if least > 1.0 + MARGIN {
                continue;
            }
            all[far / 64] |= 1 << (far % 64);
            for (near, hidden) in behind.iter_mut().enumerate() {
                let [_, to_near] = distances([0.0; 2], 0.0, near);
                let [_, between] = distances(corner(near), side, far);
                // On the way from the one to the other at least as long as if they touched directly.
                if between < 1.0 - MARGIN && height(to_near) + height(between) > height(least) + MARGIN {
                    hidden[far / 64] |= 1 << (far % 64);
                }
            }
        }
        Self { behind: behind.into(), all }
    }
}

/// The graph of a tile.
#[derive(Debug, Clone, Default)]
pub(super) struct Constraints {
    links: Vec<Link>,
    /// Where the links of each mobile sphere begin: those behind it, then those ahead; and the end.
    starts: Vec<u32>,
    /// Memory that is used again.
    lists: Vec<Vec<Entry>>,
    edges: Vec<(u32, Link)>,
}

impl Constraints {
    /// Finds who can touch whom. Candidates come in the order along the axis; the first `mobile` spheres by number move.
    /// `contact` is the squared distance at which spheres touch, `period` that along the axis.
    pub(super) fn find(
        &mut self,
        columns: &Columns,
        candidates: &[Candidate],
        mobile: usize,
        contact: f64,
        period: Option<f64>,
    ) {
        let shadows = Shadows::get();
        let count = columns.counts[0] * columns.counts[1];
        if self.lists.len() < count {
            self.lists.resize_with(count, Vec::new);
        }
        self.lists.iter_mut().for_each(Vec::clear);
        self.edges.clear();
        if period.is_some() {
            for candidate in candidates {
                self.list(columns, candidate, true);
            }
        }
        for candidate in candidates {
            let mut hidden = Mask::default();
            let frozen = candidate.sphere as usize >= mobile;
            // The nearest first.
            for entry in self.lists[candidate.column as usize].iter().rev() {
                let displacement = [0, 1].map(|axis: usize| entry.across[axis] - candidate.across[axis]);
                let squared = displacement[0] * displacement[0] + displacement[1] * displacement[1];
                if squared >= contact {
                    continue;
                }
                if entry.image && entry.sphere == candidate.sphere {
                    // Once round.
                    break;
                }
                let pixel = Shadows::pixel(displacement);
                if !contains(&hidden, pixel) && (!frozen || (entry.sphere as usize) < mobile) {
                    let reach = (contact - squared).sqrt();
                    let reach = if entry.image { reach - period.unwrap_or(0.0) } else { reach };
                    self.edges.push((entry.sphere, Link { reach, other: candidate.sphere }));
                }
                // Nearly one diameter off, it might be passed.
                if squared < 1.0 - 1e-6 {
                    let behind = &shadows.behind[pixel];
                    let mut left = 0;
                    for word in 0..hidden.len() {
                        hidden[word] |= behind[word];
                        left |= shadows.all[word] & !hidden[word];
                    }
                    if left == 0 {
                        break;
                    }
                }
            }
            self.list(columns, candidate, false);
        }
        self.sort(mobile);
    }

    #[inline]
    fn list(&mut self, columns: &Columns, candidate: &Candidate, image: bool) {
        let lists = &mut self.lists;
        columns.around(candidate.column, |column, shifts| {
            // Seen from beyond an edge, coordinates differ by a period.
            let across = [0, 1].map(|axis: usize| candidate.across[axis] + shifts[axis]);
            lists[column].push(Entry { across, sphere: candidate.sphere, image });
        });
    }

    /// Puts the edges in the order of the spheres, from both ends.
    fn sort(&mut self, mobile: usize) {
        let Self { links, starts, edges, .. } = self;
        starts.clear();
        starts.resize(2 * mobile + 2, 0);
        // Twice the sphere for what is behind, one more for what is ahead.
        let ends = |&(behind, Link { reach, other }): &(u32, Link)| {
            [
                (2 * other as usize, Link { reach, other: behind }),
                (2 * behind as usize + 1, Link { reach, other }),
            ]
        };
        for edge in edges.iter() {
            for (slot, _) in ends(edge) {
                if slot < 2 * mobile {
                    starts[slot + 2] += 1;
                }
            }
        }
        for slot in 2..starts.len() {
            starts[slot] += starts[slot - 1];
        }
        links.clear();
        links.resize(starts.last().map_or(0, |&end| end as usize), Link::default());
        for edge in edges.iter() {
            for (slot, link) in ends(edge) {
                if slot < 2 * mobile {
                    links[starts[slot + 1] as usize] = link;
                    starts[slot + 1] += 1;
                }
            }
        }
    }

    /// Spheres that a mobile one may touch on its way.
    #[inline]
    pub(super) fn links(&self, sphere: usize, forward: bool) -> &[Link] {
        let slot = 2 * sphere + usize::from(forward);
        &self.links[self.starts[slot] as usize..self.starts[slot + 1] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Generator, unit};
    use rand::SeedableRng;

    /// Spheres without overlaps in a box that repeats across, and along the axis too if asked to.
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
                    let found = constraints.links(sphere, forward);
                    links += found.len();
                    let found = found
                        .iter()
                        .map(|link| ahead(&spheres[link.other as usize]) - link.reach)
                        .fold(f64::INFINITY, f64::min);
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
            // Few, out of some ten less than a diameter off across.
            assert!(links < 8 * mobile, "{links} for {mobile}");
        }
    }
}
