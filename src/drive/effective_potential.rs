//! The reduced potential of a non-isothermal scene: the isothermal one plus a tabulated correction.

use super::Drive;
use crate::numerics::integrate_panel;
use crate::{Centers, Error, Field, Scene, TemperatureProfile};

/// u(x) = φ(x)/T(0) + C(x), with the correction
///
/// C(x) = ∫₀ˣ a (1/T − 1/T(0)) dx' − ∫ (P/n) d(1/T)
///
/// exact at the edges of bins and linear between them. At constant temperature C is zero to the last
/// bit. Between edges u' is off by at most half the bin width times u''.
///
/// As a [`Drive`] it is frozen: detailed balance is exact.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectivePotential {
    /// T(0); a division as in the isothermal drive, so that equal potentials have equal bits.
    reference: f64,
    inverse_width: f64,
    correction: Vec<f64>,
}

impl EffectivePotential {
    /// u at `height` in `field`.
    #[inline]
    fn evaluate(&self, field: &impl Field, height: f64) -> f64 {
        let (bin, [low, high]) = self.bin(height);
        let within = height * self.inverse_width - bin as f64;
        field.potential(height) / self.reference + (low + (high - low) * within)
    }

    /// The bin that holds `height`, and the correction at its edges.
    #[inline]
    fn bin(&self, height: f64) -> (usize, [f64; 2]) {
        // Heights are inside the slab; the table covers it.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let bin = ((height * self.inverse_width) as usize).min(self.correction.len() - 2);
        (bin, [self.correction[bin], self.correction[bin + 1]])
    }
}

impl<F: Field, T> Drive<F, T> for EffectivePotential {
    #[inline]
    fn reduced_potential(&self, scene: &Scene<F, T>, height: f64) -> f64 {
        self.evaluate(scene.field(), height)
    }

    #[inline]
    fn reduced_force(&self, scene: &Scene<F, T>, height: f64) -> f64 {
        let (_, [low, high]) = self.bin(height);
        scene.field().acceleration(height) / self.reference + (high - low) * self.inverse_width
    }
}

/// What the correction needs of a scene, computed once.
#[derive(Debug, Clone)]
pub(super) struct Mapping {
    width: f64,
    reference: f64,
    /// ∫ a (1/T − 1/T(0)) dx over each bin.
    field_part: Vec<f64>,
    /// −Δ(1/T) over each bin: what multiplies P/n.
    gradient_part: Vec<f64>,
}

impl Mapping {
    /// Bins of about `bin_width` over the whole slab.
    pub(super) fn new<F: Field, T: TemperatureProfile>(
        scene: &Scene<F, T>,
        bin_width: f64,
    ) -> Result<Self, Error> {
        const MAXIMUM: usize = 1 << 24;
        Error::require_positive("bin width of the effective field", bin_width)?;
        let height = scene.slab().height();
        let bins = (height / bin_width).round().max(1.0);
        // At least 1; the cast saturates.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let bins = bins as usize;
        if bins > MAXIMUM {
            return Err(Error::InvalidBins { bins, extent: height, maximum: MAXIMUM });
        }
        let width = height / bins as f64;
        let inverse = |x: f64| 1.0 / scene.temperature().temperature(x);
        let inverse_reference = inverse(0.0);
        let edge = |bin: usize| bin as f64 * width;
        let field_part = (0..bins)
            .map(|bin| {
                let force = |x: f64| scene.field().acceleration(x) * (inverse(x) - inverse_reference);
                integrate_panel(force, edge(bin), edge(bin + 1))
            })
            .collect();
        let gradient_part = (0..bins).map(|bin| inverse(edge(bin)) - inverse(edge(bin + 1))).collect();
        let reference = scene.temperature().temperature(0.0);
        for height in (0..=bins).map(edge) {
            let potential = scene.field().potential(height) / reference;
            if !potential.is_finite() {
                return Err(Error::InvalidPotential { height, potential });
            }
        }
        Ok(Self { width, reference, field_part, gradient_part })
    }

    pub(super) fn bins(&self) -> usize {
        self.field_part.len()
    }

    pub(super) fn width(&self) -> f64 {
        self.width
    }

    /// Bin that holds `height`.
    #[inline]
    pub(super) fn bin(&self, height: f64) -> usize {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let bin = (height / self.width) as usize;
        bin.min(self.bins() - 1)
    }

    /// The potential for the given values of P/n, a length times m g, one per bin.
    pub(super) fn potential(&self, pressure_over_density: impl Fn(usize) -> f64) -> EffectivePotential {
        let mut potential = EffectivePotential {
            reference: self.reference,
            inverse_width: 1.0 / self.width,
            correction: vec![0.0; self.bins() + 1],
        };
        self.update(&mut potential, pressure_over_density);
        potential
    }

    /// Rewrites `potential` in place.
    pub(super) fn update(
        &self,
        potential: &mut EffectivePotential,
        pressure_over_density: impl Fn(usize) -> f64,
    ) {
        let mut sum = 0.0;
        let parts = self.field_part.iter().zip(&self.gradient_part);
        for (bin, (entry, (field, gradient))) in potential.correction[1..].iter_mut().zip(parts).enumerate() {
            // A flat stretch owes nothing to the density, not even a rounding error or 0 times infinity.
            if *gradient != 0.0 {
                sum += pressure_over_density(bin) * gradient;
            }
            sum += field;
            *entry = sum;
        }
    }

    /// Fails at the first height where `potential` is not finite.
    pub(super) fn check(&self, potential: &EffectivePotential) -> Result<(), Error> {
        let bad = potential.correction.iter().position(|value| !value.is_finite());
        bad.map_or(Ok(()), |edge| {
            Err(Error::InvalidPotential {
                height: edge as f64 * self.width,
                potential: potential.correction[edge],
            })
        })
    }
}

/// Counts and weights in the bins of a [`Mapping`], summed over configurations.
#[derive(Debug, Clone)]
pub(super) struct Histogram {
    configurations: u64,
    counts: Vec<f64>,
    /// Sum of a(x) over the spheres of each bin.
    weights: Vec<f64>,
}

impl Histogram {
    pub(super) fn new(bins: usize) -> Self {
        Self { configurations: 0, counts: vec![0.0; bins], weights: vec![0.0; bins] }
    }

    pub(super) fn configurations(&self) -> u64 {
        self.configurations
    }

    pub(super) fn clear(&mut self) {
        self.configurations = 0;
        self.counts.fill(0.0);
        self.weights.fill(0.0);
    }

    pub(super) fn add<F: Field, T>(&mut self, mapping: &Mapping, scene: &Scene<F, T>, centers: Centers<'_>) {
        self.configurations += 1;
        centers.for_each_height(|height| {
            let bin = mapping.bin(height);
            self.counts[bin] += 1.0;
            self.weights[bin] += scene.field().acceleration(height);
        });
    }

    pub(super) fn absorb(&mut self, other: &Self) {
        self.configurations += other.configurations;
        for (mine, theirs) in self.counts.iter_mut().zip(&other.counts) {
            *mine += theirs;
        }
        for (mine, theirs) in self.weights.iter_mut().zip(&other.weights) {
            *mine += theirs;
        }
    }

    /// Spheres in each bin, summed over configurations, and P A Δx in the same units: their ratio is
    /// P/n. `lid` is the pressure on the lid.
    ///
    /// The weight in the middle of a bin is the mean of those at its edges, which makes
    /// n u' Δx = −Δ(P/T) hold bin by bin.
    pub(super) fn counts_and_pressures(&self, mapping: &Mapping, base_area: f64, lid: f64) -> Vec<[f64; 2]> {
        let mut above = lid * base_area * self.configurations as f64;
        let mut rows: Vec<[f64; 2]> = self
            .counts
            .iter()
            .zip(&self.weights)
            .rev()
            .map(|(&count, &weight)| {
                let middle = above + 0.5 * weight;
                above += weight;
                [count, middle * mapping.width()]
            })
            .collect();
        rows.reverse();
        rows
    }

    /// Pressure on the lid from the spheres below it: T n within `depth` of the contact height.
    pub(super) fn lid_pressure<F, T: TemperatureProfile>(
        &self,
        mapping: &Mapping,
        scene: &Scene<F, T>,
        depth: f64,
    ) -> f64 {
        let highest = scene.slab().highest_center();
        let (first, last) = (mapping.bin(highest - depth), mapping.bin(highest));
        let count: f64 = self.counts[first..=last].iter().sum();
        let volume = scene.slab().base_area() * (highest - first as f64 * mapping.width());
        let density = count / (volume * self.configurations.max(1) as f64);
        density * scene.temperature().temperature(highest)
    }
}
