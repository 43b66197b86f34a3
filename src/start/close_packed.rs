//! Close-packed lattices that fit the slab, and the close-packed start.

use super::Start;
use crate::configuration::wrap;
use crate::random::{index, symmetric};
use crate::{AnyScene, Error, Generator, Slab};
use nalgebra::Vector3;
use std::collections::HashMap;

/// A close-packed crystal that stands on the base, filled from below; the top layer has random
/// vacancies. It is far below the steady state, while [`RandomInsertion`](super::RandomInsertion)
/// is above it.
///
/// ```
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, start::ClosePacked, temperature::Isothermal};
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 360, UniformField::default(), Isothermal::new(5.0)?)?;
/// let simulation = Simulation::builder(scene).start(ClosePacked).build()?;
/// let highest = simulation.frame().heights().fold(0.0, f64::max);
/// assert!(highest < 12.0);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ClosePacked;

impl Start for ClosePacked {
    /// # Errors
    /// [`Error::LatticeFull`] when the lattice that fits the slab has too few sites.
    fn place(&self, scene: &AnyScene<'_>, generator: &mut Generator) -> Result<Vec<Vector3<f64>>, Error> {
        let lattice = Lattice::densest(scene.slab());
        lattice.fill(scene, generator, |layer| if layer == 0 { scene.particles() } else { 0 })
    }
}

/// Gap between adjacent spheres. Without gaps event chains could not advance.
const GAP: f64 = 1e-3;
/// Largest random displacement of a sphere from its site along each axis. In a perfect lattice,
/// chains would close the gaps until rings of touching spheres fit the width exactly and jam. Two
/// neighbors use at most 2·√3/4 of the gap.
const JITTER: f64 = 0.25 * GAP;

/// Layers of a two-dimensional lattice, every other layer shifted over the hollows of the one
/// below.
///
/// Sites are not stored, but computed when they are used.
#[derive(Debug, Clone)]
pub(super) struct Lattice {
    /// Rows of a layer, and sites in a row.
    rows: usize,
    in_row: usize,
    /// Distance of sites along a row, and from row to row.
    step: [f64; 2],
    /// Shift of every other row, in steps along the row.
    row_shift: f64,
    /// Whether rows lie along z.
    swap: bool,
    /// Shift of odd layers, along y and z.
    shift: [f64; 2],
    spacing: f64,
    layers: usize,
}

impl Lattice {
    /// The densest of the lattices that fit the periodic widths of `slab`: square or triangular
    /// layers, rows along y or z, stretched to fit.
    pub(super) fn densest(slab: &Slab) -> Self {
        let widths = slab.widths();
        let square = Self::of_rows(slab, widths, 1.0, 0.0, false);
        let triangular_y = Self::of_rows(slab, widths, 0.75f64.sqrt(), 0.5, false);
        let triangular_z = Self::of_rows(slab, [widths[1], widths[0]], 0.75f64.sqrt(), 0.5, true);
        let mut best = square;
        for candidate in [triangular_y, triangular_z] {
            if candidate.capacity() > best.capacity() {
                best = candidate;
            }
        }
        best
    }

    /// Rows of spheres along the first width, at least `row_distance` apart, with every other row
    /// shifted by `row_shift` of the spacing in the row. `swap` exchanges y and z at the end.
    fn of_rows(slab: &Slab, widths: [f64; 2], row_distance: f64, row_shift: f64, swap: bool) -> Self {
        let count = |width: f64, spacing: f64| {
            // Widths are between 3 and 1e6.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let count = (width / (spacing * (1.0 + GAP))) as usize;
            count
        };
        let in_row = count(widths[0], 1.0);
        let rows = count(widths[1], row_distance);
        // Shifted rows come in pairs.
        let rows = if row_shift > 0.0 { rows / 2 * 2 } else { rows };
        let step = [widths[0] / in_row as f64, widths[1] / rows as f64];
        // Above the middle of a square, or the point with equal distances to the corners of a
        // triangle.
        let shift = if row_shift > 0.0 {
            let [a, h] = step;
            [0.5 * a, (h * h - 0.25 * a * a) / (2.0 * h)]
        } else {
            [0.5 * step[0], 0.5 * step[1]]
        };
        let mut lattice = Self { rows, in_row, step, row_shift, swap: false, shift, spacing: 1.0, layers: 1 };
        // The shift leads into the first cell, so the nearest sites are in the first or, by
        // periodicity, the last rows and columns.
        let near = |count: usize| [0, 1, 2, count - 1].into_iter().filter(move |&index| index < count);
        let nearest = near(rows)
            .flat_map(|row| near(in_row).map(move |column| row * in_row + column))
            .map(|site| {
                let site = lattice.site(site);
                let along = |axis: usize| {
                    let distance = (site[axis] - shift[axis]).abs();
                    distance.min(widths[axis] - distance)
                };
                along(0) * along(0) + along(1) * along(1)
            })
            .fold(f64::INFINITY, f64::min);
        // A layer must clear the one below, and the second one below, whose sites it repeats.
        lattice.spacing = (1.0 - nearest).max(0.25).sqrt() * (1.0 + GAP) + GAP;
        lattice.stretch(1.0, slab);
        if swap {
            lattice.swap = true;
            lattice.shift.swap(0, 1);
        }
        lattice
    }

    /// A site of an even layer, as y and z.
    fn site(&self, index: usize) -> [f64; 2] {
        let (row, column) = (index / self.in_row, index % self.in_row);
        let offset = if row % 2 == 1 { self.row_shift } else { 0.0 };
        let [a, b] = [(column as f64 + offset) * self.step[0], row as f64 * self.step[1]];
        if self.swap { [b, a] } else { [a, b] }
    }

    /// Number of sites of a layer.
    fn per_layer(&self) -> usize {
        self.rows * self.in_row
    }

    /// Number of sites.
    pub(super) fn capacity(&self) -> usize {
        self.per_layer() * self.layers
    }

    /// Sites per volume far from the walls.
    pub(super) fn number_density(&self, slab: &Slab) -> f64 {
        self.per_layer() as f64 / (slab.base_area() * self.spacing)
    }

    /// Moves the layers apart by `factor` ≥ 1.
    pub(super) fn stretch(&mut self, factor: f64, slab: &Slab) {
        self.spacing *= factor;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let layers = ((slab.highest_center() - slab.lowest_center()) / self.spacing) as usize + 1;
        self.layers = layers;
    }

    pub(super) fn spacing(&self) -> f64 {
        self.spacing
    }

    /// Number of layers, at least one.
    pub(super) fn layers(&self) -> usize {
        self.layers
    }

    /// Puts `wanted(layer)` spheres on random sites of each layer. Spheres that do not fit go to
    /// the next layer; those left after the last layer fill vacancies from the top down.
    pub(super) fn fill(
        &self,
        scene: &AnyScene<'_>,
        generator: &mut Generator,
        wanted: impl Fn(usize) -> usize,
    ) -> Result<Vec<Vector3<f64>>, Error> {
        let (slab, particles) = (scene.slab(), scene.particles());
        if particles > self.capacity() {
            return Err(Error::LatticeFull { sites: self.capacity(), particles });
        }
        let per_layer = self.per_layer();
        let mut occupied = vec![0; self.layers];
        let mut waiting = 0;
        for (layer, count) in occupied.iter_mut().enumerate() {
            waiting += wanted(layer);
            *count = waiting.min(per_layer);
            waiting -= *count;
        }
        for count in occupied.iter_mut().rev() {
            let added = waiting.min(per_layer - *count);
            *count += added;
            waiting -= added;
        }
        // A permutation of the sites of a layer, of which only changed entries are stored.
        let mut order: HashMap<usize, usize> = HashMap::new();
        let mut chosen_sites = Vec::new();
        let mut positions = Vec::with_capacity(particles);
        for (layer, &count) in occupied.iter().enumerate() {
            // The first `count` entries of a Fisher-Yates shuffle.
            chosen_sites.clear();
            for chosen in 0..count {
                let other = chosen + index(generator, per_layer - chosen);
                let [first, second] = [chosen, other].map(|place| *order.get(&place).unwrap_or(&place));
                order.insert(chosen, second);
                order.insert(other, if other == chosen { second } else { first });
                chosen_sites.push(second);
            }
            let height = slab.lowest_center() + layer as f64 * self.spacing;
            for &site in &chosen_sites {
                let site = self.site(site);
                let along = |axis: usize, jitter: f64| {
                    let shift = if layer % 2 == 1 { self.shift[axis] } else { 0.0 };
                    wrap((site[axis] + shift) % slab.widths()[axis] + jitter, slab.widths()[axis])
                };
                let [x, y, z] = [0; 3].map(|_| JITTER * symmetric(generator));
                // The clamp keeps spheres next to the base or the lid inside.
                let height = (height + x).clamp(slab.lowest_center(), slab.highest_center());
                positions.push(Vector3::new(height, along(0, y), along(1, z)));
            }
        }
        Ok(positions)
    }
}
