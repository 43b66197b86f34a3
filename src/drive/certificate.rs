//! Whether the effective field was the right one: the balance of forces in a production run.

use super::MeasuredShare;
use super::column_average::WallContact;
use crate::frame::{Frame, Phase};
use crate::observer::{Observer, ObserverError};
use crate::scene::AnyScene;
use crate::statistics::{BlockAverages, Estimate, FEWEST_INDEPENDENT, drift, independent};
use crate::{Error, Merge, TemperatureProfile, Wall};
use std::fmt;

/// Both sides of the sum rule that the effective field must fulfil, recorded in the production run
/// of a mapped scene.
///
/// A run samples an isothermal system in the potential u. Its pressure over temperature at height x
/// is what its forces hold up, `P_iso(x)` = ∫ₓ n u' dx' + P(lid)/T(lid), for any u. The run stands
/// for the scene if this equals W(x)/T(x), the weight of the column over the temperature (eq. 24 of
/// doi:10.1103/PhysRevE.83.061306, exact for any n(x), also in the layers at a wall). Both sides
/// come from the same n(x) and need no equation of state. Both start from the pressure that the
/// field assumes at the [open end](crate::Scene::open_end) (the lid if the field pulls down), which
/// is compared with the contact density there. They are recorded every few sweeps at the edges of
/// bands one diameter high.
///
/// The test compares field and density. It does not show that the column is at rest: for that,
/// start from both sides. It does not resolve what happens within a band: a field passes that is
/// right on the average over each. Where T changes much within a band, P/n of narrow bins can be
/// off by more than 10 % in a run that is certified to 2 %.
#[derive(Debug, Clone)]
pub struct ForceBalance {
    base_area: f64,
    open_end: Wall,
    /// T at the edges of bands that are farther from the open end, and at the open end.
    temperatures: Vec<f64>,
    end_temperature: f64,
    lowest: f64,
    band_height: f64,
    certifiable: bool,
    /// Of the field, when production began.
    measured: Option<MeasuredShare>,
    /// Σ u' and Σ a over the spheres of each band; contact density at the open end and pressure
    /// assumed there, both times area; height of the center of mass and its square.
    sample: Vec<f64>,
    averages: BlockAverages,
    /// Drifts of merged replicas.
    replica_drifts: Vec<Estimate>,
}

impl ForceBalance {
    /// Bands are about one diameter high; there are at most so many.
    const MOST_BANDS: f64 = 4096.0;
    /// Heights that carry less than this part of the largest weight are not judged.
    const LEAST_LOAD: f64 = 0.05;
    /// A drift of more standard errors than this is no accident.
    const LARGEST_DRIFT: f64 = 4.0;
    /// Nor is a deviation above the tolerance of more than these.
    const SIGNIFICANT: f64 = 3.0;
    /// Fewer tell nothing about a drift.
    pub(super) const FEWEST_CONFIGURATIONS: u64 = 64;
    /// Configurations are recorded after every so many sweeps of production.
    pub(super) const SWEEPS_BETWEEN_RECORDS: u64 = 5;
    /// Fewest sweeps of production that can be judged.
    pub(crate) const FEWEST_SWEEPS: u64 = Self::FEWEST_CONFIGURATIONS * Self::SWEEPS_BETWEEN_RECORDS;

    /// Nothing yet. `certifiable` is whether the potential does not change with every
    /// configuration.
    pub(crate) fn new(scene: &AnyScene<'_>, certifiable: bool) -> Self {
        let (lowest, extent) = (scene.slab().lowest_center(), scene.slab().height() - 1.0);
        let bands = extent.round().clamp(1.0, Self::MOST_BANDS);
        let band_height = extent / bands;
        // At most 4096.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let bands = bands as usize;
        let temperature = |height: f64| scene.temperature().temperature(height);
        let components = 2 * bands + 4;
        let open_end = scene.open_end();
        let edge = |band| Self::edge(open_end, lowest, band_height, band);
        Self {
            open_end,
            base_area: scene.slab().base_area(),
            temperatures: (0..bands).map(|band| temperature(edge(band))).collect(),
            end_temperature: temperature(open_end.contact_height(scene.slab())),
            lowest,
            band_height,
            certifiable,
            measured: None,
            sample: vec![0.0; components],
            averages: BlockAverages::of(components),
            replica_drifts: Vec::new(),
        }
    }

    /// The edge of a band that is farther from the open end.
    fn edge(open_end: Wall, lowest: f64, band_height: f64, band: usize) -> f64 {
        let upper = f64::from(u8::from(open_end == Wall::Base));
        lowest + (band as f64 + upper) * band_height
    }

    /// Says how much was measured of the field in which production begins.
    pub(crate) fn set_measured_share(&mut self, measured: Option<MeasuredShare>) {
        self.measured = measured;
    }

    fn bands(&self) -> usize {
        self.temperatures.len()
    }

    /// Configurations recorded.
    #[must_use]
    pub fn observations(&self) -> u64 {
        self.averages.observations()
    }

    /// Heights, `P_iso` T/W there, and W over the largest W; upwards.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] below 16 configurations.
    pub fn ratios(&self) -> Result<Vec<ForceBalancePoint>, Error> {
        let bands = self.bands();
        let loads = |means: &[f64]| {
            let mut rows = vec![[0.0; 2]; bands];
            let at_end = means[2 * bands + 1];
            let (mut force, mut weight) = (at_end / self.end_temperature, at_end);
            let mut pass = |band: usize, sign: f64| {
                force += sign * means[band];
                weight += sign * means[bands + band];
                rows[band] = [force, weight];
            };
            match self.open_end {
                Wall::Lid => (0..bands).rev().for_each(|band| pass(band, 1.0)),
                Wall::Base => (0..bands).for_each(|band| pass(band, -1.0)),
            }
            rows
        };
        let weights: Vec<f64> = loads(&self.averages.mean()).into_iter().map(|[_, weight]| weight).collect();
        let largest = weights.iter().fold(0.0, |largest: f64, weight| largest.max(weight.abs()));
        let ratios = self.averages.jackknife(|means| {
            let rows = loads(means);
            let ratios = rows.iter().zip(&self.temperatures);
            ratios.map(|([force, weight], temperature)| force * temperature / weight).collect::<Vec<f64>>()
        })?;
        let points = ratios.into_iter().zip(weights).enumerate();
        Ok(points
            .map(|(band, (ratio, weight))| ForceBalancePoint {
                height: Self::edge(self.open_end, self.lowest, self.band_height, band),
                ratio,
                pressure: weight / self.base_area,
                load: weight.abs() / largest,
            })
            .collect())
    }

    /// Second half of the run minus first, of this replica.
    fn own_drift(&self) -> Result<Estimate, Error> {
        let center = 2 * self.bands() + 2;
        let own: Vec<f64> = self.averages.blocks().map(|block| block[center]).collect();
        drift(&own)
    }

    /// After so many configurations nothing is certified.
    fn too_few(configurations: u64) -> Error {
        Self::too_few_sweeps(configurations.saturating_mul(Self::SWEEPS_BETWEEN_RECORDS))
    }

    /// After so many sweeps nothing is certified.
    fn too_few_sweeps(sweeps: u64) -> Error {
        let number = |sweeps: u64| usize::try_from(sweeps).unwrap_or(usize::MAX);
        Error::TooFewObservations {
            what: "sweeps of production for a certificate",
            available: number(sweeps),
            needed: number(Self::FEWEST_SWEEPS),
        }
    }

    /// What the run says about the field it was made in.
    ///
    /// `tolerance` is the largest relative deviation of `P_iso` from W/T that is acceptable, at
    /// heights that carry at least 5 % of the largest weight.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] unless the tolerance lies between 0 and 1;
    /// [`Error::TooFewObservations`] below 320 sweeps of production, of which one in five is
    /// recorded.
    pub fn certificate(&self, tolerance: f64) -> Result<Certificate, Error> {
        let tolerance = Error::require_tolerance("tolerance of the balance of forces", tolerance)?;
        if self.observations() < Self::FEWEST_CONFIGURATIONS {
            return Err(Self::too_few(self.observations()));
        }
        let points = self.ratios()?;
        let judged = points.iter().filter(|point| point.load >= Self::LEAST_LOAD);
        let worst = judged.clone().fold(None, |worst: Option<&ForceBalancePoint>, point| match worst {
            // A deviation that is not a number is the worst.
            Some(worst) if worst.deviation().mean.abs() >= point.deviation().mean.abs() => Some(worst),
            Some(worst) if worst.deviation().mean.is_nan() => Some(worst),
            _ => Some(point),
        });
        let worst = worst.ok_or_else(|| Self::too_few(0))?;
        let largest_error = judged.fold(0.0, |largest, point| {
            let error = point.ratio.standard_error;
            if error.is_nan() || error > largest { error } else { largest }
        });
        let drift = if self.replica_drifts.is_empty() {
            self.own_drift()?
        } else {
            // Of all replicas, this one among them.
            let mut drifts = self.replica_drifts.clone();
            drifts.extend(self.own_drift().ok());
            let count = drifts.len() as f64;
            let squares = drifts.iter().map(|drift| drift.standard_error * drift.standard_error).sum::<f64>();
            Estimate::new(drifts.iter().map(|drift| drift.mean).sum::<f64>() / count, squares.sqrt() / count)
        };
        let center = 2 * self.bands() + 2;
        let (means, errors) = (self.averages.mean(), self.averages.standard_errors()?);
        let effective_sample_size = self.averages.independent([center]);
        let residual = worst.deviation();
        let heaviest = points.iter().map(|point| point.pressure.abs()).fold(0.0, f64::max) * self.base_area;
        let (contact, assumed) = (center - 2, center - 1);
        let open_end = Estimate::new(
            (means[contact] * self.end_temperature - means[assumed]) / heaviest,
            errors[contact] * self.end_temperature / heaviest,
        );
        let off = |deviation: Estimate| {
            deviation.mean.abs() > tolerance && deviation.deviation_from(0.0).abs() > Self::SIGNIFICANT
        };
        let convergence = if !self.certifiable {
            Convergence::NotConverged { residual, suggestion: Suggestion::FreezeTheField }
        } else if drift.deviation_from(0.0).abs() > Self::LARGEST_DRIFT {
            Convergence::NotConverged { residual, suggestion: Suggestion::EquilibrateLonger }
        } else if off(residual) || off(open_end) {
            Convergence::NotConverged { residual, suggestion: Suggestion::AdaptLonger }
        } else if residual.mean.abs() <= tolerance
            && largest_error <= 0.5 * tolerance
            && open_end.standard_error <= tolerance
        {
            Convergence::Converged { residual }
        } else {
            Convergence::NotConverged { residual, suggestion: Suggestion::MeasureLonger }
        };
        Ok(Certificate {
            convergence,
            height: worst.height,
            tolerance,
            resolution: self.band_height,
            largest_error,
            open_end,
            drift,
            effective_sample_size,
            measured: self.measured,
        })
    }
}

impl Observer for ForceBalance {
    /// Sees every fifth configuration of production, in the potential that it was made in.
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        if frame.phase() != Phase::Production
            || !(frame.sweep_of_phase() - 1).is_multiple_of(Self::SWEEPS_BETWEEN_RECORDS)
        {
            return Ok(());
        }
        if frame.sweep_of_phase() == 1 {
            // A potential that was changed has nothing to do with what was seen before.
            self.averages = BlockAverages::of(self.sample.len());
            self.replica_drifts.clear();
        }
        let (bands, field) = (self.bands(), frame.field());
        let end = self.open_end.contact_height(frame.slab());
        let mut contact = WallContact::default();
        let mut moment = 0.0;
        self.sample.fill(0.0);
        let (forces, weights) = self.sample.split_at_mut(bands);
        frame.for_each_height(|height| {
            // Heights are inside the slab.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let band = (((height - self.lowest) / self.band_height) as usize).min(bands - 1);
            forces[band] += frame.reduced_force(height);
            weights[band] += field.acceleration(height);
            contact.add((end - height).abs());
            moment += height;
        });
        let center = moment / frame.particles() as f64;
        let at_end = [contact.density_times_area(), frame.open_end_pressure() * self.base_area];
        self.sample[2 * bands..].copy_from_slice(&[at_end[0], at_end[1], center, center * center]);
        Ok(self.averages.push(&self.sample)?)
    }
}

persist!(ForceBalance { value measured, part averages, value replica_drifts });

impl Merge for ForceBalance {
    fn merge(&mut self, other: &Self) -> Result<(), Error> {
        self.averages.merge(&other.averages)?;
        self.replica_drifts.extend(other.own_drift().ok());
        self.replica_drifts.extend_from_slice(&other.replica_drifts);
        self.certifiable &= other.certifiable;
        self.measured = self.measured.zip(other.measured).map(|(own, other)| own.least(other));
        Ok(())
    }
}

/// Both sides of the sum rule at one height.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ForceBalancePoint {
    /// Height, in diameters.
    pub height: f64,
    /// `P_iso` T/W: what the forces hold up, over what weighs on it; 1 if the field is right.
    pub ratio: Estimate,
    /// Pressure P = W, in m g/d², from the weight and what the field assumes at the open end.
    pub pressure: f64,
    /// W over its largest value.
    pub load: f64,
}

impl ForceBalancePoint {
    /// `P_iso` T/W − 1.
    fn deviation(&self) -> Estimate {
        Estimate::new(self.ratio.mean - 1.0, self.ratio.standard_error)
    }
}

/// Whether a run at a temperature that varies can be trusted; see [`ForceBalance`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Certificate {
    /// The verdict.
    pub convergence: Convergence,
    /// Height at which the residual is largest, in diameters; NaN in an isothermal scene.
    pub height: f64,
    /// What was tolerated.
    pub tolerance: f64,
    /// Height of the bands, in diameters: NaN in an isothermal scene.
    pub resolution: f64,
    /// Largest standard error of the ratio at the heights that were judged.
    pub largest_error: f64,
    /// Pressure on the wall at the open end by the contact density less that which the field
    /// assumes, over the largest pressure.
    pub open_end: Estimate,
    /// Height of the center of mass, second half of the run minus first, in diameters.
    pub drift: Estimate,
    /// Number of independent configurations that would know the slowest quantity as well: of a run,
    /// as [`MixingEvidence::FewIndependent`](crate::MixingEvidence::FewIndependent) has it; of a
    /// merged record, the center of mass.
    pub effective_sample_size: f64,
    /// The measured share of the field; the rest is theory. `None` in an isothermal scene, or where
    /// the scheme does not say. The verdict does not use the theory. Of replicas, the least.
    pub measured: Option<MeasuredShare>,
}

/// The verdict of a [`Certificate`]. The residual is the largest `P_iso` T/W − 1 with its sign.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Convergence {
    /// The temperature is the same everywhere, and the column is at rest.
    Isothermal,
    /// Field and density belong to each other within the tolerance, known to half of it (the
    /// pressure at the open end: to all of it), and the column is at rest.
    #[non_exhaustive]
    Converged {
        /// Largest deviation.
        residual: Estimate,
    },
    /// They do not, or it cannot be told.
    #[non_exhaustive]
    NotConverged {
        /// Largest deviation.
        residual: Estimate,
        /// What to do.
        suggestion: Suggestion,
    },
}

/// What to do about a run that is not converged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Suggestion {
    /// The center of mass still moves.
    EquilibrateLonger,
    /// The field is not that of the density which it makes: it was frozen too early.
    AdaptLonger,
    /// The error bars are too large to tell.
    MeasureLonger,
    /// The run has not mixed: its error bars may be too small.
    MixLonger,
    /// The field changes with every configuration: nothing can be certified.
    FreezeTheField,
}

impl fmt::Display for Suggestion {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::EquilibrateLonger => "the column still moves: equilibrate longer",
            Self::AdaptLonger => {
                "the field is not that of the density it makes: equilibrate longer before it is frozen"
            }
            Self::MeasureLonger => "the errors are too large to tell: measure longer",
            Self::MixLonger => "not mixed, known as from too few independent configurations: run longer",
            Self::FreezeTheField => {
                "the field follows every configuration, which breaks detailed balance: take a scheme that freezes it"
            }
        })
    }
}

impl Certificate {
    /// That of a run at one temperature, from the heights of its center of mass: is it at rest?
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] for a tolerance that is not positive and finite;
    /// [`Error::TooFewObservations`].
    pub(crate) fn isothermal(centers: &[f64], sweeps: u64, tolerance: f64) -> Result<Self, Error> {
        let tolerance = Error::require_tolerance("tolerance of the balance of forces", tolerance)?;
        if sweeps < ForceBalance::FEWEST_SWEEPS {
            return Err(ForceBalance::too_few_sweeps(sweeps));
        }
        let drift = drift(centers)?;
        let exact = Estimate::new(0.0, 0.0);
        let convergence = if drift.deviation_from(0.0).abs() > ForceBalance::LARGEST_DRIFT {
            let suggestion = Suggestion::EquilibrateLonger;
            Convergence::NotConverged { residual: exact, suggestion }
        } else {
            Convergence::Isothermal
        };
        Ok(Self {
            convergence,
            height: f64::NAN,
            tolerance,
            resolution: f64::NAN,
            largest_error: 0.0,
            open_end: exact,
            drift,
            effective_sample_size: independent(&[centers]),
            measured: None,
        })
    }

    /// Not converged if the slowest quantity of the run has seen too few independent
    /// configurations.
    pub(crate) fn mixed(mut self, independent: f64) -> Self {
        self.effective_sample_size = self.effective_sample_size.min(independent);
        if self.is_converged() && self.effective_sample_size < FEWEST_INDEPENDENT {
            let (residual, suggestion) = (self.residual(), Suggestion::MixLonger);
            self.convergence = Convergence::NotConverged { residual, suggestion };
        }
        self
    }

    /// Whether the run is converged.
    #[must_use]
    pub fn is_converged(&self) -> bool {
        matches!(self.convergence, Convergence::Converged { .. } | Convergence::Isothermal)
    }

    /// The largest `P_iso` T/W − 1.
    #[must_use]
    pub fn residual(&self) -> Estimate {
        match self.convergence {
            Convergence::Converged { residual } | Convergence::NotConverged { residual, .. } => residual,
            Convergence::Isothermal => Estimate::new(0.0, 0.0),
        }
    }
}

/// An estimate in per cent, without the sign and the digits of rounding.
fn percent(estimate: Estimate) -> String {
    const ROUNDING: f64 = 1e-10;
    let Estimate { mean, standard_error } = estimate;
    if mean.abs() < ROUNDING && standard_error < ROUNDING {
        return "0".to_owned();
    }
    Estimate::new(100.0 * mean, 100.0 * standard_error).to_string()
}

/// One line: the verdict with its numbers.
impl fmt::Display for Certificate {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { height, tolerance, resolution, drift, effective_sample_size, .. } = self;
        match self.convergence {
            Convergence::Converged { .. } => write!(formatter, "converged")?,
            Convergence::Isothermal => write!(formatter, "isothermal, at rest")?,
            Convergence::NotConverged { suggestion, .. } => {
                write!(formatter, "NOT CONVERGED ({suggestion})")?;
            }
        }
        if height.is_nan() {
            return write!(
                formatter,
                ": drift of h_c {drift}, effective sample size {effective_sample_size:.0}"
            );
        }
        let percent = percent(self.residual());
        write!(
            formatter,
            ": forces differ from the weight above by {percent} % at height {height:.1} (tolerance \
             {:.2} %, in bands {resolution:.1} high), drift of h_c {drift}, effective sample size {effective_sample_size:.0}",
            100.0 * tolerance,
        )?;
        self.measured.map_or(Ok(()), |measured| write!(formatter, "; measured part of the field: {measured}"))
    }
}
