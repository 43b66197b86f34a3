//! The equation of state measured from the collisions of a run, used as a closure.

use super::MeasuredShare;
use crate::equation_of_state::{Coexistence, EquationOfState, FREEZING, FluidSolid, Series, SpeedySolid};
use crate::observers::equation_of_state_fit::{Collisions, Means};
use crate::{Frame, Recorder, Slab};
use std::ops::Range;

/// Z(η) measured in the steps of an iteration, from collisions and local paths of event chains.
///
/// Z = 1 + Σ cₖ ηᵏ/(1 − η)³ is fitted to all heights farther than four diameters from a wall where
/// the packing fraction is below freezing. Only local equilibrium is needed, so Z can be measured
/// in any field and before the column is stationary. The solid is not measured; Speedy's equation
/// is used.
#[derive(Debug, Clone)]
pub(super) struct OwnEquation {
    collisions: Collisions,
    bulk: Range<usize>,
    frames: u64,
    /// Samples of the halves of the interval; that of the first is complete after
    /// [`HALF`](Self::HALF) frames.
    first: Vec<f64>,
    second: Vec<f64>,
    means: Vec<f64>,
    /// Sums of the current step and, with less weight, of earlier steps.
    sums: Vec<f64>,
}

impl OwnEquation {
    /// Number of bins on either side over which densities are smoothed.
    const SMOOTHING: usize = 8;
    /// Number of frames of half an interval.
    const HALF: u64 = 64;
    /// Smallest path of chains for a fit, in diameters: Z then has a standard error of about 1 %.
    const LEAST_PATH: f64 = 1e4;
    /// Weight of all earlier steps in the next step.
    const KEPT: f64 = 0.5;

    /// `None` if the slab has no bulk, or if it is so high that there are too many bins.
    pub(super) fn new(slab: &Slab) -> Option<Self> {
        let collisions = Collisions::over(slab, Self::SMOOTHING).ok()?;
        let bulk = collisions.away_from_walls(slab, MeasuredShare::LAYERED);
        let [sample, means] =
            [collisions.components(), collisions.means()].map(|components| vec![0.0; components]);
        (!bulk.is_empty()).then(|| Self {
            collisions,
            bulk,
            frames: 0,
            first: sample.clone(),
            second: sample,
            means: means.clone(),
            sums: means,
        })
    }

    pub(super) fn add(&mut self, frame: &Frame<'_>) {
        self.collisions.observe(frame);
        self.frames += 1;
        if self.frames == Self::HALF {
            self.collisions.take(&mut self.first);
        } else if self.frames == 2 * Self::HALF {
            self.collisions.take(&mut self.second);
            self.collisions.complete([&self.first, &self.second], &mut self.means);
            self.enter(2.0);
            self.frames = 0;
        }
    }

    /// The recorder of single moves.
    pub(super) fn recorder(&mut self) -> &mut dyn Recorder {
        &mut self.collisions
    }

    /// Adds the means, over this number of samples, to the sums.
    fn enter(&mut self, samples: f64) {
        self.sums.iter_mut().zip(&self.means).for_each(|(sum, mean)| *sum += samples * mean);
    }

    /// Ends an incomplete interval, if there is one.
    fn end_interval(&mut self) {
        if self.frames >= Self::HALF {
            self.collisions.complete([&self.first; 2], &mut self.means);
            self.enter(1.0);
        }
        if !self.frames.is_multiple_of(Self::HALF) {
            self.collisions.take(&mut self.second);
            self.collisions.complete([&self.second; 2], &mut self.means);
            self.enter(1.0);
        }
        self.frames = 0;
    }

    /// The fit to the data so far, with this number of terms; `None` if there are too few data.
    pub(super) fn fit(&mut self, terms: usize) -> Option<Box<dyn EquationOfState>> {
        self.end_interval();
        let means = Means::of(&self.sums);
        let fluid = || self.bulk.clone().filter(|&bin| means.is_below(FREEZING, bin));
        if fluid().map(|bin| means.path(bin)).sum::<f64>() < Self::LEAST_PATH {
            return None;
        }
        let series = Series::new(&means.fit(fluid(), terms)?);
        let both = FluidSolid::new(series, SpeedySolid, Coexistence::default());
        // The pressure of coexistence is not reached by a fit to dilute data; then the fit alone is
        // used.
        Some(both.map_or_else(|_| Box::new(series) as Box<dyn EquationOfState>, |both| Box::new(both)))
    }

    /// Starts the next step.
    pub(super) fn next_step(&mut self) {
        self.end_interval();
        self.sums.iter_mut().for_each(|sum| *sum *= Self::KEPT);
    }
}

persist!(
    OwnEquation { part collisions, count frames, slice first, slice sums },
    |own| own.frames < 2 * OwnEquation::HALF
);
