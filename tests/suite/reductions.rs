//! Limits α → 0 and β → 0: results are continuous, and at 0 they have the same bits as the special
//! case.

use crate::common::scenes::NoInteraction;
use approx::assert_relative_eq;
use gradient_mc::drive::{Automatic, Drive, EquationOfStateClosure, Instantaneous, Scheme, SelfConsistent};
use gradient_mc::equation_of_state::EquationOfState;
use gradient_mc::field::{ExponentialField, LinearField, SumField, UniformField};
use gradient_mc::moves::LocalMoves;
use gradient_mc::start::ClosePacked;
use gradient_mc::temperature::{ExponentialTemperature, Isothermal, LinearTemperature, TabulatedTemperature};
use gradient_mc::{Field, Scene, Simulation, Slab, TemperatureProfile, Vector3};
use proptest::prelude::*;

/// Rates that are nothing, or nearly.
fn tiny_rate() -> impl Strategy<Value = f64> {
    prop_oneof![
        Just(0.0),
        Just(-0.0),
        Just(f64::MIN_POSITIVE),
        Just(5e-324),
        (-300.0..-15.0_f64, any::<bool>()).prop_map(|(power, up)| {
            let rate = 10_f64.powf(power);
            if up { rate } else { -rate }
        }),
    ]
}

fn slab() -> Slab {
    Slab::new(400.0, 25.0, 25.0).unwrap()
}

/// u at `height` under `scheme`.
fn reduced_potential<F, T, S>(field: F, temperature: T, scheme: S, height: f64) -> f64
where
    F: Field,
    T: TemperatureProfile,
    S: Scheme<F, T>,
{
    let scene = Scene::new(slab(), 25_000, field, temperature).unwrap();
    scheme.drive(&scene).unwrap().0.reduced_potential(&scene, height)
}

/// A hard-sphere equation of state of its own, so that the closure has something to close.
#[derive(Clone, Copy)]
struct CarnahanStarlingHere;

impl EquationOfState for CarnahanStarlingHere {
    fn compressibility_factor(&self, packing_fraction: f64) -> f64 {
        let eta = packing_fraction;
        (1.0 + eta + eta * eta - eta * eta * eta) / (1.0 - eta).powi(3)
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn exponential_field_becomes_uniform(rate in tiny_rate(), height in 0.0..400.0_f64) {
        let field = ExponentialField::new(rate).unwrap();
        prop_assert!((field.potential(height) - height).abs() <= 1e-12 * height);
        prop_assert!((field.acceleration(height) - 1.0).abs() <= 1e-12);
        if rate == 0.0 {
            prop_assert_eq!(field.potential(height).to_bits(), height.to_bits());
        }
    }

    /// Across the whole range of rates, against the Taylor series or the closed form.
    #[test]
    fn exponential_field_is_accurate_at_every_rate(power in -12.0..-1.0_f64, up in any::<bool>(), height in 0.5..400.0_f64) {
        let rate = if up { 10_f64.powf(power) } else { -10_f64.powf(power) };
        let exponent = rate * height;
        let series = (1..30).rev().fold(1.0, |sum, order| 1.0 + sum * exponent / f64::from(order + 1));
        let expected = if exponent.abs() < 1.0 { height * series } else { exponent.exp_m1() / rate };
        let potential = ExponentialField::new(rate).unwrap().potential(height);
        prop_assert!((potential - expected).abs() <= 1e-13 * expected, "{potential} against {expected}");
    }

    #[test]
    fn linear_and_summed_fields_become_uniform(slope in tiny_rate(), height in 0.0..400.0_f64) {
        let linear = LinearField::new(1.0, slope).unwrap();
        prop_assert!((linear.potential(height) - height).abs() <= 1e-12 * height);
        let sum = SumField(UniformField::default(), LinearField::new(0.0, slope).unwrap());
        prop_assert!((sum.potential(height) - height).abs() <= 1e-12 * height);
    }

    #[test]
    fn temperatures_become_constant(rate in tiny_rate(), height in 0.0..400.0_f64) {
        let exponential = ExponentialTemperature::new(20.0, rate).unwrap();
        let linear = LinearTemperature::new(20.0, rate).unwrap();
        prop_assert!((exponential.temperature(height) - 20.0).abs() <= 2e-11);
        prop_assert!((linear.temperature(height) - 20.0).abs() <= 2e-11);
        prop_assert!(exponential.logarithmic_gradient(height).abs() <= 1e-15);
        prop_assert!(linear.logarithmic_gradient(height).abs() <= 1e-15);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, ..ProptestConfig::default() })]

    #[test]
    fn drives_become_isothermal(rate in tiny_rate(), height in 0.5..399.5_f64, field_rate in -0.01..0.02_f64) {
        let field = ExponentialField::new(field_rate).unwrap();
        let temperature = ExponentialTemperature::new(20.0, rate).unwrap();
        let isothermal = reduced_potential(field, Isothermal::new(20.0).unwrap(), Automatic, height);
        let reduced = [
            reduced_potential(field, temperature, EquationOfStateClosure::new(NoInteraction), height),
            reduced_potential(field, temperature, EquationOfStateClosure::new(CarnahanStarlingHere), height),
            reduced_potential(field, temperature, SelfConsistent::default(), height),
            reduced_potential(field, temperature, Instantaneous::default(), height),
        ];
        for potential in reduced {
            if rate == 0.0 {
                prop_assert_eq!(potential.to_bits(), isothermal.to_bits());
            } else {
                prop_assert!((potential - isothermal).abs() <= 1e-12 * isothermal.abs());
            }
        }
    }
}

#[test]
fn drives_are_linear_in_a_small_decay_rate() {
    // u(β) = u(0) + β u₁ + O(β²): the odd part is the ideal-gas one x²/(2T) - x, the even part is
    // small.
    let rate = 1e-6;
    for height in [10.0, 120.0, 399.5] {
        let at = |rate: f64| {
            let temperature = ExponentialTemperature::new(20.0, rate).unwrap();
            let closure = EquationOfStateClosure::new(NoInteraction);
            let potential =
                |height: f64| reduced_potential(UniformField::default(), temperature, closure, height);
            potential(height) - potential(1.0)
        };
        let (above, middle, below) = (at(rate), at(0.0), at(-rate));
        let slope = (above - below) / (2.0 * rate);
        // At multiples of 0.1, where tables are exact, and half way between them alike to 1e-4.
        let odd = |height: f64| height * height / 40.0 - height;
        assert_relative_eq!(slope, odd(height) - odd(1.0), max_relative = 1e-4);
        let even = (above - middle) + (below - middle);
        assert!(even.abs() <= rate * rate * height.powi(3) / 20.0 + 1e-13 * middle, "{even}");
    }
}

/// Positions after a short run from the close-packed crystal, which does not use theory.
fn run<T: TemperatureProfile, S: Scheme<UniformField, T>>(temperature: T, scheme: S) -> Vec<Vector3<f64>> {
    let slab = Slab::new(60.0, 5.0, 5.0).unwrap();
    let scene = Scene::new(slab, 200, UniformField::default(), temperature).unwrap();
    let builder = Simulation::builder(scene).scheme(scheme).start(ClosePacked).seed(4);
    let mut simulation = builder.moves(LocalMoves::new(0.75).unwrap()).build().unwrap();
    simulation.equilibrate(150, &mut ()).unwrap();
    simulation.run(150, &mut ()).unwrap();
    simulation.positions()
}

#[test]
fn at_constant_temperature_all_schemes_make_the_same_run() {
    // 3 is not a power of two: a division by T and a product with 1/T would differ in the last bit.
    let isothermal = run(Isothermal::new(3.0).unwrap(), Automatic);
    let exponential = || ExponentialTemperature::new(3.0, 0.0).unwrap();
    assert_eq!(isothermal, run(exponential(), EquationOfStateClosure::default()));
    assert_eq!(isothermal, run(exponential(), SelfConsistent::default()));
    assert_eq!(isothermal, run(exponential(), Instantaneous::default()));
    assert_eq!(isothermal, run(LinearTemperature::new(3.0, 0.0).unwrap(), SelfConsistent::default()));
    let table = TabulatedTemperature::new(vec![(0.0, 3.0), (30.0, 3.0), (60.0, 3.0)]).unwrap();
    assert_eq!(isothermal, run(table, SelfConsistent::default()));
    // And the comparison is able to fail.
    let varying = ExponentialTemperature::new(3.0, 1e-2).unwrap();
    assert_ne!(isothermal, run(varying, EquationOfStateClosure::default()));
}
