//! Reads arbitrary bytes as a checkpoint, and continues from it if it is valid. The fuzz target
//! `checkpoint` supplies the bytes.

#![allow(clippy::unwrap_used)]

use gradient_mc::checkpoint::Snapshot;
use gradient_mc::field::UniformField;
use gradient_mc::moves::{EventChains, LocalMoves};
use gradient_mc::observers::{Bins, CenterOfMass, ChainPressureProfile, DensityProfile};
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Error, Every, Scene, Simulation, SimulationBuilder, Slab};

type Observed = (Every<DensityProfile>, CenterOfMass, ChainPressureProfile);

/// A column that is made in microseconds, with much that can be wrong in it.
pub fn small() -> (SimulationBuilder<UniformField, Isothermal>, Observed) {
    let slab = Slab::new(8.0, 3.0, 3.0).unwrap();
    let scene = Scene::new(slab, 10, UniformField::default(), Isothermal::new(3.0).unwrap()).unwrap();
    let moves = EventChains::default().local_moves(Some(LocalMoves::tuned()));
    let density = DensityProfile::new(&slab, Bins::count(3)).unwrap();
    let pressure = ChainPressureProfile::new(&slab, Bins::count(2)).unwrap();
    (Simulation::builder(scene).moves(moves).seed(1), (Every::new(2, density), CenterOfMass::new(), pressure))
}

/// Once as they are, and once as if their length and checksum were right, so that all else has to
/// be checked by itself. How often they were taken for a run.
pub fn read(bytes: &[u8]) -> usize {
    let mut sealed = bytes.to_vec();
    if sealed.len() >= 24 {
        sealed[..8].copy_from_slice(b"gmc-ckpt");
        sealed[8..12].copy_from_slice(&1_u32.to_le_bytes());
        let length = (sealed.len() - 24) as u64;
        sealed[16..24].copy_from_slice(&length.to_le_bytes());
        let checksum = crc32fast::hash(&sealed[16..]).to_le_bytes();
        sealed[12..16].copy_from_slice(&checksum);
    }
    [bytes, &sealed].into_iter().filter(|bytes| is_run(bytes)).count()
}

fn is_run(bytes: &[u8]) -> bool {
    let snapshot = match Snapshot::from_bytes(bytes) {
        Ok(snapshot) => snapshot,
        Err(Error::CheckpointDamaged { .. } | Error::CheckpointVersion { .. }) => return false,
        Err(error) => panic!("{error}"),
    };
    assert!(snapshot.to_bytes() == bytes);
    let (builder, mut observer) = small();
    match builder.resume(&snapshot, &mut observer) {
        // Numbers that are as good as others: it goes on, or says why not.
        Ok(mut simulation) => {
            let (estimate, points) = (observer.1.estimate(), observer.0.observer.points());
            assert!(estimate.is_ok() || points.is_ok() || observer.1.sweeps().len() < 64);
            if let Err(error) = simulation.run(2, &mut observer) {
                assert!(!error.to_string().is_empty());
            }
            true
        }
        Err(Error::CheckpointDamaged { .. } | Error::CheckpointMismatch { .. }) => false,
        Err(error) => panic!("{error}"),
    }
}
