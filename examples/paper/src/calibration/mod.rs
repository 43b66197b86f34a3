//! The models of a column: their scenes, what was measured of them, and the fit.

mod adsorption;
pub mod data;
pub mod fit;
mod functional;
pub mod scenes;
pub mod unseen;
