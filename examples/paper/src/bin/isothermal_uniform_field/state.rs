//! All columns of one temperature, pooled.

use super::column::Column;
use super::layers::Base;
use super::protocol::COLUMN_DENSITY;
use super::theory::Theory;
use gradient_mc::observers::{EquationOfStateProfile, RadialDistribution};
use gradient_mc::statistics::Estimate;
use gradient_mc::{Error, Merge};
use paper::{Failure, Side};

/// Results for the steady state at one temperature.
pub(crate) struct State<'a> {
    pub(crate) temperature: f64,
    pub(crate) columns: Vec<&'a Column>,
    pub(crate) theory: Theory,
    /// Over all columns, with the number of spheres times sweeps as weights.
    pub(crate) center_of_mass: Estimate,
    /// N/T² times the variance of `h_c`, which is its derivative by T exactly.
    pub(crate) response: Estimate,
    /// Of the widest columns.
    pub(crate) profile: EquationOfStateProfile,
    pub(crate) first_layer: RadialDistribution,
    /// By small local moves.
    pub(crate) base: Base,
    /// n(x) at the base by the moves that made the columns steady.
    pub(crate) base_by_own_moves: Vec<Estimate>,
}

impl<'a> State<'a> {
    pub(crate) fn new(temperature: f64, columns: &'a [Column]) -> Result<Self, Failure> {
        let columns: Vec<&Column> =
            columns.iter().filter(|column| column.task.temperature == temperature).collect();
        let widest = columns.iter().map(|column| column.task.width).fold(0.0, f64::max);
        let mut wide = columns.iter().filter(|column| column.task.width == widest);
        let first = wide.next().ok_or("a temperature without a column")?;
        let missing = "the layers of the widest columns are measured";
        let layers = first.layers.as_ref().ok_or(missing)?;
        let (mut profile, mut by_own_moves) = (first.profile.clone(), first.by_own_moves.clone());
        let (mut base, mut fine, mut first_layer) =
            (layers.base.observer.clone(), layers.fine.observer.clone(), layers.first_layer.observer.clone());
        for column in wide {
            let layers = column.layers.as_ref().ok_or(missing)?;
            profile.merge(&column.profile)?;
            by_own_moves.merge(&column.by_own_moves)?;
            base.merge(&layers.base.observer)?;
            fine.merge(&layers.fine.observer)?;
            first_layer.merge(&layers.first_layer.observer)?;
        }
        let response = pooled(columns.iter().copied(), |column| {
            let variance = column.steady().variance()?;
            let factor = column.task.particles() as f64 / (temperature * temperature);
            Ok(factor * variance)
        })?;
        Ok(Self {
            temperature,
            theory: Theory::new(temperature)?,
            center_of_mass: center_of_mass(columns.iter().copied())?,
            response,
            profile,
            first_layer,
            base: Base::new(&base, &fine)?,
            base_by_own_moves: by_own_moves.points()?.iter().map(|point| point.number_density).collect(),
            columns,
        })
    }

    /// Center of mass of the columns that came from one side; none if there are none.
    pub(crate) fn from(&self, side: Side) -> Option<Estimate> {
        center_of_mass(self.columns.iter().copied().filter(|column| column.task.side == side)).ok()
    }

    /// Center of mass of the columns over one base; none if there are none.
    pub(crate) fn over(&self, width: f64) -> Option<Estimate> {
        center_of_mass(self.columns.iter().copied().filter(|column| column.task.width == width)).ok()
    }

    /// Contact density by the contact theorem: weight over temperature.
    pub(crate) fn contact_density(&self) -> f64 {
        COLUMN_DENSITY / self.temperature
    }

    pub(crate) fn busy(&self) -> f64 {
        self.columns.iter().map(|column| column.busy).sum()
    }
}

fn center_of_mass<'a>(columns: impl Iterator<Item = &'a Column> + Clone) -> Result<Estimate, Failure> {
    pooled(columns, |column| column.steady().estimate())
}

/// The mean of estimates of independent columns.
fn pooled<'a>(
    columns: impl Iterator<Item = &'a Column> + Clone,
    estimate: impl Fn(&Column) -> Result<Estimate, Error>,
) -> Result<Estimate, Failure> {
    let total: f64 = columns.clone().map(Column::weight).sum();
    let (mut mean, mut squared) = (0.0, 0.0);
    for column in columns {
        let (weight, estimate) = (column.weight() / total, estimate(column)?);
        mean += weight * estimate.mean;
        squared += (weight * estimate.standard_error) * (weight * estimate.standard_error);
    }
    if total > 0.0 { Ok(Estimate::new(mean, squared.sqrt())) } else { Err("no such column".into()) }
}
