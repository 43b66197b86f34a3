//! Varying temperatures: the default scheme is accurate, and wrong or unconverged fields are
//! detected.

use crate::common::exact::meet;
use crate::common::wrong_rules::{EquationThirtyOneAsPrinted, TemperatureInMetropolis};
use gradient_mc::drive::{
    Adaptation, AveragedThenFrozen, Convergence, Drive, EquationOfStateClosure, Instantaneous, MeasuredShare,
    RunningAverage, Scheme, SelfConsistent, Suggestion,
};
use gradient_mc::equation_of_state::{IdealGas, ModifiedKolafa};
use gradient_mc::field::{ExponentialField, UniformField};
use gradient_mc::moves::{EventChains, LocalMoves, Moves};
use gradient_mc::observers::{Bins, DensityProfile, EquationOfStateProfile};
use gradient_mc::start::{ClosePacked, Positions, RandomInsertion, Start, Theory};
use gradient_mc::statistics::Estimate;
use gradient_mc::temperature::{ExponentialTemperature, TabulatedTemperature, TemperatureFn};
use gradient_mc::{Error, Every, Field, Scene, Simulation, Slab, TemperatureProfile, Warning};
use proptest::prelude::*;
use std::cmp::Ordering;

/// Deviations from the modified Kolafa-Labík-Malijevský equation over ranges of height.
fn deviations(profile: &EquationOfStateProfile, ranges: &[[f64; 2]]) -> Vec<Estimate> {
    profile.deviations_over(ranges, &ModifiedKolafa).unwrap()
}

/// Whether deviations are none: within 4 standard errors, and these below `cap`.
fn agree(deviations: &[Estimate], cap: f64) -> Result<(), String> {
    for (range, deviation) in deviations.iter().enumerate() {
        if deviation.standard_error.is_nan() || deviation.standard_error > cap {
            return Err(format!("range {range}: error of {deviation} above {cap}"));
        }
        if deviation.deviation_from(0.0).abs() > 4.0 {
            return Err(format!("range {range}: {deviation}"));
        }
    }
    Ok(())
}

/// A column, 25 spheres above each unit of a base 6 x 6.
fn column<T: TemperatureProfile>(temperature: T) -> Scene<UniformField, T> {
    let slab = Slab::new(120.0, 6.0, 6.0).unwrap();
    Scene::new(slab, 900, UniformField::default(), temperature).unwrap()
}

/// The paper's steepest gradient, on a column somewhat lighter and cooler.
fn steep() -> ExponentialTemperature {
    ExponentialTemperature::new(12.0, 0.05).unwrap()
}

const RANGES: [[f64; 2]; 3] = [[8.0, 18.0], [18.0, 28.0], [28.0, 36.0]];

/// A run of the steep column, after so many sweeps of equilibration and of production.
fn measured<S: Scheme<UniformField, ExponentialTemperature>>(
    scheme: S,
    start: impl Start + 'static,
    moves: impl Into<Moves>,
    sweeps: [u64; 2],
) -> (Simulation<UniformField, ExponentialTemperature, S>, Vec<Estimate>) {
    let builder = Simulation::builder(column(steep())).scheme(scheme).start(start);
    let mut simulation = builder.moves(moves).seed(21).build().unwrap();
    simulation.equilibrate(sweeps[0], &mut ()).unwrap();
    let profile =
        EquationOfStateProfile::new(simulation.scene().slab(), Bins::count(200).from(0.5).to(50.5)).unwrap();
    let mut profile = Every::new(5, profile);
    simulation.run(sweeps[1], &mut profile).unwrap();
    let deviations = deviations(&profile.observer, &RANGES);
    (simulation, deviations)
}

/// Whether Z is off beyond doubt in a range: by more than 5 % and 4 standard errors, on the side
/// that is expected.
#[track_caller]
fn assert_misses(deviation: Estimate, side: Ordering) {
    let sigma = deviation.deviation_from(0.0);
    println!("{deviation}, {sigma:.1} sigma");
    let beyond = deviation.mean.abs() > 0.05 && sigma.abs() > 4.0;
    assert!(beyond && sigma.total_cmp(&0.0) == side, "{deviation}, {sigma:.1} sigma, is not {side:?}");
}

#[test]
fn the_default_scheme_finds_the_equation_of_state() {
    let start = RandomInsertion::default();
    let (simulation, deviations) =
        measured(SelfConsistent::default(), start, EventChains::default(), [9000, 16_000]);
    // Errors scatter by a fifth.
    agree(&deviations, 0.013).unwrap();
    let certificate = simulation.certificate(0.02).unwrap();
    assert!(certificate.is_converged(), "{certificate}");
    assert!(certificate.effective_sample_size > 20.0, "{certificate}");
}

/// From above, with Z = 1 for all that is known, it finds the same: no equation of state is needed.
#[test]
fn the_default_scheme_needs_no_equation_of_state() {
    let scheme = SelfConsistent::new(IdealGas);
    let (simulation, deviations) =
        measured(scheme, RandomInsertion::default(), EventChains::default(), [9000, 16_000]);
    agree(&deviations, 0.013).unwrap();
    let certificate = simulation.certificate(0.02).unwrap();
    assert!(certificate.is_converged(), "{certificate}");
    assert!(certificate.measured.unwrap().bulk > 0.9, "{certificate}");
}

/// Chains bound the force by values in every bin, also where bins are narrow and few spheres are
/// counted.
#[test]
fn chains_go_through_bins_of_any_width() {
    for width in [0.01, 0.05, 0.3] {
        let scheme = SelfConsistent::default().bin_width(width).unwrap().closure_weight(1.0).unwrap();
        let temperature = ExponentialTemperature::new(6.0, 0.2).unwrap();
        let slab = Slab::new(60.0, 6.0, 6.0).unwrap();
        let scene = Scene::new(slab, 180, UniformField::default(), temperature).unwrap();
        let mut simulation = Simulation::builder(scene).scheme(scheme).seed(1).build().unwrap();
        simulation.equilibrate(1000, &mut ()).unwrap_or_else(|error| panic!("{width}: {error}"));
        simulation.run(100, &mut ()).unwrap_or_else(|error| panic!("{width}: {error}"));
    }
}

#[test]
fn the_closure_finds_what_it_was_given() {
    let scheme = EquationOfStateClosure::default();
    agree(&measured(scheme, Theory, EventChains::default(), [9000, 12_000]).1, 0.013).unwrap();
}

#[test]
fn wrong_fields_miss_it() {
    let (_, found) = measured(TemperatureInMetropolis, Theory, EventChains::default(), [1500, 2000]);
    assert_misses(found[0], Ordering::Less);
    // It presses the column into a crystal, in which chains would not get on.
    let local = LocalMoves::new(0.3).unwrap();
    let (_, found) = measured(EquationThirtyOneAsPrinted, Theory, local, [1500, 2000]);
    assert_misses(found[0], Ordering::Less);
}

#[test]
fn the_instantaneous_histogram_misses_it() {
    let (_, found) =
        measured(Instantaneous::default().any_moves(), Theory, EventChains::default(), [1500, 2000]);
    assert_misses(found[0], Ordering::Less);
}

/// A field frozen while the column still falls is not that of the density which it makes. The
/// certificate says so, and so does the pressure.
#[test]
fn a_field_frozen_too_early_is_caught() {
    let scene = column(steep());
    let builder = Simulation::builder(scene).scheme(AveragedThenFrozen::default());
    let mut simulation =
        builder.start(RandomInsertion::default()).moves(EventChains::default()).seed(5).build().unwrap();
    simulation.equilibrate(30, &mut ()).unwrap();
    let profile =
        EquationOfStateProfile::new(simulation.scene().slab(), Bins::count(200).from(0.5).to(50.5)).unwrap();
    let mut profile = Every::new(5, profile);
    simulation.run(500, &mut ()).unwrap();
    // What falls is told from what is wrong.
    let falling = simulation.certificate(0.02).unwrap();
    let Convergence::NotConverged { suggestion: Suggestion::MeasureLonger, .. } = falling.convergence else {
        panic!("{falling}");
    };
    // Once the column is at rest in the wrong field.
    simulation.equilibrate(0, &mut ()).unwrap();
    simulation.run(6000, &mut profile).unwrap();
    let certificate = simulation.certificate(0.02).unwrap();
    let Convergence::NotConverged { residual, suggestion, .. } = certificate.convergence else {
        panic!("{certificate}");
    };
    assert_eq!(suggestion, Suggestion::AdaptLonger, "{certificate}");
    assert!(residual.mean.abs() > 0.05 && residual.standard_error < 0.02, "{certificate}");
    let found = deviations(&profile.observer, &RANGES);
    assert_misses(found[0], Ordering::Greater);
}

#[test]
fn what_follows_every_configuration_is_never_certified() {
    let builder = Simulation::builder(column(steep())).scheme(Instantaneous::new(2.0).unwrap().any_moves());
    let mut simulation = builder.moves(EventChains::default()).seed(2).build().unwrap();
    simulation.equilibrate(200, &mut ()).unwrap();
    let nothing = simulation.certificate(0.1);
    assert!(matches!(nothing, Err(Error::TooFewObservations { available: 0, .. })), "{nothing:?}");
    simulation.run(1000, &mut ()).unwrap();
    let certificate = simulation.certificate(0.1).unwrap();
    let Convergence::NotConverged { suggestion, .. } = certificate.convergence else {
        panic!("{certificate}");
    };
    assert_eq!(suggestion, Suggestion::FreezeTheField);
}

/// A scene from two starts: it is certified, P is n T Z in the ranges given, and both starts meet.
fn general<F, T>(
    scene: Scene<F, T>,
    ranges: &[[f64; 2]],
    tolerance: f64,
    lowest: &impl Start,
    highest: &impl Start,
) where
    F: Field + Copy,
    T: TemperatureProfile + Copy,
{
    let side = |start: Vec<gradient_mc::Vector3<f64>>, seed: u64| {
        let builder = Simulation::builder(scene).scheme(SelfConsistent::default()).start(Positions(start));
        let mut simulation = builder.moves(EventChains::default()).seed(seed).build().unwrap();
        simulation.equilibrate(8000, &mut ()).unwrap();
        let slab = simulation.scene().slab();
        let bins = ((slab.height() - 1.0) * 4.0).round();
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let profile =
            EquationOfStateProfile::new(slab, Bins::count(bins as usize).from(0.5).to(slab.height() - 0.5))
                .unwrap();
        let mut profile = Every::new(5, profile);
        simulation.run(20_000, &mut profile).unwrap();
        let certificate = simulation.certificate(tolerance).unwrap();
        assert!(certificate.is_converged(), "{certificate}");
        let mut profile = profile.observer;
        profile.set_open_end_pressure(simulation.open_end_pressure()).unwrap();
        let deviations = deviations(&profile, ranges);
        agree(&deviations, 0.012).unwrap();
        profile
            .jackknife(|states| {
                ranges
                    .iter()
                    .map(|&[low, high]| {
                        let inside = states.iter().filter(|state| (low..high).contains(&state.height));
                        inside.map(|state| state.number_density).sum::<f64>()
                    })
                    .collect::<Vec<f64>>()
            })
            .unwrap()
    };
    let mut generator = <gradient_mc::Generator as rand::SeedableRng>::seed_from_u64(8);
    let low = side(lowest.place(&scene.as_any(), &mut generator).unwrap(), 31);
    let high = side(highest.place(&scene.as_any(), &mut generator).unwrap(), 32);
    for (low, high) in low.iter().zip(&high) {
        meet("from above", *high, *low, 0.02).unwrap();
    }
}

#[test]
fn field_and_temperature_both_vary() {
    let slab = Slab::new(100.0, 6.0, 6.0).unwrap();
    let field = ExponentialField::new(0.02).unwrap();
    let temperature = ExponentialTemperature::new(12.0, 0.02).unwrap();
    let scene = Scene::new(slab, 720, field, temperature).unwrap();
    general(scene, &[[8.0, 14.0], [14.0, 20.0]], 0.025, &ClosePacked, &RandomInsertion::default());
}

#[test]
fn temperature_rises_and_falls() {
    let slab = Slab::new(120.0, 6.0, 6.0).unwrap();
    let temperature = TemperatureFn(|height: f64| 8.0 + 3.0 * libm::sin(0.1 * height));
    let scene = Scene::new(slab, 720, UniformField::default(), temperature).unwrap();
    general(scene, &[[8.0, 14.0], [14.0, 20.0]], 0.025, &ClosePacked, &RandomInsertion::default());
}

/// Without weight the pressure is that on the lid everywhere, and n T Z is flat.
#[test]
fn closed_box_without_weight() {
    let slab = Slab::new(40.0, 6.0, 6.0).unwrap();
    let temperature = ExponentialTemperature::new(2.0, 0.02).unwrap();
    let scene = Scene::new(slab, 560, UniformField::new(0.0).unwrap(), temperature).unwrap();
    general(
        scene,
        &[[6.0, 15.0], [15.0, 25.0], [25.0, 34.0]],
        0.08,
        &Theory,
        &RandomInsertion::new(0.4).unwrap(),
    );
}

/// Weight and a lid that carries a good part of the pressure, in a field that grows.
#[test]
fn closed_box_with_weight() {
    let slab = Slab::new(40.0, 6.0, 6.0).unwrap();
    let temperature = ExponentialTemperature::new(20.0, -0.02).unwrap();
    let field = ExponentialField::new(0.01).unwrap();
    let scene = Scene::new(slab, 500, field, temperature).unwrap();
    general(
        scene,
        &[[6.0, 15.0], [15.0, 25.0], [25.0, 34.0]],
        0.08,
        &Theory,
        &RandomInsertion::new(0.35).unwrap(),
    );
}

/// The drives of a scene after a few sweeps are finite wherever a sphere can be.
fn finite<D: Drive<UniformField, TabulatedTemperature>>(
    scene: &Scene<UniformField, TabulatedTemperature>,
    drive: &D,
) {
    for step in 0..=400 {
        let height = 0.5 + (scene.slab().height() - 1.0) * f64::from(step) / 400.0;
        assert!(drive.reduced_potential(scene, height).is_finite());
        assert!(drive.reduced_force(scene, height).is_finite());
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    /// Empty bins, bins of single spheres, and bins wider than the bed.
    #[test]
    fn any_bins_make_finite_drives(
        particles in 1_usize..40,
        width in prop_oneof![Just(0.01), Just(0.1), Just(1.0), Just(7.0), Just(1e3)],
        temperatures in prop::collection::vec(0.5..20.0_f64, 3),
        sweeps in 1_u64..90,
    ) {
        let points = temperatures.iter().zip([0.0, 15.0, 30.0]).map(|(&temperature, height)| (height, temperature));
        let temperature = TabulatedTemperature::new(points.collect()).unwrap();
        let slab = Slab::new(30.0, 4.0, 4.0).unwrap();
        let scene = || Scene::new(slab, particles, UniformField::default(), temperature.clone()).unwrap();
        let local = LocalMoves::new(0.75).unwrap();
        macro_rules! check {
            ($scheme:expr) => {
                let mut simulation = Simulation::builder(scene()).scheme($scheme).moves(local).build().unwrap();
                simulation.equilibrate(sweeps, &mut ()).unwrap();
                finite(simulation.scene(), simulation.drive());
                simulation.run(20, &mut ()).unwrap();
                finite(simulation.scene(), simulation.drive());
            };
        }
        check!(SelfConsistent::default().bin_width(width).unwrap());
        check!(AveragedThenFrozen::new(width).unwrap());
        check!(RunningAverage::new(width).unwrap());
        check!(Instantaneous::new(width).unwrap());
    }
}

/// Temperatures that fall by a fifth and a third of themselves over a diameter: nobody's equation
/// of state is good there, so the field has to come from the measurement. An independent iteration has
/// n = 0.821(5) at 0.55 for β = 0.2.
#[test]
fn steep_temperatures_are_measured() {
    for (decay_rate, density) in [(0.2, Some(Estimate::new(0.821, 0.005))), (0.3, None)] {
        let slab = Slab::new(40.0, 6.0, 6.0).unwrap();
        let temperature = ExponentialTemperature::new(6.0, decay_rate).unwrap();
        let scene = Scene::new(slab, 180, UniformField::default(), temperature).unwrap();
        let builder = Simulation::builder(scene).scheme(SelfConsistent::default());
        let mut simulation = builder.moves(EventChains::default()).seed(3).build().unwrap();
        simulation.equilibrate(40_000, &mut ()).unwrap();
        let measured = simulation.adaptation().measured_share().unwrap();
        assert!(measured.bulk > 0.3 && measured.walls > 0.9, "{decay_rate}: {measured}");
        let layer = DensityProfile::new(simulation.scene().slab(), Bins::count(1).from(0.5).to(0.6)).unwrap();
        let mut layer = Every::new(4, layer);
        simulation.run(40_000, &mut layer).unwrap();
        let certificate = simulation.certificate(0.03).unwrap();
        let residual = certificate.residual();
        assert!(residual.mean.abs() < 0.03 && residual.standard_error < 0.01, "{decay_rate}: {certificate}");
        if let Some(expected) = density {
            let found = layer.observer.points().unwrap()[0].number_density;
            meet("contact layer", found, expected, 0.0146).unwrap();
        }
    }
}

/// A certificate says how much of its field was measured, whatever the scheme.
#[test]
fn certificates_state_the_measured_share() {
    fn after<S: Scheme<UniformField, ExponentialTemperature>>(
        scheme: S,
        moves: impl Into<Moves>,
        sweeps: u64,
    ) -> (MeasuredShare, bool) {
        let slab = Slab::new(60.0, 6.0, 6.0).unwrap();
        let temperature = ExponentialTemperature::new(5.0, 0.02).unwrap();
        let scene = Scene::new(slab, 180, UniformField::default(), temperature).unwrap();
        let mut simulation = Simulation::builder(scene).scheme(scheme).moves(moves).seed(1).build().unwrap();
        simulation.equilibrate(sweeps, &mut ()).unwrap();
        simulation.run(600, &mut ()).unwrap();
        let certificate = simulation.certificate(0.1).unwrap();
        let measured = certificate.measured.unwrap();
        assert!(certificate.to_string().ends_with(&format!("measured part of the field: {measured}")));
        let warned =
            simulation.warnings().iter().any(|warning| matches!(warning, Warning::FieldOfTheory { .. }));
        (measured, warned)
    }
    let (chains, local) = (Moves::default(), LocalMoves::tuned());
    assert_eq!(after(EquationOfStateClosure::default(), chains, 200), (MeasuredShare::NONE, false));
    // Too short for a single step.
    assert_eq!(after(SelfConsistent::default(), chains, 20), (MeasuredShare::NONE, true));
    // The bulk by collisions, whatever the closure weighs; the layers by counts.
    let (measured, warned) = after(SelfConsistent::default(), chains, 2000);
    assert!(measured.bulk > 0.99 && (measured.walls - 0.9).abs() < 0.05 && !warned, "{measured}");
    let (measured, warned) = after(SelfConsistent::default().closure_weight(1e6).unwrap(), chains, 2000);
    assert!(measured.bulk > 0.99 && measured.walls < 0.2 && warned, "{measured}");
    // Local moves have no collisions. Some 20 spheres per diameter, looked at every fourth sweep of
    // three quarters of 976 sweeps: 4000 against 10 000.
    let (measured, warned) = after(SelfConsistent::default(), local, 2000);
    assert!((measured.bulk - 0.2).abs() < 0.12 && (measured.walls - 0.9).abs() < 0.05, "{measured}");
    assert!(!warned);
    let (measured, warned) = after(SelfConsistent::default().closure_weight(1e6).unwrap(), local, 2000);
    assert!(measured.bulk < 0.01 && measured.walls < 0.2 && warned, "{measured}");
}
