//! What all runs of one column come to.

use super::column::Column;
use super::maximum::{self, Maximum};
use super::rows::{self, Row, rows};
use super::run::{BIN, Measured};
use gradient_mc::Merge;
use gradient_mc::drive::Certificate;
use gradient_mc::equation_of_state::ModifiedKolafa;
use gradient_mc::observers::{BinState, CenterOfMass, DisplacementPoint};
use gradient_mc::statistics::Estimate;
use paper::{Failure, Side, warnings};

/// What the certificates tolerate.
const TOLERANCE: f64 = 0.02;
/// Densities between which the dilute top is compared with the ideal-gas law.
pub(crate) const DILUTE: [f64; 2] = [3e-4, 1e-2];

/// A column with what was measured of it.
#[derive(Debug, Clone)]
pub(crate) struct Outcome {
    pub(crate) column: Column,
    pub(crate) rows: Vec<Row>,
    /// Wider ranges, above the layers, for the equation of state.
    pub(crate) states: Vec<Row>,
    pub(crate) mobility: Vec<DisplacementPoint>,
    pub(crate) center_of_mass: Estimate,
    /// From above less from below, if there were both.
    pub(crate) difference_of_sides: Option<Estimate>,
    pub(crate) maximum: Option<Maximum>,
    /// n over that of the theory, minus 1, in each group of heights.
    pub(crate) densities: Vec<Estimate>,
    /// P/(nTZ) − 1 in each group of heights.
    pub(crate) deviations: Vec<Estimate>,
    /// Spheres in the dilute top over those of the ideal-gas law and over those of the theory.
    pub(crate) dilute: [Estimate; 2],
    pub(crate) certificate: Certificate,
    /// Warnings about the runs.
    pub(crate) warnings: Vec<String>,
}

impl Outcome {
    pub(crate) fn new(column: &Column, runs: &[Measured]) -> Result<Self, Failure> {
        let (first, rest) = runs.split_first().ok_or("nothing was measured")?;
        let mut all = first.clone();
        for run in rest {
            all.merge(run)?;
        }
        let profile = &all.profile;
        let densities = profile.jackknife(|states| {
            let ratio = |&[low, high]: &[f64; 2]| {
                ratio(states, [low, high], |height| column.theory.number_density(height))
            };
            column.groups.iter().map(ratio).map(|ratio| ratio - 1.0).collect::<Vec<f64>>()
        })?;
        let dilute = profile.jackknife(|states| {
            let range = [column.height_of_density(DILUTE[1]), column.height_of_density(DILUTE[0])];
            [
                ratio(states, range, |x| column.ideal_gas(x)),
                ratio(states, range, |x| column.theory.number_density(x)),
            ]
        })?;
        let highest = column.height_of_density(1e-5).min(super::column::HEIGHT - 1.5);
        Ok(Self {
            rows: rows(profile, &rows::fine(highest))?,
            states: rows(profile, &rows::coarse(highest))?,
            mobility: all.mobility.points()?,
            center_of_mass: center_of_mass(runs, None)?.ok_or("nothing was measured")?,
            difference_of_sides: difference(runs)?,
            maximum: maximum::find(column, profile)?,
            densities,
            deviations: profile.deviations_over(&column.groups, &ModifiedKolafa)?,
            dilute: [dilute[0], dilute[1]],
            certificate: all.balance.certificate(TOLERANCE)?,
            warnings: warnings::lines(runs.iter().map(|run| &run.warnings[..])),
            column: column.clone(),
        })
    }
}

/// Spheres in a range of heights over those of a density, which is averaged over each bin by
/// Simpson's rule.
fn ratio(states: &[BinState], [low, high]: [f64; 2], density: impl Fn(f64) -> f64) -> f64 {
    let mean = |x: f64| (density(x - 0.5 * BIN) + 4.0 * density(x) + density(x + 0.5 * BIN)) / 6.0;
    let inside = states.iter().filter(|state| (low..high).contains(&state.height));
    let (measured, expected) = inside.fold((0.0, 0.0), |(measured, expected), state| {
        (measured + state.number_density, expected + mean(state.height))
    });
    measured / expected
}

/// Of all runs, or of those from one side.
fn center_of_mass(runs: &[Measured], side: Option<Side>) -> Result<Option<Estimate>, Failure> {
    let mut pooled: Option<CenterOfMass> = None;
    for run in runs.iter().filter(|run| side.is_none_or(|side| side == run.side)) {
        match &mut pooled {
            None => pooled = Some(run.center_of_mass.clone()),
            Some(pooled) => pooled.merge(&run.center_of_mass)?,
        }
    }
    Ok(pooled.map(|pooled| pooled.estimate()).transpose()?)
}

fn difference(runs: &[Measured]) -> Result<Option<Estimate>, Failure> {
    let above = center_of_mass(runs, Some(Side::Above))?;
    let below = center_of_mass(runs, Some(Side::Below))?;
    Ok(above.zip(below).map(|(above, below)| above.minus_independent(below)))
}
