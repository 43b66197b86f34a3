//! The part of an effective field that was measured.

use crate::Warning;
use std::fmt;

/// The part of an effective field that was measured, from 0 to 1; the rest comes from theory.
///
/// A scheme combines a measurement of P/n with a theory, with a weight between 0 and 1 for the
/// measurement at every height. The fields are the means of this weight over spheres: for the
/// layers within four diameters of a wall, which the theory does not describe, and for the bulk,
/// where the theory is accurate to about 0.2 %. In the bulk a closure by an equation of state that
/// the run has measured counts as a measurement; in the layers only counts of spheres do. Without a
/// bulk, both are equal. Statistical errors are in the residual of a
/// [`Certificate`](super::Certificate).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MeasuredShare {
    /// Mean over spheres more than four diameters from both walls, from 0 to 1.
    pub bulk: f64,
    /// Mean over spheres within four diameters of a wall, from 0 to 1.
    pub walls: f64,
}

impl MeasuredShare {
    /// Thickness of the layers at a wall, in diameters.
    pub(super) const LAYERED: f64 = 4.0;
    /// A field that comes from theory only.
    pub const NONE: Self = Self { bulk: 0.0, walls: 0.0 };
    /// A field that is measured at all heights.
    pub const ALL: Self = Self { bulk: 1.0, walls: 1.0 };

    /// The means of the weights, from rows with distance from the nearest wall and number of
    /// spheres.
    pub(super) fn of(rows: impl Iterator<Item = MeasuredAt>) -> Self {
        let (mut sums, mut spheres) = ([0.0; 2], [0.0; 2]);
        for row in rows {
            let place = usize::from(row.distance < Self::LAYERED);
            sums[place] += row.spheres * row.share;
            spheres[place] += row.spheres;
        }
        let mean = |place: usize| (spheres[place] > 0.0).then(|| sums[place] / spheres[place]);
        match (mean(0), mean(1)) {
            (Some(bulk), Some(walls)) => Self { bulk, walls },
            (Some(both), None) | (None, Some(both)) => Self { bulk: both, walls: both },
            (None, None) => Self::NONE,
        }
    }

    /// The smaller values of both fields.
    pub(super) fn least(self, other: Self) -> Self {
        Self { bulk: self.bulk.min(other.bulk), walls: self.walls.min(other.walls) }
    }

    /// [`Warning::FieldOfTheory`] if less than half of the field was measured at the walls, or less
    /// than a tenth in the bulk.
    #[must_use]
    pub fn warning(self) -> Option<Warning> {
        const LEAST_IN_BULK: f64 = 0.1;
        const LEAST_AT_WALLS: f64 = 0.5;
        let enough = self.bulk >= LEAST_IN_BULK && self.walls >= LEAST_AT_WALLS;
        (!enough).then_some(Warning::FieldOfTheory { measured: self })
    }
}

/// One height of a [`MeasuredShare`].
#[derive(Debug, Clone, Copy)]
pub(super) struct MeasuredAt {
    /// Distance from the nearest wall, in diameters.
    pub(super) distance: f64,
    pub(super) spheres: f64,
    pub(super) share: f64,
}

/// For example "3 % in the bulk and 53 % at the walls".
impl fmt::Display for MeasuredShare {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [bulk, walls] = [self.bulk, self.walls].map(|share| 100.0 * share);
        write!(formatter, "{bulk:.0} % in the bulk and {walls:.0} % at the walls")
    }
}
