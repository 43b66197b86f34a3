//! How much of an effective field was measured, and how much is theory.

use crate::Warning;
use std::fmt;

/// The part of an effective field that was measured; the rest is the theory's.
///
/// A scheme that combines a measurement of P/n with what a theory says of it gives the measurement
/// a weight between 0 and 1 at every height. These are its means over the spheres of the column,
/// apart for the layers within four diameters of a wall, of which the theory knows nothing, and for
/// the bulk, where it is good to some 0.2 %. In the bulk a closure by the equation of state that
/// the run itself has measured is a measurement; in the layers only counts are. It says nothing of
/// errors: those are in the residual of a [`Certificate`](super::Certificate). Where there is no
/// bulk, both are the same.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MeasuredShare {
    /// More than four diameters from both walls, 0 to 1.
    pub bulk: f64,
    /// Within four diameters of a wall, 0 to 1.
    pub walls: f64,
}

impl MeasuredShare {
    /// Nearer to a wall than this the fluid is layered.
    pub(super) const LAYERED: f64 = 4.0;
    /// A field that is all theory.
    pub const NONE: Self = Self { bulk: 0.0, walls: 0.0 };
    /// A field that is all measurement.
    pub const ALL: Self = Self { bulk: 1.0, walls: 1.0 };

    /// The means of shares, each at a distance from the nearest wall and for so many spheres.
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

    /// The smaller of each.
    pub(super) fn least(self, other: Self) -> Self {
        Self { bulk: self.bulk.min(other.bulk), walls: self.walls.min(other.walls) }
    }

    /// [`Warning::FieldOfTheory`] where less than half of the field was measured at the walls, or
    /// less than a tenth of it in the bulk.
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
    /// From the nearest wall.
    pub(super) distance: f64,
    pub(super) spheres: f64,
    pub(super) share: f64,
}

/// As in "3 % in the bulk and 53 % at the walls".
impl fmt::Display for MeasuredShare {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [bulk, walls] = [self.bulk, self.walls].map(|share| 100.0 * share);
        write!(formatter, "{bulk:.0} % in the bulk and {walls:.0} % at the walls")
    }
}
