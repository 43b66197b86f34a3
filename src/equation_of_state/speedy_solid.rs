//! Speedy's equation of the fcc crystal.

use super::{CLOSE_PACKING, Domain, EquationOfState};

const RESIDUE: f64 = 0.5921;
const ZERO: f64 = 0.7072;
const POLE: f64 = 0.601;

/// Speedy's equation of the fcc crystal: Z = 3/(1 − z) − 0.5921 (z − 0.7072)/(z − 0.601), where z
/// is the packing fraction over that of close packing.
///
/// It is a fit to molecular dynamics of the crystal. The domain starts at η = 0.52, a little below
/// melting, which allows coexistence at a somewhat lower pressure; at lower densities the formula
/// has a pole. R. J. Speedy, J. Phys.: Condens. Matter 10, 4387 (1998),
/// doi:10.1088/0953-8984/10/20/006.
///
/// The integration constant of the chemical potential is chosen for an excess free energy of
/// 5.91889 T per sphere at n = 1.04086: J. M. Polson, E. Trizac, S. Pronk and D. Frenkel, J. Chem.
/// Phys. 112, 5339 (2000), doi:10.1063/1.481102.
///
/// ```
/// use gradient_mc::equation_of_state::{EquationOfState, MELTING, SpeedySolid, number_density};
/// let reduced_pressure = number_density(MELTING) * SpeedySolid.compressibility_factor(MELTING);
/// assert!((reduced_pressure - 11.57).abs() < 0.01);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SpeedySolid;

/// ∫ Z/z dz, up to a constant.
fn antiderivative(z: f64) -> f64 {
    let ratio = ZERO / POLE;
    3.0 * libm::log(z / (1.0 - z)) - RESIDUE * (ratio * libm::log(z) + (1.0 - ratio) * libm::log(z - POLE))
}

impl EquationOfState for SpeedySolid {
    fn compressibility_factor(&self, packing_fraction: f64) -> f64 {
        let z = packing_fraction / CLOSE_PACKING;
        3.0 / (1.0 - z) - RESIDUE * (z - ZERO) / (z - POLE)
    }
    fn compressibility_derivative(&self, packing_fraction: f64) -> f64 {
        let z = packing_fraction / CLOSE_PACKING;
        z * (3.0 / ((1.0 - z) * (1.0 - z)) - RESIDUE * (ZERO - POLE) / ((z - POLE) * (z - POLE)))
    }
    fn excess_chemical_potential(&self, packing_fraction: f64) -> f64 {
        const REFERENCE_DENSITY: f64 = 1.040_86;
        const REFERENCE_FREE_ENERGY: f64 = 5.918_89;
        let reference = super::packing_fraction(REFERENCE_DENSITY) / CLOSE_PACKING;
        let z = packing_fraction / CLOSE_PACKING;
        let free_energy =
            REFERENCE_FREE_ENERGY + antiderivative(z) - antiderivative(reference) - libm::log(z / reference);
        free_energy + self.compressibility_factor(packing_fraction) - 1.0
    }
    fn domain(&self) -> Domain {
        Domain { lowest: 0.52, highest: CLOSE_PACKING }
    }
}
