//! A field that gives a chosen density profile.

use super::Field;
use crate::equation_of_state::{CLOSE_PACKING, EquationOfState, number_density};
use crate::hydrostatics::bulk_beginning;
use crate::numerics::integrate_panel;
use crate::temperature::{Isothermal, TemperatureProfile};
use crate::{Error, Slab};

/// The field in which an isothermal column has a chosen profile of the packing fraction η(x):
///
/// φ(x) = T [ln η(0) + μₑₓ(η(0))] − T [ln η(x) + μₑₓ(η(x))],
///
/// because the sum of ideal and excess chemical potential and potential is the same at all heights.
/// μₑₓ is the excess chemical potential over temperature of a given equation of state. An
/// approximate equation only changes the resulting profile somewhat.
///
/// To measure the equation of state in one run, a packing fraction that decreases linearly over the
/// slab is a good choice: there is no dilute tail, and all densities are sampled equally. Because
/// of the layers at the walls, choose a range a little wider than needed at both ends.
///
/// The potential is a piecewise cubic with a continuous slope and at least 32 nodes per diameter.
/// The chosen packing fraction is never evaluated outside the slab.
///
/// ```
/// use gradient_mc::equation_of_state::CarnahanStarling;
/// use gradient_mc::{Scene, Simulation, Slab, field::DesignedField, temperature::Isothermal};
/// let slab = Slab::new(60.0, 6.0, 6.0)?;
/// let temperature = Isothermal::new(1.0)?;
/// let field = DesignedField::linear([0.3, 0.02], temperature, CarnahanStarling, &slab)?;
/// let column_density = field.column_density();
/// let scene = Scene::with_column_density(slab, column_density, field, temperature)?;
/// let theory = scene.hydrostatics(&CarnahanStarling)?;
/// assert!((theory.packing_fraction(30.0) - 0.16).abs() < 1e-4);
/// let mut simulation = Simulation::builder(scene).seed(1).build()?;
/// simulation.equilibrate(10, &mut ())?;
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Clone)]
pub struct DesignedField {
    /// Potential and acceleration at evenly spaced heights, the first at 0 and the last at the lid.
    nodes: Vec<[f64; 2]>,
    spacing: f64,
    column_density: f64,
}

impl std::fmt::Debug for DesignedField {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("DesignedField").field("nodes", &self.nodes.len()).finish_non_exhaustive()
    }
}

impl DesignedField {
    const NODES_PER_DIAMETER: f64 = 32.0;

    /// Makes the field for a `packing_fraction` as a function of height, between the walls of
    /// `slab`.
    ///
    /// ```
    /// use gradient_mc::equation_of_state::ModifiedKolafa;
    /// use gradient_mc::{Field, Slab, field::DesignedField, temperature::Isothermal};
    /// // The barometric law of a gas so dilute that it is ideal: its field is uniform.
    /// let slab = Slab::new(50.0, 5.0, 5.0)?;
    /// let barometric = |height: f64| 1e-6 * (-height / 10.0).exp();
    /// let field = DesignedField::new(barometric, Isothermal::new(10.0)?, ModifiedKolafa, &slab)?;
    /// assert!((field.acceleration(20.0) - 1.0).abs() < 1e-5);
    /// # Ok::<(), gradient_mc::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] if the packing fraction is not above 0 and below close packing;
    /// [`Error::InvalidField`] if the equation of state gives no finite potential at some height.
    pub fn new<E: EquationOfState>(
        packing_fraction: impl Fn(f64) -> f64,
        temperature: Isothermal,
        equation_of_state: E,
        slab: &Slab,
    ) -> Result<Self, Error> {
        let highest = slab.height();
        // At most some millions.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let panels = ((highest * Self::NODES_PER_DIAMETER).ceil() as usize).max(4);
        let height = |node: usize| highest * (node as f64 / panels as f64);
        let temperature = temperature.temperature(0.0);
        let chemical_potential = |node: usize| {
            let eta = packing_fraction(height(node));
            if !(eta > 0.0 && eta < CLOSE_PACKING) {
                let requirement = "it must be above 0 and below close packing";
                return Err(Error::InvalidParameter { name: "packing fraction", value: eta, requirement });
            }
            Ok(temperature * (libm::log(eta) + equation_of_state.excess_chemical_potential(eta)))
        };
        let at_base = chemical_potential(0)?;
        let mut potentials = Vec::with_capacity(panels + 1);
        for node in 0..=panels {
            let potential = at_base - chemical_potential(node)?;
            if !potential.is_finite() {
                let height = height(node);
                return Err(Error::InvalidField { height, acceleration: f64::NAN, potential });
            }
            potentials.push(potential);
        }
        let spacing = highest / panels as f64;
        let nodes = (0..=panels).map(|node| [potentials[node], slope(&potentials, node) / spacing]).collect();
        let begin = bulk_beginning(packing_fraction(0.0));
        let end = highest - bulk_beginning(packing_fraction(highest));
        let width = (end - begin) / panels as f64;
        let spheres = |panel: usize| {
            let from = begin + width * panel as f64;
            integrate_panel(|x| number_density(packing_fraction(x)), from, from + width)
        };
        let column_density = (0..panels).map(spheres).sum();
        Ok(Self { nodes, spacing, column_density })
    }

    /// Makes the field for a packing fraction that is linear in height, from its values at x = 0
    /// and at the lid.
    ///
    /// # Errors
    /// Those of [`new`](Self::new).
    pub fn linear<E: EquationOfState>(
        [base, lid]: [f64; 2],
        temperature: Isothermal,
        equation_of_state: E,
        slab: &Slab,
    ) -> Result<Self, Error> {
        let height = slab.height();
        Self::new(|x| base + (lid - base) * (x / height), temperature, equation_of_state, slab)
    }

    /// Number of spheres per area N/A of the chosen profile, in inverse square diameters, including
    /// the layers at the walls (see [`between_walls`](crate::Hydrostatics::between_walls)). Pass it
    /// to [`Scene::with_column_density`](crate::Scene::with_column_density). With another number
    /// the column is denser or more dilute at all heights.
    #[must_use]
    pub fn column_density(&self) -> f64 {
        self.column_density
    }

    /// The panel of a height: potential and slope times width at both ends, and the position of the
    /// height in the panel, from 0 to 1.
    #[inline]
    fn panel(&self, height: f64) -> ([[f64; 2]; 2], f64) {
        let scaled = height / self.spacing;
        // Clamped to the table; outside it the cubics of the end panels are used.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let panel = (scaled.max(0.0) as usize).min(self.nodes.len() - 2);
        let ends = [panel, panel + 1].map(|node| {
            let [potential, acceleration] = self.nodes[node];
            [potential, acceleration * self.spacing]
        });
        (ends, scaled - panel as f64)
    }
}

/// The derivative at a node, times the spacing, of the polynomial through the five nearest nodes.
fn slope(values: &[f64], node: usize) -> f64 {
    /// Weights at the first to the third of five nodes, times twelve.
    const WEIGHTS: [[f64; 5]; 3] =
        [[-25.0, 48.0, -36.0, 16.0, -3.0], [-3.0, -10.0, 18.0, -6.0, 1.0], [1.0, -8.0, 0.0, 8.0, -1.0]];
    let last = values.len() - 1;
    let sum = |weights: [f64; 5], place: &dyn Fn(usize) -> f64| -> f64 {
        weights.iter().enumerate().map(|(index, weight)| weight * place(index)).sum()
    };
    let twelvefold = match (node, last - node) {
        (0 | 1, _) => sum(WEIGHTS[node], &|index| values[index]),
        (_, from_end @ (0 | 1)) => -sum(WEIGHTS[from_end], &|index| values[last - index]),
        _ => sum(WEIGHTS[2], &|index| values[node + index - 2]),
    };
    twelvefold / 12.0
}

impl Field for DesignedField {
    #[inline]
    fn potential(&self, height: f64) -> f64 {
        let ([[u0, h0], [u1, h1]], s) = self.panel(height);
        let rise = u1 - u0;
        u0 + s * (h0 + s * (3.0 * rise - 2.0 * h0 - h1 + s * (h0 + h1 - 2.0 * rise)))
    }

    #[inline]
    fn acceleration(&self, height: f64) -> f64 {
        let ([[u0, h0], [u1, h1]], s) = self.panel(height);
        let rise = u1 - u0;
        let slope = h0 + s * (2.0 * (3.0 * rise - 2.0 * h0 - h1) + 3.0 * s * (h0 + h1 - 2.0 * rise));
        slope / self.spacing
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::equation_of_state::{CarnahanStarling, ModifiedKolafa, PercusYevickVirial};
    use crate::{Hydrostatics, Scene};
    use approx::assert_relative_eq;

    fn temperature() -> Isothermal {
        Isothermal::new(3.0).unwrap()
    }

    #[test]
    fn hydrostatics_gives_the_wanted_profile_back() {
        let slab = Slab::new(60.3, 5.0, 5.0).unwrap();
        let wanted = |x: f64| 0.47 - 0.44 * x / 60.3;
        let field = DesignedField::linear([0.47, 0.03], temperature(), ModifiedKolafa, &slab).unwrap();
        // From its pressure at the base, without walls.
        let pressure = 3.0 * number_density(0.47) * ModifiedKolafa.compressibility_factor(0.47);
        let theory = Hydrostatics::new(&field, temperature(), ModifiedKolafa).lid(60.3);
        let profile = theory.base_pressure(pressure).unwrap();
        for x in [0.5, 10.0, 33.3, 59.9] {
            assert_relative_eq!(profile.packing_fraction(x), wanted(x), max_relative = 1e-7);
        }
        // From its number of spheres, between walls.
        let scene = Scene::with_column_density(slab, field.column_density(), field, temperature()).unwrap();
        let profile = scene.hydrostatics(&ModifiedKolafa).unwrap();
        for x in [0.5, 10.0, 33.3, 59.5] {
            // A whole number of spheres.
            assert_relative_eq!(profile.packing_fraction(x), wanted(x), max_relative = 2e-3);
        }
        let rough = scene.hydrostatics(&PercusYevickVirial).unwrap();
        assert!((rough.packing_fraction(10.0) - wanted(10.0)).abs() > 1e-3);
    }

    #[test]
    fn the_acceleration_is_the_slope_up_to_both_walls() {
        let slab = Slab::new(20.0, 5.0, 5.0).unwrap();
        let wanted = |x: f64| {
            assert!((0.0..=20.0).contains(&x), "asked at {x}");
            0.25 + 0.1 * libm::sin(x)
        };
        let field = DesignedField::new(wanted, temperature(), CarnahanStarling, &slab).unwrap();
        super::super::probe(&field, &slab).unwrap();
        for x in [0.0_f64, 0.02, 0.5, 3.0, 19.99, 20.0] {
            let eta = wanted(x);
            let stiffness = CarnahanStarling.compressibility_factor(eta)
                + CarnahanStarling.compressibility_derivative(eta);
            let exact = -3.0 * 0.1 * libm::cos(x) * stiffness / eta;
            assert_relative_eq!(field.acceleration(x), exact, epsilon = 1e-4);
            if (1e-5..20.0 - 1e-5).contains(&x) {
                let difference = (field.potential(x + 1e-5) - field.potential(x - 1e-5)) / 2e-5;
                assert_relative_eq!(field.acceleration(x), difference, epsilon = 1e-4);
            }
        }
    }

    #[test]
    fn profiles_that_no_fluid_has_are_refused() {
        let slab = Slab::new(20.0, 5.0, 5.0).unwrap();
        for ends in [[0.3, 0.0], [0.75, 0.1], [f64::NAN, 0.1]] {
            let field = DesignedField::linear(ends, temperature(), CarnahanStarling, &slab);
            assert!(matches!(field, Err(Error::InvalidParameter { .. })));
        }
    }
}
