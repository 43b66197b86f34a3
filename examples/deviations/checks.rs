//! What Figure 17 claims, and the numbers that decide it.

use super::case::Case;
use super::outcome::{Analysis, Outcome};
use crate::common::verdict::Verdicts;
use gradient_mc::statistics::Estimate;

/// The paper's dotted line.
pub(crate) const LINE: f64 = 0.02;
/// Below this packing fraction few spheres are in a bin, and the paper's own σ is above the line.
pub(crate) const FEW: f64 = 0.03;
/// Standard errors that a number may be off.
const SIGMAS: f64 = 4.0;
/// Largest error of a mean over a group of heights.
const LARGEST_ERROR: f64 = 0.01;
/// Up to here the paper's field is compared: well below the maximum of the density.
const LOW: f64 = 16.0;

pub(crate) fn verdicts(outcomes: &[Outcome]) -> Verdicts {
    let mut verdicts = Verdicts::new();
    for outcome in outcomes {
        ours(&outcome.case, &outcome.ours, &mut verdicts);
        for (name, analysis) in &outcome.papers {
            papers(&outcome.case, name, analysis, &mut verdicts);
        }
    }
    verdicts
}

fn exact(value: f64) -> Estimate {
    Estimate::new(value, 0.0)
}

fn ours(case: &Case, ours: &Analysis, verdicts: &mut Verdicts) {
    let (panel, label) = (case.panel, case.label());
    for (name, deviations) in
        [("Carnahan-Starling", &ours.carnahan_starling), ("modified Kolafa", &ours.modified_kolafa)]
    {
        let largest = Analysis::largest(deviations);
        let claim =
            format!("{label}: largest |P/(nTZ) − 1| of {} ranges of height, {name}", deviations.len());
        verdicts.at_most(panel, &claim, Estimate::new(largest.mean.abs(), largest.standard_error), LINE);
    }
    let claim = format!("{label}: the largest of these in standard errors, modified Kolafa");
    verdicts.at_most(panel, &claim, exact(Analysis::most_significant(&ours.modified_kolafa)), SIGMAS);
    let errors = ours.modified_kolafa.iter().map(|deviation| deviation.standard_error);
    let claim = format!("{label}: the largest standard error");
    verdicts.at_most(panel, &claim, exact(errors.fold(0.0, f64::max)), LARGEST_ERROR);
    // In so short a run δ of a bin of 0.1 d is counting noise: of the spheres in it, times d ln P/d ln n.
    let claim = format!("{label}: median of δ (33) in bins of 0.1 d");
    verdicts.at_most(panel, &claim, exact(ours.median(|point| point.deviation)), LINE);
    let claim = format!("{label}: number of these bins where δ is above 2 % by more than four of its errors");
    let count = ours.significantly_above(LINE, SIGMAS);
    verdicts.at_most(panel, &claim, exact(count as f64), 0.0);
    let claim = format!("{label}: part of these bins, packing fraction above {FEW}, with σ (32) below 2 %");
    verdicts.at_least(panel, &claim, exact(ours.part_below(LINE, FEW, |point| point.scatter)), 0.99);
}

fn papers(case: &Case, name: &str, analysis: &Analysis, verdicts: &mut Verdicts) {
    let label = case.label();
    if case.decay_rate > 0.0 {
        let mean = Analysis::mean_below(case, &analysis.carnahan_starling, LOW);
        // The paper has up to 7 % there; counting noise must make 8.2 % at x = 10 and 5.4 % at x = 18.
        let claim = format!("{label}, {name}: mean P/(nTZ) − 1 below x = {LOW}: the paper's 7 %");
        verdicts.between(case.panel, &claim, mean, 0.05, 0.11);
    } else {
        let part = analysis.part_below(LINE, FEW, |point| point.deviation);
        let claim = format!("{label}, {name}: part of the bins with δ below 2 %");
        verdicts.at_least(case.panel, &claim, exact(part), 0.99);
    }
}
