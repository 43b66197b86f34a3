//! Spherical harmonics of bonds, and the invariants of Steinhardt, Nelson and Ronchetti
//! (doi:10.1103/PhysRevB.28.784).

use nalgebra::Vector3;

/// Y₄ₘ and Y₆ₘ, summed over bonds or averaged over spheres, for m ≥ 0 (the others follow by
/// conjugation), as real and imaginary part; times √(4π/(2l + 1)), so that squares sum to
/// Legendre's polynomial.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Harmonics {
    four: [[f64; 2]; 5],
    six: [[f64; 2]; 7],
}

impl Harmonics {
    /// Adds the harmonics of the direction of a bond of nonzero length.
    pub(super) fn add_bond(&mut self, bond: &Vector3<f64>) {
        let direction = bond / bond.norm();
        let (z, square) = (direction.z, direction.z * direction.z);
        // √((l − m)!/(l + m)!) times the mth derivative of Legendre's polynomial; sin^m is part of
        // the azimuthal factor.
        let four = [
            (square * (35.0 * square - 30.0) + 3.0) / 8.0,
            2.5 * z * (7.0 * square - 3.0) / 20_f64.sqrt(),
            7.5 * (7.0 * square - 1.0) / 360_f64.sqrt(),
            105.0 * z / 5040_f64.sqrt(),
            105.0 / 40_320_f64.sqrt(),
        ];
        let six = [
            (square * (square * (231.0 * square - 315.0) + 105.0) - 5.0) / 16.0,
            2.625 * z * (square * (33.0 * square - 30.0) + 5.0) / 42_f64.sqrt(),
            13.125 * (square * (33.0 * square - 18.0) + 1.0) / 1680_f64.sqrt(),
            157.5 * z * (11.0 * square - 3.0) / 60_480_f64.sqrt(),
            472.5 * (11.0 * square - 1.0) / 1_814_400_f64.sqrt(),
            10_395.0 * z / 39_916_800_f64.sqrt(),
            10_395.0 / 479_001_600_f64.sqrt(),
        ];
        // (−sin θ e^{iφ})^m, with the sign of Condon and Shortley.
        let mut power = [1.0, 0.0];
        for (m, sum) in self.six.iter_mut().enumerate() {
            sum[0] += six[m] * power[0];
            sum[1] += six[m] * power[1];
            if let Some(sum) = self.four.get_mut(m) {
                sum[0] += four[m] * power[0];
                sum[1] += four[m] * power[1];
            }
            let [real, imaginary] = power;
            power = [
                imaginary * direction.y - real * direction.x,
                -(real * direction.y + imaginary * direction.x),
            ];
        }
    }

    /// Adds `weight` times the harmonics `other`.
    pub(super) fn add(&mut self, other: &Self, weight: f64) {
        let mine = self.four.iter_mut().chain(&mut self.six).flatten();
        for (mine, other) in mine.zip(other.four.iter().chain(&other.six).flatten()) {
            *mine += weight * other;
        }
    }

    /// √(4π/13 Σ|Y₆ₘ|²).
    pub(super) fn q6(&self) -> f64 {
        norm(&self.six)
    }

    /// √(4π/9 Σ|Y₄ₘ|²).
    pub(super) fn q4(&self) -> f64 {
        norm(&self.four)
    }
}

/// Root of the sum over all m of squares.
fn norm(harmonics: &[[f64; 2]]) -> f64 {
    let squared = |[real, imaginary]: &[f64; 2]| real * real + imaginary * imaginary;
    let (zero, others) = (&harmonics[..1], &harmonics[1..]);
    (zero.iter().map(squared).sum::<f64>() + 2.0 * others.iter().map(squared).sum::<f64>()).sqrt()
}

/// The cubic invariant w₄, with its Wigner symbols (4 4 4; m₁ m₂ m₃).
#[derive(Debug, Clone)]
pub(super) struct CubicInvariant {
    /// m₁ and m₂, both from −4 to 4, and the symbol with m₃ = −m₁ − m₂.
    terms: Vec<(i32, i32, f64)>,
}

impl CubicInvariant {
    pub(super) fn new() -> Self {
        let pairs = (-4..=4).flat_map(|first| (-4..=4).map(move |second| (first, second)));
        let terms = pairs
            .filter(|(first, second): &(i32, i32)| (first + second).abs() <= 4)
            .map(|(first, second)| (first, second, wigner(first, second)))
            .collect();
        Self { terms }
    }

    /// w₄ = Σ (4 4 4; m₁ m₂ m₃) q₄ₘ₁ q₄ₘ₂ q₄ₘ₃ over (Σ|q₄ₘ|²)^{3/2}; −0.1593 in a perfect fcc
    /// crystal, 0.1341 in an hcp crystal.
    pub(super) fn of(&self, harmonics: &Harmonics) -> f64 {
        let component = |m: i32| {
            let [real, imaginary] = harmonics.four[m.unsigned_abs() as usize];
            match m {
                0.. => [real, imaginary],
                // Y₋ₘ is (−1)^m times the conjugate of Yₘ.
                _ if m % 2 == 0 => [real, -imaginary],
                _ => [-real, imaginary],
            }
        };
        let sum: f64 = self
            .terms
            .iter()
            .map(|&(first, second, symbol)| {
                let (a, b, c) = (component(first), component(second), component(-first - second));
                // The imaginary parts of the products cancel in the sum.
                let product = [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]];
                symbol * (product[0] * c[0] - product[1] * c[1])
            })
            .sum();
        let norm = harmonics.q4();
        sum / (norm * norm * norm)
    }
}

/// The symbol (4 4 4; m₁ m₂ −m₁−m₂) by Racah's formula.
fn wigner(first: i32, second: i32) -> f64 {
    let factorial = |number: i32| (1..=number).map(f64::from).product::<f64>();
    let third = -first - second;
    let sum: f64 = (0..=4)
        .map(|t| (t, [t, 4 - t, t + first, t - second, 4 - t - first, 4 - t + second]))
        .filter(|(_, numbers)| numbers.iter().all(|&number| number >= 0))
        .map(|(t, numbers)| {
            let product: f64 = numbers.into_iter().map(factorial).product();
            if t % 2 == 0 { 1.0 / product } else { -1.0 / product }
        })
        .sum();
    let triangle = factorial(4) * factorial(4) * factorial(4) / factorial(13);
    let orders: f64 =
        [first, second, third].into_iter().map(|m| factorial(4 + m) * factorial(4 - m)).product();
    let root = (triangle * orders).sqrt();
    if third % 2 == 0 { root * sum } else { -root * sum }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    /// Σ Yₘ(u) Yₘ*(v) is Legendre's polynomial of u·v.
    #[test]
    fn harmonics_obey_the_addition_theorem() {
        let mut generator = Pcg64Mcg::seed_from_u64(1);
        let mut direction = || Vector3::from([(); 3].map(|()| generator.random::<f64>() - 0.5)) * 3.0;
        for _ in 0..100 {
            let (first, second) = (direction(), direction());
            let cosine = first.dot(&second) / (first.norm() * second.norm());
            let of = |bond: &Vector3<f64>| {
                let mut harmonics = Harmonics::default();
                harmonics.add_bond(bond);
                harmonics
            };
            let (a, mut both) = (of(&first), of(&second));
            assert!((a.q4() - 1.0).abs() < 1e-12 && (a.q6() - 1.0).abs() < 1e-12);
            // |a + b|² = 2 + 2 P(cos).
            both.add(&a, 1.0);
            let square = cosine * cosine;
            let four = (35.0 * square * square - 30.0 * square + 3.0) / 8.0;
            let six = (231.0 * square.powi(3) - 315.0 * square.powi(2) + 105.0 * square - 5.0) / 16.0;
            assert!((both.q4().powi(2) - 2.0 - 2.0 * four).abs() < 1e-12);
            assert!((both.q6().powi(2) - 2.0 - 2.0 * six).abs() < 1e-12);
        }
    }

    #[test]
    fn wigner_symbols_are_those_of_tables() {
        assert!((wigner(0, 0) - 3.0 * (2.0_f64 / 1001.0).sqrt()).abs() < 1e-14);
        for third in -4..=4_i32 {
            let squares: f64 = (-4..=4)
                .filter(|first: &i32| (third + first).abs() <= 4)
                .map(|first| wigner(first, -third - first).powi(2))
                .sum();
            assert!((squares - 1.0 / 9.0).abs() < 1e-14, "{third}: {squares}");
        }
        for (first, second) in [(1, 2), (4, -1), (-3, 3), (0, 4)] {
            let symbol = wigner(first, second);
            for other in [wigner(second, first), wigner(first, -first - second), wigner(-first, -second)] {
                assert!((symbol - other).abs() < 1e-14);
            }
        }
    }

    /// The invariants of Steinhardt's table, in any orientation.
    #[test]
    fn perfect_crystals_have_their_invariants() {
        let cubic = CubicInvariant::new();
        let height = (2.0_f64 / 3.0).sqrt();
        let triangle = |turn: f64, height: f64| {
            (0..3).map(move |corner| {
                let angle = turn + std::f64::consts::TAU * f64::from(corner) / 3.0;
                let radius = 1.0 / 3.0_f64.sqrt();
                Vector3::new(height, radius * angle.cos(), radius * angle.sin())
            })
        };
        let hexagon = (0..6).map(|corner| {
            let angle = std::f64::consts::TAU * (f64::from(corner) + 0.5) / 6.0;
            Vector3::new(0.0, angle.cos(), angle.sin())
        });
        let shell = |above: f64| -> Vec<Vector3<f64>> {
            hexagon.clone().chain(triangle(0.0, -height)).chain(triangle(above, height)).collect()
        };
        for (shell, q4, q6, w4) in [
            (shell(std::f64::consts::PI), 0.190_940_65, 0.574_524_25, -0.159_317_37),
            (shell(0.0), 0.097_222_22, 0.484_761_68, 0.134_096_69),
        ] {
            for axis in [Vector3::new(0.0, 0.0, 1.0), Vector3::new(1.0, 2.0, -0.5)] {
                let rotation = nalgebra::Rotation3::new(axis);
                let mut sum = Harmonics::default();
                for bond in &shell {
                    let mut one = Harmonics::default();
                    one.add_bond(&(rotation * bond));
                    sum.add(&one, 1.0 / 12.0);
                }
                assert!((sum.q4() - q4).abs() < 1e-6, "{}", sum.q4());
                assert!((sum.q6() - q6).abs() < 1e-6, "{}", sum.q6());
                assert!((cubic.of(&sum) - w4).abs() < 1e-6, "{}", cubic.of(&sum));
            }
        }
    }
}
