//! A guard against chains that do not advance.

use crate::Error;
use crate::frame::Phase;

/// Ends chains that do not advance, because spheres are jammed or the force is immense.
///
/// In equilibration, where balance need not hold, such a chain is given up early and without an
/// error: a crystal is jammed until it melts. In production it is an error, since giving up chains
/// in dense configurations would favor dilute ones.
pub(super) struct StallGuard {
    phase: Phase,
    length: f64,
    /// Straight pieces since the mark.
    pieces: u32,
    /// Straight pieces before the mark.
    before: u32,
    /// Field events since the mark.
    field_events: u32,
    /// Length that was left at the mark.
    mark: f64,
}

impl StallGuard {
    /// Straight pieces within which a chain must advance by one diameter. Two cases need more:
    /// spheres that are jammed to a millionth of a diameter, and a sphere with next to no room
    /// between two frozen ones, which goes to and fro until the chain ends.
    pub(super) const PIECES: u32 = 1_000_000;
    /// The same in equilibration.
    pub(super) const PIECES_IN_EQUILIBRATION: u32 = 10_000;

    /// Straight pieces of a whole chain, if they are shorter than [`SHORT`](Self::SHORT): half a
    /// gigabyte where they are recorded.
    pub(super) const PIECES_OF_A_CHAIN: u32 = 10_000_000;
    /// Mean length of a piece that is common only in an immense force, in diameters.
    const SHORT: f64 = 1e-4;

    pub(super) fn new(length: f64, phase: Phase) -> Self {
        Self { phase, length, pieces: 0, before: 0, field_events: 0, mark: length }
    }

    /// Counts a field event.
    #[inline]
    pub(super) fn field_event(&mut self) {
        self.field_events += 1;
    }

    /// Counts a piece. Returns whether the chain, which has the length `left`, may go on.
    #[inline]
    pub(super) fn lasts(&mut self, left: f64) -> Result<bool, Error> {
        self.pieces += 1;
        if self.pieces < Self::PIECES_IN_EQUILIBRATION { Ok(true) } else { self.look(left) }
    }

    #[cold]
    fn look(&mut self, left: f64) -> Result<bool, Error> {
        let (path, pieces) = (self.length - left, self.before.saturating_add(self.pieces));
        let is_endless = pieces >= Self::PIECES_OF_A_CHAIN && path < Self::SHORT * f64::from(pieces);
        if self.mark - left >= 1.0 && !is_endless {
            self.before = pieces;
            (self.pieces, self.field_events, self.mark) = (0, 0, left);
        } else if self.phase == Phase::Equilibration {
            return Ok(false);
        } else if is_endless || self.pieces >= Self::PIECES {
            return Err(Error::ChainStuck { length: self.length, path, field_events: self.field_events });
        }
        Ok(true)
    }
}
