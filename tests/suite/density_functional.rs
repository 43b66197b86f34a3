//! Density functional theory: its layers, and the sum rules that every functional fulfills.

use gradient_mc::equation_of_state::{number_density, packing_fraction};
use gradient_mc::field::{ExponentialField, UniformField};
use gradient_mc::functional::{
    Bulk, DensityFunctional, FreeEnergy, Functional, LayeredProfile, Lutsko, Rosenfeld, WeightedDensities,
    WhiteBear, WhiteBear2,
};
use gradient_mc::temperature::{ExponentialTemperature, Isothermal, TemperatureFn};
use gradient_mc::{EquationOfState, Error, Field, Hydrostatics, TemperatureProfile};

fn all() -> [Box<dyn Functional>; 5] {
    [
        Box::new(Rosenfeld),
        Box::new(WhiteBear),
        Box::new(WhiteBear2),
        Box::new(Lutsko::TARAZONA),
        Box::new(Lutsko::STABLE),
    ]
}

fn column(temperature: f64) -> DensityFunctional<UniformField, Isothermal, WhiteBear2> {
    DensityFunctional::new(UniformField::default(), Isothermal::new(temperature).unwrap(), WhiteBear2)
}

/// A box without weight.
fn weightless(height: f64, chemical_potential: f64, functional: &dyn Functional) -> LayeredProfile {
    DensityFunctional::new(UniformField::new(0.0).unwrap(), Isothermal::new(1.0).unwrap(), functional)
        .lid(height)
        .chemical_potential(chemical_potential)
        .unwrap()
}

/// μ/T of the uniform fluid.
fn chemical_potential(functional: &dyn Functional, eta: f64) -> f64 {
    number_density(eta).ln() + Bulk(functional).excess_chemical_potential(eta)
}

fn pressure(functional: &dyn Functional, eta: f64) -> f64 {
    number_density(eta) * Bulk(functional).compressibility_factor(eta)
}

/// Bins and centers of mass of a solver that shares nothing with this one.
#[test]
fn layers_are_those_of_an_independent_solver() {
    let references = [
        (5.0, 27.9942, include_str!("../reference/fmt_WBII_T5_bins_extrapolated.csv")),
        (15.0, 42.9804, include_str!("../reference/fmt_WBII_T15_bins_extrapolated.csv")),
    ];
    for (temperature, center, text) in references {
        let profile = column(temperature).column_density(40.0).unwrap();
        assert!((profile.center_of_mass() - center).abs() < 1e-4, "{}", profile.center_of_mass());
        let bulk = Hydrostatics::new(
            UniformField::default(),
            Isothermal::new(temperature).unwrap(),
            Bulk(WhiteBear2),
        )
        .column_density(40.0)
        .unwrap()
        .number_density(0.0);
        let mut rows = 0;
        for line in text.lines().skip(1) {
            let [low, high, expected] = {
                let mut numbers = line.split(',').map(|number| number.parse::<f64>().unwrap());
                [(); 3].map(|()| numbers.next().unwrap())
            };
            let difference = profile.mean_density(low, high) - expected;
            assert!(difference.abs() < 2e-4 * bulk, "T = {temperature}, x = {low}: {difference:e}");
            rows += 1;
        }
        assert_eq!(rows, 75);
    }
    for (temperature, center) in [(20.0, 49.3939), (30.0, 61.3926)] {
        // That solver's box has a top, which the hottest column reaches: at 500 it lowers the center by
        // 0.0002.
        let profile = column(temperature).lid(500.0).column_density(40.0).unwrap();
        assert!((profile.center_of_mass() - center).abs() < 1e-4, "{}", profile.center_of_mass());
    }
}

fn carries_its_weight<F: Field, T: TemperatureProfile>(
    field: F,
    temperature: T,
    functional: &dyn Functional,
    spheres: f64,
) {
    let at_base = temperature.temperature(0.5);
    let at_lid = temperature.temperature(399.5);
    let profile =
        DensityFunctional::new(field, temperature, functional).lid(400.0).column_density(spheres).unwrap();
    assert!((profile.column_density() / spheres - 1.0).abs() < 1e-9);
    assert!(profile.residual() < 1e-8, "{}", profile.residual());
    let contact = profile.contact_density() * at_base / profile.base_pressure();
    assert!((contact - 1.0).abs() < 1e-6, "{contact}");
    let lid = profile.number_density(399.5) * at_lid;
    assert!((lid - profile.pressure(399.5)).abs() < 1e-9 * profile.base_pressure());
}

/// The base carries the weight of the column, whatever the functional, field and temperature:
/// contact theorem.
#[test]
fn contact_density_is_the_weight() {
    let gravity = UniformField::default();
    for functional in all() {
        carries_its_weight(gravity, Isothermal::new(15.0).unwrap(), &*functional, 40.0);
    }
    for temperature in [5.0, 20.0, 30.0] {
        carries_its_weight(gravity, Isothermal::new(temperature).unwrap(), &WhiteBear2, 40.0);
        let profile = column(temperature).column_density(40.0).unwrap();
        assert!((profile.base_pressure() / 40.0 - 1.0).abs() < 1e-9, "{}", profile.base_pressure());
        assert!((profile.contact_density() * temperature / 40.0 - 1.0).abs() < 1e-6);
    }
    for rate in [0.0025, 0.02, 0.05] {
        let field = ExponentialField::new(rate).unwrap();
        carries_its_weight(field, Isothermal::new(20.0).unwrap(), &WhiteBear2, 40.0);
    }
    for rate in [0.005, 0.02, 0.05] {
        let temperature = ExponentialTemperature::new(20.0, rate).unwrap();
        carries_its_weight(gravity, temperature, &WhiteBear2, 40.0);
    }
}

/// Above the layers the column is that of hydrostatics with the functional's own equation of state;
/// where T varies too.
#[test]
fn the_bulk_is_hydrostatic() {
    for rate in [0.0, 0.01] {
        let temperature = ExponentialTemperature::new(20.0, rate).unwrap();
        let profile = DensityFunctional::new(UniformField::default(), temperature, WhiteBear2)
            .lid(400.0)
            .column_density(40.0)
            .unwrap();
        let mut worst = 0.0_f64;
        for height in [15.0, 30.0, 60.0, 90.0] {
            let eta = packing_fraction(profile.number_density(height));
            let local = pressure(&WhiteBear2, eta) * temperature.temperature(height);
            worst = worst.max((local / profile.pressure(height) - 1.0).abs());
        }
        // What is left is the change of density over a sphere.
        assert!(worst < 2e-4, "{worst:e}");
    }
}

/// A temperature that is constant, and does not say so, takes the way of those that vary.
#[test]
fn an_isothermal_column_is_the_limit_of_others() {
    let known = column(8.0).lid(120.0).column_density(20.0).unwrap();
    let found = DensityFunctional::new(UniformField::default(), TemperatureFn(|_: f64| 8.0), WhiteBear2)
        .lid(120.0)
        .column_density(20.0)
        .unwrap();
    for height in [0.5, 0.8, 1.5, 3.3, 20.0, 60.0, 119.5] {
        let ratio = found.number_density(height) / known.number_density(height);
        assert!((ratio - 1.0).abs() < 1e-7, "{height}: {ratio}");
    }
    assert!((found.chemical_potential() - known.chemical_potential()).abs() < 1e-8);
}

/// What a gas at a wall is to second order in its density, n(z)/n = 1 + 2η(1 − z)²(2 + z), every
/// functional knows.
#[test]
fn a_dilute_gas_at_a_wall_is_exact() {
    let eta = 1e-4;
    for functional in all() {
        let profile = weightless(20.0, chemical_potential(&*functional, eta), &*functional);
        for z in [0.0, 0.1, 0.4, 0.7, 0.95] {
            let surplus = profile.number_density(0.5 + z) / profile.number_density(10.0) - 1.0;
            let exact = 2.0 * eta * (1.0 - z) * (1.0 - z) * (2.0 + z);
            assert!((surplus - exact).abs() < 30.0 * eta * eta, "{z}: {surplus:e}, {exact:e}");
        }
    }
}

/// In a box without weight: the uniform fluid in the middle, the contact theorem at both walls, and
/// the adsorption equation of Gibbs.
#[test]
fn sum_rules_hold_in_a_box_without_weight() {
    const HEIGHT: f64 = 60.0;
    for functional in all() {
        for eta in [0.1, 0.3, 0.4] {
            let functional = &*functional;
            let potential = chemical_potential(functional, eta);
            let profile = weightless(HEIGHT, potential, functional);
            let density = number_density(eta);
            assert!((profile.number_density(30.0) / density - 1.0).abs() < 1e-5);
            let pressure = pressure(functional, eta);
            for wall in [0.5, HEIGHT - 0.5] {
                assert!((profile.number_density(wall) / pressure - 1.0).abs() < 1e-7);
            }
            // γ of one wall, at which the uniform fluid ends.
            let tension = |step: f64| {
                let potential = potential + step;
                let profile = weightless(HEIGHT, potential, functional);
                0.5 * (profile.grand_potential() + profile.number_density(0.5) * HEIGHT)
            };
            let slope = (8.0 * (tension(0.01) - tension(-0.01)) - (tension(0.02) - tension(-0.02))) / 0.12;
            let adsorption = 0.5 * (profile.column_density() - density * HEIGHT);
            assert!((slope + adsorption).abs() < 1e-5, "{slope} {adsorption}");
            // Scaled-particle theory (doi:10.1063/1.1731020): too high in a dense fluid.
            let void = 1.0 - eta;
            let scaled_particle = 3.0 * eta * (2.0 + eta) / (2.0 * std::f64::consts::PI * void * void);
            let ratio = tension(0.0) / scaled_particle;
            assert!(ratio < 1.0 && ratio > 1.0 - 1.2 * eta * eta, "{ratio}");
        }
    }
}

/// Given N/A or given the chemical potential that comes with it.
#[test]
fn both_ensembles_agree() {
    let column = column(10.0).lid(150.0);
    let canonical = column.column_density(25.0).unwrap();
    let grand = column.chemical_potential(canonical.chemical_potential()).unwrap();
    assert!((grand.column_density() / 25.0 - 1.0).abs() < 1e-8, "{}", grand.column_density());
    assert!((grand.grand_potential() / canonical.grand_potential() - 1.0).abs() < 1e-8);
}

/// A column that hangs is one that stands, upside down; also in a box whose walls see each other.
#[test]
fn a_hanging_column_is_the_mirror_image() {
    for (height, spheres) in [(3.3, 1.1), (47.3, 9.0)] {
        let standing = column(3.0).lid(height).column_density(spheres).unwrap();
        let hanging = DensityFunctional::new(
            UniformField::new(-1.0).unwrap(),
            Isothermal::new(3.0).unwrap(),
            WhiteBear2,
        )
        .lid(height)
        .column_density(spheres)
        .unwrap();
        for part in [0.0, 0.1, 0.31, 0.5, 0.77, 1.0] {
            let x = 0.5 + part * (height - 1.0);
            let ratio = hanging.number_density(height - x) / standing.number_density(x);
            assert!((ratio - 1.0).abs() < 1e-6, "{height} {x}: {ratio}");
        }
    }
}

/// Knows the uniform fluid alone.
struct OnlyUniform;

impl Functional for OnlyUniform {
    fn free_energy(&self, weighted: &WeightedDensities) -> FreeEnergy {
        let mut energy = WhiteBear2.free_energy(weighted);
        if weighted.vector != 0.0 {
            energy.by_vector = f64::NAN;
        }
        energy
    }
}

#[test]
fn what_cannot_be_solved_is_an_error() {
    // Its lower part is a crystal.
    assert!(matches!(column(2.0).column_density(40.0), Err(Error::BeyondFreezing { .. })));
    // T jumps, and with it the density.
    let jump = TemperatureFn(|x: f64| if x < 12.3 { 5.0 } else { 7.0 });
    let jump = DensityFunctional::new(UniformField::default(), jump, WhiteBear2).lid(60.0);
    assert!(matches!(jump.column_density(5.0), Err(Error::FunctionalTooSteep { .. })));
    for senseless in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(column(5.0).column_density(senseless), Err(Error::InvalidParameter { .. })));
    }
    assert!(matches!(column(5.0).chemical_potential(f64::NAN), Err(Error::InvalidParameter { .. })));
    // Nothing holds it.
    let flat =
        DensityFunctional::new(UniformField::new(0.0).unwrap(), Isothermal::new(1.0).unwrap(), WhiteBear2);
    assert!(matches!(flat.column_density(1.0), Err(Error::UnboundedColumn { .. })));
    assert!(flat.lid(0.9).column_density(0.1).is_err());
    let failing = DensityFunctional::new(UniformField::default(), Isothermal::new(5.0).unwrap(), OnlyUniform);
    let failed = failing.column_density(5.0);
    assert!(matches!(failed, Err(Error::FunctionalNotConverged { .. })), "{failed:?}");
}
