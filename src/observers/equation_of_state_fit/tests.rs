use super::super::test_frame;
use super::ranks::{self, Ranks, Used};
use super::*;
use crate::equation_of_state::{MOST_TERMS, ModifiedKolafa, Series};
use crate::field::UniformField;
use crate::frame::InForce;
use crate::moves::EventChains;
use crate::random::{Generator, exponential};
use crate::start::RandomInsertion;
use crate::temperature::Isothermal;
use crate::{EquationOfState, Simulation};
use rand::SeedableRng;

/// The reduced potential x/5.
struct Weight;

impl InForce for Weight {
    fn reduced_potential(&self, height: f64) -> f64 {
        height / 5.0
    }
    fn reduced_force(&self, _: f64) -> f64 {
        0.2
    }
    fn generation(&self) -> u64 {
        0
    }
    fn open_end_pressure(&self) -> f64 {
        0.0
    }
}

/// Z by ranks at η = 0.02 of `particles` ideal particles with heights from the distribution in the
/// field; pressures are computed for `extra` more spheres.
fn ideal_gas_by_ranks(particles: usize, extra: f64) -> crate::statistics::Estimate {
    let mut scene = test_frame::Scene::new(400.0, &[]);
    let mut ranks = Ranks::new(particles);
    let mut averages = BlockAverages::new(ranks.components()).unwrap();
    let mut sample = vec![0.0; ranks.components()];
    for seed in 0..20_000 {
        scene.place(&test_frame::ideal_heights(particles, seed));
        ranks.observe(&Frame { potential: &Weight, ..scene.frame() });
        ranks.take(&mut sample);
        let nodes = ranks.nodes().len();
        for weight in &mut sample[nodes..2 * nodes] {
            *weight += extra * 0.2 / scene.slab.base_area();
        }
        averages.push(&sample).unwrap();
    }
    let factor = averages.jackknife(|means| {
        let used = Used { nodes: ranks.nodes(), area: scene.slab.base_area(), distances: [0.0, 400.0] };
        let fit = ranks::Means::of(means).fit(&used, 1);
        [fit.map_or(f64::NAN, |fit| Series::new(&fit).compressibility_factor(0.02))]
    });
    factor.unwrap()[0]
}

#[test]
fn ranks_of_an_ideal_gas_are_exact_for_any_number() {
    for (particles, cap) in [(3, 0.06), (20, 0.02), (200, 0.006)] {
        let factor = ideal_gas_by_ranks(particles, 0.0);
        assert!(factor.deviation_from(1.0).abs() < 4.0, "{particles}: {factor}");
        assert!(factor.standard_error < cap, "{particles}: {factor}");
    }
    // They are wrong if the sphere below a gap is included in the weight.
    let wrong = ideal_gas_by_ranks(20, 1.0);
    assert!(wrong.deviation_from(1.0).abs() > 4.0, "{wrong}");
}

#[test]
fn ranks_at_the_heights_of_an_equation_of_state_give_it_back() {
    let (spheres, area, temperature) = (2000, 49.0, 10.0);
    let nodes = Ranks::new(spheres).nodes().to_vec();
    let factor_at = |pressure: f64| {
        ModifiedKolafa.compressibility_factor(ModifiedKolafa.packing_fraction_at(pressure, None).unwrap())
    };
    // Distances from the highest, and weights.
    let mut sample = vec![0.0; 2 * nodes.len() + 1];
    let (mut distance, mut rank) = (0.0, 1);
    for (node, &last) in nodes.iter().enumerate() {
        while rank < last {
            let pressure = rank as f64 / (area * temperature);
            distance += factor_at(pressure) / (pressure * area);
            rank += 1;
        }
        sample[node] = distance;
        sample[nodes.len() + node] = last as f64 / (area * temperature);
    }
    let used = Used { nodes: &nodes, area, distances: [0.0, 1e3] };
    let fit = ranks::Means::of(&sample).fit(&used, 4).unwrap();
    for eta in [0.05, 0.1, 0.2, 0.3, 0.35] {
        let exact = ModifiedKolafa.compressibility_factor(eta);
        approx::assert_relative_eq!(
            Series::new(&fit).compressibility_factor(eta),
            exact,
            max_relative = 1e-4
        );
    }
}

/// Z − 1 of two spheres from lateral chains in a box without a field: the estimate and the exact
/// value.
///
/// The configurational integral is an average over both heights of L²W² − LW a(x), where a = π(1 −
/// x²) for centers closer than a diameter in height. N Z of the lateral pressure is its logarithmic
/// derivative by L.
#[test]
fn collisions_of_two_spheres_are_exact() {
    let (height, width) = (3.0, 3.0);
    let scene =
        Scene::new(Slab::new(height, width, width).unwrap(), 2, UniformField::new(0.0).unwrap(), hot())
            .unwrap();
    let chains = EventChains::with_length(3.0).unwrap().vertical_fraction(1e-3).unwrap();
    let mut simulation = Simulation::builder(scene).moves(chains).seed(3).build().unwrap();
    let mut fit = EquationOfStateFit::new(&scene).unwrap();
    simulation.equilibrate(100, &mut ()).unwrap();
    simulation.run(400_000, &mut fit).unwrap();
    let bins = fit.bins.count();
    let split = fit.ranks.components();
    let excess = fit.averages.jackknife(|means| {
        let sums = &means[split + bins..split + 3 * bins];
        [sums[bins..].iter().sum::<f64>() / sums[..bins].iter().sum::<f64>()]
    });
    let excess = excess.unwrap()[0];
    let h = height - 1.0;
    let excluded = 2.0 * std::f64::consts::PI / (h * h) * (h * 2.0 / 3.0 - 0.25) / (width * width);
    let exact = 0.5 * excluded / (1.0 - excluded);
    assert!(excess.deviation_from(exact).abs() < 4.0, "{excess}, exact {exact:.5}");
    assert!(excess.standard_error < 0.01 * exact, "{excess}");
}

fn hot() -> Isothermal {
    Isothermal::new(1.0).unwrap()
}

#[test]
fn collisions_are_right_in_a_column_that_still_falls_and_ranks_are_not_believed() {
    let slab = Slab::new(120.0, 6.0, 6.0).unwrap();
    let scene =
        Scene::with_column_density(slab, 30.0, UniformField::default(), Isothermal::new(10.0).unwrap())
            .unwrap();
    let mut simulation =
        Simulation::builder(scene).start(RandomInsertion::default()).seed(1).build().unwrap();
    let mut fit = EquationOfStateFit::new(&scene).unwrap();
    simulation.run(1600, &mut fit).unwrap();
    let measured = fit.result().unwrap();
    assert_eq!(measured.terms(), 3);
    let etas = [0.1, 0.2, 0.3];
    let deviation = |factor: &crate::statistics::Estimate, eta: f64| {
        factor.deviation_from(ModifiedKolafa.compressibility_factor(eta)).abs()
    };
    for curve in [measured.collisions(), measured.combined()] {
        for (factor, eta) in curve.compressibility_factor_at(&etas).unwrap().iter().zip(etas) {
            assert!(
                deviation(factor, eta) < 4.0 && factor.standard_error < 0.04 * factor.mean,
                "{eta}: {factor}"
            );
        }
    }
    let ranks = measured.ranks().compressibility_factor_at(&etas).unwrap();
    assert!(ranks.iter().any(|factor| factor.standard_error > 0.04 * factor.mean), "{ranks:?}");
}

#[test]
fn what_was_not_measured_is_refused() {
    let slab = Slab::new(60.0, 5.0, 5.0).unwrap();
    let scene = Scene::new(slab, 250, UniformField::default(), Isothermal::new(5.0).unwrap()).unwrap();
    let mut fit = EquationOfStateFit::new(&scene).unwrap();
    assert!(matches!(fit.result(), Err(Error::TooFewObservations { .. })));
    let mut simulation = Simulation::builder(scene).seed(1).build().unwrap();
    simulation.run(1100, &mut fit).unwrap();
    let measured = fit.result().unwrap();
    let highest = measured.highest_packing_fraction();
    assert!((0.1..0.3).contains(&highest), "{highest}");
    for eta in [-0.1, highest * 1.01, f64::NAN] {
        assert!(measured.combined().compressibility_factor_at(&[eta]).is_err(), "{eta}");
    }
    // Derived quantities at zero density are those of an ideal gas.
    let combined = measured.combined();
    approx::assert_relative_eq!(combined.excess_chemical_potential_at(&[0.0]).unwrap()[0].mean, 0.0);
    approx::assert_relative_eq!(combined.reduced_compressibility_at(&[0.0]).unwrap()[0].mean, 1.0);
    let covariance = combined.covariance_at(&[0.1, 0.15]).unwrap();
    let errors = combined.compressibility_factor_at(&[0.1, 0.15]).unwrap();
    for (index, error) in errors.iter().enumerate() {
        approx::assert_relative_eq!(
            covariance[index][index].sqrt(),
            error.standard_error,
            max_relative = 1e-9
        );
    }
    let virial = combined.virial_coefficients();
    assert!(virial[0].deviation_from(4.0).abs() < 4.0, "{virial:?}");
    // Another scene.
    let other = Scene::new(slab, 251, UniformField::default(), Isothermal::new(5.0).unwrap()).unwrap();
    assert!(fit.merge(&EquationOfStateFit::new(&other).unwrap()).is_err());
    assert!(Simulation::builder(other).build().unwrap().run(1, &mut fit).is_err());
}

#[test]
fn a_short_run_has_collisions_without_errors() {
    let slab = Slab::new(60.0, 5.0, 5.0).unwrap();
    let scene = Scene::new(slab, 500, UniformField::default(), Isothermal::new(5.0).unwrap()).unwrap();
    let moves = EventChains::default().local_moves(None);
    let mut simulation = Simulation::builder(scene).moves(moves).seed(5).build().unwrap();
    let mut fit = EquationOfStateFit::new(&scene).unwrap();
    simulation.equilibrate(200, &mut ()).unwrap();
    simulation.run(31, &mut fit).unwrap();
    assert!(matches!(fit.collisions_without_errors().map(|_| ()), Err(Error::TooFewObservations { .. })));
    simulation.run(225, &mut fit).unwrap();
    assert!(fit.result().is_err());
    let equation = fit.collisions_without_errors().unwrap();
    for eta in [0.1, 0.2, 0.3] {
        let known = ModifiedKolafa.compressibility_factor(eta);
        approx::assert_relative_eq!(equation.compressibility_factor(eta), known, max_relative = 0.06);
    }
}

/// The mean of the third term of the series over blocks with independent Poisson counts, at
/// η = 0.3, over its value at the mean density, less 1; `same` gives both halves the same counts.
fn bias_of_fluctuations(same: bool) -> crate::statistics::Estimate {
    const TERM: usize = 2;
    let slab = Slab::new(30.0, 6.0, 6.0).unwrap();
    let collisions = Collisions::over(&slab, EquationOfStateFit::SMOOTHING).unwrap();
    let bins = collisions.bins().count();
    let mean = 0.3 * collisions.bins().volume() * 6.0 / std::f64::consts::PI;
    let mut averages = BlockAverages::new(1).unwrap();
    let (mut generator, mut means) = (Generator::seed_from_u64(1), vec![0.0; collisions.means()]);
    let mut half = || -> Vec<f64> {
        let mut poisson = || {
            let (mut count, mut left) = (-1.0, mean);
            while left > 0.0 {
                left -= exponential(&mut generator);
                count += 1.0;
            }
            count
        };
        let counts = (0..bins).map(|_| poisson());
        counts.chain(std::iter::repeat_n(1.0, 2 * bins)).collect()
    };
    for _ in 0..20_000 {
        let first = half();
        let second = if same { first.clone() } else { half() };
        collisions.complete([&first, &second], &mut means);
        averages.push(&[means[(3 + TERM) * bins + bins / 2] / Series::terms(0.3)[TERM] - 1.0]).unwrap();
    }
    averages.estimates().unwrap()[0]
}

#[test]
fn the_density_of_a_block_may_fluctuate() {
    let bias = bias_of_fluctuations(false);
    assert!(bias.deviation_from(0.0).abs() < 4.0 && bias.standard_error < 3e-3, "{bias}");
    let wrong = bias_of_fluctuations(true);
    assert!(wrong.deviation_from(0.0) > 4.0 && wrong.mean > 0.01, "{wrong}");
}

#[test]
fn a_bin_whose_smoothed_density_is_zero_is_left_out() {
    // Three bins with Z - 1 = 4 times the first term; in the last, chains ran and no sphere was
    // counted.
    let (counts, paths, terms) = ([5.0, 3.0, 0.0], [100.0, 100.0, 10.0], [10.0, 5.0, 0.0]);
    let transfers = [40.0, 20.0, 1.0];
    let mut sample = [counts, paths, transfers, terms].concat();
    sample.resize(3 * (3 + MOST_TERMS), 0.0);
    let fit = Means::of(&sample).fit(0..3, 1).unwrap();
    approx::assert_relative_eq!(fit[0], 4.0, max_relative = 1e-12);
}

#[test]
fn a_density_that_is_too_steep_to_be_smoothed_is_warned_of() {
    for (temperature, spheres, steep) in [(2.0, 40, true), (5.0, 200, false)] {
        let slab = Slab::new(60.0, 5.0, 5.0).unwrap();
        let temperature = Isothermal::new(temperature).unwrap();
        let scene = Scene::new(slab, spheres, UniformField::default(), temperature).unwrap();
        let mut fit = EquationOfStateFit::new(&scene).unwrap();
        Simulation::builder(scene).seed(1).build().unwrap().run(1100, &mut fit).unwrap();
        let warnings = fit.result().unwrap().warnings();
        let warned = warnings.iter().any(|warning| matches!(warning, Warning::SteepGradient { .. }));
        assert_eq!(warned, steep, "{temperature:?}: {warnings:?}");
    }
}

/// Both routes with independent noise of 0.04 in their coefficients.
#[test]
fn routes_that_disagree_are_warned_of_and_collisions_are_believed() {
    let mut generator = <crate::Generator as rand::SeedableRng>::seed_from_u64(4);
    let mut noise = BlockAverages::new(2 * MOST_TERMS).unwrap();
    for _ in 0..1024 {
        noise
            .push(&std::array::from_fn::<f64, { 2 * MOST_TERMS }, _>(|_| {
                4.0 * (crate::random::unit(&mut generator) - 0.5)
            }))
            .unwrap();
    }
    let measured = |off: f64| {
        let jackknife = noise.jackknifed(|means| {
            measured::fits(|route, terms| {
                let (first, means) = match route {
                    measured::Route::Ranks => (4.0 + off, &means[..terms]),
                    measured::Route::Collisions => (4.0, &means[MOST_TERMS..MOST_TERMS + terms]),
                };
                let mut coefficients = vec![first, -2.0, 0.2];
                coefficients.resize(terms, 0.0);
                Some(coefficients.iter().zip(means).map(|(value, noise)| value + noise).collect())
            })
        });
        MeasuredEquationOfState::new(&jackknife.unwrap(), [5.0, 20.0], 0.4, None)
    };
    assert_eq!(measured(0.0).warnings(), []);
    let apart = measured(1.0);
    assert!(
        matches!(apart.warnings()[..], [Warning::RoutesDisagree { ranks, collisions, .. }]
            if ranks.mean > collisions.mean + 4.0 * ranks.standard_error),
        "{:?}",
        apart.warnings()
    );
    let factor = |curve: EquationOfStateCurve<'_>| curve.compressibility_factor(0.3);
    approx::assert_relative_eq!(factor(apart.combined()), factor(apart.collisions()), max_relative = 1e-9);
}
