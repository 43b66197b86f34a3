//! What was fitted to `examples/paper/calibration/`, as `cargo run --release -p paper --bin
//! calibrate_models -- --fit` prints it; a test in `examples/paper/tests/model_for.rs` fits again
//! and compares.

/// How the noise of a plan depends on the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Logarithm of the variance in units of that of as many independent spheres, and its slopes
    /// with the largest packing fraction, the logarithm of the extent, and T that varies.
    pub inefficiency: [f64; 4],
    /// Sweeps that the theory start counts for.
    pub head_start: f64,
    /// Root mean square of ln(measured/expected) over the calibration.
    pub scatter: f64,
    /// Standard deviation of the noise of single seeds, in units of its root mean square.
    pub seeds: f64,
}

/// Coefficients of B(η)/η², a polynomial in η.
pub const LAYERS: [f64; 4] = [0.41778, -7.739, 19.713, -13.224];

/// What that misses of B/η².
pub const LAYERS_SCATTER: f64 = 2.0837e-2;

/// Which part of ∫ |Δn| is in the first, second ... diameter from a wall, and with which sign.
pub const LAYERS_SHAPE: [f64; 8] =
    [0.52555, -0.36634, -6.4815e-2, -2.4044e-2, -1.2062e-2, -6.8998e-3, 8.5389e-5, -2.0728e-4];

/// What a density functional's layers miss, in spheres per area of a wall: of η⁶, and of η² in
/// quadrature, which is what columns do not resolve.
pub const FUNCTIONAL: [f64; 2] = [1.4014, 9.3316e-3];

/// The same of the functional as [`LAYERS_SHAPE`] of the theory.
pub const FUNCTIONAL_SHAPE: [f64; 8] =
    [-0.46923, 0.2703, 0.12266, 2.0266e-2, 4.6898e-4, -4.5632e-2, 4.5049e-2, 2.64e-2];

/// Factor by which the functional may be worse than expected in n.
pub const FUNCTIONAL_ALLOWANCE: f64 = 1.5667;

/// Part of what excluded volume does to a profile that the theory misses beyond the layers.
pub const BULK: f64 = 1.4692e-3;

/// Factor by which ideal gas or theory may be worse than expected, for n, P and Z.
pub const ALLOWANCE: [f64; 3] = [1.1098, 2.4895, 1.134];

/// Part of what excluded volume does to a profile that is missing over a base with one sphere.
pub const FINITE_BASE: f64 = 0.55073;

/// Trials and events per sphere and sweep, and their slope with the largest packing fraction, for
/// tuned local moves and event chains with them.
pub const MOVES: [[f64; 2]; 2] = [[1.0, 0.0], [0.87148, 3.2315]];

/// For n, P and Z, and for tuned local moves and event chains with them.
pub const NOISE: [[Noise; 2]; 3] = [
    [
        Noise {
            inefficiency: [1.9369, 3.1727, -0.16486, -0.12897],
            head_start: 15.0,
            scatter: 0.15916,
            seeds: 0.27588,
        },
        Noise {
            inefficiency: [1.7553, -0.40159, -4.3034e-2, -3.5285e-2],
            head_start: 4.0,
            scatter: 0.10879,
            seeds: 0.23661,
        },
    ],
    [
        Noise {
            inefficiency: [2.1389, 2.7429, 0.19422, -0.18906],
            head_start: 74.0,
            scatter: 0.30685,
            seeds: 0.5196,
        },
        Noise {
            inefficiency: [1.7612, 0.2151, 0.38609, -4.4391e-2],
            head_start: 26.0,
            scatter: 0.29003,
            seeds: 0.50171,
        },
    ],
    [
        Noise {
            inefficiency: [2.0931, 2.2568, -0.15081, -0.11037],
            head_start: 0.0,
            scatter: 0.44055,
            seeds: 0.3011,
        },
        Noise {
            inefficiency: [1.6756, 0.20207, 2.1e-2, -7.4459e-2],
            head_start: 0.0,
            scatter: 0.29018,
            seeds: 0.30726,
        },
    ],
];
