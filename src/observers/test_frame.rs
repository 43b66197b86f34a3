//! Frames for tests.

use crate::centers::Centers;
use crate::field::UniformField;
use crate::frame::{Frame, MoveCounts, Phase, Still};
use crate::temperature::Isothermal;
use crate::{Field, Slab, TemperatureProfile};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::cell::Cell;

/// A scene with spheres at given positions.
pub(super) struct Scene {
    pub(super) slab: Slab,
    pub(super) field: Box<dyn Field>,
    pub(super) temperature: Box<dyn TemperatureProfile>,
    pub(super) positions: Vec<[f64; 3]>,
    /// Number of the sweep of the next frame.
    pub(super) sweep: Cell<u64>,
    pub(super) move_counts: MoveCounts,
}

impl Scene {
    /// Uniform field, temperature 5, base area 5 x 5.
    pub(super) fn new(height: f64, heights: &[f64]) -> Self {
        let mut scene = Self {
            slab: Slab::new(height, 5.0, 5.0).unwrap(),
            field: Box::new(UniformField::default()),
            temperature: Box::new(Isothermal::new(5.0).unwrap()),
            positions: Vec::new(),
            sweep: Cell::new(0),
            move_counts: MoveCounts::default(),
        };
        scene.place(heights);
        scene
    }

    pub(super) fn place(&mut self, heights: &[f64]) {
        self.positions = heights.iter().map(|&height| [height, 1.0, 2.0]).collect();
    }

    /// The frame of the next sweep.
    pub(super) fn frame(&self) -> Frame<'_> {
        let sweep = self.sweep.get();
        self.sweep.set(sweep + 1);
        Frame {
            scene: crate::Scene::unchecked(self.slab, self.positions.len(), &*self.field, &*self.temperature),
            potential: &Still(0),
            centers: Centers::listed(&self.positions),
            sweep,
            phase: Phase::Production,
            sweep_of_phase: sweep,
            move_counts: &self.move_counts,
        }
    }
}

/// Heights of ideal particles at the temperature 5 in the uniform field, over the wall at 0.5.
pub(super) fn ideal_heights(particles: usize, seed: u64) -> Vec<f64> {
    let mut generator = Pcg64Mcg::seed_from_u64(seed);
    (0..particles).map(|_| 0.5 - 5.0 * (1.0 - generator.random::<f64>()).ln()).collect()
}

/// A perfect hexagonal layer at height 0.5, of `cells` by `cells` rectangles of two spheres whose
/// short side is `spacing`; the spacing is returned as well.
pub(super) fn hexagonal_layer(cells: u32, spacing: f64) -> (Scene, f64) {
    let row = spacing * 3.0_f64.sqrt();
    let mut scene = Scene::new(10.0, &[]);
    scene.slab = Slab::new(10.0, f64::from(cells) * spacing, f64::from(cells) * row).unwrap();
    for (column, line) in (0..cells).flat_map(|column| (0..cells).map(move |line| (column, line))) {
        let corner = [f64::from(column) * spacing, f64::from(line) * row];
        scene.positions.push([0.5, corner[0], corner[1]]);
        scene.positions.push([0.5, corner[0] + 0.5 * spacing, corner[1] + 0.5 * row]);
    }
    (scene, spacing)
}
