//! What a simulation notes about its production run, so that it can be judged afterwards.

use crate::observer::{AcceptedMove, Collision, Recorder};
use crate::{Centers, Slab};

/// Bands of equal height over the whole slab.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bands {
    count: usize,
    height: f64,
}

impl Bands {
    /// High enough to average over a layer and more.
    const HEIGHT: f64 = 2.0;
    const MOST: f64 = 4096.0;

    fn new(slab: &Slab) -> Self {
        let bands = (slab.height() / Self::HEIGHT).round().clamp(1.0, Self::MOST);
        // At most 4096.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let count = bands as usize;
        Self { count, height: slab.height() / bands }
    }

    #[inline]
    fn of(&self, height: f64) -> usize {
        // Heights are inside the slab.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let band = (height * (1.0 / self.height)) as usize;
        band.min(self.count - 1)
    }

    /// Height of a band.
    pub(crate) fn height(&self) -> f64 {
        self.height
    }

    /// Lower edge of a band; of the one after the last, the lid.
    pub(crate) fn edge(&self, band: usize) -> f64 {
        band as f64 * self.height
    }
}

/// Trials and acceptances of local moves by band, from a few sweeps.
#[derive(Debug, Clone)]
pub(crate) struct Acceptance {
    bands: Bands,
    pub(crate) trials: Vec<u64>,
    pub(crate) accepted: Vec<u64>,
}

impl Recorder for Acceptance {
    fn record_move(&mut self, accepted: &AcceptedMove) {
        self.accepted[self.bands.of(accepted.from_height)] += 1;
    }
}

/// Notes about production: it reads configurations and moves, and changes neither them nor the generator.
///
/// The series of the center of mass is thinned whenever it is full, so that it spans the run in bounded memory, and the
/// longer a run the less it costs.
#[derive(Debug, Clone)]
pub(crate) struct Monitor {
    /// Sweeps of production.
    sweeps: u64,
    /// Of the drive when production began.
    generation: u64,
    /// Sweeps between two numbers of the series.
    interval: u64,
    series: Vec<f64>,
    /// Spheres by band, summed over looks that count for as many sweeps as they are apart.
    occupancy: Vec<u64>,
    weight: u64,
    bands: Bands,
    acceptance: Acceptance,
}

impl Monitor {
    /// A pass over all heights takes 3 to 10 % of a local sweep, most in small systems, and half as much again with
    /// bands. With these numbers all of it costs 0.5 % (25 000 spheres) to 1.3 % (360) of the first thousand sweeps, 0.2
    /// to 0.5 % of eight thousand, and less the longer a run.
    const LONGEST_SERIES: usize = 128;
    pub(crate) const FIRST_INTERVAL: u64 = 8;
    /// Looks at the bands are at least so many sweeps apart.
    const SWEEPS_BETWEEN_COUNTS: u64 = 32;
    const SWEEPS_BETWEEN_RECORDS: u64 = 128;

    pub(crate) fn new(slab: &Slab) -> Self {
        let bands = Bands::new(slab);
        let zeros = || vec![0; bands.count];
        Self {
            sweeps: 0,
            generation: 0,
            interval: Self::FIRST_INTERVAL,
            series: Vec::with_capacity(Self::LONGEST_SERIES),
            occupancy: zeros(),
            weight: 0,
            bands,
            acceptance: Acceptance { bands, trials: zeros(), accepted: zeros() },
        }
    }

    /// Forgets everything: production begins, with the drive at this `generation`.
    pub(crate) fn start(&mut self, generation: u64) {
        (self.sweeps, self.generation, self.interval, self.weight) = (0, generation, Self::FIRST_INTERVAL, 0);
        self.series.clear();
        let Acceptance { trials, accepted, .. } = &mut self.acceptance;
        for counts in [&mut self.occupancy, trials, accepted] {
            counts.fill(0);
        }
    }

    /// Whether the moves of a sweep are to be recorded. Some of the equilibration are too, to have the memory for it.
    pub(crate) fn records(sweep: u64) -> bool {
        sweep.is_multiple_of(Self::SWEEPS_BETWEEN_RECORDS)
    }

    /// Where moves are recorded.
    pub(crate) fn acceptance_mut(&mut self) -> &mut Acceptance {
        &mut self.acceptance
    }

    /// Counts the trials of a sweep that was recorded: spheres are picked uniformly, so a band has as many as spheres.
    pub(crate) fn count_trials(&mut self, centers: Centers<'_>) {
        let Acceptance { bands, trials, .. } = &mut self.acceptance;
        centers.for_each_height(|height| trials[bands.of(height)] += 1);
    }

    /// Looks at the configuration after a sweep of production.
    pub(crate) fn after_sweep(&mut self, centers: Centers<'_>) {
        let sweep = self.sweeps;
        self.sweeps += 1;
        if !sweep.is_multiple_of(self.interval) {
            return;
        }
        if self.series.len() == Self::LONGEST_SERIES {
            for kept in 0..Self::LONGEST_SERIES / 2 {
                self.series[kept] = self.series[2 * kept];
            }
            self.series.truncate(Self::LONGEST_SERIES / 2);
            self.interval *= 2;
            // The sweep is a multiple of the new interval too.
        }
        let mut moment = 0.0;
        let between_counts = self.interval.max(Self::SWEEPS_BETWEEN_COUNTS);
        if sweep.is_multiple_of(between_counts) {
            self.weight += between_counts;
            centers.for_each_height(|height| {
                moment += height;
                self.occupancy[self.bands.of(height)] += between_counts;
            });
        } else {
            centers.for_each_height(|height| moment += height);
        }
        self.series.push(moment / centers.count() as f64);
    }

    /// Sweeps of production.
    pub(crate) fn sweeps(&self) -> u64 {
        self.sweeps
    }

    /// Generation of the drive when production began.
    pub(crate) fn generation(&self) -> u64 {
        self.generation
    }

    /// Heights of the center of mass, evenly spaced in time over production.
    pub(crate) fn series(&self) -> &[f64] {
        &self.series
    }

    pub(crate) fn bands(&self) -> &Bands {
        &self.bands
    }

    /// Mean number of spheres in each band, upwards; nothing before the first look.
    pub(crate) fn mean_occupancy(&self) -> Option<Vec<f64>> {
        let weight = self.weight as f64;
        (self.weight > 0).then(|| self.occupancy.iter().map(|&count| count as f64 / weight).collect())
    }

    pub(crate) fn acceptance(&self) -> &Acceptance {
        &self.acceptance
    }
}

/// Passes moves on to an observer's recorder and to the monitor.
pub(crate) struct Both<'a> {
    pub(crate) observer: Option<&'a mut dyn Recorder>,
    pub(crate) monitor: &'a mut Acceptance,
}

impl Recorder for Both<'_> {
    fn record_move(&mut self, accepted: &AcceptedMove) {
        self.monitor.record_move(accepted);
        if let Some(observer) = &mut self.observer {
            observer.record_move(accepted);
        }
    }
    fn record_collision(&mut self, collision: &Collision) {
        if let Some(observer) = &mut self.observer {
            observer.record_collision(collision);
        }
    }
    fn record_chain(&mut self, axis: usize, length: f64) {
        if let Some(observer) = &mut self.observer {
            observer.record_chain(axis, length);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_series_spans_the_run_in_bounded_memory() {
        let slab = Slab::new(1e5, 3.0, 3.0).unwrap();
        let mut monitor = Monitor::new(&slab);
        monitor.start(3);
        for sweep in 0..40_000_u32 {
            monitor.after_sweep(Centers::listed(&[[f64::from(sweep), 0.0, 0.0]; 2]));
            let series = monitor.series();
            let interval = monitor.interval as f64;
            assert!(series.len() <= Monitor::LONGEST_SERIES);
            assert!(sweep < 1024 || series.len() > Monitor::LONGEST_SERIES / 2);
            let last = series.len() - 1;
            assert!(
                (series[last] - interval * last as f64).abs() < 1e-9
                    && f64::from(sweep) - series[last] < interval
            );
        }
        assert_eq!((monitor.sweeps(), monitor.generation(), monitor.interval), (40_000, 3, 512));
        // Two spheres, always somewhere.
        let occupancy: f64 = monitor.mean_occupancy().unwrap().iter().sum();
        assert!((occupancy - 2.0).abs() < 1e-9);
        monitor.start(4);
        assert!(monitor.mean_occupancy().is_none() && monitor.series().is_empty());
    }
}
