//! What was fitted to `examples/paper/calibration/`, as `cargo run --release -p paper --bin calibrate_models -- --fit` prints it; a
//! test in `examples/paper/tests/model_for.rs` fits again and compares.

/// How the noise of a plan depends on the scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Logarithm of the variance in units of that of as many independent spheres, and its slopes with the largest packing
    /// fraction, the logarithm of the extent, and T that varies.
    pub inefficiency: [f64; 4],
    /// Sweeps that the theory start counts for.
    pub head_start: f64,
    /// Root mean square of ln(measured/expected) over the calibration.
    pub scatter: f64,
    /// Standard deviation of the noise of single seeds, in units of its root mean square.
    pub seeds: f64,
}

/// Coefficients of B(η)/η², a polynomial in η.
pub const LAYERS: [f64; 4] = [0.41778, -7.7632, 19.836, -13.401];

/// What that misses of B/η².
pub const LAYERS_SCATTER: f64 = 0.019996;

/// Which part of ∫ |Δn| is in the first, second ... diameter from a wall, and with which sign.
pub const LAYERS_SHAPE: [f64; 8] = [0.5, -0.4, -0.1, 0.0, 0.0, 0.0, 0.0, 0.0];

/// Part of what excluded volume does to a profile that the theory misses beyond the layers.
pub const BULK: f64 = 0.0018153;

/// Factor by which ideal gas or theory may be worse than expected, for n, P and Z.
pub const ALLOWANCE: [f64; 3] = [1.1158, 1.2, 1.2];

/// Part of what excluded volume does to a profile that is missing over a base with one sphere.
pub const FINITE_BASE: f64 = 0.55105;

/// Trials and events per sphere and sweep, and their slope with the largest packing fraction, for tuned local moves and event chains
/// with them.
pub const MOVES: [[f64; 2]; 2] = [[1.0, 0.0], [1.2, 2.3]];

/// For n, P and Z, and for tuned local moves and event chains with them.
pub const NOISE: [[Noise; 2]; 3] = {
    const NONE: Noise =
        Noise { inefficiency: [1.7, 0.0, 0.0, 0.0], head_start: 3.0, scatter: 0.1, seeds: 0.3 };
    [[NONE; 2]; 3]
};
