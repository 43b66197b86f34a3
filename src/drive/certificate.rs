//! Checks whether the effective field is self-consistent: the balance of forces in production.

use super::MeasuredShare;
use super::column_average::WallContact;
use crate::frame::{Frame, Phase};
use crate::observer::{Observer, ObserverError};
use crate::scene::AnyScene;
use crate::statistics::{BlockAverages, Estimate, FEWEST_INDEPENDENT, drift, independent};
use crate::{Error, Merge, TemperatureProfile, Wall};
use std::fmt;

/// Balance of forces: both sides of the sum rule that a self-consistent effective field fulfills,
/// recorded in production if the temperature varies.
///
/// A run samples an isothermal system in the reduced potential u. For any u its pressure over
/// temperature at height x is held up by the forces of the effective field, `P_iso(x)` = ∫ₓ n u'
/// dx' + P(lid)/T(lid). The field is self-consistent if `P_iso` equals W/T, where W(x) is the
/// pressure from the weight of the column above x (eq. 24 of doi:10.1103/PhysRevE.83.061306, exact
/// for any n(x), also in the layers at a wall). The ratio `P_iso` T/W is 1 then. Both sides come
/// from the same n(x), without an equation of state. Both start from the pressure that the field
/// assumes at the [open end](crate::Scene::open_end) (the lid if the field pulls down); this
/// pressure is compared with the contact density there. Both are recorded every five sweeps, at the
/// edges of bands one diameter high.
///
/// The test compares field and density. It does not prove that the column is stationary: for that,
/// compare runs from a dense and a dilute start. It does not resolve heights within a band, but
/// only averages over each. If T changes much within a band, P/n of narrow bins may be off by more
/// than 10 % in a run that is converged to 2 %.
#[derive(Debug, Clone)]
pub struct ForceBalance {
    base_area: f64,
    open_end: Wall,
    /// T at the edge of each band that is farther from the open end.
    temperatures: Vec<f64>,
    end_temperature: f64,
    lowest: f64,
    band_height: f64,
    certifiable: bool,
    /// Measured part of the field at the start of production.
    measured: Option<MeasuredShare>,
    /// One sample: Σ u' and Σ a over the spheres of each band; contact density at the open end and
    /// pressure assumed there, both times area; height of the center of mass and its square.
    sample: Vec<f64>,
    averages: BlockAverages,
    replica_drifts: Vec<Estimate>,
}

impl ForceBalance {
    /// Largest number of bands; their height is about one diameter.
    const MOST_BANDS: f64 = 4096.0;
    /// Heights with a smaller part of the largest weight are not judged.
    const LEAST_LOAD: f64 = 0.05;
    /// A drift is significant above this number of standard errors.
    const LARGEST_DRIFT: f64 = 4.0;
    /// A deviation above the tolerance is significant above this number of standard errors.
    const SIGNIFICANT: f64 = 3.0;
    /// Smallest number of configurations from which a drift is judged.
    pub(super) const FEWEST_CONFIGURATIONS: u64 = 64;
    /// Sweeps of production between two records.
    pub(super) const SWEEPS_BETWEEN_RECORDS: u64 = 5;
    /// Smallest number of sweeps of production that can be judged.
    pub(crate) const FEWEST_SWEEPS: u64 = Self::FEWEST_CONFIGURATIONS * Self::SWEEPS_BETWEEN_RECORDS;

    /// Empty records. `certifiable` is false if the potential changes with every configuration.
    pub(crate) fn new(scene: &AnyScene<'_>, certifiable: bool) -> Self {
        let (lowest, extent) = (scene.slab().lowest_center(), scene.slab().height() - 1.0);
        let bands = extent.round().clamp(1.0, Self::MOST_BANDS);
        let band_height = extent / bands;
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

    /// Sets the measured part of the field at the start of production.
    pub(crate) fn set_measured_share(&mut self, measured: Option<MeasuredShare>) {
        self.measured = measured;
    }

    fn bands(&self) -> usize {
        self.temperatures.len()
    }

    /// Number of configurations recorded.
    #[must_use]
    pub fn observations(&self) -> u64 {
        self.averages.observations()
    }

    /// The ratio `P_iso` T/W and the pressure at the edges of all bands, upwards.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] for fewer than 16 configurations.
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

    /// Mean height of the center of mass in the second half minus the first half, of this replica.
    fn own_drift(&self) -> Result<Estimate, Error> {
        let center = 2 * self.bands() + 2;
        let own: Vec<f64> = self.averages.blocks().map(|block| block[center]).collect();
        drift(&own)
    }

    fn too_few(configurations: u64) -> Error {
        Self::too_few_sweeps(configurations.saturating_mul(Self::SWEEPS_BETWEEN_RECORDS))
    }

    fn too_few_sweeps(sweeps: u64) -> Error {
        let number = |sweeps: u64| usize::try_from(sweeps).unwrap_or(usize::MAX);
        Error::TooFewObservations {
            what: "sweeps of production for a certificate",
            available: number(sweeps),
            needed: number(Self::FEWEST_SWEEPS),
        }
    }

    /// Judges whether the effective field is self-consistent and the column stationary.
    ///
    /// `tolerance` is the largest acceptable value of |`P_iso` T/W − 1|, at heights where W is at
    /// least 5 % of its largest value.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] if the tolerance is not between 0 and 1;
    /// [`Error::TooFewObservations`] for fewer than 320 sweeps of production.
    pub fn certificate(&self, tolerance: f64) -> Result<Certificate, Error> {
        let tolerance = Error::require_tolerance("tolerance of the balance of forces", tolerance)?;
        if self.observations() < Self::FEWEST_CONFIGURATIONS {
            return Err(Self::too_few(self.observations()));
        }
        let points = self.ratios()?;
        let judged = points.iter().filter(|point| point.load >= Self::LEAST_LOAD);
        let worst = judged.clone().fold(None, |worst: Option<&ForceBalancePoint>, point| match worst {
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
    /// Samples every fifth configuration of production.
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        if frame.phase() != Phase::Production
            || !(frame.sweep_of_phase() - 1).is_multiple_of(Self::SWEEPS_BETWEEN_RECORDS)
        {
            return Ok(());
        }
        if frame.sweep_of_phase() == 1 {
            // The potential may have changed, so earlier records are dropped.
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
    /// `P_iso` T/W: pressure held up by the forces of the effective field, over the weight of the
    /// column; 1 if the field is right.
    pub ratio: Estimate,
    /// Pressure P = W, in m g/d²: the weight per area of the spheres between this height and the
    /// open end, plus the pressure that the field assumes there.
    pub pressure: f64,
    /// W over its largest value, from 0 to 1.
    pub load: f64,
}

impl ForceBalancePoint {
    /// `P_iso` T/W − 1.
    fn deviation(&self) -> Estimate {
        Estimate::new(self.ratio.mean - 1.0, self.ratio.standard_error)
    }
}

/// Result of the check whether the effective field of a run is self-consistent; see
/// [`ForceBalance`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Certificate {
    /// Whether the run is converged, and what to do if it is not.
    pub convergence: Convergence,
    /// Height at which the residual is largest, in diameters; NaN in an isothermal scene.
    pub height: f64,
    /// Tolerance of |`P_iso` T/W − 1|.
    pub tolerance: f64,
    /// Height of the bands, in diameters; NaN in an isothermal scene.
    pub resolution: f64,
    /// Largest standard error of `P_iso` T/W at the heights that were judged.
    pub largest_error: f64,
    /// Pressure on the wall at the open end from the contact density, minus the pressure that the
    /// field assumes there, over the largest pressure.
    pub open_end: Estimate,
    /// Mean height of the center of mass in the second half of production minus that in the first
    /// half, in diameters.
    pub drift: Estimate,
    /// Effective number of independent configurations: of the slowest quantity of a run, as in
    /// [`MixingEvidence::FewIndependent`](crate::MixingEvidence::FewIndependent); of the center of
    /// mass in merged records.
    pub effective_sample_size: f64,
    /// The measured part of the field; the rest is theory. `None` in an isothermal scene, or if the
    /// scheme does not report it. Of merged replicas, the smallest part.
    pub measured: Option<MeasuredShare>,
}

/// Whether a run is converged; part of a [`Certificate`]. The residual is the value of `P_iso` T/W
/// − 1 with the largest magnitude: pressure held up by the forces of the effective field, over the
/// weight of the column, minus 1.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Convergence {
    /// The scene is isothermal and the column stationary.
    Isothermal,
    /// The residual is within the tolerance, its standard error below half of it (that of the
    /// pressure at the open end: below all of it), and the column is stationary.
    #[non_exhaustive]
    Converged {
        /// `P_iso` T/W − 1 with the largest magnitude.
        residual: Estimate,
    },
    /// The field is not self-consistent within the tolerance, or the run is too short to decide.
    #[non_exhaustive]
    NotConverged {
        /// `P_iso` T/W − 1 with the largest magnitude.
        residual: Estimate,
        /// The reason, and what to do.
        suggestion: Suggestion,
    },
}

/// Why a run is not converged, and what to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Suggestion {
    /// The mean height of the center of mass still changes: equilibrate longer.
    EquilibrateLonger,
    /// The field is not self-consistent, because it was frozen too early: equilibrate longer.
    AdaptLonger,
    /// The standard errors are too large to decide: run longer.
    MeasureLonger,
    /// The effective number of independent configurations is too small, so standard errors may be
    /// too small: run longer.
    MixLonger,
    /// The field changes with every configuration, so it is never converged: use another scheme.
    FreezeTheField,
}

impl fmt::Display for Suggestion {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::EquilibrateLonger => "the center of mass still drifts: equilibrate longer",
            Self::AdaptLonger => {
                "the effective field is not self-consistent: equilibrate longer before production"
            }
            Self::MeasureLonger => "the standard errors are too large to decide: run longer",
            Self::MixLonger => "the effective number of independent configurations is too small: run longer",
            Self::FreezeTheField => {
                "the field changes with every configuration, which breaks detailed balance: use a scheme that freezes it"
            }
        })
    }
}

impl Certificate {
    /// Certificate of an isothermal run, from the series of the height of its center of mass:
    /// whether the column is stationary.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] if the tolerance is not between 0 and 1;
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

    /// Not converged if the effective number of `independent` configurations is too small.
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

    /// `P_iso` T/W − 1 with the largest magnitude.
    #[must_use]
    pub fn residual(&self) -> Estimate {
        match self.convergence {
            Convergence::Converged { residual } | Convergence::NotConverged { residual, .. } => residual,
            Convergence::Isothermal => Estimate::new(0.0, 0.0),
        }
    }
}

/// An estimate in per cent; 0 if it is only rounding.
fn percent(estimate: Estimate) -> String {
    const ROUNDING: f64 = 1e-10;
    let Estimate { mean, standard_error } = estimate;
    if mean.abs() < ROUNDING && standard_error < ROUNDING {
        return "0".to_owned();
    }
    Estimate::new(100.0 * mean, 100.0 * standard_error).to_string()
}

/// One line: the result with its numbers.
impl fmt::Display for Certificate {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { height, tolerance, resolution, drift, effective_sample_size, .. } = self;
        match self.convergence {
            Convergence::Converged { .. } => write!(formatter, "converged")?,
            Convergence::Isothermal => write!(formatter, "isothermal, stationary")?,
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
            ": P_iso T/W - 1 = {percent} % at height {height:.1} (pressure held up by the forces of the effective field, over the \
            weight of the column, minus 1; tolerance {:.2} %, bands {resolution:.1} high), drift of h_c {drift}, effective sample size \
            {effective_sample_size:.0}",
            100.0 * tolerance,
        )?;
        self.measured.map_or(Ok(()), |measured| write!(formatter, "; measured part of the field: {measured}"))
    }
}
