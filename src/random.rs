//! The generator of every run, and the few distributions that moves need.

use rand::{Rng, RngExt};

/// The generator that every seeded result comes from: PCG XSL 128/64 (MCG), portable across machines.
///
/// ```
/// use gradient_mc::Generator;
/// use rand::SeedableRng;
/// let generator = Generator::seed_from_u64(1);
/// # let _ = generator;
/// ```
pub type Generator = rand_pcg::Pcg64Mcg;

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
    fn golden_sequence() {
        let mut generator = Generator::seed_from_u64(1);
        let drawn: Vec<usize> = (0..4).map(|_| index(&mut generator, 1000)).collect();
        assert_eq!(drawn, [870, 199, 690, 260]);
    }
}
