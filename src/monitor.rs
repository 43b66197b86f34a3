//! Records of a production run, from which warnings are made.

use crate::frame::{Frame, Phase};
use crate::observer::{AcceptedMove, Observer, ObserverError, Recorder};
use crate::{Quantity, Slab};

/// Bands of equal height over the whole slab.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bands {
    count: usize,
    height: f64,
}

impl Bands {
    /// Height of a band in diameters, larger than the distance of layers.
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

    /// Height of a band, in diameters.
    pub(crate) fn height(&self) -> f64 {
        self.height
    }

    /// Lower edge of a band; the index after the last gives the lid.
    pub(crate) fn edge(&self, band: usize) -> f64 {
        band as f64 * self.height
    }
}

/// Counts of local moves tried and accepted in each band, from a few sweeps.
#[derive(Debug, Clone)]
pub(crate) struct Acceptance {
    bands: Bands,
    pub(crate) trials: Vec<u64>,
    pub(crate) accepted: Vec<u64>,
    /// Counts of the sweep that is being recorded.
    accepted_now: Vec<u64>,
}

impl Recorder for Acceptance {
    fn record_move(&mut self, accepted: &AcceptedMove) {
        self.accepted_now[self.bands.of(accepted.from_height)] += 1;
    }
}

/// Records of production. The monitor reads configurations and moves, and changes neither them nor
/// the generator.
///
/// The series of the center of mass and of numbers of spheres are thinned when they are full. They
/// always span the whole run in bounded memory, and their cost per sweep decreases with the length
/// of the run.
#[derive(Debug, Clone)]
pub(crate) struct Monitor {
    /// Whether moves are recorded: only if all of them are local.
    records: bool,
    /// Number of the last sweep observed.
    seen: u64,
    /// Number of incomplete sweeps up to then.
    incomplete: u64,
    /// Sweeps of production.
    sweeps: u64,
    /// Generation of the drive when production began.
    generation: u64,
    /// Sweeps between two numbers of the series.
    interval: u64,
    /// Height of the center of mass, and the number of spheres below each mark.
    series: [Vec<f64>; 1 + Self::MARKS],
    /// Heights below which spheres are counted: two in the column, two near the base.
    marks: [f64; Self::MARKS],
    lowest_center: f64,
    /// Spheres in each band, summed over samples, each weighted with the number of sweeps since the
    /// previous sample.
    occupancy: Vec<u64>,
    weight: u64,
    bands: Bands,
    acceptance: Acceptance,
}

impl Monitor {
    /// Largest length of a series. One pass over all heights costs 3 to 10 % of a local sweep, and
    /// half more with bands. With the intervals chosen here the monitor costs 0.5 % (25 000
    /// spheres) to 1.3 % (360 spheres) of the first thousand sweeps, 0.2 to 0.5 % of eight
    /// thousand, and less in longer runs.
    const LONGEST_SERIES: usize = 128;
    const MARKS: usize = 4;
    /// Number of series of the whole column; the others are of the layers at the base.
    const OF_COLUMN: usize = 3;
    pub(crate) const FIRST_INTERVAL: u64 = 8;
    /// Smallest number of sweeps between two counts of the bands.
    const SWEEPS_BETWEEN_COUNTS: u64 = 32;
    const SWEEPS_BETWEEN_RECORDS: u64 = 128;

    /// Empty records of a run in `slab`; `records` is whether all moves are local.
    pub(crate) fn new(slab: &Slab, records: bool) -> Self {
        let bands = Bands::new(slab);
        let zeros = || vec![0; bands.count];
        Self {
            records,
            seen: 0,
            incomplete: 0,
            sweeps: 0,
            generation: 0,
            interval: Self::FIRST_INTERVAL,
            series: std::array::from_fn(|_| Vec::with_capacity(Self::LONGEST_SERIES)),
            marks: [0.0; Self::MARKS],
            lowest_center: slab.lowest_center(),
            occupancy: zeros(),
            weight: 0,
            bands,
            acceptance: Acceptance { bands, trials: zeros(), accepted: zeros(), accepted_now: zeros() },
        }
    }

    /// Clears all records at the start of production, with the drive at this `generation`.
    fn start(&mut self, generation: u64) {
        (self.sweeps, self.generation, self.interval, self.weight) = (0, generation, Self::FIRST_INTERVAL, 0);
        self.series.iter_mut().for_each(Vec::clear);
        let Acceptance { trials, accepted, .. } = &mut self.acceptance;
        for counts in [&mut self.occupancy, trials, accepted] {
            counts.fill(0);
        }
    }

    /// Whether the moves of the current sweep are recorded. Some sweeps of equilibration are
    /// recorded too, which allocates the memory early.
    fn is_recording(&self) -> bool {
        self.records && self.seen.is_multiple_of(Self::SWEEPS_BETWEEN_RECORDS)
    }

    /// Counts the moves and trials of a recorded sweep. Spheres are picked uniformly, so the number
    /// of trials in a band is its number of spheres.
    fn count_moves(&mut self, frame: &Frame<'_>) {
        let Acceptance { bands, trials, accepted, accepted_now } = &mut self.acceptance;
        for (sum, now) in accepted.iter_mut().zip(accepted_now) {
            *sum += std::mem::take(now);
        }
        frame.for_each_height(|height| trials[bands.of(height)] += 1);
    }

    /// Samples the configuration after a sweep of production.
    fn look(&mut self, frame: &Frame<'_>) {
        let sweep = self.sweeps;
        self.sweeps += 1;
        if !sweep.is_multiple_of(self.interval) {
            return;
        }
        if sweep == 0 {
            self.mark(frame);
        }
        if self.series[0].len() == Self::LONGEST_SERIES {
            for series in &mut self.series {
                for kept in 0..Self::LONGEST_SERIES / 2 {
                    series[kept] = series[2 * kept];
                }
                series.truncate(Self::LONGEST_SERIES / 2);
            }
            self.interval *= 2;
            // The sweep is a multiple of the new interval too.
        }
        let marks = self.marks;
        let (mut moment, mut below) = (0.0, [0_u64; Self::MARKS]);
        let mut count = |height: f64| {
            moment += height;
            for (below, mark) in below.iter_mut().zip(marks) {
                *below += u64::from(height < mark);
            }
        };
        let between_counts = self.interval.max(Self::SWEEPS_BETWEEN_COUNTS);
        if sweep.is_multiple_of(between_counts) {
            self.weight += between_counts;
            frame.for_each_height(|height| {
                count(height);
                self.occupancy[self.bands.of(height)] += between_counts;
            });
        } else {
            frame.for_each_height(count);
        }
        let [center, counts @ ..] = &mut self.series;
        center.push(moment / frame.particles() as f64);
        counts.iter_mut().zip(below).for_each(|(series, below)| series.push(below as f64));
    }

    /// Chooses the marks: the edges of bands below which half and nine tenths of the spheres are;
    /// half a diameter above the lowest possible center, which bounds the first layer; and the
    /// upper edge of the lowest band.
    fn mark(&mut self, frame: &Frame<'_>) {
        const LAYER: f64 = 0.5;
        let mut counts = vec![0_usize; self.bands.count];
        frame.for_each_height(|height| counts[self.bands.of(height)] += 1);
        let quantile = |part: f64| {
            let mut below = 0;
            let reached = counts.iter().position(|count| {
                below += count;
                below as f64 >= part * frame.particles() as f64
            });
            self.bands.edge(1 + reached.unwrap_or(0))
        };
        self.marks = [quantile(0.5), quantile(0.9), self.lowest_center + LAYER, self.bands.edge(1)];
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
    pub(crate) fn center_of_mass(&self) -> &[f64] {
        &self.series[0]
    }

    /// All series of each part of the column, evenly spaced in time over production. The
    /// autocorrelation time of a part is that of its slowest series.
    pub(crate) fn series(&self) -> [(Quantity, &[Vec<f64>]); 2] {
        let (column, base) = self.series.split_at(Self::OF_COLUMN);
        [(Quantity::Column, column), (Quantity::Base, base)]
    }

    pub(crate) fn bands(&self) -> &Bands {
        &self.bands
    }

    /// Mean number of spheres in each band, upwards; `None` before the first count.
    pub(crate) fn mean_occupancy(&self) -> Option<Vec<f64>> {
        let weight = self.weight as f64;
        (self.weight > 0).then(|| self.occupancy.iter().map(|&count| count as f64 / weight).collect())
    }

    pub(crate) fn acceptance(&self) -> &Acceptance {
        &self.acceptance
    }
}

impl Observer for Monitor {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        let incomplete = frame.move_counts().incomplete_sweeps;
        let whole = std::mem::replace(&mut self.incomplete, incomplete) == incomplete;
        if !whole {
            // The recorded moves include those of an incomplete sweep, whose trials are not known.
            self.acceptance.accepted_now.fill(0);
        }
        let recorded = whole && self.is_recording();
        self.seen = frame.sweep();
        let production = frame.phase() == Phase::Production;
        if production && frame.sweep_of_phase() == 1 {
            self.start(frame.generation());
        }
        if recorded {
            self.count_moves(frame);
        }
        if production {
            self.look(frame);
        }
        Ok(())
    }

    fn recorder(&mut self) -> Option<&mut dyn Recorder> {
        if self.is_recording() { Some(&mut self.acceptance) } else { None }
    }
}

persist!(Acceptance { counts trials, counts accepted, counts accepted_now });
persist!(
    Monitor {
        same records,
        count seen,
        count incomplete,
        count sweeps,
        count generation,
        count interval,
        value series,
        value marks,
        counts occupancy,
        count weight,
        part acceptance,
    },
    |monitor| {
        let length = monitor.series[0].len();
        monitor.interval > 0
            && length <= Monitor::LONGEST_SERIES
            && monitor.series.iter().all(|series| series.len() == length)
    }
);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;
    use crate::centers::Centers;
    use crate::field::UniformField;
    use crate::frame::{MoveCounts, Still};
    use crate::temperature::Isothermal;

    /// Two spheres at a height, in a sweep of production.
    fn show(monitor: &mut Monitor, slab: &Slab, height: f64, sweep: u64, generation: u64) {
        let (field, temperature) = (UniformField::default(), Isothermal::new(1.0).unwrap());
        let scene = Scene::unchecked(*slab, 2, field, temperature);
        let positions = [[height, 0.0, 0.0]; 2];
        let frame = Frame {
            scene: scene.as_any(),
            potential: &Still(generation),
            centers: Centers::listed(&positions),
            sweep,
            phase: Phase::Production,
            sweep_of_phase: sweep,
            move_counts: &MoveCounts::default(),
        };
        monitor.observe(&frame).unwrap();
    }

    #[test]
    fn the_series_spans_the_run_in_bounded_memory() {
        let slab = Slab::new(1e5, 3.0, 3.0).unwrap();
        let mut monitor = Monitor::new(&slab, false);
        for sweep in 0..40_000_u32 {
            show(&mut monitor, &slab, sweep.into(), u64::from(sweep) + 1, 3);
            let series = monitor.center_of_mass();
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
        // Two spheres in total.
        let occupancy: f64 = monitor.mean_occupancy().unwrap().iter().sum();
        assert!((occupancy - 2.0).abs() < 1e-9);
        // Production starts again.
        show(&mut monitor, &slab, 7.0, 1, 4);
        assert_eq!((monitor.center_of_mass(), monitor.sweeps(), monitor.generation()), (&[7.0][..], 1, 4));
    }

    #[test]
    fn moves_are_recorded_every_128th_sweep_if_all_are_trials() {
        let slab = Slab::new(10.0, 3.0, 3.0).unwrap();
        let mut monitor = Monitor::new(&slab, true);
        let mut asked = Vec::new();
        for sweep in 1..=257 {
            if let Some(recorder) = monitor.recorder() {
                let displacement = nalgebra::Vector3::zeros();
                recorder.record_move(&AcceptedMove { from_height: 3.0, displacement, chain_axis: None });
                asked.push(sweep);
            }
            show(&mut monitor, &slab, 3.0, sweep, 0);
        }
        assert_eq!(asked, [1, 129, 257]);
        let Acceptance { trials, accepted, .. } = monitor.acceptance();
        assert_eq!((trials.iter().sum::<u64>(), accepted.iter().sum::<u64>()), (6, 3));
        assert!(Monitor::new(&slab, false).recorder().is_none());
    }
}
