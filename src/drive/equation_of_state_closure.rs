//! The effective field from an equation of state.

use super::column_average::Prior;
use super::effective_potential::bin_width_of;
use super::{EffectivePotential, Scheme};
use crate::equation_of_state::{EquationOfState, FluidSolid};
use crate::{Error, Field, Scene, TemperatureProfile};

/// Scheme with a constant effective field from an equation of state: P/n = T Z(η) at the theory
/// profile [between walls](crate::Hydrostatics::between_walls), so u' = a/T + Z T'/T (eq. 20 of
/// doi:10.1103/PhysRevE.83.061306, divided by T).
///
/// Detailed balance is exact and there is no iteration. But the equation of state is an input, so
/// agreement of the measured P with it is no test.
///
/// ```
/// use gradient_mc::drive::{Drive, EquationOfStateClosure, Scheme};
/// use gradient_mc::equation_of_state::IdealGas;
/// use gradient_mc::{Scene, Slab, field::UniformField, temperature::ExponentialTemperature};
/// let slab = Slab::new(100.0, 5.0, 5.0)?;
/// let scene = Scene::new(slab, 25, UniformField::default(), ExponentialTemperature::new(20.0, 0.02)?)?;
/// let drive = EquationOfStateClosure::new(IdealGas).drive(&scene)?.0;
/// // Z = 1, so u' = 1/T + T'/T: with βx = 1 at the top, u rises by (e − 1)/(β T₀) − 1.
/// let rise = drive.reduced_potential(&scene, 50.0) - drive.reduced_potential(&scene, 0.0);
/// assert!((rise - (50.0 / 20.0 * 1f64.exp_m1() - 1.0)).abs() < 1e-3);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EquationOfStateClosure<E> {
    equation_of_state: E,
    bin_width: f64,
}

impl<E> EquationOfStateClosure<E> {
    /// Makes a closure by `equation_of_state`, with bins of 0.1 diameters.
    pub fn new(equation_of_state: E) -> Self {
        Self { equation_of_state, bin_width: 0.1 }
    }

    /// Sets the bin width of the effective field, in diameters.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] unless positive and finite.
    pub fn bin_width(self, bin_width: f64) -> Result<Self, Error> {
        Ok(Self { bin_width: bin_width_of(bin_width)?, ..self })
    }
}

impl Default for EquationOfStateClosure<FluidSolid> {
    /// The closure by [`FluidSolid`], the most accurate equation of state of the library.
    fn default() -> Self {
        Self::new(FluidSolid::default())
    }
}

impl<F: Field, T: TemperatureProfile, E: EquationOfState> Scheme<F, T> for EquationOfStateClosure<E> {
    type Drive = EffectivePotential;
    type Adaptation = ();

    fn drive(self, scene: &Scene<F, T>) -> Result<(EffectivePotential, ()), Error> {
        let mut potential = EffectivePotential::new(scene, self.bin_width)?;
        let Prior { ratios, open_end_pressure, .. } =
            Prior::new(scene, &potential, &self.equation_of_state, 0.0)?;
        potential.set(open_end_pressure, |bin| ratios[bin])?;
        Ok((potential, ()))
    }
}
