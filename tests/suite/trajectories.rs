//! Trajectories: written files read back with the same bits, and invalid files give an error with
//! its position.

use gradient_mc::field::UniformField;
use gradient_mc::observers::{BondOrder, ExtendedXyz, Gsd, HexaticOrder, RadialDistribution};
use gradient_mc::start::{Positions, RandomInsertion, TrajectoryError, TrajectoryFrame};
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Error, Every, Observer as _, Scene, Simulation, Slab, Vector3};
use proptest::prelude::*;
use std::fs;
use std::io::{Cursor, Write as _};
use std::path::PathBuf;
use tempfile::tempdir;

type Column = Scene<UniformField, Isothermal>;

fn column(extents: [f64; 3], particles: usize) -> Column {
    let slab = Slab::new(extents[0], extents[1], extents[2]).unwrap();
    Scene::new(slab, particles, UniformField::default(), Isothermal::new(2.0).unwrap()).unwrap()
}

/// Bytes of both formats, with a frame after each of some sweeps.
fn written(scene: Column, frames: u64) -> [Vec<u8>; 2] {
    let folder = tempdir().unwrap();
    let path = folder.path().join("column.gsd");
    let mut trajectory = (ExtendedXyz::new(Vec::new()), Gsd::open(&path).unwrap());
    let start = RandomInsertion::new(0.3).unwrap();
    let mut simulation = Simulation::builder(scene).start(start).seed(1).build().unwrap();
    simulation.run(frames, &mut trajectory).unwrap();
    assert_eq!(trajectory.1.frames(), frames);
    [trajectory.0.into_inner(), fs::read(&path).unwrap()]
}

fn small() -> [Vec<u8>; 2] {
    written(column([6.0, 3.0, 3.5], 5), 2)
}

fn read(bytes: &[u8], number: Option<u64>) -> Result<TrajectoryFrame, TrajectoryError> {
    TrajectoryFrame::read(Cursor::new(bytes), number)
}

#[test]
fn a_run_starts_from_any_frame_with_the_same_bits() {
    let folder = tempdir().unwrap();
    // Dense, with spheres in contact after every chain; the index of 100 frames was doubled twice.
    let scene = column([12.0, 5.0, 4.0 + 1.0 / 3.0], 220);
    let paths = ["column.xyz", "column.gsd"].map(|name| folder.path().join(name));
    let text = fs::File::create(&paths[0]).unwrap();
    let mut trajectory = Every::new(3, (ExtendedXyz::new(text), Gsd::open(&paths[1]).unwrap()));
    let mut simulation = Simulation::builder(scene).seed(1).build().unwrap();
    let mut seen = Vec::new();
    for _ in 0..100 {
        simulation.run(3, &mut trajectory).unwrap();
        seen.push(simulation.positions());
    }
    for path in &paths {
        for number in [0, 1, 39, 40, 41, 82, 83, 98, 99] {
            let frame = TrajectoryFrame::nth(path, number).unwrap();
            assert_eq!(frame.sweep(), Some(3 * number + 3));
            assert_eq!(frame.positions(), seen[usize::try_from(number).unwrap()]);
        }
        let last = TrajectoryFrame::last(path).unwrap();
        assert_eq!(last, TrajectoryFrame::nth(path, 99).unwrap());
        let again = Simulation::builder(scene).start(last).seed(2).build().unwrap();
        assert_eq!(again.positions(), simulation.positions());
        let beyond = TrajectoryFrame::nth(path, 100).unwrap_err();
        let TrajectoryError::File { path: named, source, .. } = &beyond else { panic!("{beyond}") };
        assert!(named == path && beyond.to_string().contains("100 frames"), "{beyond}");
        assert!(matches!(**source, TrajectoryError::NoSuchFrame { number: 100, frames: 100, .. }));
    }
    let absent = TrajectoryFrame::last(folder.path().join("absent.gsd")).unwrap_err();
    assert!(absent.to_string().contains("absent.gsd"), "{absent}");
}

#[test]
fn another_scene_is_refused() {
    for bytes in small() {
        let frame = read(&bytes, None).unwrap();
        for (extents, name) in [
            ([6.000_001, 3.0, 3.5], "height"),
            ([6.0, 3.1, 3.5], "width along y"),
            ([6.0, 3.0, 3.4], "width along z"),
        ] {
            let started = Simulation::builder(column(extents, 5)).start(frame.clone()).build();
            let Err(Error::Trajectory(TrajectoryError::AnotherSlab { what, .. })) = started else {
                panic!("{name}: {started:?}")
            };
            assert_eq!(what, name);
        }
        let started = Simulation::builder(column([6.0, 3.0, 3.5], 6)).start(frame.clone()).build();
        assert!(matches!(started, Err(Error::WrongParticleCount { expected: 6, found: 5, .. })));
        // What the message advises.
        let higher = Simulation::builder(column([7.0, 3.0, 3.5], 5));
        let positions = frame.positions().to_vec();
        assert_eq!(higher.start(Positions(positions.clone())).build().unwrap().positions(), positions);
    }
}

/// An extended XYZ file of two spheres.
fn two(comment: &str, first: &str, second: &str) -> Result<TrajectoryFrame, TrajectoryError> {
    read(format!("2\n{comment}\n{first}\n{second}\n").as_bytes(), None)
}

const COMMENT: &str = r#"Lattice="6 0 0 0 3 0 0 0 3" Properties=species:S:1:pos:R:3"#;

#[test]
fn text_that_others_write_is_read() {
    let expected = [Vector3::new(0.5, 1.0, 1.0), Vector3::new(2.25, 1.5, 1.0)];
    let plain = r#"Lattice="6 0 0 0 3 0 0 0 3""#;
    let more = r#"energy=1 Lattice="6.0 0.0 0.0 0.0 3.0 0.0 0.0 0.0 3.0" note="a = b" flag Properties=id:I:1:pos:R:3:radius:R:1:v:R:3 Origin="0 0 0" pbc="F T T" sweep=7"#;
    for (comment, spheres, sweep) in [
        (COMMENT, ["X 0.5 1 1", "X 2.25 1.5 1"], None),
        (plain, ["Ar  0.5\t1.0 1.0 ", "Ar 225e-2 1.5 1"], None),
        (more, ["1 0.5 1 1 0.5 0 0 0", "2 2.25 1.5 1 0.50 1 2 3"], Some(7)),
    ] {
        let frame = two(comment, spheres[0], spheres[1]).unwrap();
        assert_eq!((frame.positions(), frame.sweep()), (&expected[..], sweep));
        Simulation::builder(column([6.0, 3.0, 3.0], 2)).start(frame).build().unwrap();
    }
    // As on another system, and with empty lines at the end.
    let text = format!("2\r\n{COMMENT}\r\nX 0.5 1 1\r\nX 2.25 1.5 1\r\n\r\n\r\n");
    assert_eq!(read(text.as_bytes(), None).unwrap().positions(), expected);
}

#[test]
fn spheres_that_do_not_fit_are_refused() {
    let build = |first: &str, second: &str| {
        let frame = two(COMMENT, first, second).unwrap();
        Simulation::builder(column([6.0, 3.0, 3.0], 2)).start(frame).build().unwrap_err()
    };
    let overlap = build("X 0.5 1 1", "X 0.5 1 1.999999");
    assert!(matches!(overlap, Error::Overlap { first: 0, second: 1, .. }), "{overlap}");
    for outside in ["X 0.4999999 1 1", "X 5.6 1 1", "X 2 -0.1 1", "X 2 1 3.1"] {
        let error = build("X 2.5 2 2", outside);
        assert!(matches!(error, Error::OutsideSlab { index: 1, .. }), "{outside}: {error}");
    }
}

#[test]
fn text_that_is_wrong_says_in_which_line() {
    let sphere = "X 0.5 1 1";
    for (comment, second, line, what) in [
        (COMMENT, "X NaN 1 1", 4, "NaN"),
        (COMMENT, "X inf 1 1", 4, "inf"),
        (COMMENT, "X 1e999 1 1", 4, "1e999"),
        (COMMENT, "X 1 1", 4, "3 columns instead of 4"),
        (COMMENT, "X 1 1 1 1", 4, "5 columns"),
        (COMMENT, "", 4, "0 columns"),
        ("two spheres", sphere, 2, "no Lattice"),
        (r#"Lattice="6 0 0 0 3 0 0 0""#, sphere, 2, "not a finite number"),
        (r#"Lattice="6 0 0 0 3 0 0 0 3 3""#, sphere, 2, "more than 9"),
        (r#"Lattice="6 0 0 1 3 0 0 0 3""#, sphere, 2, "along the axes"),
        (r#"Lattice="6 0 0 0 3 0 0 0 3" Origin="-3 0 0""#, sphere, 2, "Origin"),
        (r#"Lattice="6 0 0 0 3 0 0 0 3" Properties=species:S:1"#, sphere, 2, "pos:R:3"),
        (r#"Lattice="6 0 0 0 3 0 0 0 3" Properties=species:S:1:pos:R"#, sphere, 2, "name:type:number"),
        (r#"Lattice="6 0 0 0 3 0 0 0 3" Properties=species:S:999:pos:R:3"#, sphere, 2, "999 columns"),
        (r#"Lattice="6 0 0 0 3 0 0 0 3" Properties=pos:R:3:radius:R:1"#, "1 1 1 1", 3, "not a finite number"),
        (r#"Lattice="6 0 0 0 3 0 0 0 3" sweep=-1"#, sphere, 2, "sweep=-1"),
    ] {
        let error = two(comment, sphere, second).unwrap_err();
        let said = error.to_string();
        assert!(
            said.starts_with(&format!("line {line}: ")) && said.contains(what),
            "{comment} {second}: {said}"
        );
    }
    let radius = r#"Lattice="6 0 0 0 3 0 0 0 3" Properties=pos:R:3:radius:R:1"#;
    let error = two(radius, "0.5 1 1 0.5", "2 1 1 1.5").unwrap_err();
    assert!(error.to_string().contains("the radius is 1.5"), "{error}");
    for text in ["two\n", "-2\n", "5000000000\n", "\u{1f34e}\n", "{}\n"] {
        let error = read(text.as_bytes(), None).unwrap_err();
        assert!(error.to_string().starts_with("line 1: a frame must begin"), "{error}");
    }
    assert!(matches!(read(b"", None), Err(TrajectoryError::NoSuchFrame { frames: 0, .. })));
    assert!(matches!(read(b"\xff\xfe\n", None), Err(TrajectoryError::Malformed { .. })));
    // No more is read than a line may have.
    let error = read(&vec![b'1'; 1 << 20], None).unwrap_err();
    assert!(error.to_string().contains("too long"), "{error}");
}

/// A file that ends within a frame says which one is whole; every frame before is read as ever.
#[test]
fn every_truncation_is_found() {
    let [text, binary] = small();
    let whole = read(&text, Some(0)).unwrap();
    let lines: Vec<usize> =
        text.iter().enumerate().filter(|(_, byte)| **byte == b'\n').map(|(end, _)| end + 1).collect();
    let first = lines[lines.len() / 2 - 1];
    for length in 0..text.len() {
        match read(&text[..length], None) {
            Ok(frame) => assert!(length == first && frame == whole, "{length}"),
            Err(TrajectoryError::CutOff { frame, .. }) => {
                assert_eq!(frame, u64::from(length > first), "{length}");
            }
            Err(error) => assert!(
                length == 0 && matches!(error, TrajectoryError::NoSuchFrame { .. }),
                "{length}: {error}"
            ),
        }
        assert_eq!(read(&text[..length], Some(0)).is_ok(), length >= first, "{length}");
    }
    for length in 0..binary.len() {
        assert!(read(&binary[..length], None).is_err(), "{length}");
    }
    let said = read(&text[..text.len() - 1], None).unwrap_err().to_string();
    assert_eq!(said, "frame 1 is cut off: use frame 0, the last complete one, with `TrajectoryFrame::nth`");
}

/// There is no checksum in either format. What a changed byte leaves is numbers, or an error.
#[test]
fn every_changed_byte_is_an_error_or_another_number() {
    for bytes in small() {
        let whole = read(&bytes, None).unwrap();
        let mut changed = bytes.clone();
        let mut refused = 0;
        for index in 0..bytes.len() {
            for mask in [0x01, 0x04, 0x80, 0xff] {
                changed[index] ^= mask;
                match read(&changed, None) {
                    Ok(frame) => {
                        assert!(frame.positions().iter().flatten().all(|coordinate| coordinate.is_finite()));
                    }
                    Err(_) => refused += 1,
                }
                changed[index] ^= mask;
            }
        }
        assert!(refused > bytes.len() / 10, "{refused} of {}", bytes.len());
        assert_eq!(read(&changed, None).unwrap(), whole);
    }
}

/// With something in place of all that is alike.
fn replaced(bytes: &[u8], from: &[u8], to: &[u8]) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    let mut bytes = bytes.to_vec();
    let places: Vec<usize> =
        (0..=bytes.len() - from.len()).filter(|&at| bytes[at..].starts_with(from)).collect();
    assert!(!places.is_empty());
    for place in places {
        bytes[place..place + from.len()].copy_from_slice(to);
    }
    bytes
}

/// GSD of other programs has centers in single precision, from the middle of the box.
#[test]
fn binary_frames_of_others_are_read_as_precisely_as_they_are() {
    let scene = column([30.0, 5.0, 4.1], 40);
    let [_, bytes] = written(scene, 3);
    let exact = read(&bytes, None).unwrap();
    let others = replaced(&bytes, b"log/particles/exact_position", b"log/particles/other_position");
    let frame = read(&others, None).unwrap();
    assert_eq!(frame.sweep(), Some(3));
    let simulation = Simulation::builder(scene).start(frame.clone()).build().unwrap();
    for (exact, rounded) in exact.positions().iter().zip(simulation.positions()) {
        // Half of the last bit of 15.
        assert!((exact - rounded).amax() < 5e-7, "{exact} {rounded}");
    }
    // The walls stand nowhere in such a file, but the slab cannot be longer than the box.
    for (extents, name) in [([32.1, 5.0, 4.1], "height"), ([30.0, 5.0, 4.2], "width along z")] {
        let started = Simulation::builder(column(extents, 40)).start(frame.clone()).build();
        let Err(Error::Trajectory(TrajectoryError::AnotherSlab { what, .. })) = started else {
            panic!("{name}")
        };
        assert_eq!(what, name);
    }
}

#[test]
fn binary_frames_that_are_wrong_say_where() {
    let [_, bytes] = small();
    let long = |number: u64| number.to_le_bytes();
    for (what, changed) in [
        ("particles/N", replaced(&bytes, b"particles/N", b"particles/M")),
        ("configuration/box", replaced(&bytes, b"configuration/box", b"configuration/fox")),
        ("particles/position", replaced(&bytes, b"\0particles/position", b"\0particles/positiom")),
        ("schema", replaced(&bytes, b"hoomd", b"bloom")),
        // The place of the index, and its length.
        ("index", replaced(&bytes, &[long(256), long(128)].concat(), &[long(256), long(u64::MAX)].concat())),
        (
            "index",
            replaced(&bytes, &[long(256), long(128)].concat(), &[long(u64::MAX - 9), long(1)].concat()),
        ),
        // Rows of all chunks of five spheres.
        (
            "there are 6 x 1 numbers",
            replaced(&bytes, &[long(0), long(5)].concat(), &[long(0), long(6)].concat()),
        ),
    ] {
        let error = read(&changed, Some(0)).unwrap_err();
        assert!(error.to_string().contains(what), "{what}: {error}");
    }
    // Whoever changes positions leaves the exact ones behind.
    let frame = read(&bytes, None).unwrap();
    let x = frame.positions()[3].x;
    let changed = replaced(&bytes, &x.to_le_bytes(), &(x + 1e-3).to_le_bytes());
    let error = read(&changed, None).unwrap_err();
    assert!(error.to_string().contains("of sphere 3 differ"), "{error}");
    let changed = replaced(&bytes, &x.to_le_bytes(), &f64::NAN.to_le_bytes());
    assert!(read(&changed, None).is_err());
}

#[test]
fn a_file_that_holds_something_is_not_overwritten() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("column.gsd");
    let scene = column([6.0, 3.0, 3.5], 5);
    let mut simulation = Simulation::builder(scene).build().unwrap();
    let mut trajectory = Gsd::open(&path).unwrap();
    simulation.run(3, &mut trajectory).unwrap();
    let before = fs::read(&path).unwrap();
    let error = simulation.run(1, &mut Gsd::open(&path).unwrap()).unwrap_err();
    assert!(error.to_string().contains("use another file, or remove this one"), "{error}");
    // Nor are frames of another run appended.
    let mut other = Simulation::builder(column([6.0, 3.0, 3.5], 6)).build().unwrap();
    other.run(5, &mut ()).unwrap();
    assert!(trajectory.observe(&other.frame()).is_err());
    assert_eq!(fs::read(&path).unwrap(), before);
    simulation.run(1, &mut trajectory).unwrap();
    assert_eq!(trajectory.frames(), 4);
}

/// What the fuzzer keeps, and some files made by hand.
#[test]
fn the_corpus_of_the_fuzzer_is_read_or_refused() {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/corpus/frame");
    let mut read_or_refused = [0, 0];
    for file in fs::read_dir(folder).unwrap() {
        let bytes = fs::read(file.unwrap().path()).unwrap();
        for number in [None, Some(0), Some(1)] {
            read_or_refused[usize::from(read(&bytes, number).is_err())] += 1;
        }
    }
    assert!(read_or_refused[0] > 0 && read_or_refused[1] > 0, "{read_or_refused:?}");
}

proptest! {
    /// Whatever the numbers, they come back.
    #[test]
    fn any_numbers_come_back(heights in prop::collection::vec(0.5..1e6, 1..9), step in 0.0..1.0_f64) {
        let mut text = Vec::new();
        writeln!(text, "{}\nLattice=\"1e6 0 0 0 3 0 0 0 {}\"", heights.len(), 3.0 + step).unwrap();
        for height in &heights {
            writeln!(text, "X {height} {step} {}", step * step).unwrap();
        }
        let frame = read(&text, None).unwrap();
        let expected: Vec<_> = heights.iter().map(|&height| Vector3::new(height, step, step * step)).collect();
        prop_assert_eq!(frame.positions(), expected);
    }
}

/// Frames in both formats and what observers find in them, for `.ci/read_trajectory`, which has
/// other programs find the same.
#[test]
#[ignore = "writes files for other programs"]
fn for_other_programs() {
    let folder = PathBuf::from(std::env::var("TRAJECTORY_FOLDER").unwrap());
    // Full to the lid, so that whoever looks across the walls finds something.
    let scene = column([12.0, 8.0, 7.5], 660);
    let slab = *scene.slab();
    let mut simulation = Simulation::builder(scene).seed(1).build().unwrap();
    simulation.equilibrate(200, &mut ()).unwrap();
    let mut files = (
        ExtendedXyz::new(fs::File::create(folder.join("box.xyz")).unwrap()),
        Gsd::open(folder.join("box.gsd")).unwrap(),
    );
    let mut distribution = RadialDistribution::with_maximum_distance(&slab, 0.0, 1.0, 3.0, 30).unwrap();
    let mut hexatic = HexaticOrder::new(&slab, 0.0, 1.0, 1.4).unwrap();
    for _ in 0..64 {
        simulation.run(10, &mut ()).unwrap();
        for observer in [&mut files as &mut dyn gradient_mc::Observer, &mut distribution, &mut hexatic] {
            observer.observe(&simulation.frame()).unwrap();
        }
    }
    let mut numbers = fs::File::create(folder.join("box.txt")).unwrap();
    for point in distribution.points().unwrap() {
        writeln!(numbers, "g {} {}", point.distance, point.radial_distribution.mean).unwrap();
    }
    writeln!(numbers, "local {}\nglobal {}", hexatic.local().unwrap().mean, hexatic.global().unwrap().mean)
        .unwrap();
    // Of the last frame.
    let mut order = BondOrder::new(&slab);
    order.gather(simulation.positions());
    for sphere in 0..order.count() {
        if let Some([q4, q6, w4]) = order.invariants(sphere) {
            writeln!(numbers, "bonds {sphere} {q4} {q6} {w4}").unwrap();
        }
    }
}
