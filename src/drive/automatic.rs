//! The scheme of a simulation that names none, for any temperature profile.

use super::self_consistent::Iteration;
use super::{Drive, ForceBalance, MappedDrive, Phase, Scheme, SelfConsistent};
use crate::{Centers, Error, Field, Scene, TemperatureProfile, Warning, temperature};

/// The scheme of a simulation that names none: u = φ/T in closed form (eqs. 14 to 16 of
/// doi:10.1103/PhysRevE.83.061306) where the temperature is constant, the [`SelfConsistent`]
/// iteration where it varies.
///
/// Where a profile [says](TemperatureProfile::constant) that it is constant, as
/// [`Isothermal`](crate::temperature::Isothermal) does, the choice is made by the compiler, and nothing is
/// left of the other. Where it only turns out to be constant, at four heights to a diameter and to
/// rounding, the choice is one branch.
///
/// ```
/// use gradient_mc::drive::{Automatic, Drive, Scheme};
/// use gradient_mc::{Scene, Slab, field::UniformField, temperature::*};
/// let slab = Slab::new(50.0, 5.0, 5.0)?;
/// let scene = Scene::new(slab, 100, UniformField::default(), Isothermal::new(2.0)?)?;
/// assert_eq!(Automatic.drive(&scene)?.reduced_potential(&scene, 10.0), 5.0);
/// // T = 20 exp(−0x): the same potential as at a temperature of 20.
/// let scene = Scene::new(slab, 100, UniformField::default(), ExponentialTemperature::new(20.0, 0.0)?)?;
/// assert_eq!(Automatic.drive(&scene)?.reduced_potential(&scene, 10.0), 0.5);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Automatic;

/// The drive of [`Automatic`].
#[derive(Debug, Clone)]
pub struct AutomaticDrive(Kind);

#[derive(Debug, Clone)]
enum Kind {
    Isothermal { temperature: f64 },
    Iterated(Box<MappedDrive<Iteration>>),
}

impl<F: Field, T: TemperatureProfile> Scheme<F, T> for Automatic {
    type Drive = AutomaticDrive;

    /// # Errors
    /// [`Error::InvalidPotential`] where φ/T overflows; what [`SelfConsistent`] returns.
    fn drive(self, scene: &Scene<F, T>) -> Result<AutomaticDrive, Error> {
        const PROBES: u32 = 4096;
        let Some(temperature) = temperature::constant(scene.temperature(), scene.slab()) else {
            return Ok(AutomaticDrive(Kind::Iterated(Box::new(SelfConsistent::default().drive(scene)?))));
        };
        for probe in 0..=PROBES {
            let height = scene.slab().height() * f64::from(probe) / f64::from(PROBES);
            let potential = scene.field().potential(height) / temperature;
            if !potential.is_finite() {
                return Err(Error::InvalidPotential { height, potential });
            }
        }
        Ok(AutomaticDrive(Kind::Isothermal { temperature }))
    }
}

impl AutomaticDrive {
    /// The iteration, unless the temperature is constant. Of a profile that says that it is, this is known to the compiler.
    #[inline]
    fn iterated<F, T: TemperatureProfile>(
        &self,
        scene: &Scene<F, T>,
    ) -> Result<&MappedDrive<Iteration>, f64> {
        match (scene.temperature().constant(), &self.0) {
            (Some(temperature), _) | (None, &Kind::Isothermal { temperature }) => Err(temperature),
            (None, Kind::Iterated(drive)) => Ok(drive),
        }
    }

    /// The same, to be changed.
    #[inline]
    fn iterated_mut<F, T: TemperatureProfile>(
        &mut self,
        scene: &Scene<F, T>,
    ) -> Option<&mut MappedDrive<Iteration>> {
        match (scene.temperature().constant(), &mut self.0) {
            (None, Kind::Iterated(drive)) => Some(drive),
            _ => None,
        }
    }
}

impl<F: Field, T: TemperatureProfile> Drive<F, T> for AutomaticDrive {
    #[inline]
    fn reduced_potential(&self, scene: &Scene<F, T>, height: f64) -> f64 {
        match self.iterated(scene) {
            Ok(drive) => drive.reduced_potential(scene, height),
            Err(temperature) => scene.field().potential(height) / temperature,
        }
    }

    #[inline]
    fn reduced_force(&self, scene: &Scene<F, T>, height: f64) -> f64 {
        match self.iterated(scene) {
            Ok(drive) => drive.reduced_force(scene, height),
            Err(temperature) => scene.field().acceleration(height) / temperature,
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
    fn lid_pressure(&self) -> f64 {
        match &self.0 {
            Kind::Isothermal { .. } => 0.0,
            Kind::Iterated(drive) => Drive::<F, T>::lid_pressure(drive.as_ref()),
        }
    }

    #[inline]
    fn after_sweep(&mut self, scene: &Scene<F, T>, centers: Centers<'_>, phase: Phase) -> Result<(), Error> {
        self.iterated_mut(scene).map_or(Ok(()), |drive| drive.after_sweep(scene, centers, phase))
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
        self.iterated_mut(scene).map_or(Ok(()), |drive| drive.start_production(scene))
    }

    #[inline]
    fn warnings(&self, scene: &Scene<F, T>) -> Vec<Warning> {
        self.iterated(scene).map_or_else(|_| Vec::new(), |drive| drive.warnings(scene))
    }
}
