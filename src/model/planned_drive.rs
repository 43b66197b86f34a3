//! The drive of a plan, for any temperature profile.

use crate::drive::{Drive, ForceBalance, Phase, Scheme, SelfConsistent, SelfConsistentDrive};
use crate::{Centers, Error, Field, Scene, TemperatureProfile, Warning};

/// The scheme of a [`MonteCarloPlan`](super::MonteCarloPlan): φ/T in closed form where the profile turns out to be constant, the
/// [`SelfConsistent`] iteration where it varies. A plan is made for scenes whose type does not say which.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Planned;

/// The drive of [`Planned`].
#[derive(Debug, Clone)]
pub struct PlannedDrive(Kind);

#[derive(Debug, Clone)]
enum Kind {
    Isothermal { temperature: f64 },
    Iterated(Box<SelfConsistentDrive>),
}

/// The temperature of a scene if it is the same at all heights, to rounding.
pub(super) fn constant_temperature<F: Field, T: TemperatureProfile>(scene: &Scene<F, T>) -> Option<f64> {
    /// Probes per diameter: a scene was checked at forty.
    const DENSITY: f64 = 4.0;
    const LEAST: u32 = 256;
    const ROUNDING: f64 = 1e-12;
    let height = scene.slab().height();
    // Heights are at most 1e6.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let probes = ((DENSITY * height).ceil() as u32).max(LEAST);
    let temperature =
        |probe: u32| scene.temperature().temperature(height * f64::from(probe) / f64::from(probes));
    let first = temperature(0);
    (1..=probes).all(|probe| (temperature(probe) / first - 1.0).abs() < ROUNDING).then_some(first)
}

impl<F: Field, T: TemperatureProfile> Scheme<F, T> for Planned {
    type Drive = PlannedDrive;

    /// # Errors
    /// [`Error::InvalidPotential`] where φ/T overflows; what [`SelfConsistent`] returns.
    fn drive(self, scene: &Scene<F, T>) -> Result<PlannedDrive, Error> {
        let Some(temperature) = constant_temperature(scene) else {
            return Ok(PlannedDrive(Kind::Iterated(Box::new(SelfConsistent::default().drive(scene)?))));
        };
        let height = scene.slab().height();
        let potential = scene.field().potential(height) / temperature;
        if !potential.is_finite() {
            return Err(Error::InvalidPotential { height, potential });
        }
        Ok(PlannedDrive(Kind::Isothermal { temperature }))
    }
}

impl<F: Field, T: TemperatureProfile> Drive<F, T> for PlannedDrive {
    #[inline]
    fn reduced_potential(&self, scene: &Scene<F, T>, height: f64) -> f64 {
        match &self.0 {
            Kind::Isothermal { temperature } => scene.field().potential(height) / temperature,
            Kind::Iterated(drive) => drive.reduced_potential(scene, height),
        }
    }

    #[inline]
    fn reduced_force(&self, scene: &Scene<F, T>, height: f64) -> f64 {
        match &self.0 {
            Kind::Isothermal { temperature } => scene.field().acceleration(height) / temperature,
            Kind::Iterated(drive) => drive.reduced_force(scene, height),
        }
    }

    #[inline]
    fn generation(&self) -> u64 {
        match &self.0 {
            Kind::Isothermal { .. } => 0,
            Kind::Iterated(drive) => Drive::<F, T>::generation(drive.as_ref()),
        }
    }

    #[inline]
    fn after_sweep(&mut self, scene: &Scene<F, T>, centers: Centers<'_>, phase: Phase) -> Result<(), Error> {
        match &mut self.0 {
            Kind::Isothermal { .. } => Ok(()),
            Kind::Iterated(drive) => drive.after_sweep(scene, centers, phase),
        }
    }

    #[inline]
    fn force_balance(&self) -> Option<&ForceBalance> {
        match &self.0 {
            Kind::Isothermal { .. } => None,
            Kind::Iterated(drive) => Drive::<F, T>::force_balance(drive.as_ref()),
        }
    }

    #[inline]
    fn start_production(&mut self, scene: &Scene<F, T>) -> Result<(), Error> {
        match &mut self.0 {
            Kind::Isothermal { .. } => Ok(()),
            Kind::Iterated(drive) => drive.start_production(scene),
        }
    }

    #[inline]
    fn warnings(&self, scene: &Scene<F, T>) -> Vec<Warning> {
        match &self.0 {
            Kind::Isothermal { .. } => Vec::new(),
            Kind::Iterated(drive) => drive.warnings(scene),
        }
    }
}
