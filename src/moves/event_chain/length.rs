//! The length of chains.

use super::EventChains;

/// Mean length of chains, and the records that tune it.
///
/// A chain much shorter than the path between two field events moves a few spheres to and fro.
/// Beyond several such paths the length does not matter, since every field event continues the
/// chain elsewhere (measured in `docs/event_chains.md`). So the length is a multiple of the path
/// between field events. Where events are so frequent that a sweep would take too long, the path of
/// all its chains is limited to a multiple of the path between events.
#[derive(Debug, Clone, Copy)]
pub(super) struct ChainLength {
    fixed: Option<f64>,
    tuned: f64,
    /// Path of all chains of a sweep, as set and as limited.
    wanted_path_per_sphere: f64,
    pub(super) path_per_sphere: f64,
    /// Path of the chains of one visit to a tile, per mobile sphere.
    pub(super) path_per_visit: f64,
    /// Whether [`begin`](Self::begin) was called.
    pub(super) begun: bool,
    /// Path of the vertical chains so far.
    path: f64,
    field_events: u64,
    /// Path and events of vertical chains, with weights that decay with age.
    recent: [f64; 2],
}

impl ChainLength {
    const FIELD_EVENTS_PER_CHAIN: f64 = 10.0;
    /// Largest mean number of field events of a chain before tuning.
    const MOST_PER_CHAIN: f64 = 1000.0;
    /// Weight of a sweep relative to the next one, so that the relaxation of the start is
    /// forgotten.
    const MEMORY: f64 = 0.7;
    /// Events of a visit, per sphere: enough to pay for finding the pairs that can touch.
    const EVENTS_PER_VISIT: f64 = 8.0;
    /// Longest path of a visit, per sphere.
    const LONGEST_VISIT: f64 = 6.0;

    pub(super) fn new(chains: &EventChains) -> Self {
        let path_per_sphere = chains.path_per_sphere;
        Self {
            fixed: chains.length,
            wanted_path_per_sphere: path_per_sphere,
            tuned: 100.0,
            path_per_sphere,
            path_per_visit: 1.0,
            begun: false,
            path: 0.0,
            field_events: 0,
            recent: [0.0; 2],
        }
    }

    /// Limits lengths before the first chain by the mean magnitude of the force. Collisions, not
    /// known yet, come in addition.
    pub(super) fn begin(&mut self, force: f64) {
        self.begun = true;
        self.tuned = self.tuned.min(Self::MOST_PER_CHAIN / force);
        self.path_per_sphere = self.path_per_sphere.min(0.25 * EventChains::MOST_EVENTS / force);
        self.path_per_visit = self.path_per_visit.min(Self::EVENTS_PER_VISIT / force);
    }

    pub(super) fn mean(&self) -> f64 {
        self.fixed.unwrap_or(self.tuned)
    }

    /// Records the vertical chains of a sweep.
    pub(super) fn learn(&mut self, path: f64, events: u64, field_events: u64) {
        if path > 0.0 {
            self.path += path;
            self.field_events += field_events;
            let [all_path, all_events] = self.recent;
            self.recent = [Self::MEMORY * all_path + path, Self::MEMORY * all_events + events as f64];
        }
    }

    /// Sets the lengths from the records. The mean length is at most the height of the slab: after
    /// a wall reverses a chain, it retraces its path until the next field event.
    pub(super) fn tune(&mut self, height: f64) {
        let [path, events] = self.recent;
        if events > 0.0 {
            let free_path = path / events;
            self.path_per_sphere = self.wanted_path_per_sphere.min(EventChains::MOST_EVENTS * free_path);
            self.path_per_visit = (Self::EVENTS_PER_VISIT * free_path).min(Self::LONGEST_VISIT);
        }
        if self.field_events > 0 {
            let free_path = self.path / self.field_events as f64;
            self.tuned = (Self::FIELD_EVENTS_PER_CHAIN * free_path).min(height);
        } else {
            self.tuned = self.tuned.min(height);
        }
    }
}

persist!(
    ChainLength {
        same fixed,
        same wanted_path_per_sphere,
        value tuned,
        value path_per_sphere,
        value path_per_visit,
        value begun,
        value path,
        count field_events,
        value recent,
    },
    |length| length.makes_sense()
);

#[cfg(feature = "checkpoint")]
impl ChainLength {
    /// Whether sweeps end: chains have a positive length, and there are not too many.
    fn makes_sense(&self) -> bool {
        let positive = |value: f64| value.is_finite() && value > 0.0;
        let free_path = self.path / self.field_events as f64;
        [self.tuned, self.path_per_sphere, self.path_per_visit].into_iter().all(positive)
            && (self.field_events == 0 || positive(free_path))
            && self.recent.into_iter().all(|value| value.is_finite() && value >= 0.0)
            && self.path_per_sphere <= 1e6 * self.mean()
    }
}
