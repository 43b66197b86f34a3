//! Solves a column by a density functional.

use super::grid::Grid;
use super::potential::Potential;
use super::profile::LayeredProfile;
use super::solution::{Given, Problem, Solution};
use super::{Bulk, Functional, RADIUS};
use crate::equation_of_state::{EquationOfState, number_density};
use crate::legendre::{Legendre, ORDER, evaluate};
use crate::{Error, Field, HydrostaticProfile, Hydrostatics, Scene, TemperatureProfile, Wall};

/// A column whose profile is to be computed by a density functional, layers at the walls included.
///
/// The base is a hard wall at x = 0, so that centers begin at x = ½. Field, temperature and
/// functional can be given by value or by reference.
///
/// n(x) minimizes the grand potential: ln n = μ − u(x) − δ∫Φ dx/δn, with u = φ/T. Where the
/// temperature varies, u is the effective potential of the [`drive`](crate::drive), which is
/// self-consistent with n(x).
///
/// ```
/// use gradient_mc::functional::{DensityFunctional, WhiteBear2};
/// use gradient_mc::{field::UniformField, temperature::Isothermal};
/// let column = DensityFunctional::new(UniformField::default(), Isothermal::new(5.0)?, WhiteBear2);
/// let profile = column.lid(150.0).column_density(20.0)?;
/// // The contact theorem: the base carries the weight of the column.
/// assert!((5.0 * profile.number_density(0.5) - 20.0).abs() < 1e-6);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct DensityFunctional<F, T, W> {
    field: F,
    temperature: T,
    functional: W,
    lid: Option<f64>,
}

impl<F: Field, T: TemperatureProfile, W: Functional> DensityFunctional<F, T, W> {
    /// A column on its base that is open at the top.
    pub fn new(field: F, temperature: T, functional: W) -> Self {
        Self { field, temperature, functional, lid: None }
    }

    /// Closes the column with a wall at `height`. The highest centers are half a diameter below it.
    #[must_use]
    pub fn lid(mut self, height: f64) -> Self {
        self.lid = Some(height);
        self
    }

    /// Solves for `spheres` per unit of base area, N/A.
    ///
    /// # Errors
    /// Those of [`Hydrostatics::column_density`], whose profile is the first guess;
    /// [`Error::BeyondFreezing`] if the fluid would freeze; [`Error::FunctionalTooSteep`] for a
    /// field or temperature that changes too fast, such as a jump;
    /// [`Error::FunctionalNotConverged`].
    pub fn column_density(&self, spheres: f64) -> Result<LayeredProfile, Error> {
        let spheres = Error::require_positive("column density", spheres)?;
        let start = self.hydrostatics().between(self.lid, spheres)?;
        self.solve(&start, Given::ColumnDensity(spheres))
    }

    /// Solves for a chemical potential over temperature, μ = ln n + μₑₓ(n) + u of a uniform fluid,
    /// with u = φ/T half a diameter above the base.
    ///
    /// # Errors
    /// As [`column_density`](Self::column_density), and [`Error::InvalidParameter`] unless it is
    /// finite.
    pub fn chemical_potential(&self, potential: f64) -> Result<LayeredProfile, Error> {
        let given = Error::require_finite("chemical potential", potential)?;
        let temperature = self.temperature.temperature(RADIUS);
        let pressure =
            temperature * self.reduced_pressure(given - self.field.potential(RADIUS) / temperature);
        let mut hydrostatics = self.hydrostatics().base(RADIUS);
        if let Some(lid) = self.lid {
            hydrostatics = hydrostatics.lid(lid - RADIUS);
        }
        self.solve(&hydrostatics.base_pressure(pressure)?, Given::ChemicalPotential(given))
    }

    /// Adsorption at the base of a column at constant temperature: spheres per area minus those of
    /// the functional's local theory with the same chemical potential, whose density begins at the
    /// wall at x = 0. It is negative if the half diameter without centers counts more than the
    /// layers. A lid that carries part of the column contributes too.
    ///
    /// # Errors
    /// Those of [`Hydrostatics::base_pressure`]. [`Error::InvalidParameter`] if the temperature
    /// varies, where this reference is not defined.
    pub fn adsorption(&self, profile: &LayeredProfile) -> Result<f64, Error> {
        let Some(temperature) = self.temperature.constant() else {
            let requirement = "the adsorption is defined at constant temperature";
            let value = self.temperature.temperature(RADIUS);
            return Err(Error::InvalidParameter { name: "temperature", value, requirement });
        };
        let local = profile.chemical_potential() - self.field.potential(0.0) / temperature;
        let mut hydrostatics = self.hydrostatics();
        if let Some(lid) = self.lid {
            hydrostatics = hydrostatics.lid(lid);
        }
        let bulk = hydrostatics.base_pressure(temperature * self.reduced_pressure(local))?;
        Ok(profile.column_density() - bulk.column_density())
    }

    /// P/T of the uniform fluid at a chemical potential.
    fn reduced_pressure(&self, chemical_potential: f64) -> f64 {
        let bulk = Bulk(&self.functional);
        let beyond = |eta: f64| {
            libm::log(number_density(eta)) + bulk.excess_chemical_potential(eta) > chemical_potential
        };
        let (mut low, mut high) = (f64::MIN_POSITIVE, 0.9);
        // Bisection, at first of the logarithm.
        for _ in 0..100 {
            let middle = if low < 0.01 * high { (low * high).sqrt() } else { f64::midpoint(low, high) };
            if beyond(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        number_density(low) * bulk.compressibility_factor(low)
    }

    fn hydrostatics(&self) -> Hydrostatics<&F, &T, Bulk<&W>> {
        Hydrostatics::new(&self.field, &self.temperature, Bulk(&self.functional))
    }

    fn solve(&self, start: &HydrostaticProfile, given: Given) -> Result<LayeredProfile, Error> {
        /// Number of refinements of the grid.
        const REFINEMENTS: u32 = 12;
        let highest = self.lid.map_or(f64::INFINITY, |lid| lid - RADIUS);
        if highest - RADIUS < 2.0 * Grid::NARROWEST {
            let requirement = "a lid must leave room for centers, above 1";
            return Err(Error::InvalidParameter {
                name: "lid of the column",
                value: highest + RADIUS,
                requirement,
            });
        }
        if let Some(exit) = start.domain_exit() {
            return Err(Error::BeyondFreezing {
                height: exit.lowest_height,
                packing_fraction: exit.packing_fraction,
            });
        }
        let rule = Legendre::new();
        let (ends, walls) = self.ends(start);
        let open_end = self.open_end(ends);
        let ratio = {
            let (end, wall) = match open_end {
                Wall::Base => (ends[0], walls[0]),
                Wall::Lid => (ends[1], walls[1]),
            };
            if wall {
                self.temperature.temperature(end)
            } else {
                start.pressure(end) / start.number_density(end)
            }
        };
        let constant = self.temperature.constant();
        let mut grid = self.fitted(&rule, Grid::new(&rule, ends, walls), start, constant)?;
        let mut logarithms: Vec<f64> = grid.nodes.iter().map(|&height| logarithm(start, height)).collect();
        let (mut iterations, mut refinements) = (0, 0);
        loop {
            let potential = Potential::new(&self.field, &self.temperature, constant, &grid, open_end, ratio)?;
            let problem = Problem::new(&rule, &self.functional, grid, potential, given);
            let mut solution = problem.solve(logarithms)?;
            iterations += solution.iterations;
            solution.iterations = iterations;
            let (coarse, worst) = unresolved(&rule, &problem.grid, &solution);
            if coarse.is_empty() {
                return Ok(LayeredProfile::new(&rule, &problem, &solution, start));
            }
            if refinements == REFINEMENTS {
                return Err(worst);
            }
            refinements += 1;
            grid = problem.grid.halved(&rule, &coarse);
            logarithms = grid
                .nodes
                .iter()
                .map(|&height| problem.grid.interpolate(&rule, &solution.logarithms, height))
                .collect();
        }
    }

    /// The lowest and the highest centers, and whether each is at a wall. Beyond an end without a
    /// wall the density is negligible.
    fn ends(&self, start: &HydrostaticProfile) -> ([f64; 2], [bool; 2]) {
        /// A negligible share of the spheres.
        const NOTHING: f64 = 1e-15;
        let nothing = NOTHING * start.column_density();
        let lid = self.lid.map(|lid| lid - RADIUS);
        let top = start.edges().find(|&height| start.column_above(height) < nothing).unwrap_or(start.top());
        let base = start.edges().take_while(|&height| start.column_below(height) < nothing).last();
        let (low, floor) = match base {
            Some(base) if base > RADIUS => (base, false),
            _ => (RADIUS, true),
        };
        match lid {
            Some(lid) if top >= lid - 1.0 => ([low, lid], [floor, true]),
            _ => ([low, top], [floor, false]),
        }
    }

    fn open_end(&self, [low, high]: [f64; 2]) -> Wall {
        if self.field.potential(high) >= self.field.potential(low) { Wall::Lid } else { Wall::Base }
    }

    /// The grid with panels halved until field, temperature and the start are smooth on each.
    fn fitted(
        &self,
        rule: &Legendre,
        mut grid: Grid,
        start: &HydrostaticProfile,
        constant: Option<f64>,
    ) -> Result<Grid, Error> {
        /// Largest change of ln n over a panel.
        const LARGEST_CHANGE: f64 = 4.0;
        /// Largest error of the polynomials for the start, and for ln T.
        const TOLERANCE: f64 = 1e-8;
        const MOST_NODES: usize = 200_000;
        loop {
            let mut coarse = Vec::new();
            for (panel, [begin, end]) in grid.panels().enumerate() {
                let change = logarithm(start, end) - logarithm(start, begin);
                let mut mismatch = start_mismatch(rule, start, [begin, end]);
                if constant.is_none() {
                    let gradient = rule.nodes.map(|t| {
                        self.temperature.logarithmic_gradient(begin + 0.5 * (end - begin) * (t + 1.0))
                    });
                    let rise =
                        libm::log(self.temperature.temperature(end) / self.temperature.temperature(begin));
                    mismatch = mismatch.max((0.5 * (end - begin) * rule.integrate(&gradient) - rise).abs());
                }
                mismatch *= importance([begin, end]);
                if change.abs() > LARGEST_CHANGE || mismatch > TOLERANCE {
                    if end - begin < 100.0 * Grid::NARROWEST {
                        return Err(Error::FunctionalTooSteep {
                            height: begin,
                            tail: change.abs().max(mismatch),
                        });
                    }
                    coarse.push(panel);
                }
            }
            if coarse.is_empty() {
                return Ok(grid);
            }
            if grid.nodes.len() > MOST_NODES {
                let height = grid.ends()[0];
                return Err(Error::FunctionalTooSteep { height, tail: f64::INFINITY });
            }
            grid = grid.halved(rule, &coarse);
        }
    }
}

/// ln n of a hydrostatic profile, also where it has ended.
fn logarithm(profile: &HydrostaticProfile, height: f64) -> f64 {
    libm::log(profile.number_density(height.clamp(profile.base(), profile.top())).max(f64::MIN_POSITIVE))
}

/// Weight of an error on a panel: averages over spheres are insensitive to narrow panels.
fn importance([begin, end]: [f64; 2]) -> f64 {
    ((end - begin) / RADIUS).min(1.0)
}

/// Largest deviation between the nodes of the polynomial through ln n of the start.
fn start_mismatch(rule: &Legendre, start: &HydrostaticProfile, [begin, end]: [f64; 2]) -> f64 {
    let height = |t: f64| begin + 0.5 * (end - begin) * (t + 1.0);
    let series = rule.coefficients(&rule.nodes.map(|t| logarithm(start, height(t))));
    let between = rule.nodes.windows(2).map(|nodes| f64::midpoint(nodes[0], nodes[1]));
    between.map(|t| (evaluate(&series, t) - logarithm(start, height(t))).abs()).fold(0.0, f64::max)
}

/// Panels on which the polynomials have not converged, and the error for the worst one.
fn unresolved(rule: &Legendre, grid: &Grid, solution: &Solution) -> (Vec<usize>, Error) {
    /// Largest of the last coefficients of n, relative to the mean on the panel.
    const TOLERANCE: f64 = 1e-8;
    let densities = &solution.state.densities;
    let highest = densities.iter().copied().fold(0.0, f64::max);
    let mut coarse = Vec::new();
    let mut worst = (0.0, 0.0);
    for (panel, [height, end]) in grid.panels().enumerate() {
        let series = rule.coefficients(&Grid::values(panel, densities));
        let scale = series[0].abs() + 1e-9 * highest;
        let tail = series[ORDER - 3..].iter().fold(0.0, |tail: f64, value| tail.max(value.abs())) / scale;
        let tail = tail * importance([height, end]);
        if tail > TOLERANCE {
            coarse.push(panel);
            if tail > worst.1 {
                worst = (height, tail);
            }
        }
    }
    let (height, tail) = worst;
    (coarse, Error::FunctionalTooSteep { height, tail })
}

impl<F: Field, T: TemperatureProfile> Scene<F, T> {
    /// The profile of this scene by a density functional: [`DensityFunctional`] with its field,
    /// temperature, slab and number of spheres.
    ///
    /// ```
    /// use gradient_mc::functional::WhiteBear2;
    /// use gradient_mc::{Scene, Slab, field::UniformField, temperature::Isothermal};
    /// let slab = Slab::new(60.0, 6.0, 6.0)?;
    /// let scene = Scene::new(slab, 360, UniformField::default(), Isothermal::new(5.0)?)?;
    /// let layers = scene.density_functional(&WhiteBear2)?;
    /// println!("{:.3} at contact, {:.3} above it", layers.number_density(0.5), layers.number_density(1.0));
    /// # Ok::<(), gradient_mc::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`DensityFunctional::column_density`].
    pub fn density_functional<W: Functional + ?Sized>(
        &self,
        functional: &W,
    ) -> Result<LayeredProfile, Error> {
        DensityFunctional::new(self.field(), self.temperature(), functional)
            .lid(self.slab().height())
            .column_density(self.column_density())
    }
}
