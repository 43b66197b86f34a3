//! The error of a model: which fraction of the spheres it puts where they are not.

use crate::Slab;

/// ½ ∫ |n′ − n| dx / ∫ n dx of two profiles, n′ of a model and n, given in the same bins: the fraction of the spheres that would have to
/// be moved to another bin.
///
/// It is the total-variation distance of two distributions of heights. In a uniform field the pressure
/// is the weight above, P(x)/P(base) = 1 − F(x) with F the cumulative distribution of heights, so that the error of P relative to the
/// base is |F′ − F|. At any edge of a bin this is the sum of (n′ − n) over the bins below, over N/A; by
/// conservation of spheres also minus the sum over those above, so it is at most half the sum of the absolute values: the Kolmogorov distance
/// never exceeds the total variation.
///
/// Only the shapes count where both hold the same number of spheres. A profile that ends earlier goes on with zeros. Not finite if `truth` holds nothing.
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

/// Number densities averaged over bins one diameter high, from x = 0 up to the lid of `slab`, of a column that has `column_below(x)`
/// spheres per area below x. The last bin counts as whole, so that the sum is N/A.
///
/// ```
/// use gradient_mc::equation_of_state::ModifiedKolafa;
/// use gradient_mc::{Hydrostatics, Slab, field::UniformField, temperature::Isothermal};
/// let slab = Slab::new(100.0, 5.0, 5.0)?;
/// let theory = Hydrostatics::new(UniformField::default(), Isothermal::new(5.0)?, ModifiedKolafa);
/// let profile = theory.between_walls(&slab, 10.0)?;
/// let densities = gradient_mc::model::densities(&slab, |height| profile.column_below(height));
/// assert_eq!(densities.len(), 100);
/// assert!((densities.iter().sum::<f64>() - 10.0).abs() < 1e-9);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[must_use]
pub fn densities(slab: &Slab, column_below: impl Fn(f64) -> f64) -> Vec<f64> {
    let mut below = column_below(0.0);
    (1..=bins(slab))
        .map(|edge| {
            let here = column_below((edge as f64).min(slab.height()));
            let density = here - below;
            below = here;
            density
        })
        .collect()
}

/// Number of bins one diameter high that a slab takes.
pub(super) fn bins(slab: &Slab) -> usize {
    // Heights are at most 1e6.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let bins = slab.height().ceil() as usize;
    bins
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_a_distance_between_zero_and_one() {
        let (first, second) = ([0.2, 0.3, 0.5], [0.5, 0.3, 0.2]);
        approx::assert_relative_eq!(total_variation_distance(&first, &second), 0.3, epsilon = 1e-15);
        approx::assert_relative_eq!(total_variation_distance(&second, &first), 0.3, epsilon = 1e-15);
        assert!(total_variation_distance(&first, &first).abs() < 1e-15);
        // Nothing in common, and of different lengths.
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
}
