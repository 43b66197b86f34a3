//! Tests of parameter sweeps without MPI; ranks are threads here.

#![allow(clippy::unwrap_used, clippy::panic)]

mod ranks;
mod tables;
mod threads_as_ranks;
