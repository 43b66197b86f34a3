//! The contact value g(1⁺), extrapolated.
//!
//! Pairs are counted in shells of equal thickness from contact to 1.1 diameters; the value at 1 is
//! that of the cubic that fits the shells best by least squares. This is a fixed linear combination
//! of the counts, so its error is that of a mean. The neglected fourth derivative changes g by
//! about 10⁻⁴ of its value at a packing fraction of 0.45.

use super::cells::Cells;
use gradient_mc::equation_of_state::number_density;
use std::f64::consts::PI;

const SHELLS: usize = 20;
/// Coefficients of the polynomial.
const TERMS: usize = 4;
const THICKNESS: f64 = (Cells::REACH - 1.0) / SHELLS as f64;

/// The combination.
#[derive(Debug, Clone)]
pub(crate) struct Contact {
    weights: [f64; SHELLS],
}

impl Contact {
    pub(crate) fn new() -> Self {
        // Polynomials orthonormal over the shells by Gram and Schmidt; the last value of each is that at
        // contact.
        let place = |index: usize| if index < SHELLS { (index as f64 + 0.5) / SHELLS as f64 } else { 0.0 };
        let mut basis: Vec<[f64; SHELLS + 1]> = Vec::new();
        for _ in 0..TERMS {
            let mut next = [1.0; SHELLS + 1];
            if let Some(last) = basis.last() {
                for (index, value) in next.iter_mut().enumerate() {
                    *value = last[index] * place(index);
                }
            }
            // Twice, against rounding.
            for _ in 0..2 {
                for earlier in &basis {
                    let overlap: f64 = (0..SHELLS).map(|shell| next[shell] * earlier[shell]).sum();
                    for (value, part) in next.iter_mut().zip(earlier) {
                        *value -= overlap * part;
                    }
                }
            }
            let norm = (0..SHELLS).map(|shell| next[shell] * next[shell]).sum::<f64>().sqrt();
            basis.push(next.map(|value| value / norm));
        }
        let mut weights = [0.0; SHELLS];
        for polynomial in &basis {
            for (weight, value) in weights.iter_mut().zip(polynomial) {
                *weight += polynomial[SHELLS] * value;
            }
        }
        Self { weights }
    }

    /// The value in one configuration.
    pub(crate) fn value(&self, cells: &Cells, packing_fraction: f64) -> f64 {
        let mut counts = [0.0; SHELLS];
        cells.pairs_within(Cells::REACH, |distance| {
            // Not negative but for rounding, and below the number of shells.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let shell = (((distance - 1.0) / THICKNESS) as usize).min(SHELLS - 1);
            counts[shell] += 1.0;
        });
        let pairs_per_volume = 0.5 * cells.particles() as f64 * number_density(packing_fraction);
        let cube = |x: f64| x * x * x;
        let mut sum = 0.0;
        for (shell, (count, weight)) in counts.into_iter().zip(self.weights).enumerate() {
            let inner = 1.0 + shell as f64 * THICKNESS;
            let volume = 4.0 * PI / 3.0 * (cube(inner + THICKNESS) - cube(inner));
            sum += weight * count / (pairs_per_volume * volume);
        }
        sum
    }
}
