//! Centers in cells, relative to the corners of these.

/// Most centers of a cell: spheres that do not overlap have at most eight in a cube of less than
/// √2, and room is left.
const SLOTS: usize = 12;
/// Number of slots that are always compared; more are rarely full.
const AT_ONCE: usize = 4;
/// Coordinate of an empty slot, far from everything.
const NOWHERE: f64 = 1e6;

/// The spheres of one cell.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cell {
    /// Along each axis.
    coordinates: [[f64; SLOTS]; 3],
    pub(crate) spheres: [u32; SLOTS],
    pub(crate) count: usize,
}

impl Cell {
    const EMPTY: Self = Self { coordinates: [[NOWHERE; SLOTS]; 3], spheres: [0; SLOTS], count: 0 };

    #[inline]
    pub(crate) fn center(&self, slot: usize) -> [f64; 3] {
        self.coordinates.map(|along| along[slot])
    }

    #[inline]
    fn set(&mut self, slot: usize, center: [f64; 3]) {
        for (along, value) in self.coordinates.iter_mut().zip(center) {
            along[slot] = value;
        }
    }

    /// Whether a sphere of this cell is closer than a diameter to a place.
    #[inline]
    fn overlaps(&self, [x, y, z]: [f64; 3]) -> bool {
        let mut closest = [0.0; AT_ONCE];
        for (slot, square) in closest.iter_mut().enumerate() {
            let [dx, dy, dz] =
                [self.coordinates[0][slot] - x, self.coordinates[1][slot] - y, self.coordinates[2][slot] - z];
            *square = dx * dx + dy * dy + dz * dz;
        }
        let [a, b, c, d] = closest.map(|square| square < 1.0);
        a | b | c | d || (AT_ONCE..self.count).any(|slot| square_distance(self.center(slot), [x, y, z]) < 1.0)
    }
}

/// A periodic cube, cut into cells.
#[derive(Debug, Clone)]
pub(crate) struct Cells {
    side: f64,
    edge: usize,
    cell_side: f64,
    pub(crate) grid: Vec<Cell>,
    /// Cell and slot of each sphere.
    pub(crate) places: Vec<(u32, u32)>,
    /// Of each cell, those around it, in the order of [`OFFSETS`].
    pub(crate) neighbors: Vec<[u32; 27]>,
}

/// Offsets along the three axes, plus one: the cell itself, six behind faces, twelve behind edges,
/// eight behind corners.
pub(crate) const OFFSETS: [[usize; 3]; 27] = offsets();

/// Where an offset stands in [`OFFSETS`].
const INDICES: [usize; 27] = indices();

const fn indices() -> [usize; 27] {
    let (mut indices, mut index) = ([0; 27], 0);
    while index < 27 {
        let [x, y, z] = OFFSETS[index];
        indices[9 * x + 3 * y + z] = index;
        index += 1;
    }
    indices
}

/// Offsets as numbers.
pub(crate) const SHIFTS: [f64; 3] = [-1.0, 0.0, 1.0];

const fn offsets() -> [[usize; 3]; 27] {
    let mut offsets = [[1; 3]; 27];
    let (mut next, mut kind) = (0, 0);
    while kind <= 3 {
        let mut index = 0;
        while index < 27 {
            let offset = [index / 9, index / 3 % 3, index % 3];
            let steps = (offset[0] != 1) as usize + (offset[1] != 1) as usize + (offset[2] != 1) as usize;
            if steps == kind {
                offsets[next] = offset;
                next += 1;
            }
            index += 1;
        }
        kind += 1;
    }
    offsets
}

impl Cells {
    /// Smallest side of a cell: what is closer than this is found in the cells around.
    pub(crate) const REACH: f64 = 1.1;

    /// An empty cube.
    pub(crate) fn new(side: f64) -> Self {
        // At least three, below some hundreds.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let edge = ((side / Self::REACH) as usize).max(3);
        let neighbors = (0..edge * edge * edge)
            .map(|index| {
                let here = [index / (edge * edge), index / edge % edge, index % edge];
                OFFSETS.map(|offset| {
                    let [x, y, z] = [0, 1, 2].map(|axis| (here[axis] + offset[axis] + edge - 1) % edge);
                    // Far below 2³².
                    #[allow(clippy::cast_possible_truncation)]
                    let cell = ((x * edge + y) * edge + z) as u32;
                    cell
                })
            })
            .collect();
        Self {
            side,
            edge,
            cell_side: side / edge as f64,
            grid: vec![Cell::EMPTY; edge * edge * edge],
            places: Vec::new(),
            neighbors,
        }
    }

    pub(crate) fn particles(&self) -> usize {
        self.places.len()
    }

    pub(crate) fn side(&self) -> f64 {
        self.side
    }

    pub(crate) fn cell_side(&self) -> f64 {
        self.cell_side
    }

    /// Cells along an edge of the cube.
    pub(crate) fn edge(&self) -> usize {
        self.edge
    }

    /// Adds a sphere at a place within the cube.
    pub(crate) fn insert(&mut self, center: [f64; 3]) {
        let mut relative = center;
        let cell = self.settle(0, &mut relative);
        // Some hundreds.
        #[allow(clippy::cast_possible_truncation)]
        let sphere = self.places.len() as u32;
        self.places.push((0, 0));
        self.push(cell, sphere, relative);
    }

    fn push(&mut self, cell: u32, sphere: u32, relative: [f64; 3]) {
        let target = &mut self.grid[cell as usize];
        target.set(target.count, relative);
        target.spheres[target.count] = sphere;
        // Below the number of slots.
        #[allow(clippy::cast_possible_truncation)]
        let slot = target.count as u32;
        self.places[sphere as usize] = (cell, slot);
        target.count += 1;
    }

    /// The cell of a place given relative to a cell, and makes the place relative to it.
    #[inline]
    pub(crate) fn settle(&self, cell: u32, relative: &mut [f64; 3]) -> u32 {
        let inside = |x: f64| x >= 0.0 && x < self.cell_side;
        if inside(relative[0]) && inside(relative[1]) && inside(relative[2]) {
            return cell;
        }
        let edge = self.edge;
        // Nearly always a cell beside it.
        let beside = |x: f64| {
            if x < 0.0 {
                0
            } else if x < self.cell_side {
                1
            } else {
                2
            }
        };
        let offset = relative.map(beside);
        let shifted = [0, 1, 2].map(|axis| relative[axis] - SHIFTS[offset[axis]] * self.cell_side);
        if shifted.iter().all(|&x| inside(x)) {
            *relative = shifted;
            return self.neighbors[cell as usize][INDICES[offset[0] * 9 + offset[1] * 3 + offset[2]]];
        }
        let cell = cell as usize;
        let mut here = [cell / (edge * edge), cell / edge % edge, cell % edge];
        for (coordinate, index) in relative.iter_mut().zip(&mut here) {
            let steps = (*coordinate / self.cell_side).floor();
            *coordinate = (*coordinate - steps * self.cell_side).max(0.0);
            // A few cells either way.
            #[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap)]
            let moved = (*index as i64 + steps as i64).rem_euclid(edge as i64);
            *index = usize::try_from(moved).unwrap_or(0);
            if *coordinate >= self.cell_side {
                // Rounding.
                *coordinate = 0.0;
                *index = (*index + 1) % edge;
            }
        }
        // Far below 2³².
        #[allow(clippy::cast_possible_truncation)]
        let cell = ((here[0] * edge + here[1]) * edge + here[2]) as u32;
        cell
    }

    /// Puts a sphere at a place that is relative to a cell, inside it.
    #[inline]
    pub(crate) fn place(&mut self, sphere: u32, cell: u32, relative: [f64; 3]) {
        let (old, slot) = self.places[sphere as usize];
        if old == cell {
            self.grid[cell as usize].set(slot as usize, relative);
            return;
        }
        let source = &mut self.grid[old as usize];
        source.count -= 1;
        let last = source.count;
        let moved = source.spheres[last];
        let center = source.center(last);
        source.set(slot as usize, center);
        source.set(last, [NOWHERE; 3]);
        source.spheres[slot as usize] = moved;
        self.places[moved as usize].1 = slot;
        self.push(cell, sphere, relative);
    }

    /// Whether a sphere overlaps no other at this place in a cell.
    #[inline]
    pub(crate) fn is_free(&mut self, sphere: u32, cell: u32, center: [f64; 3]) -> bool {
        let (own, slot) = self.places[sphere as usize];
        let here = self.grid[own as usize].center(slot as usize);
        // It is not in its own way.
        self.grid[own as usize].set(slot as usize, [NOWHERE; 3]);
        let gaps = self.gaps(center);
        let overlaps = OFFSETS.iter().zip(&self.neighbors[cell as usize]).any(|(offset, &neighbor)| {
            let near = gaps[0][offset[0]] + gaps[1][offset[1]] + gaps[2][offset[2]] < 1.0;
            near && {
                let from = [0, 1, 2].map(|axis| center[axis] - SHIFTS[offset[axis]] * self.cell_side);
                self.grid[neighbor as usize].overlaps(from)
            }
        });
        self.grid[own as usize].set(slot as usize, here);
        !overlaps
    }

    /// Squares of the distances from a place in a cell to the cells before, at and after it along
    /// each axis.
    #[inline]
    pub(crate) fn gaps(&self, relative: [f64; 3]) -> [[f64; 3]; 3] {
        relative.map(|coordinate| {
            let after = self.cell_side - coordinate;
            [coordinate * coordinate, 0.0, after * after]
        })
    }

    /// Smallest distance of two spheres.
    pub(crate) fn smallest_distance(&self) -> f64 {
        let mut smallest = f64::INFINITY;
        self.pairs_within(Self::REACH, |distance| smallest = f64::min(smallest, distance));
        smallest
    }

    /// Calls `visit` with the distance of every pair closer than `reach`, at most [`Self::REACH`].
    pub(crate) fn pairs_within(&self, reach: f64, mut visit: impl FnMut(f64)) {
        let square = reach * reach;
        for (here, cell) in self.grid.iter().enumerate() {
            for slot in 0..cell.count {
                let (center, sphere) = (cell.center(slot), cell.spheres[slot]);
                let gaps = self.gaps(center);
                for (offset, &neighbor) in OFFSETS.iter().zip(&self.neighbors[here]) {
                    if gaps[0][offset[0]] + gaps[1][offset[1]] + gaps[2][offset[2]] >= square {
                        continue;
                    }
                    let from = [0, 1, 2].map(|axis| center[axis] - SHIFTS[offset[axis]] * self.cell_side);
                    let other = &self.grid[neighbor as usize];
                    for slot in 0..other.count {
                        let distance = square_distance(from, other.center(slot));
                        // Each pair once.
                        if distance < square && other.spheres[slot] > sphere {
                            visit(distance.sqrt());
                        }
                    }
                }
            }
        }
    }
}

#[inline]
pub(crate) fn square_distance(one: [f64; 3], other: [f64; 3]) -> f64 {
    let [x, y, z] = [0, 1, 2].map(|axis| one[axis] - other[axis]);
    x * x + y * y + z * z
}
