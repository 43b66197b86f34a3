//! The paper's scheme: the effective field of every sweep comes from that sweep's own histogram.

use super::column_average::ColumnAverage;
use super::counting_noise;
use super::effective_potential::bin_width_of;
use super::{Adaptation, EffectivePotential, MeasuredShare, Scheme};
use crate::frame::Frame;
use crate::observer::{Observer, ObserverError};
use crate::scene::AnyScene;
use crate::{Error, Field, Scene, TemperatureProfile, Warning};

/// The effective field from the histogram of the current configuration, remade every sweep, as in
/// doi:10.1103/PhysRevE.83.061306. For comparison: **do not use it for results**.
///
/// The rule that accepts a move depends on the configuration through the histogram and is not
/// corrected for it, so detailed balance does not hold. A bin that holds k spheres of Poisson mean
/// λ contributes E[1/k] > 1/λ, which over-weights the gradient term by about 1/λ of itself wherever
/// a move crosses bins: narrow bins and small bases are biased most (`docs/seven_per_cent.md`). An
/// empty bin takes the ideal-gas value P/n = T. Certificates of such a run always say
/// [`FreezeTheField`](super::Suggestion::FreezeTheField).
///
/// Since balance does not hold, the steady state depends on the moves. A simulation that names none
/// has the paper's: local moves with S = 0.75. Event chains are refused unless
/// [`any_moves`](Self::any_moves) allows them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instantaneous {
    bin_width: f64,
    any_moves: bool,
}

impl Instantaneous {
    /// Bins of the given width, in diameters.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] unless positive and finite.
    pub fn new(bin_width: f64) -> Result<Self, Error> {
        Ok(Self { bin_width: bin_width_of(bin_width)?, any_moves: false })
    }

    /// Takes event chains too, for studies of how the steady state depends on the moves.
    #[must_use]
    pub fn any_moves(self) -> Self {
        Self { any_moves: true, ..self }
    }
}

impl Default for Instantaneous {
    /// The paper's bins of 0.1 diameters.
    fn default() -> Self {
        Self { bin_width: 0.1, any_moves: false }
    }
}

/// Of [`Instantaneous`]: P/n of the last configuration.
#[derive(Debug, Clone)]
pub struct EverySweep {
    histogram: ColumnAverage,
    temperatures: Vec<f64>,
}

impl<F: Field, T: TemperatureProfile> Scheme<F, T> for Instantaneous {
    type Drive = EffectivePotential;
    type Adaptation = EverySweep;

    fn drive(self, scene: &Scene<F, T>) -> Result<(EffectivePotential, EverySweep), Error> {
        let mut potential = EffectivePotential::new(scene, self.bin_width)?;
        let temperatures: Vec<f64> =
            potential.heights().map(|height| scene.temperature().temperature(height)).collect();
        // Until the first sweep has been counted.
        potential.set(0.0, |bin| temperatures[bin])?;
        let histogram = ColumnAverage::new(&potential);
        Ok((potential, EverySweep { histogram, temperatures }))
    }

    fn depends_on_moves(&self) -> bool {
        !self.any_moves
    }
}

impl Observer for EverySweep {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.histogram.clear();
        self.histogram.add(frame);
        Ok(())
    }
}

impl Adaptation<EffectivePotential> for EverySweep {
    fn adapt(&mut self, potential: &mut EffectivePotential, scene: &AnyScene<'_>) -> Result<(), Error> {
        // The paper takes the pressure far above to be zero.
        let area = scene.slab().base_area();
        let rows = self.histogram.counts_and_pressures(potential.bin_width(), area, 0.0);
        let temperatures = &self.temperatures;
        potential.set(0.0, |bin| {
            let [count, pressure] = rows[bin];
            if count > 0.0 { pressure / count } else { temperatures[bin] }
        })
    }

    fn follows_every_configuration(&self) -> bool {
        true
    }

    fn measured_share(&self) -> Option<MeasuredShare> {
        Some(MeasuredShare::ALL)
    }

    /// [`Warning::CountingNoise`].
    fn warnings(&self, potential: &EffectivePotential, scene: &AnyScene<'_>) -> Vec<Warning> {
        // Without a theory the judgment of the run says so.
        counting_noise::warning(scene, potential.bin_width()).ok().flatten().into_iter().collect()
    }
}

// Counted anew after every sweep.
persist!(EverySweep { part histogram });
