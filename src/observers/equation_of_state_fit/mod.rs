//! The equation of state from one run, without counting in bins: from ranks and from collisions.

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

/// Z as a smooth function of packing fraction, from all heights of a run together, by two
/// independent routes.
///
/// **Ranks.** The pressure in the gap below the k-th highest sphere is the weight of the k spheres
/// above it, nearly without noise; measured are the mean heights x₍ₖ₎. From dP = −n dU and P = n T
/// Z, with p = P/T and the base area A,
///
/// x₍ₖ₎ − x₍ₖ₊₁₎ = Z(pₖ)/(A pₖ),
///
/// for any reduced potential; in a field that varies with height or in a temperature gradient pₖ is
/// the mean of Σ u′/A over the spheres above. An ideal gas obeys it exactly for any number of
/// spheres (order statistics; Rényi, 1953). It needs a column at rest, and suits any moves.
///
/// **Collisions.** Along event chains, Z = 1 + (sum of the separations of colliding
/// spheres)/(path), height by height, over the path run at that height (Michel, Kapfer and Krauth,
/// doi:10.1063/1.4863991). Z is compared at the packing fraction of the same heights in the same
/// sweeps, 64 at a time, smoothed over some eight diameters: a fluid in local equilibrium is
/// enough, the column may still be on its way.
///
/// Each route fits the coefficients of Z = 1 + Σ cₖ ηᵏ/(1 − η)³, the form of Carnahan and
/// Starling's equation, of which no coefficient is assumed. [`result`](Self::result) combines the
/// two and says whether they agree.
///
/// The layers at a wall are left out: up to where the density in bins of half a diameter oscillates
/// by less than 2 % (root mean square over two diameters), and two diameters more, four at least.
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
    /// Sweeps that ended with an error, up to the last frame.
    incomplete: u64,
    sample: Vec<f64>,
    averages: BlockAverages,
}

impl EquationOfStateFit {
    /// Height of the bins, in diameters.
    const BIN_WIDTH: f64 = 0.5;
    /// Bins on either side over which densities are smoothed.
    const SMOOTHING: usize = 16;
    /// Frames in which a packing fraction is counted.
    const INTERVAL: u64 = 64;
    /// Spheres are counted so often, in frames.
    const BETWEEN_COUNTS: u64 = 2;
    /// Ranks are looked at so often, in frames: successive configurations are alike, and sorting
    /// takes time.
    const BETWEEN_RANKS: u64 = 16;
    /// Diameters nearest to a wall, which are always layered.
    const LAYERS: f64 = 2.0;

    /// For runs of a scene.
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
                .said_of("intervals of 64 frames for a fit of an equation of state"),
        })
    }

    /// Intervals of 64 frames that are complete.
    #[must_use]
    pub fn intervals(&self) -> u64 {
        self.averages.observations()
    }

    /// What was measured so far.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] below 16 intervals, 1024 frames.
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
        let jackknife = self.averages.jackknifed(|means| {
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

    /// Z by collisions alone and without errors, for runs too short for [`result`](Self::result):
    /// with three coefficients, and without the eight diameters at either wall.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] before the first 64 frames, and if no event chains were seen.
    pub fn collisions_without_errors(&self) -> Result<impl EquationOfState + use<>, Error> {
        const LAYERS: f64 = 8.0;
        let mean = self.averages.mean();
        let means = collisions::Means::of(&mean[self.ranks.components()..]);
        let range = bins_in(&self.bins, [LAYERS, self.slab.height() - LAYERS]);
        let coefficients = means.fit(range, measured::FEWEST_TERMS).filter(|_| self.intervals() > 0);
        coefficients.map(|coefficients| Series::new(&coefficients)).ok_or(Error::TooFewObservations {
            what: "intervals of 64 frames with event chains",
            available: 0,
            needed: 1,
        })
    }

    /// Mean numbers of spheres in bins, smoothed.
    fn smooth_counts(&self) -> Vec<f64> {
        let mean = self.averages.mean();
        let counts = collisions::Means::of(&mean[self.ranks.components()..]).counts;
        let mut smooth = vec![0.0; counts.len()];
        self.collisions.smooth(counts, &mut smooth);
        smooth
    }

    /// Whether more than a tenth of the spheres are where a density that falls by e within some
    /// three diameters is smoothed away.
    fn too_steep(&self, smooth: &[f64], range: std::ops::Range<usize>) -> Option<Warning> {
        const STEEPEST: f64 = 0.3;
        const LEAST_SHARE: f64 = 0.1;
        /// Bins to either side.
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

    /// The range of heights without the layers at the walls.
    fn heights_used(&self) -> Result<[f64; 2], Error> {
        /// Diameters left out beyond the last layer that can be seen, and at least.
        const MARGIN: f64 = 2.0;
        const LEAST: f64 = 4.0;
        /// Relative amplitude of layers that can be seen.
        const VISIBLE: f64 = 0.02;
        /// Bins in two diameters.
        const WINDOW: usize = 4;
        let count = self.bins.count();
        let split = self.ranks.components();
        // Numbers in bins with their errors.
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
            // Not where there are no spheres.
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

/// The bins whose middles lie between two heights.
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
            // The path of a sweep that failed is not all that it was to be: the interval begins anew.
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

/// Intervals that are not complete are left out.
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
