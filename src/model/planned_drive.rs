//! The drive of a plan, for any temperature profile.

use crate::drive::{Drive, ForceBalance, Phase, Scheme, SelfConsistent, SelfConsistentDrive};
use crate::{Centers, Error, Field, Scene, TemperatureProfile, Warning, temperature};

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

impl<F: Field, T: TemperatureProfile> Scheme<F, T> for Planned {
    type Drive = PlannedDrive;

    /// # Errors
    /// [`Error::InvalidPotential`] where φ/T overflows; what [`SelfConsistent`] returns.
    fn drive(self, scene: &Scene<F, T>) -> Result<PlannedDrive, Error> {
        let Some(temperature) = temperature::constant(scene.temperature(), scene.slab()) else {
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
