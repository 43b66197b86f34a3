//! The main test suite: one program, so that the library is linked once and all cores are used.
//!
//! `cargo test --test suite exact_results` runs one module. Apart from these, `threads` runs with
//! the feature `rayon` too, and `no_trace` counts allocations.

#![allow(clippy::disallowed_methods, unreachable_pub)]

mod adaptation;
mod chain_pressure;
mod common;
mod density_functional;
mod detailed_balance;
mod event_chains;
mod exact_results;
mod half_way;
mod hostile_input;
mod inputs;
mod invariants;
mod mirror_image;
mod non_isothermal;
mod reductions;
mod stability;
mod steady_state;
mod structure;
mod theory;
mod trajectories;
mod wall_pressure;
mod warnings;
