//! The arguments and the result of a functional.

use super::RADIUS;
use std::f64::consts::PI;

/// Weighted densities at a height: four averages of the density over spheres of radius R = ½.
///
/// For equal spheres the others follow: n₀ = n₂/π, n₁ = n₂/(2π) and **n**₁ = **n**₂/(2π).
///
/// ```
/// use gradient_mc::equation_of_state::packing_fraction;
/// use gradient_mc::functional::WeightedDensities;
/// let uniform = WeightedDensities::uniform(0.6);
/// assert!((uniform.packing - packing_fraction(0.6)).abs() < 1e-15);
/// assert_eq!(uniform.vector, 0.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WeightedDensities {
    /// n₃ = π∫(R² − s²) n(x + s) ds over |s| < R: the local packing fraction.
    pub packing: f64,
    /// n₂ = π∫n(x + s) ds: the surface density.
    pub surface: f64,
    /// n₂ₓ = −2π∫s n(x + s) ds: the vertical component of the vector surface density.
    pub vector: f64,
    /// Tₓₓ = 4π∫s² n(x + s) ds: the vertical component of the tensor surface density. The other two
    /// components are (n₂ − Tₓₓ)/2 each.
    pub tensor: f64,
}

impl WeightedDensities {
    /// Weighted densities of a uniform fluid.
    #[must_use]
    pub fn uniform(number_density: f64) -> Self {
        let surface = PI * number_density;
        Self { packing: surface / 6.0, surface, vector: 0.0, tensor: surface / 3.0 }
    }

    /// From ∫n ds, ∫s n ds and ∫s² n ds over |s| < R.
    pub(super) fn from_moments([zeroth, first, second]: [f64; 3]) -> Self {
        Self {
            packing: PI * (RADIUS * RADIUS * zeroth - second),
            surface: PI * zeroth,
            vector: -2.0 * PI * first,
            tensor: 4.0 * PI * second,
        }
    }
}

/// Excess free energy per volume over temperature, Φ, and its derivatives.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FreeEnergy {
    /// Φ, in inverse cubic diameters.
    pub density: f64,
    /// ∂Φ/∂n₃.
    pub by_packing: f64,
    /// ∂Φ/∂n₂, including the contributions of n₀ and n₁.
    pub by_surface: f64,
    /// ∂Φ/∂n₂ₓ, including the contribution of **n**₁.
    pub by_vector: f64,
    /// ∂Φ/∂Tₓₓ.
    pub by_tensor: f64,
}

impl FreeEnergy {
    /// The three functions whose moments ∫A₀ ds + ∫s A₁ ds + ∫s² A₂ ds over |s| < R are the
    /// derivative of ∫Φ dx by n.
    pub(super) fn for_moments(&self) -> [f64; 3] {
        [
            PI * (RADIUS * RADIUS * self.by_packing + self.by_surface),
            2.0 * PI * self.by_vector,
            PI * (4.0 * self.by_tensor - self.by_packing),
        ]
    }
}
