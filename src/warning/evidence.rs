//! The observations behind warnings about replicas and mixing.

use crate::statistics::{Estimate, FEWEST_INDEPENDENT};
use std::fmt;

/// The quantity in which merged replicas differ; part of
/// [`Warning::ReplicasDisagree`](super::Warning::ReplicasDisagree).
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Disagreement {
    /// The mean height of the center of mass.
    #[non_exhaustive]
    CenterOfMass {
        /// Lowest mean height of a replica.
        lowest: f64,
        /// Highest mean height of a replica.
        highest: f64,
    },
    /// The counts in some bins of a profile.
    #[non_exhaustive]
    Bins {
        /// Number of such bins.
        bins: usize,
        /// Middle of the lowest of these bins.
        lowest_height: f64,
        /// Middle of the highest of these bins.
        highest_height: f64,
    },
}

impl fmt::Display for Disagreement {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::CenterOfMass { lowest, highest } => {
                write!(
                    formatter,
                    "the mean heights of their centers of mass range from {lowest:.3} to {highest:.3}"
                )
            }
            Self::Bins { bins, lowest_height, highest_height } => {
                write!(
                    formatter,
                    "they differ in {bins} bins between heights {lowest_height:.2} and {highest_height:.2}"
                )
            }
        }
    }
}

/// The part of a column whose autocorrelation time is judged; part of
/// [`MixingEvidence::FewIndependent`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Quantity {
    /// The whole column: the height of the center of mass, and the numbers of spheres below two
    /// heights.
    Column,
    /// The layers at the base: the numbers of spheres in the first layer and in the lowest two
    /// diameters.
    Base,
}

impl fmt::Display for Quantity {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Column => "the column",
            Self::Base => "the layers at the base",
        })
    }
}

/// The observation that shows that a run is not mixed; part of
/// [`Warning::NotMixed`](super::Warning::NotMixed).
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum MixingEvidence {
    /// The mean height of the center of mass changes during production.
    #[non_exhaustive]
    Drift {
        /// Mean height in the second half of production minus that in the first half.
        drift: Estimate,
    },
    /// The center of mass is far from its later mean height at the beginning of production.
    #[non_exhaustive]
    Relaxing {
        /// Mean height in the first eighth of production minus that in the second half.
        shift: Estimate,
    },
    /// The slowest quantity has an effective number of independent configurations below 2.5.
    #[non_exhaustive]
    FewIndependent {
        /// The part of the column that is slowest.
        quantity: Quantity,
        /// Effective number of independent configurations.
        effective_sample_size: f64,
    },
    /// The height of the center of mass fluctuates less than in equilibrium.
    #[non_exhaustive]
    TooQuiet {
        /// Variance of the height in production, in square diameters.
        variance: f64,
        /// Variance in equilibrium, by a sum rule.
        required: f64,
    },
}

impl fmt::Display for MixingEvidence {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Drift { drift } => {
                write!(
                    formatter,
                    "the mean height of the center of mass changes by {drift} from the first half of production to the second"
                )
            }
            Self::Relaxing { shift } => write!(
                formatter,
                "the start still relaxes: the mean height of the center of mass is larger by {shift} in the first eighth of \
                production than in the second half"
            ),
            Self::FewIndependent { quantity, effective_sample_size } => {
                let number = effective_sample_size;
                write!(
                    formatter,
                    "the effective number of independent configurations of {quantity} is only {number:.1}, at least {FEWEST_INDEPENDENT} are needed"
                )
            }
            Self::TooQuiet { variance, required } => write!(
                formatter,
                "the variance of the height of the center of mass is {variance:.2e}, but {required:.2e} in equilibrium"
            ),
        }
    }
}
