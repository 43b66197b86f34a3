//! The default scheme of a simulation, for any temperature profile.

use super::self_consistent::Iteration;
use super::{Adaptation, Drive, EffectivePotential, MeasuredShare, Scheme, SelfConsistent};
use crate::scene::AnyScene;
use crate::{Error, Field, Scene, TemperatureProfile, Warning, temperature};

/// The default scheme: u = φ/T in closed form (eqs. 14 to 16 of doi:10.1103/PhysRevE.83.061306) if
/// the temperature is constant, and the [`SelfConsistent`] iteration if it varies.
///
/// If a profile has a [`constant`](TemperatureProfile::constant) temperature, as
/// [`Isothermal`](crate::temperature::Isothermal), the compiler makes the choice and removes the
/// code of the iteration. Other profiles are evaluated at four heights per diameter; if the
/// temperature is the same, up to rounding, they are treated as isothermal too, at the cost of one
/// branch.
///
/// ```
/// use gradient_mc::drive::{Automatic, Drive, Scheme};
/// use gradient_mc::{Scene, Slab, field::UniformField, temperature::*};
/// let slab = Slab::new(50.0, 5.0, 5.0)?;
/// let scene = Scene::new(slab, 100, UniformField::default(), Isothermal::new(2.0)?)?;
/// assert_eq!(Automatic.drive(&scene)?.0.reduced_potential(&scene, 10.0), 5.0);
/// // T = 20 exp(−0x): the same potential as at a temperature of 20.
/// let scene = Scene::new(slab, 100, UniformField::default(), ExponentialTemperature::new(20.0, 0.0)?)?;
/// assert_eq!(Automatic.drive(&scene)?.0.reduced_potential(&scene, 10.0), 0.5);
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
    Mapped(Box<EffectivePotential>),
}

impl<F: Field, T: TemperatureProfile> Scheme<F, T> for Automatic {
    type Drive = AutomaticDrive;
    type Adaptation = Option<Box<Iteration>>;

    /// # Errors
    /// [`Error::InvalidPotential`] if φ/T overflows at some height; those of [`SelfConsistent`].
    fn drive(self, scene: &Scene<F, T>) -> Result<(AutomaticDrive, Self::Adaptation), Error> {
        const PROBES: u32 = 4096;
        let Some(temperature) = temperature::constant(scene.temperature(), scene.slab()) else {
            let (potential, iteration) = SelfConsistent::default().drive(scene)?;
            return Ok((AutomaticDrive(Kind::Mapped(Box::new(potential))), Some(Box::new(iteration))));
        };
        for probe in 0..=PROBES {
            let height = scene.slab().height() * f64::from(probe) / f64::from(PROBES);
            let potential = scene.field().potential(height) / temperature;
            if !potential.is_finite() {
                return Err(Error::InvalidPotential { height, potential });
            }
        }
        Ok((AutomaticDrive(Kind::Isothermal { temperature }), None))
    }
}

impl AutomaticDrive {
    /// The effective potential, or the temperature if it is constant. For profiles such as
    /// `Isothermal` the compiler knows the result.
    #[inline]
    fn mapped<F, T: TemperatureProfile>(&self, scene: &Scene<F, T>) -> Result<&EffectivePotential, f64> {
        match (scene.temperature().constant(), &self.0) {
            (Some(temperature), _) | (None, &Kind::Isothermal { temperature }) => Err(temperature),
            (None, Kind::Mapped(potential)) => Ok(potential),
        }
    }
}

impl<F: Field, T: TemperatureProfile> Drive<F, T> for AutomaticDrive {
    #[inline]
    fn reduced_potential(&self, scene: &Scene<F, T>, height: f64) -> f64 {
        match self.mapped(scene) {
            Ok(potential) => potential.reduced_potential(scene, height),
            Err(temperature) => scene.field().potential(height) / temperature,
        }
    }

    #[inline]
    fn reduced_force(&self, scene: &Scene<F, T>, height: f64) -> f64 {
        match self.mapped(scene) {
            Ok(potential) => potential.reduced_force(scene, height),
            Err(temperature) => scene.field().acceleration(height) / temperature,
        }
    }

    #[inline]
    fn generation(&self) -> u64 {
        match &self.0 {
            Kind::Isothermal { .. } => 0,
            Kind::Mapped(potential) => Drive::<F, T>::generation(potential.as_ref()),
        }
    }

    #[inline]
    fn open_end_pressure(&self) -> f64 {
        match &self.0 {
            Kind::Isothermal { .. } => 0.0,
            Kind::Mapped(potential) => Drive::<F, T>::open_end_pressure(potential.as_ref()),
        }
    }
}

impl Adaptation<AutomaticDrive> for Option<Box<Iteration>> {
    #[inline]
    fn adapt(&mut self, drive: &mut AutomaticDrive, scene: &AnyScene<'_>) -> Result<(), Error> {
        match (self, &mut drive.0) {
            (Some(iteration), Kind::Mapped(potential)) => iteration.adapt(potential, scene),
            _ => Ok(()),
        }
    }

    #[inline]
    fn start_production(&mut self, drive: &mut AutomaticDrive, scene: &AnyScene<'_>) -> Result<(), Error> {
        match (self, &mut drive.0) {
            (Some(iteration), Kind::Mapped(potential)) => iteration.start_production(potential, scene),
            _ => Ok(()),
        }
    }

    fn measured_share(&self) -> Option<MeasuredShare> {
        self.as_ref().and_then(|iteration| iteration.measured_share())
    }

    fn warnings(&self, drive: &AutomaticDrive, scene: &AnyScene<'_>) -> Vec<Warning> {
        match (self, &drive.0) {
            (Some(iteration), Kind::Mapped(potential)) => iteration.warnings(potential, scene),
            _ => Vec::new(),
        }
    }
}

#[cfg(feature = "checkpoint")]
impl crate::checkpoint::Persist for AutomaticDrive {
    fn persist(&mut self, archive: &mut crate::checkpoint::Archive<'_>) -> Result<(), Error> {
        match &mut self.0 {
            Kind::Isothermal { temperature } => archive.same("temperature", temperature),
            Kind::Mapped(potential) => archive.part("potential", potential),
        }
    }
}
