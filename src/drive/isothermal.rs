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
}

impl<F: Field> Scheme<F, Isothermal> for ClosedForm {
    type Drive = IsothermalDrive;

    fn drive(self, _: &Scene<F, Isothermal>) -> Result<IsothermalDrive, Error> {
        Ok(IsothermalDrive)
    }
}
