//! Invariants of all moves in all scenes: spheres do not overlap and stay inside, and runs are
//! determined by the seed.

use crate::common::scenes::{FieldCase, TemperatureCase, field_case, temperature_case};
use gradient_mc::drive::{Automatic, EquationOfStateClosure, Instantaneous, Scheme, SelfConsistent};
use gradient_mc::moves::{EventChains, FieldEvent, LocalMoves, Moves};
use gradient_mc::start::{ClosePacked, RandomInsertion, Start, Theory};
use gradient_mc::temperature::Isothermal;
use gradient_mc::{
    Error, Field, Frame, Observer, ObserverError, Scene, Simulation, Slab, TemperatureProfile, Vector3,
};
use proptest::prelude::*;

/// Distances and bounds by all pairs and nearest images, as an observer that never looks at cells.
#[derive(Default)]
struct Invariants {
    observed: u64,
}

fn check_invariants(slab: &Slab, positions: &[Vector3<f64>]) {
    let [width_y, width_z] = slab.widths();
    for (first, a) in positions.iter().enumerate() {
        assert!(a.x >= slab.lowest_center() && a.x <= slab.highest_center(), "sphere {first} at {a}");
        assert!(a.y >= 0.0 && a.y < width_y && a.z >= 0.0 && a.z < width_z, "sphere {first} at {a}");
        for (second, b) in positions.iter().enumerate().skip(first + 1) {
            let image = |distance: f64, width: f64| distance.abs().min(width - distance.abs());
            let [x, y, z] = [a.x - b.x, image(a.y - b.y, width_y), image(a.z - b.z, width_z)];
            // The last bits depend on the order of operations.
            assert!(x * x + y * y + z * z >= 1.0 - 1e-14, "spheres {first} and {second} at {a} and {b}");
        }
    }
}

impl Observer for Invariants {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.observed += 1;
        // Chains may come with local moves.
        let local = frame.move_counts().chains == 0;
        let trials = self.observed * frame.particles() as u64;
        assert!(frame.move_counts().trials == trials || !local && frame.move_counts().trials == 0);
        assert!(frame.move_counts().accepted <= frame.move_counts().trials);
        check_invariants(frame.slab(), &frame.positions().collect::<Vec<_>>());
        Ok(())
    }
}

#[derive(Debug, Clone, Copy)]
enum SchemeCase {
    Closure,
    SelfConsistent,
    Instantaneous,
}

/// Local moves with S as a fraction of the largest allowed, or chains of some length, tuned if
/// there is none.
#[derive(Debug, Clone, Copy)]
enum MovesCase {
    Local(f64),
    Chains { length: Option<f64>, vertical_fraction: f64, field_event: FieldEvent, alone: bool },
}

impl MovesCase {
    fn make(self, extents: [f64; 3]) -> Moves {
        match self {
            Self::Local(displacement) => {
                let smallest = extents.into_iter().fold(f64::INFINITY, f64::min);
                LocalMoves::new(displacement * 0.5 * smallest).unwrap().into()
            }
            Self::Chains { length, vertical_fraction, field_event, alone } => {
                let chains =
                    length.map_or(EventChains::default(), |length| EventChains::with_length(length).unwrap());
                let chains = if alone { chains.local_moves(None) } else { chains };
                chains.field_event(field_event).vertical_fraction(vertical_fraction).unwrap().into()
            }
        }
    }
}

fn moves_case() -> impl Strategy<Value = MovesCase> {
    // From next to nothing to all that is allowed.
    let displacement = prop_oneof![(-6.0..0.0_f64).prop_map(|power| 10_f64.powf(power)), Just(1.0)];
    // A slab's width and multiples of it, too.
    let length = prop_oneof![Just(None), Just(Some(3.0)), (-3.0..3.0_f64).prop_map(|p| Some(10_f64.powf(p)))];
    let field_event = prop::sample::select(vec![FieldEvent::Relocate, FieldEvent::Reverse]);
    prop_oneof![
        displacement.prop_map(MovesCase::Local),
        (length, 0.05..0.95_f64, field_event, any::<bool>()).prop_map(
            |(length, vertical_fraction, field_event, alone)| {
                MovesCase::Chains { length, vertical_fraction, field_event, alone }
            }
        ),
    ]
}

/// A small scene: extents, packing fraction, moves, seed.
#[derive(Debug, Clone, Copy)]
struct Case {
    extents: [f64; 3],
    packing_fraction: f64,
    moves: MovesCase,
    seed: u64,
    field: FieldCase,
    compact: bool,
}

impl Case {
    fn slab(&self) -> Slab {
        Slab::new(self.extents[0], self.extents[1], self.extents[2]).unwrap()
    }

    fn particles(&self) -> usize {
        let volume = self.extents.iter().product::<f64>();
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let particles = (self.packing_fraction * volume * 6.0 / std::f64::consts::PI) as usize;
        particles.max(1)
    }
}

fn case() -> impl Strategy<Value = Case> {
    let width = || prop_oneof![Just(3.0), Just(3.5), Just(4.0), 3.0..8.0];
    (
        (prop_oneof![Just(2.0), Just(3.0), 2.0..25.0], width(), width()),
        // A single sphere, too.
        prop_oneof![8 => 0.01..0.25_f64, 1 => Just(0.0)],
        moves_case(),
        any::<u64>(),
        field_case(),
        any::<bool>(),
    )
        .prop_map(|((x, y, z), packing_fraction, moves, seed, field, compact)| Case {
            extents: [x, y, z],
            packing_fraction,
            moves,
            seed,
            field,
            compact,
        })
}

/// Runs both phases under observation, goes on after a rebuild, and returns the positions.
fn run<T, S>(case: Case, temperature: T, scheme: S) -> Result<Vec<Vector3<f64>>, Error>
where
    T: TemperatureProfile,
    S: Scheme<Box<dyn Field>, T>,
{
    if case.compact {
        run_from(case, temperature, scheme, ClosePacked)
    } else {
        run_from(case, temperature, scheme, RandomInsertion::new(0.3).unwrap())
    }
}

fn run_from<T, S, P>(case: Case, temperature: T, scheme: S, start: P) -> Result<Vec<Vector3<f64>>, Error>
where
    T: TemperatureProfile,
    S: Scheme<Box<dyn Field>, T>,
    P: Start + 'static,
{
    let slab = case.slab();
    let scene = Scene::new(slab, case.particles(), case.field.make(&slab), temperature)?;
    let mut simulation = Simulation::builder(scene)
        .scheme(scheme)
        .start(start)
        .moves(case.moves.make(case.extents))
        .seed(case.seed)
        .build()?;
    check_invariants(&slab, &simulation.positions());
    let mut invariants = Invariants::default();
    simulation.equilibrate(30, &mut invariants)?;
    simulation.run(30, &mut invariants)?;
    simulation.equilibrate(5, &mut invariants)?;
    simulation.run(5, &mut invariants)?;
    assert_eq!((invariants.observed, simulation.sweep()), (70, 70));
    Ok(simulation.positions())
}

/// Starts may refuse what does not fit, hydrostatics a scene beyond its equation of state, and
/// chains a crystal that has not melted; nothing else may go wrong.
fn accept_refusals<T>(outcome: Result<T, Error>) -> Option<T> {
    match outcome {
        Ok(value) => Some(value),
        Err(
            Error::LatticeFull { .. }
            | Error::InsertionFailed { .. }
            | Error::EquationOfStateExhausted { .. }
            | Error::HydrostaticsNotConverged { .. }
            | Error::ChainStuck { .. },
        ) => None,
        Err(error) => panic!("{error}"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, ..ProptestConfig::default() })]

    #[test]
    fn isothermal_scenes_stay_valid(case in case(), temperature in 0.05..50.0_f64) {
        let go = |case| accept_refusals(run(case, Isothermal::new(temperature).unwrap(), Automatic));
        let first = go(case);
        prop_assert_eq!(&first, &go(case), "the same seed gives the same run");
        if let Some(first) = first {
            let other = go(Case { seed: case.seed ^ 1, ..case }).unwrap_or_default();
            prop_assert_ne!(first, other, "another seed gives another run");
        }
    }

    #[test]
    fn scenes_of_varying_temperature_stay_valid(
        case in case(),
        temperature in temperature_case(),
        scheme in prop::sample::select(vec![SchemeCase::Closure, SchemeCase::SelfConsistent, SchemeCase::Instantaneous]),
    ) {
        let go = |case: Case| {
            let temperature: TemperatureCase = temperature;
            let temperature = temperature.make(case.extents[0]);
            accept_refusals(match scheme {
                SchemeCase::Closure => run(case, temperature, EquationOfStateClosure::default()),
                SchemeCase::SelfConsistent => run(case, temperature, SelfConsistent::default()),
                SchemeCase::Instantaneous => run(case, temperature, Instantaneous::default().any_moves()),
            })
        };
        let first = go(case);
        prop_assert_eq!(&first, &go(case), "the same seed gives the same run");
        if let Some(first) = first {
            let other = go(Case { seed: case.seed ^ 1, ..case }).unwrap_or_default();
            prop_assert_ne!(first, other, "another seed gives another run");
        }
    }
}

#[test]
fn a_dense_column_stays_valid() {
    // Close to freezing at the base, so that cells are full and most trials meet a neighbor.
    let slab = Slab::new(80.0, 6.0, 6.0).unwrap();
    let field = FieldCase::Uniform(1.0);
    for displacement in [0.05, 0.3, 3.0] {
        let scene = Scene::new(slab, 720, field.make(&slab), Isothermal::new(5.0).unwrap()).unwrap();
        let mut simulation = Simulation::builder(scene)
            .start(Theory)
            .moves(LocalMoves::new(displacement).unwrap())
            .seed(5)
            .build()
            .unwrap();
        simulation.equilibrate(100, &mut Invariants::default()).unwrap();
    }
}

#[test]
fn what_was_seen_can_be_gone_on_from() {
    let slab = Slab::new(30.0, 4.0, 3.5).unwrap();
    let scene =
        || Scene::new(slab, 90, FieldCase::Uniform(1.0).make(&slab), Isothermal::new(3.0).unwrap()).unwrap();
    let builder = Simulation::builder(scene()).start(ClosePacked).seed(2);
    let mut simulation = builder.moves(LocalMoves::new(0.75).unwrap()).build().unwrap();
    simulation.run(200, &mut ()).unwrap();
    let positions = simulation.positions();
    let start = gradient_mc::start::Positions(positions.clone());
    let continued = Simulation::builder(scene()).start(start).seed(3).build().unwrap();
    assert_eq!(continued.positions(), positions);
}
