//! What must hold of runs that are stopped and go on: `cargo test --features checkpoint --test checkpoint`.

#![allow(clippy::unwrap_used, unreachable_pub)]

mod exact;
mod file;
