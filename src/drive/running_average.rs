//! The effective field from an average over all configurations so far.

use super::column_average::{ColumnAverage, Prior};
use super::effective_potential::bin_width_of;
use super::{Adaptation, EffectivePotential, MeasuredShare, Scheme};
use crate::equation_of_state::FluidSolid;
use crate::frame::{Frame, Phase};
use crate::observer::{Observer, ObserverError};
use crate::scene::AnyScene;
use crate::{Error, Field, Scene, TemperatureProfile, Warning};

/// Scheme with the effective field from the average over all configurations so far, also in
/// production.
///
/// Detailed balance holds asymptotically: the change by one more configuration decreases as 1 over
/// the number of configurations (diminishing adaptation, Roberts and Rosenthal,
/// doi:10.1239/jap/1183667414). Counts and weights are averaged, not ratios of single
/// configurations, so there is no bias from counting noise. But the influence of the start decays
/// slowly, as the power −(1 − ρ) of the number of sweeps, where ρ is the spectral radius of the
/// fixed-point map from density to field (0.11 to 0.57 for β = 0.005 to 0.05, the range of the
/// paper). The scheme is for comparison; [`SelfConsistent`](super::SelfConsistent) is better.
///
/// ```
/// use gradient_mc::drive::RunningAverage;
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::ExponentialTemperature};
/// let temperature = ExponentialTemperature::new(5.0, 0.02)?;
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 360, UniformField::default(), temperature)?;
/// let mut simulation = Simulation::builder(scene).scheme(RunningAverage::new(0.5)?).build()?;
/// simulation.equilibrate(50, &mut ())?;
/// let changes = simulation.frame().generation();
/// simulation.run(50, &mut ())?;
/// assert!(simulation.frame().generation() > changes);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunningAverage {
    bin_width: f64,
}

/// Scheme of [`RunningAverage`] in equilibration, with the field frozen in production. Detailed
/// balance is exact in production, but the field still depends on the start of the run.
///
/// It is for comparison. If the field is frozen too early, it is wrong, and the certificate of the
/// run is not converged.
///
/// ```
/// use gradient_mc::drive::AveragedThenFrozen;
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::ExponentialTemperature};
/// let temperature = ExponentialTemperature::new(5.0, 0.02)?;
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 360, UniformField::default(), temperature)?;
/// let mut simulation = Simulation::builder(scene).scheme(AveragedThenFrozen::new(0.5)?).build()?;
/// simulation.equilibrate(50, &mut ())?;
/// simulation.run(1, &mut ())?;
/// let changes = simulation.frame().generation();
/// simulation.run(50, &mut ())?;
/// assert_eq!(simulation.frame().generation(), changes);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AveragedThenFrozen {
    bin_width: f64,
}

impl RunningAverage {
    /// Makes the scheme with bins of this width, in diameters.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] unless positive and finite.
    pub fn new(bin_width: f64) -> Result<Self, Error> {
        Ok(Self { bin_width: bin_width_of(bin_width)? })
    }
}

impl AveragedThenFrozen {
    /// Makes the scheme with bins of this width, in diameters.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] unless positive and finite.
    pub fn new(bin_width: f64) -> Result<Self, Error> {
        Ok(Self { bin_width: bin_width_of(bin_width)? })
    }
}

impl Default for RunningAverage {
    /// Bins of 0.1 diameters.
    fn default() -> Self {
        Self { bin_width: 0.1 }
    }
}

impl Default for AveragedThenFrozen {
    /// Bins of 0.1 diameters.
    fn default() -> Self {
        Self { bin_width: 0.1 }
    }
}

impl<F: Field, T: TemperatureProfile> Scheme<F, T> for RunningAverage {
    type Drive = EffectivePotential;
    type Adaptation = Averaging;

    fn drive(self, scene: &Scene<F, T>) -> Result<(EffectivePotential, Averaging), Error> {
        Averaging::drive(scene, self.bin_width, false)
    }
}

impl<F: Field, T: TemperatureProfile> Scheme<F, T> for AveragedThenFrozen {
    type Drive = EffectivePotential;
    type Adaptation = Averaging;

    fn drive(self, scene: &Scene<F, T>) -> Result<(EffectivePotential, Averaging), Error> {
        Averaging::drive(scene, self.bin_width, true)
    }
}

/// The adaptation of [`RunningAverage`] and [`AveragedThenFrozen`]: P/n of the average over all
/// configurations, with a small weight of the theory profile.
#[derive(Debug, Clone)]
pub struct Averaging {
    freezes: bool,
    prior: Prior,
    average: ColumnAverage,
    measured: MeasuredShare,
    sweeps: u64,
    /// Phase of the last sweep.
    phase: Phase,
}

impl Averaging {
    const SWEEPS_BETWEEN_UPDATES: u64 = 10;
    /// Sweeps of the intervals from which the noise of counts is estimated.
    const SWEEPS_OF_INTERVAL: u64 = 64;
    /// Weight of the theory, in counted spheres per diameter of height. It prevents errors from
    /// bins that are empty by chance.
    const THEORY_WEIGHT: f64 = 1e4;

    fn drive<F: Field, T: TemperatureProfile>(
        scene: &Scene<F, T>,
        bin_width: f64,
        freezes: bool,
    ) -> Result<(EffectivePotential, Self), Error> {
        let mut potential = EffectivePotential::new(scene, bin_width)?;
        let prior = Prior::new(scene, &potential, &FluidSolid::default(), Self::THEORY_WEIGHT)?;
        potential.set(prior.open_end_pressure, |bin| prior.ratios[bin])?;
        let average = ColumnAverage::new(&potential);
        let (measured, phase) = (MeasuredShare::NONE, Phase::Equilibration);
        Ok((potential, Self { freezes, prior, average, measured, sweeps: 0, phase }))
    }

    fn update(&mut self, potential: &mut EffectivePotential, scene: &AnyScene<'_>) -> Result<(), Error> {
        let open_end_pressure = self.average.open_end_pressure(scene, &self.prior);
        let ratios = self.average.ratios(scene, potential.bin_width(), open_end_pressure, &self.prior);
        potential.set(open_end_pressure, |bin| ratios[bin])?;
        self.measured = self.average.measured_share(scene, potential.bin_width(), &self.prior, &self.average);
        Ok(())
    }

    /// Whether the field is frozen.
    fn is_frozen(&self) -> bool {
        self.freezes && self.phase == Phase::Production
    }
}

impl Observer for Averaging {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.phase = frame.phase();
        if !self.is_frozen() {
            self.average.add(frame, self.sweeps / Self::SWEEPS_OF_INTERVAL);
            self.sweeps += 1;
        }
        Ok(())
    }
}

impl Adaptation<EffectivePotential> for Averaging {
    fn adapt(&mut self, potential: &mut EffectivePotential, scene: &AnyScene<'_>) -> Result<(), Error> {
        if self.is_frozen() || !self.sweeps.is_multiple_of(Self::SWEEPS_BETWEEN_UPDATES) {
            return Ok(());
        }
        self.update(potential, scene)
    }

    fn start_production(
        &mut self,
        potential: &mut EffectivePotential,
        scene: &AnyScene<'_>,
    ) -> Result<(), Error> {
        self.update(potential, scene)
    }

    fn measured_share(&self) -> Option<MeasuredShare> {
        Some(self.measured)
    }

    /// [`Warning::FieldOfTheory`].
    fn warnings(&self, _: &EffectivePotential, _: &AnyScene<'_>) -> Vec<Warning> {
        self.measured.warning().into_iter().collect()
    }
}

persist!(Averaging { part prior, same freezes, part average, value measured, count sweeps, value phase });
