//! The paper's scheme: the effective field of every sweep comes from that sweep's own histogram.

use super::effective_potential::{EffectivePotential, Histogram, Mapping};
use super::{Drive, Phase, Scheme};
use crate::{Centers, Error, Field, Scene, TemperatureProfile};

/// The effective field from the histogram of the current configuration, remade every sweep, as in
/// doi:10.1103/PhysRevE.83.061306. For comparison: **do not use it for results**.
///
/// The rule that accepts a move depends on the configuration through the histogram and is not
/// corrected for it, so detailed balance does not hold. A bin that holds k spheres of Poisson mean
/// λ contributes E[1/k] > 1/λ, which over-weights the gradient term by about 1/λ of itself:
/// narrow bins and small bases are biased most. An empty bin takes the ideal-gas value P/n = T.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instantaneous {
    bin_width: f64,
}

impl Instantaneous {
    /// Bins of the given width, in diameters.
    #[must_use]
    pub fn new(bin_width: f64) -> Self {
        Self { bin_width }
    }
}

impl Default for Instantaneous {
    /// The paper's bins of 0.1 diameters.
    fn default() -> Self {
        Self::new(0.1)
    }
}

/// The drive of [`Instantaneous`].
#[derive(Debug, Clone)]
pub struct InstantaneousDrive {
    potential: EffectivePotential,
    generation: u64,
    mapping: Mapping,
    histogram: Histogram,
    temperatures: Vec<f64>,
}

impl<F: Field, T: TemperatureProfile> Scheme<F, T> for Instantaneous {
    type Drive = InstantaneousDrive;

    fn drive(self, scene: &Scene<F, T>) -> Result<InstantaneousDrive, Error> {
        let mapping = Mapping::new(scene, self.bin_width)?;
        let temperatures: Vec<f64> = (0..mapping.bins())
            .map(|bin| scene.temperature().temperature((bin as f64 + 0.5) * mapping.width()))
            .collect();
        // Until the first sweep has been counted.
        let potential = mapping.potential(|bin| temperatures[bin]);
        mapping.check(&potential)?;
        let histogram = Histogram::new(mapping.bins());
        Ok(InstantaneousDrive { potential, generation: 0, mapping, histogram, temperatures })
    }
}

impl<F: Field, T: TemperatureProfile> Drive<F, T> for InstantaneousDrive {
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
        self.generation
    }

    fn after_sweep(&mut self, scene: &Scene<F, T>, centers: Centers<'_>, _: Phase) -> Result<(), Error> {
        self.histogram.clear();
        self.histogram.add(&self.mapping, scene, centers);
        let rows = self.histogram.counts_and_pressures(&self.mapping, scene.slab().base_area(), 0.0);
        let temperatures = &self.temperatures;
        self.mapping.update(&mut self.potential, |bin| {
            let [count, pressure] = rows[bin];
            if count > 0.0 { pressure / count } else { temperatures[bin] }
        });
        self.generation += 1;
        self.mapping.check(&self.potential)
    }
}
