//! The algorithm of the paper in its simplest form, as a reference: linked-list cells, random
//! sphere, cubic displacement, uniform field, one temperature.

use gradient_mc::Vector3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const NONE: usize = usize::MAX;

/// Hard spheres in a slab with a square base.
#[derive(Debug)]
pub struct PlainColumn {
    height: f64,
    width: f64,
    temperature: f64,
    displacement: f64,
    cells: [usize; 2],
    heads: Vec<usize>,
    next: Vec<usize>,
    positions: Vec<[f64; 3]>,
    generator: Pcg64Mcg,
}

impl PlainColumn {
    /// Makes a column from positions in a slab with a square base.
    pub fn new(
        height: f64,
        width: f64,
        temperature: f64,
        displacement: f64,
        positions: &[Vector3<f64>],
        seed: u64,
    ) -> Self {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let cells = [height as usize, width as usize];
        let mut column = Self {
            height,
            width,
            temperature,
            displacement,
            cells,
            heads: vec![NONE; cells[0] * cells[1] * cells[1]],
            next: vec![NONE; positions.len()],
            positions: positions.iter().map(|&position| position.into()).collect(),
            generator: Pcg64Mcg::seed_from_u64(seed),
        };
        for sphere in 0..positions.len() {
            let cell = column.cell(column.coordinates(column.positions[sphere]));
            column.next[sphere] = column.heads[cell];
            column.heads[cell] = sphere;
        }
        column
    }

    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    fn coordinates(&self, [x, y, z]: [f64; 3]) -> [usize; 3] {
        let [nx, nw] = self.cells;
        [
            ((x / self.height * nx as f64) as usize).min(nx - 1),
            ((y / self.width * nw as f64) as usize).min(nw - 1),
            ((z / self.width * nw as f64) as usize).min(nw - 1),
        ]
    }

    fn cell(&self, [x, y, z]: [usize; 3]) -> usize {
        (x * self.cells[1] + y) * self.cells[1] + z
    }

    fn overlaps(&self, sphere: usize, position: [f64; 3]) -> bool {
        let [nx, nw] = self.cells;
        let [x, y, z] = self.coordinates(position);
        for i in x.saturating_sub(1)..=(x + 1).min(nx - 1) {
            for j in [(y + nw - 1) % nw, y, (y + 1) % nw] {
                for k in [(z + nw - 1) % nw, z, (z + 1) % nw] {
                    let mut other = self.heads[self.cell([i, j, k])];
                    while other != NONE {
                        if other != sphere {
                            let dx = position[0] - self.positions[other][0];
                            let mut dy = (position[1] - self.positions[other][1]).abs();
                            let mut dz = (position[2] - self.positions[other][2]).abs();
                            dy = dy.min(self.width - dy);
                            dz = dz.min(self.width - dz);
                            if dx * dx + dy * dy + dz * dz < 1.0 {
                                return true;
                            }
                        }
                        other = self.next[other];
                    }
                }
            }
        }
        false
    }

    /// Centers of the spheres.
    pub fn positions(&self) -> &[[f64; 3]] {
        &self.positions
    }

    /// Makes as many trials as there are spheres.
    pub fn sweep(&mut self) {
        for _ in 0..self.positions.len() {
            let sphere = self.generator.random_range(0..self.positions.len());
            let old = self.positions[sphere];
            let mut trial = old;
            for coordinate in &mut trial {
                *coordinate += self.displacement * (2.0 * self.generator.random::<f64>() - 1.0);
            }
            if trial[0] < 0.5 || trial[0] > self.height - 0.5 {
                continue;
            }
            trial[1] = trial[1].rem_euclid(self.width);
            trial[2] = trial[2].rem_euclid(self.width);
            let rise = (trial[0] - old[0]) / self.temperature;
            if rise > 0.0 && self.generator.random::<f64>() >= libm::exp(-rise) {
                continue;
            }
            if self.overlaps(sphere, trial) {
                continue;
            }
            let (from, to) = (self.cell(self.coordinates(old)), self.cell(self.coordinates(trial)));
            if from != to {
                let mut link = self.heads[from];
                if link == sphere {
                    self.heads[from] = self.next[sphere];
                } else {
                    while self.next[link] != sphere {
                        link = self.next[link];
                    }
                    self.next[link] = self.next[sphere];
                }
                self.next[sphere] = self.heads[to];
                self.heads[to] = sphere;
            }
            self.positions[sphere] = trial;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_sphere_has_the_height_of_the_barometer() {
        let (height, temperature) = (30.0, 1.5);
        let start = Vector3::new(2.0, 1.0, 1.0);
        let mut column = PlainColumn::new(height, 4.0, temperature, 1.5, &[start], 1);
        let sweeps = 400_000;
        let sum: f64 = (0..sweeps)
            .map(|_| {
                column.sweep();
                column.positions()[0][0]
            })
            .sum();
        // Error of the mean: T sqrt(2 τ/sweeps) with τ of some twenty sweeps.
        let error = temperature * (2.0 * 20.0 / f64::from(sweeps)).sqrt();
        let mean = sum / f64::from(sweeps);
        assert!((mean - 0.5 - temperature).abs() < 4.0 * error, "{mean}, {error}");
    }

    #[test]
    fn spheres_never_overlap() {
        let positions: Vec<Vector3<f64>> = (0..27_u32)
            .map(|index| {
                let at = |digit: u32| 0.6 + 1.3 * f64::from(digit % 3);
                Vector3::new(at(index), at(index / 3), at(index / 9))
            })
            .collect();
        let mut column = PlainColumn::new(8.0, 4.0, 1.0, 0.4, &positions, 2);
        (0..500).for_each(|_| column.sweep());
        for (index, one) in column.positions().iter().enumerate() {
            for other in &column.positions()[..index] {
                let across = |axis: usize| {
                    let distance = (one[axis] - other[axis]).abs();
                    distance.min(4.0 - distance)
                };
                let square: f64 =
                    [one[0] - other[0], across(1), across(2)].map(|part| part * part).iter().sum();
                assert!(square >= 1.0, "{square}");
            }
        }
    }
}
