//! Messages between ranks by MPI.

use crate::link::{Link, Message};
use mpi::environment::Universe;
use mpi::point_to_point::traits::{Destination as _, MatchedReceiveVec as _, Source as _};
use mpi::topology::{Communicator as _, SimpleCommunicator};
use std::fmt;

/// Connection to the ranks started by `mpirun` or `srun`; a single rank without them.
pub struct MpiLink {
    world: SimpleCommunicator,
    /// Finalizes MPI when dropped.
    _universe: Universe,
}

impl fmt::Debug for MpiLink {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("MpiLink").field("rank", &self.rank()).field("ranks", &self.ranks()).finish()
    }
}

impl MpiLink {
    /// Initializes MPI, once in a process. Other threads may run, but must not send messages.
    /// `None` if it fails.
    #[must_use]
    pub fn new() -> Option<Self> {
        let (universe, _) = mpi::initialize_with_threading(mpi::Threading::Funneled)?;
        Some(Self { world: universe.world(), _universe: universe })
    }
}

/// Ranks are small and not negative.
fn number(rank: i32) -> usize {
    usize::try_from(rank).unwrap_or(0)
}

impl Link for MpiLink {
    fn rank(&self) -> usize {
        number(self.world.rank())
    }

    fn ranks(&self) -> usize {
        number(self.world.size())
    }

    fn send(&mut self, rank: usize, message: &Message) {
        let (tag, content) = message.encode();
        if let Ok(rank) = i32::try_from(rank) {
            self.world.process_at_rank(rank).send_with_tag(&content[..], tag);
        }
    }

    fn receive(&mut self) -> Option<(usize, Message)> {
        let (content, status) =
            self.world.any_process().immediate_matched_probe()?.matched_receive_vec::<u8>();
        Some((number(status.source_rank()), Message::decode(status.tag(), &content)?))
    }

    fn abort(&mut self, code: u8) -> ! {
        self.world.abort(code.into())
    }
}
