//! The scheme of the paper: the effective field is computed from the histogram of every sweep.

use super::column_average::ColumnAverage;
use super::counting_noise;
use super::effective_potential::bin_width_of;
use super::{Adaptation, EffectivePotential, MeasuredShare, Scheme};
use crate::frame::Frame;
use crate::observer::{Observer, ObserverError};
use crate::scene::AnyScene;
use crate::{Error, Field, Scene, TemperatureProfile, Warning};

/// Scheme of doi:10.1103/PhysRevE.83.061306: the effective field is computed after every sweep from
/// the histogram of the current configuration. It is biased and only for comparison: **do not use
/// it for results**.
///
/// The acceptance depends on the configuration through the histogram, without a correction, so
/// detailed balance does not hold. A bin with k spheres of Poisson mean λ contributes E[1/k] > 1/λ,
/// which makes the gradient term too large by a relative amount of about 1/λ if moves cross bins.
/// The bias is largest for narrow bins and small bases (`docs/seven_per_cent.md`). An empty bin has
/// the ideal-gas value P/n = T. The certificate of such a run is never converged
/// ([`FreezeTheField`](super::Suggestion::FreezeTheField)).
///
/// The steady state therefore depends on the moves. The default moves of this scheme are those of
/// the paper: local moves with S = 0.75. Other moves are refused unless
/// [`any_moves`](Self::any_moves) allows them.
///
/// ```
/// use gradient_mc::drive::Instantaneous;
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::ExponentialTemperature};
/// let temperature = ExponentialTemperature::new(5.0, 0.02)?;
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 360, UniformField::default(), temperature)?;
/// let mut simulation = Simulation::builder(scene).scheme(Instantaneous::new(0.5)?).build()?;
/// simulation.run(400, &mut ())?;
/// assert!(!simulation.certificate(0.1)?.is_converged());
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instantaneous {
    bin_width: f64,
    any_moves: bool,
}

impl Instantaneous {
    /// Makes the scheme with bins of this width, in diameters.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] unless positive and finite.
    pub fn new(bin_width: f64) -> Result<Self, Error> {
        Ok(Self { bin_width: bin_width_of(bin_width)?, any_moves: false })
    }

    /// Allows event chains too, to study how the steady state depends on the moves.
    #[must_use]
    pub fn any_moves(self) -> Self {
        Self { any_moves: true, ..self }
    }
}

impl Default for Instantaneous {
    /// Bins of 0.1 diameters, as in the paper.
    fn default() -> Self {
        Self { bin_width: 0.1, any_moves: false }
    }
}

/// The adaptation of [`Instantaneous`]: P/n of the last configuration.
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
        // The potential of the first sweep: the ideal gas.
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
        self.histogram.add(frame, 0);
        Ok(())
    }
}

impl Adaptation<EffectivePotential> for EverySweep {
    fn adapt(&mut self, potential: &mut EffectivePotential, scene: &AnyScene<'_>) -> Result<(), Error> {
        // As in the paper, the pressure at the top is zero.
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
        // Without a theory, `Simulation::warnings` gives `NoTheory`.
        counting_noise::warning(scene, potential.bin_width()).ok().flatten().into_iter().collect()
    }
}

// The histogram is overwritten after every sweep.
persist!(EverySweep { part histogram });
