//! The equation of state from one run, from ranks and from collisions.

mod collisions;
mod least_squares;
mod measured;
mod ranks;
mod smoothing;
persist!(
    EquationOfStateFit {
        part run,
        same spheres,
        same open_end,
        count frames,
        count incomplete,
        part ranks,
        part collisions,
        part averages,
    },
    |fit| fit.frames < EquationOfStateFit::INTERVAL
);

#[cfg(test)]
mod tests;

pub(crate) use collisions::{Collisions, Means};
pub use measured::{EquationOfStateCurve, MeasuredEquationOfState};

use super::bins::HeightBins;
use super::one_run::OneRun;
use crate::equation_of_state::{EquationOfState, Series, packing_fraction};
use crate::statistics::BlockAverages;
use crate::{Error, Frame, Merge, Observer, ObserverError, Recorder, Scene, Slab, Wall, Warning};
use measured::Route;
use ranks::Ranks;

/// Measures Z(η) as a smooth function of packing fraction, from all heights of a run together, by
/// two independent routes.
///
/// **Ranks.** The pressure just below the k-th highest sphere is the weight of the k highest
/// spheres, nearly without noise. The mean heights x₍ₖ₎ are measured. From dP = −n dU and P = n T
/// Z, with p = P/T and the base area A,
///
/// x₍ₖ₎ − x₍ₖ₊₁₎ = Z(pₖ)/(A pₖ),
///
/// for any reduced potential. If field or temperature vary with height, pₖ is the mean of Σ u′/A
/// over the spheres above. The relation is exact for an ideal gas of any number of spheres (order
/// statistics; Rényi, 1953). This route needs a stationary column and works with all moves.
///
/// **Collisions.** In event chains, Z = 1 + (sum of the separations of colliding spheres)/(path) at
/// every height, with the path of chains at this height (Michel, Kapfer and Krauth,
/// doi:10.1063/1.4863991). The packing fraction is that of the same heights in the same block of at
/// least 64 sweeps, smoothed over about eight diameters; the bias by its fluctuations is removed.
/// This route needs only local equilibrium: the column need not be stationary.
///
/// Each route fits all coefficients of Z = 1 + Σ cₖ ηᵏ/(1 − η)³, a form that includes Carnahan and
/// Starling's equation. [`result`](Self::result) combines the two routes and tests whether they
/// agree.
///
/// The layers at a wall are not used: up to the height where the density in bins of half a diameter
/// oscillates by less than 2 % (root mean square over two diameters), and two diameters more, but
/// at least four diameters.
///
/// ```
/// use gradient_mc::observers::EquationOfStateFit;
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// let slab = Slab::new(60.0, 5.0, 5.0)?;
/// let scene = Scene::new(slab, 500, UniformField::default(), Isothermal::new(5.0)?)?;
/// let mut simulation = Simulation::builder(scene).seed(1).build()?;
/// let mut fit = EquationOfStateFit::new(&scene)?;
/// simulation.equilibrate(200, &mut ())?;
/// simulation.run(1100, &mut fit)?;
/// let measured = fit.result()?;
/// let packing_fractions = [0.1, 0.2, 0.3];
/// let factors = measured.combined().compressibility_factor_at(&packing_fractions)?;
/// for (packing_fraction, factor) in packing_fractions.iter().zip(factors) {
///     println!("{packing_fraction}  {factor}");
/// }
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct EquationOfStateFit {
    slab: Slab,
    spheres: usize,
    open_end: Wall,
    run: OneRun,
    bins: HeightBins,
    ranks: Ranks,
    collisions: Collisions,
    frames: u64,
    /// Number of incomplete sweeps up to the last frame.
    incomplete: u64,
    sample: Vec<f64>,
    averages: BlockAverages,
}

impl EquationOfStateFit {
    /// Height of the bins, in diameters.
    const BIN_WIDTH: f64 = 0.5;
    /// Number of bins on either side over which densities are smoothed.
    const SMOOTHING: usize = 16;
    /// Number of frames of a sample; half of a block, over which packing fractions are counted, is
    /// at least one sample.
    const INTERVAL: u64 = 32;
    /// Number of frames between counts of spheres.
    const BETWEEN_COUNTS: u64 = 2;
    /// Number of frames between samples of ranks; successive configurations are strongly
    /// correlated, and sorting takes time.
    const BETWEEN_RANKS: u64 = 16;
    /// Distance from a wall, in diameters, that is always layered.
    const LAYERS: f64 = 2.0;

    /// Makes an observer for runs of `scene`.
    ///
    /// # Errors
    /// [`Error::InvalidBins`] for a slab higher than 32 768 diameters.
    pub fn new<F, T>(scene: &Scene<F, T>) -> Result<Self, Error> {
        let (slab, spheres) = (*scene.slab(), scene.particles());
        let ranks = Ranks::new(spheres);
        let collisions = Collisions::over(&slab, Self::SMOOTHING)?;
        let components = ranks.components() + collisions.components();
        Ok(Self {
            run: OneRun::in_slab(&slab),
            slab,
            spheres,
            open_end: scene.open_end(),
            bins: collisions.bins(),
            ranks,
            collisions,
            frames: 0,
            incomplete: 0,
            sample: vec![0.0; components],
            averages: BlockAverages::new(components)?
                .said_of("intervals of 32 frames for a fit of an equation of state"),
        })
    }

    /// Number of complete intervals of 32 frames.
    #[must_use]
    pub fn intervals(&self) -> u64 {
        self.averages.observations()
    }

    /// The equation of state measured so far.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] for fewer than 32 intervals, 1024 frames.
    pub fn result(&self) -> Result<MeasuredEquationOfState, Error> {
        let heights = self.heights_used()?;
        let range = bins_in(&self.bins, heights);
        let split = self.ranks.components();
        let contact = self.open_end.contact_height(&self.slab);
        let [one, other] = heights.map(|height| (contact - height).abs());
        let used = ranks::Used {
            nodes: self.ranks.nodes(),
            area: self.slab.base_area(),
            distances: [one.min(other), one.max(other)],
        };
        let jackknife = self.completed().jackknifed(|means| {
            let (ranks, collisions) = means.split_at(split);
            let (ranks, collisions) = (ranks::Means::of(ranks), collisions::Means::of(collisions));
            measured::fits(|route, terms| match route {
                Route::Ranks => ranks.fit(&used, terms),
                Route::Collisions => collisions.fit(range.clone(), terms),
            })
        })?;
        let smooth = self.smooth_counts();
        let most = smooth[range.clone()].iter().copied().fold(0.0, f64::max);
        let highest = packing_fraction(most / self.bins.volume());
        let too_steep = self.too_steep(&smooth, range);
        Ok(MeasuredEquationOfState::new(&jackknife, heights, highest, too_steep))
    }

    /// Z from collisions alone and without errors, for runs too short for [`result`](Self::result).
    /// It fits three coefficients and does not use the eight diameters at each wall.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] before the first 32 frames, or without event chains.
    pub fn collisions_without_errors(&self) -> Result<impl EquationOfState + use<>, Error> {
        const LAYERS: f64 = 8.0;
        let mean = self.completed().mean();
        let means = collisions::Means::of(&mean[self.ranks.components()..]);
        let range = bins_in(&self.bins, [LAYERS, self.slab.height() - LAYERS]);
        let coefficients = means.fit(range, measured::FEWEST_TERMS).filter(|_| self.intervals() > 0);
        coefficients.map(|coefficients| Series::new(&coefficients)).ok_or(Error::TooFewObservations {
            what: "intervals of 32 frames with event chains",
            available: 0,
            needed: 1,
        })
    }

    /// Smoothed mean numbers of spheres in bins.
    fn smooth_counts(&self) -> Vec<f64> {
        let (mean, first) = (self.averages.mean(), self.ranks.components());
        let mut smooth = vec![0.0; self.bins.count()];
        self.collisions.smooth(&mean[first..first + smooth.len()], &mut smooth);
        smooth
    }

    /// The averages with the terms of the series in every block.
    fn completed(&self) -> BlockAverages {
        let split = self.ranks.components();
        self.averages.of_halves(split + self.collisions.means(), |halves, completed| {
            let (ranks, collisions) = completed.split_at_mut(split);
            for (rank, (first, second)) in ranks.iter_mut().zip(halves[0].iter().zip(halves[1])) {
                *rank = 0.5 * (first + second);
            }
            self.collisions.complete(halves.map(|half| &half[split..]), collisions);
        })
    }

    /// A warning if more than a tenth of the spheres are at heights where the density changes by e
    /// within about three diameters, too steep for the smoothing.
    fn too_steep(&self, smooth: &[f64], range: std::ops::Range<usize>) -> Option<Warning> {
        const STEEPEST: f64 = 0.3;
        const LEAST_SHARE: f64 = 0.1;
        /// Number of bins on either side.
        const REACH: usize = 2;
        let width = self.slab.height() / smooth.len() as f64;
        let (mut all, mut steep, mut steepest) = (0.0, 0.0, (0, 0.0_f64));
        for bin in range.start + REACH..range.end.saturating_sub(REACH) {
            let (below, above) = (smooth[bin - REACH], smooth[bin + REACH]);
            if below > 0.0 && above > 0.0 {
                let slope = libm::log(above / below) / (2.0 * REACH as f64 * width);
                all += smooth[bin];
                if slope.abs() > STEEPEST {
                    steep += smooth[bin];
                }
                if slope.abs() * smooth[bin] > steepest.1.abs() * smooth[steepest.0] {
                    steepest = (bin, slope);
                }
            }
        }
        let (bin, slope) = steepest;
        let height = (bin as f64 + 0.5) * width;
        let share = steep / all;
        (share > LEAST_SHARE).then_some(Warning::SteepGradient { height, slope, share })
    }

    /// The range of heights that is used, without the layers at the walls.
    fn heights_used(&self) -> Result<[f64; 2], Error> {
        /// Diameters not used beyond the last visible layer; below, the smallest total distance.
        const MARGIN: f64 = 2.0;
        const LEAST: f64 = 4.0;
        /// Relative amplitude of visible layers.
        const VISIBLE: f64 = 0.02;
        /// Number of bins in two diameters.
        const WINDOW: usize = 4;
        let count = self.bins.count();
        let split = self.ranks.components();
        // Numbers of spheres in bins, with errors.
        let counts = self.averages.jackknife(|means| means[split..split + count].to_vec())?;
        let mut smooth = vec![0.0; count];
        self.collisions.smooth(&counts.iter().map(|count| count.mean).collect::<Vec<_>>(), &mut smooth);
        // Mean square of the oscillation, beyond noise, in the bins from `start` on.
        let is_layered = |start: usize| {
            let square = |bin: usize| {
                let (count, smooth) = (&counts[bin], smooth[bin]);
                let (deviation, noise) = ((count.mean - smooth) / smooth, count.standard_error / smooth);
                (deviation * deviation - noise * noise) / WINDOW as f64
            };
            // False without spheres.
            (start..start + WINDOW).map(square).sum::<f64>() > VISIBLE * VISIBLE
        };
        let height = self.slab.height();
        let width = height / count as f64;
        let first = bins_in(&self.bins, [Self::LAYERS, height - Self::LAYERS]);
        let starts = first.start..first.end.saturating_sub(WINDOW);
        // A column that does not reach a wall has no layers there.
        let reaches = |bin: usize| counts.get(bin).is_some_and(|count| count.mean > 0.0);
        let mut range = [0.0, height];
        if reaches(starts.start) {
            let lowest = starts.clone().find(|&start| !is_layered(start));
            range[0] = lowest.map_or(height, |bin| bin as f64 * width + MARGIN).max(LEAST);
        }
        if reaches(starts.end) {
            let highest = starts.clone().rfind(|&start| !is_layered(start));
            let edge = highest.map_or(0.0, |bin| (bin + WINDOW) as f64 * width - MARGIN);
            range[1] = edge.min(height - LEAST);
        }
        Ok(range)
    }
}

/// The bins whose middles are between two heights.
fn bins_in(bins: &HeightBins, [low, high]: [f64; 2]) -> std::ops::Range<usize> {
    let first = bins.centers().take_while(|&center| center < low).count();
    let end = bins.centers().take_while(|&center| center < high).count();
    first..end.max(first)
}

impl Observer for EquationOfStateFit {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        if frame.particles() != self.spheres {
            let (seen, shown) = (self.spheres as f64, frame.particles() as f64);
            return Err(Error::AnotherRun { what: "number of spheres", seen, shown }.into());
        }
        self.run.admit(frame)?;
        let incomplete = frame.move_counts().incomplete_sweeps;
        if std::mem::replace(&mut self.incomplete, incomplete) != incomplete {
            // A failed sweep has an incomplete path, so the interval is started again.
            self.ranks.forget();
            self.collisions.forget();
            self.frames = 0;
        }
        if self.frames.is_multiple_of(Self::BETWEEN_COUNTS) {
            self.collisions.observe(frame);
        }
        if self.frames.is_multiple_of(Self::BETWEEN_RANKS) {
            self.ranks.observe(frame);
        }
        self.frames += 1;
        if self.frames == Self::INTERVAL {
            self.frames = 0;
            let (ranks, collisions) = self.sample.split_at_mut(self.ranks.components());
            self.ranks.take(ranks);
            self.collisions.take(collisions);
            self.averages.push(&self.sample)?;
        }
        Ok(())
    }

    fn recorder(&mut self) -> Option<&mut dyn Recorder> {
        Some(&mut self.collisions)
    }
}

/// Incomplete intervals are not merged.
impl Merge for EquationOfStateFit {
    fn merge(&mut self, other: &Self) -> Result<(), Error> {
        self.bins.require_same(&other.bins)?;
        if self.spheres != other.spheres {
            let requirement = "fits can only be pooled if their scenes are the same";
            let value = other.spheres as f64;
            return Err(Error::InvalidParameter { name: "number of spheres", value, requirement });
        }
        self.run.require_same_scene(&other.run)?;
        self.averages.merge(&other.averages)?;
        self.run.join(&other.run);
        Ok(())
    }
}
