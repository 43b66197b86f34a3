//! The effective field from an average over everything seen so far.

use super::column_average::{ColumnAverage, Prior};
use super::effective_potential::bin_width_of;
use super::{Adaptation, EffectivePotential, MeasuredShare, Scheme};
use crate::equation_of_state::FluidSolid;
use crate::frame::{Frame, Phase};
use crate::observer::{Observer, ObserverError};
use crate::scene::AnyScene;
use crate::{Error, Field, Scene, TemperatureProfile, Warning};

/// The effective field from the average of all configurations so far, updated for ever, ever more
/// slowly.
///
/// Detailed balance holds asymptotically: what one more configuration changes falls as one over the
/// number of those before (diminishing adaptation, Roberts and Rosenthal,
/// doi:10.1239/jap/1183667414). Counts and weights are averaged, never ratios of single
/// configurations, so there is no noise bias. But an average of everything never quite forgets its
/// start: the fixed-point map from density to field has a spectral radius ρ (0.11 to 0.57 for the
/// paper's β = 0.005 to 0.05), and what is left of the start falls as slowly as the power −(1 − ρ)
/// of the number of sweeps. For comparison; [`SelfConsistent`](super::SelfConsistent) is better.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunningAverage {
    bin_width: f64,
}

/// As [`RunningAverage`] while equilibrating, then frozen: production holds detailed balance
/// exactly, in a field that remembers the start of the run.
///
/// For comparison: frozen early, it is wrong, and the certificate of the run says so.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AveragedThenFrozen {
    bin_width: f64,
}

impl RunningAverage {
    /// Bins of the given width, in diameters.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] unless positive and finite.
    pub fn new(bin_width: f64) -> Result<Self, Error> {
        Ok(Self { bin_width: bin_width_of(bin_width)? })
    }
}

impl AveragedThenFrozen {
    /// Bins of the given width, in diameters.
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

/// Of [`RunningAverage`] and [`AveragedThenFrozen`]: P/n of the average of all configurations, the
/// theory profile standing for a few.
#[derive(Debug, Clone)]
pub struct Averaging {
    freezes: bool,
    prior: Prior,
    average: ColumnAverage,
    measured: MeasuredShare,
    sweeps: u64,
    /// Of the last sweep.
    phase: Phase,
}

impl Averaging {
    const SWEEPS_BETWEEN_UPDATES: u64 = 10;
    /// Of the theory, in counted spheres per diameter of height: enough that bins which are empty
    /// by chance do no harm.
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

    /// Whether nothing changes any more.
    fn is_frozen(&self) -> bool {
        self.freezes && self.phase == Phase::Production
    }
}

impl Observer for Averaging {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.phase = frame.phase();
        if !self.is_frozen() {
            self.average.add(frame);
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
