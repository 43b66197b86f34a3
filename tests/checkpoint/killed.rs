//! Processes that are killed, at any moment, and those that are told to stop.

use crate::file::Folder;
use gradient_mc::checkpoint::{Run, Signals, Snapshot};
use gradient_mc::field::UniformField;
use gradient_mc::observers::{Bins, ChainPressureProfile, DisplacementProfile};
use gradient_mc::temperature::ExponentialTemperature;
use gradient_mc::{Every, Scene, Simulation, Slab};
use std::fs;
use std::path::Path;
use std::process::{Child, Command};
use std::thread;
use std::time::Duration;

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
    let (_, ended) = run.of(Simulation::builder(scene).seed(6), &mut observer).unwrap();
    ended.is_finished()
}

fn start(path: &Path) -> Child {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command.args(["killed::child", "--exact", "--ignored", "--quiet"]).env(PATH, path);
    command.stdout(std::process::Stdio::null()).spawn().unwrap()
}

/// The bytes that a run ends with if nobody disturbs it.
fn undisturbed(folder: &Folder) -> Vec<u8> {
    let path = folder.0.join("undisturbed");
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

#[test]
fn a_run_that_is_killed_again_and_again_ends_with_the_same_bits() {
    const KILLS: u32 = 200;
    let folder = Folder::new("killed");
    let expected = undisturbed(&folder);
    let (mut kills, mut runs, mut state) = (0, 0, 1);
    while kills < KILLS {
        let path = folder.0.join(format!("run{runs}"));
        loop {
            let mut child = start(&path);
            thread::sleep(Duration::from_micros(next(&mut state) % 120_000));
            let was_running = child.try_wait().unwrap().is_none();
            // SIGKILL.
            child.kill().ok();
            let status = child.wait().unwrap();
            if status.success() {
                break;
            }
            assert!(was_running && status.code().is_none(), "{status}");
            kills += 1;
            // Whatever is there can be read, or the one before can.
            if path.exists() {
                Snapshot::read(&path).unwrap();
            }
        }
        assert!(fs::read(&path).unwrap() == expected, "run {runs}, after {kills} kills");
        runs += 1;
    }
    println!("{kills} kills in {runs} runs");
}

#[test]
fn signals_end_a_run_with_everything_written() {
    let folder = Folder::new("signals");
    let expected = undisturbed(&folder);
    let path = folder.0.join("run");
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
