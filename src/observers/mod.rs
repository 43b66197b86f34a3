//! Observers: profiles, structure, trajectories and more.
//!
//! | quantity | observer |
//! |---|---|
//! | profiles | [`DensityProfile`], [`BalancedDensityProfile`], [`PressureProfile`], [`EquationOfStateProfile`], [`ChainPressureProfile`], [`DisplacementProfile`] |
//! | pressure on base and lid | [`WallPressure`] |
//! | height of the center of mass, steady state | [`CenterOfMass`] |
//! | order in the plane of a layer | [`RadialDistribution`], [`NeighborAngles`], [`HexaticOrder`] |
//! | layers of the density profile | [`DensityProfile::layers`] |
//! | fcc, hcp or fluid | [`StructureProfile`]; for single spheres [`BondOrder`] |
//! | trajectory for OVITO and others | as text [`ExtendedXyz`], binary [`Gsd`] |
//! | neighbors, for your own observers | [`Neighbors`] |
//!
//! The time per frame is proportional to the number of spheres. The memory does not grow with the
//! length of the run, except for the series of [`CenterOfMass`]. Standard errors include
//! correlations in time. Data of independent replicas can be merged ([`Merge`](crate::Merge)). An
//! observer that averages samples one run: it refuses frames of another scene or another run
//! ([`Error::AnotherRun`]).
//!
//! Profiles are averages over bins of equal height. Bins of 0.1 diameters, as in the paper
//! (doi:10.1103/PhysRevE.83.061306), resolve the layers near the base. Use wider bins, up to a
//! diameter, for quantities that vary slowly.

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

/// Number of neighboring bins on either side whose counts have nearly the same autocorrelation
/// time.
const ALIKE_COUNTS: usize = 1;
/// The same for weights above bins.
const ALIKE_WEIGHTS: usize = 8;

/// Packing fraction πn/6 of a number density, with its standard error.
fn packing_fraction(number_density: Estimate) -> Estimate {
    let convert = crate::equation_of_state::packing_fraction;
    Estimate::new(convert(number_density.mean), convert(number_density.standard_error))
}

/// Fails if two observers search for neighbors within different radii.
fn require_same_radius(mine: &Neighbors, other: &Neighbors) -> Result<(), Error> {
    if mine.radius().to_bits() == other.radius().to_bits() {
        return Ok(());
    }
    let requirement = "observers can only be pooled if their radii are the same";
    Err(Error::InvalidParameter { name: "search radius", value: other.radius(), requirement })
}
