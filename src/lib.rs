//! Gradient Monte Carlo (draft page).
#![warn(
    missing_docs,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    clippy::print_stderr
)]

pub mod equation_of_state;
mod error;
pub mod field;
pub mod hydrostatics;
mod numerics;
mod slab;
pub mod temperature;

pub use error::Error;
pub use field::Field;
pub use slab::Slab;
pub use temperature::TemperatureProfile;
