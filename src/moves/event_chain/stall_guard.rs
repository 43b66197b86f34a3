//! Chains that do not get ahead.

use crate::Error;
use crate::frame::Phase;

/// Guards against chains that go on for ever without getting anywhere, where spheres touch all
/// along the way or the force is immense.
///
/// While equilibrating, when no balance has to be kept yet, such a chain is given up early and
/// quietly: crystals to start from are jammed until they have melted. In production it is an error,
/// since giving up where spheres are dense would favor what is not.
pub(super) struct StallGuard {
    phase: Phase,
    length: f64,
    /// Straight pieces since the mark.
    pieces: u32,
    /// Times that the field stopped the chain since the mark.
    field_events: u32,
    /// Length that was left at the mark.
    mark: f64,
}

impl StallGuard {
    /// Straight pieces within which a chain must advance by one diameter. Only spheres that are
    /// jammed to a millionth of a diameter need more, or one between two frozen ones that leave
    /// it next to no room: it goes to and fro until the chain is over.
    pub(super) const PIECES: u32 = 1_000_000;
    /// The same while equilibrating.
    pub(super) const PIECES_IN_EQUILIBRATION: u32 = 10_000;

    pub(super) fn new(length: f64, phase: Phase) -> Self {
        Self { phase, length, pieces: 0, field_events: 0, mark: length }
    }

    /// Counts that the field has stopped the chain.
    #[inline]
    pub(super) fn field_event(&mut self) {
        self.field_events += 1;
    }

    /// Whether the chain, which has `left` to go, may go on.
    #[inline]
    pub(super) fn lasts(&mut self, left: f64) -> Result<bool, Error> {
        self.pieces += 1;
        if self.pieces < Self::PIECES_IN_EQUILIBRATION { Ok(true) } else { self.look(left) }
    }

    #[cold]
    fn look(&mut self, left: f64) -> Result<bool, Error> {
        if self.mark - left >= 1.0 {
            (self.pieces, self.field_events, self.mark) = (0, 0, left);
        } else if self.phase == Phase::Equilibration {
            return Ok(false);
        } else if self.pieces >= Self::PIECES {
            let (length, path) = (self.length, self.length - left);
            return Err(Error::ChainStuck { length, path, field_events: self.field_events });
        }
        Ok(true)
    }
}
