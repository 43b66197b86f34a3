//! Constants fitted to the runs in `examples/paper/calibration/`, as `cargo run --release -p paper
//! --bin calibrate_models -- --fit` prints them. A test in `examples/paper/tests/model_for.rs`
//! repeats the fit and compares.

/// How the noise of a plan depends on the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Logarithm of the variance relative to that of as many independent spheres: constant, slopes
    /// with the largest packing fraction and with the logarithm of the extent, and the term if T
    /// varies.
    pub inefficiency: [f64; 4],
    /// Number of sweeps that the start at the theory profile is worth.
    pub head_start: f64,
    /// Root mean square of ln(measured/expected) over the calibration.
    pub scatter: f64,
    /// Standard deviation of the noise of single seeds, in units of its root mean square.
    pub seeds: f64,
}

/// Coefficients of B(η)/η², a polynomial in η.
pub const LAYERS: [f64; 4] = [0.41778, -7.9298, 20.537, -14.15];

/// Scatter of B/η² about this fit.
pub const LAYERS_SCATTER: f64 = 2.1588e-2;

/// Shares of ∫ |Δn| in the first, second, ... diameter from a wall, with sign.
pub const LAYERS_SHAPE: [f64; 8] =
    [0.5207, -0.3684, -7.0149e-2, -2.3931e-2, -1.1374e-2, -3.9485e-3, -1.2747e-3, -2.2024e-4];

/// Error of the layers of a density functional, in spheres per area of a wall: the coefficient of
/// η⁶ and, in quadrature, that of η², which is below the resolution of the runs.
pub const FUNCTIONAL: [f64; 2] = [1.5379, 5.5565e-3];

/// As [`LAYERS_SHAPE`], for the functional.
pub const FUNCTIONAL_SHAPE: [f64; 8] =
    [-0.45547, 0.31363, 4.2897e-2, -0.12821, -5.5651e-2, -1.215e-3, 2.7718e-3, 1.4394e-4];

/// Factor by which the functional may be worse than expected, for n, P and Z.
pub const FUNCTIONAL_ALLOWANCE: [f64; 3] = [2.3073, 2.0366, 2.5409];

/// Shift of the column above the layers in the theory, in diameters, over η at the wall.
pub const ADSORPTION: f64 = 6.2029e-2;

/// The same in a density functional: the coefficient of η⁶ and, in quadrature, that of η, which is
/// below the resolution of the runs.
pub const FUNCTIONAL_ADSORPTION: [f64; 2] = [1.9677, 7.7199e-3];

/// Error of the theory beyond the layers, as a share of the effect of excluded volume.
pub const BULK: f64 = 8.7687e-4;

/// Factor by which ideal gas or theory may be worse than expected, for n, P and Z.
pub const ALLOWANCE: [f64; 3] = [1.1338, 1.1822, 1.2233];

/// Error by a base with one sphere, as a share of the effect of excluded volume.
pub const FINITE_BASE: f64 = 0.47875;

/// Trials and events per sphere and sweep, and their slope with the largest packing fraction: for
/// tuned local moves, and for event chains with tuned local moves.
pub const MOVES: [[f64; 2]; 2] = [[1.0, 0.0], [0.8548, 5.8666]];

/// Noise of n, P and Z, each for tuned local moves and for event chains with tuned local moves.
pub const NOISE: [[Noise; 2]; 3] = [
    [
        Noise {
            inefficiency: [1.9431, 3.1961, -0.17118, -0.12256],
            head_start: 15.0,
            scatter: 0.15662,
            seeds: 0.27353,
        },
        Noise {
            inefficiency: [1.7279, -0.64122, -4.9122e-2, -0.10576],
            head_start: 2.0,
            scatter: 0.12538,
            seeds: 0.25684,
        },
    ],
    [
        Noise {
            inefficiency: [2.2202, 2.6207, 0.17543, -0.15236],
            head_start: 72.0,
            scatter: 0.30933,
            seeds: 0.51393,
        },
        Noise {
            inefficiency: [1.6177, 0.16772, 0.32164, -2.8183e-2],
            head_start: 13.0,
            scatter: 0.26706,
            seeds: 0.49446,
        },
    ],
    [
        Noise {
            inefficiency: [2.2244, 2.1391, -0.18351, -0.10373],
            head_start: 0.0,
            scatter: 0.44327,
            seeds: 0.29158,
        },
        Noise {
            inefficiency: [1.7111, -0.40887, 8.0514e-3, -6.2352e-2],
            head_start: 0.0,
            scatter: 0.23462,
            seeds: 0.28713,
        },
    ],
];
