//! How well hexagonal layers fit a periodic rectangle.

use nalgebra::Matrix2;

/// Lattice vector m(1, 0) + n(½, √3/2).
fn vector(m: f64, n: f64) -> [f64; 2] {
    [m + 0.5 * n, 0.75_f64.sqrt() * n]
}

/// The smallest strain that makes a hexagonal lattice of unit spacing periodic in a rectangle of
/// these sides.
///
/// Minimum of the larger principal strain over all pairs of lattice vectors that are rotated and
/// strained into the two sides. Rows along a side are one case; the other side then has an even
/// number of rows.
pub(super) fn smallest_strain(sides: [f64; 2]) -> f64 {
    // Larger strains are not searched. In boxes wider than this a pair with a smaller strain always
    // exists.
    const LARGEST: f64 = 0.15;
    const WIDEST: f64 = 60.0;
    let [length, width] = sides;
    if length > WIDEST || width > WIDEST {
        return 0.0;
    }
    let mut smallest = f64::INFINITY;
    // At most some 80 in each direction.
    let most = (length * (1.0 + LARGEST) * 2.0 / 3_f64.sqrt()).ceil();
    let mut n = 0.0;
    while n <= most {
        let mut m = -0.5 * n - most;
        m = m.ceil();
        while m <= most {
            let first = vector(m, n);
            let norm = (first[0] * first[0] + first[1] * first[1]).sqrt();
            if (norm / length - 1.0).abs() <= LARGEST {
                // Ideal end of the other vector, and the lattice points around it.
                let scale = width / norm;
                let ideal = [-first[1] * scale, first[0] * scale];
                let row = ideal[1] / 0.75_f64.sqrt();
                for n in [row.floor(), row.ceil()] {
                    let place = ideal[0] - 0.5 * n;
                    for m in [place.floor(), place.ceil()] {
                        smallest = smallest.min(strain(first, vector(m, n), sides));
                    }
                }
            }
            m += 1.0;
        }
        n += 1.0;
    }
    smallest
}

/// Larger principal strain of the deformation of two vectors into the sides of a rectangle.
fn strain(first: [f64; 2], second: [f64; 2], [length, width]: [f64; 2]) -> f64 {
    let determinant = first[0] * second[1] - first[1] * second[0];
    if determinant <= 0.0 {
        return f64::INFINITY;
    }
    // F = diag(length, width) [first second]⁻¹, up to the rotation.
    let gradient = Matrix2::new(
        length * second[1] / determinant,
        -length * second[0] / determinant,
        -width * first[1] / determinant,
        width * first[0] / determinant,
    );
    // Principal stretches.
    gradient.singular_values().iter().fold(0.0, |largest: f64, stretch| largest.max((stretch - 1.0).abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_rows_fit_and_others_do_not() {
        let row = 0.75_f64.sqrt();
        // Ten spheres along, twelve rows across, in both orientations.
        assert!(smallest_strain([10.0, 12.0 * row]) < 1e-12);
        assert!(smallest_strain([12.0 * row, 10.0]) < 1e-12);
        // Stretched by two per cent: the strain is that, or smaller in another orientation.
        assert!((smallest_strain([3.06, 4.08 * row]) - 0.02).abs() < 1e-12);
        assert!((0.005..0.02).contains(&smallest_strain([10.2, 12.24 * row])));
        // Rotated: 4a + b, of length √21, and 4b + b' at right angles to it, √3 times as long.
        let side = 21_f64.sqrt();
        assert!(smallest_strain([side, 3_f64.sqrt() * side]) < 1e-12);
        // A small square fits no orientation well; a large one always fits.
        let square = |width: f64| smallest_strain([width, width]);
        assert!(square(4.0) > 0.1 && square(6.0) > 0.04 && square(25.0) < 0.01);
    }

    /// By brute force over all pairs.
    #[test]
    fn no_other_pair_fits_better() {
        for sides in [[4.3, 5.1], [6.0, 6.0], [5.5, 8.7]] {
            let range = || (-14..=14).map(f64::from);
            let vectors: Vec<[f64; 2]> = range().flat_map(|m| range().map(move |n| vector(m, n))).collect();
            let pairs = vectors.iter().flat_map(|&first| vectors.iter().map(move |&second| (first, second)));
            let best =
                pairs.map(|(first, second)| strain(first, second, sides)).fold(f64::INFINITY, f64::min);
            approx::assert_relative_eq!(smallest_strain(sides), best, epsilon = 1e-12);
        }
    }
}
