//! Runs that are stopped and go on as if they had not been.
//!
//! A [`Snapshot`] holds all that a run has become: positions, the generator, what was tuned and adapted, what judges the
//! run, and what observers have seen, also in an interval under way. It goes on in a simulation made by the same code, whose
//! numbers are overwritten ([`SimulationBuilder::resume`](crate::SimulationBuilder::resume)); fields, temperatures and
//! closures are not kept, but compared. 2k sweeps are the same bits as k, a file, and k more.
//!
//! | you want | take |
//! |---|---|
//! | a long run in one call, that goes on where it was stopped | [`Run`] |
//! | to end it by a signal | `Signals`, with the feature `signals` |
//! | the results of many processes in one | [`SimulationBuilder::pooled`](crate::SimulationBuilder::pooled) |
//! | an observer, a drive or an adaptation of your own in it | [`Persist`] |
//! | each step by yourself | [`Simulation::snapshot`](crate::Simulation::snapshot), [`Snapshot::write`], [`Snapshot::read`] |
//!
//! # The file
//! Eight bytes `gmc-ckpt`, the version of the format (four bytes, as all numbers the lowest first), the CRC-32 of what
//! follows, the number of bytes that follow, and these: seed, sweep and sweeps of production, and three pieces, each after
//! its length: what is simulated and how, the state of the simulation, that of the observer. The pieces are items by
//! [`postcard`](https://postcard.jamesmunns.com/wire-format), each after its name. A file of another version is refused.
//!
//! Any damage is an error. To read a file takes at most 32 times its size in memory, and what the scene takes by itself.

mod archive;
mod file;
mod identity;
mod parts;
mod pooled;
mod run;
#[cfg(feature = "signals")]
mod signals;
mod snapshot;

pub use archive::{Archive, Persist};
pub(crate) use identity::Identity;
pub use run::{Ended, Progress, Reason, Run};
#[cfg(feature = "signals")]
pub use signals::Signals;
pub use snapshot::Snapshot;
