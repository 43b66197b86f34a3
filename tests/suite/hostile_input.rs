//! Invalid input gives a typed error that names the value and the remedy, never a panic.

// Values are compared as they went in.
#![allow(clippy::float_cmp)]

use crate::common::scenes::{Counted, NoInteraction};
use gradient_mc::drive::{
    Automatic, AveragedThenFrozen, Drive, EffectivePotential, EquationOfStateClosure, Instantaneous,
    RunningAverage, Scheme, SelfConsistent, log_acceptance,
};
use gradient_mc::equation_of_state::{EquationOfState, FluidSolid, number_density, packing_fraction};
use gradient_mc::field::{ExponentialField, FieldFn, LinearField, SumField, UniformField};
use gradient_mc::hydrostatics::Hydrostatics;
use gradient_mc::moves::{EventChains, LocalMoves};
use gradient_mc::observers::{
    Bins, DensityProfile, DisplacementProfile, EquationOfStateProfile, PressureProfile,
};
use gradient_mc::start::{ClosePacked, Positions, RandomInsertion, Start, Theory};
use gradient_mc::temperature::{
    ExponentialTemperature, Isothermal, LinearTemperature, TabulatedTemperature, TemperatureFn,
};
use gradient_mc::{
    AnyScene, Error, Every, Field, Frame, Generator, MoveCounts, Observer, ObserverError, Scene, Simulation,
    Slab, TemperatureProfile, Vector3,
};
use proptest::prelude::*;

const NOT_POSITIVE: [f64; 7] = [0.0, -0.0, -1.0, -1e-300, f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
const NOT_FINITE: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

fn slab() -> Slab {
    Slab::new(50.0, 5.0, 5.0).unwrap()
}

/// Moves that get on from anywhere, a trial at a time.
fn small() -> LocalMoves {
    LocalMoves::new(0.75).unwrap()
}

fn gravity() -> UniformField {
    UniformField::default()
}

fn warm() -> Isothermal {
    Isothermal::new(2.0).unwrap()
}

fn scene(particles: usize) -> Scene<UniformField, Isothermal> {
    Scene::new(slab(), particles, gravity(), warm()).unwrap()
}

fn cooling() -> Scene<UniformField, ExponentialTemperature> {
    Scene::new(slab(), 50, gravity(), ExponentialTemperature::new(5.0, 0.02).unwrap()).unwrap()
}

/// The message names the offending value and says what to do.
fn assert_says(error: &Error, parts: &[&str]) {
    let message = error.to_string();
    for part in parts {
        assert!(message.contains(part), "\"{message}\" does not say \"{part}\"");
    }
}

/// A number as messages show it: without a tail of three hundred zeros.
fn shown(value: f64) -> String {
    if value != 0.0 && value.is_finite() && !(1e-5..1e16).contains(&value.abs()) {
        return format!("{value:e}");
    }
    value.to_string()
}

/// The outcome is [`Error::InvalidParameter`] and carries `value`.
fn assert_refused<T>(outcome: Result<T, Error>, value: f64) {
    let Err(error) = outcome else { panic!("{value} was accepted") };
    let Error::InvalidParameter { name, value: carried, requirement, .. } = error else {
        panic!("{error:?}")
    };
    assert_eq!(carried.to_bits(), value.to_bits());
    assert_says(&error, &[name, &shown(value), requirement]);
    assert!(error.to_string().len() < 200, "{error}");
}

#[test]
fn temperatures_that_are_not_positive() {
    for value in NOT_POSITIVE {
        assert_refused(Isothermal::new(value), value);
        assert_refused(ExponentialTemperature::new(value, 0.01), value);
        assert_refused(LinearTemperature::new(value, 0.01), value);
        let table = TabulatedTemperature::new(vec![(0.0, 1.0), (20.0, value)]).unwrap_err();
        assert!(matches!(table, Error::InvalidTemperature { height: 20.0, .. }), "{table:?}");
        assert_says(&table, &[&shown(value), "20", "positive"]);
    }
    for value in NOT_FINITE {
        assert_refused(ExponentialTemperature::new(1.0, value), value);
        assert_refused(LinearTemperature::new(1.0, value), value);
    }
}

#[test]
fn temperatures_that_turn_bad_at_some_height() {
    let refusal = |profile: &dyn TemperatureProfile| {
        let error = Scene::new(slab(), 50, gravity(), profile).map(drop).unwrap_err();
        let Error::InvalidTemperature { height, temperature, .. } = error else { panic!("{error:?}") };
        assert_says(&error, &[&height.to_string(), &shown(temperature), "lower the lid"]);
        (height, temperature)
    };
    // Zero at 40 of 50 diameters.
    let (height, temperature) = refusal(&LinearTemperature::new(4.0, -0.1).unwrap());
    assert!((height - 40.0).abs() < 0.01 && temperature <= 0.0);
    for bad in NOT_POSITIVE {
        let window = TemperatureFn(move |x: f64| if (20.0..20.01).contains(&x) { bad } else { 3.0 });
        let (height, temperature) = refusal(&window);
        assert!((20.0..20.01).contains(&height) && temperature.to_bits() == bad.to_bits());
    }
    // Underflow and overflow of the library's own profiles.
    assert_eq!(refusal(&ExponentialTemperature::new(1.0, 20.0).unwrap()).1, 0.0);
    assert_eq!(refusal(&ExponentialTemperature::new(1.0, -20.0).unwrap()).1, f64::INFINITY);
    // A narrow flaw is found in a tall slab too.
    let tall = Slab::new(100_000.0, 3.0, 3.0).unwrap();
    let flaw = TemperatureFn(|x: f64| if (70_000.0..70_000.1).contains(&x) { f64::NAN } else { 1.0 });
    let outcome = Scene::new(tall, 5, UniformField::new(0.0).unwrap(), flaw);
    assert!(matches!(outcome, Err(Error::InvalidTemperature { .. })));
}

#[test]
fn tables_that_are_empty_or_out_of_order() {
    let refusal = |points: Vec<(f64, f64)>| TabulatedTemperature::new(points).unwrap_err();
    assert_says(&refusal(vec![]), &["table", "at least one point"]);
    for height in [0.0, 10.0, 9.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let error = refusal(vec![(0.0, 1.0), (10.0, 1.0), (height, 1.0)]);
        assert!(matches!(error, Error::InvalidParameter { .. }), "{error:?}");
        assert_says(&error, &[&height.to_string(), "rise"]);
    }
}

#[test]
fn slabs_that_are_too_small_too_large_or_not_numbers() {
    for small in [2.999_999_999, 1.0, 0.0, -5.0] {
        for (direction, outcome) in [
            ('y', Slab::new(50.0, small, 5.0)),
            ('z', Slab::new(50.0, 5.0, small)),
            ('x', Slab::new(small - 1.0, 5.0, 5.0)),
        ] {
            let error = outcome.unwrap_err();
            assert!(matches!(error, Error::SlabTooSmall { direction: found, .. } if found == direction));
            let given = if direction == 'x' { small - 1.0 } else { small };
            assert_says(&error, &[&given.to_string(), &direction.to_string(), "enlarge"]);
        }
    }
    for value in NOT_FINITE.into_iter().chain([1.000_001e6, f64::MAX]) {
        assert_refused(Slab::new(value, 5.0, 5.0), value);
        assert_refused(Slab::new(50.0, value, 5.0), value);
        assert_refused(Slab::new(50.0, 5.0, value), value);
    }
    // Allowed extents whose cell list would take terabytes: refused before any is allocated.
    for extents in [[1e6, 1e6, 1e6], [1e6, 1e3, 1e3], [400.0, 1e6, 3.0]] {
        let slab = Slab::new(extents[0], extents[1], extents[2]).unwrap();
        let error = Scene::new(slab, 1, gravity(), warm()).unwrap_err();
        assert!(matches!(error, Error::SlabTooLarge { .. }), "{error:?}");
        assert_says(&error, &[&shown(extents.iter().product()), "200000000", "lower the lid"]);
    }
}

#[test]
fn the_largest_slab_can_be_used() {
    let slab = Slab::new(1e6, 9.9, 9.9).unwrap();
    let scene = Scene::new(slab, 1, UniformField::new(0.0).unwrap(), warm()).unwrap();
    let start = Positions(vec![Vector3::new(999_999.5, 6.5, 0.0)]);
    let mut simulation = Simulation::builder(scene).start(start).moves(small()).build().unwrap();
    simulation.run(10, &mut ()).unwrap();
    assert!(simulation.move_counts().accepted > 0);
}

#[test]
fn numbers_of_spheres() {
    let capacity = slab().capacity();
    assert!(Scene::new(slab(), capacity, gravity(), warm()).is_ok());
    assert_refused(Scene::new(slab(), 0, gravity(), warm()), 0.0);
    for particles in [capacity + 1, usize::MAX] {
        let error = Scene::new(slab(), particles, gravity(), warm()).unwrap_err();
        assert!(matches!(error, Error::TooManyParticles { particles: found, .. } if found == particles));
        assert_says(&error, &[&particles.to_string(), &capacity.to_string(), "fewer spheres"]);
    }
}

#[test]
fn fields_that_are_not_finite() {
    for value in NOT_FINITE {
        assert_refused(UniformField::new(value), value);
        assert_refused(ExponentialField::new(value), value);
        assert_refused(LinearField::new(value, 0.0), value);
        assert_refused(LinearField::new(0.0, value), value);
    }
    // exp(50 * 50) overflows at 14.2 diameters.
    let error = Scene::new(slab(), 50, ExponentialField::new(50.0).unwrap(), warm()).unwrap_err();
    let Error::InvalidField { height, .. } = error else { panic!("{error:?}") };
    assert!((14.0..14.4).contains(&height));
    assert_says(&error, &["inf", "finite over the whole slab"]);
}

/// A field with a flaw between two heights.
#[derive(Debug)]
struct Flawed {
    window: [f64; 2],
    acceleration: f64,
    potential: f64,
}

impl Flawed {
    fn hit(&self, height: f64) -> bool {
        height > self.window[0] && height < self.window[1]
    }
}

impl Field for Flawed {
    fn potential(&self, height: f64) -> f64 {
        if self.hit(height) { self.potential } else { height }
    }
    fn acceleration(&self, height: f64) -> f64 {
        if self.hit(height) { self.acceleration } else { 1.0 }
    }
}

#[test]
fn fields_that_turn_bad_at_some_height() {
    for bad in NOT_FINITE {
        // The second window lies between two probes, where only the quadrature looks.
        for window in [[20.0, 20.05], [20.001, 20.005]] {
            for (acceleration, potential) in [(bad, bad), (bad, 20.0)] {
                let field = Flawed { window, acceleration, potential };
                let error = Scene::new(slab(), 50, field, warm()).unwrap_err();
                let Error::InvalidField { height, acceleration, .. } = error else { panic!("{error:?}") };
                assert!(height > window[0] && height < window[1], "{height}");
                assert_says(&error, &[&height.to_string(), &acceleration.to_string(), "finite"]);
            }
        }
        let outcome = FieldFn::new(move |height| if height > 30.0 { bad } else { 1.0 }, &slab());
        let error = outcome.unwrap_err();
        assert!(matches!(error, Error::InvalidField { height, .. } if (30.0..30.1).contains(&height)));
    }
    // A narrow flaw is found in a tall slab too, and an oscillating field is not taken for one.
    let tall = Slab::new(100_000.0, 3.0, 3.0).unwrap();
    let field = Flawed { window: [70_000.0, 70_000.2], acceleration: f64::NAN, potential: 0.0 };
    assert!(matches!(Scene::new(tall, 5, field, warm()), Err(Error::InvalidField { .. })));
    let wave = FieldFn::new(|height: f64| height.sin(), &tall).unwrap();
    assert!(Scene::new(tall, 5, wave, warm()).is_ok());
}

#[test]
fn a_flaw_that_no_probe_meets_ends_the_run() {
    // Between two probes of the potential, which are 50/4096 apart.
    let probe = 50.0 / 4096.0;
    // Between two layers of the start, too.
    let window = [200.1 * probe, 200.9 * probe];
    for potential in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let field = Flawed { window, acceleration: 1.0, potential };
        let scene = Scene::new(slab(), 50, field, warm()).unwrap();
        let mut simulation =
            Simulation::builder(scene).start(ClosePacked).seed(1).moves(small()).build().unwrap();
        let outcome = simulation.equilibrate(2000, &mut ());
        let inside = simulation.positions().iter().filter(|p| p.x > window[0] && p.x < window[1]).count();
        if potential > 0.0 {
            // A wall, which is what an infinite potential means.
            assert!(outcome.is_ok() && inside == 0);
            continue;
        }
        let error = outcome.unwrap_err();
        let Error::InvalidPotential { height, .. } = error else { panic!("{error:?}") };
        assert_says(&error, &[&height.to_string()]);
        if potential.is_nan() {
            assert!(height > window[0] && height < window[1] && inside == 0);
        }
        // The configuration is intact.
        let positions = simulation.positions();
        assert_eq!(positions.len(), 50);
        assert!(Simulation::builder(self::scene(50)).start(Positions(positions)).build().is_ok());
    }
}

#[test]
fn potentials_too_large_for_the_temperature() {
    // φ/T overflows: every difference would be a NaN.
    let cold = Isothermal::new(1e-308).unwrap();
    let scene = Scene::new(slab(), 50, gravity(), cold).unwrap();
    let error = Automatic.drive(&scene).unwrap_err();
    assert!(matches!(error, Error::InvalidPotential { .. }), "{error:?}");
    assert_says(&error, &["inf", "too steep"]);
    // Just as the non-isothermal schemes say.
    let scene = Scene::new(slab(), 50, gravity(), ExponentialTemperature::new(1e-308, 0.0).unwrap()).unwrap();
    assert!(matches!(Instantaneous::default().drive(&scene), Err(Error::InvalidPotential { .. })));
}

#[test]
fn fields_whose_parts_disagree() {
    #[derive(Debug)]
    struct Wrong(f64);
    impl Field for Wrong {
        fn potential(&self, height: f64) -> f64 {
            height * height
        }
        fn acceleration(&self, height: f64) -> f64 {
            self.0 * height
        }
    }
    assert!(Scene::new(slab(), 50, Wrong(2.0), warm()).is_ok());
    // Twice and half, a forgotten factor, are the likeliest mistakes; the last is 2 % off.
    for factor in [-2.0, 0.0, 1.0, 4.0, 20.0, 1.96] {
        let error = Scene::new(slab(), 50, Wrong(factor), warm()).unwrap_err();
        assert!(matches!(error, Error::InconsistentField { .. }), "{error:?}");
        assert_says(&error, &["implement only `potential`"]);
    }
}

#[test]
fn columns_beyond_reason() {
    // An error, or the column that was asked for: never something else, and never at great expense.
    const MOST_EVALUATIONS: u64 = 2_000_000;
    let mut most = 0;
    let mut solved = 0;
    for spheres in [1e-300, 1e-12, 40.0, 1e9, 1e300] {
        for temperature in [1e-300, 1e-3, 5.0, 1e300] {
            for alpha in [-1e300, -1.0, 0.0, 1.0, 1000.0] {
                let field = Counted::new(ExponentialField::new(alpha).unwrap());
                let warm = Isothermal::new(temperature).unwrap();
                let open = Hydrostatics::new(&field, warm, FluidSolid::default());
                for column in [open, open.lid(400.0)] {
                    let outcome = column.column_density(spheres);
                    let evaluations = field.take();
                    most = most.max(evaluations);
                    assert!(
                        evaluations <= MOST_EVALUATIONS,
                        "{spheres:e} {temperature:e} {alpha:e}: {evaluations}"
                    );
                    let Ok(profile) = outcome else { continue };
                    approx::assert_relative_eq!(profile.column_density(), spheres, max_relative = 1e-9);
                    let center = profile.center_of_mass();
                    assert!(center > 0.0 && center < profile.top(), "{spheres} {temperature} {alpha}");
                    solved += 1;
                }
            }
        }
    }
    println!("{most} evaluations at most");
    assert!(solved > 20, "{solved}");
    // So far away that heights are coarser than the column.
    for base in [1.000_001e6, -1e18, f64::MAX] {
        let column = Hydrostatics::new(gravity(), warm(), FluidSolid::default()).base(base);
        assert_refused(column.column_density(10.0), base);
        assert_refused(column.base_pressure(10.0), base);
    }
    assert!(
        Hydrostatics::new(gravity(), warm(), FluidSolid::default()).base(1e6).column_density(10.0).is_ok()
    );
}

#[test]
fn the_smallest_scene_can_be_used() {
    // One sphere whose nearest image is itself, in three cells each way.
    let slab = Slab::new(2.0, 3.0, 3.0).unwrap();
    for temperature in [1e-300, 1.0, 1e300] {
        let scene = Scene::new(slab, 1, gravity(), Isothermal::new(temperature).unwrap()).unwrap();
        let mut simulation =
            Simulation::builder(scene).start(ClosePacked).seed(1).moves(small()).build().unwrap();
        let mut profile = EquationOfStateProfile::new(&slab, Bins::count(4)).unwrap();
        simulation.equilibrate(10, &mut ()).unwrap();
        simulation.run(100, &mut profile).unwrap();
        // n A Δx summed over the bins is the sphere.
        let spheres: f64 = profile.points().unwrap().iter().map(|p| p.number_density.mean).sum::<f64>() * 4.5;
        approx::assert_relative_eq!(spheres, 1.0, max_relative = 1e-12);
        let accepted = simulation.move_counts().accepted;
        assert!(if temperature < 1.0 { accepted < 10 } else { accepted > 10 }, "{temperature} {accepted}");
    }
}

#[test]
fn observers_of_another_slab() {
    let mut simulation = Simulation::builder(scene(30)).start(ClosePacked).moves(small()).build().unwrap();
    for slab in [Slab::new(51.0, 5.0, 5.0).unwrap(), Slab::new(50.0, 5.0, 6.0).unwrap()] {
        let mut observers: [Box<dyn Observer>; 4] = [
            Box::new(DensityProfile::new(&slab, Bins::count(10)).unwrap()),
            Box::new(PressureProfile::new(&slab, Bins::count(10)).unwrap()),
            Box::new(EquationOfStateProfile::new(&slab, Bins::count(10)).unwrap()),
            Box::new(DisplacementProfile::new(&slab, Bins::count(10)).unwrap()),
        ];
        for observer in &mut observers {
            let error = simulation.run(1, &mut **observer).unwrap_err();
            let source = std::error::Error::source(&error).expect("the observer's own error");
            assert!(matches!(source.downcast_ref(), Some(Error::AnotherRun { .. })), "{source}");
        }
    }
}

/// A drive whose potential is not a number above some height.
#[derive(Debug, Clone, Copy)]
struct NoNumber;

impl<F, T> Drive<F, T> for NoNumber {
    fn reduced_potential(&self, _: &Scene<F, T>, height: f64) -> f64 {
        if height > 10.0 { f64::NAN } else { 0.0 }
    }
}

impl<F, T> Scheme<F, T> for NoNumber {
    type Drive = Self;
    type Adaptation = ();
    fn drive(self, _: &Scene<F, T>) -> Result<(Self, ()), Error> {
        Ok((self, ()))
    }
}

#[test]
fn a_drive_that_is_not_a_number_accepts_nothing() {
    let scene = scene(20);
    assert!(log_acceptance(&NoNumber, &scene, 9.0, 11.0).is_nan());
    assert!(log_acceptance(&NoNumber, &scene, 11.0, 9.0).is_nan());
    let mut simulation =
        Simulation::builder(scene).scheme(NoNumber).start(ClosePacked).moves(small()).build().unwrap();
    let error = simulation.equilibrate(10_000, &mut ()).unwrap_err();
    assert!(
        matches!(error, Error::InvalidPotential { height, potential, .. } if height > 10.0 && potential.is_nan())
    );
    assert!(simulation.positions().iter().all(|position| position.x <= 10.0));
}

#[test]
fn displacements_out_of_range() {
    for value in NOT_POSITIVE {
        assert_refused(LocalMoves::new(value), value);
        assert_refused(LocalMoves::mixture(&[1.0, value]), value);
    }
    // Too large for the slab, which is known when the simulation is built.
    for value in [2.500_001, 1e300] {
        let moves = LocalMoves::new(value).unwrap();
        let builder = Simulation::builder(scene(50)).start(ClosePacked);
        assert_refused(builder.clone().moves(moves).build(), value);
        assert_refused(builder.moves(EventChains::default().local_moves(Some(moves))).build(), value);
    }
    // Half the smallest side is allowed, as is next to nothing; the height may be the smallest.
    for value in [2.5, f64::MIN_POSITIVE, 5e-324] {
        let builder =
            Simulation::builder(scene(50)).start(ClosePacked).moves(LocalMoves::new(value).unwrap());
        builder.build().unwrap().equilibrate(3, &mut ()).unwrap();
    }
    let flat = Slab::new(2.0, 5.0, 5.0).unwrap();
    let flat = Scene::new(flat, 5, gravity(), warm()).unwrap();
    let build = |size| Simulation::builder(flat).moves(LocalMoves::new(size).unwrap()).build();
    assert!(build(1.0).is_ok());
    assert_refused(build(1.1), 1.1);
}

#[test]
fn moves_that_a_scheme_does_not_take() {
    let builder = || Simulation::builder(cooling()).start(ClosePacked);
    let error = builder().scheme(Instantaneous::default()).moves(EventChains::default()).build().unwrap_err();
    assert!(matches!(error, Error::UnsuitableMoves { .. }), "{error:?}");
    assert_says(&error, &["event chains", "LocalMoves", "any_moves"]);
    // The paper's moves are its own, and others can be allowed.
    let mut simulation = builder().scheme(Instantaneous::default()).build().unwrap();
    simulation.run(1, &mut ()).unwrap();
    assert!(simulation.move_counts().trials > 0 && simulation.move_counts().chains == 0);
    let any = Instantaneous::default().any_moves();
    builder().scheme(any).moves(EventChains::default()).build().unwrap();
    // No call undoes another.
    let mut simulation = builder().moves(EventChains::default()).scheme(any).seed(3).build().unwrap();
    simulation.run(1, &mut ()).unwrap();
    assert!(simulation.move_counts().chains > 0);
}

#[test]
fn a_temperature_that_says_wrongly_that_it_is_constant() {
    struct Liar;
    impl TemperatureProfile for Liar {
        fn temperature(&self, height: f64) -> f64 {
            3.0 + 0.01 * height
        }
        fn constant(&self) -> Option<f64> {
            Some(3.0)
        }
    }
    let error = Scene::new(slab(), 50, gravity(), Liar).map(drop).unwrap_err();
    assert!(matches!(error, Error::InconsistentTemperature { height, .. } if height > 0.0), "{error:?}");
    assert_says(&error, &["returns 3 for all heights", "constant"]);
}

#[test]
fn errors_print_as_sentences() {
    /// What `fn main() -> Result<(), Error>` prints.
    fn printed(error: &Error) -> String {
        format!("{error:?}")
    }
    let error = Isothermal::new(-1.0).unwrap_err();
    assert_eq!(printed(&error), "temperature = -1 is invalid: it must be positive and finite");
    let mut simulation = Simulation::builder(scene(30)).start(ClosePacked).moves(small()).build().unwrap();
    let error = simulation.run(10, &mut Fragile { fails_at: 7, seen: 0 }).unwrap_err();
    assert!(printed(&error).contains("Fragile failed after sweep 7: out of ink"), "{error:?}");
    let custom: Box<dyn std::error::Error + Send + Sync> = "the file is empty".into();
    assert_eq!(printed(&Error::Custom(custom)), "the file is empty");
}

#[test]
fn bins_of_schemes() {
    for value in NOT_POSITIVE {
        assert_refused(Instantaneous::new(value), value);
        assert_refused(RunningAverage::new(value), value);
        assert_refused(AveragedThenFrozen::new(value), value);
        assert_refused(SelfConsistent::default().bin_width(value), value);
        assert_refused(SelfConsistent::default().closure_weight(value), value);
        assert_refused(EquationOfStateClosure::new(NoInteraction).bin_width(value), value);
        assert_refused(EffectivePotential::new(&cooling(), value), value);
    }
    for value in [1e-300, 5e-324, 1e-7] {
        for error in [
            Instantaneous::new(value).unwrap().drive(&cooling()).unwrap_err(),
            SelfConsistent::default().bin_width(value).unwrap().drive(&cooling()).unwrap_err(),
            EquationOfStateClosure::new(NoInteraction)
                .bin_width(value)
                .unwrap()
                .drive(&cooling())
                .unwrap_err(),
        ] {
            assert!(matches!(error, Error::InvalidBins { .. }), "{error:?}");
            // The range of the centers.
            assert_says(&error, &["49 diameters", "use between 1 and"]);
        }
    }
    assert_says(&Instantaneous::new(1e-7).unwrap().drive(&cooling()).unwrap_err(), &["490000000 bins"]);
    // A single bin is a bin, and no interval is an interval of one.
    assert!(Instantaneous::new(1e6).unwrap().drive(&cooling()).is_ok());
    let scheme = SelfConsistent::default().bin_width(f64::MAX).unwrap();
    let mut simulation =
        Simulation::builder(cooling()).scheme(scheme).start(ClosePacked).moves(small()).build().unwrap();
    simulation.equilibrate(3, &mut Every::new(0, ())).unwrap();
    simulation.run(3, &mut ()).unwrap();
}

fn build_from(
    positions: Vec<Vector3<f64>>,
    particles: usize,
) -> Result<Simulation<UniformField, Isothermal>, Error> {
    Simulation::builder(scene(particles)).start(Positions(positions)).build()
}

/// A row of spheres 1.5 apart, far from all edges.
fn row(count: usize) -> Vec<Vector3<f64>> {
    (0..count).map(|index| Vector3::new(1.0 + 1.5 * index as f64, 2.0, 2.0)).collect()
}

#[test]
fn positions_that_overlap() {
    for (first, second) in [(0, 9), (3, 7), (8, 9)] {
        let mut positions = row(10);
        positions[second] = positions[first] + Vector3::new(0.0, 0.25, 0.0);
        let error = build_from(positions, 10).unwrap_err();
        let Error::Overlap { first: found, second: other, distance, .. } = error else { panic!("{error:?}") };
        assert_eq!((found, other), (first, second));
        approx::assert_relative_eq!(distance, 0.25, max_relative = 1e-12);
        assert_says(&error, &[&first.to_string(), &second.to_string(), "0.25"]);
    }
    // Across a periodic edge, and at the edge itself, which is the same point as zero.
    for (first, second, expected) in [(0.1, 4.9, 0.2), (0.0, 5.0, 0.0), (-0.0, 4.5, 0.5)] {
        let positions = vec![Vector3::new(1.0, first, 1.0), Vector3::new(1.0, second, 1.0)];
        let error = build_from(positions, 2).unwrap_err();
        let Error::Overlap { first: 0, second: 1, distance, .. } = error else { panic!("{error:?}") };
        approx::assert_abs_diff_eq!(distance, expected, epsilon = 1e-12);
    }
    // Touching is allowed.
    assert!(build_from(vec![Vector3::new(1.0, 1.0, 1.0), Vector3::new(2.0, 1.0, 1.0)], 2).is_ok());
}

#[test]
fn positions_outside() {
    let cases = [
        (0, 'x', 0.499_999),
        (0, 'x', 49.500_001),
        (0, 'x', -3.0),
        (0, 'x', f64::NAN),
        (0, 'x', f64::INFINITY),
        (1, 'y', -1e-9),
        (1, 'y', 5.000_001),
        (1, 'y', f64::NAN),
        (1, 'y', f64::NEG_INFINITY),
        (2, 'z', -1e300),
        (2, 'z', 1e300),
        (2, 'z', f64::NAN),
    ];
    for (axis_index, axis, bad) in cases {
        for sphere in [0, 4, 9] {
            let mut positions = row(10);
            positions[sphere][axis_index] = bad;
            let error = build_from(positions, 10).unwrap_err();
            let Error::OutsideSlab { index, axis: found, value, lowest, highest, .. } = error else {
                panic!("{error:?}")
            };
            assert_eq!((index, found, value.to_bits()), (sphere, axis, bad.to_bits()));
            assert_eq!([lowest, highest], if axis == 'x' { [0.5, 49.5] } else { [0.0, 5.0] });
            assert_says(&error, &[&sphere.to_string(), &axis.to_string(), &shown(bad), "move it inside"]);
        }
    }
}

/// A start of one's own.
struct Forgetful;
impl Start for Forgetful {
    fn place(&self, _: &AnyScene<'_>, _: &mut Generator) -> Result<Vec<Vector3<f64>>, Error> {
        Ok(vec![Vector3::new(f64::NAN, 0.0, 0.0)])
    }
}

#[test]
fn positions_of_the_wrong_number() {
    for count in [0, 9, 11] {
        let error = build_from(row(count), 10).unwrap_err();
        assert!(matches!(error, Error::WrongParticleCount { expected: 10, found, .. } if found == count));
        assert_says(&error, &[&count.to_string(), "10"]);
    }
    // A start of one's own is checked like any other.
    let outcome = Simulation::builder(scene(1)).start(Forgetful).build();
    assert!(matches!(outcome, Err(Error::OutsideSlab { index: 0, axis: 'x', .. })));
}

#[test]
fn random_insertion_that_cannot_succeed() {
    // Packing fraction 0.5 is beyond the jamming of random insertion.
    let small = Slab::new(10.0, 5.0, 5.0).unwrap();
    let scene = Scene::new(small, 240, gravity(), warm()).unwrap();
    let error = Simulation::builder(scene).start(RandomInsertion::new(1.0).unwrap()).build().unwrap_err();
    let Error::InsertionFailed { placed, requested: 240, attempts: 1_000_000, packing_fraction, .. } = error
    else {
        panic!("{error:?}")
    };
    assert!(placed < 240 && packing_fraction > 0.3 && packing_fraction < 0.5);
    assert_says(&error, &[&placed.to_string(), "240", "close-packed crystal"]);
    // A density no matter can have puts all on the base.
    let error = Simulation::builder(self::scene(200))
        .start(RandomInsertion::new(1e300).unwrap())
        .build()
        .unwrap_err();
    assert!(matches!(error, Error::InsertionFailed { attempts: 1_000_000, .. }), "{error:?}");
    for value in NOT_POSITIVE {
        assert_refused(RandomInsertion::new(value), value);
    }
}

#[test]
fn crystals_without_room() {
    // Below the bound of close packing, yet more than any lattice has sites for in so small a box.
    let tiny = Slab::new(3.0, 3.0, 3.0).unwrap();
    let particles = tiny.capacity();
    let scene = || Scene::new(tiny, particles, gravity(), warm()).unwrap();
    let error = Simulation::builder(scene()).start(ClosePacked).build().unwrap_err();
    let Error::LatticeFull { sites, particles: found, .. } = error else { panic!("{error:?}") };
    assert!(found == particles && sites < particles);
    assert_says(&error, &[&sites.to_string(), &particles.to_string(), "larger slab"]);
    let error = Simulation::builder(scene()).start(Theory).build().unwrap_err();
    assert!(matches!(error, Error::LatticeFull { .. }), "{error:?}");
    // As many as there are sites do fit.
    let scene = Scene::new(tiny, sites, gravity(), warm()).unwrap();
    let mut full = Simulation::builder(scene).start(ClosePacked).moves(small()).build().unwrap();
    full.equilibrate(10, &mut ()).unwrap();
}

/// An observer that fails at one sweep, with an error of its own.
struct Fragile {
    fails_at: u64,
    seen: u64,
}

#[derive(Debug, thiserror::Error, PartialEq)]
#[error("out of ink at sweep {0}")]
struct OutOfInk(u64);

impl Observer for Fragile {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        if frame.sweep() == self.fails_at {
            return Err(OutOfInk(frame.sweep()).into());
        }
        self.seen += 1;
        Ok(())
    }
}

#[test]
fn an_observer_that_fails_does_not_spoil_the_run() {
    let mut simulation =
        Simulation::builder(scene(30)).start(ClosePacked).seed(9).moves(small()).build().unwrap();
    let mut observer = (Fragile { fails_at: 7, seen: 0 }, Every::new(2, Fragile { fails_at: 99, seen: 0 }));
    simulation.equilibrate(5, &mut observer).unwrap();
    let error = simulation.run(10, &mut observer).unwrap_err();
    assert_says(&error, &["observer .0 of the tuple", "Fragile", "sweep 7: out of ink at sweep 7"]);
    let source = std::error::Error::source(&error).expect("the observer's own error is the source");
    assert_eq!(source.downcast_ref::<OutOfInk>(), Some(&OutOfInk(7)));
    assert_eq!((simulation.sweep(), simulation.move_counts().trials), (7, 7 * 30));
    simulation.run(8, &mut observer).unwrap();
    assert_eq!((simulation.sweep(), observer.0.seen, observer.1.observer.seen), (15, 14, 7));
    // The same spheres as in a run that nobody disturbed.
    let mut undisturbed =
        Simulation::builder(scene(30)).start(ClosePacked).seed(9).moves(small()).build().unwrap();
    undisturbed.run(15, &mut ()).unwrap();
    assert_eq!(simulation.positions(), undisturbed.positions());
    // Inside another tuple, and alone.
    let fails_next = || Fragile { fails_at: undisturbed.sweep() + 1, seen: 0 };
    let mut tuple = ((), (Every::new(1, ()), fails_next()), fails_next());
    let mut alone = fails_next();
    for (observer, place) in
        [(&mut tuple as &mut dyn Observer, &[1, 1][..]), (&mut alone as &mut dyn Observer, &[][..])]
    {
        let error = simulation.clone().run(1, observer).unwrap_err();
        let Error::Observer { position, .. } = &error else { panic!("{error}") };
        assert_eq!(position, place, "{error}");
        assert!(format!("{error:?}").ends_with("after sweep 16: out of ink at sweep 16"), "{error:?}");
    }
}

#[test]
fn tallies_of_different_runs() {
    let mut simulation = Simulation::builder(scene(30)).start(ClosePacked).moves(small()).build().unwrap();
    let before = *simulation.move_counts();
    simulation.run(2, &mut ()).unwrap();
    let after = *simulation.move_counts();
    assert_eq!(after.since(&before), after);
    assert_eq!(before.since(&after), MoveCounts::default());
    assert!(MoveCounts::default().acceptance().is_nan());
}

/// Any number at all, the awkward ones often.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        prop::sample::select(vec![
            0.0,
            -0.0,
            1.0,
            -1.0,
            0.1,
            3.0,
            5e-324,
            f64::MIN_POSITIVE,
            -f64::MIN_POSITIVE,
            f64::EPSILON,
            1e-8,
            1e6,
            1e308,
            f64::MAX,
            f64::MIN,
            f64::NAN,
            f64::INFINITY,
            f64::NEG_INFINITY,
        ]),
        any::<f64>(),
        -10.0..10.0_f64,
    ]
}

fn fuzz_slab() -> Slab {
    Slab::new(12.0, 3.0, 4.0).unwrap()
}

/// Builds and runs whatever can be built; only a panic fails.
fn exercise<F: Field, T: TemperatureProfile>(field: &F, temperature: &T, bin_width: f64) {
    fn try_scheme<F: Field, T: TemperatureProfile, S: Scheme<F, T>>(
        scene: Scene<F, T>,
        scheme: S,
        start: impl Start + 'static,
    ) {
        if let Ok(mut simulation) =
            Simulation::builder(scene).scheme(scheme).start(start).seed(1).moves(small()).build()
        {
            let _ = simulation.equilibrate(3, &mut ());
            let _ = simulation.run(3, &mut ());
        }
    }
    // Table widths that are allowed but take seconds are not the point.
    let bin_width = if bin_width > 0.0 && bin_width < 1e-3 { 1e-300 } else { bin_width };
    let Ok(scene) = Scene::new(fuzz_slab(), 6, field, temperature) else { return };
    try_scheme(scene, Automatic, Theory);
    try_scheme(scene, EquationOfStateClosure::new(FluidSolid::default()), Theory);
    // All refuse the same widths.
    let Ok(instantaneous) = Instantaneous::new(bin_width) else { return };
    try_scheme(scene, instantaneous, RandomInsertion::new(bin_width).unwrap());
    let closure = EquationOfStateClosure::new(NoInteraction).bin_width(bin_width).unwrap();
    try_scheme(scene, closure, ClosePacked);
    try_scheme(scene, SelfConsistent::default().bin_width(bin_width).unwrap(), Theory);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    #[test]
    fn no_number_makes_a_constructor_panic(a in any_number(), b in any_number(), c in any_number(), count in any::<usize>()) {
        if let Ok(slab) = Slab::new(a, b, c) {
            prop_assert!(slab.height() >= 2.0 && slab.widths().iter().all(|width| *width >= 3.0));
            let _ = (slab.capacity(), slab.packing_fraction(count), LocalMoves::new(c));
            // Beyond the limits of memory it must be an error, whatever the number of spheres.
            if slab.base_area() * slab.height() > Slab::MAXIMUM_VOLUME {
                let refused = Scene::new(slab, count.max(1), gravity(), warm()).map(drop);
                prop_assert!(matches!(refused, Err(Error::SlabTooLarge { .. })), "{refused:?}");
            }
        }
        let _ = LocalMoves::new(a);
        let _ = TabulatedTemperature::new(vec![(a, b), (b, c), (c, a)]);
        let _ = (number_density(a), packing_fraction(a));
        for equation_of_state in [&NoInteraction as &dyn EquationOfState, &FluidSolid::default()] {
            let _ = equation_of_state.compressibility_factor(a);
            let _ = equation_of_state.compressibility_derivative(a);
            let _ = equation_of_state.excess_chemical_potential(a);
        }
        if count > slab().capacity() {
            let refused = Scene::new(slab(), count, gravity(), warm()).map(drop);
            prop_assert!(matches!(refused, Err(Error::TooManyParticles { .. })), "{refused:?}");
        }
    }

    #[test]
    fn no_number_makes_a_position_panic(numbers in prop::collection::vec(any_number(), 9)) {
        let positions = numbers.chunks(3).map(|p| Vector3::new(p[0], p[1], p[2])).collect();
        if let Ok(mut simulation) = build_from(positions, 3) {
            simulation.equilibrate(3, &mut ()).unwrap();
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, ..ProptestConfig::default() })]

    #[test]
    fn no_number_makes_a_run_panic(
        kind in 0..4_u8,
        profile in 0..4_u8,
        [a, b, c, d, width] in [any_number(), any_number(), any_number(), any_number(), any_number()],
    ) {
        let field: Box<dyn Field> = match kind {
            0 => { let Ok(field) = UniformField::new(a) else { return Ok(()) }; Box::new(field) }
            1 => { let Ok(field) = ExponentialField::new(a) else { return Ok(()) }; Box::new(field) }
            2 => {
                let (Ok(linear), Ok(uniform)) = (LinearField::new(a, b), UniformField::new(b)) else { return Ok(()) };
                Box::new(SumField(linear, uniform))
            }
            _ => {
                let Ok(field) = FieldFn::new(move |height: f64| a + b * (c * height).sin(), &fuzz_slab()) else { return Ok(()) };
                Box::new(field)
            }
        };
        let temperature: Box<dyn TemperatureProfile> = match profile {
            0 => { let Ok(profile) = ExponentialTemperature::new(c, d) else { return Ok(()) }; Box::new(profile) }
            1 => { let Ok(profile) = LinearTemperature::new(c, d) else { return Ok(()) }; Box::new(profile) }
            2 => {
                let Ok(profile) = TabulatedTemperature::new(vec![(0.0, c), (a, d)]) else { return Ok(()) };
                Box::new(profile)
            }
            _ => Box::new(TemperatureFn(move |height: f64| c + d * height)),
        };
        exercise(&field, &temperature, width);
        if let (Ok(isothermal), Ok(scene)) = (Isothermal::new(c), Scene::new(fuzz_slab(), 6, &field, &temperature)) {
            let _ = scene.column_density();
            let Ok(scene) = Scene::new(fuzz_slab(), 6, &field, isothermal) else { return Ok(()) };
            if let Ok(mut simulation) = Simulation::builder(scene).start(ClosePacked).moves(LocalMoves::new(1.5).unwrap()).build() {
                let _ = simulation.equilibrate(3, &mut ());
            }
        }
    }
}
