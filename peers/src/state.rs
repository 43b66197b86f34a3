//! What both engines are given.

use crate::hoomd::{Grid, Settings};

/// Equal hard spheres of diameter 1 between walls along x, periodic along y and z.
#[derive(Debug, Clone, Copy)]
pub(crate) struct State {
    pub(crate) name: &'static str,
    pub(crate) particles: usize,
    /// Distance of the walls and the two periodic widths.
    pub(crate) size: [f64; 3],
    pub(crate) gravity: f64,
    pub(crate) temperature: f64,
    /// S of trials uniform in (−S, S)³.
    pub(crate) maximum_displacement: f64,
    /// What is fastest for hoomd-mc here: `--tune` shows it.
    pub(crate) hoomd: Settings,
}

const PARTICLES: usize = 25_000;

/// Height that gives a number density to a slab with a square base.
const fn height(number_density: f64, width: f64) -> f64 {
    PARTICLES as f64 / (number_density * width * width)
}

/// The homogeneous boxes are nearly cubes, and as wide as hoomd-mc's `VecCell` likes them: it keeps a
/// cube of 2ᵏ⁺¹ + 1 cells along each side, so that 30 (and a ghost at each side) needs 33³ cells.
pub(crate) const STATES: [State; 3] = [
    State {
        name: "dense: packing fraction 0.45, S = 0.12",
        particles: PARTICLES,
        size: [height(0.45 * 6.0 / std::f64::consts::PI, 30.0), 30.0, 30.0],
        gravity: 0.0,
        temperature: 20.0,
        maximum_displacement: 0.12,
        hoomd: Settings { grid: Grid::Dense, cell_width: 1.0, checkerboard_width: 3.0 },
    },
    State {
        name: "dilute: n = 0.1, S = 0.75",
        particles: PARTICLES,
        size: [height(0.1, 62.0), 62.0, 62.0],
        gravity: 0.0,
        temperature: 20.0,
        maximum_displacement: 0.75,
        hoomd: Settings { grid: Grid::Dense, cell_width: 1.6, checkerboard_width: 8.0 },
    },
    State {
        name: "column: 400 x 25 x 25, T = 20, uniform field, S = 0.75",
        particles: PARTICLES,
        size: [400.0, 25.0, 25.0],
        gravity: 1.0,
        temperature: 20.0,
        maximum_displacement: 0.75,
        hoomd: Settings { grid: Grid::Dense, cell_width: 2.0, checkerboard_width: 8.0 },
    },
];
