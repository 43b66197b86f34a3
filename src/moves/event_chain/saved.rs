//! What a checkpoint keeps of event chains.

use super::{Engine, EventChains};
use crate::Error;
use crate::checkpoint::Archive;
use crate::configuration::Grid;

impl Engine {
    /// See [`Persist`](crate::checkpoint::Persist). Bounds of the force follow from the drive.
    pub(in crate::moves) fn persist(&mut self, archive: &mut Archive<'_>, grid: &Grid) -> Result<(), Error> {
        archive.part("length", &mut self.length)?;
        archive.value("owed", &mut self.tiles.owed)?;
        // A sweep exceeds its path by at most one visit, and unused path is not carried over.
        archive.check(self.tiles.owed.iter().all(|owed| owed.abs() <= EventChains::MAXIMUM_LENGTH))?;
        self.local
            .as_mut()
            .map_or(Ok(()), |moves| archive.within("local moves", |archive| moves.persist(archive, grid)))
    }
}
