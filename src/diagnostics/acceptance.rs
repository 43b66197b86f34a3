//! Whether local moves are accepted wherever there are spheres.

use crate::Warning;
use crate::monitor::Monitor;

/// Below this, a sphere stays where it is for fifty sweeps and more.
const LOWEST_ACCEPTANCE: f64 = 0.02;
/// Tuned moves are judged by how far they come: most of their jumps are meant to fail, and 1.5 % of
/// them are accepted in the paper's columns.
const LOWEST_ACCEPTANCE_OF_TUNED: f64 = 0.002;
/// A smaller part of the spheres does not matter.
const LEAST_SHARE: f64 = 0.01;

/// The range of heights in which hardly a move is accepted, if enough spheres are in it.
pub(super) fn low(monitor: &Monitor, tuned: bool) -> Option<Warning> {
    let lowest = if tuned { LOWEST_ACCEPTANCE_OF_TUNED } else { LOWEST_ACCEPTANCE };
    let record = monitor.acceptance();
    let total: u64 = record.trials.iter().sum();
    let (mut trials, mut accepted, mut range) = (0, 0, None);
    for (band, (&tried, &moved)) in record.trials.iter().zip(&record.accepted).enumerate() {
        // Not by chance: two standard deviations of the number that was accepted, and one more, are allowed
        // for.
        let at_most = moved as f64 + 2.0 * (moved as f64 + 1.0).sqrt();
        if at_most < lowest * tried as f64 {
            trials += tried;
            accepted += moved;
            range = Some((range.map_or(band, |(first, _)| first), band));
        }
    }
    let (first, last) = range?;
    let share = trials as f64 / total as f64;
    (share >= LEAST_SHARE).then(|| Warning::LowAcceptance {
        lowest_height: monitor.bands().edge(first),
        highest_height: monitor.bands().edge(last + 1),
        acceptance: accepted as f64 / trials as f64,
        share,
    })
}
