//! Neighboring cells within one diameter of a position.

use wide::u8x16;

/// The 27 cells around and including one: bit 9 layer + 3 row + column of a set of cells, each
/// counted from the cell before.
pub(super) const NEIGHBORS: usize = 27;
/// Number of parts of a cell along each axis.
pub(super) const PARTS: usize = 16;
/// Parts along each axis that differ in which cells are visited first.
const QUARTERS: usize = 4;
/// Far above the rounding of coordinates.
const MARGIN: f64 = 1e-6;
/// The 27 cells, one bit for each.
const ALL: u32 = (1 << NEIGHBORS) - 1;
/// Cells that are visited first.
const FIRST: usize = 5;

/// One byte for each of the 27 cells.
type Row = [u8x16; 2];

/// The cells within one diameter of a part of a cell.
///
/// The squared distance is a sum of a term for each axis. The terms of all 27 cells for a part
/// along one axis are a row of bytes, rounded down: so a sum of three rows gives the result for all
/// cells at once, and the table is small.
#[derive(Debug, Clone)]
pub(super) struct Reach {
    squared_gaps: Box<[[Row; PARTS]; 3]>,
    /// The cells to visit first, by quarters and octant.
    first: Box<[u32; FIRST_SETS]>,
}

const FIRST_SETS: usize = QUARTERS * QUARTERS * QUARTERS * 8;

/// Whether a neighboring cell lies before, at or after the middle one along an axis: 0, 1 or 2.
fn offset(bit: usize, axis: usize) -> usize {
    [bit / 9, bit / 3 % 3, bit % 3][axis]
}

impl Reach {
    pub(super) fn new(sides: [f64; 3]) -> Self {
        let row = |axis: usize, part: usize| {
            let below = part as f64 / PARTS as f64;
            let above = 1.0 - (part + 1) as f64 / PARTS as f64;
            let terms = [below, 0.0, above].map(|gap| {
                let gap = f64::max(sides[axis] * gap - MARGIN, 0.0);
                // One diameter is 128, the highest bit; more than 255 becomes 255.
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                let term = (128.0 * gap * gap) as u8;
                term
            });
            let byte = |bit: usize| if bit < NEIGHBORS { terms[offset(bit, axis)] } else { 0 };
            [0, 16].map(|first| u8x16::new(std::array::from_fn(|lane| byte(first + lane))))
        };
        Self {
            squared_gaps: Box::new(std::array::from_fn(|axis| std::array::from_fn(|part| row(axis, part)))),
            first: likeliest(sides),
        }
    }

    /// Index of a part, from those along x, y, z.
    #[inline]
    pub(super) fn part([x, y, z]: [u32; 3]) -> u32 {
        // A small constant.
        #[allow(clippy::cast_possible_truncation)]
        let parts = PARTS as u32;
        (x % parts * parts + y % parts) * parts + z % parts
    }

    /// The cells in reach of a part: in the low half those with the most likely overlaps for a
    /// displacement in the direction of `octant`, in the high half the others.
    #[inline]
    pub(super) fn cells(&self, part: u32, octant: usize) -> u64 {
        let part = part as usize;
        let parts = [part / (PARTS * PARTS) % PARTS, part / PARTS % PARTS, part % PARTS];
        let [x, y, z] = [0, 1, 2].map(|axis| &self.squared_gaps[axis][parts[axis]]);
        let beyond = |half: usize| x[half].saturating_add(y[half]).saturating_add(z[half]).to_bitmask();
        let cells = !(beyond(0) | beyond(1) << 16) & ALL;
        let [x, y, z] = parts.map(|part| part / (PARTS / QUARTERS));
        let first = self.first[(((x * QUARTERS + y) * QUARTERS + z) * 8 + octant) % FIRST_SETS];
        u64::from(cells & first) | u64::from(cells & !first) << 32
    }
}

/// The cells in which overlaps are most likely after a displacement into a part, by quarters and
/// octant. They affect only the speed of the search.
fn likeliest(sides: [f64; 3]) -> Box<[u32; FIRST_SETS]> {
    const STEPS: usize = 7;
    // Points of the grid on the faces of a cube to points on the sphere: directions with weights.
    let directions: Vec<([f64; 3], f64)> = (0..STEPS * STEPS * STEPS)
        .filter_map(|point| {
            let steps = [point / (STEPS * STEPS), point / STEPS % STEPS, point % STEPS];
            let direction = steps.map(|step| step as f64 - 0.5 * (STEPS - 1) as f64);
            let length = direction.iter().map(|along| along * along).sum::<f64>().sqrt();
            (length > 0.0).then(|| (direction.map(|along| along / length), 1.0 / (length * length * length)))
        })
        .collect();
    let mut first = Box::new([0; FIRST_SETS]);
    for (part, first) in first.chunks_exact_mut(8).enumerate() {
        let parts = [part / (QUARTERS * QUARTERS), part / QUARTERS % QUARTERS, part % QUARTERS];
        let mut weights = [[0.0; NEIGHBORS]; 8];
        for &(direction, weight) in &directions {
            let bit = (0..3).fold(0, |bit, axis| {
                let to = (parts[axis] as f64 + 0.5) / QUARTERS as f64 + 0.95 * direction[axis] / sides[axis];
                3 * bit + usize::from(to >= 0.0) + usize::from(to >= 1.0)
            });
            for (octant, weights) in weights.iter_mut().enumerate() {
                let along = |axis: usize| direction[axis] * if octant >> axis & 1 == 1 { 1.0 } else { -1.0 };
                weights[bit] += weight * f64::max(along(0) + along(1) + along(2), 0.0);
            }
        }
        for (first, weights) in first.iter_mut().zip(&weights) {
            let mut order: [usize; NEIGHBORS] = std::array::from_fn(|bit| bit);
            order.select_nth_unstable_by(FIRST, |&a, &b| weights[b].total_cmp(&weights[a]).then(a.cmp(&b)));
            *first = order[..FIRST].iter().map(|bit| 1 << bit).sum();
        }
    }
    first
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Generator, unit};
    use rand::SeedableRng;

    #[test]
    fn cells_left_out_hold_nothing_in_reach() {
        let mut generator = Generator::seed_from_u64(3);
        for sides in [[1.0, 1.01, 1.04], [1.25; 3], [1.45, 1.3, 1.2]] {
            let reach = Reach::new(sides);
            let (mut kept, mut needed) = (0, 0);
            for _ in 0..40_000 {
                let place = [0, 1, 2].map(|_| unit(&mut generator));
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                let part = Reach::part(place.map(|along| (along * PARTS as f64) as u32));
                let cells = (0..8).map(|octant| reach.cells(part, octant)).map(|cells| {
                    assert_eq!(cells & cells >> 32, 0, "a cell is visited twice");
                    (cells | cells >> 32) & u64::from(ALL)
                });
                let cells: Vec<u64> = cells.collect();
                assert!(cells.iter().all(|other| *other == cells[0]), "the octant is only for the order");
                kept += cells[0].count_ones();
                for bit in 0..NEIGHBORS {
                    // The nearest point of the cell.
                    let corner = |axis: usize| offset(bit, axis) as f64 - 1.0;
                    let nearest = [0, 1, 2].map(|axis| place[axis].clamp(corner(axis), corner(axis) + 1.0));
                    let distance = (0..3).map(|axis| sides[axis] * (nearest[axis] - place[axis]));
                    if distance.map(|along| along * along).sum::<f64>() < 1.0 {
                        assert_eq!(cells[0] >> bit & 1, 1, "cell {bit} from {place:?}");
                        needed += 1;
                    }
                }
            }
            assert!(f64::from(kept) < 1.12 * f64::from(needed), "{kept} of {needed} needed");
        }
    }
}
