//! Smooth densities from noisy counts.

use nalgebra::DMatrix;

/// Smoothing by local polynomials: the value at a bin is that of the polynomial that fits its
/// neighbors best.
///
/// The degree is four with equal numbers of neighbors on both sides, with a bias of sixth order in
/// the width, and two near the ends.
#[derive(Debug, Clone)]
pub(super) struct Smoothing {
    /// First neighbor, and the weights from it on; empty for unused bins.
    rows: Vec<(usize, Vec<f64>)>,
}

impl Smoothing {
    /// Makes a smoothing of the bins in `used` of `bins` bins, over `reach` bins on either side.
    pub(super) fn new(bins: usize, used: std::ops::Range<usize>, reach: usize) -> Self {
        let row = |bin: usize| {
            if !used.contains(&bin) {
                return (bin, Vec::new());
            }
            let first = bin.saturating_sub(reach).max(used.start);
            let last = (bin + reach).min(used.end - 1);
            let full = last - first == 2 * reach;
            let degree = if full { 4 } else { 2 }.min(last - first);
            (first, weights(first, last, bin, reach, degree))
        };
        Self { rows: (0..bins).map(row).collect() }
    }

    /// The smooth values; zero in unused bins.
    pub(super) fn apply(&self, values: &[f64], smooth: &mut [f64]) {
        for (smooth, (first, weights)) in smooth.iter_mut().zip(&self.rows) {
            *smooth = values[*first..].iter().zip(weights).map(|(value, weight)| value * weight).sum();
        }
    }
}

/// Weights of the values in bins `first` to `last` in the value of the polynomial at `bin`. In the
/// fit, the weight of a neighbor decreases with its distance.
fn weights(first: usize, last: usize, bin: usize, reach: usize, degree: usize) -> Vec<f64> {
    let distance = |other: usize| (other as f64 - bin as f64) / (reach as f64 + 1.0);
    let importance = |other: usize| 1.0 - distance(other) * distance(other);
    let count = last - first + 1;
    let power_of =
        |row: usize, power: usize| std::iter::repeat_n(distance(first + row), power).product::<f64>();
    let powers = DMatrix::from_fn(count, degree + 1, power_of);
    let weighted =
        DMatrix::from_fn(count, degree + 1, |row, power| importance(first + row) * powers[(row, power)]);
    let Some(inverse) = (powers.transpose() * &weighted).try_inverse() else {
        return (first..=last).map(|other| f64::from(u8::from(other == bin))).collect();
    };
    (0..count)
        .map(|row| (0..=degree).map(|power| inverse[(0, power)] * weighted[(row, power)]).sum())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_stay_what_they_are() {
        let smoothing = Smoothing::new(60, 5..55, 8);
        let cubic = |bin: f64| 1.0 + 0.1 * bin - 0.003 * bin * bin + 2e-5 * bin * bin * bin;
        let values: Vec<f64> = (0..60).map(|bin| cubic(f64::from(bin))).collect();
        let mut smooth = vec![0.0; 60];
        smoothing.apply(&values, &mut smooth);
        for bin in 13..47 {
            approx::assert_relative_eq!(smooth[bin], values[bin], max_relative = 1e-10);
        }
        // Near the ends a parabola, and nothing outside.
        assert!((smooth[5] - values[5]).abs() < 0.01 && smooth[4] == 0.0 && smooth[55] == 0.0);
    }
}
