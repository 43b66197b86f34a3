//! Density functionals of hard spheres: a theory that includes the layers at a wall.
//!
//! The excess free energy per area over temperature is ∫ Φ dx, where Φ is a function of a few
//! weighted densities: averages of the density over a sphere (Rosenfeld's fundamental measure
//! theory, Phys. Rev. Lett. 63, 980 (1989), doi:10.1103/PhysRevLett.63.980). The density depends on
//! height alone, so the averages are integrals over half a diameter up and down.
//!
//! | functional | uniform fluid | property |
//! |---|---|---|
//! | [`Rosenfeld`] | Percus-Yevick, compressibility | the original |
//! | [`WhiteBear`] | Carnahan-Starling | accurate pressure |
//! | [`WhiteBear2`] | Carnahan-Starling | consistent with scaled-particle theory to 2 % |
//! | [`Lutsko`] | depends on its two parameters | stable also in narrow cavities |
//!
//! [`DensityFunctional`] solves a column with any of them, between walls and in any field. Where
//! the temperature varies, it uses the effective field of the column (see [`drive`](crate::drive)).
//! To add a functional, implement the one method of [`Functional`].

mod anderson;
mod bulk;
mod column;
mod grid;
mod lutsko;
mod measures;
mod moments;
mod potential;
mod profile;
mod rosenfeld;
mod solution;
mod terms;
#[cfg(test)]
mod tests;
mod white_bear;
mod white_bear_2;

pub use bulk::Bulk;
pub use column::DensityFunctional;
pub use lutsko::Lutsko;
pub use measures::{FreeEnergy, WeightedDensities};
pub use profile::LayeredProfile;
pub use rosenfeld::Rosenfeld;
pub use white_bear::WhiteBear;
pub use white_bear_2::WhiteBear2;

use std::sync::Arc;

/// Radius of a sphere.
const RADIUS: f64 = 0.5;

/// The excess free energy of hard spheres as a function of the [`WeightedDensities`].
///
/// ```
/// use gradient_mc::EquationOfState;
/// use gradient_mc::functional::{Bulk, FreeEnergy, Functional, WeightedDensities};
/// /// Pairs of spheres only: exact in the dilute limit.
/// struct Pairs;
/// impl Functional for Pairs {
///     fn free_energy(&self, weighted: &WeightedDensities) -> FreeEnergy {
///         let WeightedDensities { packing, surface, vector, .. } = *weighted;
///         let pi = std::f64::consts::PI;
///         FreeEnergy {
///             density: surface * packing / pi + (surface * surface - vector * vector) / (2.0 * pi),
///             by_packing: surface / pi,
///             by_surface: packing / pi + surface / pi,
///             by_vector: -vector / pi,
///             by_tensor: 0.0,
///         }
///     }
/// }
/// // Z = 1 + 4η
/// assert!((Bulk(Pairs).compressibility_factor(0.1) - 1.4).abs() < 1e-12);
/// ```
///
/// It must be `Send` and `Sync`. `&`, `Box` and `Arc` of a functional are functionals too.
pub trait Functional: Send + Sync {
    /// Φ and its derivatives, for a packing below 1.
    fn free_energy(&self, weighted: &WeightedDensities) -> FreeEnergy;
}

macro_rules! forward_functional {
    ($($pointer:ty),+) => {
        $(impl<W: Functional + ?Sized> Functional for $pointer {
            fn free_energy(&self, weighted: &WeightedDensities) -> FreeEnergy {
                (**self).free_energy(weighted)
            }
        })+
    };
}
forward_functional!(&W, Box<W>, Arc<W>);
