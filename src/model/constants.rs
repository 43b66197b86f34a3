//! Fitted to `examples/paper/calibration/` and written by `cargo run --release -p paper --bin calibrate_models`; a test in
//! `examples/paper/tests/model_for.rs` fits them again. Not to be edited.

#![allow(clippy::unreadable_literal, reason = "generated")]

/// Coefficients of B(η)/η², a polynomial in η.
pub(super) const LAYERS: [f64; 4] = [0.41778, -7.7632, 19.836, -13.401];

/// What that misses of B/η².
pub(super) const LAYERS_SCATTER: f64 = 0.019996;

/// Total variation distance above the layers, in units of that of the ideal gas.
pub(super) const BULK: f64 = 0.0018153;

/// Factor by which ideal gas or theory may be worse than expected.
pub(super) const ALLOWANCE: f64 = 1.1158;

/// Total variation distance by a finite base, in units of that of the ideal gas over the number of spheres.
pub(super) const FINITE_BASE: f64 = 0.55105;

/// CPU seconds of the ideal gas: factor and power of the height.
pub(super) const IDEAL_COST: [f64; 2] = [3.8608e-7, 1.0106];

/// CPU seconds of the theory: factor and power of the height.
pub(super) const THEORY_COST: [f64; 2] = [8.537e-4, 0.47461];

/// CPU seconds to set up a run, in units of those of the theory: isothermal, and where T varies.
pub(super) const START_COST: [f64; 2] = [1.9353, 2.9358];

/// Variance of a run in units of that of as many independent spheres, for tuned local moves and event chains: logarithm, and its slopes with packing fraction, logarithm of the extent, and varying T.
pub(super) const INEFFICIENCY: [[f64; 4]; 2] =
    [[1.8547, 3.5866, -0.16613, -0.11688], [1.69, -0.25511, -0.039911, -0.037488]];

/// Sweeps that the theory start counts for, for either family.
pub(super) const HEAD_START: [f64; 2] = [16.0, 3.0];

/// Standard deviation of the noise of single seeds, in units of its root mean square, for either family.
pub(super) const SEED_SCATTER: [f64; 2] = [0.28139, 0.24665];

/// Factor by which the noise of a plan may be more than expected, for either family.
pub(super) const PLAN_ALLOWANCE: [f64; 2] = [1.1713, 1.1172];

/// CPU seconds per sphere and sweep for either family, and their slope with packing fraction.
pub(super) const SWEEP_COST: [[f64; 2]; 2] = [[1.8153e-7, -2.0368e-7], [2.21e-7, 4.2184e-7]];
