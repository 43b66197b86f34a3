//! What a checkpoint keeps of event chains.

use super::{Engine, EventChains};
use crate::Error;
use crate::checkpoint::Archive;
use crate::configuration::Grid;

impl Engine {
    /// See [`Persist`](crate::checkpoint::Persist). Bounds of the force follow from the drive.
    pub(in crate::moves) fn persist(&mut self, archive: &mut Archive<'_>, grid: &Grid) -> Result<(), Error> {
        archive.part("length", &mut self.length)?;
        archive.value("advance", &mut self.advance)?;
        archive.value("owed", self.tiles.owed_mut())?;
        // A chain is never more ahead than by its own length, and so much is never owed. What is behind is forgotten.
        archive.check(self.advance <= 2.0 * EventChains::MAXIMUM_LENGTH)?;
        archive.check(self.tiles.owed_mut().iter().all(|owed| owed.abs() <= EventChains::MAXIMUM_LENGTH))?;
        self.local
            .as_mut()
            .map_or(Ok(()), |moves| archive.within("local moves", |archive| moves.persist(archive, grid)))
    }
}
