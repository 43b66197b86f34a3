//! Measures of the difference of two profiles, and the difference expected from their error bars.
//!
//! Profiles are means of n over bins one diameter high, from x = 0, and P at the middles of these
//! bins.

use std::f64::consts::FRAC_2_PI;

/// Height of a bin.
pub const BIN_HEIGHT: f64 = 1.0;

/// Total variation distance: half of ∫|n − n'| dx over N/A, the share of spheres at a wrong height,
/// resolved to a diameter.
pub fn total_variation_distance(density: &[f64], reference: &[f64], column_density: f64) -> f64 {
    let distance: f64 =
        density.iter().zip(reference).map(|(density, reference)| (density - reference).abs()).sum();
    0.5 * distance * BIN_HEIGHT / column_density
}

/// Expected total variation distance of an unbiased density with normal noise of these standard
/// errors; the mean magnitude of the noise is √(2/π) of its standard deviation.
pub fn expected_total_variation_distance(standard_errors: &[f64], column_density: f64) -> f64 {
    0.5 * FRAC_2_PI.sqrt() * standard_errors.iter().sum::<f64>() * BIN_HEIGHT / column_density
}

/// The largest |P − P'| over the pressure P' at the base.
pub fn pressure_deviation(pressure: &[f64], reference: &[f64]) -> f64 {
    let largest = pressure
        .iter()
        .zip(reference)
        .map(|(pressure, reference)| (pressure - reference).abs())
        .fold(0.0, worse);
    largest / reference.first().copied().unwrap_or(f64::NAN)
}

/// The larger of two; NaN if either is NaN, which `max` would ignore.
fn worse(one: f64, other: f64) -> f64 {
    if one.is_nan() || other.is_nan() { f64::NAN } else { one.max(other) }
}

/// The root mean square of `values` relative to `reference`, over the bins of the bulk: above the
/// layers at the base (x > 8), and where the packing fraction of the reference is above 0.05.
pub fn bulk_deviation(values: &[f64], reference: &[f64], reference_density: &[f64]) -> f64 {
    const LOWEST: f64 = 8.0;
    /// Packing fraction 0.05, in spheres per cubic diameter.
    const LEAST: f64 = 0.3 / std::f64::consts::PI;
    let squares: Vec<f64> = values
        .iter()
        .zip(reference)
        .zip(reference_density)
        .enumerate()
        .filter(|&(bin, (_, &density))| bin as f64 * BIN_HEIGHT >= LOWEST && density > LEAST)
        .map(|(_, ((value, reference), _))| (value / reference - 1.0) * (value / reference - 1.0))
        .collect();
    root_mean(&squares)
}

/// The root of the mean of squares; NaN for none.
pub fn root_mean(squares: &[f64]) -> f64 {
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

/// The root mean square.
pub fn root_mean_square(values: impl IntoIterator<Item = f64>) -> f64 {
    root_mean(&values.into_iter().map(|value| value * value).collect::<Vec<f64>>())
}

/// The median; the larger of the two in the middle, and NaN if there are none.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn half_of_what_is_elsewhere_is_misplaced() {
        let (own, reference) = ([2.0, 1.0, 1.0], [1.0, 1.0, 2.0]);
        // One sphere of four per area.
        assert_relative_eq!(total_variation_distance(&own, &reference, 4.0), 0.25);
        let noise = expected_total_variation_distance(&[0.1; 3], 4.0);
        assert_relative_eq!(noise, 0.5 * 0.3 * FRAC_2_PI.sqrt() / 4.0);
    }

    #[test]
    fn pressures_are_compared_with_that_at_the_base_and_nan_is_not_passed_over() {
        assert_relative_eq!(pressure_deviation(&[4.0, 2.5], &[4.0, 2.0]), 0.125);
        assert!(pressure_deviation(&[f64::NAN, 2.0], &[4.0, 2.0]).is_nan());
    }

    #[test]
    fn the_bulk_is_above_the_layers_and_not_too_dilute() {
        let reference = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1e-3];
        let mut values = reference;
        (values[0], values[8], values[9], values[10]) = (9.0, 1.03, 0.96, 9.0);
        let expected = f64::midpoint(0.03 * 0.03, 0.04 * 0.04).sqrt();
        assert_relative_eq!(bulk_deviation(&values, &reference, &reference), expected, epsilon = 1e-12);
        assert_relative_eq!(root_mean_square([3.0, 4.0]), 12.5_f64.sqrt());
        assert_relative_eq!(median(vec![5.0, 1.0, 2.0, 4.0]), 4.0);
        assert!(median(Vec::new()).is_nan());
        assert!(root_mean(&[]).is_nan());
    }
}
