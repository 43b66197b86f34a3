//! Readers of frames of trajectories, on any bytes: `cargo +nightly fuzz run frame
//! fuzz/corpus/frame tests/corpus/frame -- -runs=1000000 -max_len=8192 -malloc_limit_mb=1`.
//!
//! The first folder takes what is found. Memory is at most ten times the input and 100 kB, less
//! than a megabyte here.

#![no_main]

use gradient_mc::field::UniformField;
use gradient_mc::start::{Start as _, TrajectoryFrame};
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Generator, Scene, Slab};
use libfuzzer_sys::fuzz_target;
use std::io::Cursor;
use std::sync::LazyLock;

static SCENE: LazyLock<Scene<UniformField, Isothermal>> = LazyLock::new(|| {
    let slab = Slab::new(6.0, 3.0, 3.5).unwrap();
    Scene::new(slab, 2, UniformField::default(), Isothermal::new(2.0).unwrap()).unwrap()
});

fuzz_target!(|bytes: &[u8]| {
    for number in [None, Some(0), Some(1)] {
        match TrajectoryFrame::read(Cursor::new(bytes), number) {
            Ok(frame) => {
                assert!(frame.positions().iter().flatten().all(|coordinate| coordinate.is_finite()));
                let mut generator = Generator::new(1);
                let placed = frame.place(&SCENE.as_any(), &mut generator);
                assert!(
                    placed.is_err() || placed.is_ok_and(|placed| placed.len() == frame.positions().len())
                );
            }
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }
});
