//! Sampled results compared with exact ones: fixed seeds, within 4 standard errors from blocks,
//! with a limit on the standard error, so that a noisy run cannot pass.

use crate::common::exact::{
    TWO_SPHERES_MEAN, TWO_SPHERES_VARIANCE, agrees, center_of_mass, contact_density, ideal_gas_mean,
    mean_height,
};
use gradient_mc::drive::{EquationOfStateClosure, SelfConsistent};
use gradient_mc::equation_of_state::IdealGas;
use gradient_mc::field::{ExponentialField, LinearField, SumField, UniformField};
use gradient_mc::moves::LocalMoves;
use gradient_mc::observers::{Bins, CenterOfMass, DensityProfile};
use gradient_mc::start::RandomInsertion;
use gradient_mc::statistics::Estimate;
use gradient_mc::temperature::{ExponentialTemperature, Isothermal};
use gradient_mc::{Every, Field, Scene, Simulation, SimulationBuilder, Slab, TemperatureProfile};

/// One sphere, which has the profile n ∝ exp(−u): the drive is all there is.
fn one_sphere<F: Field, T: TemperatureProfile>(
    height: f64,
    field: F,
    temperature: T,
) -> SimulationBuilder<F, T> {
    let slab = Slab::new(height, 8.0, 8.0).unwrap();
    let scene = Scene::new(slab, 1, field, temperature).unwrap();
    Simulation::builder(scene).moves(LocalMoves::new(4.0).unwrap()).seed(11)
}

#[test]
fn one_sphere_in_a_uniform_field() {
    let temperature = 2.0;
    let builder = one_sphere(60.0, UniformField::default(), Isothermal::new(temperature).unwrap());
    let heights = center_of_mass(builder.build().unwrap(), 1_500_000, 10);
    agrees("mean height", heights.estimate().unwrap(), 0.5 + temperature, 0.01).unwrap();
    // Var(x) = T^2 for one sphere.
    agrees("variance", heights.variance().unwrap(), temperature * temperature, 0.06).unwrap();
}

#[test]
fn ideal_gas_under_a_lid() {
    let (temperature, height) = (15.0, 21.0);
    let builder = one_sphere(height, UniformField::default(), Isothermal::new(temperature).unwrap());
    let heights = center_of_mass(builder.build().unwrap(), 1_000_000, 20);
    let free = height - 1.0;
    let exact = 0.5 + temperature - free / (free / temperature).exp_m1();
    agrees("mean height", heights.estimate().unwrap(), exact, 0.06).unwrap();
}

#[test]
fn one_sphere_in_fields_that_vary() {
    let temperature = 4.0;
    let exponential = ExponentialField::new(0.2).unwrap();
    let builder = one_sphere(40.0, exponential, Isothermal::new(temperature).unwrap());
    let heights = center_of_mass(builder.build().unwrap(), 1_000_000, 10);
    let exact = mean_height(40.0, |x| (-(0.2 * x).exp_m1() / 0.2 / temperature).exp());
    agrees("exponential", heights.estimate().unwrap(), exact, 0.01).unwrap();

    let sum = SumField(UniformField::new(0.5).unwrap(), LinearField::new(-1.5, 0.2).unwrap());
    let builder = one_sphere(40.0, sum, Isothermal::new(temperature).unwrap());
    let heights = center_of_mass(builder.build().unwrap(), 1_000_000, 10);
    let exact = mean_height(40.0, |x| (-(-x + 0.1 * x * x) / temperature).exp());
    agrees("sum", heights.estimate().unwrap(), exact, 0.02).unwrap();
}

#[test]
fn one_sphere_where_both_fields_vary() {
    let (base, alpha, beta, height) = (6.0, 0.03, 0.05, 50.0);
    let field = ExponentialField::new(alpha).unwrap();
    let temperature = ExponentialTemperature::new(base, beta).unwrap();
    let closure = EquationOfStateClosure::new(IdealGas);
    let builder = one_sphere(height, field, temperature).scheme(closure);
    let heights = center_of_mass(builder.build().unwrap(), 1_000_000, 10);
    let exact = ideal_gas_mean(height, base, alpha, beta);
    agrees("closure", heights.estimate().unwrap(), exact, 0.02).unwrap();
}

#[test]
fn self_consistent_field_of_a_dilute_gas_is_the_ideal_one() {
    // So few spheres on so large a base that they hardly meet: Z − 1 is about 4·10⁻³ at the base.
    let (base, beta, height) = (4.0, 0.05, 40.0);
    let slab = Slab::new(height, 40.0, 40.0).unwrap();
    let field = UniformField::default();
    let temperature = ExponentialTemperature::new(base, beta).unwrap();
    let scene = Scene::new(slab, 16, field, temperature).unwrap();
    let mut simulation = Simulation::builder(scene)
        .scheme(SelfConsistent::default())
        .moves(LocalMoves::new(4.0).unwrap())
        .seed(3)
        .build()
        .unwrap();
    let mut observer = Every::new(10, CenterOfMass::new());
    simulation.equilibrate(200_000, &mut ()).unwrap();
    simulation.run(500_000, &mut observer).unwrap();
    let estimate = observer.observer.estimate().unwrap();
    let exact = ideal_gas_mean(height, base, 0.0, beta);
    // Excluded volume raises the mean by about 0.2 %, the frozen average adds its own error: allow for
    // both, and require that the error of a wrong rule (above 0.3) is far outside.
    assert!(estimate.standard_error < 0.02, "{estimate}");
    assert!((estimate.mean - exact).abs() < 0.06, "{estimate} against {exact}");
}

#[test]
fn two_spheres() {
    let slab = Slab::new(30.0, 3.0, 3.0).unwrap();
    let scene = Scene::new(slab, 2, UniformField::default(), Isothermal::new(1.0).unwrap()).unwrap();
    let build = || {
        let builder = Simulation::builder(scene).start(RandomInsertion::default());
        builder.moves(LocalMoves::new(1.2).unwrap()).seed(5).build().unwrap()
    };
    let heights = center_of_mass(build(), 4_000_000, 10);
    agrees("mean height", heights.estimate().unwrap(), TWO_SPHERES_MEAN, 0.003).unwrap();
    agrees("variance", heights.variance().unwrap(), TWO_SPHERES_VARIANCE, 0.005).unwrap();
}

/// A small column, some 10 diameters high, so that it relaxes within some hundred sweeps.
fn column(
    particles: usize,
    side: f64,
    temperature: f64,
    moves: LocalMoves,
    seed: u64,
) -> Simulation<UniformField, Isothermal> {
    let slab = Slab::new(60.0, side, side).unwrap();
    let temperature = Isothermal::new(temperature).unwrap();
    let scene = Scene::new(slab, particles, UniformField::default(), temperature).unwrap();
    Simulation::builder(scene).moves(moves).seed(seed).build().unwrap()
}

#[test]
fn contact_density_carries_the_weight() {
    let temperature = 3.0;
    let moves = LocalMoves::new(1.0).unwrap();
    let mut simulation = column(144, 6.0, temperature, moves, 22);
    // Bins of 0.02 from the contact height; the density there is the intercept of a parabola in ln n.
    let profile = DensityProfile::new(simulation.scene().slab(), Bins::count(10).from(0.5).to(0.7)).unwrap();
    let mut observer = Every::new(2, profile);
    simulation.equilibrate(10_000, &mut ()).unwrap();
    simulation.run(800_000, &mut observer).unwrap();
    let contact = observer.observer.jackknife(|bins| [contact_density(bins)]).unwrap()[0];
    let exact = simulation.scene().column_density() / temperature;
    agrees("contact density", contact, exact, 0.01 * exact).unwrap();
    assert!((contact.mean / exact - 1.0).abs() < 0.01, "{contact} against {exact}");
}

#[test]
fn fluctuation_of_the_center_of_mass() {
    // Var(h_c) = (T²/N) dh_c/dT, the derivative from two more runs.
    let (particles, temperature, step) = (48, 3.0, 0.3);
    let at = |temperature: f64, seed: u64, sweeps: u64| {
        center_of_mass(column(particles, 4.0, temperature, LocalMoves::tuned(), seed), sweeps, 5)
    };
    let (high, low) = (at(temperature + step, 32, 200_000), at(temperature - step, 33, 200_000));
    let (high, low) = (high.estimate().unwrap(), low.estimate().unwrap());
    let slope = (high.mean - low.mean) / (2.0 * step);
    let slope_error = high.standard_error.hypot(low.standard_error) / (2.0 * step);
    let factor = temperature * temperature / particles as f64;
    let expected = factor * slope;
    let variance = at(temperature, 31, 500_000).variance().unwrap();
    let difference = Estimate::new(
        variance.mean / expected - 1.0,
        variance.standard_error.hypot(factor * slope_error) / expected,
    );
    agrees("Var(h_c) N/T² over dh_c/dT, less 1", difference, 0.0, 0.025).unwrap();
    assert!(difference.mean.abs() < 0.10, "{difference}");
}
