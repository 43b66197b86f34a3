//! Gradient Monte Carlo (draft page).
#![warn(
    missing_docs,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    clippy::print_stderr
)]
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::disallowed_methods))]

mod cell_list;
mod configuration;
pub mod drive;
pub mod equation_of_state;
mod error;
pub mod field;
pub mod hydrostatics;
pub mod moves;
mod numerics;
mod observer;
pub mod observers;
mod random;
mod scene;
mod simulation;
mod slab;
pub mod start;
pub mod statistics;
pub mod temperature;

pub use equation_of_state::EquationOfState;
pub use error::Error;
pub use field::Field;
pub use hydrostatics::{HydrostaticProfile, Hydrostatics};
pub use nalgebra::Vector3;
pub use observer::{AcceptedMove, Every, Frame, Observer, ObserverError, Tally};
pub use random::Generator;
pub use scene::Scene;
pub use simulation::{Simulation, SimulationBuilder};
pub use slab::Slab;
pub use temperature::TemperatureProfile;
