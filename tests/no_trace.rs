//! An isothermal scene has no cost of the feedback: no table, no allocation in a sweep, and φ/T
//! with the same bits. (`cargo bench --bench throughput` compares its time with a drive specialized
//! by hand.) A nearly empty slab needs memory only for its spheres, and a trajectory only for its
//! content.

#![allow(clippy::unwrap_used)]

use allocation_counter::measure;
use gradient_mc::drive::{Automatic, Drive, Scheme, SelfConsistent};
use gradient_mc::field::{ExponentialField, UniformField};
use gradient_mc::moves::{LocalMoves, Moves};
use gradient_mc::start::{ClosePacked, Positions, Start, Theory, TrajectoryFrame};
use gradient_mc::temperature::{ExponentialTemperature, Isothermal};
use gradient_mc::{Field, Generator, Scene, Simulation, Slab, TemperatureProfile};
use rand::SeedableRng;
use std::io::Cursor;

fn scene<T: TemperatureProfile>(temperature: T) -> Scene<UniformField, T> {
    let slab = Slab::new(60.0, 5.0, 5.0).unwrap();
    Scene::new(slab, 200, UniformField::default(), temperature).unwrap()
}

fn isothermal() -> Scene<UniformField, Isothermal> {
    scene(Isothermal::new(4.0).unwrap())
}

#[test]
fn the_isothermal_drive_is_a_tag_and_a_pointer() {
    type Drive<T> = <Automatic as Scheme<UniformField, T>>::Drive;
    assert!(size_of::<Drive<Isothermal>>() <= 2 * size_of::<usize>());
    assert_eq!(size_of::<Isothermal>(), size_of::<f64>());
    assert_eq!(size_of::<UniformField>(), size_of::<f64>());
}

#[test]
fn the_isothermal_drive_is_made_without_an_allocation() {
    let scene = isothermal();
    assert_eq!(measure(|| drop(Automatic.drive(&scene).unwrap())).count_total, 0);
    // The counter counts: a temperature that varies has a table.
    let varying = crate::scene(ExponentialTemperature::new(4.0, 0.02).unwrap());
    assert!(measure(|| drop(Automatic.drive(&varying).unwrap())).count_total > 0);
}

/// The drive of a scene at T = 3.7 against φ/T, at many heights.
fn check<T: TemperatureProfile>(scene: &Scene<ExponentialField, T>) {
    let (field, (drive, _)) = (scene.field(), Automatic.drive(scene).unwrap());
    for step in 0..6000 {
        let height = f64::from(step) * 0.01;
        let potential = drive.reduced_potential(scene, height);
        assert_eq!(potential.to_bits(), (field.potential(height) / 3.7).to_bits());
        let force = drive.reduced_force(scene, height);
        assert_eq!(force.to_bits(), (field.acceleration(height) / 3.7).to_bits());
    }
}

#[test]
fn the_isothermal_potential_is_the_closed_form_to_the_bit() {
    let slab = Slab::new(60.0, 5.0, 5.0).unwrap();
    let field = ExponentialField::new(0.03).unwrap();
    let known = Isothermal::new(3.7).unwrap();
    // It only turns out to be constant.
    let found = ExponentialTemperature::new(3.7, 0.0).unwrap();
    let chosen: Box<dyn TemperatureProfile> = Box::new(known);
    check(&Scene::new(slab, 200, field, known).unwrap());
    check(&Scene::new(slab, 200, field, found).unwrap());
    check(&Scene::new(slab, 200, field, chosen).unwrap());
}

/// Allocations of 200 sweeps of production, after 2200 in which everything grows as large as it
/// will.
fn allocations_of_production(moves: impl Into<Moves>) -> u64 {
    let mut simulation = Simulation::builder(isothermal()).moves(moves).seed(1).build().unwrap();
    simulation.equilibrate(2000, &mut ()).unwrap();
    simulation.run(200, &mut ()).unwrap();
    measure(|| simulation.run(200, &mut ()).unwrap()).count_total
}

#[test]
fn isothermal_sweeps_allocate_nothing() {
    // The cell list makes a page at most for each sphere at first; then it reuses them.
    assert_eq!(allocations_of_production(LocalMoves::new(0.75).unwrap()), 0);
    // Sizes that were tuned are as cheap as others once they are fixed, and so are chains.
    assert_eq!(allocations_of_production(LocalMoves::tuned()), 0);
    assert_eq!(allocations_of_production(Moves::default()), 0);

    // The counter counts: a drive that adapts does allocate.
    let moves = LocalMoves::new(0.75).unwrap();
    let scene = scene(ExponentialTemperature::new(4.0, 0.02).unwrap());
    let mut simulation = Simulation::builder(scene).moves(moves).seed(1).build().unwrap();
    simulation.equilibrate(2000, &mut ()).unwrap();
    assert!(measure(|| simulation.equilibrate(200, &mut ()).unwrap()).count_total > 0);
}

#[test]
fn an_isothermal_simulation_is_made_with_nothing_for_the_feedback() {
    /// φ/T by hand, which surely has nothing.
    struct ByHand;
    impl<F: Field> Drive<F, Isothermal> for ByHand {
        fn reduced_potential(&self, scene: &Scene<F, Isothermal>, height: f64) -> f64 {
            scene.field().potential(height) / scene.temperature().temperature(height)
        }
    }
    impl<F: Field> Scheme<F, Isothermal> for ByHand {
        type Drive = Self;
        type Adaptation = ();
        fn drive(self, _: &Scene<F, Isothermal>) -> Result<(Self, ()), gradient_mc::Error> {
            Ok((self, ()))
        }
    }
    let start = Simulation::builder(isothermal()).start(Theory).build().unwrap().positions();
    let builder = || Simulation::builder(isothermal()).start(Positions(start.clone()));
    let automatic = measure(|| drop(builder().build().unwrap()));
    let by_hand = measure(|| drop(builder().scheme(ByHand).build().unwrap()));
    assert_eq!(automatic.count_total, by_hand.count_total);
    assert_eq!(automatic.bytes_total, by_hand.bytes_total);
    // One that has the machinery has more.
    let self_consistent = measure(|| drop(builder().scheme(SelfConsistent::default()).build().unwrap()));
    assert!(self_consistent.count_total > by_hand.count_total);
}

/// What a start takes is in proportion to the number of spheres, not to the volume of the slab.
#[test]
fn few_spheres_in_a_wide_slab_take_little_memory() {
    let slab = Slab::new(2.0, 1e4, 1e4).unwrap();
    for spheres in [1, 1000] {
        let scene = Scene::new(slab, spheres, UniformField::default(), Isothermal::new(1.0).unwrap());
        let scene = scene.unwrap();
        let mut generator = Generator::seed_from_u64(1);
        let counted = [
            measure(|| {
                assert_eq!(ClosePacked.place(&scene.as_any(), &mut generator).unwrap().len(), spheres);
            }),
            measure(|| {
                let generator = &mut Generator::seed_from_u64(1);
                assert_eq!(Theory.place(&scene.as_any(), generator).unwrap().len(), spheres);
            }),
        ];
        for counted in counted {
            assert!(counted.bytes_max < 4_000_000, "{} bytes for {spheres} spheres", counted.bytes_max);
        }
    }
}

/// Whatever a file claims to hold.
#[test]
fn a_small_file_that_claims_to_be_large_takes_little_memory() {
    const FEW: u64 = 110_000;
    let refused = |bytes: &[u8]| {
        let read = measure(|| assert!(TrajectoryFrame::read(Cursor::new(bytes), None).is_err()));
        assert!(read.bytes_max < FEW, "{} bytes", read.bytes_max);
    };
    refused(b"4000000000\nLattice=\"6 0 0 0 3 0 0 0 3\"\nX 1 1 1\n");
    refused(&vec![b'1'; 10 << 20]);
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/corpus/frame/compact.gsd");
    let bytes = std::fs::read(path).unwrap();
    let whole = measure(|| assert!(TrajectoryFrame::read(Cursor::new(&bytes), None).is_ok()));
    assert!(whole.bytes_max < FEW, "{} bytes", whole.bytes_max);
    // Entries of the index, pieces of the list of names, and rows of the first frame's chunks.
    for place in [16, 32].into_iter().chain((0..10).map(|entry| 256 + 32 * entry + 8)) {
        for claimed in [1 << 24, u64::MAX / 32, u64::MAX] {
            let mut changed = bytes.clone();
            changed[place..place + 8].copy_from_slice(&claimed.to_le_bytes());
            let read = measure(|| drop(TrajectoryFrame::read(Cursor::new(&changed), Some(0))));
            assert!(read.bytes_max < FEW, "{} bytes", read.bytes_max);
        }
    }
}
