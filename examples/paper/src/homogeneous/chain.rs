//! Straight event chains, always in the positive direction of an axis (Bernard, Krauth and Wilson,
//! doi:10.1103/PhysRevE.80.056704).

use super::cells::{Cells, OFFSETS, SHIFTS};
use rand::{Rng, RngExt};

/// So many chains, of a mean length of the side of the cube: separations in all collisions, path,
/// number of collisions.
pub(crate) fn sweep(cells: &mut Cells, chains: u64, generator: &mut impl Rng) -> (f64, f64, u64) {
    // Some hundreds.
    #[allow(clippy::cast_possible_truncation)]
    let particles = cells.particles() as u32;
    let (mut transferred, mut path, mut events) = (0.0, 0.0, 0);
    for _ in 0..chains {
        // Not commensurate with the cube.
        let length = 2.0 * cells.side() * generator.random::<f64>();
        let mut sphere = generator.random_range(0..particles);
        let axis = generator.random_range(0..3_usize);
        let mut left = length;
        loop {
            let step = ahead(cells, sphere, axis, left);
            advance(cells, sphere, axis, step.distance);
            left -= step.distance;
            if let Some((next, separation)) = step.collision {
                transferred += separation;
                events += 1;
                sphere = next;
            } else if left <= 0.0 {
                break;
            }
        }
        path += length;
    }
    (transferred, path, events)
}

/// A straight piece of a chain, and what ends it, if it is not the chain's own end.
struct Step {
    distance: f64,
    collision: Option<(u32, f64)>,
}

/// Which cells of [`OFFSETS`] lie beside a cell across an axis, itself included.
const BESIDE: [[usize; 9]; 3] = [beside(0), beside(1), beside(2)];
/// Which one lies ahead.
const AHEAD: [usize; 3] = [after(0), after(1), after(2)];

const fn beside(axis: usize) -> [usize; 9] {
    let (mut found, mut next, mut index) = ([0; 9], 0, 0);
    while index < 27 {
        if OFFSETS[index][axis] == 1 {
            found[next] = index;
            next += 1;
        }
        index += 1;
    }
    found
}

const fn after(axis: usize) -> usize {
    let mut index = 0;
    while index < 27 {
        let [x, y, z] = OFFSETS[index];
        if OFFSETS[index][axis] == 2 && x + y + z == 4 {
            return index;
        }
        index += 1;
    }
    0
}

/// How far a sphere can go along an axis, `longest` at most.
#[inline]
fn ahead(cells: &Cells, sphere: u32, axis: usize, longest: f64) -> Step {
    let side = cells.cell_side();
    let (mut cell, slot) = cells.places[sphere as usize];
    let center = cells.grid[cell as usize].center(slot as usize);
    let gaps = cells.gaps(center);
    let across = [(axis + 1) % 3, (axis + 2) % 3];
    let mut step = Step { distance: longest, collision: None };
    // Layers of cells ahead, at most up to the sphere itself.
    for layer in 0..cells.edge() - 1 {
        let begin = layer as f64 * side;
        for index in BESIDE[axis] {
            let offset = OFFSETS[index];
            let [one, other] = across.map(|across| gaps[across][offset[across]]);
            if one + other >= 1.0 {
                continue;
            }
            let from = across.map(|across| center[across] - SHIFTS[offset[across]] * side);
            let candidates = &cells.grid[cells.neighbors[cell as usize][index] as usize];
            for slot in 0..candidates.count {
                let candidate = candidates.center(slot);
                let separation = candidate[axis] + begin - center[axis];
                // Behind, or farther than what is found already.
                if separation <= 0.0 || separation - 1.0 >= step.distance {
                    continue;
                }
                let partner = candidates.spheres[slot];
                let [y, z] = [candidate[across[0]] - from[0], candidate[across[1]] - from[1]];
                let free = 1.0 - y * y - z * z;
                if free > 0.0 && partner != sphere {
                    let touching = free.sqrt();
                    // Rounding may have brought two that touch a little too close.
                    let distance = (separation - touching).max(0.0);
                    if distance < step.distance {
                        step = Step { distance, collision: Some((partner, touching)) };
                    }
                }
            }
        }
        // Nothing in the next layer can be met before this.
        if step.distance <= begin + side - center[axis] - 1.0 {
            return step;
        }
        cell = cells.neighbors[cell as usize][AHEAD[axis]];
    }
    // Nothing but emptiness, nearly all around: go as far as has been looked.
    let seen = (cells.edge() - 1) as f64 * side - center[axis] - 1.0;
    if step.distance <= seen { step } else { Step { distance: seen.max(0.0), collision: None } }
}

/// Moves a sphere along an axis.
#[inline]
fn advance(cells: &mut Cells, sphere: u32, axis: usize, distance: f64) {
    let (cell, slot) = cells.places[sphere as usize];
    let mut center = cells.grid[cell as usize].center(slot as usize);
    center[axis] += distance;
    let target = cells.settle(cell, &mut center);
    cells.place(sphere, target, center);
}
