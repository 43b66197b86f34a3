//! What several modules share.

pub mod balance;
pub mod exact;
pub mod scenes;
pub mod wrong_rules;
