//! What is measured of a column: n, P and the center of mass, with errors.

use gradient_mc::statistics::BlockAverages;
use gradient_mc::{Frame, Observer, ObserverError};
use paper::Failure;
use paper::accuracy::{self, BIN_HEIGHT};

/// Spheres per area of the base, N/A, of all three systems.
pub(crate) const COLUMN_DENSITY: f64 = 40.0;
/// Height of the slab.
pub(crate) const HEIGHT: f64 = 400.0;
/// Bins one diameter high.
pub(crate) const BINS: usize = 400;

/// Values in every bin, upwards, and their standard errors; of a theory these are zero.
#[derive(Debug, Clone, Default, serde::Serialize, serde::Deserialize)]
pub(crate) struct Profile {
    /// Means of n over the bins.
    pub(crate) density: Vec<f64>,
    pub(crate) density_errors: Vec<f64>,
    /// P at the middles of the bins.
    pub(crate) pressure: Vec<f64>,
    pub(crate) pressure_errors: Vec<f64>,
    pub(crate) center_of_mass: f64,
    pub(crate) center_of_mass_error: f64,
}

/// The middle of a bin.
pub(crate) fn middle(bin: usize) -> f64 {
    (bin as f64 + 0.5) * BIN_HEIGHT
}

impl Profile {
    /// Not a number at any height.
    pub(crate) fn unknown() -> Self {
        let none = vec![f64::NAN; BINS];
        Self { density: none.clone(), pressure: none, center_of_mass: f64::NAN, ..Self::default() }
    }

    /// Replaces n, P and the center of mass by those of `other`, n and P from `height` up.
    pub(crate) fn take_above(&mut self, other: &Self, height: f64) {
        for bin in (0..BINS).filter(|&bin| bin as f64 * BIN_HEIGHT >= height) {
            (self.density[bin], self.pressure[bin]) = (other.density[bin], other.pressure[bin]);
        }
        self.center_of_mass = other.center_of_mass;
    }

    /// The mean of independent profiles, with errors from their estimated errors.
    pub(crate) fn mean(profiles: &[&Self]) -> Self {
        let count = profiles.len() as f64;
        let mean =
            |of: &dyn Fn(&Self) -> f64| profiles.iter().map(|profile| of(profile)).sum::<f64>() / count;
        let error = |of: &dyn Fn(&Self) -> f64| {
            profiles.iter().map(|profile| of(profile) * of(profile)).sum::<f64>().sqrt() / count
        };
        Self {
            density: (0..BINS).map(|bin| mean(&|profile| profile.density[bin])).collect(),
            density_errors: (0..BINS).map(|bin| error(&|profile| profile.density_errors[bin])).collect(),
            pressure: (0..BINS).map(|bin| mean(&|profile| profile.pressure[bin])).collect(),
            pressure_errors: (0..BINS).map(|bin| error(&|profile| profile.pressure_errors[bin])).collect(),
            center_of_mass: mean(&|profile| profile.center_of_mass),
            center_of_mass_error: error(&|profile| profile.center_of_mass_error),
        }
    }

    /// The mean of independent profiles, with errors from their scatter.
    pub(crate) fn mean_with_scatter(profiles: &[&Self]) -> Self {
        let mean = Self::mean(profiles);
        let count = profiles.len() as f64;
        let scatter = |center: f64, of: &dyn Fn(&Self) -> f64| {
            let squares: f64 =
                profiles.iter().map(|profile| (of(profile) - center) * (of(profile) - center)).sum();
            (squares / (count * (count - 1.0))).sqrt()
        };
        Self {
            density_errors: (0..BINS)
                .map(|bin| scatter(mean.density[bin], &|profile| profile.density[bin]))
                .collect(),
            pressure_errors: (0..BINS)
                .map(|bin| scatter(mean.pressure[bin], &|profile| profile.pressure[bin]))
                .collect(),
            center_of_mass_error: scatter(mean.center_of_mass, &|profile| profile.center_of_mass),
            ..mean
        }
    }

    /// The estimated errors of this profile.
    pub(crate) fn claims(&self) -> Errors {
        let base = self.pressure.first().copied().unwrap_or(f64::NAN);
        let relative = |errors: &[f64], values: &[f64]| -> Vec<f64> {
            errors.iter().zip(values).map(|(error, value)| 1.0 + error / value).collect()
        };
        let ones = vec![1.0; BINS];
        Errors {
            misplaced: accuracy::expected_total_variation_distance(&self.density_errors, COLUMN_DENSITY),
            pressure: self.pressure_errors.iter().copied().fold(0.0, f64::max) / base,
            bulk_density: accuracy::bulk_deviation(
                &relative(&self.density_errors, &self.density),
                &ones,
                &self.density,
            ),
            bulk_pressure: accuracy::bulk_deviation(
                &relative(&self.pressure_errors, &self.pressure),
                &ones,
                &self.density,
            ),
            center_of_mass: self.center_of_mass_error / self.center_of_mass,
        }
    }

    /// The errors of this profile compared with a reference.
    pub(crate) fn errors(&self, reference: &Self) -> Errors {
        Errors {
            misplaced: accuracy::total_variation_distance(&self.density, &reference.density, COLUMN_DENSITY),
            pressure: accuracy::pressure_deviation(&self.pressure, &reference.pressure),
            bulk_density: accuracy::bulk_deviation(&self.density, &reference.density, &reference.density),
            bulk_pressure: accuracy::bulk_deviation(&self.pressure, &reference.pressure, &reference.density),
            center_of_mass: (self.center_of_mass / reference.center_of_mass - 1.0).abs(),
        }
    }
}

/// True or estimated errors of a profile; definitions in `paper::accuracy`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Errors {
    /// Of n: the fraction of the spheres at a wrong height.
    pub(crate) misplaced: f64,
    /// Of P: the largest deviation, over P at the base.
    pub(crate) pressure: f64,
    /// Root mean square of the relative errors over the bulk.
    pub(crate) bulk_density: f64,
    pub(crate) bulk_pressure: f64,
    /// Relative.
    pub(crate) center_of_mass: f64,
}

impl Errors {
    /// Root mean squares over replicas.
    pub(crate) fn root_mean_square(all: &[Self]) -> Self {
        let over = |of: fn(&Self) -> f64| accuracy::root_mean_square(all.iter().map(of));
        Self {
            misplaced: over(|errors| errors.misplaced),
            pressure: over(|errors| errors.pressure),
            bulk_density: over(|errors| errors.bulk_density),
            bulk_pressure: over(|errors| errors.bulk_pressure),
            center_of_mass: over(|errors| errors.center_of_mass),
        }
    }
}

/// Looks at a column.
#[derive(Debug)]
pub(crate) struct ColumnObserver {
    /// Numbers and weights in bins half a diameter high.
    counts: Vec<f64>,
    weights: Vec<f64>,
    /// Numbers in the bins, weights above their middles, and the sum of all heights.
    sample: Vec<f64>,
    averages: BlockAverages,
}

impl ColumnObserver {
    pub(crate) fn new() -> Result<Self, Failure> {
        Ok(Self {
            counts: vec![0.0; 2 * BINS],
            weights: vec![0.0; 2 * BINS],
            sample: vec![0.0; 2 * BINS + 1],
            averages: BlockAverages::new(2 * BINS + 1)?,
        })
    }

    /// The means over all frames; the pressure on the lid is added to the weights.
    pub(crate) fn profile(
        &self,
        base_area: f64,
        particles: usize,
        lid_pressure: f64,
    ) -> Result<Profile, Failure> {
        let estimates = self.averages.estimates()?;
        let volume = base_area * BIN_HEIGHT;
        let (numbers, rest) = estimates.split_at(BINS);
        let (weights, heights) = rest.split_at(BINS);
        let heights = heights.first().ok_or("the sum of heights is measured")?;
        Ok(Profile {
            density: numbers.iter().map(|count| count.mean / volume).collect(),
            density_errors: numbers.iter().map(|count| count.standard_error / volume).collect(),
            pressure: weights.iter().map(|weight| weight.mean / base_area + lid_pressure).collect(),
            pressure_errors: weights.iter().map(|weight| weight.standard_error / base_area).collect(),
            center_of_mass: heights.mean / particles as f64,
            center_of_mass_error: heights.standard_error / particles as f64,
        })
    }
}

impl Observer for ColumnObserver {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.counts.fill(0.0);
        self.weights.fill(0.0);
        let field = frame.field();
        let mut sum = 0.0;
        for height in frame.heights() {
            // Heights lie in the slab.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let half = ((2.0 * height / BIN_HEIGHT) as usize).min(2 * BINS - 1);
            self.counts[half] += 1.0;
            self.weights[half] += field.acceleration(height);
            sum += height;
        }
        let mut above = 0.0;
        for bin in (0..BINS).rev() {
            above += self.weights[2 * bin + 1];
            self.sample[BINS + bin] = above;
            above += self.weights[2 * bin];
            self.sample[bin] = self.counts[2 * bin] + self.counts[2 * bin + 1];
        }
        self.sample[2 * BINS] = sum;
        self.averages.push(&self.sample)?;
        Ok(())
    }
}
