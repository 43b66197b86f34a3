//! Numbers that `cargo run --release --example calibrate_models` fits to `calibration.csv` and writes here; `tests/model_for.rs` fits them again.

/// B(η)/η²: coefficients of a polynomial in η.
pub(super) const LAYERS: [f64; 4] = [-0.42, 7.4, -19.0, 14.0];
/// What the polynomial misses, in units of η².
pub(super) const LAYERS_SCATTER: f64 = 0.03;
/// Misplaced fraction in the bulk by equation of state and gradients.
pub(super) const BULK: f64 = 0.0004;
/// Factor by which an error of theory or ideal gas may exceed what is expected of it.
pub(super) const ALLOWANCE: f64 = 1.2;
/// Of a finite base: misplaced fraction in units of that of the ideal gas over the number of spheres.
pub(super) const FINITE_BASE: f64 = 1.0;
/// CPU seconds of the ideal gas, of theory: factor and power of the height of the slab.
pub(super) const IDEAL_COST: [f64; 2] = [5e-7, 1.0];
pub(super) const THEORY_COST: [f64; 2] = [7e-4, 0.5];
/// CPU seconds to set up a Monte Carlo run, in units of those of the theory; isothermal, and where T varies.
pub(super) const START_COST: [f64; 2] = [1.3, 2.5];
/// For tuned local moves and for event chains: ln g at η = 0 and its slope in η; more of it where T varies.
pub(super) const INEFFICIENCY: [[f64; 4]; 2] = [[1.5, 3.5, 0.0, 0.2], [1.45, 0.0, 0.0, 0.2]];
/// Sweeps in which the theory start is forgotten, for either family.
pub(super) const RELAXATION: [f64; 2] = [20.0, 10.0];
/// CPU seconds per sphere and sweep at η = 0, and more per unit of η, for either family.
pub(super) const SWEEP_COST: [[f64; 2]; 2] = [[1.3e-7, 0.0], [2.5e-7, 5e-7]];
