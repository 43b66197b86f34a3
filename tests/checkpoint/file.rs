//! Files that are damaged, belong to other runs, or cannot be written.

use gradient_mc::checkpoint::Snapshot;
use gradient_mc::drive::{EquationOfStateClosure, RunningAverage, SelfConsistent};
use gradient_mc::equation_of_state::IdealGas;
use gradient_mc::field::UniformField;
use gradient_mc::moves::{EventChains, LocalMoves};
use gradient_mc::observers::{Bins, CenterOfMass, DensityProfile, PressureProfile};
use gradient_mc::temperature::{ExponentialTemperature, Isothermal};
use gradient_mc::{Error, Every, Scene, Simulation, SimulationBuilder, Slab};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::error::Error as _;
use std::fs;
use std::time::{Duration, Instant};
use tempfile::tempdir;

type Builder = SimulationBuilder<UniformField, ExponentialTemperature>;

fn scene(particles: usize, height: f64) -> Scene<UniformField, ExponentialTemperature> {
    let temperature = ExponentialTemperature::new(3.0, 0.05).unwrap();
    Scene::new(Slab::new(height, 3.0, 3.0).unwrap(), particles, UniformField::default(), temperature).unwrap()
}

fn small() -> (Builder, Every<DensityProfile>) {
    let scene = scene(10, 8.0);
    let profile = DensityProfile::new(scene.slab(), Bins::count(3)).unwrap();
    (Simulation::builder(scene).seed(1), Every::new(2, profile))
}

/// Of a small system with everything in it.
fn snapshot() -> Snapshot {
    let (builder, mut observer) = small();
    let mut simulation = builder.build().unwrap();
    simulation.equilibrate(20, &mut ()).unwrap();
    simulation.run(41, &mut observer).unwrap();
    simulation.snapshot(&mut observer).unwrap()
}

#[test]
fn every_truncation_and_every_changed_byte_is_found() {
    let bytes = snapshot().to_bytes();
    assert_eq!(Snapshot::from_bytes(&bytes).unwrap(), snapshot());
    for length in 0..bytes.len() {
        let error = Snapshot::from_bytes(&bytes[..length]).unwrap_err();
        assert!(matches!(error, Error::CheckpointDamaged { .. }), "{length}: {error}");
    }
    let mut changed = bytes.clone();
    for index in 0..bytes.len() {
        for mask in [0x01, 0x80, 0xff] {
            changed[index] ^= mask;
            let error = Snapshot::from_bytes(&changed).unwrap_err();
            let version = matches!(error, Error::CheckpointVersion { known: 1, .. });
            assert!(version == (8..12).contains(&index), "{index}: {error}");
            assert!(version || matches!(error, Error::CheckpointDamaged { .. }), "{index}: {error}");
            changed[index] ^= mask;
        }
    }
    assert!(Snapshot::from_bytes(&[&bytes[..], &[0]].concat()).is_err());
}

/// As above, and with a checksum that fits, so that all that is read has to be checked by itself.
#[test]
fn what_is_wrong_in_spite_of_its_checksum_does_no_harm() {
    let bytes = snapshot().to_bytes();
    let (mut refused, mut taken) = (0, 0);
    // Some milliseconds each, since the theory of the scene is solved.
    for (index, mask) in (16..bytes.len()).step_by(5).zip([0x01, 0x80, 0x7f].into_iter().cycle()) {
        let mut changed = bytes.clone();
        changed[index] ^= mask;
        let checksum = crc32fast::hash(&changed[16..]).to_le_bytes();
        changed[12..16].copy_from_slice(&checksum);
        let (builder, mut observer) = small();
        let resumed =
            Snapshot::from_bytes(&changed).and_then(|snapshot| builder.resume(&snapshot, &mut observer));
        match resumed {
            // Numbers that are as good as others.
            Ok(mut simulation) => {
                taken += 1;
                simulation.run(3, &mut observer).ok();
            }
            Err(Error::CheckpointDamaged { .. } | Error::CheckpointMismatch { .. }) => refused += 1,
            Err(error) => panic!("{index}: {error}"),
        }
    }
    println!("{refused} refused, {taken} taken");
    assert!(refused > 500 && taken > 500, "{refused} {taken}");
}

/// What differs, and what it was and is, in the words of the error.
fn mismatch<T>(result: Result<T, Error>) -> [String; 3] {
    match result.err() {
        Some(Error::CheckpointMismatch { what, saved, given, .. }) => [what, saved, given],
        other => panic!("{other:?}"),
    }
}

#[test]
fn another_run_is_refused_with_what_differs() {
    let snapshot = snapshot();
    let builder = |particles: usize, height: f64| Simulation::builder(scene(particles, height)).seed(1);
    let observer = || small().1;
    let resumed = |builder: Builder| mismatch(builder.resume(&snapshot, &mut observer()));
    assert_eq!(resumed(builder(11, 8.0)), ["number of spheres", "10", "11"]);
    assert_eq!(resumed(builder(10, 9.0))[0], "slab");
    assert_eq!(resumed(builder(10, 8.0).seed(2)), ["seed", "1", "2"]);
    let [what, saved, given] = resumed(builder(10, 8.0).moves(LocalMoves::new(0.25).unwrap()));
    assert!(what == "moves" && saved.contains("EventChains") && given.contains("0.25"), "{saved} {given}");
    assert_eq!(resumed(builder(10, 8.0).moves(EventChains::with_length(2.0).unwrap()))[0], "moves");

    let slab = *scene(10, 8.0).slab();
    let other = Scene::new(slab, 10, UniformField::new(1.5).unwrap(), *scene(10, 8.0).temperature()).unwrap();
    let [what, saved, given] = resumed(Simulation::builder(other).seed(1));
    assert_eq!(what, "potential of the field");
    assert_eq!((&saved[..], &given[..]), ("0.5 at height 0.5", "0.75 at height 0.5"));
    let temperature = ExponentialTemperature::new(3.0, 0.051).unwrap();
    let other = Scene::new(slab, 10, UniformField::default(), temperature).unwrap();
    assert_eq!(resumed(Simulation::builder(other).seed(1))[0], "temperature");
    let isothermal = Scene::new(slab, 10, UniformField::default(), Isothermal::new(3.0).unwrap()).unwrap();
    assert_eq!(
        mismatch(Simulation::builder(isothermal).seed(1).resume(&snapshot, &mut observer()))[0],
        "temperature"
    );

    let scheme = |scheme| builder(10, 8.0).scheme(scheme);
    let closure = EquationOfStateClosure::new(IdealGas);
    let [what, ..] = mismatch(builder(10, 8.0).scheme(closure).resume(&snapshot, &mut observer()));
    assert_eq!(what, "reduced potential at the start");
    let averaging = builder(10, 8.0).scheme(RunningAverage::default());
    let [what, ..] = mismatch(averaging.resume(&snapshot, &mut observer()));
    assert!(what.starts_with("content of drive"), "{what}");
    // What the default scheme makes is held in another way: the weight is found out all the same.
    let own = || scheme(SelfConsistent::default());
    let saved = own().build().unwrap().snapshot(&mut ()).unwrap();
    let [what, ..] =
        mismatch(scheme(SelfConsistent::default().closure_weight(1e3).unwrap()).resume(&saved, &mut ()));
    assert_eq!(what, "adaptation.prior.weight");
    own().resume(&saved, &mut ()).unwrap();
}

#[test]
fn another_observer_is_refused_with_what_differs() {
    let snapshot = snapshot();
    let slab = *scene(10, 8.0).slab();
    let density = || DensityProfile::new(&slab, Bins::count(3)).unwrap();
    let resume = |observer: &mut dyn gradient_mc::checkpoint::Persist| small().0.resume(&snapshot, observer);
    resume(&mut Every::new(2, density())).unwrap();
    assert_eq!(mismatch(resume(&mut Every::new(3, density()))), ["interval", "2", "3"]);
    let mut others = Every::new(2, DensityProfile::new(&slab, Bins::count(4)).unwrap());
    assert_eq!(mismatch(resume(&mut others))[0], "observer.bins");
    let mut others = Every::new(2, PressureProfile::new(&slab, Bins::count(3)).unwrap());
    assert_eq!(mismatch(resume(&mut others)), ["content of observer", "averages", "open_end"]);
    assert!(matches!(resume(&mut ()), Err(Error::CheckpointDamaged { .. })));
    assert_eq!(mismatch(resume(&mut CenterOfMass::new()))[1..], ["interval", "run"]);
    assert_eq!(mismatch(resume(&mut Some(density())))[1..], ["interval", "presence"]);
    assert_eq!(mismatch(resume(&mut (density(), density())))[1..], ["interval", "0"]);
}

#[test]
fn files_are_written_as_a_whole_and_the_one_before_is_kept() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("run.checkpoint");
    let (builder, mut observer) = small();
    let mut simulation = builder.build().unwrap();
    let first = simulation.snapshot(&mut observer).unwrap();
    first.write(&path).unwrap();
    simulation.run(1, &mut observer).unwrap();
    let second = simulation.snapshot(&mut observer).unwrap();
    second.write(&path).unwrap();
    assert_eq!(Snapshot::read(&path).unwrap(), second);
    assert_eq!(Snapshot::read(folder.path().join("run.checkpoint.previous")).unwrap(), first);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);

    // What cannot be written leaves what was there, and says where it was to go.
    fs::create_dir(folder.path().join("run.checkpoint.new")).unwrap();
    let error = first.write(&path).unwrap_err();
    assert!(matches!(&error, Error::CheckpointFile { path, .. } if path.ends_with("run.checkpoint.new")));
    assert!(error.source().is_some_and(<dyn std::error::Error>::is::<std::io::Error>));
    assert_eq!(Snapshot::read(&path).unwrap(), second);
    let error = first.write(folder.path().join("nowhere").join("run")).unwrap_err();
    assert!(format!("{error:?}").contains("nowhere"), "{error:?}");

    // What cannot be read says so too.
    fs::write(&path, b"gmc-ckpt").unwrap();
    let error = Snapshot::read(&path).unwrap_err();
    assert!(error.source().unwrap().to_string().contains("damaged"), "{error:?}");
    assert!(matches!(Snapshot::read(folder.path().join("none")), Err(Error::CheckpointFile { .. })));
}

#[test]
fn a_checkpoint_is_small_and_quick() {
    let slab = Slab::new(400.0, 25.0, 25.0).unwrap();
    let scene = Scene::new(slab, 25_000, UniformField::default(), Isothermal::new(15.0).unwrap()).unwrap();
    let mut simulation = Simulation::builder(scene).build().unwrap();
    let mut observer = DensityProfile::new(&slab, Bins::count(400)).unwrap();
    simulation.run(130, &mut observer).unwrap();
    let folder = tempdir().unwrap();
    let path = folder.path().join("run.checkpoint");
    let times = (0..5).map(|_| {
        let start = Instant::now();
        simulation.snapshot(&mut observer).unwrap().write(&path).unwrap();
        start.elapsed()
    });
    let quickest = times.min().unwrap();
    let size = fs::metadata(&path).unwrap().len();
    println!("{size} bytes in {quickest:?}");
    assert!(size < 30 * 25_000 + 128 * 400 * 8, "{size}");
    // A machine that is not busy takes a tenth of it.
    assert!(quickest < Duration::from_millis(200), "{quickest:?}");
}

/// Resident memory of this process at most, in MB.
#[cfg(target_os = "linux")]
fn most_memory() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with("VmHWM:")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap() / 1024
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "three gigabytes and a minute"]
fn a_checkpoint_of_ten_million_spheres() {
    const SPHERES: usize = 10_000_000;
    let slab = Slab::new(400.0, 500.0, 500.0).unwrap();
    let scene = Scene::new(slab, SPHERES, UniformField::default(), Isothermal::new(15.0).unwrap()).unwrap();
    let builder = Simulation::builder(scene).moves(LocalMoves::new(0.5).unwrap());
    let mut simulation = builder.clone().build().unwrap();
    simulation.run(3, &mut ()).unwrap();
    let memory = most_memory();
    let folder = tempdir().unwrap();
    let path = folder.path().join("run");
    let started = Instant::now();
    let snapshot = simulation.snapshot(&mut ()).unwrap();
    let taken = started.elapsed();
    snapshot.write(&path).unwrap();
    let written = started.elapsed();
    let size = fs::metadata(&path).unwrap().len();
    println!(
        "{:.2} bytes a sphere; taken in {taken:?}, on the disk after {written:?}; {memory} MB before, {} MB then",
        size as f64 / SPHERES as f64,
        most_memory()
    );
    assert!(size < 30 * SPHERES as u64, "{size}");
    drop((simulation, snapshot));
    let started = Instant::now();
    let mut again = builder.resume(&Snapshot::read(&path).unwrap(), &mut ()).unwrap();
    println!("goes on after {:?}; {} MB at most", started.elapsed(), most_memory());
    assert!(again.snapshot(&mut ()).unwrap().to_bytes() == fs::read(&path).unwrap());
}

/// Pieces that are removed, repeated, put elsewhere or made up, with a checksum that fits: a typed
/// error, or a snapshot, of which the bytes are those that were read.
#[test]
fn what_was_changed_at_random_is_read_or_refused() {
    let bytes = snapshot().to_bytes();
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let mut pick = |below: usize| random.random_range(0..below.max(1));
    let (mut refused, mut taken) = (0, 0);
    for _ in 0..100_000 {
        let mut changed = bytes.clone();
        for _ in 0..=pick(4) {
            let [start, to] = [16 + pick(changed.len() - 16), 16 + pick(changed.len() - 16)];
            let end = (start + 1 + pick(32)).min(changed.len());
            let piece = changed[start..end].to_vec();
            match pick(4) {
                0 => drop(changed.drain(start..end)),
                1 => drop(changed.splice(to..to, piece)),
                2 => changed[start] = u8::try_from(pick(256)).unwrap(),
                _ => changed[start..end].fill([0, 0x7f, 0x80, 0xff][pick(4)]),
            }
            if changed.len() < 24 {
                break;
            }
        }
        if pick(2) == 0 && changed.len() >= 24 {
            let length = (changed.len() - 24) as u64;
            changed[16..24].copy_from_slice(&length.to_le_bytes());
        }
        let checksum = crc32fast::hash(&changed[16..]).to_le_bytes();
        changed[12..16].copy_from_slice(&checksum);
        match Snapshot::from_bytes(&changed) {
            Ok(snapshot) => {
                taken += 1;
                assert!(snapshot.to_bytes() == changed);
            }
            Err(Error::CheckpointDamaged { .. }) => refused += 1,
            Err(error) => panic!("{error}"),
        }
    }
    assert!(refused > 10_000 && taken > 10_000, "{refused} {taken}");
}

/// Of an isothermal column, so that it depends on little.
fn golden() -> (SimulationBuilder<UniformField, Isothermal>, DensityProfile) {
    let slab = Slab::new(8.0, 3.0, 3.0).unwrap();
    let scene = Scene::new(slab, 10, UniformField::default(), Isothermal::new(3.0).unwrap()).unwrap();
    (Simulation::builder(scene).seed(1), DensityProfile::new(&slab, Bins::count(3)).unwrap())
}

const GOLDEN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/reference/checkpoint_format_1");

#[test]
fn a_file_of_format_1_is_read() {
    let bytes = fs::read(GOLDEN).unwrap();
    let (builder, mut observer) = golden();
    let mut simulation = builder.resume(&Snapshot::from_bytes(&bytes).unwrap(), &mut observer).expect(
        "what a file holds has changed: raise VERSION, and write another by \
         `cargo test --features checkpoint --test checkpoint -- --ignored write_golden`",
    );
    assert_eq!((simulation.sweep(), observer.observations()), (30, 20));
    assert!(simulation.snapshot(&mut observer).unwrap().to_bytes() == bytes);
}

#[test]
#[ignore = "writes the file that another test reads"]
fn write_golden() {
    let (builder, mut observer) = golden();
    let mut simulation = builder.build().unwrap();
    simulation.equilibrate(10, &mut ()).unwrap();
    simulation.run(20, &mut observer).unwrap();
    fs::write(GOLDEN, simulation.snapshot(&mut observer).unwrap().to_bytes()).unwrap();
}
