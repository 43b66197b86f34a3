//! The solution of a column.

use super::solution::{Problem, Solution};
use super::{Functional, RADIUS};
use crate::HydrostaticProfile;
use crate::legendre::Legendre;

/// The profile of a column with its layers; made by
/// [`DensityFunctional`](super::DensityFunctional).
///
/// It holds its own nodes and borrows nothing. Between them ln n is a polynomial of degree 15.
/// Pressures are the weight of the spheres above plus the pressure on the lid. At any height, also
/// in the layers, this is the vertical component of the pressure.
///
/// ```
/// use gradient_mc::functional::WhiteBear2;
/// use gradient_mc::{Scene, Slab, field::UniformField, temperature::Isothermal};
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 360, UniformField::default(), Isothermal::new(5.0)?)?;
/// let profile = scene.density_functional(&WhiteBear2)?;
/// assert!((profile.column_density() - 10.0).abs() < 1e-9);
/// // The first layer: the density at contact is above the mean over the first diameter.
/// assert!(profile.contact_density() > profile.mean_density(0.5, 1.5));
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct LayeredProfile {
    profile: HydrostaticProfile,
    chemical_potential: f64,
    grand_potential: f64,
    iterations: u32,
    residual: f64,
}

impl LayeredProfile {
    pub(super) fn new<W: Functional>(
        rule: &Legendre,
        problem: &Problem<'_, W>,
        solution: &Solution,
        start: &HydrostaticProfile,
    ) -> Self {
        let grid = &problem.grid;
        let state = &solution.state;
        let panels: Vec<[f64; 2]> = grid.panels().collect();
        let pressures = problem.potential.weights(rule, grid, &state.densities);
        let ln_pressures: Vec<f64> =
            pressures.iter().map(|pressure| libm::log(pressure.max(f64::MIN_POSITIVE))).collect();
        let values = [&solution.logarithms[..], &ln_pressures[..]];
        Self {
            profile: start.with_layers(rule, &panels, values, RADIUS),
            chemical_potential: state.chemical_potential,
            grand_potential: state.grand_potential,
            iterations: solution.iterations,
            residual: solution.residual,
        }
    }

    /// The profile in the form of a hydrostatic profile.
    pub(crate) fn as_hydrostatic(&self) -> &HydrostaticProfile {
        &self.profile
    }

    /// Number density n(x) of centers; 0 within half a diameter of a wall.
    #[must_use]
    pub fn number_density(&self, height: f64) -> f64 {
        self.profile.number_density(height)
    }

    /// Mean of n between two heights, exact for the polynomials.
    #[must_use]
    pub fn mean_density(&self, lowest: f64, highest: f64) -> f64 {
        (self.column_below(highest) - self.column_below(lowest)) / (highest - lowest)
    }

    /// The pressure on a plane at `height`, in m g/d².
    #[must_use]
    pub fn pressure(&self, height: f64) -> f64 {
        self.profile.pressure(height)
    }

    /// Pressure on the base, in m g/d². By the contact theorem it is nT at the lowest center.
    #[must_use]
    pub fn base_pressure(&self) -> f64 {
        self.profile.base_pressure()
    }

    /// Density of centers in contact with the base.
    #[must_use]
    pub fn contact_density(&self) -> f64 {
        self.number_density(self.profile.base())
    }

    /// Height of the lowest centers.
    #[must_use]
    pub fn base(&self) -> f64 {
        self.profile.base()
    }

    /// Height of the highest centers; in an open column, where the density is negligible.
    #[must_use]
    pub fn top(&self) -> f64 {
        self.profile.top()
    }

    /// Spheres per unit of base area, N/A.
    #[must_use]
    pub fn column_density(&self) -> f64 {
        self.profile.column_density()
    }

    /// Spheres per unit area between the base and `height`.
    #[must_use]
    pub fn column_below(&self, height: f64) -> f64 {
        self.profile.column_below(height)
    }

    /// Height of the center of mass.
    #[must_use]
    pub fn center_of_mass(&self) -> f64 {
        self.profile.center_of_mass()
    }

    /// Height below which `fraction` of the spheres lie; fractions outside [0, 1] are clamped.
    #[must_use]
    pub fn height_of_fraction(&self, fraction: f64) -> f64 {
        self.profile.height_of_fraction(fraction)
    }

    /// Chemical potential over temperature, μ = ln n + μₑₓ + u, with u = φ/T at the lowest center.
    #[must_use]
    pub fn chemical_potential(&self) -> f64 {
        self.chemical_potential
    }

    /// Grand potential per area over temperature. Without a field it is −PL/T plus twice the
    /// surface tension of the walls over T, with the height L of the box.
    #[must_use]
    pub fn grand_potential(&self) -> f64 {
        self.grand_potential
    }

    /// Number of iterations on all grids.
    #[must_use]
    pub fn iterations(&self) -> u32 {
        self.iterations
    }

    /// Root mean square of μ − u − μₑₓ − ln n, weighted by n.
    #[must_use]
    pub fn residual(&self) -> f64 {
        self.residual
    }
}
