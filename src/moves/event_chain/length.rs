//! How long chains are.

use super::EventChains;

/// Mean length of chains, and what it is tuned by.
///
/// A chain that is short against the path between two field events drags a few spheres to and fro;
/// one that is long against it is as good as any longer one, since every field event starts afresh
/// elsewhere (measured in `docs/event_chains.md`). So the length is a multiple of that path. Where
/// events come so fast that a sweep would not end soon, the path of all its chains is a multiple of
/// that between two of them.
#[derive(Debug, Clone, Copy)]
pub(super) struct ChainLength {
    fixed: Option<f64>,
    tuned: f64,
    /// Of all chains of a sweep: what is wanted, and what it is.
    wanted_path_per_sphere: f64,
    pub(super) path_per_sphere: f64,
    /// Of the chains of one visit to a tile, per mobile sphere.
    pub(super) path_per_visit: f64,
    /// Whether the forces of the start have been seen.
    pub(super) begun: bool,
    /// Of vertical chains, while equilibrating.
    path: f64,
    field_events: u64,
    /// Path and events of vertical chains of late, older ones counting less.
    recent: [f64; 2],
}

impl ChainLength {
    const FIELD_EVENTS_PER_CHAIN: f64 = 10.0;
    /// A chain that has not been tuned is stopped no more often than so.
    const MOST_PER_CHAIN: f64 = 1000.0;
    /// What a visit counts less than the next, since a start relaxes.
    const MEMORY: f64 = 0.7;
    /// Events of a visit, per sphere: as many as pay for finding out who can touch whom.
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

    /// Before the first chain, when all that is known is the mean magnitude of the force.
    /// Collisions come on top.
    pub(super) fn begin(&mut self, force: f64) {
        self.begun = true;
        self.tuned = self.tuned.min(Self::MOST_PER_CHAIN / force);
        self.path_per_sphere = self.path_per_sphere.min(0.25 * EventChains::MOST_EVENTS / force);
        self.path_per_visit = self.path_per_visit.min(Self::EVENTS_PER_VISIT / force);
    }

    pub(super) fn mean(&self) -> f64 {
        self.fixed.unwrap_or(self.tuned)
    }

    /// What the vertical chains of a sweep came to.
    pub(super) fn learn(&mut self, path: f64, events: u64, field_events: u64) {
        if path > 0.0 {
            self.path += path;
            self.field_events += field_events;
            let [all_path, all_events] = self.recent;
            self.recent = [Self::MEMORY * all_path + path, Self::MEMORY * all_events + events as f64];
        }
    }

    /// Sets the length from what the chains so far have met. It is at most the height of the slab:
    /// a chain that a wall turns round undoes what it has done until the field stops it.
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
    /// Whether sweeps end: chains have a length, and are not too many.
    fn makes_sense(&self) -> bool {
        let positive = |value: f64| value.is_finite() && value > 0.0;
        let free_path = self.path / self.field_events as f64;
        [self.tuned, self.path_per_sphere, self.path_per_visit].into_iter().all(positive)
            && (self.field_events == 0 || positive(free_path))
            && self.recent.into_iter().all(|value| value.is_finite() && value >= 0.0)
            && self.path_per_sphere <= 1e6 * self.mean()
    }
}
