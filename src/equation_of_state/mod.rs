//! Equations of state of hard spheres: Z(η) = P/(nT).
//!
//! To add one, implement [`EquationOfState`] for a type of your own: one method.
