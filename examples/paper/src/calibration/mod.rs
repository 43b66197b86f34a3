//! Calibration of the models of a column: scenes, data, and fit.

mod adsorption;
pub mod data;
pub mod fit;
mod functional;
pub mod scenes;
pub mod unseen;
