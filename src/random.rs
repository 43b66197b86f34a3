//! The random number generator, and the distributions that moves need.

use rand::{Rng, RngExt};

/// The random number generator of all runs: PCG XSL 128/64 (MCG), with the same numbers on every
/// machine.
///
/// ```
/// use gradient_mc::Generator;
/// use rand::SeedableRng;
/// let generator = Generator::seed_from_u64(1);
/// # let _ = generator;
/// ```
pub type Generator = rand_pcg::Pcg64Mcg;

/// Uniform on (−1, 1), with exactly equal probabilities of v and −v: detailed balance needs equal
/// probabilities of a trial move and its reverse.
#[inline]
pub(crate) fn symmetric(generator: &mut impl Rng) -> f64 {
    // An odd integer in (−2^53, 2^53), over 2^53: exact.
    let bits = generator.next_u64() >> 11;
    let odd = (2 * bits + 1).cast_signed() - (1 << 53);
    odd as f64 * (1.0 / (1u64 << 53) as f64)
}

/// Uniform on [0, 1).
#[inline]
pub(crate) fn unit(generator: &mut impl Rng) -> f64 {
    generator.random::<f64>()
}

/// Exponential with mean 1.
#[inline]
pub(crate) fn exponential(generator: &mut impl Rng) -> f64 {
    -libm::log(1.0 - unit(generator))
}

/// Uniform on 0..`bound`.
#[inline]
pub(crate) fn index(generator: &mut impl Rng, bound: usize) -> usize {
    // The number of spheres, or of lattice sites per layer, is a u32; 32 bits do on every machine.
    #[allow(clippy::cast_possible_truncation)]
    let bound = bound as u32;
    generator.random_range(0..bound) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn symmetric_is_symmetric_and_fills_its_range() {
        let mut generator = Generator::seed_from_u64(7);
        let values: Vec<f64> = (0..100_000).map(|_| symmetric(&mut generator)).collect();
        assert!(values.iter().all(|value| value.abs() < 1.0 && *value != 0.0));
        let mean = values.iter().sum::<f64>() / 1e5;
        let square = values.iter().map(|value| value * value).sum::<f64>() / 1e5;
        // Standard errors sqrt(1/3/N) and sqrt(4/45/N).
        assert!(mean.abs() < 4.0 * 1.83e-3);
        assert!((square - 1.0 / 3.0).abs() < 4.0 * 9.5e-4);
    }

    #[test]
    fn golden_sequence() {
        let mut generator = Generator::seed_from_u64(1);
        let drawn: Vec<usize> = (0..4).map(|_| index(&mut generator, 1000)).collect();
        assert_eq!(drawn, [870, 199, 690, 260]);
    }
}
