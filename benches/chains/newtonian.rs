//! Newtonian event chains (Klement and Engel, doi:10.1063/1.5090882) in a uniform field, as
//! compactly as is fast: measured against the library's straight chains, and no part of it.
//!
//! All spheres have velocities; only the active one moves, until it touches another. Their
//! velocities change as in an elastic collision, and the other is active. Where the field stops the
//! active sphere, another goes on, drawn at random: it gets the vertical velocity, turned
//! downwards, in exchange for its own. Every state that starts downhill is thereby entered as often
//! as it is left, as with straight chains.

use gradient_mc::Vector3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const SLOTS: usize = 8;

#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
struct Cell {
    positions: [[f64; SLOTS]; 3],
    occupants: [u32; SLOTS],
    count: u32,
}

/// What becomes of a chain that the field stops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Rule {
    Relocate,
    Reflect,
}

#[derive(Debug)]
pub(crate) struct NewtonianColumn {
    extents: [f64; 3],
    temperature: f64,
    duration: f64,
    rule: Rule,
    cells: [usize; 3],
    sides: [f64; 3],
    grid: Vec<Cell>,
    /// Cell and slot of each sphere.
    places: Vec<(u32, u32)>,
    coordinates: Vec<[usize; 3]>,
    velocities: Vec<[f64; 3]>,
    generator: Pcg64Mcg,
    pub(crate) events: u64,
    time: f64,
}

/// What ends a straight piece.
enum Stop {
    End,
    Field,
    Edge(usize),
    Sphere { other: usize, normal: [f64; 3] },
}

impl NewtonianColumn {
    /// Chains of a mean duration in units in which each component of a velocity has variance 1.
    pub(crate) fn new(
        extents: [f64; 3],
        temperature: f64,
        duration: f64,
        rule: Rule,
        positions: &[Vector3<f64>],
        seed: u64,
    ) -> Self {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let cells = extents.map(|extent| extent as usize);
        let sides = [0, 1, 2].map(|axis| extents[axis] / cells[axis] as f64);
        let empty = Cell { positions: [[0.0; SLOTS]; 3], occupants: [0; SLOTS], count: 0 };
        let mut column = Self {
            extents,
            temperature,
            duration,
            rule,
            cells,
            sides,
            grid: vec![empty; cells.iter().product()],
            places: vec![(0, 0); positions.len()],
            coordinates: vec![[0; 3]; positions.len()],
            velocities: vec![[0.0; 3]; positions.len()],
            generator: Pcg64Mcg::seed_from_u64(seed),
            events: 0,
            time: 0.0,
        };
        for (sphere, position) in positions.iter().enumerate() {
            let position: [f64; 3] = (*position).into();
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let coordinates = [0, 1, 2].map(|a| ((position[a] / sides[a]) as usize).min(cells[a] - 1));
            column.insert(sphere, coordinates, position);
        }
        column
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.cells[1] + y) * self.cells[0] + x
    }

    #[allow(clippy::cast_possible_truncation)]
    fn insert(&mut self, sphere: usize, coordinates: [usize; 3], position: [f64; 3]) {
        let index = self.index(coordinates);
        let cell = &mut self.grid[index];
        let slot = cell.count as usize;
        assert!(slot < SLOTS, "a cell overflows");
        cell.count += 1;
        cell.occupants[slot] = sphere as u32;
        for axis in 0..3 {
            cell.positions[axis][slot] = position[axis];
        }
        self.places[sphere] = (index as u32, slot as u32);
        self.coordinates[sphere] = coordinates;
    }

    fn remove(&mut self, sphere: usize) {
        let (index, slot) = self.places[sphere];
        let cell = &mut self.grid[index as usize];
        cell.count -= 1;
        let last = cell.count as usize;
        for axis in 0..3 {
            cell.positions[axis][slot as usize] = cell.positions[axis][last];
        }
        let moved = cell.occupants[last];
        cell.occupants[slot as usize] = moved;
        self.places[moved as usize] = (index, slot);
    }

    pub(crate) fn position(&self, sphere: usize) -> [f64; 3] {
        let (index, slot) = self.places[sphere];
        let cell = &self.grid[index as usize];
        [0, 1, 2].map(|axis| cell.positions[axis][slot as usize])
    }

    pub(crate) fn len(&self) -> usize {
        self.places.len()
    }

    fn unit(&mut self) -> f64 {
        self.generator.random::<f64>()
    }

    fn exponential(&mut self) -> f64 {
        -libm::log(1.0 - self.unit())
    }

    /// Velocities of all spheres anew.
    fn refresh(&mut self) {
        for sphere in 0..self.velocities.len() {
            for pair in 0..2 {
                let radius = (2.0 * self.exponential()).sqrt();
                let (sine, cosine) = libm::sincos(std::f64::consts::TAU * self.unit());
                if pair == 0 {
                    (self.velocities[sphere][0], self.velocities[sphere][1]) =
                        (radius * cosine, radius * sine);
                } else {
                    self.velocities[sphere][2] = radius * cosine;
                }
            }
        }
    }

    /// Chains whose durations add up to `time`, on average, with fresh velocities.
    pub(crate) fn run(&mut self, time: f64) {
        self.refresh();
        self.time -= time;
        while self.time < 0.0 {
            let duration = 2.0 * self.duration * self.unit();
            self.time += duration;
            self.chain(duration);
        }
    }

    fn random_sphere(&mut self) -> usize {
        let count = self.velocities.len();
        self.generator.random_range(0..count)
    }

    fn chain(&mut self, mut left: f64) {
        let mut active = self.random_sphere();
        let mut clock = self.exponential();
        loop {
            let (position, velocity) = (self.position(active), self.velocities[active]);
            let (mut time, stop) = self.first_stop(active, position, velocity, left, clock);
            time = time.max(0.0);
            left -= time;
            let climb = velocity[0] * time;
            if climb > 0.0 {
                clock -= climb / self.temperature;
            }
            let mut target = [0, 1, 2].map(|axis| position[axis] + velocity[axis] * time);
            target[0] = target[0].clamp(0.5, self.extents[0] - 0.5);
            if let Stop::Edge(axis) = stop {
                self.cross(active, axis, target);
                continue;
            }
            let (index, slot) = self.places[active];
            for axis in 0..3 {
                self.grid[index as usize].positions[axis][slot as usize] = target[axis];
            }
            self.events += 1;
            match stop {
                Stop::Sphere { other, normal } => {
                    let along = |v: [f64; 3]| v[0] * normal[0] + v[1] * normal[1] + v[2] * normal[2];
                    let exchanged = along(velocity) - along(self.velocities[other]);
                    for axis in 0..3 {
                        self.velocities[active][axis] -= exchanged * normal[axis];
                        self.velocities[other][axis] += exchanged * normal[axis];
                    }
                    active = other;
                }
                Stop::Field => {
                    clock = self.exponential();
                    let other = if self.rule == Rule::Relocate { self.random_sphere() } else { active };
                    let vertical = self.velocities[active][0];
                    self.velocities[active][0] = self.velocities[other][0];
                    self.velocities[other][0] = -vertical;
                    active = other;
                }
                Stop::End | Stop::Edge(_) => return,
            }
        }
    }

    /// Moves a sphere into the next cell along an axis, or off a wall.
    fn cross(&mut self, sphere: usize, axis: usize, mut target: [f64; 3]) {
        let forward = self.velocities[sphere][axis] > 0.0;
        let mut coordinates = self.coordinates[sphere];
        let wall = if forward { self.extents[0] - 0.5 } else { 0.5 };
        if axis == 0 && (target[0] - wall).abs() < 1e-12 {
            self.velocities[sphere][0] = -self.velocities[sphere][0];
            self.events += 1;
        } else {
            let count = self.cells[axis];
            coordinates[axis] = if forward {
                (coordinates[axis] + 1) % count
            } else {
                (coordinates[axis] + count - 1) % count
            };
            target[axis] = (coordinates[axis] + usize::from(!forward)) as f64 * self.sides[axis];
        }
        self.remove(sphere);
        self.insert(sphere, coordinates, target);
    }

    /// What stops the active sphere first: the end of the chain, the field, the edge of its cell or
    /// the wall, or another sphere in the 27 cells around.
    #[inline]
    fn first_stop(
        &self,
        active: usize,
        position: [f64; 3],
        velocity: [f64; 3],
        left: f64,
        clock: f64,
    ) -> (f64, Stop) {
        let (mut time, mut stop) = (left, Stop::End);
        if velocity[0] > 0.0 && clock * self.temperature < velocity[0] * time {
            (time, stop) = (clock * self.temperature / velocity[0], Stop::Field);
        }
        let home = self.coordinates[active];
        for axis in 0..3 {
            let low = home[axis] as f64 * self.sides[axis];
            let mut edge = if velocity[axis] > 0.0 { low + self.sides[axis] } else { low };
            if axis == 0 {
                edge = edge.clamp(0.5, self.extents[0] - 0.5);
            }
            if velocity[axis] != 0.0 && edge - position[axis] < time * velocity[axis] && velocity[axis] > 0.0
                || velocity[axis] < 0.0 && edge - position[axis] > time * velocity[axis]
            {
                (time, stop) = ((edge - position[axis]) / velocity[axis], Stop::Edge(axis));
            }
        }
        let speed = velocity[0] * velocity[0] + velocity[1] * velocity[1] + velocity[2] * velocity[2];
        let neighbors = |axis: usize| {
            let (at, count) = (home[axis], self.cells[axis]);
            [if at == 0 { count - 1 } else { at - 1 }, at, if at + 1 == count { 0 } else { at + 1 }]
        };
        let rows = home[0].saturating_sub(1)..(home[0] + 2).min(self.cells[0]);
        let half = [0.5 * self.extents[1], 0.5 * self.extents[2]];
        for z in neighbors(2) {
            for y in neighbors(1) {
                let first = self.index([0, y, z]);
                for cell in &self.grid[first + rows.start..first + rows.end] {
                    for slot in 0..cell.count as usize {
                        let mut apart = [0, 1, 2].map(|axis| cell.positions[axis][slot] - position[axis]);
                        for axis in 1..3 {
                            if apart[axis] > half[axis - 1] {
                                apart[axis] -= self.extents[axis];
                            } else if apart[axis] < -half[axis - 1] {
                                apart[axis] += self.extents[axis];
                            }
                        }
                        let approach =
                            apart[0] * velocity[0] + apart[1] * velocity[1] + apart[2] * velocity[2];
                        if approach <= 0.0 {
                            continue;
                        }
                        let squared = apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2];
                        let discriminant = approach * approach - speed * (squared - 1.0);
                        if discriminant <= 0.0 || cell.occupants[slot] as usize == active {
                            continue;
                        }
                        let when = ((approach - discriminant.sqrt()) / speed).max(0.0);
                        if when < time {
                            time = when;
                            let normal = [0, 1, 2].map(|axis| apart[axis] - velocity[axis] * when);
                            let length =
                                (normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2])
                                    .sqrt();
                            let normal = normal.map(|component| component / length);
                            stop = Stop::Sphere { other: cell.occupants[slot] as usize, normal };
                        }
                    }
                }
            }
        }
        (time, stop)
    }
}
