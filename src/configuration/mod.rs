//! The spheres, and the invariants that every move keeps: no two overlap, all are inside.
//!
//! Space is cut into cells of about one diameter. All cells at one height form a [`Layer`], which
//! owns its spheres. Therefore layers far from each other can be changed at the same time, and the
//! data of a trial are close in memory. Positions in double precision decide about overlaps. A copy
//! in single precision, relative to the cell, quickly excludes most pairs ([`Probe`]).

mod grid;
mod layer;
mod overlap;
mod page;
mod reach;
#[cfg(feature = "checkpoint")]
mod saved;

pub(crate) use grid::{Grid, Site, Spot};
pub(crate) use layer::Layer;
pub(crate) use overlap::{Probe, occupied_in_reach};
pub(crate) use page::NOBODY;

use crate::{Error, Slab};
use std::sync::{Mutex, OnceLock, PoisonError};

/// Spheres in layers.
#[derive(Debug)]
pub(crate) struct Configuration {
    slab: Slab,
    grid: Grid,
    /// The first and the last layer are empty; they are beyond the walls.
    layers: Vec<Layer>,
    len: usize,
    /// Positions by number, gathered at the first request.
    positions: OnceLock<Vec<[f64; 3]>>,
    /// Their earlier memory, for reuse.
    retired: Mutex<Vec<[f64; 3]>>,
}

impl Clone for Configuration {
    fn clone(&self) -> Self {
        Self {
            slab: self.slab,
            grid: self.grid.clone(),
            layers: self.layers.clone(),
            len: self.len,
            positions: self.positions.clone(),
            retired: Mutex::default(),
        }
    }
}

impl Configuration {
    /// A configuration without spheres.
    pub(crate) fn empty(slab: Slab) -> Self {
        /// Bytes set aside, so that layers need not grow later.
        const RESERVED: usize = 1 << 26;
        let grid = Grid::new(&slab);
        let layers = grid.cells[0];
        let reserve = (RESERVED / (layers * 100)).clamp(2, most_in_a_layer(&slab, &grid));
        let all = (0..layers + 2)
            .map(|index| {
                let beyond = index == 0 || index == layers + 1;
                Layer::new(grid.table(), if beyond { 0 } else { reserve }, index)
            })
            .collect();
        Self { slab, grid, layers: all, len: 0, positions: OnceLock::new(), retired: Mutex::default() }
    }

    /// Makes a configuration from positions and checks them.
    pub(crate) fn new(slab: Slab, positions: &[[f64; 3]]) -> Result<Self, Error> {
        let mut configuration = Self::empty(slab);
        let [width_y, width_z] = slab.widths();
        let bounds =
            [('x', slab.lowest_center(), slab.highest_center()), ('y', 0.0, width_y), ('z', 0.0, width_z)];
        for (index, &position) in positions.iter().enumerate() {
            for (value, (axis, lowest, highest)) in position.into_iter().zip(bounds) {
                // A NaN fails the comparison too.
                if !(value >= lowest && value <= highest) {
                    return Err(Error::OutsideSlab { index, axis, value, lowest, highest });
                }
            }
            let position = [position[0], wrap(position[1], width_y), wrap(position[2], width_z)];
            if let Some((first, distance)) = configuration.overlapping(position) {
                return Err(Error::Overlap { first, second: index, distance });
            }
            configuration.push(position);
        }
        Ok(configuration)
    }

    /// Adds a sphere if there is room for it.
    pub(crate) fn try_push(&mut self, position: [f64; 3]) -> bool {
        let free = !self.overlaps(NOBODY, position);
        if free {
            self.push(position);
        }
        free
    }

    fn push(&mut self, position: [f64; 3]) {
        self.touch();
        let spot = self.grid.spot(position);
        let layer = spot.layer as usize + 1;
        // The scene limits the number of spheres to u32.
        #[allow(clippy::cast_possible_truncation)]
        let number = self.len as u32;
        self.layers[layer].insert(&self.grid, &self.grid.site(&spot, position), number);
        self.len += 1;
    }

    pub(crate) fn slab(&self) -> &Slab {
        &self.slab
    }

    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// Heights of the centers, in arbitrary order.
    pub(crate) fn heights(&self) -> impl Iterator<Item = f64> + '_ {
        self.layers.iter().flat_map(|layer| {
            layer.spheres.iter().filter(|sphere| sphere.number != NOBODY).map(|sphere| sphere.position[0])
        })
    }

    /// Positions in the order in which the spheres were given.
    pub(crate) fn positions(&self) -> &[[f64; 3]] {
        self.positions.get_or_init(|| {
            let mut retired = self.retired.lock().unwrap_or_else(PoisonError::into_inner);
            let mut positions = std::mem::take(&mut *retired);
            positions.resize(self.len, [0.0; 3]);
            for layer in &self.layers {
                for sphere in &layer.spheres {
                    if let Some(position) = positions.get_mut(sphere.number as usize) {
                        *position = sphere.position;
                    }
                }
            }
            positions
        })
    }

    /// Invalidates the gathered positions before spheres move.
    #[inline]
    fn touch(&mut self) {
        if let Some(positions) = self.positions.take() {
            *self.retired.get_mut().unwrap_or_else(PoisonError::into_inner) = positions;
        }
    }

    /// Grid and layers, for a sweep that moves spheres between them.
    pub(crate) fn parts_mut(&mut self) -> (&Grid, &mut [Layer]) {
        self.touch();
        (&self.grid, &mut self.layers)
    }

    /// Sorts spheres so that neighbors are close in memory, which moves disturb in large systems.
    pub(crate) fn sort(&mut self) {
        for layer in &mut self.layers {
            layer.sort(&self.grid);
        }
    }

    /// The layers before, at and after that of a spot.
    #[inline]
    fn around(&self, spot: &Spot) -> &[Layer] {
        neighbors_of(&self.layers, spot.layer as usize + 1)
    }

    /// Whether a sphere would overlap another than `ignored` at `position` (wrapped, inside).
    pub(crate) fn overlaps(&self, ignored: u32, position: [f64; 3]) -> bool {
        let spot = self.grid.spot(position);
        self.probe(&spot, position, 0, ignored).overlaps(&self.grid, self.around(&spot))
    }

    /// A probe for a sphere at a position to which it moved in the direction of `octant`.
    fn probe(&self, spot: &Spot, position: [f64; 3], octant: usize, ignored: u32) -> Probe {
        let Spot { cell, part, .. } = *spot;
        let candidates = occupied_in_reach(&self.grid, self.around(spot), cell, part, octant);
        Probe { site: self.grid.site(spot, position), ignored, candidates }
    }

    /// A sphere that overlaps one at `position`, and the distance between the two.
    fn overlapping(&self, position: [f64; 3]) -> Option<(usize, f64)> {
        if !self.overlaps(NOBODY, position) {
            return None;
        }
        let spot = self.grid.spot(position);
        for layer in self.around(&spot) {
            for neighbor in &self.grid.neighbors[9..18] {
                for index in layer.indices_in((spot.cell as usize).wrapping_add(neighbor.cell)) {
                    let sphere = &layer.spheres[index as usize];
                    let squared = self.grid.squared_distance(position, sphere.position);
                    if squared < 1.0 {
                        return Some((sphere.number as usize, squared.sqrt()));
                    }
                }
            }
        }
        None
    }
}

/// Upper bound of the number of spheres in a layer, from close packing in the layer and half a
/// diameter on both sides.
fn most_in_a_layer(slab: &Slab, grid: &Grid) -> usize {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let most = (slab.base_area() * (grid.sides[0] + 1.0) * std::f64::consts::SQRT_2) as usize;
    most
}

/// The layers before, at and after one of them.
#[inline]
pub(crate) fn neighbors_of(layers: &[Layer], layer: usize) -> &[Layer] {
    &layers[layer - 1..layer + 2]
}

/// The periodic coordinate in `[0, width)` of a `value` that is less than one width outside.
#[inline]
pub(crate) fn wrap(value: f64, width: f64) -> f64 {
    let raised = if value < 0.0 { value + width } else { value };
    // A negative number below the resolution of `width` was raised to it.
    if raised >= width { raised - width } else { raised }
}

#[cfg(test)]
mod tests;
