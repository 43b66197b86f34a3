//! The reduced potential of a non-isothermal scene: the isothermal one plus a tabulated correction.

use super::Drive;
use crate::numerics::integrate_panel;
use crate::{Error, Field, Scene, TemperatureProfile, Wall};

/// The reduced potential u(x) = φ(x)/T₀ + C(x) of an effective field, with the correction
///
/// C(x) = ∫₀ˣ a (1/T − 1/T₀) dx' − ∫ (P/n) d(1/T)
///
/// up to a constant, and T₀ the highest temperature at an edge of a bin: a lower one could be so
/// low that the sum has no digits left. C is exact at the edges of bins and linear between them, so u' is off by at
/// most half the bin width times u''. The bins divide the heights where centers can be. At constant
/// temperature C is exactly zero.
///
/// As a [`Drive`] it is constant, so detailed balance is exact. An
/// [`Adaptation`](super::Adaptation) may set it from P/n in every bin.
///
/// ```
/// use gradient_mc::drive::{Drive, EffectivePotential};
/// use gradient_mc::{Scene, Slab, field::UniformField, temperature::ExponentialTemperature};
/// let slab = Slab::new(100.0, 5.0, 5.0)?;
/// let scene = Scene::new(slab, 25, UniformField::default(), ExponentialTemperature::new(20.0, 0.02)?)?;
/// let mut potential = EffectivePotential::new(&scene, 0.1)?;
/// // As if the spheres were an ideal gas: P/n = T.
/// let temperatures: Vec<f64> = potential.heights().map(|x| 20.0 * (-0.02 * x).exp()).collect();
/// potential.set(0.0, |bin| temperatures[bin])?;
/// assert!((potential.reduced_force(&scene, 50.0) - (1f64.exp() / 20.0 - 0.02)).abs() < 1e-3);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct EffectivePotential {
    /// T₀. The potential is divided by it as in the isothermal drive, so that both have equal bits.
    reference: f64,
    lowest: f64,
    width: f64,
    inverse_width: f64,
    /// C at the edges of bins.
    correction: Vec<f64>,
    /// ∫ a (1/T − 1/T₀) dx over each bin.
    field_part: Vec<f64>,
    /// −Δ(1/T) over each bin: the factor of P/n.
    gradient_part: Vec<f64>,
    open_end: Wall,
    open_end_pressure: f64,
    generation: u64,
}

/// Heights divided into bins.
#[derive(Debug, Clone, Copy)]
pub(super) struct Division {
    lowest: f64,
    inverse_width: f64,
    pub(super) bins: usize,
}

impl Division {
    /// The bin that contains `height`, or the nearest one outside the range of centers.
    #[inline]
    pub(super) fn bin(&self, height: f64) -> usize {
        // The cast saturates at both ends.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let bin = ((height - self.lowest) * self.inverse_width) as usize;
        bin.min(self.bins - 1)
    }
}

/// Checks a bin width.
pub(super) fn bin_width_of(bin_width: f64) -> Result<f64, Error> {
    Error::require_positive("bin width of the effective field", bin_width)
}

impl EffectivePotential {
    /// Makes bins of about `bin_width` over all heights of centers, with P/n = 0. Use
    /// [`set`](Self::set) to set P/n.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] if the width is not positive and finite; [`Error::InvalidBins`]
    /// for too many bins; [`Error::InvalidPotential`] if φ/T₀ overflows.
    pub fn new<F: Field, T: TemperatureProfile>(scene: &Scene<F, T>, bin_width: f64) -> Result<Self, Error> {
        const MAXIMUM: usize = 1 << 24;
        bin_width_of(bin_width)?;
        let (lowest, extent) = (scene.slab().lowest_center(), scene.slab().height() - 1.0);
        let bins = (extent / bin_width).round().max(1.0);
        // At least 1; the cast saturates.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let bins = bins as usize;
        if bins > MAXIMUM {
            return Err(Error::InvalidBins { bins, extent, maximum: MAXIMUM });
        }
        let width = extent / bins as f64;
        let temperature = |x: f64| scene.temperature().temperature(x);
        let inverse = |x: f64| 1.0 / temperature(x);
        let edge = |bin: usize| lowest + bin as f64 * width;
        let reference = (0..=bins).map(edge).map(temperature).fold(0.0, f64::max);
        let inverse_reference = 1.0 / reference;
        let field_part = (0..bins)
            .map(|bin| {
                let force = |x: f64| scene.field().acceleration(x) * (inverse(x) - inverse_reference);
                integrate_panel(force, edge(bin), edge(bin + 1))
            })
            .collect();
        let gradient_part = (0..bins).map(|bin| inverse(edge(bin)) - inverse(edge(bin + 1))).collect();
        for height in (0..=bins).map(edge) {
            let potential = scene.field().potential(height) / reference;
            if !potential.is_finite() {
                return Err(Error::InvalidPotential { height, potential });
            }
        }
        Ok(Self {
            reference,
            lowest,
            width,
            inverse_width: 1.0 / width,
            correction: vec![0.0; bins + 1],
            field_part,
            gradient_part,
            open_end: scene.open_end(),
            open_end_pressure: 0.0,
            generation: 0,
        })
    }

    /// Sets u from P/n in each bin, in m g d, and the pressure on the wall at the [open
    /// end](Scene::open_end), in m g/d².
    ///
    /// # Errors
    /// [`Error::InvalidPotential`] if u is not finite at some height; u is unchanged then.
    pub fn set(
        &mut self,
        open_end_pressure: f64,
        pressure_over_density: impl Fn(usize) -> f64,
    ) -> Result<(), Error> {
        let mut sum = 0.0;
        let mut correction = Vec::with_capacity(self.correction.len());
        correction.push(0.0);
        for (bin, (field, gradient)) in self.field_part.iter().zip(&self.gradient_part).enumerate() {
            // No contribution where the temperature is constant: this avoids rounding errors, and 0
            // times infinity.
            if *gradient != 0.0 {
                sum += pressure_over_density(bin) * gradient;
            }
            sum += field;
            if !sum.is_finite() {
                let height = self.lowest + (bin + 1) as f64 * self.width;
                return Err(Error::InvalidPotential { height, potential: sum });
            }
            correction.push(sum);
        }
        (self.correction, self.open_end_pressure) = (correction, open_end_pressure);
        self.generation += 1;
        Ok(())
    }

    /// Number of bins.
    #[must_use]
    pub fn bins(&self) -> usize {
        self.field_part.len()
    }

    /// Height of a bin, in diameters.
    #[must_use]
    pub fn bin_width(&self) -> f64 {
        self.width
    }

    /// Middles of the bins in diameters, upwards.
    #[must_use]
    pub fn heights(&self) -> impl ExactSizeIterator<Item = f64> + use<> {
        let Self { lowest, width, .. } = *self;
        (0..self.bins()).map(move |bin| lowest + (bin as f64 + 0.5) * width)
    }

    /// The bin that contains `height`, or the nearest one outside the range of centers.
    #[inline]
    #[must_use]
    pub fn bin(&self, height: f64) -> usize {
        self.division().bin(height)
    }

    /// The wall from which pressures are summed.
    pub(super) fn open_end(&self) -> Wall {
        self.open_end
    }

    /// The division of heights into bins.
    #[inline]
    pub(super) fn division(&self) -> Division {
        Division { lowest: self.lowest, inverse_width: self.inverse_width, bins: self.correction.len() - 1 }
    }
}

impl<F: Field, T> Drive<F, T> for EffectivePotential {
    #[inline]
    fn reduced_potential(&self, scene: &Scene<F, T>, height: f64) -> f64 {
        let bin = self.bin(height);
        let (low, high) = (self.correction[bin], self.correction[bin + 1]);
        let within = (height - self.lowest) * self.inverse_width - bin as f64;
        scene.field().potential(height) / self.reference + (low + (high - low) * within)
    }

    #[inline]
    fn reduced_force(&self, scene: &Scene<F, T>, height: f64) -> f64 {
        let bin = self.bin(height);
        let rise = self.correction[bin + 1] - self.correction[bin];
        scene.field().acceleration(height) / self.reference + rise * self.inverse_width
    }

    #[inline]
    fn resolution(&self) -> f64 {
        // Less than a bin, so that rounding at its edges cannot leave it out.
        0.9 * self.width
    }

    #[inline]
    fn generation(&self) -> u64 {
        self.generation
    }

    #[inline]
    fn open_end_pressure(&self) -> f64 {
        self.open_end_pressure
    }
}

persist!(
    EffectivePotential {
        same reference,
        same lowest,
        same width,
        same open_end,
        value open_end_pressure,
        slice correction,
        count generation,
    },
    |potential| potential.correction.iter().all(|value| value.is_finite())
);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Slab;
    use crate::field::ExponentialField;
    use crate::temperature::{LinearTemperature, TemperatureFn};
    use proptest::prelude::*;

    /// The temperature rises from next to nothing at the wall, where no center can be.
    #[test]
    fn a_cold_wall_does_not_cost_the_digits_of_the_force() {
        let slab = Slab::new(24.0, 4.0, 4.0).unwrap();
        let temperature = LinearTemperature::new(1e-300, 0.5).unwrap();
        let scene = Scene::new(slab, 10, ExponentialField::new(0.0).unwrap(), temperature).unwrap();
        let mut potential = EffectivePotential::new(&scene, 0.1).unwrap();
        // The ideal gas, P/n = T: u' = 1/T + T'/T.
        let temperatures: Vec<f64> = potential.heights().map(|height| 0.5 * height).collect();
        potential.set(0.0, |bin| temperatures[bin]).unwrap();
        for height in [1.0, 10.0, 23.0] {
            let force = potential.reduced_force(&scene, height);
            approx::assert_relative_eq!(force, 1.5 / (0.5 * height), max_relative = 0.1);
        }
    }

    proptest! {
        /// The definition of the effective field: m n g_e = −d(W/f)/dx for any n(x), field and
        /// temperature.
        #[test]
        fn the_force_on_any_density_is_the_fall_of_pressure_over_temperature(
            field_rate in -0.02..0.04_f64,
            swing in 0.0..0.5_f64,
            wave in 0.02..0.2_f64,
            bumps in prop::collection::vec((0.01..0.6_f64, 5.0..95.0_f64, 3.0..15.0_f64), 1..6),
        ) {
            let density = |x: f64| {
                let bump = |&(size, middle, width): &(f64, f64, f64)| {
                    size * (-((x - middle) / width).powi(2)).exp()
                };
                0.01 + bumps.iter().map(bump).sum::<f64>()
            };
            let temperature = move |x: f64| 10.0 * (1.0 + swing * (wave * x).sin());
            let field = ExponentialField::new(field_rate).unwrap();
            let slab = Slab::new(101.0, 5.0, 5.0).unwrap();
            let scene = Scene::new(slab, 10, field, TemperatureFn(temperature)).unwrap();
            // Largest error over a bin, in units of the largest force, for two bin widths.
            let worst = |width: f64| {
                let mut potential = EffectivePotential::new(&scene, width).unwrap();
                let bins = potential.bins();
                let mass = |bin: usize| {
                    let (low, high) = (0.5 + bin as f64 * width, 0.5 + (bin as f64 + 1.0) * width);
                    integrate_panel(|x| density(x) * field.acceleration(x), low, high)
                };
                let mut weights = vec![0.0; bins + 1];
                for bin in (0..bins).rev() {
                    weights[bin] = weights[bin + 1] + mass(bin);
                }
                let middle = |bin: usize| 0.5 + (bin as f64 + 0.5) * width;
                potential.set(0.0, |bin| 0.5 * (weights[bin] + weights[bin + 1]) / density(middle(bin))).unwrap();
                let (mut largest, mut scale) = (0.0, 0.0_f64);
                for bin in 0..bins {
                    let force = density(middle(bin)) * potential.reduced_force(&scene, middle(bin));
                    let over_temperature = |edge: usize| weights[edge] / temperature(0.5 + edge as f64 * width);
                    let fall = (over_temperature(bin) - over_temperature(bin + 1)) / width;
                    largest = f64::max(largest, (force - fall).abs());
                    scale = scale.max(fall.abs());
                }
                largest / scale
            };
            let (coarse, fine) = (worst(0.5), worst(0.125));
            prop_assert!(coarse < 0.02, "{coarse}");
            // Second order: sixteen times smaller within a factor of two, unless it is rounding.
            prop_assert!(fine < coarse / 8.0 + 1e-12, "{coarse} with wide bins, {fine} with narrow ones");
        }
    }
}
