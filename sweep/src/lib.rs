#![doc = include_str!("../README.md")]
#![warn(missing_docs, clippy::unwrap_used, clippy::expect_used, clippy::panic)]
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

mod case;
pub mod crew;
pub mod dispatch;
mod files;
pub mod link;
#[cfg(feature = "mpi")]
mod mpi_link;
mod progress;
pub mod results;
mod run;
mod table;

pub use case::{Case, ChosenScene, FieldChoice, Observers, TemperatureChoice};
pub use files::{Folder, Noted, Record};
#[cfg(feature = "mpi")]
pub use mpi_link::MpiLink;
pub use run::{Failure, Job};
pub use table::{BadTable, Table, Task};
