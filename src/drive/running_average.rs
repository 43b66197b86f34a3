//! The effective field from an average over everything seen so far.

use super::column_average::{ColumnAverage, Prior};
use super::effective_potential::bin_width_of;
use super::{Adaptation, EffectivePotential, MappedDrive, Phase, Scheme};
use crate::equation_of_state::FluidSolid;
use crate::{Centers, Error, Field, Scene, TemperatureProfile};

/// The effective field from the average of all configurations so far, updated for ever, ever more slowly.
///
/// Detailed balance holds asymptotically: what one more configuration changes falls as one over the number of those
/// before (diminishing adaptation, Roberts and Rosenthal, doi:10.1239/jap/1183667414). Counts and weights are averaged,
/// never ratios of single configurations, so there is no noise bias. But an average of everything never quite
/// forgets its start: the fixed-point map from density to field has a spectral radius ρ (0.11 to 0.57 for the paper's
/// β = 0.005 to 0.05), and what is left of the start falls as slowly as the power −(1 − ρ) of the number of sweeps.
/// For comparison; [`SelfConsistent`](super::SelfConsistent) is better.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RunningAverage {
    bin_width: f64,
}

/// As [`RunningAverage`] while equilibrating, then frozen: production holds detailed balance exactly, in a field that
/// remembers the start of the run.
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
    type Drive = MappedDrive<Averaging>;

    fn drive(self, scene: &Scene<F, T>) -> Result<Self::Drive, Error> {
        Averaging::drive(scene, self.bin_width, false)
    }
}

impl<F: Field, T: TemperatureProfile> Scheme<F, T> for AveragedThenFrozen {
    type Drive = MappedDrive<Averaging>;

    fn drive(self, scene: &Scene<F, T>) -> Result<Self::Drive, Error> {
        Averaging::drive(scene, self.bin_width, true)
    }
}

/// Of [`RunningAverage`] and [`AveragedThenFrozen`]: P/n of the average of all configurations, the theory profile
/// standing for a few.
#[derive(Debug, Clone)]
pub struct Averaging {
    freezes: bool,
    prior: Prior,
    lid_pressure: f64,
    average: ColumnAverage,
    sweeps: u64,
}

impl Averaging {
    const SWEEPS_BETWEEN_UPDATES: u64 = 10;
    /// Of the theory, in counted spheres per diameter of height: enough that bins which are empty by chance do no harm.
    const THEORY_WEIGHT: f64 = 1e4;

    fn drive<F: Field, T: TemperatureProfile>(
        scene: &Scene<F, T>,
        bin_width: f64,
        freezes: bool,
    ) -> Result<MappedDrive<Self>, Error> {
        let mut potential = EffectivePotential::new(scene, bin_width)?;
        let prior = Prior::new(scene, &potential, &FluidSolid::default(), Self::THEORY_WEIGHT)?;
        potential.set(|bin| prior.ratios[bin])?;
        let average = ColumnAverage::new(potential.bins());
        let lid_pressure = prior.lid_pressure;
        Ok(MappedDrive::new(scene, potential, Self { freezes, prior, lid_pressure, average, sweeps: 0 }))
    }

    fn update<F: Field, T: TemperatureProfile>(
        &mut self,
        potential: &mut EffectivePotential,
        scene: &Scene<F, T>,
    ) -> Result<(), Error> {
        self.lid_pressure = self.average.lid_pressure(scene, &self.prior);
        let ratios = self.average.ratios(scene, potential.bin_width(), self.lid_pressure, &self.prior);
        potential.set(|bin| ratios[bin])
    }
}

impl Adaptation for Averaging {
    fn lid_pressure(&self) -> f64 {
        self.lid_pressure
    }

    fn after_sweep<F: Field, T: TemperatureProfile>(
        &mut self,
        potential: &mut EffectivePotential,
        scene: &Scene<F, T>,
        centers: Centers<'_>,
        phase: Phase,
    ) -> Result<(), Error> {
        if self.freezes && phase == Phase::Production {
            return Ok(());
        }
        self.average.add(potential, scene, centers);
        self.sweeps += 1;
        if self.sweeps.is_multiple_of(Self::SWEEPS_BETWEEN_UPDATES) {
            self.update(potential, scene)
        } else {
            Ok(())
        }
    }

    fn start_production<F: Field, T: TemperatureProfile>(
        &mut self,
        potential: &mut EffectivePotential,
        scene: &Scene<F, T>,
    ) -> Result<(), Error> {
        self.update(potential, scene)
    }
}
