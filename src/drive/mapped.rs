//! The drive of every scene whose temperature varies: an effective potential, what sets it, and a record of whether
//! it was the right one.

use super::certificate::{Certificate, Convergence, ForceBalance, Suggestion};
use super::effective_potential::EffectivePotential;
use super::{Drive, Phase};
use crate::{Centers, Error, Field, Scene, TemperatureProfile, Warning};

/// How the effective potential follows what a run measures: the part in which schemes differ.
///
/// ```
/// use gradient_mc::drive::{Adaptation, EffectivePotential, MappedDrive, Phase, Scheme};
/// use gradient_mc::{Centers, Error, Field, Scene, TemperatureProfile};
/// /// Z = 1/(1 − 4η), at one packing fraction everywhere; nothing is measured.
/// #[derive(Debug, Clone, Copy)]
/// struct Crude {
///     packing_fraction: f64,
/// }
/// /// It never changes what it was set to.
/// impl Adaptation for Crude {}
/// impl<F: Field, T: TemperatureProfile> Scheme<F, T> for Crude {
///     type Drive = MappedDrive<Self>;
///     fn drive(self, scene: &Scene<F, T>) -> Result<Self::Drive, Error> {
///         let mut potential = EffectivePotential::new(scene, 0.1)?;
///         let factor = 1.0 / (1.0 - 4.0 * self.packing_fraction);
///         let ratios: Vec<f64> =
///             potential.heights().map(|height| factor * scene.temperature().temperature(height)).collect();
///         potential.set(|bin| ratios[bin])?;
///         MappedDrive::new(scene, potential, self)
///     }
/// }
/// ```
pub trait Adaptation: Sync {
    /// Whether a production run can tell that the potential was the right one: not if it changes with every
    /// configuration.
    const CERTIFIABLE: bool = true;

    /// Pressure on the lid in m g/d² that the potential in force assumes; by default none, as under an open sky.
    fn lid_pressure(&self) -> f64 {
        0.0
    }

    /// What it has to say against production, beyond the balance of forces; by default nothing.
    fn warnings<F: Field, T: TemperatureProfile>(
        &self,
        _potential: &EffectivePotential,
        _scene: &Scene<F, T>,
    ) -> Vec<Warning> {
        Vec::new()
    }

    /// Sees the configuration after each sweep; the default does nothing.
    ///
    /// # Errors
    /// Any [`Error`]; it ends the run.
    #[inline]
    fn after_sweep<F: Field, T: TemperatureProfile>(
        &mut self,
        _potential: &mut EffectivePotential,
        _scene: &Scene<F, T>,
        _centers: Centers<'_>,
        _phase: Phase,
    ) -> Result<(), Error> {
        Ok(())
    }

    /// Called when production starts, before its first sweep; the default does nothing.
    ///
    /// # Errors
    /// Any [`Error`]; it ends the run.
    #[inline]
    fn start_production<F: Field, T: TemperatureProfile>(
        &mut self,
        _potential: &mut EffectivePotential,
        _scene: &Scene<F, T>,
    ) -> Result<(), Error> {
        Ok(())
    }
}

/// The drive of a scene that is mapped on an isothermal one: an [`EffectivePotential`], an [`Adaptation`] that sets
/// it, and the [`ForceBalance`] of the production run, from which
/// [`Simulation::certificate`](crate::Simulation::certificate) is made.
#[derive(Debug, Clone)]
pub struct MappedDrive<A> {
    potential: EffectivePotential,
    adaptation: A,
    balance: ForceBalance,
    /// Sweeps of production.
    sweeps: u64,
}

impl<A: Adaptation> MappedDrive<A> {
    /// The relative deviation of the balance of forces above which a run that can tell is warned of.
    const TOLERANCE: f64 = 0.02;
    /// That below which a run should be able to tell.
    const KNOWN_TO: f64 = 0.05;

    /// Puts the parts together.
    ///
    /// # Errors
    /// None at present.
    pub fn new<F, T: TemperatureProfile>(
        scene: &Scene<F, T>,
        potential: EffectivePotential,
        adaptation: A,
    ) -> Result<Self, Error> {
        let balance = ForceBalance::new(scene, A::CERTIFIABLE)?;
        Ok(Self { potential, adaptation, balance, sweeps: 0 })
    }
}

impl<A> MappedDrive<A> {
    /// The potential in force.
    #[must_use]
    pub fn potential(&self) -> &EffectivePotential {
        &self.potential
    }

    /// What sets it.
    #[must_use]
    pub fn adaptation(&self) -> &A {
        &self.adaptation
    }

    /// Pressure on the lid in m g/d² that the potential in force assumes: what a pressure profile starts from.
    #[must_use]
    pub fn lid_pressure(&self) -> f64
    where
        A: Adaptation,
    {
        self.adaptation.lid_pressure()
    }
}

impl<F: Field, T: TemperatureProfile, A: Adaptation> Drive<F, T> for MappedDrive<A> {
    #[inline]
    fn reduced_potential(&self, scene: &Scene<F, T>, height: f64) -> f64 {
        self.potential.reduced_potential(scene, height)
    }

    #[inline]
    fn reduced_force(&self, scene: &Scene<F, T>, height: f64) -> f64 {
        self.potential.reduced_force(scene, height)
    }

    #[inline]
    fn generation(&self) -> u64 {
        <EffectivePotential as Drive<F, T>>::generation(&self.potential)
    }

    fn after_sweep(&mut self, scene: &Scene<F, T>, centers: Centers<'_>, phase: Phase) -> Result<(), Error> {
        if phase == Phase::Production {
            // With the potential that was in force, not the one that is made from this configuration.
            if self.sweeps.is_multiple_of(ForceBalance::SWEEPS_BETWEEN_RECORDS) {
                let lid_pressure = self.adaptation.lid_pressure();
                self.balance.record(&self.potential, lid_pressure, scene, centers)?;
            }
            self.sweeps += 1;
        }
        self.adaptation.after_sweep(&mut self.potential, scene, centers, phase)
    }

    fn force_balance(&self) -> Option<&ForceBalance> {
        Some(&self.balance)
    }

    /// [`Warning::FeedbackNotConverged`] where the field is off by more than 2 %, or not known to be within 5 %.
    fn warnings(&self, scene: &Scene<F, T>) -> Vec<Warning> {
        let mut warnings = self.adaptation.warnings(&self.potential, scene);
        let cannot_tell = |certificate: &Certificate| {
            let Convergence::NotConverged { suggestion, .. } = certificate.convergence else { return false };
            suggestion == Suggestion::MeasureLonger
        };
        let verdict = match self.balance.certificate(Self::TOLERANCE) {
            Ok(certificate) if cannot_tell(&certificate) => self.balance.certificate(Self::KNOWN_TO),
            verdict => verdict,
        };
        match verdict {
            Ok(certificate) if !certificate.is_converged() => {
                warnings.push(Warning::FeedbackNotConverged { certificate });
            }
            Ok(_) => {}
            Err(_) => {
                let needed = ForceBalance::FEWEST_CONFIGURATIONS * ForceBalance::SWEEPS_BETWEEN_RECORDS;
                warnings.push(Warning::TooShort { sweeps: self.sweeps, needed });
            }
        }
        warnings
    }

    fn start_production(&mut self, scene: &Scene<F, T>) -> Result<(), Error> {
        // A potential that is to be changed now has nothing to do with what was seen before.
        self.balance.clear(scene)?;
        self.sweeps = 0;
        self.adaptation.start_production(&mut self.potential, scene)
    }
}
