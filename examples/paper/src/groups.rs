//! Ranges of heights over which a measured column is compared with theory.

use gradient_mc::HydrostaticProfile;
use gradient_mc::observers::BinState;
use gradient_mc::statistics::Estimate;

/// The first height above `lowest` at which |d ln n/dx| of the theory exceeds `steepest`, to 0.1
/// diameters. A local equation of state holds only where ln n changes little over a diameter.
pub fn end_of_gentle_slope(theory: &HydrostaticProfile, lowest: f64, steepest: f64, lid: f64) -> f64 {
    let slope = |height: f64| {
        let (below, above) = (theory.number_density(height - 0.05), theory.number_density(height + 0.05));
        libm::log(above / below) / 0.1
    };
    let mut highest = lowest;
    while slope(highest).abs() < steepest && highest < lid - 1.0 {
        highest += 0.1;
    }
    highest
}

/// The edges of `groups` ranges of heights from `lowest` to `highest` with equal numbers of
/// spheres, so that errors are similar in all of them.
pub fn edges_of_equal_numbers(
    theory: &HydrostaticProfile,
    [lowest, highest]: [f64; 2],
    groups: usize,
) -> Vec<f64> {
    let (low, high) = (theory.column_below(lowest), theory.column_below(highest));
    (0..=groups)
        .map(|edge| {
            let part = (low + (high - low) * edge as f64 / groups as f64) / theory.column_density();
            theory.height_of_fraction(part)
        })
        .collect()
}

/// The ranges between successive edges.
pub fn ranges_between(edges: &[f64]) -> Vec<[f64; 2]> {
    edges.windows(2).map(|group| [group[0], group[1]]).collect()
}

/// Means of a quantity over the bins whose middles are in ranges of heights; the states are ordered
/// by height.
pub fn means_over(states: &[BinState], ranges: &[[f64; 2]], value: impl Fn(&BinState) -> f64) -> Vec<f64> {
    let below = |height: f64| states.partition_point(|state| state.height < height);
    let mean = |&[low, high]: &[f64; 2]| {
        let inside = &states[below(low)..below(high)];
        inside.iter().map(&value).sum::<f64>() / inside.len() as f64
    };
    ranges.iter().map(mean).collect()
}

/// The estimate with the largest magnitude, with its sign. NaN if there is none or one is NaN, so
/// that a claim about missing data fails.
pub fn farthest_from_zero(values: impl IntoIterator<Item = Estimate>) -> Estimate {
    let farthest = values.into_iter().max_by(|first, second| first.mean.abs().total_cmp(&second.mean.abs()));
    farthest.unwrap_or(Estimate::new(f64::NAN, f64::NAN))
}

/// The mean of estimates whose errors add up, since they move together; NaN if there are none.
pub fn mean_of_correlated(estimates: impl IntoIterator<Item = Estimate>) -> Estimate {
    let (mut sum, mut count) = (Estimate::exact(0.0), 0.0);
    for estimate in estimates {
        sum.mean += estimate.mean;
        sum.standard_error += estimate.standard_error;
        count += 1.0;
    }
    sum / count
}

/// The magnitude of an estimate.
pub fn magnitude(Estimate { mean, standard_error, .. }: Estimate) -> Estimate {
    Estimate::new(mean.abs(), standard_error)
}

/// The largest value. NaN if there is none or one is NaN, which `f64::max` would ignore.
pub fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    let larger = |first: f64, second: f64| if first >= second || first.is_nan() { first } else { second };
    values.into_iter().reduce(larger).unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_could_not_be_measured_is_not_passed_over() {
        let estimates =
            |means: &[f64]| means.iter().map(|&mean| Estimate::new(mean, 0.1)).collect::<Vec<_>>();
        assert!((farthest_from_zero(estimates(&[0.5, -2.0, 1.0])).mean + 2.0).abs() < 1e-15);
        assert!((largest([0.5, -2.0, 1.0]) - 1.0).abs() < 1e-15);
        for unknown in [f64::NAN, -f64::NAN] {
            assert!(farthest_from_zero(estimates(&[0.5, unknown, 1.0])).mean.is_nan());
            assert!(largest([unknown, 0.5]).is_nan() && largest([0.5, unknown, 1.0]).is_nan());
        }
        assert!(farthest_from_zero([]).mean.is_nan() && largest([]).is_nan());
    }
}
