//! Equations of state and the hydrostatic theory against references, closed forms and identities.
// Exact zeros and forwarded values are meant exactly; small types live beside the test that uses them.
#![allow(clippy::float_cmp, clippy::items_after_statements)]

use crate::common::scenes::Counted;
use approx::{assert_abs_diff_eq, assert_relative_eq};
use gradient_mc::equation_of_state::{
    CarnahanStarling, Coexistence, Domain, DomainSide, FREEZING, FluidSolid, HansenGoos, IdealGas,
    ModifiedKolafa, PercusYevickCompressibility, PercusYevickVirial, SpeedySolid, VirialSeries,
    number_density,
};
use gradient_mc::field::{ExponentialField, FieldFn, LinearField, UniformField};
use gradient_mc::hydrostatics::{HydrostaticProfile, Hydrostatics};
use gradient_mc::temperature::{
    ExponentialTemperature, Isothermal, LinearTemperature, TabulatedTemperature, TemperatureFn,
};
use gradient_mc::{EquationOfState, Error, Field, Slab, TemperatureProfile};
use proptest::prelude::*;
use std::f64::consts::PI;

/// The paper's scene: base at 0, 40 spheres per area, open.
fn paper<E: EquationOfState>(equation: E, t0: f64, alpha: f64, beta: f64) -> HydrostaticProfile {
    let field = ExponentialField::new(alpha).unwrap();
    let temperature = ExponentialTemperature::new(t0, beta).unwrap();
    Hydrostatics::new(field, temperature, equation).column_density(40.0).unwrap()
}

fn fluids() -> Vec<(&'static str, Box<dyn EquationOfState>)> {
    vec![
        ("ideal gas", Box::new(IdealGas)),
        ("Carnahan-Starling", Box::new(CarnahanStarling)),
        ("Percus-Yevick, compressibility", Box::new(PercusYevickCompressibility)),
        ("Percus-Yevick, virial", Box::new(PercusYevickVirial)),
        ("modified Kolafa", Box::new(ModifiedKolafa)),
        ("Hansen-Goos", Box::new(HansenGoos)),
        ("virial series", Box::new(VirialSeries::default())),
        ("fluid and solid", Box::new(spheres())),
    ]
}

fn spheres() -> FluidSolid<ModifiedKolafa, SpeedySolid> {
    FluidSolid::new(ModifiedKolafa, SpeedySolid, Coexistence::default()).unwrap()
}

/// Only Z, as a user would write it.
struct UserCarnahanStarling;
impl EquationOfState for UserCarnahanStarling {
    fn compressibility_factor(&self, eta: f64) -> f64 {
        (1.0 + eta + eta.powi(2) - eta.powi(3)) / (1.0 - eta).powi(3)
    }
}

// ---------------------------------------------------------------------------------------------
// Equations of state
// ---------------------------------------------------------------------------------------------

#[test]
fn derivatives_of_every_equation_are_consistent() {
    let mut equations = fluids();
    equations.push(("Speedy", Box::new(SpeedySolid)));
    for (name, equation) in &equations {
        let etas: &[f64] =
            if *name == "Speedy" { &[0.53, 0.56, 0.6, 0.7] } else { &[0.001, 0.05, 0.2, 0.35, 0.48] };
        for &eta in etas {
            let h = 1e-4 * eta;
            let slope = |f: &dyn Fn(f64) -> f64| {
                (8.0 * (f(eta + h) - f(eta - h)) - (f(eta + 2.0 * h) - f(eta - 2.0 * h))) / (12.0 * h)
            };
            let factor = |x: f64| equation.compressibility_factor(x);
            assert_relative_eq!(
                equation.compressibility_derivative(eta),
                eta * slope(&factor),
                max_relative = 1e-8,
                epsilon = 1e-12
            );
            // Gibbs and Duhem: η dμ/dη = d(ηZ)/dη, ideal part ln η taken off.
            let chemical_potential = |x: f64| equation.excess_chemical_potential(x);
            let duhem = (equation.compressibility_derivative(eta) + factor(eta) - 1.0) / eta;
            assert_relative_eq!(slope(&chemical_potential), duhem, max_relative = 1e-7, epsilon = 1e-9);
        }
    }
}

#[test]
fn chemical_potentials_start_at_zero_and_agree_with_the_integral() {
    struct OnlyZ<'a>(&'a dyn EquationOfState);
    impl EquationOfState for OnlyZ<'_> {
        fn compressibility_factor(&self, eta: f64) -> f64 {
            self.0.compressibility_factor(eta)
        }
    }
    for (name, equation) in fluids() {
        assert_eq!(equation.excess_chemical_potential(0.0), 0.0, "{name}");
        for eta in [1e-6, 0.1, 0.3, 0.45] {
            let integrated = OnlyZ(&equation).excess_chemical_potential(eta);
            let closed = equation.excess_chemical_potential(eta);
            assert_relative_eq!(closed, integrated, max_relative = 1e-11, epsilon = 1e-13);
        }
    }
}

#[test]
fn virial_coefficients_and_check_values() {
    for (name, equation) in fluids() {
        let b2 = if name == "ideal gas" { 0.0 } else { 4.0 };
        let b3 = if name == "ideal gas" { 0.0 } else { 10.0 };
        let eta = 1e-4;
        let factor = equation.compressibility_factor(eta);
        assert_abs_diff_eq!(factor, 1.0 + eta * (b2 + eta * b3), epsilon = 4e-11);
    }
    // B4 tells the closures from the exact series: CS 18, PY 19 and 16, exact 18.3648.
    let fourth = |equation: &dyn EquationOfState| {
        let eta = 1e-3;
        let z = |eta: f64| equation.compressibility_factor(eta) - 1.0 - 4.0 * eta - 10.0 * eta * eta;
        (16.0 * z(eta / 2.0) - z(eta)) / eta.powi(3)
    };
    assert_abs_diff_eq!(fourth(&CarnahanStarling), 18.0, epsilon = 1e-3);
    assert_abs_diff_eq!(fourth(&PercusYevickCompressibility), 19.0, epsilon = 1e-3);
    assert_abs_diff_eq!(fourth(&PercusYevickVirial), 16.0, epsilon = 1e-3);
    assert_abs_diff_eq!(fourth(&ModifiedKolafa), 18.364_768, epsilon = 1e-3);
    assert_abs_diff_eq!(fourth(&VirialSeries::default()), 18.364_768, epsilon = 1e-3);

    assert_abs_diff_eq!(ModifiedKolafa.compressibility_factor(0.20), 2.409_40, epsilon = 5e-6);
    assert_abs_diff_eq!(ModifiedKolafa.compressibility_factor(0.45), 9.404, epsilon = 5e-4);
    // Stated accuracies against the best equation.
    let deviation = |equation: &dyn EquationOfState, eta: f64| {
        equation.compressibility_factor(eta) / ModifiedKolafa.compressibility_factor(eta) - 1.0
    };
    assert!((1..50).all(|i| deviation(&CarnahanStarling, 0.01 * f64::from(i)).abs() < 0.003));
    assert_abs_diff_eq!(deviation(&PercusYevickCompressibility, FREEZING), 0.07, epsilon = 0.01);
    assert_abs_diff_eq!(deviation(&PercusYevickVirial, FREEZING), -0.15, epsilon = 0.01);
    assert_abs_diff_eq!(deviation(&VirialSeries::default(), 0.4), -0.0036, epsilon = 2e-4);
}

#[test]
fn inversion_returns_the_packing_fraction_it_came_from() {
    for (name, equation) in fluids() {
        for eta in [1e-300, 1e-12, 0.003, 0.1, 0.3, 0.48] {
            let reduced_pressure = number_density(eta) * equation.compressibility_factor(eta);
            for guess in [None, Some(eta), Some(0.5 * eta), Some((1.5 * eta).min(0.49))] {
                let back = equation.packing_fraction_at(reduced_pressure, guess);
                assert_relative_eq!(back.expect(name), eta, max_relative = 1e-12);
            }
        }
        assert_eq!(equation.packing_fraction_at(0.0, None), Some(0.0), "{name}");
        for wrong in [f64::NAN, -1.0, f64::INFINITY] {
            assert_eq!(equation.packing_fraction_at(wrong, None), None, "{name} at {wrong}");
        }
    }
    // Beyond the pressure of freezing, and of close packing of nothing in particular.
    for reduced_pressure in [20.0, 1e3, 1e9] {
        let eta = CarnahanStarling.packing_fraction_at(reduced_pressure, None).unwrap();
        assert!(eta < 1.0);
        let back = number_density(eta) * CarnahanStarling.compressibility_factor(eta);
        assert_relative_eq!(back, reduced_pressure, max_relative = 1e-8);
        let solid = SpeedySolid.packing_fraction_at(reduced_pressure, None).unwrap();
        assert!(solid > 0.59 && solid < gradient_mc::equation_of_state::CLOSE_PACKING);
    }
}

#[test]
fn inversion_tells_when_there_is_no_state() {
    // The polynomial has a maximum at 0.571.
    let maximum = (5000..7000)
        .map(|i| 1e-4 * f64::from(i))
        .map(|eta| number_density(eta) * ModifiedKolafa.compressibility_factor(eta))
        .fold(0.0, f64::max);
    let below = ModifiedKolafa.packing_fraction_at(0.9999 * maximum, None).unwrap();
    assert!(below > 0.56 && below < 0.571, "{below}");
    assert!(ModifiedKolafa.compressibility_derivative(below) > -ModifiedKolafa.compressibility_factor(below));
    for factor in [1.0001, 2.0, 1e6] {
        for guess in [None, Some(0.3), Some(0.7)] {
            assert_eq!(ModifiedKolafa.packing_fraction_at(factor * maximum, guess), None);
        }
    }
    // A solid has no dilute state, and the pole below its domain is never entered.
    assert_eq!(SpeedySolid.packing_fraction_at(1.0, None), None);
    assert_eq!(SpeedySolid.packing_fraction_at(1.0, Some(0.6)), None);
    assert_eq!(SpeedySolid.packing_fraction_at(0.0, None), None);
    struct NotANumber;
    impl EquationOfState for NotANumber {
        fn compressibility_factor(&self, _: f64) -> f64 {
            f64::NAN
        }
    }
    assert_eq!(NotANumber.packing_fraction_at(1.0, None), None);
    // P = n(1 - η): a maximum at 1/2, no state beyond n/2 of there.
    struct Falling;
    impl EquationOfState for Falling {
        fn compressibility_factor(&self, eta: f64) -> f64 {
            1.0 - eta
        }
    }
    let at = |eta: f64| number_density(eta) * (1.0 - eta);
    assert_relative_eq!(Falling.packing_fraction_at(at(0.45), None).unwrap(), 0.45, max_relative = 1e-11);
    assert_eq!(Falling.packing_fraction_at(1.001 * at(0.5), None), None);
}

#[test]
fn fluid_and_solid_meet_at_the_pressure_of_coexistence() {
    let joined = spheres();
    let cuts = joined.coexistence();
    assert_abs_diff_eq!(cuts.fluid, 0.4918, epsilon = 5e-5);
    assert_abs_diff_eq!(cuts.solid, 0.5434, epsilon = 5e-5);
    let reduced_pressure = |eta: f64| number_density(eta) * joined.compressibility_factor(eta);
    for eta in [cuts.fluid, 0.5, 0.52, 0.54, cuts.solid] {
        assert_relative_eq!(reduced_pressure(eta), 11.5727, max_relative = 1e-12);
    }
    assert_eq!(joined.compressibility_factor(0.4), ModifiedKolafa.compressibility_factor(0.4));
    assert_eq!(joined.compressibility_factor(0.6), SpeedySolid.compressibility_factor(0.6));
    for (pressure, eta) in [(11.5727 - 1e-9, cuts.fluid), (11.5727 + 1e-9, cuts.solid)] {
        for guess in [None, Some(0.3), Some(0.52), Some(0.6)] {
            let found = joined.packing_fraction_at(pressure, guess).unwrap();
            assert_abs_diff_eq!(found, eta, epsilon = 1e-9);
        }
    }
    // Total chemical potential ln n + μ_ex the same all along the transition ...
    let total = |eta: f64| number_density(eta).ln() + joined.excess_chemical_potential(eta);
    assert_abs_diff_eq!(total(cuts.solid), total(cuts.fluid), epsilon = 1e-12);
    assert_abs_diff_eq!(total(0.52), total(cuts.fluid), epsilon = 1e-12);
    // ... and the two equations agree about it on their own, the solid's constant being measured.
    let solid = number_density(cuts.solid).ln() + SpeedySolid.excess_chemical_potential(cuts.solid);
    assert_abs_diff_eq!(solid, total(cuts.fluid), epsilon = 3e-4);

    let coexistence = |reduced_pressure| Coexistence { reduced_pressure, ..Coexistence::default() };
    for pressure in [f64::NAN, -1.0, 0.1, 1e6] {
        let joined = FluidSolid::new(ModifiedKolafa, SpeedySolid, coexistence(pressure));
        assert!(matches!(joined, Err(Error::InvalidParameter { .. })), "{pressure}");
    }
    let reversed = FluidSolid::new(SpeedySolid, CarnahanStarling, coexistence(11.5727));
    assert!(matches!(reversed, Err(Error::InvalidParameter { .. })), "{reversed:?}");
}

#[test]
fn pointers_forward_every_method() {
    struct Odd;
    impl EquationOfState for Odd {
        fn compressibility_factor(&self, _: f64) -> f64 {
            2.0
        }
        fn compressibility_derivative(&self, _: f64) -> f64 {
            3.0
        }
        fn excess_chemical_potential(&self, _: f64) -> f64 {
            4.0
        }
        fn domain(&self) -> Domain {
            Domain { lowest: 0.25, highest: 0.5 }
        }
        fn packing_fraction_at(&self, _: f64, _: Option<f64>) -> Option<f64> {
            Some(5.0)
        }
    }
    fn check(equation: impl EquationOfState) {
        assert_eq!(equation.compressibility_factor(0.1), 2.0);
        assert_eq!(equation.compressibility_derivative(0.1), 3.0);
        assert_eq!(equation.excess_chemical_potential(0.1), 4.0);
        assert_eq!(equation.domain().side(0.2), Some(DomainSide::Below));
        assert_eq!(equation.packing_fraction_at(1.0, None), Some(5.0));
    }
    check(&Odd);
    let boxed: Box<dyn EquationOfState> = Box::new(Odd);
    check(boxed);
}

// ---------------------------------------------------------------------------------------------
// Hydrostatics against the reference solvers
// ---------------------------------------------------------------------------------------------

/// Compares a file of reference columns; returns the worst relative deviation of base, center of
/// mass and profile.
fn compare_with_reference<E: EquationOfState + Copy>(file: &str, equation: E) -> [f64; 3] {
    let path = format!("{}/tests/reference/{file}", env!("CARGO_MANIFEST_DIR"));
    let mut reader = csv::Reader::from_path(path).unwrap();
    let header = reader.headers().unwrap().clone();
    let mut worst = [0.0_f64; 3];
    let mut rows = 0;
    for row in reader.records() {
        let row = row.unwrap();
        let text = |name: &str| row.get(header.iter().position(|title| title == name).unwrap()).unwrap();
        let value = |name: &str| text(name).parse::<f64>().unwrap();
        let profile = paper(equation, value("T0"), value("alpha"), value("beta"));
        let scene = format!("{file}, T0 {}, alpha {}, beta {}", text("T0"), text("alpha"), text("beta"));
        assert_relative_eq!(profile.column_density(), 40.0, max_relative = 1e-12);
        // Method A carries the reference's own error of up to 1e-12.
        for (slot, name, found) in [
            (0, "n0", profile.number_density(0.0)),
            (0, "P0_weight", profile.base_pressure()),
            (0, "eta0", profile.base_packing_fraction()),
            (1, "hc", profile.center_of_mass()),
            (0, "n_max", profile.density_maximum().1),
        ] {
            let deviation = (found / value(name) - 1.0).abs();
            assert!(deviation < 1e-11, "{scene}: {name} off by {deviation:e}");
            worst[slot] = worst[slot].max(deviation);
        }
        assert_abs_diff_eq!(profile.density_maximum().0, value("x_max"), epsilon = 1e-7);
        if !text("xm_closed").is_empty() {
            assert_abs_diff_eq!(profile.density_maximum().0, value("xm_closed"), epsilon = 1e-7);
        }
        for height in ["1", "5", "10", "20", "50", "100", "200", "400"] {
            let expected = value(&format!("n_{height}"));
            let found = profile.number_density(height.parse().unwrap());
            let error = (found - expected).abs();
            assert!(error < 1e-8 * expected + 1e-12, "{scene}: n({height}) = {found:e}, not {expected:e}");
            worst[2] = worst[2].max(error / (expected + 1e-12));
        }
        rows += 1;
    }
    assert_eq!(rows, 13);
    worst
}

#[test]
fn every_reference_column_is_reproduced() {
    let carnahan_starling = compare_with_reference("hydro_CS_xb0.csv", CarnahanStarling);
    let ideal = compare_with_reference("hydro_ideal_xb0.csv", IdealGas);
    println!("worst deviations of n(0), h_c, n(x): {carnahan_starling:?} {ideal:?}");
}

#[test]
fn a_column_takes_few_evaluations() {
    let scenes = [
        (5.0, 0.0, 0.0),
        (30.0, 0.0, 0.0),
        (20.0, 0.0025, 0.0),
        (20.0, 0.1, 0.0),
        (20.0, 0.0, 0.005),
        (20.0, 0.0, 0.05),
    ];
    for (t0, alpha, beta) in scenes {
        let field = Counted::new(ExponentialField::new(alpha).unwrap());
        let temperature = ExponentialTemperature::new(t0, beta).unwrap();
        Hydrostatics::new(&field, temperature, CarnahanStarling).column_density(40.0).unwrap();
        let evaluations = field.take();
        println!("T0 {t0}, alpha {alpha}, beta {beta}: {evaluations}");
        assert!(evaluations < 100_000, "T0 {t0}, alpha {alpha}, beta {beta}: {evaluations}");
    }
}

#[test]
fn freezing_is_flagged_and_only_then() {
    let frozen = paper(CarnahanStarling, 20.0, 0.1, 0.0);
    let exit = frozen.domain_exit().unwrap();
    assert_eq!(exit.side, DomainSide::Above);
    assert_eq!((exit.lowest_height, exit.limit), (0.0, FREEZING));
    assert_relative_eq!(exit.packing_fraction, 0.570_408_793_213_238, max_relative = 1e-10);
    assert_relative_eq!(frozen.packing_fraction(exit.highest_height), FREEZING, max_relative = 1e-9);
    // n = 0.9391 between two rows of the tabulated column.
    assert_abs_diff_eq!(exit.highest_height, 31.94, epsilon = 0.01);
    for (t0, alpha, beta) in [(5.0, 0.0, 0.0), (20.0, 0.05, 0.0), (20.0, 0.0, 0.05)] {
        assert_eq!(paper(CarnahanStarling, t0, alpha, beta).domain_exit(), None);
    }
    assert_eq!(paper(spheres(), 20.0, 0.1, 0.0).domain_exit(), None);
    assert_eq!(paper(IdealGas, 20.0, 0.1, 0.0).domain_exit(), None);
    // Freezing in the middle of a column: cold in a belt.
    let belt = TemperatureFn(|x: f64| if (10.0..15.0).contains(&x) { 2.0 } else { 20.0 });
    let column = Hydrostatics::new(UniformField::default(), belt, CarnahanStarling);
    let exit = column.column_density(40.0).unwrap().domain_exit().unwrap();
    assert_abs_diff_eq!(exit.lowest_height, 10.0, epsilon = 1e-9);
    assert_abs_diff_eq!(exit.highest_height, 15.0, epsilon = 1e-9);
}

#[test]
fn crystal_below_fluid_as_in_the_reference() {
    let path = format!("{}/tests/reference/alpha0.1_KLM+Speedy.csv", env!("CARGO_MANIFEST_DIR"));
    let coexistence = Coexistence { reduced_pressure: 11.57, ..Coexistence::default() };
    let joined = FluidSolid::new(ModifiedKolafa, SpeedySolid, coexistence).unwrap();
    let profile = paper(joined, 20.0, 0.1, 0.0);
    let mut rows = 0;
    for row in csv::Reader::from_path(path).unwrap().records() {
        let row: Vec<f64> = row.unwrap().iter().map(|field| field.parse().unwrap()).collect();
        let reduced_pressure = profile.pressure(row[0]) / 20.0;
        assert_abs_diff_eq!(profile.number_density(row[0]), row[1], epsilon = 1e-5);
        assert_abs_diff_eq!(reduced_pressure, row[2], epsilon = 3e-4);
        rows += 1;
    }
    assert_eq!(rows, 91);
    // The front: 27.8, with 31.6 of the 40 spheres below it.
    let profile = paper(spheres(), 20.0, 0.1, 0.0);
    let cuts = spheres().coexistence();
    let front = front(&profile);
    assert_abs_diff_eq!(front, 27.8, epsilon = 0.05);
    assert_abs_diff_eq!(profile.column_below(front), 31.6, epsilon = 0.1);
    assert_relative_eq!(profile.packing_fraction(front - 1e-6), cuts.solid, max_relative = 1e-6);
    assert_relative_eq!(profile.packing_fraction(front + 1e-6), cuts.fluid, max_relative = 1e-6);
    assert_relative_eq!(profile.pressure(front) / 20.0, 11.5727, max_relative = 1e-10);
}

/// Height at which a crystal ends.
fn front(profile: &HydrostaticProfile) -> f64 {
    let (mut low, mut high) = (20.0, 35.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if profile.packing_fraction(middle) > 0.52 { low = middle } else { high = middle }
    }
    low
}

/// What is not known about coexistence moves the front of the paper's column at alpha = 0.1 by less
/// than 0.003 d: the measured pressure within its error, another fluid, the pressure of equal
/// chemical potentials. The older P/T = 11.56 differs by 0.014 d, a crystal of 0.1 % more pressure
/// by 0.01 d.
#[test]
fn the_front_of_the_crystal_is_known() {
    let at = |reduced_pressure| Coexistence { reduced_pressure, ..Coexistence::default() };
    let join = |pressure| FluidSolid::new(ModifiedKolafa, SpeedySolid, at(pressure)).unwrap();
    let of = |equation: &dyn EquationOfState| front(&paper(equation, 20.0, 0.1, 0.0));
    let expected = of(&spheres());
    println!("front at {expected:.4}");
    for (name, equation, limit) in [
        ("P/T lower by its error", Box::new(join(11.5717)) as Box<dyn EquationOfState>, 0.002),
        ("P/T higher by its error", Box::new(join(11.5737)), 0.002),
        ("Hansen-Goos", Box::new(FluidSolid::new(HansenGoos, SpeedySolid, at(11.5727)).unwrap()), 0.002),
        (
            "equal chemical potentials",
            Box::new(FluidSolid::in_equilibrium(ModifiedKolafa, SpeedySolid).unwrap()),
            0.01,
        ),
        (
            "the same, Hansen-Goos",
            Box::new(FluidSolid::in_equilibrium(HansenGoos, SpeedySolid).unwrap()),
            0.01,
        ),
    ] {
        let off = of(&equation) - expected;
        println!("{name}: {off:+.5}");
        assert!(off.abs() < limit, "{name}: {off}");
    }
    struct Stiffer;
    impl EquationOfState for Stiffer {
        fn compressibility_factor(&self, eta: f64) -> f64 {
            1.001 * SpeedySolid.compressibility_factor(eta)
        }
        fn domain(&self) -> Domain {
            SpeedySolid.domain()
        }
    }
    let stiffer = FluidSolid::new(ModifiedKolafa, Stiffer, at(11.5727)).unwrap();
    for (name, off) in
        [("P/T = 11.56", of(&join(11.56)) - expected), ("a stiffer crystal", of(&stiffer) - expected)]
    {
        println!("{name}: {off:+.4}");
        assert!((0.005..0.03).contains(&off), "{name}: {off}");
    }
}

/// Two independent equations of state and the free energy of the crystal give the pressure that
/// simulations of coexistence found; Carnahan-Starling does not.
#[test]
fn chemical_potentials_agree_where_simulations_have_coexistence() {
    let pressure = |joined: Coexistence| joined.reduced_pressure;
    let kolafa = FluidSolid::in_equilibrium(ModifiedKolafa, SpeedySolid).unwrap();
    let hansen_goos = FluidSolid::in_equilibrium(HansenGoos, SpeedySolid).unwrap();
    let carnahan_starling = FluidSolid::in_equilibrium(CarnahanStarling, SpeedySolid).unwrap();
    assert_abs_diff_eq!(pressure(kolafa.coexistence()), 11.5707, epsilon = 1e-4);
    assert_abs_diff_eq!(pressure(hansen_goos.coexistence()), 11.5715, epsilon = 1e-4);
    let off = pressure(carnahan_starling.coexistence()) - 11.5727;
    assert!(off.abs() > 0.01, "{off}");
    // At the cuts both branches have the same total chemical potential, with their own constants.
    let cuts = kolafa.coexistence();
    let total = |eta: f64, excess: f64| number_density(eta).ln() + excess;
    let fluid = total(cuts.fluid, ModifiedKolafa.excess_chemical_potential(cuts.fluid));
    let solid = total(cuts.solid, SpeedySolid.excess_chemical_potential(cuts.solid));
    assert_abs_diff_eq!(fluid, solid, epsilon = 1e-11);
    let never = FluidSolid::in_equilibrium(IdealGas, SpeedySolid);
    assert!(matches!(never, Err(Error::InvalidParameter { .. })), "{never:?}");
}

// ---------------------------------------------------------------------------------------------
// Closed forms and identities
// ---------------------------------------------------------------------------------------------

/// Where ln P has fallen to within a rounding of the transition, a panel must still get across:
/// this column's did not.
#[test]
fn a_transition_is_crossed_where_rounding_would_stop_it() {
    let slab = Slab::new(400.0, 5.0, 5.0).unwrap();
    let center = |rate: f64| {
        let field = ExponentialField::new(rate).unwrap();
        let theory = Hydrostatics::new(field, Isothermal::new(5.0).unwrap(), FluidSolid::default());
        theory.between_walls(&slab, 40.0).unwrap().center_of_mass()
    };
    let [below, at, above] = [0.0199, 0.02, 0.0201].map(center);
    assert!(below > at && at > above);
    assert!((at - 0.5 * (below + above)).abs() < 1e-3, "{below} {at} {above}");
}

#[test]
fn ideal_gas_follows_the_barometric_law() {
    for (t0, alpha, beta) in [(20.0, 0.02, 0.03), (5.0, 0.1, -0.02), (15.0, 0.0, 0.05), (9.0, -0.01, 0.04)] {
        let profile = paper(IdealGas, t0, alpha, beta);
        let rate: f64 = alpha + beta;
        for x in [0.3, 2.0, 11.0, 27.0, 60.0] {
            let exact = -((rate * x).exp_m1() / (rate * t0)) + beta * x;
            let found = (profile.number_density(x) / profile.number_density(0.0)).ln();
            assert_abs_diff_eq!(found, exact, epsilon = 1e-11 * exact.abs().max(1.0));
        }
    }
}

#[test]
fn ideal_gas_under_a_lid() {
    for t in [5.0, 20.0, 300.0, 1e5] {
        for sign in [1.0, -1.0] {
            let field = UniformField::new(sign).unwrap();
            let column = Hydrostatics::new(field, Isothermal::new(t).unwrap(), IdealGas).base(0.5).lid(399.5);
            let profile = column.column_density(40.0).unwrap();
            let depth = t - 399.0 / (399.0 / t).exp_m1();
            let mean = if sign > 0.0 { 0.5 + depth } else { 399.5 - depth };
            assert_relative_eq!(profile.center_of_mass(), mean, max_relative = 1e-11);
            let weight = profile.base_pressure() - profile.lid_pressure();
            assert_relative_eq!(weight, sign * 40.0, max_relative = 1e-10);
            assert_eq!(profile.number_density(0.49), 0.0);
            assert_eq!(profile.number_density(399.51), 0.0);
        }
    }
}

#[test]
fn weightless_box_is_uniform() {
    let temperature = ExponentialTemperature::new(5.0, 0.01).unwrap();
    let field = UniformField::new(0.0).unwrap();
    let profile = Hydrostatics::new(field, Isothermal::new(5.0).unwrap(), CarnahanStarling)
        .lid(50.0)
        .column_density(25.0)
        .unwrap();
    for x in [0.0, 13.3, 50.0] {
        assert_relative_eq!(profile.number_density(x), 0.5, max_relative = 1e-12);
    }
    assert_relative_eq!(profile.center_of_mass(), 25.0, max_relative = 1e-12);
    // With a temperature gradient the pressure is uniform, not the density.
    let profile =
        Hydrostatics::new(field, temperature, CarnahanStarling).lid(50.0).column_density(25.0).unwrap();
    assert_relative_eq!(profile.pressure(50.0), profile.base_pressure(), max_relative = 1e-12);
    assert!(profile.number_density(50.0) > profile.number_density(0.0) + 0.05);
}

#[test]
fn strong_pull_upwards_leaves_the_base_empty() {
    let field = UniformField::new(-10.0).unwrap();
    let column = Hydrostatics::new(field, Isothermal::new(1.0).unwrap(), IdealGas).lid(399.0);
    let profile = column.column_density(0.01).unwrap();
    assert_eq!(profile.number_density(0.0), 0.0);
    assert_relative_eq!(profile.number_density(399.0), 0.1, max_relative = 1e-9);
    assert_relative_eq!(profile.center_of_mass(), 398.9, max_relative = 1e-11);
}

/// Fourth-order Runge-Kutta for eq. (7), independent of the library's way through ln P.
fn runge_kutta(
    n0: f64,
    height: f64,
    steps: u32,
    field: &impl Field,
    temperature: &impl TemperatureProfile,
    equation: &impl EquationOfState,
) -> f64 {
    let slope = |x: f64, ln_n: f64| {
        let eta = PI / 6.0 * ln_n.exp();
        let z = equation.compressibility_factor(eta);
        let numerator =
            field.acceleration(x) / (temperature.temperature(x) * z) + temperature.logarithmic_gradient(x);
        -numerator / (1.0 + equation.compressibility_derivative(eta) / z)
    };
    let h = height / f64::from(steps);
    let mut y = n0.ln();
    for step in 0..steps {
        let x = h * f64::from(step);
        let k1 = slope(x, y);
        let k2 = slope(x + 0.5 * h, y + 0.5 * h * k1);
        let k3 = slope(x + 0.5 * h, y + 0.5 * h * k2);
        let k4 = slope(x + h, y + h * k3);
        y += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    y.exp()
}

#[test]
fn both_fields_varying_agree_with_equation_7() {
    let field = LinearField::new(0.5, 0.02).unwrap();
    let temperature = TemperatureFn(|x: f64| 10.0 + 4.0 * (x / 7.0).sin());
    let profile = Hydrostatics::new(field, temperature, ModifiedKolafa).column_density(30.0).unwrap();
    for height in [5.0, 20.0, 45.0] {
        let expected =
            runge_kutta(profile.number_density(0.0), height, 4000, &field, &temperature, &ModifiedKolafa);
        assert_relative_eq!(profile.number_density(height), expected, max_relative = 1e-9);
    }
    // The column density by an independent quadrature.
    let h = 240.0 / 24_000.0;
    let simpson: f64 = (0..=24_000)
        .map(|i| {
            let weight = if i == 0 || i == 24_000 { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
            weight * profile.number_density(h * f64::from(i))
        })
        .sum::<f64>()
        * h
        / 3.0;
    assert_relative_eq!(simpson, 30.0, max_relative = 1e-10);
}

#[test]
fn pressure_balances_weight_and_obeys_the_equation_of_state() {
    let field = ExponentialField::new(0.03).unwrap();
    let temperature = ExponentialTemperature::new(15.0, 0.01).unwrap();
    let profile = Hydrostatics::new(field, temperature, CarnahanStarling).column_density(40.0).unwrap();
    for x in [0.5, 3.3, 17.0, 41.9, 66.0] {
        let h = 0.02;
        let p = |x| profile.pressure(x);
        let slope = (8.0 * (p(x + h) - p(x - h)) - (p(x + 2.0 * h) - p(x - 2.0 * h))) / (12.0 * h);
        assert_relative_eq!(slope, -field.acceleration(x) * profile.number_density(x), max_relative = 1e-8);
        let z = CarnahanStarling.compressibility_factor(profile.packing_fraction(x));
        let expected = profile.number_density(x) * temperature.temperature(x) * z;
        assert_relative_eq!(p(x), expected, max_relative = 1e-11);
    }
}

#[test]
fn maximum_obeys_its_closed_form() {
    for beta in [0.02_f64, 0.03, 0.05, 0.08] {
        let profile = paper(CarnahanStarling, 20.0, 0.0, beta);
        let (height, density) = profile.density_maximum();
        let z = CarnahanStarling.compressibility_factor(PI / 6.0 * density);
        assert_abs_diff_eq!(height, (20.0 * z * beta).ln() / beta, epsilon = 1e-8);
        // alpha = 0: P = n/beta there.
        assert_relative_eq!(profile.pressure(height), density / beta, max_relative = 1e-10);
        assert!(
            profile.number_density(height - 0.3) < density && profile.number_density(height + 0.3) < density
        );
    }
    assert_eq!(paper(CarnahanStarling, 20.0, 0.0, 0.0).density_maximum().0, 0.0);
}

#[test]
fn jumps_of_temperature_stay_jumps() {
    let jump = 17.3;
    let temperature = TemperatureFn(move |x: f64| if x < jump { 20.0 } else { 8.0 });
    let column = Hydrostatics::new(UniformField::default(), temperature, CarnahanStarling);
    let profile = column.column_density(40.0).unwrap();
    // The pressure goes through, and in a uniform field it is the weight above.
    for x in [0.0, 10.0, jump - 1e-9, jump + 1e-9, 25.0, 60.0] {
        assert_relative_eq!(profile.pressure(x), profile.column_above(x), max_relative = 1e-10);
        let eta = CarnahanStarling
            .packing_fraction_at(profile.pressure(x) / temperature.temperature(x), None)
            .unwrap();
        assert_relative_eq!(profile.packing_fraction(x), eta, max_relative = 1e-10);
    }
    assert_relative_eq!(profile.base_pressure(), 40.0, max_relative = 1e-11);
    // No ringing: falling on both sides.
    let falling = |low: f64, high: f64| {
        (0..2000)
            .map(|i| profile.number_density(low + (high - low) * f64::from(i) / 2000.0))
            .collect::<Vec<_>>()
            .windows(2)
            .all(|pair| pair[1] <= pair[0])
    };
    assert!(falling(16.0, jump) && falling(jump + 1e-12, 18.0));
    assert!(profile.number_density(jump + 1e-9) > profile.number_density(jump - 1e-9) + 0.1);
    let (height, density) = profile.density_maximum();
    assert_abs_diff_eq!(height, jump, epsilon = 1e-9);
    assert_relative_eq!(density, profile.number_density(jump + 1e-10), max_relative = 1e-9);
    // Kinks: the same balance for a table.
    let table = TabulatedTemperature::new(vec![(0.0, 20.0), (12.3, 6.0), (40.0, 15.0)]).unwrap();
    let profile =
        Hydrostatics::new(UniformField::default(), &table, CarnahanStarling).column_density(40.0).unwrap();
    for x in [0.0, 12.3, 12.4, 39.9, 40.1, 70.0] {
        assert_relative_eq!(profile.pressure(x), profile.column_above(x), max_relative = 1e-10);
    }
}

#[test]
fn a_jump_is_found_wherever_it_falls() {
    // The first panels are 2 wide, and a jump just below or on their ends lies beyond the last node.
    for jump in [1e-3, 1.9, 1.991, 1.995, 1.999, 2.0, 2.001, 4.0, 16.0, 39.99] {
        let temperature = TemperatureFn(move |x: f64| if x < jump { 20.0 } else { 8.0 });
        let column = Hydrostatics::new(UniformField::default(), temperature, CarnahanStarling);
        let profile = column.column_density(40.0).unwrap();
        assert_relative_eq!(profile.base_pressure(), 40.0, max_relative = 1e-10);
        assert_abs_diff_eq!(profile.density_maximum().0, jump, epsilon = 1e-11);
        // A jump of the field, from gravity 1 to 3: the weight above it counts three times.
        struct Step(f64);
        impl Field for Step {
            fn potential(&self, x: f64) -> f64 {
                x + 2.0 * (x - self.0).max(0.0)
            }
            fn acceleration(&self, x: f64) -> f64 {
                if x < self.0 { 1.0 } else { 3.0 }
            }
        }
        let warm = Isothermal::new(20.0).unwrap();
        let profile = Hydrostatics::new(Step(jump), warm, CarnahanStarling).column_density(40.0).unwrap();
        let weight = profile.column_below(jump) + 3.0 * profile.column_above(jump);
        assert_relative_eq!(profile.base_pressure(), weight, max_relative = 1e-10);
    }
    // A front of the crystal, at many places.
    for step in 0..40 {
        let profile = paper(spheres(), 20.0, 0.1 + 1e-3 * f64::from(step), 0.0);
        let alpha = 0.1 + 1e-3 * f64::from(step);
        let (mut low, mut high) = (5.0, 40.0);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if profile.packing_fraction(middle) > 0.52 { low = middle } else { high = middle }
        }
        let weight = |low: f64, high: f64| {
            let h = (high - low) / 2000.0;
            (0..=2000)
                .map(|i| {
                    let factor = if i == 0 || i == 2000 { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
                    let x = low + h * f64::from(i);
                    factor * (alpha * x).exp() * profile.number_density(x)
                })
                .sum::<f64>()
                * h
                / 3.0
        };
        let weight = weight(0.0, low - 1e-11) + weight(high + 1e-11, 60.0);
        assert_relative_eq!(profile.base_pressure(), weight, max_relative = 1e-9);
    }
}

#[test]
fn a_closure_field_gives_the_profile_of_its_type() {
    let slab = Slab::new(400.0, 10.0, 10.0).unwrap();
    let closure = FieldFn::new(|x: f64| (0.02 * x).exp(), &slab).unwrap();
    let temperature = Isothermal::new(20.0).unwrap();
    let profile =
        Hydrostatics::new(&closure, temperature, CarnahanStarling).lid(400.0).column_density(40.0).unwrap();
    assert_relative_eq!(profile.center_of_mass(), 31.922_681_144_164, max_relative = 1e-11);
    // A field of which only the potential is known: its slope is a difference, with the rounding of
    // one.
    struct OnlyPotential;
    impl Field for OnlyPotential {
        fn potential(&self, height: f64) -> f64 {
            height
        }
    }
    let profile =
        Hydrostatics::new(OnlyPotential, temperature, CarnahanStarling).column_density(40.0).unwrap();
    assert_relative_eq!(profile.center_of_mass(), 49.177_638_979_96, max_relative = 1e-9);
}

#[test]
fn an_equation_with_only_z_gives_the_same_profile() {
    for (t0, alpha, beta) in [(5.0, 0.0, 0.0), (20.0, 0.1, 0.0), (20.0, 0.0, 0.05)] {
        let (own, user) =
            (paper(CarnahanStarling, t0, alpha, beta), paper(UserCarnahanStarling, t0, alpha, beta));
        assert_relative_eq!(own.center_of_mass(), user.center_of_mass(), max_relative = 1e-10);
        for x in [0.0, 7.7, 25.0, 36.0] {
            assert_relative_eq!(own.number_density(x), user.number_density(x), max_relative = 1e-9);
        }
    }
    let boxed: Box<dyn EquationOfState> = Box::new(UserCarnahanStarling);
    assert!(paper(boxed, 20.0, 0.0, 0.0).center_of_mass() > 49.0);
}

#[test]
fn base_pressure_is_the_inverse_of_column_density() {
    let field = ExponentialField::new(0.02).unwrap();
    let temperature = ExponentialTemperature::new(20.0, 0.02).unwrap();
    let column = Hydrostatics::new(&field, &temperature, ModifiedKolafa);
    for spheres in [1e-3, 1.0, 40.0, 60.0] {
        let there = column.column_density(spheres).unwrap();
        let back = column.base_pressure(there.base_pressure()).unwrap();
        assert_relative_eq!(back.column_density(), spheres, max_relative = 1e-11);
        assert_relative_eq!(back.center_of_mass(), there.center_of_mass(), max_relative = 1e-11);
    }
}

#[test]
fn rates_go_smoothly_to_zero() {
    let reference = paper(CarnahanStarling, 20.0, 0.0, 0.0);
    for (alpha, beta) in [(1e-16, 0.0), (-1e-16, 1e-16), (0.0, -1e-15), (1e-15, 1e-15)] {
        let profile = paper(CarnahanStarling, 20.0, alpha, beta);
        assert_relative_eq!(profile.center_of_mass(), reference.center_of_mass(), max_relative = 1e-12);
        for x in [0.0, 10.0, 80.0] {
            assert_relative_eq!(profile.number_density(x), reference.number_density(x), max_relative = 1e-12);
        }
    }
    // And a small step gives a proportionally small change, so nothing is switched off by a threshold.
    let change =
        |rate: f64| paper(CarnahanStarling, 20.0, rate, 0.0).center_of_mass() - reference.center_of_mass();
    assert_relative_eq!(change(1e-7) / change(1e-6), 0.1, max_relative = 1e-3);
}

#[test]
fn fractions_and_columns_are_each_other() {
    let profile = paper(CarnahanStarling, 20.0, 0.0, 0.05);
    for q in [1e-12, 1e-3, 0.2, 0.5, 0.77, 0.999, 1.0 - 1e-12] {
        let height = profile.height_of_fraction(q);
        assert_abs_diff_eq!(profile.column_below(height) / 40.0, q, epsilon = 1e-13);
    }
    for x in [-1.0, 0.0, 3.0, 30.0, 45.0, 60.0, 1e4] {
        assert_relative_eq!(profile.column_below(x) + profile.column_above(x), 40.0, max_relative = 1e-12);
    }
    // Also far out, where what is left is nothing beside 40.
    let gas = paper(IdealGas, 5.0, 0.0, 0.0);
    for x in [10.0, 200.0, 1000.0] {
        assert_relative_eq!(gas.column_above(x), 40.0 * (-x / 5.0).exp(), max_relative = 1e-10);
    }
    assert_eq!(profile.height_of_fraction(0.0), 0.0);
    assert_eq!(profile.height_of_fraction(2.0), profile.top());
    assert!(profile.height_of_fraction(f64::NAN).is_nan());
    // Placing spheres evenly gives the center of mass.
    let spheres = 25_000;
    let mean = (0..spheres)
        .map(|i| profile.height_of_fraction((f64::from(i) + 0.5) / f64::from(spheres)))
        .sum::<f64>()
        / f64::from(spheres);
    assert_abs_diff_eq!(mean, profile.center_of_mass(), epsilon = 1e-4);
}

#[test]
fn energy_response_matches_the_slope_of_the_center_of_mass() {
    for (t0, expected) in [(5.0, 1.8127), (15.0, 1.3206), (20.0, 1.2434), (30.0, 1.1604)] {
        let height = |t: f64| paper(CarnahanStarling, t, 0.0, 0.0).center_of_mass();
        let slope = (height(t0 + 0.01) - height(t0 - 0.01)) / 0.02;
        assert_abs_diff_eq!(slope, expected, epsilon = 6e-5);
    }
}

// ---------------------------------------------------------------------------------------------
// What cannot be solved
// ---------------------------------------------------------------------------------------------

#[test]
fn an_equation_that_ends_is_an_error() {
    let field = ExponentialField::new(0.1).unwrap();
    let cold = Isothermal::new(2.0).unwrap();
    let column = Hydrostatics::new(field, cold, ModifiedKolafa);
    assert!(matches!(column.column_density(40.0), Err(Error::EquationOfStateExhausted { .. })));
    assert!(matches!(column.base_pressure(1e4), Err(Error::EquationOfStateExhausted { height: 0.0, .. })));
    // The same where the pressure rises upwards, and where the temperature falls.
    let up = UniformField::new(-1.0).unwrap();
    let column = Hydrostatics::new(up, cold, ModifiedKolafa).lid(50.0);
    assert!(matches!(column.column_density(60.0), Err(Error::EquationOfStateExhausted { .. })));
    assert!(column.column_density(10.0).is_ok());
    let solid = Hydrostatics::new(UniformField::default(), cold, SpeedySolid);
    assert!(matches!(solid.column_density(40.0), Err(Error::EquationOfStateExhausted { .. })));
}

#[test]
fn an_open_column_needs_a_field_that_holds_it() {
    let warm = Isothermal::new(20.0).unwrap();
    for acceleration in [0.0, -1.0, -1e-6] {
        let field = UniformField::new(acceleration).unwrap();
        let open = Hydrostatics::new(field, warm, CarnahanStarling).column_density(40.0);
        // Pulled upwards the open column may first run out of states.
        assert!(
            matches!(open, Err(Error::UnboundedColumn { .. } | Error::EquationOfStateExhausted { .. })),
            "{open:?}"
        );
    }
    let fading = ExponentialField::new(-0.1).unwrap();
    let column = Hydrostatics::new(fading, warm, CarnahanStarling);
    assert!(matches!(column.column_density(1.0), Err(Error::UnboundedColumn { .. })));
    assert!(column.lid(100.0).column_density(1.0).is_ok());
    assert!(matches!(column.lid(100.0).open().base_pressure(1.0), Err(Error::UnboundedColumn { .. })));
}

#[test]
fn what_is_not_a_number_is_an_error() {
    struct Broken(f64);
    impl Field for Broken {
        fn potential(&self, height: f64) -> f64 {
            height
        }
        fn acceleration(&self, height: f64) -> f64 {
            if height < 3.0 { 1.0 } else { self.0 }
        }
    }
    let warm = Isothermal::new(20.0).unwrap();
    for value in [f64::NAN, f64::INFINITY] {
        let column = Hydrostatics::new(Broken(value), warm, CarnahanStarling);
        assert!(matches!(column.column_density(40.0), Err(Error::InvalidField { .. })));
        let cooling = TemperatureFn(move |x: f64| if x < 5.0 { 20.0 } else { value });
        let column = Hydrostatics::new(UniformField::default(), cooling, CarnahanStarling);
        assert!(matches!(column.column_density(40.0), Err(Error::InvalidTemperature { .. })));
        let column = Hydrostatics::new(UniformField::default(), warm, CarnahanStarling);
        for broken in [column.base(value), column.lid(value)] {
            assert!(matches!(broken.column_density(40.0), Err(Error::InvalidParameter { .. })));
        }
        for outcome in [column.column_density(value), column.base_pressure(value)] {
            assert!(matches!(outcome, Err(Error::InvalidParameter { .. })));
        }
    }
    let column = Hydrostatics::new(UniformField::default(), warm, CarnahanStarling);
    for outcome in [column.lid(0.0).column_density(1.0), column.column_density(0.0)] {
        assert!(matches!(outcome, Err(Error::InvalidParameter { .. })));
    }
    let negative =
        Hydrostatics::new(UniformField::default(), LinearTemperature::new(5.0, -0.1).unwrap(), IdealGas);
    assert!(matches!(negative.column_density(40.0), Err(Error::InvalidTemperature { .. })));
    struct NotANumber;
    impl EquationOfState for NotANumber {
        fn compressibility_factor(&self, eta: f64) -> f64 {
            if eta > 0.1 { f64::NAN } else { 1.0 }
        }
    }
    let column = Hydrostatics::new(UniformField::default(), warm, NotANumber);
    assert!(matches!(column.column_density(40.0), Err(Error::EquationOfStateExhausted { .. })));
}

#[test]
fn coexistence_without_weight_has_no_profile() {
    let weightless = UniformField::new(0.0).unwrap();
    let column = Hydrostatics::new(weightless, Isothermal::new(1.0).unwrap(), spheres()).lid(20.0);
    let density = number_density(0.52);
    assert!(matches!(column.column_density(20.0 * density), Err(Error::HydrostaticsNotConverged { .. })));
    assert!(column.column_density(20.0 * number_density(0.45)).is_ok());
    assert!(column.column_density(20.0 * number_density(0.6)).is_ok());
}

/// Taken for a column between x = 0.25 and a quarter of a diameter below the lid, the fluid of this
/// box would be beyond freezing.
#[test]
fn a_box_of_fluid_close_to_freezing_has_a_profile() {
    let weightless = UniformField::new(0.0).unwrap();
    let slab = Slab::new(42.736, 25.0, 25.0).unwrap();
    let theory = Hydrostatics::new(weightless, Isothermal::new(20.0).unwrap(), spheres());
    let profile = theory.between_walls(&slab, slab.height() * number_density(0.488)).unwrap();
    let eta = profile.base_packing_fraction();
    assert!(eta > 0.4905 && eta < FREEZING, "{eta}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_column_balances(t0 in 2.0..60.0_f64, alpha in -0.002..0.1_f64, beta in -0.03..0.06_f64, spheres in 0.1..60.0_f64) {
        // A column that is open and hot above need not end.
        prop_assume!(alpha + beta > 0.001);
        let field = ExponentialField::new(alpha).unwrap();
        let temperature = ExponentialTemperature::new(t0, beta).unwrap();
        let profile = Hydrostatics::new(field, temperature, CarnahanStarling).column_density(spheres).unwrap();
        prop_assert!((profile.column_density() / spheres - 1.0).abs() < 1e-10);
        for q in [0.05, 0.4, 0.8, 0.99] {
            let x = profile.height_of_fraction(q);
            prop_assert!((profile.column_below(x) / spheres - q).abs() < 1e-10);
            let eta = profile.packing_fraction(x);
            let state = number_density(eta) * CarnahanStarling.compressibility_factor(eta) * temperature.temperature(x);
            prop_assert!((profile.pressure(x) / state - 1.0).abs() < 1e-9);
            let h = 1e-3 * profile.center_of_mass();
            let slope = (profile.pressure(x + h).ln() - profile.pressure(x - h).ln()) / (2.0 * h);
            let expected = -field.acceleration(x) * profile.number_density(x) / profile.pressure(x);
            prop_assert!((slope / expected - 1.0).abs() < 1e-3, "{} {}", slope, expected);
        }
        // Global balance: P(base) = ∫ a n dx, by the midpoint rule, and what is above carries the rest.
        let (points, top) = (4000, profile.height_of_fraction(0.9999));
        let width = top / f64::from(points);
        let weight: f64 = (0..points)
            .map(|i| (f64::from(i) + 0.5) * width)
            .map(|x| field.acceleration(x) * profile.number_density(x) * width)
            .sum();
        let carried = profile.base_pressure() - profile.pressure(top);
        prop_assert!((carried / weight - 1.0).abs() < 1e-3, "{} {}", carried, weight);
    }
}

/// Centers of mass of the White Bear II density functional at a hard wall, from a solver
/// independent of the project: the local theory is right about them once it begins where
/// scaled-particle theory says.
#[test]
fn columns_between_walls_have_the_center_of_mass_of_density_functional_theory() {
    let slab = Slab::new(400.0, 25.0, 25.0).unwrap();
    for (temperature, functional) in [(5.0, 27.9942), (15.0, 42.9804), (20.0, 49.3939), (30.0, 61.3926)] {
        let temperature = Isothermal::new(temperature).unwrap();
        let theory = Hydrostatics::new(UniformField::default(), temperature, CarnahanStarling);
        let walled = theory.between_walls(&slab, 40.0).unwrap().center_of_mass();
        assert!((walled - functional).abs() < 0.02, "{walled} against {functional}");
        // Without the walls it is off by the height at which the profile begins.
        let without = theory.column_density(40.0).unwrap().center_of_mass();
        assert!((without - functional).abs() > 0.1);
    }
}
