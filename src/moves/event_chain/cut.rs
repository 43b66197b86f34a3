//! How space is cut into tiles that chains along one axis do not leave.

use crate::Slab;
use crate::random::{Generator, unit};

/// Distance between the mobile parts of neighboring tiles: more than the contact distance.
const STRIP: f64 = 1.0 + 1e-6;
/// Width of the rim around a tile in which its spheres can touch others: less than [`STRIP`], so
/// that none of those is mobile in another tile.
const RIM: f64 = 1.0 + 5e-7;

/// How large tiles are.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sizes {
    /// Spheres of a tile that fit the cache.
    pub(super) spheres: f64,
    /// Least widths of the mobile part of a tile: for vertical chains, and for lateral ones.
    pub(super) least: [f64; 2],
    /// Largest number of tiles that are visited together and share threads. Their outcomes are
    /// entered together.
    pub(super) together: usize,
}

/// A range of a coordinate across the chains, in which spheres are mobile.
#[derive(Debug, Clone, Copy)]
pub(super) struct Section {
    low: f64,
    width: f64,
    /// `None` between walls.
    period: Option<f64>,
    whole: bool,
}

impl Section {
    /// The coordinate relative to the section, and whether it is inside. `None` beyond the rim.
    #[inline]
    pub(super) fn locate(&self, value: f64) -> Option<(f64, bool)> {
        let mut within = value - self.low;
        if self.whole {
            return Some((within, true));
        }
        if let Some(period) = self.period {
            if within < 0.0 {
                within += period;
            }
            if within > period - RIM {
                within -= period;
            }
        }
        let inside = within >= 0.0 && within < self.width;
        (within > -RIM && within < self.width + RIM).then_some((within, inside))
    }

    /// The lowest relative coordinate of section and rim, and their width.
    pub(super) fn extent(&self) -> [f64; 2] {
        if self.whole { [0.0, self.width] } else { [-RIM, self.width + 2.0 * RIM] }
    }

    /// Period of the relative coordinates, if the section is the whole of a periodic axis.
    pub(super) fn repeats(&self) -> Option<f64> {
        self.period.filter(|_| self.whole)
    }

    /// The absolute coordinate of the relative coordinate 0.
    pub(super) fn low(&self) -> f64 {
        self.low
    }

    /// The cells of section and rim: the first one and their number.
    pub(super) fn cells(&self, cells: usize, side: f64) -> (usize, usize) {
        if self.whole {
            return (0, cells);
        }
        let [first, last] = [self.low - RIM, self.low + self.width + RIM].map(|edge| (edge / side).floor());
        // Coordinates are at most 1e6.
        #[allow(clippy::cast_possible_truncation)]
        let (first, last) = (first as i64, last as i64);
        let all = cells.cast_signed() as i64;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        if self.period.is_some() {
            let count = (last - first + 1).min(all);
            (first.rem_euclid(all) as usize, count as usize)
        } else {
            let (first, end) = (first.clamp(0, all), (last + 1).clamp(0, all));
            (first as usize, (end - first).max(0) as usize)
        }
    }
}

/// Equal sections of one axis, with strips between them.
#[derive(Debug, Clone, Copy)]
struct Division {
    extent: f64,
    periodic: bool,
    /// 1 if the axis is not cut.
    sections: usize,
    pitch: f64,
}

impl Division {
    /// Sections of about `width`, and at least `least`, if two of them fit.
    fn new(extent: f64, periodic: bool, width: f64, least: f64) -> Self {
        let [wanted, most] = [width, least].map(|width| extent / (width + STRIP));
        // At most 1e6.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let fitting = wanted.round().min(most) as usize;
        if fitting < 2 {
            return Self { extent, periodic, sections: 1, pitch: extent };
        }
        // Between walls the first and the last section are incomplete.
        Self { extent, periodic, sections: fitting + usize::from(!periodic), pitch: extent / fitting as f64 }
    }

    /// Share of the extent that is mobile, on average over shifts.
    fn mobile(&self) -> f64 {
        if self.sections == 1 { 1.0 } else { 1.0 - STRIP / self.pitch }
    }

    fn section(&self, number: usize, shift: f64) -> Section {
        let period = self.periodic.then_some(self.extent);
        if self.sections == 1 {
            return Section { low: 0.0, width: self.extent, period, whole: true };
        }
        let low = self.pitch * (number as f64 + shift - f64::from(!self.periodic));
        Section { low, width: self.pitch - STRIP, period, whole: false }
    }

    fn width(&self) -> f64 {
        if self.sections == 1 { self.extent } else { self.pitch - STRIP }
    }
}

/// A division into tiles for chains along one axis. Tiles extend over the whole of that axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cut {
    pub(super) axis: usize,
    divisions: [Division; 2],
}

impl Cut {
    /// The two axes across each axis.
    pub(super) const ACROSS: [[usize; 2]; 3] = [[1, 2], [0, 2], [0, 1]];

    pub(super) fn new(axis: usize, slab: &Slab, particles: usize, sizes: &Sizes) -> Self {
        /// Number density that is assumed for tiles of lateral chains.
        const DENSITY: f64 = 0.5;
        let [width_y, width_z] = slab.widths();
        let extents = [slab.height(), width_y, width_z];
        let column = particles as f64 / slab.base_area();
        // Spheres per area across the chains.
        let (density, least) =
            if axis == 0 { (column, sizes.least[0]) } else { (DENSITY * extents[axis], sizes.least[1]) };
        let area = sizes.spheres / density;
        let across = Self::ACROSS[axis];
        let divide = |axis: usize, width: f64| Division::new(extents[axis], axis != 0, width, least);
        // The narrower axis first: if it is not cut, tiles are longer along the other.
        let (narrow, wide) = if extents[across[0]] <= extents[across[1]] { (0, 1) } else { (1, 0) };
        let mut divisions = [divide(across[narrow], area.sqrt()); 2];
        divisions[wide] = divide(across[wide], area / divisions[narrow].width());
        Self { axis, divisions }
    }

    /// Number of tiles.
    pub(super) fn tiles(&self) -> usize {
        self.divisions[0].sections * self.divisions[1].sections
    }

    /// Share of the spheres that are mobile, on average over shifts.
    pub(super) fn mobile(&self) -> f64 {
        self.divisions[0].mobile() * self.divisions[1].mobile()
    }

    /// The cut at a random place.
    pub(super) fn shifted(self, generator: &mut Generator) -> Shifted {
        Shifted { cut: self, shifts: [unit(generator), unit(generator)] }
    }
}

/// A cut at its place in one visit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shifted {
    pub(super) cut: Cut,
    shifts: [f64; 2],
}

impl Shifted {
    pub(super) fn tile(&self, number: usize) -> [Section; 2] {
        let [first, second] = self.cut.divisions;
        [
            first.section(number / second.sections, self.shifts[0]),
            second.section(number % second.sections, self.shifts[1]),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn every_place_is_mobile_as_often_as_any_other_and_in_one_tile_only() {
        let sizes = Sizes { spheres: 0.0, least: [2.0, 1.5], together: 1 };
        let slab = Slab::new(14.0, 10.0, 4.0).unwrap();
        let extents = [slab.height(), 10.0, 4.0];
        let mut generator = Generator::seed_from_u64(1);
        let cuts = 20_000;
        for axis in 0..3 {
            let cut = Cut::new(axis, &slab, 100, &sizes);
            assert!(cut.tiles() >= 3);
            let across = Cut::ACROSS[axis];
            // Places near an edge, and anywhere.
            for place in [[0.501_f64, 0.001], [0.6, 3.999], [3.2, 1.7], [9.3, 2.0]] {
                let mut mobile = 0;
                for _ in 0..cuts {
                    let shifted = cut.shifted(&mut generator);
                    let mut owners = 0;
                    let mut neighbors = 0;
                    for tile in 0..cut.tiles() {
                        let sections = shifted.tile(tile);
                        let [first, second] = [0, 1]
                            .map(|side: usize| sections[side].locate(place[side].min(extents[across[side]])));
                        if let (Some((_, first)), Some((_, second))) = (first, second) {
                            owners += u32::from(first && second);
                            neighbors += u32::from(!(first && second));
                        }
                    }
                    // What is mobile in one tile is out of reach in all others.
                    assert!(owners == 0 || (owners == 1 && neighbors == 0));
                    mobile += owners;
                }
                let share = f64::from(mobile) / f64::from(cuts);
                // Four standard errors.
                let error = 4.0 * (0.25 / f64::from(cuts)).sqrt();
                assert!((share - cut.mobile()).abs() < error, "{axis} {place:?}: {share}, {}", cut.mobile());
            }
        }
    }
}
