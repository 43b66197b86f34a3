//! Tests of interrupted and continued runs: `cargo test --features signals --test checkpoint`.

#![allow(clippy::unwrap_used, unreachable_pub)]

mod corpus;
mod driver;
mod exact;
mod file;
#[cfg(all(unix, feature = "signals"))]
mod killed;
mod pooled;
mod reader;
mod run;
