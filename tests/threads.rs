//! The result of a sweep does not depend on the number of threads.
//!
//! Without the feature `rayon` there is always one thread. The digest of the positions is the same
//! for all numbers of threads, with and without the feature.

#![allow(clippy::unwrap_used)]

use gradient_mc::field::UniformField;
use gradient_mc::moves::{EventChains, LocalMoves};
use gradient_mc::observers::{Bins, ChainPressureProfile};
use gradient_mc::start::RandomInsertion;
use gradient_mc::temperature::Isothermal;
use gradient_mc::{
    AcceptedMove, Error, Frame, MoveCounts, Observer, ObserverError, Recorder, Scene, Simulation, Slab,
    Vector3,
};

/// Adds up what single moves report, in their order.
#[derive(Debug, Default, PartialEq)]
struct Moves {
    count: u64,
    digest: u64,
}

impl Recorder for Moves {
    fn record_move(&mut self, accepted: &AcceptedMove) {
        self.count += 1;
        for value in [accepted.from_height, accepted.displacement.y] {
            self.digest = (self.digest ^ value.to_bits()).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

impl Observer for Moves {
    fn observe(&mut self, _: &Frame<'_>) -> Result<(), ObserverError> {
        Ok(())
    }
    fn recorder(&mut self) -> Option<&mut dyn Recorder> {
        Some(self)
    }
}

/// A column of several slabs, or a wide one of many tiles too.
///
/// S is tuned if none is given.
fn run(threads: usize, extents: [f64; 3], moves: &[f64]) -> (Vec<Vector3<f64>>, Moves, MoveCounts) {
    let slab = Slab::new(extents[0], extents[1], extents[2]).unwrap();
    let particles = 12_000;
    let scene =
        Scene::new(slab, particles, UniformField::new(0.05).unwrap(), Isothermal::new(2.0).unwrap()).unwrap();
    let moves = if moves.is_empty() { LocalMoves::tuned() } else { LocalMoves::mixture(moves).unwrap() };
    let builder = Simulation::builder(scene).start(RandomInsertion::new(0.2).unwrap()).moves(moves).seed(9);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let mut simulation = builder.build()?;
        let mut moves = Moves::default();
        simulation.equilibrate(10, &mut moves)?;
        simulation.run(10, &mut ())?;
        Ok::<_, Error>((simulation.positions(), moves, *simulation.move_counts()))
    })
    .unwrap()
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    for (extents, moves) in
        [([250.0, 16.0, 16.0], &[0.3][..]), ([70.0, 60.0, 50.0], &[0.1, 0.4]), ([250.0, 16.0, 16.0], &[])]
    {
        let expected = run(1, extents, moves);
        assert_eq!(expected.2.trials, 20 * 12_000);
        assert!(expected.1.count > 10_000 && expected.1.count < expected.2.accepted);
        for threads in [2, 3] {
            let found = run(threads, extents, moves);
            assert!(found == expected, "{threads} threads");
        }
    }
}

#[test]
fn the_bits_are_those_of_the_serial_program() {
    // Written down from a run without the feature `rayon`.
    for (moves, expected) in [(&[0.3][..], 10_688_306_100_750_185_840), (&[], 18_157_823_412_695_333_238)] {
        let (positions, ..) = run(3, [250.0, 16.0, 16.0], moves);
        let digest = positions.iter().flat_map(|position| position.iter()).fold(0_u64, |digest, value| {
            (digest ^ value.to_bits()).wrapping_mul(0x0100_0000_01b3).rotate_left(5)
        });
        assert_eq!(digest, expected, "{moves:?}");
    }
}

/// A base of four tiles, with chains alone and with local moves in between.
fn run_chains(threads: usize, local: bool) -> (Vec<Vector3<f64>>, MoveCounts, ChainPressureProfile) {
    let slab = Slab::new(40.0, 150.0, 150.0).unwrap();
    let scene = Scene::new(slab, 135_000, UniformField::default(), Isothermal::new(6.0).unwrap()).unwrap();
    let chains = EventChains::default().local_moves(local.then(|| LocalMoves::new(0.5).unwrap()));
    let builder = Simulation::builder(scene).moves(chains).seed(9);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let mut pressure = ChainPressureProfile::new(&slab, Bins::count(10))?;
        let mut simulation = builder.build()?;
        simulation.equilibrate(2, &mut ())?;
        simulation.run(2, &mut ())?;
        simulation.run(20, &mut pressure)?;
        Ok::<_, Error>((simulation.positions(), *simulation.move_counts(), pressure))
    })
    .unwrap()
}

#[test]
fn chains_in_tiles_give_the_same_bits() {
    for local in [false, true] {
        let (positions, move_counts, pressure) = run_chains(1, local);
        assert!(move_counts.chains > 1000 && move_counts.events > 1_000_000);
        // Without the feature `rayon` the number of threads does not matter.
        for threads in 2..=if cfg!(feature = "rayon") { 3 } else { 2 } {
            let found = run_chains(threads, local);
            assert!(found.0 == positions && found.1 == move_counts, "{threads} threads");
            assert_eq!(format!("{:?}", found.2), format!("{pressure:?}"));
        }
        if local {
            continue;
        }
        let digest = positions.iter().flat_map(|position| position.iter()).fold(0_u64, |digest, value| {
            (digest ^ value.to_bits()).wrapping_mul(0x0100_0000_01b3).rotate_left(5)
        });
        // Written down from a run without the feature `rayon`.
        assert_eq!(digest, 12_163_286_396_385_350_568);
        no_overlaps(positions, [40.0, 150.0, 150.0]);
    }
}

#[test]
fn a_large_system_keeps_what_no_move_may_break() {
    let extents = [70.0, 60.0, 50.0];
    let (positions, ..) = run(2, extents, &[0.5]);
    no_overlaps(positions, extents);
}

fn no_overlaps(positions: Vec<Vector3<f64>>, extents: [f64; 3]) {
    // Sorted by height, only pairs that are near in height need a look.
    let mut sorted: Vec<[f64; 3]> = positions.into_iter().map(Into::into).collect();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let image = |distance: f64, width: f64| distance.abs().min(width - distance.abs());
    for (index, a) in sorted.iter().enumerate() {
        assert!(a[0] >= 0.5 && a[0] <= extents[0] - 0.5);
        assert!(a[1] >= 0.0 && a[1] < extents[1] && a[2] >= 0.0 && a[2] < extents[2]);
        for b in sorted[index + 1..].iter().take_while(|b| b[0] - a[0] < 1.0) {
            let [x, y, z] = [b[0] - a[0], image(b[1] - a[1], extents[1]), image(b[2] - a[2], extents[2])];
            assert!(x * x + y * y + z * z >= 1.0 - 1e-14, "{a:?} and {b:?}");
        }
    }
}
