//! The accuracy that is asked of a model: of which quantity, how large an error, and where.

use crate::{Error, Field, HydrostaticProfile, Scene, Slab, TemperatureProfile, Wall};
use std::fmt;
use std::ops::Range;

/// A quantity that a model predicts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Quantity {
    /// n(x): the error is the [`total_variation_distance`].
    Density,
    /// P(x), the weight per area of the spheres between x and the [open end](Scene::open_end), ∫ n
    /// dφ: the error is relative.
    Pressure,
    /// Z(x) = P/(nT): the error is relative.
    CompressibilityFactor,
}

impl Quantity {
    /// All quantities.
    pub const ALL: [Self; 3] = [Self::Density, Self::Pressure, Self::CompressibilityFactor];
}

/// A quantity, the largest tolerated error, and the range of heights.
///
/// All profiles are averages over bins one diameter high. The first bin is at the wall on which the
/// column rests, opposite the [open end](Scene::open_end): at x = 0 if the field pulls down. The
/// error of n is the share of the spheres at a wrong height. The error of P and Z is the root mean
/// square of the relative deviation over the bins. Only bins count whose middle lies in the range
/// of heights. Without a range all bins count for n; for P and Z the first bin does not count, nor
/// do those at the open end that hold the last hundredth of the spheres.
///
/// ```
/// use gradient_mc::model::Accuracy;
/// use gradient_mc::{Scene, Slab, field::UniformField, temperature::Isothermal};
/// let scene = Scene::new(Slab::new(60.0, 20.0, 20.0)?, 1600, UniformField::default(), Isothermal::new(5.0)?)?;
/// // P to a per cent between the fifth and the twentieth diameter.
/// let choice = scene.model_for(Accuracy::pressure(0.01)?.between(5.0, 20.0)?)?;
/// println!("{choice}");
/// assert!(Accuracy::density(1.0).is_err());
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Accuracy {
    quantity: Quantity,
    tolerance: f64,
    range: Option<[f64; 2]>,
}

impl Accuracy {
    /// Share of the spheres at the open end whose bins do not count by default.
    const BEYOND: f64 = 0.01;

    /// n with at most this share of the spheres at a wrong height.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] unless the tolerance lies between 0 and 1.
    pub fn density(tolerance: f64) -> Result<Self, Error> {
        Self::new(Quantity::Density, tolerance)
    }

    /// P with at most this relative deviation.
    ///
    /// # Errors
    /// As [`density`](Self::density).
    pub fn pressure(tolerance: f64) -> Result<Self, Error> {
        Self::new(Quantity::Pressure, tolerance)
    }

    /// Z = P/(nT) with at most this relative deviation.
    ///
    /// # Errors
    /// As [`density`](Self::density).
    pub fn compressibility_factor(tolerance: f64) -> Result<Self, Error> {
        Self::new(Quantity::CompressibilityFactor, tolerance)
    }

    /// Any quantity with at most this error.
    ///
    /// # Errors
    /// As [`density`](Self::density).
    pub fn new(quantity: Quantity, tolerance: f64) -> Result<Self, Error> {
        if !(tolerance > 0.0 && tolerance < 1.0) {
            let requirement = "it must lie between 0 and 1";
            return Err(Error::InvalidParameter { name: "tolerance", value: tolerance, requirement });
        }
        Ok(Self { quantity, tolerance, range: None })
    }

    /// Limits the range to bins between two heights. The error of n is then relative to the spheres
    /// in this range.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] unless both are finite and the second is larger.
    pub fn between(self, lowest: f64, highest: f64) -> Result<Self, Error> {
        let lowest = Error::require_finite("lowest height", lowest)?;
        let highest = Error::require_finite("highest height", highest)?;
        if highest <= lowest {
            let requirement = "it must be above the lowest height";
            return Err(Error::InvalidParameter { name: "highest height", value: highest, requirement });
        }
        Ok(Self { range: Some([lowest, highest]), ..self })
    }

    /// The quantity.
    #[must_use]
    pub fn quantity(&self) -> Quantity {
        self.quantity
    }

    /// The largest tolerated error.
    #[must_use]
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// The error of the profile of a model. Both profiles are given as [`densities`].
    ///
    /// It is not finite if the true profile has no spheres in the range.
    #[must_use]
    pub fn error<F: Field, T: TemperatureProfile>(
        &self,
        scene: &Scene<F, T>,
        model: &[f64],
        truth: &[f64],
    ) -> f64 {
        let bins = self.bins(scene, truth);
        if self.quantity == Quantity::Density {
            return total_variation_distance(part(model, &bins), part(truth, &bins));
        }
        let [model_pressures, true_pressures] = [model, truth].map(|profile| pressures(scene, profile));
        let ratio = |bin: usize| {
            let pressures = model_pressures[bin] / true_pressures[bin];
            match self.quantity {
                Quantity::CompressibilityFactor => pressures * truth[bin] / model[bin],
                _ => pressures,
            }
        };
        let count = bins.len() as f64;
        (bins.map(|bin| (ratio(bin) - 1.0) * (ratio(bin) - 1.0)).sum::<f64>() / count).sqrt()
    }

    /// The expected statistical error of a profile that is averaged over `samples` independent
    /// spheres, for large `samples`.
    ///
    /// Let p be the share of the spheres in a bin and f the weight of a sphere. The error of n is ½
    /// √(2/π) Σ √(p(1 − p)/samples) / Σ p. That of P is the root mean square over the bins of the
    /// relative standard deviation of Σ f p, summed from the bin to the open end. That of Z is the
    /// same for (Σ f p)/p.
    #[must_use]
    pub fn noise<F: Field, T: TemperatureProfile>(
        &self,
        scene: &Scene<F, T>,
        profile: &[f64],
        samples: f64,
    ) -> f64 {
        let bins = self.bins(scene, profile);
        let all: f64 = profile.iter().sum();
        let part = |bin: usize| profile[bin] / all;
        if self.quantity == Quantity::Density {
            let deviations =
                bins.clone().map(|bin| (part(bin) * (1.0 - part(bin)) / samples).max(0.0).sqrt());
            let mean = 0.5 * std::f64::consts::FRAC_2_PI.sqrt() * deviations.sum::<f64>();
            return mean / bins.map(part).sum::<f64>();
        }
        let (mut weight, mut squares, mut variances) = (0.0, 0.0, 0.0);
        for bin in (bins.start..profile.len()).rev() {
            let (part, [whole, outer]) = (part(bin), weights(scene, bin));
            if bins.contains(&bin) {
                let pressure = weight + part * outer;
                variances += if self.quantity == Quantity::CompressibilityFactor {
                    let own = outer / pressure - 1.0 / part;
                    squares / (pressure * pressure) + part * own * own
                } else {
                    (squares + part * outer * outer) / (pressure * pressure) - 1.0
                };
            }
            weight += part * whole;
            squares += part * whole * whole;
        }
        (variances.max(0.0) / (bins.len() as f64 * samples)).sqrt()
    }

    /// The bins of a profile that count.
    pub(super) fn bins<F: Field, T: TemperatureProfile>(
        &self,
        scene: &Scene<F, T>,
        profile: &[f64],
    ) -> Range<usize> {
        let count = profile.len();
        if let Some([lowest, highest]) = self.range {
            let (near, far) = match scene.open_end() {
                Wall::Lid => (lowest, highest),
                Wall::Base => (scene.slab().height() - highest, scene.slab().height() - lowest),
            };
            // The bins whose middle lies between the two heights.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let [first, end] = [(near - 0.5).ceil(), (far - 0.5).floor() + 1.0]
                .map(|bin| bin.clamp(0.0, count as f64) as usize);
            return first..end.max(first);
        }
        if self.quantity == Quantity::Density {
            return 0..count;
        }
        let enough = Self::BEYOND * profile.iter().sum::<f64>();
        let mut beyond = 0.0;
        let thin = profile.iter().rev().take_while(|&&density| {
            beyond += density;
            beyond < enough
        });
        1..(count - thin.count()).max(1)
    }
}

impl fmt::Display for Accuracy {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let tolerance = Percent(self.tolerance);
        match self.quantity {
            Quantity::Density => write!(formatter, "all but {tolerance} of the spheres in place"),
            Quantity::Pressure => write!(formatter, "P to {tolerance}"),
            Quantity::CompressibilityFactor => write!(formatter, "Z to {tolerance}"),
        }?;
        self.range
            .map_or(Ok(()), |[lowest, highest]| write!(formatter, " between x = {lowest} and {highest}"))
    }
}

/// The bins of a profile, which may end earlier.
fn part<'a>(profile: &'a [f64], bins: &Range<usize>) -> &'a [f64] {
    &profile[bins.start.min(profile.len())..bins.end.min(profile.len())]
}

/// P at the middle of each bin: the weight of the spheres between it and the open end.
fn pressures<F: Field, T: TemperatureProfile>(scene: &Scene<F, T>, profile: &[f64]) -> Vec<f64> {
    let mut beyond = 0.0;
    let mut pressures: Vec<f64> = profile
        .iter()
        .enumerate()
        .rev()
        .map(|(bin, density)| {
            let [whole, outer] = weights(scene, bin);
            let pressure = beyond + density * outer;
            beyond += density * whole;
            pressure
        })
        .collect();
    pressures.reverse();
    pressures
}

/// The mean weight of a sphere in a bin, and the part of it that comes from the outer half, which
/// counts for P at the middle.
fn weights<F: Field, T: TemperatureProfile>(scene: &Scene<F, T>, bin: usize) -> [f64; 2] {
    let near = bin as f64;
    let far = (near + 1.0).min(scene.slab().height());
    let potential = |distance: f64| scene.field().potential(height(scene, distance));
    let width = far - near;
    [(potential(far) - potential(near)) / width, (potential(far) - potential(0.5 * (near + far))) / width]
}

/// The height at a distance from the wall on which the column rests.
pub(super) fn height<F: Field, T: TemperatureProfile>(scene: &Scene<F, T>, distance: f64) -> f64 {
    match scene.open_end() {
        Wall::Lid => distance,
        Wall::Base => scene.slab().height() - distance,
    }
}

/// ½ ∫ |n′ − n| dx / ∫ n dx of two profiles, n′ of a model and n, given in the same bins: the share
/// of the spheres that would have to be moved to another bin.
///
/// It bounds the error of the pressure. In a uniform field P(x)/P(base) = 1 − F(x), where F is the
/// cumulative distribution of heights, so the error of P relative to the base is |F′ − F|. At the
/// edge of a bin this is the sum of n′ − n over the bins below, over N/A. If both profiles have the
/// same number of spheres, it is also minus the sum over the bins above, so it is at most half the
/// sum of |n′ − n|.
///
/// A profile that ends earlier is continued with zeros. The result is not finite if `truth` is
/// empty.
///
/// ```
/// use gradient_mc::model::total_variation_distance;
/// // A tenth of the spheres is one bin too high.
/// assert!((total_variation_distance(&[0.5, 0.4, 0.1], &[0.6, 0.3, 0.1]) - 0.1).abs() < 1e-15);
/// ```
#[must_use]
pub fn total_variation_distance(model: &[f64], truth: &[f64]) -> f64 {
    let at = |profile: &[f64], bin: usize| profile.get(bin).copied().unwrap_or(0.0);
    let bins = model.len().max(truth.len());
    let difference: f64 = (0..bins).map(|bin| (at(model, bin) - at(truth, bin)).abs()).sum();
    0.5 * difference / truth.iter().sum::<f64>()
}

/// Number densities of a theory profile averaged over bins one diameter high, from the wall on
/// which the column of `scene` rests to its [open end](Scene::open_end), with full relative
/// precision also where few spheres are left. The last bin is treated as a whole diameter, so that
/// the sum is N/A.
///
/// ```
/// use gradient_mc::equation_of_state::ModifiedKolafa;
/// use gradient_mc::{Scene, Slab, field::UniformField, temperature::Isothermal};
/// let scene = Scene::new(Slab::new(100.0, 5.0, 5.0)?, 250, UniformField::default(), Isothermal::new(5.0)?)?;
/// let densities = gradient_mc::model::densities(&scene, &scene.hydrostatics(&ModifiedKolafa)?);
/// assert_eq!(densities.len(), 100);
/// assert!((densities.iter().sum::<f64>() - 10.0).abs() < 1e-9);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[must_use]
pub fn densities<F: Field, T: TemperatureProfile>(
    scene: &Scene<F, T>,
    profile: &HydrostaticProfile,
) -> Vec<f64> {
    let slab = scene.slab();
    let beyond = |edge: usize| {
        let height = height(scene, (edge as f64).min(slab.height()));
        match scene.open_end() {
            Wall::Lid => profile.column_above(height),
            Wall::Base => profile.column_below(height),
        }
    };
    let mut last = beyond(0);
    (1..=bins(slab))
        .map(|edge| {
            let here = beyond(edge);
            let density = last - here;
            last = here;
            density
        })
        .collect()
}

/// Number of bins one diameter high in a slab.
pub(super) fn bins(slab: &Slab) -> usize {
    // Heights are at most 1e6.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let bins = slab.height().ceil() as usize;
    bins
}

/// A fraction in per cent, with two figures.
pub(super) struct Percent(pub(super) f64);

impl fmt::Display for Percent {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = 100.0 * self.0;
        match percent.abs() {
            10.0.. => write!(formatter, "{percent:.0} %"),
            1.0..10.0 => write!(formatter, "{percent:.1} %"),
            0.1..1.0 => write!(formatter, "{percent:.2} %"),
            0.001..0.1 => write!(formatter, "{percent:.3} %"),
            _ => write!(formatter, "{percent:.0e} %"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::UniformField;
    use crate::temperature::Isothermal;

    #[test]
    fn it_is_a_distance_between_zero_and_one() {
        let (first, second) = ([0.2, 0.3, 0.5], [0.5, 0.3, 0.2]);
        approx::assert_relative_eq!(total_variation_distance(&first, &second), 0.3, epsilon = 1e-15);
        approx::assert_relative_eq!(total_variation_distance(&second, &first), 0.3, epsilon = 1e-15);
        assert!(total_variation_distance(&first, &first).abs() < 1e-15);
        // Profiles without overlap, of different lengths.
        approx::assert_relative_eq!(total_variation_distance(&[1.0], &[0.0, 1.0]), 1.0, epsilon = 1e-15);
        assert!(!total_variation_distance(&[1.0], &[]).is_finite());
    }

    #[test]
    fn the_pressure_is_no_worse() {
        // Any two profiles: here pseudo-random ones.
        for seed in 0..50_u32 {
            let profile = |shift: u32| {
                let raw: Vec<f64> =
                    (0..20).map(|bin| f64::from((bin * 7919 + seed * 104_729 + shift) % 1009)).collect();
                let sum: f64 = raw.iter().sum();
                raw.iter().map(|value| value / sum).collect::<Vec<f64>>()
            };
            let (first, second) = (profile(0), profile(541));
            let mut difference = 0.0_f64;
            let kolmogorov = first
                .iter()
                .zip(&second)
                .map(|(a, b)| {
                    difference += a - b;
                    difference.abs()
                })
                .fold(0.0, f64::max);
            assert!(kolmogorov <= total_variation_distance(&first, &second) + 1e-12);
        }
    }

    /// Four bins in a field of 2: P is twice the number of spheres above the middle.
    #[test]
    fn pressure_is_the_weight_above() {
        let scene = Scene::new(
            Slab::new(3.5, 4.0, 4.0).unwrap(),
            16,
            UniformField::new(2.0).unwrap(),
            Isothermal::new(1.0).unwrap(),
        )
        .unwrap();
        let truth = [0.4, 0.3, 0.2, 0.1];
        for (found, expected) in pressures(&scene, &truth).into_iter().zip([1.6, 0.9, 0.4, 0.1]) {
            approx::assert_relative_eq!(found, expected, max_relative = 1e-14);
        }
        let model = [0.4, 0.2, 0.3, 0.1];
        let error = |accuracy: Accuracy| accuracy.between(1.0, 3.0).unwrap().error(&scene, &model, &truth);
        // P is 1.0 and 0.5 instead of 0.9 and 0.4.
        let [first, second] = [1.0 / 0.9, 0.5 / 0.4];
        let expected = (0.5 * ((first - 1.0_f64).powi(2) + (second - 1.0_f64).powi(2))).sqrt();
        approx::assert_relative_eq!(error(Accuracy::pressure(0.1).unwrap()), expected, max_relative = 1e-12);
        let [first, second] = [first * 1.5, second / 1.5];
        let expected = (0.5 * ((first - 1.0_f64).powi(2) + (second - 1.0_f64).powi(2))).sqrt();
        let factor = Accuracy::compressibility_factor(0.1).unwrap();
        approx::assert_relative_eq!(error(factor), expected, max_relative = 1e-12);
        // A fifth of the spheres there is in the other bin.
        approx::assert_relative_eq!(error(Accuracy::density(0.1).unwrap()), 0.2, max_relative = 1e-12);
    }

    #[test]
    fn what_cannot_be_asked_is_refused() {
        for quantity in Quantity::ALL {
            for tolerance in [0.0, -1.0, 1.0, f64::NAN, f64::INFINITY] {
                let refused = Accuracy::new(quantity, tolerance);
                assert!(matches!(refused, Err(Error::InvalidParameter { name: "tolerance", .. })));
            }
            let accuracy = Accuracy::new(quantity, 0.5).unwrap();
            for [lowest, highest] in [[1.0, 1.0], [2.0, 1.0], [f64::NAN, 1.0], [0.0, f64::INFINITY]] {
                assert!(matches!(accuracy.between(lowest, highest), Err(Error::InvalidParameter { .. })));
            }
        }
    }
}
