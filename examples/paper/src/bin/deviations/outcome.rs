//! A column of Figure 17 with all that was measured of it.

use super::case::Case;
use super::papers::{PaperPoint, measures};
use gradient_mc::Merge;
use gradient_mc::equation_of_state::{CarnahanStarling, ModifiedKolafa};
use gradient_mc::observers::EquationOfStateProfile;
use gradient_mc::statistics::{Estimate, mean_of_replicas};
use paper::Failure;
use paper::accuracy::median;
use paper::groups::{largest, mean_of_correlated};

/// Runs that were made alike, as eq. (32) takes them, with both analyses.
#[derive(Debug, Clone)]
pub(crate) struct Analysis {
    /// The paper's.
    pub(crate) points: Vec<PaperPoint>,
    /// P/(nTZ) − 1 in each group of heights, Carnahan-Starling.
    pub(crate) carnahan_starling: Vec<Estimate>,
    /// The same, modified Kolafa-Labík-Malijevský.
    pub(crate) modified_kolafa: Vec<Estimate>,
}

impl Analysis {
    pub(crate) fn new(case: &Case, runs: &[EquationOfStateProfile]) -> Result<Self, Failure> {
        let (first, rest) = runs.split_first().ok_or("no runs")?;
        let mut all = first.clone();
        for run in rest {
            all.merge(run)?;
        }
        Ok(Self {
            points: measures(case, runs, &all)?,
            carnahan_starling: all.deviations_over(&case.groups, &CarnahanStarling)?,
            modified_kolafa: all.deviations_over(&case.groups, &ModifiedKolafa)?,
        })
    }

    /// The largest deviation in standard errors.
    pub(crate) fn most_significant(deviations: &[Estimate]) -> f64 {
        largest(deviations.iter().map(|deviation| deviation.deviation_from(0.0).abs()))
    }

    /// Part of the paper's bins with packing fractions above `least` where a measure stays below
    /// `line`.
    pub(crate) fn part_below(&self, line: f64, least: f64, measure: impl Fn(&PaperPoint) -> f64) -> f64 {
        let bins = || self.points.iter().filter(|point| point.packing_fraction > least);
        let below = bins().filter(|point| measure(point) < line).count();
        below as f64 / bins().count() as f64
    }

    /// Number of the paper's bins where δ is above `line` by more than so many of its standard
    /// errors.
    pub(crate) fn significantly_above(&self, line: f64, standard_errors: f64) -> usize {
        let above = |point: &&PaperPoint| point.deviation - line > standard_errors * point.deviation_error;
        self.points.iter().filter(above).count()
    }

    /// The median of a measure over the paper's bins.
    pub(crate) fn median(&self, measure: impl Fn(&PaperPoint) -> f64) -> f64 {
        median(self.points.iter().map(measure).collect())
    }

    /// Mean over the groups whose middles lie below `highest`, which move together.
    pub(crate) fn mean_below(case: &Case, deviations: &[Estimate], highest: f64) -> Estimate {
        let inside = case.groups.iter().zip(deviations);
        let inside = inside.filter(|(group, _)| f64::midpoint(group[0], group[1]) < highest);
        mean_of_correlated(inside.map(|(_, deviation)| *deviation))
    }
}

/// Everything of one column.
#[derive(Debug, Clone)]
pub(crate) struct Outcome {
    pub(crate) case: Case,
    /// P/(nTZ) − 1 in each group that a local equation must miss, to lowest order in the density.
    pub(crate) nonlocal: Vec<f64>,
    pub(crate) ours: Analysis,
    /// Runs as the paper made them.
    pub(crate) papers: Vec<Papers>,
}

/// Runs as the paper made them, from one start.
#[derive(Debug, Clone)]
pub(crate) struct Papers {
    pub(crate) name: &'static str,
    pub(crate) first: Analysis,
    pub(crate) others: Vec<Analysis>,
}

impl Papers {
    /// Mean over runs. Its error is from their scatter, if there are several: their memory is
    /// longer than an interval.
    pub(crate) fn mean(&self, of: impl Fn(&Analysis) -> Estimate) -> Estimate {
        let first = of(&self.first);
        let others = self.others.iter().map(|run| of(run).mean);
        let means: Vec<f64> = std::iter::once(first.mean).chain(others).collect();
        mean_of_replicas(&means).unwrap_or(first)
    }
}
