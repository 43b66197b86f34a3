//! Long runs in one call.

use gradient_mc::checkpoint::{Persist, Reason, Run, Snapshot};
use gradient_mc::drive::{RunningAverage, Scheme};
use gradient_mc::field::UniformField;
use gradient_mc::moves::LocalMoves;
use gradient_mc::observers::{Bins, CenterOfMass, DisplacementProfile, ExtendedXyz, Gsd};
use gradient_mc::temperature::{ExponentialTemperature, Isothermal};
use gradient_mc::{Error, Every, Field, Scene, Simulation, SimulationBuilder, Slab, TemperatureProfile};
use std::error::Error as _;
use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use tempfile::tempdir;

fn slab() -> Slab {
    Slab::new(30.0, 4.0, 4.0).unwrap()
}

fn builder(seed: u64) -> SimulationBuilder<UniformField, ExponentialTemperature> {
    let temperature = ExponentialTemperature::new(4.0, 0.03).unwrap();
    let scene = Scene::new(slab(), 40, UniformField::default(), temperature).unwrap();
    Simulation::builder(scene).seed(seed)
}

/// What an undisturbed run of 100 and 8000 sweeps ends with.
fn undisturbed() -> Snapshot {
    let mut observer = CenterOfMass::new();
    let mut simulation = builder(1).build().unwrap();
    simulation.equilibrate(100, &mut ()).unwrap();
    simulation.run(8000, &mut observer).unwrap();
    simulation.snapshot(&mut observer).unwrap()
}

fn run<'a>(path: &Path, production: u64) -> Run<'a, CenterOfMass> {
    Run::new(path, 100, production)
}

#[test]
fn a_run_that_is_stopped_ends_as_one_that_is_not() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("deep").join("run");
    let stop = AtomicBool::new(false);
    let mut reasons = Vec::new();
    for stops in 0.. {
        stop.store(false, Ordering::SeqCst);
        let mut seen = 0;
        let show = |progress: &gradient_mc::checkpoint::Progress<'_>| {
            assert_eq!((progress.sweeps, progress.unsaved.is_some()), (8100, false));
            seen = progress.sweep;
        };
        let mut this = run(&path, 8000).stop_on(&stop).progress(show);
        this = match stops % 3 {
            0 => this.time_limit(Duration::from_millis(40)),
            // Nothing is done, and nothing is lost.
            1 => {
                stop.store(true, Ordering::SeqCst);
                this
            }
            _ => this.time_limit(Duration::from_millis(60)).checkpoint_every(Duration::ZERO),
        };
        let mut observer = CenterOfMass::new();
        let (mut simulation, ended) = this.of(builder(1), &mut observer).unwrap();
        assert_eq!((seen, ended.sweep), (simulation.sweep(), simulation.sweep()));
        reasons.push(ended.reason);
        let read = Snapshot::read(&path);
        let left: Vec<_> = fs::read_dir(path.parent().unwrap()).unwrap().collect();
        assert!(read.is_ok(), "{read:?} {left:?} {reasons:?}");
        assert_eq!(read.unwrap(), simulation.snapshot(&mut observer).unwrap());
        if ended.is_finished() {
            assert!(simulation.snapshot(&mut observer).unwrap() == undisturbed());
            break;
        }
        assert!(ended.to_string().contains("continues from"), "{ended}");
    }
    assert!(reasons.contains(&Reason::Stopped) && reasons.contains(&Reason::TimeLimit), "{reasons:?}");
    assert_eq!(reasons.last(), Some(&Reason::Complete));
    // One that is complete is read, and goes on if more is asked for.
    let mut observer = CenterOfMass::new();
    let (_, ended) = run(&path, 8000).of(builder(1), &mut observer).unwrap();
    assert_eq!((ended.reason, observer.heights().len()), (Reason::Complete, 8000));
    let mut observer = CenterOfMass::new();
    run(&path, 8050).of(builder(1), &mut observer).unwrap();
    assert_eq!(observer.heights().len(), 8050);
}

#[test]
fn a_target_is_reached_at_the_same_sweep_however_often_the_run_was_stopped() {
    let folder = tempdir().unwrap();
    let reached = |path: &str, limit: Duration| {
        loop {
            let mut observer = CenterOfMass::new();
            let (_, ended) = run(&folder.path().join(path), 100_000)
                .until(|observer| observer.estimate().is_ok_and(|height| height.standard_error < 0.15))
                .time_limit(limit)
                .of(builder(2), &mut observer)
                .unwrap();
            if ended.is_finished() {
                assert_eq!(ended.reason, Reason::TargetReached);
                assert!(observer.estimate().unwrap().standard_error < 0.15);
                return ended.sweep;
            }
        }
    };
    let expected = reached("undisturbed", Duration::MAX);
    assert!(expected > 116 && expected < 100_000, "{expected}");
    assert_eq!(reached("stopped", Duration::from_millis(30)), expected);
    // Already reached.
    assert_eq!(reached("stopped", Duration::MAX), expected);
}

#[test]
fn a_damaged_checkpoint_is_replaced_by_the_one_before() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("run");
    run(&path, 200).of(builder(1), &mut CenterOfMass::new()).unwrap();
    for damage in ["truncated", "gone"] {
        if damage == "gone" {
            fs::remove_file(&path).unwrap();
        } else {
            let bytes = fs::read(&path).unwrap();
            fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
        }
        let mut observer = CenterOfMass::new();
        let (mut simulation, _) = run(&path, 8000).of(builder(1), &mut observer).unwrap();
        assert!(simulation.snapshot(&mut observer).unwrap() == undisturbed(), "{damage}");
    }
    // Both are: nothing is begun anew over what may be worth something to somebody.
    for name in ["run", "run.previous"] {
        fs::write(folder.path().join(name), b"gmc-ckpt").unwrap();
    }
    let error = run(&path, 8000).of(builder(1), &mut CenterOfMass::new()).unwrap_err();
    assert!(error.source().unwrap().to_string().contains("damaged"), "{error:?}");
    assert_eq!(fs::read(&path).unwrap(), b"gmc-ckpt");
}

#[test]
fn what_cannot_be_written_is_said_and_harms_nothing() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("run");
    // At once, not after the first ten minutes.
    fs::write(folder.path().join("file"), b"").unwrap();
    let error = run(&folder.path().join("file").join("run"), 8000).of(builder(1), &mut CenterOfMass::new());
    assert!(matches!(error, Err(Error::CheckpointFile { .. })));
    // In between: the run goes on until there is room again.
    let endless = || Run::new(&path, 100, 1 << 40);
    let (mut failures, stop) = (0, AtomicBool::new(false));
    let obstacle = folder.path().join("run.new");
    let mut observer = CenterOfMass::new();
    let this = endless().checkpoint_every(Duration::from_millis(20)).stop_on(&stop).progress(|progress| {
        match progress.unsaved {
            None if failures == 0 => fs::create_dir_all(&obstacle).unwrap(),
            // There is room again, and it was found.
            None => stop.store(true, Ordering::SeqCst),
            Some(error) => {
                assert!(error.to_string().contains("run.new"));
                failures += 1;
                if failures == 3 {
                    fs::remove_dir(&obstacle).unwrap();
                }
            }
        }
    });
    let (simulation, ended) = this.of(builder(1), &mut observer).unwrap();
    assert!(failures >= 3 && ended.reason == Reason::Stopped, "{failures} {ended}");
    assert_eq!(Snapshot::read(&path).unwrap().sweep(), simulation.sweep());
    // At the end: it fails, and what was written before is as it was.
    let before = fs::read(&path).unwrap();
    stop.store(false, Ordering::SeqCst);
    let this = endless().stop_on(&stop).progress(|_| {
        fs::create_dir_all(&obstacle).unwrap();
        stop.store(true, Ordering::SeqCst);
    });
    assert!(matches!(this.of(builder(1), &mut observer), Err(Error::CheckpointFile { .. })));
    assert_eq!(fs::read(&path).unwrap(), before);
}

#[test]
fn another_call_is_refused() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("run");
    run(&path, 50).of(builder(1), &mut CenterOfMass::new()).unwrap();
    let before = fs::read(&path).unwrap();
    let equilibration = Run::new(&path, 90, 50).of(builder(1), &mut CenterOfMass::new());
    assert!(matches!(equilibration, Err(Error::CheckpointMismatch { .. })));
    let seed = run(&path, 50).of(builder(2), &mut CenterOfMass::new());
    assert!(matches!(seed, Err(Error::CheckpointMismatch { .. })));
    let scene = builder(1).build().unwrap();
    let isothermal =
        Scene::new(*scene.scene().slab(), 40, UniformField::default(), Isothermal::new(4.0).unwrap())
            .unwrap();
    let temperature = run(&path, 50).of(Simulation::builder(isothermal).seed(1), &mut CenterOfMass::new());
    assert!(matches!(temperature, Err(Error::CheckpointMismatch { .. })));
    assert_eq!(fs::read(&path).unwrap(), before);
}

#[test]
fn a_folder_that_is_removed_or_read_only_is_said() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("inner").join("run");
    let (stop, mut unsaved) = (AtomicBool::new(false), String::new());
    let this = Run::new(&path, 100, 1 << 40).checkpoint_every(Duration::from_millis(20)).stop_on(&stop);
    let this = this.progress(|progress| match progress.unsaved {
        None => drop(fs::remove_dir_all(folder.path().join("inner"))),
        Some(error) => {
            unsaved = error.to_string();
            // There again.
            fs::create_dir_all(folder.path().join("inner")).unwrap();
            stop.store(true, Ordering::SeqCst);
        }
    });
    let (simulation, _) = this.of(builder(1), &mut CenterOfMass::new()).unwrap();
    assert!(unsaved.contains("inner"), "{unsaved}");
    // The last call of `progress` removes it once more.
    assert!(simulation.sweep() > 0);

    // Whoever may write everywhere is not stopped by this.
    let readable = folder.path().join("readable");
    fs::create_dir_all(&readable).unwrap();
    let mut permissions = fs::metadata(&readable).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&readable, permissions).unwrap();
    let anybody = fs::write(readable.join("probe"), b"").is_err();
    let outcome = run(&readable.join("run"), 200).of(builder(1), &mut CenterOfMass::new());
    assert_eq!(matches!(outcome, Err(Error::CheckpointFile { .. })), anybody);
}

#[test]
fn a_trajectory_goes_on_with_the_run() {
    let folder = tempdir().unwrap();
    let open = |name: &str| {
        let text =
            fs::File::options().create(true).append(true).open(folder.path().join(format!("{name}.xyz")));
        let binary = Gsd::open(folder.path().join(format!("{name}.gsd")));
        Every::new(7, (ExtendedXyz::new(text.unwrap()), binary.unwrap()))
    };
    let go = |name: &str, sweeps: u64| {
        let path = folder.path().join(format!("{name}.checkpoint"));
        Run::new(path, 100, sweeps).of(builder(1), &mut open(name))
    };
    go("whole", 300).unwrap();
    go("parts", 50).unwrap();
    for kind in ["xyz", "gsd"] {
        // A process that was killed has written more than its checkpoint knows.
        let more = fs::File::options().append(true).open(folder.path().join(format!("parts.{kind}")));
        std::io::Write::write_all(&mut more.unwrap(), b"40\nLattice").unwrap();
    }
    go("parts", 120).unwrap();
    go("parts", 300).unwrap();
    for kind in ["xyz", "gsd"] {
        let [whole, parts] =
            ["whole", "parts"].map(|name| fs::read(folder.path().join(format!("{name}.{kind}"))).unwrap());
        assert!(!whole.is_empty() && whole == parts, "{kind}");
        // Another file, shorter or longer.
        for other in [b"another file".to_vec(), vec![b'1'; 2 * whole.len()]] {
            if kind == "gsd" || other.len() < whole.len() {
                fs::write(folder.path().join(format!("parts.{kind}")), &other).unwrap();
                assert!(matches!(go("parts", 400), Err(Error::CheckpointDamaged { .. })), "{kind}");
                assert_eq!(fs::read(folder.path().join(format!("parts.{kind}"))).unwrap(), other);
            }
        }
        fs::write(folder.path().join(format!("parts.{kind}")), &whole).unwrap();
    }
    go("parts", 400).unwrap();
    // A new run does not begin in a file that is there; what is there stays.
    let binary = fs::read(folder.path().join("parts.gsd")).unwrap();
    fs::remove_file(folder.path().join("parts.checkpoint")).unwrap();
    fs::remove_file(folder.path().join("parts.checkpoint.previous")).unwrap();
    let error = go("parts", 400).unwrap_err();
    assert!(error.to_string().contains("use another file, or remove this one"), "{error}");
    assert!(go("parts", 400).is_err());
    assert_eq!(fs::read(folder.path().join("parts.gsd")).unwrap(), binary);
}

/// Three stages of equilibration and production, the last with another observer; stopped again and
/// again.
#[test]
fn stages_that_are_stopped_end_as_those_that_are_not() {
    fn stages<F: Field, T: TemperatureProfile, S>(
        folder: &Path,
        builder: &SimulationBuilder<F, T, S>,
        limit: Option<Duration>,
    ) -> Option<(Snapshot, Snapshot)>
    where
        SimulationBuilder<F, T, S>: Clone,
        S: Scheme<F, T, Drive: Persist, Adaptation: Persist>,
    {
        fn run<'a, O>(path: &Path, sweeps: [u64; 2], limit: Option<Duration>) -> Run<'a, O> {
            Run::new(path, sweeps[0], sweeps[1]).time_limit(limit.unwrap_or(Duration::MAX))
        }
        let path = |name: &str| folder.join(name);
        let (mut first, mut second) =
            (CenterOfMass::new(), DisplacementProfile::new(&slab(), Bins::count(6)).unwrap());
        let mut simulation = builder.clone().build().unwrap();
        let ended = run(&path("first"), [7000, 0], limit)
            .observe_equilibration()
            .on(&mut simulation, &mut first)
            .unwrap();
        assert_eq!(first.heights().len() as u64, ended.sweep);
        if !ended.is_finished() {
            return None;
        }
        let ended = run(&path("second"), [0, 6000], limit).on(&mut simulation, &mut first).unwrap();
        if !ended.is_finished() {
            return None;
        }
        let ended = run(&path("third"), [1000, 5000], limit).on(&mut simulation, &mut second).unwrap();
        assert_eq!(ended.sweeps, 19_000);
        let snapshots = (simulation.snapshot(&mut first).unwrap(), simulation.snapshot(&mut second).unwrap());
        ended.is_finished().then_some(snapshots)
    }
    fn require_same<F: Field, T: TemperatureProfile, S>(name: &str, builder: &SimulationBuilder<F, T, S>)
    where
        SimulationBuilder<F, T, S>: Clone,
        S: Scheme<F, T, Drive: Persist, Adaptation: Persist>,
    {
        let folder = tempdir().unwrap();
        let start = Instant::now();
        let expected = stages(&folder.path().join("whole"), builder, None);
        // A quarter of a stage.
        let limit = start.elapsed() / 12;
        let (mut calls, parts) = (0, folder.path().join("parts"));
        let found = loop {
            calls += 1;
            if let Some(found) = stages(&parts, builder, Some(limit)) {
                break found;
            }
        };
        assert!(expected == Some(found), "{name}, {calls} calls");
        assert!(calls > 3, "{name}, {calls} calls");
        // All is done, and nothing is written.
        let before = fs::metadata(parts.join("third")).unwrap().modified().unwrap();
        assert!(stages(&parts, builder, None) == expected);
        assert_eq!(fs::metadata(parts.join("third")).unwrap().modified().unwrap(), before);
    }
    let builder = || builder(3);
    require_same("automatic", &builder());
    require_same("running", &builder().scheme(RunningAverage::default()));
    require_same("tuned", &builder().moves(LocalMoves::tuned()));
    let scene = Scene::new(slab(), 40, UniformField::default(), Isothermal::new(4.0).unwrap()).unwrap();
    require_same("isothermal", &Simulation::builder(scene).moves(LocalMoves::new(0.4).unwrap()));
}

#[test]
fn a_run_that_another_has_is_refused() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("run");
    let mut refused = None;
    let first = run(&path, 50).progress(|_| {
        let second = run(&path, 50).of(builder(1), &mut CenterOfMass::new());
        refused = second.err();
    });
    first.of(builder(1), &mut CenterOfMass::new()).unwrap();
    let refused = refused.unwrap();
    assert!(matches!(&refused, Error::CheckpointFile { path: of, .. } if *of == path), "{refused}");
    let source = refused.source().unwrap().downcast_ref::<std::io::Error>().unwrap();
    assert_eq!(source.kind(), std::io::ErrorKind::WouldBlock);
    // It is given back.
    run(&path, 60).of(builder(1), &mut CenterOfMass::new()).unwrap();
}

/// As on a disk that is full now and then.
#[cfg(target_os = "linux")]
#[test]
fn a_run_goes_on_while_there_is_no_room() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("run");
    let (mut failures, mut successes, stop) = (0, 0, AtomicBool::new(false));
    let fill = || drop(std::os::unix::fs::symlink("/dev/full", folder.path().join("run.new")));
    let before = std::cell::RefCell::new(Vec::new());
    // Less often than progress is shown, so that what becomes of each is seen.
    let this = run(&path, 1 << 40).checkpoint_every(Duration::from_millis(150)).stop_on(&stop);
    let this = this.progress(|progress| {
        if let Some(error) = progress.unsaved {
            let reason = std::error::Error::source(error).unwrap().to_string();
            assert!(
                error.to_string().contains("run.new") && reason.contains("No space"),
                "{error}: {reason}"
            );
            // What was there is as it was.
            assert!(*before.borrow() == fs::read(&path).unwrap());
            failures += 1;
        } else {
            successes += 1;
            *before.borrow_mut() = fs::read(&path).unwrap();
            fill();
        }
        stop.store(failures >= 3 && successes >= 3, Ordering::SeqCst);
    });
    // The last checkpoint has no room either: what was written before is as it was.
    let outcome = this.of(builder(1), &mut CenterOfMass::new());
    assert!(matches!(outcome, Err(Error::CheckpointFile { .. })) || failures >= 3);
    assert!(failures >= 3 && successes >= 3, "{failures} {successes}");
    let kept = Snapshot::read(&path).unwrap();
    fill();
    let refused = run(&path, 1 << 40).of(builder(1), &mut CenterOfMass::new()).unwrap_err();
    assert!(refused.to_string().contains("run.new"), "{refused}");
    assert_eq!(Snapshot::read(&path).unwrap(), kept);
}
