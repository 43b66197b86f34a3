//! Search for neighbors.

use crate::{Error, Slab};
use nalgebra::Vector3;

/// Finds the neighbors of spheres within a radius, for observers of structure.
///
/// Spheres are sorted into cells about as wide as the search radius, so finding all neighbors takes
/// a time proportional to the number of spheres. Distances are to the nearest periodic image in y
/// and z, and positions may be any periodic images. Nothing is computed before
/// [`gather`](Self::gather) is called. Buffers are reused.
///
/// ```
/// use gradient_mc::observers::Neighbors;
/// use gradient_mc::{Frame, Observer, ObserverError};
/// /// The largest number of spheres that any sphere had within 1.2 diameters.
/// struct MostNeighbors(Neighbors, usize);
/// impl Observer for MostNeighbors {
///     fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
///         self.0.gather(frame.positions());
///         let most = (0..self.0.count()).map(|sphere| self.0.of(sphere).count()).max();
///         self.1 = self.1.max(most.unwrap_or(0));
///         Ok(())
///     }
/// }
/// # use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// let slab = Slab::new(60.0, 6.0, 6.0)?;
/// let mut most = MostNeighbors(Neighbors::new(&slab, 1.2)?, 0);
/// # let scene = Scene::new(slab, 72, UniformField::default(), Isothermal::new(5.0)?)?;
/// # Simulation::builder(scene).build()?.run(4, &mut most)?;
/// # assert!(most.1 > 0);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Neighbors {
    slab: Slab,
    radius: f64,
    positions: Vec<[f64; 3]>,
    /// Lowest height; below, cells per diameter along each axis.
    lowest: f64,
    per_diameter: [f64; 3],
    cells: [usize; 3],
    /// Index in `sorted` of the first sphere of each cell.
    starts: Vec<usize>,
    /// Positions and indices of the spheres, sorted by cell.
    sorted: Vec<([f64; 3], usize)>,
}

/// A neighbor of a sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Neighbor {
    /// Its index among the positions passed to [`Neighbors::gather`].
    pub index: usize,
    /// Vector from the center of the sphere to the nearest image of this neighbor, in diameters.
    pub separation: Vector3<f64>,
}

impl Neighbors {
    /// Makes a search for spheres whose centers are at most `radius` apart, in diameters.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] if the radius is not positive, or above half the smaller width
    /// of the slab, where two images of a sphere could be neighbors.
    pub fn new(slab: &Slab, radius: f64) -> Result<Self, Error> {
        Error::require_positive("search radius", radius)?;
        if radius > half_width(slab) {
            let requirement = "it must be at most half the smaller width of the slab";
            return Err(Error::InvalidParameter { name: "search radius", value: radius, requirement });
        }
        Ok(Self::unchecked(slab, radius))
    }

    /// A search with a radius that is valid for any slab.
    pub(super) fn unchecked(slab: &Slab, radius: f64) -> Self {
        Self {
            slab: *slab,
            radius,
            positions: Vec::new(),
            lowest: 0.0,
            per_diameter: [1.0; 3],
            cells: [1; 3],
            starts: Vec::new(),
            sorted: Vec::new(),
        }
    }

    /// The search radius, in diameters.
    #[must_use]
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Number of positions.
    #[must_use]
    pub fn count(&self) -> usize {
        self.positions.len()
    }

    /// Sets the positions to search in, and replaces earlier ones: all spheres of a frame, or those
    /// of a layer. Set all heights to the same value to search in the plane.
    pub fn gather(&mut self, positions: impl IntoIterator<Item = Vector3<f64>>) {
        self.positions.clear();
        self.positions.extend(positions.into_iter().map(<[f64; 3]>::from));
        self.divide();
        // Counting sort: sizes of the cells, then their ends, which become starts when the cells
        // are filled from behind.
        self.starts.clear();
        self.starts.resize(self.cells.iter().product::<usize>() + 1, 0);
        for position in &self.positions {
            let cell = self.cell(position);
            self.starts[cell] += 1;
        }
        let mut end = 0;
        for start in &mut self.starts {
            end += *start;
            *start = end;
        }
        self.sorted.clear();
        self.sorted.resize(self.positions.len(), ([0.0; 3], 0));
        for (index, &position) in self.positions.iter().enumerate().rev() {
            let cell = self.cell(&position);
            self.starts[cell] -= 1;
            self.sorted[self.starts[cell]] = (position, index);
        }
    }

    /// Chooses cells at least as wide as the radius, and not many more cells than spheres.
    fn divide(&mut self) {
        let heights = || self.positions.iter().map(|position| position[0]);
        self.lowest = heights().fold(f64::INFINITY, f64::min);
        let extent = (heights().fold(self.lowest, f64::max) - self.lowest).max(0.0);
        let extents = [extent, self.slab.widths()[0], self.slab.widths()[1]];
        let most = 4 * self.positions.len() + 64;
        // More cells than this along one axis are too many.
        let mut side = extents.iter().fold(self.radius, |side, &extent| side.max(extent / most as f64));
        loop {
            // Not negative; a product beyond the range of integers saturates.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let cells = extents.map(|extent| ((extent / side) as usize).max(1));
            if cells.iter().fold(1_usize, |product, &count| product.saturating_mul(count)) <= most {
                self.cells = cells;
                break;
            }
            side *= 1.25;
        }
        for (axis, extent) in extents.into_iter().enumerate() {
            self.per_diameter[axis] = if extent > 0.0 { self.cells[axis] as f64 / extent } else { 0.0 };
        }
    }

    fn along(&self, position: &[f64; 3], axis: usize) -> usize {
        let place = if axis == 0 {
            position[0] - self.lowest
        } else {
            // For any image. Rounding may give the width itself, which is in the last cell.
            position[axis].rem_euclid(self.slab.widths()[axis - 1])
        };
        // Positions far outside the slab may be below zero; they are put in the first cell.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let cell = (place * self.per_diameter[axis]) as usize;
        cell.min(self.cells[axis] - 1)
    }

    fn cell(&self, position: &[f64; 3]) -> usize {
        let [x, y, z] = [0, 1, 2].map(|axis| self.along(position, axis));
        (x * self.cells[1] + y) * self.cells[2] + z
    }

    /// The neighbors of a sphere, without itself, in an order that depends on the positions only.
    /// An index of [`count`](Self::count) or more has no neighbors.
    pub fn of(&self, sphere: usize) -> impl Iterator<Item = Neighbor> + '_ {
        let center = self.positions.get(sphere).copied();
        let squared_radius = self.radius * self.radius;
        center.into_iter().flat_map(move |center| {
            self.around(center).filter_map(move |&(position, index)| {
                let separation = self.separation(&center, &position);
                (index != sphere && separation.norm_squared() <= squared_radius)
                    .then_some(Neighbor { index, separation })
            })
        })
    }

    /// The spheres in the cell of a position and in the cells next to it.
    fn around(&self, center: [f64; 3]) -> impl Iterator<Item = &([f64; 3], usize)> + '_ {
        let [x, y, z] = [0, 1, 2].map(|axis| self.along(&center, axis));
        let layers = x.saturating_sub(1)..(x + 2).min(self.cells[0]);
        layers.flat_map(move |x| {
            adjacent(y, self.cells[1]).flat_map(move |y| {
                adjacent(z, self.cells[2]).flat_map(move |z| {
                    let cell = (x * self.cells[1] + y) * self.cells[2] + z;
                    &self.sorted[self.starts[cell]..self.starts[cell + 1]]
                })
            })
        })
    }

    fn separation(&self, from: &[f64; 3], to: &[f64; 3]) -> Vector3<f64> {
        let across = |axis: usize| {
            let (width, difference) = (self.slab.widths()[axis - 1], to[axis] - from[axis]);
            difference - width * (difference / width).round()
        };
        Vector3::new(to[0] - from[0], across(1), across(2))
    }
}

/// Half the smaller periodic width of a slab.
pub(super) fn half_width(slab: &Slab) -> f64 {
    0.5 * slab.widths()[0].min(slab.widths()[1])
}

/// A cell of a periodic row and those next to it, each once, also in a short row.
fn adjacent(cell: usize, count: usize) -> impl Iterator<Item = usize> {
    (0..count.min(3)).map(move |offset| (cell + count + offset - 1) % count)
}

persist!(Neighbors { same slab, same radius });

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    /// Compared with a search over all pairs, in slabs of one, two and many cells across, with few
    /// and many spheres.
    #[test]
    fn all_pairs_within_the_radius_are_found_once() {
        let mut generator = Pcg64Mcg::seed_from_u64(3);
        for (widths, radius, spheres) in [
            ([3.0, 3.0], 1.5, 30),
            ([3.0, 7.0], 1.2, 100),
            ([8.0, 5.0], 2.5, 200),
            ([20.0, 30.0], 1.2, 40),
            ([9.0, 9.0], 1e-3, 100),
            ([9.0, 9.0], 1.5, 1),
            ([9.0, 9.0], 1.5, 0),
        ] {
            let slab = Slab::new(30.0, widths[0], widths[1]).unwrap();
            for height in [20.0, 0.0] {
                let mut along = |extent: f64| extent * generator.random::<f64>();
                let positions: Vec<Vector3<f64>> = (0..spheres)
                    .map(|_| Vector3::new(0.5 + along(height), along(widths[0]), along(widths[1])))
                    .collect();
                let mut neighbors = Neighbors::new(&slab, radius).unwrap();
                // Earlier positions must be replaced.
                neighbors.gather([Vector3::new(1.0, 1.0, 1.0), Vector3::new(1.0, 1.0, 1.0)]);
                // Positions may be any periodic image.
                let image = |(sphere, position): (usize, &Vector3<f64>)| {
                    let periods = [sphere % 5, sphere / 5 % 5].map(|period| period as f64 - 2.0);
                    position + Vector3::new(0.0, periods[0] * widths[0], periods[1] * widths[1])
                };
                neighbors.gather(positions.iter().enumerate().map(image));
                assert_eq!(neighbors.count(), spheres);
                for (sphere, center) in positions.iter().enumerate() {
                    let expected: Vec<usize> = (0..spheres)
                        .filter(|&other| {
                            let mut separation = positions[other] - center;
                            for axis in 0..2 {
                                let difference = separation[axis + 1].abs();
                                separation[axis + 1] = difference.min(widths[axis] - difference);
                            }
                            other != sphere && separation.norm() <= radius
                        })
                        .collect();
                    let mut found: Vec<usize> = neighbors
                        .of(sphere)
                        .map(|neighbor| {
                            let mut end = center + neighbor.separation - positions[neighbor.index];
                            for axis in 0..2 {
                                end[axis + 1] -= widths[axis] * (end[axis + 1] / widths[axis]).round();
                            }
                            assert!(end.norm() < 1e-12 && neighbor.separation.norm() <= radius);
                            neighbor.index
                        })
                        .collect();
                    found.sort_unstable();
                    assert_eq!(found, expected);
                }
                assert_eq!(neighbors.of(spheres).count(), 0);
            }
        }
    }

    #[test]
    fn senseless_radii_are_refused() {
        let slab = Slab::new(30.0, 4.0, 6.0).unwrap();
        assert!(Neighbors::new(&slab, 2.0).is_ok());
        for radius in [2.1, 0.0, -1.0, f64::NAN, f64::INFINITY] {
            let refused = Neighbors::new(&slab, radius);
            assert!(matches!(refused, Err(Error::InvalidParameter { name: "search radius", .. })));
        }
    }
}
