//! What several test files share. Each file uses a part of it.

#![allow(
    dead_code,
    unreachable_pub,
    clippy::disallowed_methods,
    clippy::unwrap_used,
    clippy::missing_errors_doc
)]

pub mod balance;
pub mod exact;
pub mod scenes;
pub mod wrong_rules;
