//! A run continued from a file has the same bits as an uninterrupted run.

use gradient_mc::checkpoint::{Persist, Snapshot};
use gradient_mc::drive::{
    AveragedThenFrozen, EquationOfStateClosure, Instantaneous, RunningAverage, Scheme, SelfConsistent,
};
use gradient_mc::field::{ExponentialField, UniformField};
use gradient_mc::moves::{EventChains, FieldEvent, LocalMoves, Moves};
use gradient_mc::observers::{
    BalancedDensityProfile, Bins, CenterOfMass, ChainPressureProfile, DensityProfile, DisplacementProfile,
    EquationOfStateFit, EquationOfStateProfile, ExtendedXyz, Gsd, HexaticOrder, NeighborAngles,
    PressureProfile, RadialDistribution, StructureProfile, WallPressure,
};
use gradient_mc::start::{ClosePacked, RandomInsertion};
use gradient_mc::temperature::{ExponentialTemperature, Isothermal};
use gradient_mc::{
    Every, Field, Observer, Scene, Simulation, SimulationBuilder, Slab, TemperatureProfile, Vector3,
};
use std::fs::{self, File};
use std::path::Path;
use tempfile::tempdir;

/// Every ready observer, some of them in the middle of an interval whenever a run is stopped.
type All = (
    (DensityProfile, PressureProfile, EquationOfStateProfile, Every<ChainPressureProfile>),
    (Every<DisplacementProfile>, CenterOfMass, Option<HexaticOrder>),
    Box<(Every<StructureProfile>, EquationOfStateFit, WallPressure, BalancedDensityProfile)>,
    Every<(NeighborAngles, RadialDistribution)>,
    Every<(Gsd, ExtendedXyz<File>)>,
);

/// Trajectories are written to `folder`, or go on there.
fn all<F: Field, T: TemperatureProfile>(scene: &Scene<F, T>, folder: &Path) -> All {
    let slab = scene.slab();
    let bins = Bins::count(12);
    (
        (
            DensityProfile::new(slab, bins).unwrap(),
            PressureProfile::new(slab, bins).unwrap(),
            EquationOfStateProfile::new(slab, bins).unwrap(),
            Every::new(7, ChainPressureProfile::new(slab, bins).unwrap()),
        ),
        (
            Every::new(5, DisplacementProfile::new(slab, bins).unwrap()),
            CenterOfMass::new(),
            Some(HexaticOrder::new(slab, 0.5, 1.5, 1.5).unwrap()),
        ),
        Box::new((
            Every::new(4, StructureProfile::new(slab, bins).unwrap()),
            EquationOfStateFit::new(scene).unwrap(),
            WallPressure::new(scene).unwrap(),
            BalancedDensityProfile::new(slab, bins).unwrap(),
        )),
        Every::new(
            3,
            (
                NeighborAngles::new(slab, 0.5, 1.5, 12).unwrap(),
                RadialDistribution::new(slab, 0.5, 1.5, 12).unwrap(),
            ),
        ),
        Every::new(
            6,
            (
                Gsd::open(folder.join("column.gsd")).unwrap(),
                ExtendedXyz::new(
                    File::options().create(true).append(true).open(folder.join("column.xyz")).unwrap(),
                ),
            ),
        ),
    )
}

/// What trajectories have become.
fn written(folder: &Path) -> [Option<Vec<u8>>; 2] {
    ["column.gsd", "column.xyz"].map(|name| fs::read(folder.join(name)).ok())
}

/// What a run has become: everything that it keeps, and what can be asked of it.
#[derive(PartialEq, Debug)]
struct Fate {
    snapshot: Snapshot,
    positions: Vec<Vector3<f64>>,
    warnings: String,
}

fn fate<F: Field, T: TemperatureProfile, S, O>(simulation: &mut Simulation<F, T, S>, observer: &mut O) -> Fate
where
    S: Scheme<F, T, Drive: Persist, Adaptation: Persist>,
    O: Persist,
{
    Fate {
        snapshot: simulation.snapshot(observer).unwrap(),
        positions: simulation.positions(),
        warnings: format!("{:?}, {:?}", simulation.warnings(), simulation.certificate(0.05).ok()),
    }
}

/// Sweeps up to the `sweep`th; production begins after `equilibration`.
fn advance<F: Field, T: TemperatureProfile, S: Scheme<F, T>, O: Observer>(
    simulation: &mut Simulation<F, T, S>,
    observer: &mut O,
    equilibration: u64,
    sweep: u64,
) {
    let wanted = sweep.min(equilibration);
    if simulation.sweep() < wanted {
        simulation.equilibrate(wanted - simulation.sweep(), observer).unwrap();
    }
    if simulation.sweep() < sweep {
        simulation.run(sweep - simulation.sweep(), observer).unwrap();
    }
}

/// Stops runs, each at some sweeps, goes on from the bytes of a file, and compares with a run that
/// was not stopped.
fn require_same<F: Field + Clone, T: TemperatureProfile + Clone, S, O>(
    what: &str,
    builder: &SimulationBuilder<F, T, S>,
    observer: impl Fn(&Path) -> O,
    equilibration: u64,
    all_stops: &[&[u64]],
    sweeps: u64,
) where
    S: Scheme<F, T, Drive: Persist, Adaptation: Persist> + Clone,
    O: Observer + Persist,
{
    let folder = tempdir().unwrap();
    let mut undisturbed = builder.clone().build().unwrap();
    let mut observed = observer(folder.path());
    advance(&mut undisturbed, &mut observed, equilibration, sweeps);
    let expected = fate(&mut undisturbed, &mut observed);

    for stops in all_stops {
        let stopped = tempdir().unwrap();
        let mut seen = observer(stopped.path());
        let mut simulation = builder.clone().build().unwrap();
        for &stop in *stops {
            advance(&mut simulation, &mut seen, equilibration, stop);
            let bytes = simulation.snapshot(&mut seen).unwrap().to_bytes();
            let snapshot = Snapshot::from_bytes(&bytes).unwrap();
            assert_eq!(snapshot.sweep(), stop);
            let positions = simulation.positions();
            // As a process does that is killed after its checkpoint.
            advance(&mut simulation, &mut seen, equilibration, stop + 250);
            seen = observer(stopped.path());
            simulation = builder.clone().resume(&snapshot, &mut seen).unwrap();
            assert_eq!(simulation.positions(), positions);
            let again = simulation.snapshot(&mut seen).unwrap().to_bytes();
            assert!(again == bytes, "{what}: what was read at {stop}");
        }
        advance(&mut simulation, &mut seen, equilibration, sweeps);
        assert!(fate(&mut simulation, &mut seen) == expected, "{what}, stopped at {stops:?}");
        assert!(written(stopped.path()) == written(folder.path()), "{what}, stopped at {stops:?}");
    }
}

/// Around the sweeps at which something happens: the first, the sorting, and steps of adaptations;
/// twice in a row.
const STOPS: [&[u64]; 4] = [&[0, 1], &[37, 38, 700], &[999, 1000], &[1001, 1303, 1999]];

#[test]
fn every_family_of_moves() {
    let slab = Slab::new(40.0, 5.0, 5.0).unwrap();
    let scene =
        Scene::new(slab, 150, ExponentialField::new(0.01).unwrap(), Isothermal::new(4.0).unwrap()).unwrap();
    let moves: [(&str, Moves); 7] = [
        ("one size", LocalMoves::new(0.4).unwrap().into()),
        ("mixture", LocalMoves::mixture(&[0.2, 1.0]).unwrap().into()),
        ("tuned", LocalMoves::tuned().into()),
        ("default", Moves::default()),
        ("chains", EventChains::default().local_moves(None).into()),
        ("chains of one length", EventChains::with_length(3.0).unwrap().into()),
        ("chains that turn", EventChains::default().field_event(FieldEvent::Reverse).into()),
    ];
    for (what, moves) in moves {
        let builder = Simulation::builder(scene).moves(moves).seed(3);
        require_same(what, &builder, |folder| all(&scene, folder), 1200, &STOPS, 2100);
    }
}

#[test]
fn every_scheme() {
    fn scheme<S>(what: &str, scheme: S)
    where
        S: Scheme<UniformField, ExponentialTemperature, Drive: Persist, Adaptation: Persist> + Clone,
    {
        let slab = Slab::new(40.0, 5.0, 5.0).unwrap();
        let temperature = ExponentialTemperature::new(5.0, 0.02).unwrap();
        let scene = Scene::new(slab, 120, UniformField::default(), temperature).unwrap();
        let builder = Simulation::builder(scene).scheme(scheme).start(RandomInsertion::default()).seed(4);
        require_same(what, &builder, |folder| all(&scene, folder), 1200, &STOPS, 2100);
    }
    scheme("automatic", gradient_mc::drive::Automatic);
    scheme("self-consistent", SelfConsistent::default().closure_weight(1.0).unwrap());
    scheme("closure", EquationOfStateClosure::default());
    scheme("running average", RunningAverage::default());
    scheme("averaged, then frozen", AveragedThenFrozen::default());
    scheme("instantaneous", Instantaneous::default());
}

#[test]
fn a_second_equilibration() {
    let slab = Slab::new(40.0, 5.0, 5.0).unwrap();
    let temperature = ExponentialTemperature::new(5.0, 0.02).unwrap();
    let scene = Scene::new(slab, 120, UniformField::default(), temperature).unwrap();
    let builder = Simulation::builder(scene).seed(4);
    let run = |stops: bool| {
        let mut simulation = builder.clone().build().unwrap();
        for part in 0..6 {
            if part % 2 == 0 {
                simulation.equilibrate(150, &mut ()).unwrap();
            } else {
                simulation.run(350, &mut ()).unwrap();
            }
            if stops {
                let snapshot = simulation.snapshot(&mut ()).unwrap();
                simulation = builder.clone().resume(&snapshot, &mut ()).unwrap();
            }
        }
        fate(&mut simulation, &mut ())
    };
    assert!(run(true) == run(false));
}

#[test]
fn a_crystal_in_which_chains_touch_several_spheres_at_once() {
    let slab = Slab::new(12.0, 5.0, 5.0).unwrap();
    let scene = Scene::new(slab, 220, UniformField::default(), Isothermal::new(1.0).unwrap()).unwrap();
    for moves in [EventChains::default().local_moves(None), EventChains::default()] {
        let builder = Simulation::builder(scene).start(ClosePacked).moves(moves).seed(5);
        require_same("crystal", &builder, |_| CenterOfMass::new(), 60, &[&[0], &[1, 2, 3], &[50]], 120);
    }
}

/// Several domains for local moves, and several tiles for chains, on one thread and on two.
#[test]
fn large_systems_on_any_number_of_threads() {
    let run = |extents: [f64; 3], particles: usize, moves: Moves, stop: Option<u64>, threads: [usize; 2]| {
        let slab = Slab::new(extents[0], extents[1], extents[2]).unwrap();
        let scene =
            Scene::new(slab, particles, UniformField::default(), Isothermal::new(6.0).unwrap()).unwrap();
        let builder = Simulation::builder(scene).moves(moves).seed(9);
        let [before, after] =
            threads.map(|threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap());
        let mut observer = ChainPressureProfile::new(&slab, Bins::count(10)).unwrap();
        let mut simulation = builder.clone().build().unwrap();
        if let Some(stop) = stop {
            before.install(|| advance(&mut simulation, &mut observer, 4, stop));
            let bytes = simulation.snapshot(&mut observer).unwrap().to_bytes();
            let snapshot = Snapshot::from_bytes(&bytes).unwrap();
            observer = ChainPressureProfile::new(&slab, Bins::count(10)).unwrap();
            simulation = builder.resume(&snapshot, &mut observer).unwrap();
        }
        after.install(|| advance(&mut simulation, &mut observer, 4, 8));
        fate(&mut simulation, &mut observer)
    };
    for (extents, particles, moves) in [
        ([250.0, 16.0, 16.0], 12_000, LocalMoves::tuned().into()),
        ([40.0, 150.0, 150.0], 135_000, Moves::default()),
    ] {
        let expected = run(extents, particles, moves, None, [1, 1]);
        for (stop, threads) in [(3, [1, 2]), (6, [2, 1])] {
            assert!(run(extents, particles, moves, Some(stop), threads) == expected, "{moves:?} {stop}");
        }
    }
}

/// What .ci/run compares between builds with and without the feature `rayon`.
#[test]
#[ignore = "prints what another build has to print too"]
fn checksums() {
    for (extents, particles, moves) in [
        ([250.0, 16.0, 16.0], 12_000, LocalMoves::tuned().into()),
        ([40.0, 150.0, 150.0], 135_000, Moves::default()),
    ] {
        let slab = Slab::new(extents[0], extents[1], extents[2]).unwrap();
        let scene =
            Scene::new(slab, particles, UniformField::default(), Isothermal::new(6.0).unwrap()).unwrap();
        let folder = tempdir().unwrap();
        let mut observer = all(&scene, folder.path());
        let mut simulation = Simulation::builder(scene).moves(moves).seed(9).build().unwrap();
        advance(&mut simulation, &mut observer, 4, 8);
        let bytes = simulation.snapshot(&mut observer).unwrap().to_bytes();
        println!("checksum {:08x} of {} bytes", crc32fast::hash(&bytes), bytes.len());
    }
}
