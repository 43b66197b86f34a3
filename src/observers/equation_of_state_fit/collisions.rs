//! Z from event chains: collisions over path, resolved by height.

use super::super::bins::{Bins, HeightBins, Place};
use super::least_squares::LeastSquares;
use super::smoothing::Smoothing;
use super::{EquationOfStateFit, bins_in};
use crate::equation_of_state::{EquationOfState, MOST_TERMS, Series, packing_fraction};
use crate::{AcceptedMove, Collision, Error, Frame, Recorder, Slab};
use std::ops::Range;

/// Sums over an interval of sweeps, for each bin of height.
#[derive(Debug, Clone)]
pub(crate) struct Collisions {
    bins: HeightBins,
    smoothing: Smoothing,
    frames: f64,
    counts: Vec<f64>,
    /// Path, and sum of separations; half of each separation is added to the bin of each of the two
    /// spheres.
    sums: Vec<[f64; 2]>,
}

/// Means over blocks: numbers of spheres, paths, sums of separations, and paths times each term of
/// a [`Series`] at the packing fraction of the block.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Means<'a> {
    pub(super) counts: &'a [f64],
    paths: &'a [f64],
    transfers: &'a [f64],
    terms: &'a [f64],
}

impl Collisions {
    /// Makes sums in bins over a whole slab, smoothed over `reach` bins on either side.
    ///
    /// # Errors
    /// [`Error::InvalidBins`] for a slab higher than 32 768 diameters.
    pub(crate) fn over(slab: &Slab, reach: usize) -> Result<Self, Error> {
        const LAYERS: f64 = EquationOfStateFit::LAYERS;
        let bins = Bins::of_width(EquationOfStateFit::BIN_WIDTH.min(slab.height())).of(slab)?;
        let used = bins_in(&bins, [LAYERS, slab.height() - LAYERS]);
        Ok(Self {
            smoothing: Smoothing::new(bins.count(), used, reach),
            frames: 0.0,
            counts: vec![0.0; bins.count()],
            sums: vec![[0.0; 2]; bins.count()],
            bins,
        })
    }

    pub(super) fn bins(&self) -> HeightBins {
        self.bins
    }

    /// The bins whose middles are more than `distance` from both walls.
    pub(crate) fn away_from_walls(&self, slab: &Slab, distance: f64) -> Range<usize> {
        bins_in(&self.bins, [distance, slab.height() - distance])
    }

    /// Number of components of a sample: numbers of spheres, paths and sums of separations.
    pub(crate) fn components(&self) -> usize {
        3 * self.bins.count()
    }

    /// Number of components of [`Means`].
    pub(crate) fn means(&self) -> usize {
        (3 + MOST_TERMS) * self.bins.count()
    }

    pub(super) fn smooth(&self, values: &[f64], smooth: &mut [f64]) {
        self.smoothing.apply(values, smooth);
    }

    pub(crate) fn observe(&mut self, frame: &Frame<'_>) {
        self.frames += 1.0;
        frame.for_each_height(|height| {
            if let Place::Inside(bin, _) = self.bins.locate(height) {
                self.counts[bin] += 1.0;
            }
        });
    }

    /// Ends an interval: writes its sample and starts the next interval.
    pub(crate) fn take(&mut self, sample: &mut [f64]) {
        let (counts, sums) = sample.split_at_mut(self.bins.count());
        let (paths, transfers) = sums.split_at_mut(self.bins.count());
        for (bin, (count, &[path, transfer])) in self.counts.iter().zip(&self.sums).enumerate() {
            (counts[bin], paths[bin], transfers[bin]) = (count / self.frames, path, transfer);
        }
        self.forget();
    }

    /// Writes [`Means`] of a block, from the mean samples of its halves.
    ///
    /// A term f(η) at the packing fraction of a finite volume and time has the bias f″ var(η)/2. If
    /// the densities of the halves fluctuate independently, that of the block has half of their
    /// variance, and 2 f(block) − (mean of f over the halves) has no bias of this order.
    pub(crate) fn complete(&self, halves: [&[f64]; 2], means: &mut [f64]) {
        let count = self.bins.count();
        let (sums, terms) = means.split_at_mut(3 * count);
        for (sum, (first, second)) in sums.iter_mut().zip(halves[0].iter().zip(halves[1])) {
            *sum = 0.5 * (first + second);
        }
        terms.fill(0.0);
        let mut smooth = vec![0.0; count];
        for (sample, weight) in [(&*sums, 2.0), (halves[0], -0.5), (halves[1], -0.5)] {
            let (counts, paths) = (&sample[..count], &sample[count..2 * count]);
            self.smoothing.apply(counts, &mut smooth);
            for (bin, (smooth, path)) in smooth.iter().zip(paths).enumerate() {
                let eta = packing_fraction(smooth / self.bins.volume()).clamp(0.0, 0.7);
                for (term, value) in Series::terms(eta).into_iter().enumerate() {
                    terms[term * count + bin] += weight * path * value;
                }
            }
        }
    }

    /// Clears all sums and starts an interval.
    pub(super) fn forget(&mut self) {
        self.frames = 0.0;
        self.counts.fill(0.0);
        self.sums.fill([0.0; 2]);
    }
}

impl Recorder for Collisions {
    #[inline]
    fn record_move(&mut self, accepted: &AcceptedMove) {
        let Some(axis) = accepted.chain_axis else { return };
        let middle = accepted.from_height + 0.5 * accepted.displacement.x;
        if let Place::Inside(bin, _) = self.bins.locate(middle) {
            self.sums[bin][0] += accepted.displacement[axis].abs();
        }
    }

    #[inline]
    fn record_collision(&mut self, collision: &Collision) {
        for height in [collision.from_height, collision.to_height] {
            if let Place::Inside(bin, _) = self.bins.locate(height) {
                self.sums[bin][1] += 0.5 * collision.separation;
            }
        }
    }

    fn wants_local_moves(&mut self) -> bool {
        false
    }
}

impl<'a> Means<'a> {
    pub(crate) fn of(sample: &'a [f64]) -> Self {
        let bins = sample.len() / (3 + MOST_TERMS);
        let (counts, rest) = sample.split_at(bins);
        let (paths, rest) = rest.split_at(bins);
        let (transfers, terms) = rest.split_at(bins);
        Self { counts, paths, transfers, terms }
    }

    /// The path of chains in a bin.
    pub(crate) fn path(&self, bin: usize) -> f64 {
        self.paths[bin]
    }

    /// Whether the packing fraction of a bin was below this value.
    pub(crate) fn is_below(&self, packing_fraction: f64, bin: usize) -> bool {
        self.terms[bin] < Series::terms(packing_fraction)[0] * self.paths[bin]
    }

    /// The coefficients of the [`Series`] with this number of terms that fits the collisions in the
    /// given bins best.
    pub(crate) fn fit(&self, some: impl Iterator<Item = usize>, terms: usize) -> Option<Vec<f64>> {
        let bins = self.counts.len();
        let row = |bin: usize| {
            let mut row = [0.0; MOST_TERMS];
            for (term, value) in row[..terms].iter_mut().enumerate() {
                *value = self.terms[term * bins + bin];
            }
            row
        };
        // An approximate Z is sufficient for weights.
        let rough = Series::new(&[4.0, -2.0]);
        let mut equations = LeastSquares::new(terms);
        // A bin whose smoothed density is zero gives no information about Z(η).
        for bin in some.filter(|&bin| self.terms[bin] > 0.0) {
            let row = row(bin);
            let eta = self.terms[bin] / self.paths[bin];
            // The packing fraction, approximately, from the mean x of the first term η/(1 − η)³.
            let factor = rough.compressibility_factor(eta.min(0.5) / (1.0 + 3.0 * eta.min(0.5)));
            // The sum of separations has the mean (Z − 1) times the path. Its variance grows with
            // the density, since neighbors stay the same longer in a dense fluid; measured: as η
            // Z².
            let variance = self.paths[bin] * eta * factor * factor;
            equations.add(&row[..terms], self.transfers[bin], 1.0 / variance);
        }
        equations.solve()
    }
}

persist!(Collisions { same bins, value frames, slice counts, slice sums });
