//! The theory of any scene: hydrostatic balance with a local equation of state.
//!
//! dP/dx = −n a and P = n T Z(η), eqs. (3) and (4) of doi:10.1103/PhysRevE.83.061306, for any
//! field, temperature and equation of state.
//!
//! The theory has no layers at a wall. Its column starts at the base with the bulk density, while
//! the centers of real spheres start half a diameter above the wall and form layers. The excess of
//! spheres in the layers is known, and [`Hydrostatics::between_walls`] places base and lid such
//! that the column above the layers is right. A local theory also fails where ln n changes by about
//! 1 over a diameter.

mod diagnostics;
mod layered;
mod march;
mod mirror;
mod profile;

pub use profile::{DomainExit, HydrostaticProfile};

use crate::equation_of_state::{DomainSide, EquationOfState};
use crate::legendre::Legendre;
use crate::{Error, Field, Scene, Slab, TemperatureProfile};
use march::{Column, Panel};
use mirror::{Mirrored, mirrored_error};
use std::cell::Cell;

/// A scene whose theory profile is to be computed.
///
/// Field, temperature and equation of state can be given by value or by reference.
///
/// ```
/// use gradient_mc::equation_of_state::CarnahanStarling;
/// use gradient_mc::field::UniformField;
/// use gradient_mc::hydrostatics::Hydrostatics;
/// use gradient_mc::temperature::ExponentialTemperature;
///
/// let field = UniformField::default();
/// let temperature = ExponentialTemperature::new(20.0, 0.05)?;
/// // 40 spheres above each unit of area
/// let profile = Hydrostatics::new(&field, &temperature, CarnahanStarling).column_density(40.0)?;
/// assert!((profile.center_of_mass() - 30.3647703980).abs() < 1e-9);
/// let (height, _) = profile.density_maximum();
/// assert!((height - 37.571095).abs() < 1e-6);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Hydrostatics<F, T, E> {
    field: F,
    temperature: T,
    equation_of_state: E,
    base: f64,
    lid: Option<f64>,
}

impl<F: Field, T: TemperatureProfile, E: EquationOfState> Hydrostatics<F, T, E> {
    /// The column with its base at x = 0, as in the paper, and open at the top.
    pub fn new(field: F, temperature: T, equation_of_state: E) -> Self {
        Self { field, temperature, equation_of_state, base: 0.0, lid: None }
    }

    /// Puts the base at `height`, at most 10⁶ diameters from x = 0 (0.5 is where the centers of
    /// real spheres start).
    #[must_use]
    pub fn base(mut self, height: f64) -> Self {
        self.base = height;
        self
    }

    /// Closes the column with a lid at `height`; needed if the field does not confine it.
    #[must_use]
    pub fn lid(mut self, height: f64) -> Self {
        self.lid = Some(height);
        self
    }

    /// Leaves the column open at the top, which is the default.
    #[must_use]
    pub fn open(mut self) -> Self {
        self.lid = None;
        self
    }

    /// Solves for `spheres` per unit of base area, N/A.
    ///
    /// Without a field, a density between fluid and solid has no unique profile, since the two
    /// phases can be anywhere. The error is then [`Error::HydrostaticsNotConverged`].
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] for a column density that is not positive and finite, a base
    /// that is too far from x = 0, or a lid that is not above the base; [`Error::InvalidField`] and
    /// [`Error::InvalidTemperature`] where the scene is not usable;
    /// [`Error::EquationOfStateExhausted`] if no state of the equation carries the weight;
    /// [`Error::UnboundedColumn`] if the column is open and the field does not hold it;
    /// [`Error::HydrostaticsNotConverged`] if the solver needs more than 60 000 panels (one or two
    /// seconds).
    pub fn column_density(&self, spheres: f64) -> Result<HydrostaticProfile, Error> {
        let spheres = Error::require_positive("column density", spheres)?;
        let column = self.column()?;
        let hangs = |lid: &f64| self.field.potential(*lid) < self.field.potential(self.base);
        let Some(lid) = self.lid.filter(hangs) else { return solve(&column, spheres) };
        let base = self.base;
        let (field, temperature) =
            (Mirrored { inner: &self.field, base, lid }, Mirrored { inner: &self.temperature, base, lid });
        let standing = Column {
            field: &field,
            temperature: &temperature,
            equation_of_state: &self.equation_of_state,
            base,
            lid: Some(lid),
            rule: column.rule,
            trials: Cell::new(0),
        };
        match solve(&standing, spheres) {
            Ok(profile) => Ok(profile.mirrored(base + lid)),
            Err(error) => Err(mirrored_error(error, base + lid)),
        }
    }

    /// Solves for `spheres` per unit of base area between the hard walls of `slab`, such that the
    /// column beyond the layers at the walls is correct.
    ///
    /// Centers begin half a diameter from a wall, and the layers there hold more of them than the
    /// bulk density would. By scaled-particle theory (Reiss, Frisch, Helfand and Lebowitz,
    /// doi:10.1063/1.1731020) the surface tension of a hard wall is γ = 3η(2 + η) T/(2π(1 − η)²
    /// d²), and a bulk profile with the same number of spheres begins at the distance dγ/dP = (1 −
    /// η)/(2(1 + 2η)) from the wall: 0.5 in a dilute gas, 0.25 at η = 0.25. In a uniform field the
    /// center of mass rises by this distance. For the paper's isothermal columns
    /// (doi:10.1103/PhysRevE.83.061306) it then agrees with density functional theory within 0.02.
    ///
    /// ```
    /// use gradient_mc::equation_of_state::CarnahanStarling;
    /// use gradient_mc::{Hydrostatics, Slab, field::UniformField, temperature::Isothermal};
    /// let theory = Hydrostatics::new(UniformField::default(), Isothermal::new(15.0)?, CarnahanStarling);
    /// let slab = Slab::new(400.0, 25.0, 25.0)?;
    /// // The functional White Bear II, which has this equation of state, gives 42.980.
    /// assert!((theory.between_walls(&slab, 40.0)?.center_of_mass() - 42.98).abs() < 0.02);
    /// # Ok::<(), gradient_mc::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`column_density`](Self::column_density).
    pub fn between_walls(&self, slab: &Slab, spheres: f64) -> Result<HydrostaticProfile, Error>
    where
        F: Clone,
        T: Clone,
        E: Clone,
    {
        self.between(Some(slab.height()), spheres)
    }

    /// The same between a wall at x = 0 and one at `lid`; open at the top for `None`.
    pub(crate) fn between(&self, lid: Option<f64>, spheres: f64) -> Result<HydrostaticProfile, Error>
    where
        F: Clone,
        T: Clone,
        E: Clone,
    {
        let with_walls = |from_base: f64, from_lid: f64| {
            let mut column = self.clone().base(from_base);
            column.lid = lid.map(|lid| lid - from_lid);
            column.column_density(spheres)
        };
        // In a very full box this leaves too little room for the fluid, but the whole box may hold
        // it.
        let near = with_walls(0.25, 0.25).or_else(|_| with_walls(0.0, 0.0))?;
        let at_lid = near.packing_fraction(near.top());
        // One step is enough: a shift of the base by 0.1 changes the packing fraction there by some
        // thousandths.
        with_walls(bulk_beginning(near.base_packing_fraction()), bulk_beginning(at_lid))
    }

    /// Solves for a given pressure at the base, in m g/d².
    ///
    /// # Errors
    /// As [`column_density`](Self::column_density).
    pub fn base_pressure(&self, pressure: f64) -> Result<HydrostaticProfile, Error> {
        let ln_pressure = libm::log(Error::require_positive("base pressure", pressure)?);
        let column = self.column()?;
        column.packing_fraction_at_base(ln_pressure)?;
        let panels = column.march(ln_pressure)?;
        HydrostaticProfile::new(&column, ln_pressure, panels)
    }

    fn column(&self) -> Result<Column<'_, F, T, E>, Error> {
        let base = Error::require_finite("base of the column", self.base)?;
        if base.abs() > Slab::MAXIMUM_EXTENT {
            // Farther away, heights are rounded too coarsely.
            let requirement = "it must lie within 1e6 diameters of x = 0";
            return Err(Error::InvalidParameter { name: "base of the column", value: base, requirement });
        }
        if let Some(lid) = self.lid {
            let lid = Error::require_finite("lid of the column", lid)?;
            // Closer to each other the two heights are equal to rounding.
            if lid - base < 1e-9 * lid.abs().max(base.abs()).max(1.0) {
                let requirement = "it must be above the base";
                return Err(Error::InvalidParameter { name: "lid of the column", value: lid, requirement });
            }
        }
        Ok(Column {
            field: &self.field,
            temperature: &self.temperature,
            equation_of_state: &self.equation_of_state,
            base,
            lid: self.lid,
            rule: Legendre::new(),
            trials: Cell::new(0),
        })
    }
}

/// Distance from a hard wall at which a bulk fluid begins that holds the same number of spheres as
/// the fluid with its layers.
pub(crate) fn bulk_beginning(packing_fraction: f64) -> f64 {
    let eta = packing_fraction.clamp(0.0, 1.0);
    (1.0 - eta) / (2.0 * (1.0 + 2.0 * eta))
}

impl<F: Field, T: TemperatureProfile> Scene<F, T> {
    /// The theory profile of this scene: [`Hydrostatics::between_walls`] with its field,
    /// temperature, slab and number of spheres.
    ///
    /// ```
    /// use gradient_mc::equation_of_state::ModifiedKolafa;
    /// use gradient_mc::{Scene, Slab, field::UniformField, temperature::Isothermal};
    /// let slab = Slab::new(400.0, 25.0, 25.0)?;
    /// let scene = Scene::with_column_density(slab, 40.0, UniformField::default(), Isothermal::new(15.0)?)?;
    /// let theory = scene.hydrostatics(&ModifiedKolafa)?;
    /// println!("{:.2} at the center of mass, {:.2}", theory.number_density(40.0), theory.center_of_mass());
    /// # Ok::<(), gradient_mc::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Hydrostatics::column_density`].
    pub fn hydrostatics<E: EquationOfState + ?Sized>(
        &self,
        equation_of_state: &E,
    ) -> Result<HydrostaticProfile, Error> {
        Hydrostatics::new(self.field(), self.temperature(), equation_of_state)
            .between_walls(self.slab(), self.column_density())
    }
}

/// The profile with a given N/A.
fn solve<F: Field, T: TemperatureProfile, E: EquationOfState>(
    column: &Column<'_, F, T, E>,
    spheres: f64,
) -> Result<HydrostaticProfile, Error> {
    let (ln_base_pressure, panels) = solve_for_mass(column, spheres)?;
    HydrostaticProfile::new(column, ln_base_pressure, panels)
}

/// Finds ln P at the base for a given N/A by a bracketed secant in ln P and ln N, which is nearly a
/// straight line.
///
/// On the way up a perturbation of ln P grows at most by the ratio of Z between base and top, so
/// this is well conditioned.
fn solve_for_mass<F: Field, T: TemperatureProfile, E: EquationOfState>(
    column: &Column<'_, F, T, E>,
    spheres: f64,
) -> Result<(f64, Vec<Panel>), Error> {
    /// The logarithm used for a column density that is zero to rounding.
    const EMPTY: f64 = -700.0;
    const GOOD: f64 = 2e-14;
    const GOOD_ENOUGH: f64 = 1e-11;
    let wanted = libm::log(spheres);
    let temperature = column.temperature(column.base)?;
    let weight = column.field.acceleration(column.base).abs();
    let dilution = column.lid.map_or(0.0, |lid| temperature / (lid - column.base));
    // Exact for a uniform field and for a weightless box of points.
    let scale = weight.max(dilution);
    let mut guess = wanted + if scale > 0.0 && scale.is_finite() { libm::log(scale) } else { 0.0 };
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    let mut previous: Option<(f64, f64)> = None;
    let mut best: Option<(f64, f64, Vec<Panel>)> = None;
    let mut exhausted = None;
    let mut too_light = false;
    let mut longest_step = 2.0;
    for _ in 0..120 {
        let solution = match column.march(guess) {
            Err(Error::EquationOfStateExhausted { height, reduced_pressure, side }) => {
                let error = Error::EquationOfStateExhausted { height, reduced_pressure, side };
                too_light = side == DomainSide::Below;
                if too_light && column.lid.is_none() {
                    // An open column is arbitrarily dilute at its top.
                    return Err(error);
                }
                exhausted = Some(error);
                None
            }
            other => Some(other?),
        };
        let mut slope = 1.0;
        let residual = if let Some(panels) = solution {
            let mass: f64 = panels.iter().map(|panel| panel.mass).sum();
            let residual = libm::log(mass).max(EMPTY) - wanted;
            if let Some((at, value)) = previous
                && (guess - at).abs() > 0.0
            {
                slope = ((residual - value) / (guess - at)).clamp(0.01, 10.0);
            }
            previous = Some((guess, residual));
            if best.as_ref().is_none_or(|(smallest, ..)| residual.abs() < *smallest) {
                best = Some((residual.abs(), guess, panels));
            } else if best.as_ref().is_some_and(|(smallest, ..)| *smallest < GOOD_ENOUGH) {
                // No more progress, because of rounding.
                break;
            }
            if residual.abs() <= GOOD {
                break;
            }
            residual
        } else if too_light {
            f64::NEG_INFINITY
        } else {
            f64::INFINITY
        };
        if residual > 0.0 {
            high = high.min(guess);
        } else {
            low = low.max(guess);
        }
        let step = (-residual / slope).clamp(-longest_step, longest_step);
        let proposal = guess + step;
        let inside = proposal > low && proposal < high;
        longest_step *= 2.0;
        guess = if inside && residual.is_finite() {
            proposal
        } else if low.is_finite() && high.is_finite() {
            0.5 * (low + high)
        } else if inside {
            proposal
        } else {
            break;
        };
        if guess <= low || guess >= high {
            break;
        }
    }
    match best {
        Some((residual, ln_base_pressure, panels)) if residual < GOOD_ENOUGH => {
            Ok((ln_base_pressure, panels))
        }
        // The column cannot be made heavy enough because the equation of state ends.
        best => Err(exhausted.unwrap_or(Error::HydrostaticsNotConverged {
            height: column.base,
            residual: best.map_or(f64::INFINITY, |(residual, ..)| residual),
        })),
    }
}
