//! Checks whether spheres are correlated with their own periodic images.

use crate::equation_of_state::packing_fraction;
use crate::{HydrostaticProfile, Scene, Warning};

/// Narrowest box without a warning, in diameters. Measured at T = 2.5 with 20 spheres per area
/// (packing fraction 0.45 at the base): at a width of 3 the mean height of the center of mass,
/// 14.1, is too low by 0.15(3); at widths of 3.5 to 8 it agrees with theory within 0.03. At packing
/// fraction 0.37 it agrees also at a width of 3.
const NARROWEST: f64 = 3.5;
/// Packing fractions below this give no warning.
const DENSE: f64 = 0.4;

pub(super) fn warning<F, T>(scene: &Scene<F, T>, theory: &HydrostaticProfile) -> Option<Warning> {
    let width = scene.slab().widths().into_iter().fold(f64::INFINITY, f64::min);
    let packing_fraction = packing_fraction(theory.density_maximum().1);
    (width < NARROWEST && packing_fraction > DENSE).then_some(Warning::NarrowBox { width, packing_fraction })
}
