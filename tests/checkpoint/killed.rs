//! Processes that are killed at any moment, and processes that are stopped by a signal.

use gradient_mc::checkpoint::{Run, Signals, Snapshot};
use gradient_mc::field::UniformField;
use gradient_mc::observers::{Bins, ChainPressureProfile, DisplacementProfile};
use gradient_mc::temperature::ExponentialTemperature;
use gradient_mc::{Every, Scene, Simulation, Slab};
use std::error::Error as _;
use std::fs;
use std::path::Path;
use std::process::{Child, Command};
use std::thread;
use std::time::Duration;
use tempfile::{TempDir, tempdir};

/// Where the run of a child is kept.
const PATH: &str = "GRADIENT_MC_TEST_RUN";
/// Sweeps of production.
const SWEEPS: u64 = 1200;

/// The run of a child: a checkpoint after every sweep. The exit code says whether it has finished.
#[test]
#[ignore = "a process that the others start"]
fn child() {
    let Some(path) = std::env::var_os(PATH) else { return };
    let signals = Signals::listen().unwrap();
    let ended = run(Path::new(&path), Duration::ZERO, Some(&signals));
    std::process::exit(if ended { 0 } else { 3 });
}

/// Whether it has finished.
fn run(path: &Path, between_checkpoints: Duration, signals: Option<&Signals>) -> bool {
    let slab = Slab::new(30.0, 4.0, 4.0).unwrap();
    let temperature = ExponentialTemperature::new(4.0, 0.03).unwrap();
    let scene = Scene::new(slab, 40, UniformField::default(), temperature).unwrap();
    let mut observer = (
        Every::new(7, ChainPressureProfile::new(&slab, Bins::count(6)).unwrap()),
        Every::new(5, DisplacementProfile::new(&slab, Bins::count(6)).unwrap()),
    );
    let mut run = Run::new(path, 300, SWEEPS).checkpoint_every(between_checkpoints);
    if let Some(signals) = signals {
        run = run.stop_on(signals.flag());
    }
    match run.of(Simulation::builder(scene).seed(6), &mut observer) {
        Ok((_, ended)) => ended.is_finished(),
        Err(error) => panic!("{error}: {:?}", error.source()),
    }
}

fn start(path: &Path) -> Child {
    start_test("killed::child", path)
}

fn start_test(name: &str, path: &Path) -> Child {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args([name, "--exact", "--ignored", "--quiet"]).env(PATH, path);
    command.stdout(std::process::Stdio::null()).spawn().unwrap()
}

/// The bytes that a run ends with if nobody disturbs it.
fn undisturbed(folder: &TempDir) -> Vec<u8> {
    let path = folder.path().join("undisturbed");
    assert!(run(&path, Duration::MAX, None));
    fs::read(path).unwrap()
}

/// Random numbers (`SplitMix64`).
fn next(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mixed = (*state ^ (*state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}

/// So many runs, each killed at a random moment, many while they write a checkpoint; another
/// process goes on to the end.
fn killed_and_gone_on_with(count: u32) {
    let folder = tempdir().unwrap();
    let expected = undisturbed(&folder);
    let (mut done, mut while_writing, mut state) = (0, 0, 1);
    while done < count {
        let path = folder.path().join("run");
        let mut child = start(&path);
        // One in four at any moment, before there is a checkpoint as well.
        let at_any = next(&mut state).is_multiple_of(4);
        while !at_any && !path.exists() && child.try_wait().unwrap().is_none() {
            thread::sleep(Duration::from_millis(1));
        }
        thread::sleep(Duration::from_micros(next(&mut state) % 80_000));
        // SIGKILL.
        child.kill().ok();
        if child.wait().unwrap().code().is_none() {
            done += 1;
            while_writing += u32::from(folder.path().join("run.new").exists());
            assert!(run(&path, Duration::MAX, None), "{done}");
            assert!(fs::read(&path).unwrap() == expected, "{done}");
        }
        for name in ["run", "run.previous", "run.new"] {
            fs::remove_file(folder.path().join(name)).ok();
        }
    }
    println!(
        "{done} of {count} runs that were killed, {while_writing} while they wrote a checkpoint, end with the same bits"
    );
    assert!(while_writing > 0);
}

#[test]
fn runs_that_are_killed_end_with_the_same_bits() {
    killed_and_gone_on_with(20);
}

#[test]
#[ignore = "a minute"]
fn runs_that_are_killed_200_times_end_with_the_same_bits() {
    killed_and_gone_on_with(200);
}

#[test]
fn signals_end_a_run_with_everything_written() {
    let folder = tempdir().unwrap();
    let expected = undisturbed(&folder);
    let path = folder.path().join("run");
    for signal in ["INT", "TERM", "HUP", "USR1"] {
        let mut child = start(&path);
        // Until it listens and has begun.
        let begun = fs::metadata(&path).and_then(|file| file.modified()).ok();
        while fs::metadata(&path).and_then(|file| file.modified()).ok() == begun {
            thread::sleep(Duration::from_millis(2));
        }
        let sent = Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status();
        assert!(sent.unwrap().success());
        assert_eq!(child.wait().unwrap().code(), Some(3), "{signal}");
    }
    let last = Snapshot::read(&path).unwrap();
    assert!(last.sweep() < 300 + SWEEPS, "four interruptions were enough to end it");
    assert!(start(&path).wait().unwrap().success());
    assert!(fs::read(&path).unwrap() == expected);
}

#[test]
fn a_second_interrupt_ends_a_run_at_once_with_the_last_checkpoint_intact() {
    let folder = tempdir().unwrap();
    let expected = undisturbed(&folder);
    let path = folder.path().join("run");
    let mut ends = Vec::new();
    for delay in [0, 1, 3] {
        let mut child = start(&path);
        let begun = fs::metadata(&path).and_then(|file| file.modified()).ok();
        while fs::metadata(&path).and_then(|file| file.modified()).ok() == begun {
            thread::sleep(Duration::from_millis(2));
        }
        // At any moment of the sweep and of the checkpoint that the first one asks for.
        for _ in 0..2 {
            Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
            thread::sleep(Duration::from_millis(delay));
        }
        ends.push(child.wait().unwrap().code());
        // Between two renames there is only the one before.
        Snapshot::read(&path).or_else(|_| Snapshot::read(path.with_extension("previous"))).unwrap();
    }
    // By the second, or before it came.
    assert!(ends.iter().all(|code| matches!(code, Some(130 | 3))), "{ends:?}");
    assert!(start(&path).wait().unwrap().success());
    assert!(fs::read(&path).unwrap() == expected);
}

/// A program that does not look whether it was told to stop.
#[test]
#[ignore = "a process that another test starts"]
fn deaf_child() {
    let Some(path) = std::env::var_os(PATH) else { return };
    let _signals = Signals::listen().unwrap();
    assert!(run(Path::new(&path), Duration::ZERO, None));
    fs::write(Path::new(&path).with_extension("listening"), "").unwrap();
    loop {
        thread::sleep(Duration::from_secs(1));
    }
}

#[test]
fn a_second_interrupt_ends_a_program_that_does_not_listen() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("run");
    let mut child = start_test("killed::deaf_child", &path);
    while !path.with_extension("listening").exists() {
        thread::sleep(Duration::from_millis(2));
    }
    let interrupt =
        |child: &Child| Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    interrupt(&child);
    thread::sleep(Duration::from_millis(50));
    assert!(child.try_wait().unwrap().is_none(), "the first only asks");
    interrupt(&child);
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert!(fs::read(&path).unwrap() == undisturbed(&folder));
}

/// Files that may not grow beyond a limit, as on a disk with a quota.
#[test]
fn a_run_without_room_says_so_and_leaves_its_checkpoint() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("run");
    let mut child = start(&path);
    while !path.exists() {
        thread::sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let before = fs::read(&path).unwrap();
    let program = std::env::current_exe().unwrap();
    let limited = Command::new("sh")
        .args(["-c", "trap '' XFSZ; ulimit -f 1; exec \"$0\" \"$@\""])
        .arg(program)
        .args(["killed::child", "--exact", "--ignored"])
        .env(PATH, &path)
        .output()
        .unwrap();
    let said =
        String::from_utf8_lossy(&limited.stdout).into_owned() + &String::from_utf8_lossy(&limited.stderr);
    assert!(
        !limited.status.success() && said.contains("run.new") && said.contains("File too large"),
        "{said}"
    );
    assert!(fs::read(&path).unwrap() == before && !folder.path().join("run.new").exists());
    assert!(start(&path).wait().unwrap().success());
    assert!(fs::read(&path).unwrap() == undisturbed(&folder));
}
