//! Event chains: exact results, agreement with local moves, determinism, and difficult scenes.

// Positions are compared to the last bit.
#![allow(clippy::float_cmp)]

use crate::common::exact::{
    TWO_SPHERES_MEAN, TWO_SPHERES_VARIANCE, agrees, center_of_mass, contact_density, ideal_gas_mean,
    mean_height, meet,
};
use crate::common::scenes::FieldCase;
use gradient_mc::drive::{Automatic, Drive, EquationOfStateClosure, Scheme, SelfConsistent};
use gradient_mc::equation_of_state::IdealGas;
use gradient_mc::field::{ExponentialField, LinearField, SumField, UniformField};
use gradient_mc::moves::{EventChains, FieldEvent, LocalMoves, Moves};
use gradient_mc::observers::{Bins, CenterOfMass, DensityProfile};
use gradient_mc::start::{ClosePacked, Positions, RandomInsertion};
use gradient_mc::statistics::{BlockAverages, Estimate};
use gradient_mc::temperature::{ExponentialTemperature, Isothermal};
use gradient_mc::{
    Error, Every, Field, Frame, Observer, ObserverError, Scene, Simulation, SimulationBuilder, Slab,
    TemperatureProfile, Vector3,
};

const RULES: [FieldEvent; 2] = [FieldEvent::Relocate, FieldEvent::Reverse];

fn chains(length: f64, rule: FieldEvent) -> EventChains {
    EventChains::with_length(length).unwrap().field_event(rule).local_moves(None)
}

/// Chains of tuned length.
fn tuned(rule: FieldEvent) -> EventChains {
    EventChains::default().field_event(rule).local_moves(None)
}

/// One sphere, which has the profile n ∝ exp(−u).
fn one_sphere<F: Field, T: TemperatureProfile>(
    height: f64,
    field: F,
    temperature: T,
) -> SimulationBuilder<F, T> {
    let slab = Slab::new(height, 3.0, 4.0).unwrap();
    Simulation::builder(Scene::new(slab, 1, field, temperature).unwrap()).seed(17)
}

#[test]
fn one_sphere_in_a_uniform_field() {
    let temperature = 2.0;
    for rule in RULES {
        // The last is as long as the slab is high.
        for moves in [tuned(rule), chains(0.7, rule), chains(60.0, rule)] {
            let builder = one_sphere(60.0, UniformField::default(), Isothermal::new(temperature).unwrap());
            let heights = center_of_mass(builder.moves(moves).build().unwrap(), 1_700_000, 10);
            agrees("mean height", heights.estimate().unwrap(), 0.5 + temperature, 0.025).unwrap();
            // Var(x) = T² for one sphere.
            agrees("variance", heights.variance().unwrap(), temperature * temperature, 0.16).unwrap();
        }
    }
}

#[test]
fn ideal_gas_under_a_lid() {
    let (temperature, height) = (15.0_f64, 21.0);
    let free = height - 1.0;
    let exact = 0.5 + temperature - free / (free / temperature).exp_m1();
    for rule in RULES {
        let builder = one_sphere(height, UniformField::default(), Isothermal::new(temperature).unwrap());
        let heights = center_of_mass(builder.moves(chains(20.0, rule)).build().unwrap(), 1_000_000, 10);
        agrees("mean height", heights.estimate().unwrap(), exact, 0.06).unwrap();
    }
}

#[test]
fn one_sphere_without_a_field() {
    let builder = one_sphere(9.0, UniformField::new(0.0).unwrap(), Isothermal::new(1.0).unwrap());
    let heights =
        center_of_mass(builder.moves(chains(5.0, FieldEvent::Relocate)).build().unwrap(), 250_000, 10);
    agrees("mean height", heights.estimate().unwrap(), 4.5, 0.03).unwrap();
    agrees("variance", heights.variance().unwrap(), 64.0 / 12.0, 0.08).unwrap();
}

#[test]
fn one_sphere_in_fields_that_turn_round() {
    let temperature = 2.0;
    for rule in RULES {
        // Down below, up above: a hill of the potential, then the lid.
        let field = SumField(UniformField::new(1.5).unwrap(), LinearField::new(0.0, -0.3).unwrap());
        let builder = one_sphere(12.0, field, Isothermal::new(temperature).unwrap());
        let heights = center_of_mass(builder.moves(chains(5.0, rule)).build().unwrap(), 1_000_000, 10);
        let exact = mean_height(12.0, |x| (-(1.5 * x - 0.15 * x * x) / temperature).exp());
        agrees("hill", heights.estimate().unwrap(), exact, 0.04).unwrap();

        // Changes sign six times.
        let wave = FieldCase::Wave(3.0, 1.9);
        let slab = Slab::new(12.0, 3.0, 4.0).unwrap();
        let builder = one_sphere(12.0, wave.make(&slab), Isothermal::new(temperature).unwrap());
        let heights = center_of_mass(builder.moves(chains(5.0, rule)).build().unwrap(), 1_000_000, 10);
        let exact = mean_height(12.0, |x| (-wave.potential(x) / temperature).exp());
        agrees("wave", heights.estimate().unwrap(), exact, 0.02).unwrap();
    }
}

#[test]
fn one_sphere_where_both_fields_vary() {
    for (base, alpha, beta, height) in [(6.0, 0.03, 0.05, 50.0), (6.0, 0.0, 0.25, 14.0)] {
        let mean = |rule: FieldEvent| {
            let field = ExponentialField::new(alpha).unwrap();
            let temperature = ExponentialTemperature::new(base, beta).unwrap();
            let closure = EquationOfStateClosure::new(IdealGas);
            let builder = one_sphere(height, field, temperature).scheme(closure);
            let simulation = builder.moves(chains(10.0, rule)).build().unwrap();
            if beta > 0.2 {
                // Up at first, where T β > 1, and down above.
                let force = |x: f64| simulation.drive().reduced_force(simulation.scene(), x);
                assert!(force(1.0) < 0.0 && force(12.0) > 0.0);
            }
            center_of_mass(simulation, 600_000, 10).estimate().unwrap()
        };
        let exact = ideal_gas_mean(height, base, alpha, beta);
        for rule in RULES {
            agrees("closure", mean(rule), exact, 0.05).unwrap();
        }
    }
}

#[test]
fn two_spheres() {
    let slab = Slab::new(30.0, 3.0, 3.0).unwrap();
    let scene = Scene::new(slab, 2, UniformField::default(), Isothermal::new(1.0).unwrap()).unwrap();
    for rule in RULES {
        for moves in [chains(0.4, rule), chains(3.0, rule), tuned(rule)] {
            let build =
                || Simulation::builder(scene).start(RandomInsertion::default()).moves(moves).seed(5).build();
            let heights = center_of_mass(build().unwrap(), 800_000, 10);
            agrees("mean height", heights.estimate().unwrap(), TWO_SPHERES_MEAN, 0.01).unwrap();
            agrees("variance", heights.variance().unwrap(), TWO_SPHERES_VARIANCE, 0.016).unwrap();
        }
        let profile = DensityProfile::new(&slab, Bins::count(10).from(0.5).to(0.7)).unwrap();
        let mut observer = Every::new(4, profile);
        let moves = chains(3.0, rule);
        let builder = Simulation::builder(scene).start(RandomInsertion::default()).moves(moves).seed(5);
        builder.build().unwrap().run(1_500_000, &mut observer).unwrap();
        let contact = observer.observer.jackknife(|bins| [contact_density(bins)]).unwrap()[0];
        agrees("contact density", contact, 2.0 / 9.0, 0.006).unwrap();
    }
}

/// Σ u'(x)/A over the spheres, whose mean the contact density n(½⁺) equals where the lid is out of
/// reach.
struct ReducedWeight<'a> {
    force: &'a dyn Fn(f64) -> f64,
    averages: BlockAverages,
}

impl Observer for ReducedWeight<'_> {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        let sum: f64 = frame.heights().map(self.force).sum();
        Ok(self.averages.push(&[sum / frame.slab().base_area()])?)
    }
}

/// A small column, 4 spheres to the area.
#[derive(Debug, Clone, Copy)]
struct Column<T> {
    field: FieldCase,
    temperature: T,
    /// Cap on the relative error of the contact density.
    contact_cap: f64,
}

impl<T: TemperatureProfile + Copy> Column<T> {
    const COLUMN_DENSITY: f64 = 4.0;

    fn scene(&self) -> Scene<Box<dyn Field>, T> {
        let slab = Slab::new(30.0, 4.0, 4.0).unwrap();
        let scene = Scene::new(slab, 64, self.field.make(&slab), self.temperature).unwrap();
        assert_eq!(scene.column_density(), Self::COLUMN_DENSITY);
        scene
    }

    /// Contact density, `h_c`, and n(x) in bins of one diameter from the base, of one run. The
    /// contact theorem holds.
    fn observe<S>(&self, scheme: S, moves: Moves, sweeps: u64) -> Result<Vec<Estimate>, String>
    where
        S: Scheme<Box<dyn Field>, T> + Copy,
    {
        let scene = self.scene();
        let slab = *scene.slab();
        let drive = scheme.drive(&scene).unwrap().0;
        let force = |x: f64| drive.reduced_force(&scene, x);
        let weight = ReducedWeight { force: &force, averages: BlockAverages::new(1).unwrap() };
        let contact = DensityProfile::new(&slab, Bins::count(10).from(0.5).to(0.7)).unwrap();
        let bands = DensityProfile::new(&slab, Bins::count(10).from(0.5).to(10.5)).unwrap();
        let mut observers = Every::new(4, (CenterOfMass::new(), bands, contact, weight));
        let builder = Simulation::builder(self.scene()).scheme(scheme).moves(moves);
        let mut simulation = builder.seed(23).build().unwrap();
        simulation.equilibrate(sweeps / 5, &mut ()).unwrap();
        simulation.run(sweeps, &mut observers).unwrap();
        let (heights, bands, contact, weight) = observers.observer;
        let contact = contact.jackknife(|bins| [contact_density(bins)]).unwrap()[0];
        let expected = weight.averages.estimates().unwrap()[0];
        meet("contact theorem", contact, expected, self.contact_cap)?;
        let mut values = vec![contact, heights.estimate().unwrap()];
        values.extend(bands.points().unwrap().iter().map(|point| point.number_density));
        Ok(values)
    }

    /// Local moves against chains of both rules; the contact density by the default chains.
    fn compare<S>(&self, scheme: S) -> Estimate
    where
        S: Scheme<Box<dyn Field>, T> + Copy,
    {
        let local = LocalMoves::new(0.8).unwrap();
        let local = self.observe(scheme, local.into(), 110_000).unwrap();
        let choices = [EventChains::default(), tuned(FieldEvent::Relocate), chains(6.0, FieldEvent::Reverse)];
        let found = choices.map(|moves| self.observe(scheme, moves.into(), 50_000).unwrap());
        for found in &found {
            agree(&found[..1], &local[..1], 1.5 * self.contact_cap).unwrap();
            agree(&found[1..], &local[1..], 0.03).unwrap();
        }
        found[0][0]
    }
}

/// Two runs agree within 4 joint errors in every item, errors of at most `cap` included.
fn agree(first: &[Estimate], second: &[Estimate], cap: f64) -> Result<(), String> {
    for (item, (a, b)) in first.iter().zip(second).enumerate() {
        meet(&format!("item {item}"), *a, *b, cap)?;
    }
    Ok(())
}

#[test]
fn chains_agree_with_local_moves_in_a_uniform_field() {
    let temperature = 2.0;
    let column = Column {
        field: FieldCase::Uniform(1.0),
        temperature: Isothermal::new(temperature).unwrap(),
        contact_cap: 0.06,
    };
    let contact = column.compare(Automatic);
    // Here the contact theorem needs no measurement.
    agrees("weight", contact, Column::<Isothermal>::COLUMN_DENSITY / temperature, 0.08).unwrap();
}

#[test]
fn chains_agree_with_local_moves_in_an_exponential_field() {
    let column = Column {
        field: FieldCase::Exponential(0.1),
        temperature: Isothermal::new(3.0).unwrap(),
        contact_cap: 0.07,
    };
    column.compare(Automatic);
}

#[test]
fn chains_agree_with_local_moves_in_a_temperature_gradient() {
    let temperature = ExponentialTemperature::new(5.0, 0.13).unwrap();
    let column = Column { field: FieldCase::Uniform(1.0), temperature, contact_cap: 0.2 };
    let closure = EquationOfStateClosure::default();
    // Up below, where T decays faster than the weight presses, and down above.
    let scene = column.scene();
    let drive = closure.drive(&scene).unwrap().0;
    let force = |x: f64| drive.reduced_force(&scene, x);
    assert!(force(1.0) < -0.03 && force(12.0) > 0.3, "{} {}", force(1.0), force(12.0));
    column.compare(closure);
}

fn small_scene() -> Scene<UniformField, Isothermal> {
    let slab = Slab::new(40.0, 4.0, 5.0).unwrap();
    Scene::new(slab, 80, UniformField::default(), Isothermal::new(3.0).unwrap()).unwrap()
}

#[test]
fn a_seed_decides_everything() {
    for rule in RULES {
        for moves in [chains(7.0, rule), EventChains::default().field_event(rule)] {
            let go = |seed: u64, parts: &[u64]| {
                let mut simulation =
                    Simulation::builder(small_scene()).moves(moves).seed(seed).build().unwrap();
                simulation.equilibrate(50, &mut ()).unwrap();
                for &part in parts {
                    simulation.run(part, &mut ()).unwrap();
                }
                (simulation.positions(), *simulation.move_counts())
            };
            assert_eq!(go(1, &[100]), go(1, &[100]));
            // Neither where a run is cut nor who looks matters.
            assert_eq!(go(1, &[100]), go(1, &[1, 60, 39]));
            assert_ne!(go(1, &[100]).0, go(2, &[100]).0);
        }
    }
}

#[test]
fn a_sweep_has_its_path_on_average() {
    // Lateral chains are on average as long as the slab is wide.
    let mean = |length: f64| if length < 4.0 { length } else { 1.0 / (0.9 / length + 0.1 / 4.5) };
    for length in [0.01, 1.0, 900.0] {
        let moves = chains(length, FieldEvent::Relocate);
        let mut simulation = Simulation::builder(small_scene()).moves(moves).seed(4).build().unwrap();
        let sweeps = 1000;
        simulation.run(sweeps, &mut ()).unwrap();
        let expected = EventChains::PATH_PER_SPHERE * (80 * sweeps) as f64 / mean(length);
        let found = simulation.move_counts().chains as f64;
        // Lengths are uniform between 0 and twice the mean, and of two kinds; one chain more is on its way.
        assert!((found - expected).abs() < 4.0 * (2.0 * expected).sqrt() + 1.0, "{found}, {expected}");
    }
}

#[test]
fn a_compact_start_melts() {
    // Rows of spheres that all but touch around the box: the start leaves gaps, or chains would be
    // stuck.
    let slab = Slab::new(60.0, 4.0, 4.0).unwrap();
    let scene = Scene::new(slab, 160, UniformField::default(), Isothermal::new(6.0).unwrap()).unwrap();
    let moves = tuned(FieldEvent::Relocate);
    let build = || Simulation::builder(scene).start(ClosePacked).moves(moves).seed(3).build().unwrap();
    let lateral = moves.vertical_fraction(0.01).unwrap();
    let mut crystal = Simulation::builder(scene).start(ClosePacked).moves(lateral).seed(3).build().unwrap();
    crystal.run(50, &mut ()).unwrap();
    let mut simulation = build();
    simulation.equilibrate(2000, &mut ()).unwrap();
    let mut heights = CenterOfMass::new();
    simulation.run(4000, &mut heights).unwrap();
    let local = Simulation::builder(scene).moves(LocalMoves::new(0.8).unwrap()).seed(3).build().unwrap();
    let local = center_of_mass(local, 40_000, 10).estimate().unwrap();
    agree(&[heights.estimate().unwrap()], &[local], 0.02).unwrap();
}

/// A crystal that fills the box, rows along y touching exactly.
fn jammed() -> Simulation<UniformField, Isothermal> {
    let slab = Slab::new(3.0, 3.0, 3.0).unwrap();
    let mut positions = Vec::new();
    for layer in 0..3 {
        for row in 0..3 {
            let along = |sphere: i32| Vector3::new(f64::from(layer) + 0.5, f64::from(sphere), f64::from(row));
            positions.extend((0..3).map(along));
        }
    }
    positions.retain(|position| position.x <= slab.highest_center());
    let scene = Scene::new(slab, positions.len(), UniformField::default(), Isothermal::new(1.0).unwrap());
    Simulation::builder(scene.unwrap()).start(Positions(positions)).build().unwrap()
}

#[test]
fn a_jammed_crystal_is_an_error_not_a_hang() {
    for rule in RULES {
        for length in [1.0, 1e6] {
            let positions = jammed().positions();
            let scene = *jammed().scene();
            let builder = Simulation::builder(scene).start(Positions(positions.clone()));
            let mut simulation = builder.moves(chains(length, rule)).build().unwrap();
            let error = simulation.run(100, &mut ()).unwrap_err();
            let Error::ChainStuck { length, path, .. } = error else { panic!("{error:?}") };
            assert!(path < 1e-6 && length > 0.0);
            assert!(error.to_string().contains("loosen the packing"));
            // One chain, given up after a million pieces.
            assert!(simulation.move_counts().events <= 1_000_000, "{:?}", simulation.move_counts());
            // Nothing is broken, and equilibration goes on as well as it can.
            simulation.equilibrate(5, &mut ()).unwrap();
            for (now, then) in simulation.positions().iter().zip(&positions) {
                assert!((now - then).norm() < 1e-6);
            }
        }
    }
}

#[test]
fn numbers_that_make_no_sense() {
    let refused = |outcome: Result<EventChains, Error>, value: f64| {
        let error = outcome.unwrap_err();
        let Error::InvalidParameter { value: carried, .. } = error else { panic!("{error:?}") };
        assert_eq!(carried.to_bits(), value.to_bits());
        assert!(error.to_string().contains("event chains"), "{error}");
    };
    for length in [
        0.0,
        -0.0,
        -1.0,
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        1e7,
        1e6_f64.next_up(),
        5e-324,
        1e-3_f64.next_down(),
    ] {
        refused(EventChains::with_length(length), length);
    }
    for fraction in [0.0, -0.0, 1.0, -0.5, 1.5, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        refused(EventChains::default().vertical_fraction(fraction), fraction);
    }
    // The extremes that are allowed do run.
    for length in [EventChains::MINIMUM_LENGTH, 1.0, EventChains::MAXIMUM_LENGTH] {
        let moves = chains(length, FieldEvent::Relocate).vertical_fraction(f64::MIN_POSITIVE).unwrap();
        assert_eq!(moves.length(), Some(length));
        let moves = moves.vertical_fraction(1.0_f64.next_down()).unwrap();
        let mut simulation = Simulation::builder(small_scene()).moves(moves).build().unwrap();
        simulation.run(3, &mut ()).unwrap();
    }
}

/// One sphere in a field, driven by chains.
fn run_in<F: Field>(height: f64, field: F, sweeps: u64) -> Result<Estimate, Error> {
    let scene = Scene::new(Slab::new(height, 3.0, 4.0)?, 1, field, Isothermal::new(1.0)?)?;
    let mut simulation = Simulation::builder(scene)
        .seed(17)
        .start(Positions(vec![Vector3::new(0.75, 1.0, 1.0)]))
        .moves(chains(5.0, FieldEvent::Relocate))
        .build()?;
    let mut heights = Every::new(10, CenterOfMass::new());
    simulation.equilibrate(sweeps / 10, &mut ())?;
    simulation.run(sweeps, &mut heights)?;
    heights.observer.estimate()
}

/// A force of 0.2 below an edge and 2 above.
struct Jump {
    edge: f64,
}

impl Field for Jump {
    fn potential(&self, height: f64) -> f64 {
        0.2 * height + 1.8 * (height - self.edge).max(0.0)
    }
    fn acceleration(&self, height: f64) -> f64 {
        if height < self.edge { 0.2 } else { 2.0 }
    }
}

#[test]
fn a_force_that_jumps_is_sampled() {
    for edge in [3.0, 4.77] {
        let exact = mean_height(12.0, |x| (-Jump { edge }.potential(x)).exp());
        agrees("force", run_in(12.0, Jump { edge }, 1_000_000).unwrap(), exact, 0.015).unwrap();
        // The force by differences of the potential.
        let potential = Potential(|x| Jump { edge }.potential(x));
        agrees("potential", run_in(12.0, potential, 1_000_000).unwrap(), exact, 0.015).unwrap();
    }
}

/// A potential alone; the force is its numerical derivative.
struct Potential<U>(U);

impl<U: Fn(f64) -> f64 + Send + Sync> Field for Potential<U> {
    fn potential(&self, height: f64) -> f64 {
        (self.0)(height)
    }
}

#[test]
fn a_spike_between_probes_is_an_error() {
    // The force is zero at all probes, and great between two of them.
    let spike = |size: f64, width: f64| move |x: f64| x + size * (1.0 + ((x - 5.4) / width).tanh());
    for (size, width) in [(0.5, 1e-3), (5.0, 1e-3), (0.01, 1e-3), (0.5, 1e-6)] {
        match run_in(12.0, Potential(spike(size, width)), 1000) {
            // The scene may have noticed before.
            Err(Error::InvalidForce { height, .. } | Error::InconsistentField { height, .. }) => {
                assert!((height - 5.4).abs() < 0.1, "{height}");
            }
            outcome => panic!("{size}, {width}: {outcome:?}"),
        }
    }
    // One that is wide enough is sampled.
    let wide = spike(0.5, 0.2);
    let exact = mean_height(12.0, |x| (-wide(x)).exp());
    agrees("step", run_in(12.0, Potential(wide), 2_000_000).unwrap(), exact, 0.02).unwrap();
}

#[test]
fn an_immense_force_is_an_error_not_a_hang() {
    for force in [1e9, 1e250, 1e302] {
        let scene = Scene::new(
            Slab::new(12.0, 3.0, 4.0).unwrap(),
            1,
            UniformField::new(force).unwrap(),
            Isothermal::new(1.0).unwrap(),
        );
        let start = Positions(vec![Vector3::new(0.75, 1.0, 1.0)]);
        let moves = chains(5.0, FieldEvent::Relocate);
        let builder = Simulation::builder(scene.unwrap()).start(start).moves(moves).seed(17);
        let mut simulation = builder.build().unwrap();
        match simulation.run(1000, &mut ()) {
            Err(Error::ChainStuck { .. } | Error::InvalidForce { .. }) => {}
            outcome => panic!("{force}: {outcome:?}"),
        }
        // Given up after a million pieces of a chain.
        let events = simulation.move_counts().events;
        assert!(events <= 2_000_000, "{force}: {events} events");
    }
}

#[test]
fn a_closed_box_without_a_field_is_symmetric() {
    let slab = Slab::new(6.0, 4.0, 4.0).unwrap();
    let scene = Scene::new(slab, 40, UniformField::new(0.0).unwrap(), Isothermal::new(1.0).unwrap()).unwrap();
    for rule in RULES {
        let moves = tuned(rule);
        let heights =
            center_of_mass(Simulation::builder(scene).moves(moves).seed(2).build().unwrap(), 40_000, 10);
        agrees("middle", heights.estimate().unwrap(), 3.0, 0.02).unwrap();
    }
}

#[test]
fn a_measured_field_is_followed() {
    // The drive changes while equilibrating: bounds that were kept would be wrong.
    let slab = Slab::new(40.0, 5.0, 5.0).unwrap();
    let temperature = ExponentialTemperature::new(5.0, 0.05).unwrap();
    let scene = Scene::new(slab, 100, UniformField::default(), temperature).unwrap();
    let builder = Simulation::builder(scene).scheme(SelfConsistent::default()).moves(EventChains::default());
    let mut simulation = builder.seed(6).build().unwrap();
    simulation.equilibrate(4000, &mut ()).unwrap();
    let mut observers = Every::new(
        2,
        (CenterOfMass::new(), DensityProfile::new(&slab, Bins::count(10).from(0.5).to(0.7)).unwrap()),
    );
    simulation.run(8000, &mut observers).unwrap();
    let (heights, contact) = observers.observer;
    assert!(heights.estimate().unwrap().standard_error < 0.1);
    // The contact theorem holds for whatever field was frozen.
    let contact = contact.jackknife(|bins| [contact_density(bins)]).unwrap()[0];
    let expected = scene.column_density() / 5.0;
    assert!((contact.mean / expected - 1.0).abs() < 0.15, "{contact} against {expected}");
}
