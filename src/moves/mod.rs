//! Families of moves. Each reads the drive through [`log_acceptance`](crate::drive::log_acceptance)
//! and nothing else; a new family is a new file here.

mod local;

pub use local::LocalMoves;
