//! Ready observers: one file per observable.
//!
//! | what | observer |
//! |---|---|
//! | profiles | [`DensityProfile`], [`BalancedDensityProfile`], [`PressureProfile`], [`EquationOfStateProfile`], [`ChainPressureProfile`], [`DisplacementProfile`] |
//! | pressure on base and lid | [`WallPressure`] |
//! | is it steady? | [`CenterOfMass`] |
//! | order in the plane of a layer | [`RadialDistribution`], [`NeighborAngles`], [`HexaticOrder`] |
//! | layers on top of each other | [`DensityProfile::layers`] |
//! | fcc, hcp or fluid | [`StructureProfile`]; sphere by sphere, [`BondOrder`] |
//! | a trajectory for OVITO and others | as text [`ExtendedXyz`], binary [`Gsd`] |
//! | for an observer of your own | [`Neighbors`] |
//!
//! All observe in one pass over the spheres (those of structure find neighbors as well, by cells,
//! in a time proportional to their number), and their memory does not grow with the run (but for
//! the series of [`CenterOfMass`]); all keep enough to give error bars that account for
//! correlations in time; and independent replicas of one scene are pooled
//! ([`Merge`](crate::Merge)). One that averages looks at one run: frames of another scene, or of a
//! run that counts its sweeps anew, are refused ([`Error::AnotherRun`]).
//!
//! Profiles are averages over bins of equal height. A bin of 0.1 diameters, as in the paper
//! (doi:10.1103/PhysRevE.83.061306), resolves the layers near the base; what varies slowly is
//! better measured in wider bins, up to a diameter.

mod balanced_density;
mod bins;
mod bond_order;
mod center_of_mass;
mod chain_pressure;
mod density;
mod diagnostics;
mod displacement;
mod equation_of_state;
pub(crate) mod equation_of_state_fit;
mod extended_xyz;
mod gsd;
mod hexatic;
mod layers;
mod neighbor_angles;
mod neighbors;
mod one_run;
mod pressure;
mod radial_distribution;
mod steinhardt;
mod structure;
#[cfg(test)]
mod test_frame;
mod wall_pressure;

pub use balanced_density::BalancedDensityProfile;
pub use bins::{Bins, MAXIMUM_BINS};
pub use bond_order::{BondOrder, Structure};
pub use center_of_mass::CenterOfMass;
pub use chain_pressure::{BinPressures, ChainPressurePoint, ChainPressureProfile};
pub use density::{DensityPoint, DensityProfile};
pub use displacement::{DisplacementPoint, DisplacementProfile};
pub use equation_of_state::{BinState, DeviationPoint, EquationOfStatePoint, EquationOfStateProfile};
pub use equation_of_state_fit::{EquationOfStateCurve, EquationOfStateFit, MeasuredEquationOfState};
pub use extended_xyz::ExtendedXyz;
pub use gsd::Gsd;
pub use hexatic::HexaticOrder;
pub use layers::Layer;
pub use neighbor_angles::{NeighborAnglePoint, NeighborAngles};
pub use neighbors::{Neighbor, Neighbors};
pub use pressure::{PressurePoint, PressureProfile};
pub use radial_distribution::{RadialDistribution, RadialDistributionPoint};
pub use structure::{StructurePoint, StructureProfile};
pub use wall_pressure::WallPressure;

use crate::Error;
use crate::statistics::Estimate;

/// Counts of so many neighboring bins to either side share their memory.
const ALIKE_COUNTS: usize = 1;
/// Weights above neighboring bins are nearly the same.
const ALIKE_WEIGHTS: usize = 8;

/// Packing fraction πn/6 of a number density with its error.
fn packing_fraction(number_density: Estimate) -> Estimate {
    let convert = crate::equation_of_state::packing_fraction;
    Estimate::new(convert(number_density.mean), convert(number_density.standard_error))
}

/// Fails unless two observers look for neighbors within the same radius.
fn require_same_radius(mine: &Neighbors, other: &Neighbors) -> Result<(), Error> {
    if mine.radius().to_bits() == other.radius().to_bits() {
        return Ok(());
    }
    let requirement = "observers can only be pooled if their radii are the same";
    Err(Error::InvalidParameter { name: "search radius", value: other.radius(), requirement })
}
