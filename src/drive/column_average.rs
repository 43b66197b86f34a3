//! The measurement of the feedback: numbers and weights of spheres in the bins of an effective
//! potential.

use super::effective_potential::{Division, EffectivePotential};
use super::measured_share::{MeasuredAt, MeasuredShare};
use crate::equation_of_state::EquationOfState;
use crate::frame::Frame;
use crate::{Error, Field, Scene, TemperatureProfile, Wall};

/// Numbers and weights in bins, summed over configurations, from which P/n is computed.
#[derive(Debug, Clone)]
pub(super) struct ColumnAverage {
    division: Division,
    configurations: u64,
    /// Spheres in each bin.
    counts: Vec<f64>,
    /// Those of odd intervals: the difference to even ones gives the noise of the counts.
    odd_counts: Vec<f64>,
    odd_configurations: u64,
    /// Sum of a(x) over the spheres of each bin.
    weights: Vec<f64>,
    /// Scratch memory: both for one configuration.
    sample: Vec<[f64; 2]>,
    open_end: Wall,
    /// Contact density at the open end.
    contact: WallContact,
}

impl ColumnAverage {
    /// Empty sums in the bins of a potential.
    pub(super) fn new(potential: &EffectivePotential) -> Self {
        let division = potential.division();
        Self {
            division,
            configurations: 0,
            counts: vec![0.0; division.bins],
            odd_counts: vec![0.0; division.bins],
            odd_configurations: 0,
            weights: vec![0.0; division.bins],
            sample: vec![[0.0; 2]; division.bins],
            open_end: potential.open_end(),
            contact: WallContact::default(),
        }
    }

    pub(super) fn configurations(&self) -> u64 {
        self.configurations
    }

    pub(super) fn clear(&mut self) {
        self.configurations = 0;
        self.counts.fill(0.0);
        self.odd_counts.fill(0.0);
        self.odd_configurations = 0;
        self.weights.fill(0.0);
        self.contact = WallContact::default();
    }

    /// Adds a configuration of the interval with this number. If a field of the user panics,
    /// nothing is added.
    pub(super) fn add(&mut self, frame: &Frame<'_>, interval: u64) {
        let (end, field) = (self.open_end.contact_height(frame.slab()), frame.field());
        let mut contact = self.contact;
        self.sample.fill([0.0; 2]);
        frame.for_each_height(|height| {
            let [count, weight] = &mut self.sample[self.division.bin(height)];
            *count += 1.0;
            *weight += field.acceleration(height);
            contact.add((end - height).abs());
        });
        self.configurations += 1;
        self.contact = contact;
        let sums = self.counts.iter_mut().zip(&mut self.weights);
        for ((counts, weights), [count, weight]) in sums.zip(&self.sample) {
            *counts += count;
            *weights += weight;
        }
        if !interval.is_multiple_of(2) {
            self.odd_configurations += 1;
            self.odd_counts.iter_mut().zip(&self.sample).for_each(|(counts, [count, _])| *counts += count);
        }
    }

    /// Variance of the number of spheres in a bin, from odd and even intervals; 0 if there are only
    /// odd or even ones.
    fn variance(&self, bin: usize) -> f64 {
        let odd = self.odd_configurations as f64;
        let even = self.configurations as f64 - odd;
        if odd == 0.0 || even == 0.0 {
            return 0.0;
        }
        let difference = self.odd_counts[bin] / odd - (self.counts[bin] - self.odd_counts[bin]) / even;
        odd * even * difference * difference
    }

    /// Number of spheres in each bin, summed over configurations, and P A Δx in the same units;
    /// their ratio is P/n. `end` is the pressure at the open end.
    ///
    /// The weight in the middle of a bin is the mean of those at its edges, so that n u' Δx =
    /// −Δ(P/T) holds in each bin.
    pub(super) fn counts_and_pressures(&self, width: f64, base_area: f64, end: f64) -> Vec<[f64; 2]> {
        let mut pressure = end * base_area * self.configurations as f64;
        let mut rows = vec![[0.0; 2]; self.counts.len()];
        let mut pass = |bin: usize, weight: f64| {
            rows[bin] = [self.counts[bin], (pressure + 0.5 * weight) * width];
            pressure += weight;
        };
        match self.open_end {
            Wall::Lid => (0..self.counts.len()).rev().for_each(|bin| pass(bin, self.weights[bin])),
            // From the base upwards, for a field that pulls up.
            Wall::Base => (0..self.counts.len()).for_each(|bin| pass(bin, -self.weights[bin])),
        }
        rows
    }

    /// Pressure at the open end from the contact theorem, averaged with that of the theory.
    pub(super) fn open_end_pressure<F, T: TemperatureProfile>(
        &self,
        scene: &Scene<F, T>,
        prior: &Prior,
    ) -> f64 {
        if self.configurations == 0 {
            return prior.open_end_pressure;
        }
        let temperature = scene.temperature().temperature(self.open_end.contact_height(scene.slab()));
        let area = scene.slab().base_area() * self.configurations as f64;
        let measured = temperature * self.contact.density_times_area() / area;
        let seen = self.contact.seen();
        let imagined = prior.weight * WallContact::THEORY_WEIGHT * WallContact::DEPTH * WallContact::VARIANCE;
        if seen + imagined == 0.0 {
            return 0.0;
        }
        (seen * measured + imagined * prior.open_end_pressure) / (seen + imagined)
    }

    /// P/n in each bin for a given pressure at the open end, from the counts and the weighted
    /// theory: always finite.
    ///
    /// The mean of 1/k is larger than 1/⟨k⟩ by the factor 1 + Var(k)/⟨k⟩², for k spheres counted in
    /// a bin. Without this correction the gradient term of the field is too large by that factor.
    pub(super) fn ratios<F, T>(&self, scene: &Scene<F, T>, width: f64, end: f64, prior: &Prior) -> Vec<f64> {
        let rows = self.counts_and_pressures(width, scene.slab().base_area(), end);
        let both = |(bin, ([count, pressure], ratio)): (usize, ([f64; 2], &f64))| {
            let imagined = width * prior.weight_at(distance_from_wall(scene, width, bin));
            let total = count + imagined;
            // Without counts the theory is used.
            if total == 0.0 {
                return *ratio;
            }
            let bias = self.variance(bin) / (total * total);
            (pressure + imagined * ratio) / total * (1.0 - bias).max(0.0)
        };
        rows.into_iter().zip(&prior.ratios).enumerate().map(both).collect()
    }

    /// The part of [`ratios`](Self::ratios) that was measured, averaged over the spheres of the
    /// column.
    pub(super) fn measured_share<F, T>(
        &self,
        scene: &Scene<F, T>,
        width: f64,
        prior: &Prior,
        column: &Self,
    ) -> MeasuredShare {
        MeasuredShare::of(self.counts.iter().zip(&column.counts).enumerate().map(
            |(bin, (&own, &spheres))| {
                let distance = distance_from_wall(scene, width, bin);
                let total = own + width * prior.weight_at(distance);
                let counted = if total > 0.0 { own / total } else { 0.0 };
                let closure = if distance < MeasuredShare::LAYERED { 0.0 } else { prior.measured };
                let share = counted + (1.0 - counted) * closure;
                MeasuredAt { distance, spheres, share }
            },
        ))
    }
}

/// Distance from the middle of a bin to the nearest wall.
fn distance_from_wall<F, T>(scene: &Scene<F, T>, width: f64, bin: usize) -> f64 {
    let above_base = scene.slab().lowest_center() + (bin as f64 + 0.5) * width;
    above_base.min(scene.slab().height() - above_base)
}

/// The theory of a scene, used before and together with measurements.
#[derive(Debug, Clone)]
pub(super) struct Prior {
    /// P/n = T Z in the middle of each bin; if T jumps in a bin, the mean over the jump.
    pub(super) ratios: Vec<f64>,
    /// Pressure at the open end.
    pub(super) open_end_pressure: f64,
    /// Weight of the theory, in counted spheres per diameter of height.
    pub(super) weight: f64,
    /// The part of its equation of state that the run has measured.
    pub(super) measured: f64,
}

impl Prior {
    /// Factor of the weight in the layers at a wall, which the theory does not describe.
    const WEIGHT_IN_LAYERS: f64 = 0.03;
    /// A larger relative change of the temperature within a bin is treated as a jump.
    const SUDDEN: f64 = 0.1;

    /// Weight of the theory, in counted spheres per diameter of height, at a distance from the
    /// nearest wall.
    fn weight_at(&self, distance: f64) -> f64 {
        if distance < MeasuredShare::LAYERED { Self::WEIGHT_IN_LAYERS * self.weight } else { self.weight }
    }

    pub(super) fn new<F: Field, T: TemperatureProfile>(
        scene: &Scene<F, T>,
        potential: &EffectivePotential,
        equation_of_state: &impl EquationOfState,
        weight: f64,
    ) -> Result<Self, Error> {
        let profile = scene.hydrostatics(equation_of_state)?;
        let temperature = |height: f64| scene.temperature().temperature(height);
        let ratio = |height: f64| {
            let factor = equation_of_state.compressibility_factor(profile.packing_fraction(height));
            temperature(height) * factor
        };
        let half = 0.5 * potential.bin_width();
        let in_bin = |height: f64| {
            let inverses = [height - half, height + half].map(|edge| 1.0 / temperature(edge));
            if (libm::log(inverses[0]) - libm::log(inverses[1])).abs() < Self::SUDDEN {
                return ratio(height);
            }
            mean_over_jump(equation_of_state, profile.pressure(height), inverses)
                .unwrap_or_else(|| ratio(height))
        };
        let ratios = potential.heights().map(in_bin).collect();
        let open_end_pressure = match scene.open_end() {
            Wall::Lid => profile.lid_pressure(),
            Wall::Base => profile.base_pressure(),
        };
        Ok(Self { ratios, open_end_pressure, weight, measured: 0.0 })
    }
}

/// Mean of P/n over 1/T between two temperatures at one pressure, for a bin in which T jumps.
/// `None` if the equation of state does not reach this pressure.
fn mean_over_jump(
    equation_of_state: &impl EquationOfState,
    pressure: f64,
    [below, above]: [f64; 2],
) -> Option<f64> {
    const NODES: u32 = 32;
    let ratio = |node: u32| {
        let inverse = below + (above - below) * (f64::from(node) + 0.5) / f64::from(NODES);
        let eta = equation_of_state.packing_fraction_at(pressure * inverse, None)?;
        Some(equation_of_state.compressibility_factor(eta) / inverse)
    };
    let sum = (0..NODES).map(ratio).sum::<Option<f64>>()?;
    let mean = sum / f64::from(NODES);
    mean.is_finite().then_some(mean)
}

/// The density of centers in contact with a wall, extrapolated from the nearest 0.2 diameters.
///
/// It is the mean over the spheres of a weight that is orthogonal to z, z² and z³ in this range,
/// where z is the distance from contact. It is exact for a cubic n(z), and accurate to 0.4 % for
/// the steepest profile of a fluid, e^{−8z}.
#[derive(Debug, Clone, Copy, Default)]
#[cfg_attr(feature = "checkpoint", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct WallContact {
    weights: f64,
    seen: f64,
}

impl WallContact {
    const DEPTH: f64 = 0.2;
    /// Variance of the extrapolated density over that of the mean density in this range. The same
    /// error needs this factor more spheres.
    const VARIANCE: f64 = 16.0;
    /// Factor of the weight of the theory for the pressure at the open end, because the theory is
    /// more accurate for this pressure in a closed box than for the density at a height.
    const THEORY_WEIGHT: f64 = 10.0;

    /// Adds a sphere whose center is at this `distance` from contact.
    #[inline]
    pub(crate) fn add(&mut self, distance: f64) {
        if distance < Self::DEPTH {
            let part = distance / Self::DEPTH;
            self.weights += (16.0 - part * (120.0 - part * (240.0 - 140.0 * part))) / Self::DEPTH;
            self.seen += 1.0;
        }
    }

    /// The contact density, times area and number of configurations.
    pub(crate) fn density_times_area(&self) -> f64 {
        self.weights
    }

    /// Effective number of spheres for its statistical error.
    fn seen(&self) -> f64 {
        self.seen
    }
}

persist!(
    ColumnAverage {
        same division,
        same open_end,
        count configurations,
        slice counts,
        slice odd_counts,
        count odd_configurations,
        slice weights,
        value contact,
    },
    |average| average.odd_configurations <= average.configurations
);
persist!(Prior { slice ratios, value open_end_pressure, same weight, value measured });

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Slab;
    use crate::centers::Centers;
    use crate::equation_of_state::ModifiedKolafa;
    use crate::field::UniformField;
    use crate::frame::{MoveCounts, Phase, Still};
    use crate::random::{Generator, unit};
    use crate::statistics::Estimate;
    use crate::temperature::ExponentialTemperature;
    use rand::SeedableRng;
    use std::panic::{AssertUnwindSafe, catch_unwind};

    /// If the density is that of the theory, the field is that of the closure.
    #[test]
    fn what_the_theory_counts_is_what_the_closure_says() {
        let slab = Slab::new(120.0, 6.0, 6.0).unwrap();
        let temperature = ExponentialTemperature::new(12.0, 0.03).unwrap();
        let scene = Scene::new(slab, 900, UniformField::default(), temperature).unwrap();
        let worst = |width: f64| {
            let potential = EffectivePotential::new(&scene, width).unwrap();
            let prior = Prior::new(&scene, &potential, &ModifiedKolafa, 1e-9).unwrap();
            let theory = scene.hydrostatics(&ModifiedKolafa).unwrap();
            let mut average = ColumnAverage::new(&potential);
            average.configurations = 1;
            for (bin, height) in potential.heights().enumerate() {
                let (low, high) = (height - 0.5 * width, height + 0.5 * width);
                let spheres = 36.0 * (theory.column_above(low) - theory.column_above(high));
                (average.counts[bin], average.weights[bin]) = (spheres, spheres);
            }
            let ratios = average.ratios(&scene, potential.bin_width(), prior.open_end_pressure, &prior);
            let dense = potential.heights().zip(ratios.iter().zip(&prior.ratios));
            dense
                .filter(|(height, _)| theory.number_density(*height) > 1e-4)
                .map(|(_, (counted, closed))| (counted / closed - 1.0).abs())
                .fold(0.0, f64::max)
        };
        let (coarse, fine) = (worst(0.5), worst(0.125));
        assert!(coarse < 0.02 && fine < coarse / 8.0 + 1e-9, "{coarse}, {fine}");
    }

    /// Poisson counts of two intervals, at one pressure, in many bins.
    #[test]
    fn the_noise_of_counts_does_not_change_the_mean_of_p_over_n() {
        let slab = Slab::new(2001.0, 4.0, 4.0).unwrap();
        let temperature = ExponentialTemperature::new(12.0, 1e-4).unwrap();
        let scene = Scene::new(slab, 900, UniformField::default(), temperature).unwrap();
        let potential = EffectivePotential::new(&scene, 0.1).unwrap();
        let prior = Prior::new(&scene, &potential, &ModifiedKolafa, 1e-9).unwrap();
        let mut generator = Generator::seed_from_u64(5);
        let mut poisson = |mean: f64| {
            let (mut count, mut product) = (-1.0, 1.0);
            while product > libm::exp(-mean) {
                product *= unit(&mut generator);
                count += 1.0;
            }
            count
        };
        // The mean of P/n, relative to that of counts without noise, and its error.
        let mut mean = |corrected: bool, configurations: [u64; 2]| {
            let mut average = ColumnAverage::new(&potential);
            average.configurations = configurations[0] + configurations[1];
            for bin in 0..potential.bins() {
                let [even, odd] = configurations.map(|number| poisson(0.5 * number as f64));
                (average.counts[bin], average.odd_counts[bin]) = (even + odd, odd);
            }
            average.odd_configurations = if corrected { configurations[1] } else { 0 };
            let ratios = average.ratios(&scene, potential.bin_width(), 1.0, &prior);
            let exact = 16.0 * potential.bin_width() / 0.5;
            let (count, sum) = (ratios.len() as f64, ratios.iter().sum::<f64>() / exact);
            let squares: f64 = ratios.iter().map(|ratio| (ratio / exact).powi(2)).sum();
            let variance = squares / count - (sum / count).powi(2);
            Estimate::new(sum / count, (variance / count).sqrt())
        };
        // 80 spheres: 1 + 1/80, and what is left is of second order.
        for configurations in [[80, 80], [120, 40]] {
            let [noisy, corrected] = [false, true].map(|corrected| mean(corrected, configurations));
            assert!(noisy.standard_error < 0.0012 && corrected.standard_error < 0.0012, "{corrected}");
            assert!(noisy.deviation_from(1.0 + 1.0 / 80.0).abs() < 4.0, "{noisy}");
            assert!(corrected.deviation_from(1.0).abs() < 4.0, "{corrected}");
        }
    }

    /// A uniform field that fails above a height.
    struct Fails(f64);

    impl Field for Fails {
        fn potential(&self, height: f64) -> f64 {
            height
        }
        fn acceleration(&self, height: f64) -> f64 {
            assert!(height < self.0, "a fault of the user's own");
            1.0
        }
    }

    #[test]
    fn a_configuration_is_added_as_a_whole_or_not_at_all() {
        let slab = Slab::new(40.0, 5.0, 5.0).unwrap();
        let temperature = ExponentialTemperature::new(12.0, 0.03).unwrap();
        let scene = Scene::new(slab, 4, UniformField::default(), temperature).unwrap();
        let potential = EffectivePotential::new(&scene, 0.5).unwrap();
        let mut average = ColumnAverage::new(&potential);
        let positions = [0.5, 3.0, 39.4, 39.45].map(|height| [height, 1.0, 1.0]);
        let mut add = |field: &dyn Field| {
            let scene = Scene::unchecked(slab, 4, field, temperature);
            let frame = Frame {
                scene: scene.as_any(),
                potential: &Still(0),
                centers: Centers::listed(&positions),
                sweep: 1,
                phase: Phase::Equilibration,
                sweep_of_phase: 1,
                move_counts: &MoveCounts::default(),
            };
            let added = catch_unwind(AssertUnwindSafe(|| average.add(&frame, 0)));
            let counts: f64 = average.counts.iter().sum();
            let weights: f64 = average.weights.iter().sum();
            let expected = 4.0 * average.configurations as f64;
            assert_eq!([counts, weights].map(f64::to_bits), [expected.to_bits(); 2]);
            (added.is_ok(), average.configurations, average.contact.seen)
        };
        assert_eq!(add(&Fails(50.0)), (true, 1, 2.0));
        assert_eq!(add(&Fails(39.42)), (false, 1, 2.0));
        assert_eq!(add(&Fails(50.0)), (true, 2, 4.0));
    }

    #[test]
    fn the_contact_density_is_extrapolated() {
        // Densities as sums over many points.
        let contact = |density: fn(f64) -> f64| {
            let (points, depth) = (200_000, 0.4);
            let mut sum = 0.0;
            for point in 0..points {
                let distance = (f64::from(point) + 0.5) * depth / f64::from(points);
                let mut one = WallContact::default();
                one.add(distance);
                sum += density(distance) * one.density_times_area() * depth / f64::from(points);
            }
            sum
        };
        approx::assert_relative_eq!(contact(|_| 3.0), 3.0, max_relative = 1e-6);
        approx::assert_relative_eq!(
            contact(|z| 3.0 - 5.0 * z + z * z - 2.0 * z * z * z),
            3.0,
            max_relative = 1e-5
        );
        approx::assert_relative_eq!(contact(|z| (-8.0 * z).exp()), 1.0, max_relative = 5e-3);
        approx::assert_relative_eq!(contact(|z| (-4.0 * z).exp()), 1.0, max_relative = 3e-4);
    }
}
