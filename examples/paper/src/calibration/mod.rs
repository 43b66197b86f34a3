//! Calibration of the models of a column: scenes, data, and fit.

pub mod data;
pub mod fit;
mod functional;
pub mod scenes;
