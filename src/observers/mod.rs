//! Ready observers: one file per observable.
//!
//! All observe in one pass over the spheres, and their memory does not grow with the run (but for the
//! series of [`CenterOfMass`]); all keep enough to give error bars that account for correlations in
//! time; and independent replicas of one scene are pooled with `merge`.
//!
//! Profiles are averages over bins of equal height. A bin of 0.1 diameters, as in the paper
//! (doi:10.1103/PhysRevE.83.061306), resolves the layers near the base; what varies slowly is better
//! measured in wider bins, up to a diameter.

mod bins;
mod center_of_mass;
mod density;
mod displacement;
mod equation_of_state;
mod pressure;
#[cfg(test)]
mod test_frame;

pub use bins::MAXIMUM_BINS;
pub use center_of_mass::CenterOfMass;
pub use density::{DensityPoint, DensityProfile};
pub use displacement::{DisplacementPoint, DisplacementProfile};
pub use equation_of_state::{DeviationPoint, EquationOfStatePoint, EquationOfStateProfile};
pub use pressure::{PressurePoint, PressureProfile};

use crate::statistics::Estimate;

/// Packing fraction πn/6 of a number density with its error.
fn packing_fraction(number_density: Estimate) -> Estimate {
    let convert = crate::equation_of_state::packing_fraction;
    Estimate::new(convert(number_density.mean), convert(number_density.standard_error))
}
