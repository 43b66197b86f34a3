//! Checks the acceptance of local moves at all heights.

use crate::Warning;
use crate::monitor::Monitor;

/// With a lower acceptance a sphere keeps its place for more than fifty sweeps.
const LOWEST_ACCEPTANCE: f64 = 0.02;
/// Limit for tuned moves. They are tuned for a large mean square displacement, not for acceptance;
/// in the paper's columns 1.5 % of them are accepted.
const LOWEST_ACCEPTANCE_OF_TUNED: f64 = 0.002;
/// A range with a smaller fraction of the spheres is not reported.
const LEAST_SHARE: f64 = 0.01;

/// The range of heights with too low an acceptance, if it holds enough spheres.
pub(super) fn low(monitor: &Monitor, tuned: bool) -> Option<Warning> {
    let lowest = if tuned { LOWEST_ACCEPTANCE_OF_TUNED } else { LOWEST_ACCEPTANCE };
    let record = monitor.acceptance();
    let total: u64 = record.trials.iter().sum();
    let (mut trials, mut accepted, mut range) = (0, 0, None);
    for (band, (&tried, &moved)) in record.trials.iter().zip(&record.accepted).enumerate() {
        // Upper limit of the expected number of accepted moves, two standard deviations above the
        // count.
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
