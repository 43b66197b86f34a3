//! Acceptance rules that are known to be wrong, so that tests can be shown to notice.
//!
//! | rule | what is wrong | what notices |
//! |---|---|---|
//! | [`sign_of_displacement`] | downward moves always accepted, whatever the energy does | detailed balance |
//! | [`temperature_where_it_starts`] | ΔE over the temperature at the start of the move | cycles |
//! | [`TemperatureInMetropolis`] | u = φ/T(x): a potential, so detailed balance holds, but not the right one | the potential; the profile it gives |
//! | [`EquationThirtyOneAsPrinted`] | a sign and a factor in the feedback term | the potential; the profile it gives |

use super::scenes::exponential_integral;
use gradient_mc::drive::{Drive, Scheme};
use gradient_mc::field::UniformField;
use gradient_mc::temperature::ExponentialTemperature;
use gradient_mc::{Error, Field, Scene, TemperatureProfile};

/// ln p of the rule that accepts every downward move, and an upward one by its energy: what eqs.
/// (12), (14), (22), (25), (26) of doi:10.1103/PhysRevE.83.061306 say in words. Right only where u
/// rises.
pub fn sign_of_displacement(potential: impl Fn(f64) -> f64) -> impl Fn(f64, f64) -> f64 {
    move |from, to| if to < from { 0.0 } else { (potential(from) - potential(to)).min(0.0) }
}

/// ln p of the Metropolis rule at the temperature where the move starts.
pub fn temperature_where_it_starts<F: Field, T: TemperatureProfile>(
    scene: &Scene<F, T>,
) -> impl Fn(f64, f64) -> f64 {
    let energy = |height: f64| scene.field().potential(height);
    move |from, to| ((energy(from) - energy(to)) / scene.temperature().temperature(from)).min(0.0)
}

/// T(x) put straight into the Boltzmann factor: u = φ(x)/T(x), the barometric law of a gas without
/// heat flow. It makes the *density* a Boltzmann factor where the *pressure* should balance the
/// weight.
#[derive(Debug, Clone, Copy, Default)]
pub struct TemperatureInMetropolis;

impl<F: Field, T: TemperatureProfile> Drive<F, T> for TemperatureInMetropolis {
    fn reduced_potential(&self, scene: &Scene<F, T>, height: f64) -> f64 {
        scene.field().potential(height) / scene.temperature().temperature(height)
    }
}

impl<F: Field, T: TemperatureProfile> Scheme<F, T> for TemperatureInMetropolis {
    type Drive = Self;
    type Adaptation = ();

    fn drive(self, _: &Scene<F, T>) -> Result<(Self, ()), Error> {
        Ok((self, ()))
    }
}

/// Eq. (31) of doi:10.1103/PhysRevE.83.061306 as it is printed, with the double integral taken for
/// an ideal gas: the second term is -1/(βT₀) times it, where eq. (26) gives +β/T₀.
#[derive(Debug, Clone, Copy, Default)]
pub struct EquationThirtyOneAsPrinted;

impl Drive<UniformField, ExponentialTemperature> for EquationThirtyOneAsPrinted {
    fn reduced_potential(&self, scene: &Scene<UniformField, ExponentialTemperature>, height: f64) -> f64 {
        let base = scene.temperature().temperature(0.0);
        let decay_rate = -scene.temperature().logarithmic_gradient(0.0);
        let weight_term = scene.field().acceleration(0.0) * exponential_integral(decay_rate, height) / base;
        // For an ideal gas the double integral of e^{βx} W/n is T₀ x.
        weight_term + base * height / (decay_rate * base)
    }
}

impl Scheme<UniformField, ExponentialTemperature> for EquationThirtyOneAsPrinted {
    type Drive = Self;
    type Adaptation = ();

    fn drive(self, _: &Scene<UniformField, ExponentialTemperature>) -> Result<(Self, ()), Error> {
        Ok((self, ()))
    }
}
