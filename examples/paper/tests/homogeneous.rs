//! Parts of the study `speed_and_accuracy`: the homogeneous program, which must be correct and fast
//! for a fair comparison, the definitions of errors, and the Pareto front.

#![allow(clippy::unwrap_used)]

use gradient_mc::equation_of_state::{EquationOfState, ModifiedKolafa};
use gradient_mc::statistics::Estimate;
use paper::homogeneous::{Homogeneous, Technique, finite_size};
use paper::{accuracy, pareto};

/// Z of infinitely many spheres, measured with 4k³.
fn factor(lattice: usize, eta: f64, technique: Technique, sweeps: u64) -> Estimate {
    let mut spheres = Homogeneous::new(lattice, eta, technique, 7);
    spheres.equilibrate(sweeps / 4);
    let measured = spheres.measure(sweeps).unwrap();
    assert!(spheres.smallest_distance() > 1.0 - 1e-9, "spheres overlap");
    measured + finite_size(spheres.particles(), eta)
}

/// Within four standard errors, which are below `cap` relative to Z.
fn agrees(eta: f64, technique: Technique, sweeps: u64, cap: f64) {
    let found = factor(4, eta, technique, sweeps);
    let theory = ModifiedKolafa.compressibility_factor(eta);
    assert!(found.standard_error < cap * theory, "{technique:?} at {eta}: the error of {found} is too large");
    assert!(found.deviation_from(theory).abs() < 4.0, "{technique:?} at {eta}: {found} is not {theory}");
    // What forgets the collisions, or counts every one twice, is found out.
    for wrong in [1.0, 1.0 + 2.0 * (found.mean - 1.0)] {
        assert!(Estimate::new(wrong, found.standard_error).deviation_from(theory).abs() > 4.0);
    }
}

#[test]
fn contact_values_know_the_pressure() {
    agrees(0.2, Technique::Local, 3000, 0.02);
    agrees(0.4, Technique::Local, 3000, 0.02);
}

#[test]
fn chains_know_the_pressure() {
    agrees(0.2, Technique::Chains, 3000, 0.003);
    agrees(0.4, Technique::Chains, 3000, 0.005);
}

#[test]
fn a_dilute_gas_is_nearly_ideal() {
    // The second virial coefficient, with its 1 − 1/N.
    let eta = 0.002;
    for technique in [Technique::Local, Technique::Chains] {
        let mut spheres = Homogeneous::new(3, eta, technique, 3);
        spheres.equilibrate(50);
        let found = spheres.measure(4000).unwrap();
        let exact = 1.0 + 4.0 * eta * (1.0 - 1.0 / spheres.particles() as f64);
        assert!(found.standard_error < 3e-3, "{technique:?}: {found}");
        assert!(
            (found.mean - exact).abs() < 4.0 * found.standard_error + 1e-4,
            "{technique:?}: {found}, {exact}"
        );
    }
}

#[test]
fn small_boxes_lack_pressure_as_predicted() {
    // 32 spheres: some 1.4 % of Z.
    let eta = 0.2;
    let found = factor(2, eta, Technique::Chains, 20_000);
    let correction = finite_size(32, eta);
    let theory = ModifiedKolafa.compressibility_factor(eta);
    assert!(found.standard_error < 0.2 * correction, "{found}, {correction}");
    assert!(found.deviation_from(theory).abs() < 4.0, "{found}, {theory}");
    // Without the correction it is wrong.
    assert!(found.deviation_from(theory + correction).abs() > 4.0, "{found}, {correction}");
}

#[test]
fn a_sphere_at_the_wrong_height_is_misplaced() {
    // One of four spheres per area is two bins too high.
    let (right, wrong) = ([2.0, 2.0, 0.0, 0.0], [2.0, 1.0, 0.0, 1.0]);
    assert!((accuracy::total_variation_distance(&wrong, &right, 4.0) - 0.25).abs() < 1e-15);
    assert!(accuracy::total_variation_distance(&right, &right, 4.0) < 1e-15);
    // A column that is nowhere where it should be.
    assert!((accuracy::total_variation_distance(&[0.0, 0.0, 4.0, 0.0], &right, 4.0) - 1.0).abs() < 1e-15);
}

#[test]
fn noise_misplaces_as_much_as_its_errors_say() {
    use rand::{RngExt, SeedableRng};
    let mut generator = rand_pcg::Pcg64Mcg::seed_from_u64(5);
    // Sums of twelve uniform numbers are normal enough.
    let mut normal = || (0..12).map(|_| generator.random::<f64>()).sum::<f64>() - 6.0;
    let errors: Vec<f64> = (0..400).map(|bin| 0.01 / (1.0 + f64::from(bin))).collect();
    let column_density = 40.0;
    let trials = 2000;
    let mean = (0..trials)
        .map(|_| {
            let noise: Vec<f64> = errors.iter().map(|error| error * normal()).collect();
            accuracy::total_variation_distance(&noise, &[0.0; 400], column_density)
        })
        .sum::<f64>()
        / f64::from(trials);
    let expected = accuracy::expected_total_variation_distance(&errors, column_density);
    assert!((mean / expected - 1.0).abs() < 0.03, "{mean}, {expected}");
}

#[test]
fn pressure_and_bulk_are_relative() {
    let reference = [40.0, 30.0, 20.0];
    assert!((accuracy::pressure_deviation(&[40.0, 29.0, 20.2], &reference) - 0.025).abs() < 1e-15);
    assert!(accuracy::pressure_deviation(&[40.0, f64::NAN, 20.0], &reference).is_nan());
    // Bins 8 and 9 are above the layers and dense; 10 is dilute; what is below 8 does not count.
    let mut density = [0.5; 11];
    density[10] = 0.01;
    let mut values = density;
    (values[3], values[8], values[9], values[10]) = (5.0, 0.55, 0.45, 5.0);
    assert!((accuracy::bulk_deviation(&values, &density, &density) - 0.1).abs() < 1e-12);
}

#[test]
fn the_front_is_what_nothing_beats() {
    let points = [
        (3.0, 0.1),
        (1.0, 0.5),
        (2.0, 0.6),
        (2.0, 0.4),
        (f64::NAN, 0.0),
        (4.0, 0.1),
        (5.0, 0.01),
        (1.0, 0.7),
    ];
    assert_eq!(pareto::front(&points), [1, 3, 0, 6]);
    // Whatever is not on the front is beaten by something on it.
    let front = pareto::front(&points);
    for (index, point) in points.iter().enumerate().filter(|(_, point)| !point.0.is_nan()) {
        let beaten = |&other: &usize| points[other].0 <= point.0 && points[other].1 <= point.1;
        assert!(front.contains(&index) || front.iter().any(beaten));
    }
    assert!(pareto::front(&[]).is_empty());
}
