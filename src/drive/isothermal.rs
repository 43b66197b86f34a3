//! Isothermal scenes: φ(x)/T in closed form, no state.

use super::{Drive, Scheme};
use crate::temperature::Isothermal;
use crate::{Error, Field, Scene, TemperatureProfile};

/// The scheme of isothermal scenes, and the default: u = φ(x)/T (eqs. 14 to 16 of
/// doi:10.1103/PhysRevE.83.061306). It does not exist for other temperature profiles.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ClosedForm;

/// The drive of an isothermal scene; it holds nothing.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct IsothermalDrive;

impl<F: Field> Drive<F, Isothermal> for IsothermalDrive {
    #[inline]
    fn reduced_potential(&self, scene: &Scene<F, Isothermal>, height: f64) -> f64 {
        scene.field().potential(height) / scene.temperature().temperature(height)
    }

    #[inline]
    fn reduced_force(&self, scene: &Scene<F, Isothermal>, height: f64) -> f64 {
        scene.field().acceleration(height) / scene.temperature().temperature(height)
    }
}

impl<F: Field> Scheme<F, Isothermal> for ClosedForm {
    type Drive = IsothermalDrive;

    /// # Errors
    /// [`Error::InvalidPotential`] where φ/T overflows.
    fn drive(self, scene: &Scene<F, Isothermal>) -> Result<IsothermalDrive, Error> {
        const PROBES: u32 = 4096;
        for probe in 0..=PROBES {
            let height = scene.slab().height() * f64::from(probe) / f64::from(PROBES);
            let potential = IsothermalDrive.reduced_potential(scene, height);
            if !potential.is_finite() {
                return Err(Error::InvalidPotential { height, potential });
            }
        }
        Ok(IsothermalDrive)
    }
}
