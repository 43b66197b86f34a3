//! Sweeps with any number of ranks, also stopped or failing ones, give the results of one process.

use crate::threads_as_ranks::{channels, job, sweep};
use gradient_mc::{Replicas, Simulation};
use gradient_mc_sweep::crew;
use gradient_mc_sweep::dispatch::State;
use gradient_mc_sweep::link::{Link as _, Message};
use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;
use tempfile::tempdir;

/// Seven scenes, two of them short of their target, of unequal lengths.
const TABLE: &str = r#"
packing_fractions = [0.05, 0.1, 0.4]
[[scene]]
name = "grid"
height = 30.0
base = [4.0, 4.0]
spheres = 60
field.linear = { base = [1.0, 0.8], slope = 0.01 }
temperature.isothermal = [3.0, 4.0, 5.0]
seed = 5
replicas = 3
equilibration = 50
sweeps = 1100

[[scene]]
name = "gradient"
height = 30.0
base = [4.0, 4.0]
spheres = 50
field.exponential = 0.02
temperature.exponential = { base = 4.0, decay_rate = 0.02 }
seed = 6
replicas = 2
equilibration = 100
sweeps = 3000
target_error = 0.2
"#;

fn tables(folder: &Path) -> [String; 2] {
    ["results.csv", "runs.csv"].map(|name| fs::read_to_string(folder.join(name)).unwrap())
}

fn is_finished(state: &State) -> bool {
    *state == State::Finished
}

#[test]
fn any_number_of_ranks_and_threads_gives_the_bits_of_replicas_in_one_process() {
    let scratch = tempdir().unwrap();
    let all: Vec<[String; 2]> = [[1, 1], [2, 1], [4, 1], [2, 3]]
        .map(|[ranks, threads]| {
            let folder = scratch.path().join(format!("{ranks}_{threads}"));
            let ended = sweep(TABLE, &folder, [ranks, threads], &|| false);
            assert!(ended.states.iter().all(is_finished) && ended.lost_ranks == 0);
            tables(&folder)
        })
        .to_vec();
    assert!(all.iter().all(|tables| *tables == all[0]));

    let job = job(TABLE, &scratch.path().join("1_1"));
    let grid = &job.table.cases[..6];
    let outcomes = Replicas::new(3).seed(5).run_each(grid, |case, replica| {
        let scene = case.scene()?;
        let mut observers = case.observers(&scene)?;
        let mut simulation = Simulation::builder(scene).seed(replica.seed()).build()?;
        simulation.equilibrate(case.equilibration, &mut ())?;
        simulation.run(case.sweeps, &mut observers)?;
        Ok(observers)
    });
    for (case, outcome) in grid.iter().zip(outcomes.unwrap()) {
        let (center_of_mass, fit) = outcome.merged().unwrap();
        let measured = job.measured(case).unwrap();
        assert_eq!(measured.center_of_mass.unwrap(), center_of_mass.estimate().unwrap());
        let fit = fit.result().unwrap();
        let expected = fit.combined().compressibility_factor_at(&[0.05, 0.1]).unwrap();
        let factors = &measured.compressibility_factors;
        assert_eq!([factors[0].unwrap(), factors[1].unwrap()], expected[..]);
        assert_eq!(factors[2], None);
    }
    // Of the target: the run ends early, at a sweep that depends on nothing else.
    let gradient = job.measured(&job.table.cases[6]).unwrap();
    assert!(gradient.sweeps < 6000 && gradient.center_of_mass.unwrap().standard_error < 0.3, "{gradient:?}");
}

#[test]
fn a_sweep_that_is_stopped_again_and_again_goes_on_to_the_same_bits() {
    let scratch = tempdir().unwrap();
    let (at_once, in_pieces) = (scratch.path().join("at_once"), scratch.path().join("in_pieces"));
    sweep(TABLE, &at_once, [1, 1], &|| false);
    let mut stops = 0;
    loop {
        let looks = AtomicUsize::new(0);
        // After some 100 milliseconds.
        let signaled = || looks.fetch_add(1, Ordering::SeqCst) > 5;
        let ended = sweep(TABLE, &in_pieces, [2, 1], &signaled);
        if ended.states.iter().all(|state| !matches!(state, State::Stopped)) && stops > 0 {
            let finished = tables(&in_pieces)[1].matches(",finished,").count();
            if finished == ended.states.len() {
                break;
            }
        }
        stops += 1;
        assert!(stops < 1000);
    }
    assert!(stops > 1, "nothing was left after the first stop");
    assert_eq!(tables(&in_pieces), tables(&at_once));
}

#[test]
fn a_run_that_fails_is_named_and_leaves_the_others_their_results() {
    let scratch = tempdir().unwrap();
    let good = scratch.path().join("good");
    sweep(TABLE, &good, [1, 1], &|| false);
    let bad = scratch.path().join("bad");
    // Where the checkpoint of a run is to be stands something else.
    fs::create_dir_all(bad.join("tasks/grid.1_2")).unwrap();
    let ended = sweep(TABLE, &bad, [2, 1], &|| false);
    let failed: Vec<usize> =
        (0..ended.states.len()).filter(|&task| !is_finished(&ended.states[task])).collect();
    assert_eq!(failed, [5]);
    assert!(
        matches!(&ended.states[5], State::Failed(why) if why.contains("grid.1_2: Is a directory")),
        "{:?}",
        ended.states[5]
    );
    let ([good, _], [bad, runs]) = (tables(&good), tables(&bad));
    assert!(runs.contains("failed: "));
    for (good, bad) in good.lines().zip(bad.lines()) {
        if good.starts_with("grid.1,") {
            assert!(bad.contains(",2,2200,") && bad.ends_with("only 2 of 3 replicas are finished"), "{bad}");
        } else {
            assert_eq!(good, bad);
        }
    }
    assert_eq!(good.lines().count(), bad.lines().count());
}

#[test]
fn a_rank_that_falls_silent_is_given_up_with_its_run_and_one_that_hears_nothing_stops() {
    let scratch = tempdir().unwrap();
    let mut links = channels(2);
    let (mut silent, mut leader) = (links.remove(1), links.remove(0));
    let mut job = job(TABLE, scratch.path());
    job.patience = Duration::from_secs(2);
    silent.send(0, &Message::Ready(1));
    // The last run first: it is the one that the silent rank is given, or the one after it.
    let ended = crew::lead(&job, &mut leader, 1, (0..job.table.tasks().len()).rev().collect(), &|| false);
    let lost = ended.states.iter().filter(|state| **state == State::Lost { rank: 1 }).count();
    let finished = ended.states.iter().filter(|state| is_finished(state)).count();
    assert_eq!((ended.lost_ranks, lost, finished), (1, 1, ended.states.len() - 1));

    // Rank 0 is gone.
    let mut links = channels(2);
    let mut follower = links.remove(1);
    assert!(!crew::follow(&job, &mut follower, 1, &|| false));
    assert!(job.is_stopping());
}

#[test]
fn two_processes_do_not_work_on_the_same_run() {
    let scratch = tempdir().unwrap();
    let mut job = job(TABLE, scratch.path());
    job.patience = Duration::from_millis(100);
    let case = &job.table.cases[0];
    let lock = fs::File::create(job.folder.checkpoint(case, 0).with_extension("0_0.lock")).unwrap();
    lock.lock().unwrap();
    let task = job.table.tasks()[0];
    let refused = job.run(task, |_| {}).unwrap_err();
    assert!(refused.explained().ends_with("another process has it"), "{}", refused.explained());
    // As when the other process is ended.
    job.patience = Duration::from_secs(60);
    thread::scope(|scope| {
        let waits = scope.spawn(|| job.run(task, |_| {}));
        thread::sleep(Duration::from_millis(200));
        drop(lock);
        assert!(waits.join().unwrap().unwrap());
    });
}
