//! The solution of a column.

use super::march::{Column, Panel};
use crate::equation_of_state::{Domain, DomainSide, EquationOfState, FluidSolid, packing_fraction};
use crate::legendre::{evaluate, evaluate_integral};
use crate::{Error, Field, TemperatureProfile};

/// The theory profile of a scene; made by [`Hydrostatics`](super::Hydrostatics).
///
/// It borrows nothing. Between its nodes ln n is a polynomial of degree 15 that is within 10⁻⁹ of
/// the solution (usually within 10⁻¹³). Jumps are kept.
///
/// The profile does not end where the equation of state leaves its domain. Check this with
/// [`domain_exit`](Self::domain_exit).
#[derive(Debug, Clone)]
pub struct HydrostaticProfile {
    pub(super) panels: Vec<Panel>,
    /// Spheres per area below each panel.
    pub(super) below: Vec<f64>,
    /// Spheres per area above each panel.
    pub(super) above: Vec<f64>,
    pub(super) base: f64,
    pub(super) top: f64,
    pub(super) column_density: f64,
    pub(super) center_of_mass: f64,
    pub(super) ln_base_pressure: f64,
    pub(super) base_packing_fraction: f64,
    pub(super) lid_pressure: f64,
    pub(super) density_maximum: (f64, f64),
    pub(super) domain_exit: Option<DomainExit>,
    /// Relative deviation of Z from the best equation of state, at the densest point.
    pub(super) deviation: f64,
}

/// Where a profile leaves the domain of its equation of state.
///
/// For a fluid equation of state, [`DomainSide::Above`] is the part of the column that freezes.
///
/// ```
/// use gradient_mc::equation_of_state::{CarnahanStarling, DomainSide};
/// use gradient_mc::{Hydrostatics, field::UniformField, temperature::Isothermal};
/// let theory = Hydrostatics::new(UniformField::default(), Isothermal::new(2.5)?, CarnahanStarling);
/// let exit = theory.column_density(40.0)?.domain_exit().ok_or("a fluid at all heights")?;
/// assert_eq!((exit.side, exit.lowest_height), (DomainSide::Above, 0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DomainExit {
    /// Lowest height outside the domain.
    pub lowest_height: f64,
    /// Highest height outside the domain.
    pub highest_height: f64,
    /// The packing fraction farthest outside.
    pub packing_fraction: f64,
    /// The limit that it passes.
    pub limit: f64,
    /// Which limit that is: too dilute or too dense.
    pub side: DomainSide,
}

/// Cumulated spheres per area, by panel.
pub(super) struct Cumulated {
    pub(super) below: Vec<f64>,
    /// Summed from the thin end, so that small values are precise.
    pub(super) above: Vec<f64>,
    pub(super) column_density: f64,
}

impl Cumulated {
    pub(super) fn of(panels: &[Panel]) -> Self {
        /// The sum before each panel, and the sum of all.
        fn before<'a>(panels: impl Iterator<Item = &'a Panel>) -> (Vec<f64>, f64) {
            let mut sum = 0.0;
            let sums = panels
                .map(|panel| {
                    let here = sum;
                    sum += panel.mass;
                    here
                })
                .collect();
            (sums, sum)
        }
        let (below, _) = before(panels.iter());
        let (mut above, column_density) = before(panels.iter().rev());
        above.reverse();
        Self { below, above, column_density }
    }
}

impl HydrostaticProfile {
    pub(super) fn new<F: Field, T: TemperatureProfile, E: EquationOfState>(
        column: &Column<'_, F, T, E>,
        ln_base_pressure: f64,
        panels: Vec<Panel>,
    ) -> Result<Self, Error> {
        let Cumulated { below, above, column_density } = Cumulated::of(&panels);
        let moment: f64 = panels.iter().rev().map(|panel| panel.moment).sum();
        let top = panels.last().map_or(column.base, |panel| panel.end);
        let lid_pressure = panels
            .last()
            .filter(|panel| column.lid.is_some_and(|lid| panel.end >= lid))
            .map_or(0.0, |panel| libm::exp(evaluate(&panel.ln_pressure, 1.0)));
        let center_of_mass = column.base + moment / column_density;
        if !center_of_mass.is_finite() {
            // The mass is zero, or not finite.
            return Err(Error::HydrostaticsNotConverged { height: column.base, residual: f64::INFINITY });
        }
        let density_maximum = column.densest(&panels);
        let mut profile = Self {
            below,
            above,
            base: column.base,
            top,
            column_density,
            center_of_mass,
            ln_base_pressure,
            base_packing_fraction: column.packing_fraction_at_base(ln_base_pressure)?,
            lid_pressure,
            density_maximum,
            domain_exit: None,
            deviation: 0.0,
            panels,
        };
        let densest = packing_fraction(density_maximum.1);
        profile.deviation = column.equation_of_state.compressibility_factor(densest)
            / FluidSolid::default().compressibility_factor(densest)
            - 1.0;
        profile.domain_exit = profile.find_exit(column.equation_of_state.domain());
        Ok(profile)
    }

    /// Number density n(x); 0 below the base and above the top.
    #[must_use]
    pub fn number_density(&self, height: f64) -> f64 {
        self.panel(height).map_or(0.0, |panel| panel.density_at(height))
    }

    /// Packing fraction η(x) = πn/6.
    #[must_use]
    pub fn packing_fraction(&self, height: f64) -> f64 {
        packing_fraction(self.number_density(height))
    }

    /// Pressure P(x), in m g/d²; 0 below the base and above the top.
    ///
    /// It is the weight of the spheres above plus the pressure on the lid.
    #[must_use]
    pub fn pressure(&self, height: f64) -> f64 {
        self.panel(height)
            .map_or(0.0, |panel| libm::exp(evaluate(&panel.ln_pressure, panel.abscissa(height))))
    }

    /// Height of the base.
    #[must_use]
    pub fn base(&self) -> f64 {
        self.base
    }

    /// Height of the lid; in an open column, where the pressure falls to 10⁻³⁰⁰ of its maximum.
    #[must_use]
    pub fn top(&self) -> f64 {
        self.top
    }

    /// Spheres per unit of base area, N/A.
    #[must_use]
    pub fn column_density(&self) -> f64 {
        self.column_density
    }

    /// Height of the center of mass.
    #[must_use]
    pub fn center_of_mass(&self) -> f64 {
        self.center_of_mass
    }

    /// Pressure at the base, in m g/d².
    #[must_use]
    pub fn base_pressure(&self) -> f64 {
        libm::exp(self.ln_base_pressure)
    }

    /// Packing fraction at the base.
    #[must_use]
    pub fn base_packing_fraction(&self) -> f64 {
        self.base_packing_fraction
    }

    /// Pressure on the lid, in m g/d²; 0 for an open column.
    #[must_use]
    pub fn lid_pressure(&self) -> f64 {
        self.lid_pressure
    }

    /// Height and number density of the densest point, inside or at the base.
    #[must_use]
    pub fn density_maximum(&self) -> (f64, f64) {
        self.density_maximum
    }

    /// Relative deviation of Z from the best equation of state, at the densest point.
    pub(super) fn deviation_of_equation(&self) -> f64 {
        self.deviation
    }

    /// Spheres per unit area between the base and `height`.
    #[must_use]
    pub fn column_below(&self, height: f64) -> f64 {
        if height >= self.top {
            return self.column_density;
        }
        self.index(height).map_or(0.0, |index| self.below[index] + self.panels[index].mass_below(height))
    }

    /// Spheres per unit area above `height`, with full relative precision.
    #[must_use]
    pub fn column_above(&self, height: f64) -> f64 {
        if height <= self.base {
            return self.column_density;
        }
        self.index(height).map_or(0.0, |index| {
            let panel = &self.panels[index];
            self.above[index] + (panel.mass - panel.mass_below(height)).max(0.0)
        })
    }

    /// Height below which `fraction` of the spheres lie; fractions outside [0, 1] are clamped.
    ///
    /// Evenly spaced or uniformly random fractions give heights distributed as the profile.
    ///
    /// ```
    /// # use gradient_mc::{equation_of_state::IdealGas, field::UniformField};
    /// # use gradient_mc::{hydrostatics::Hydrostatics, temperature::Isothermal};
    /// let temperature = Isothermal::new(10.0)?;
    /// let gas = Hydrostatics::new(UniformField::default(), temperature, IdealGas).column_density(1.0)?;
    /// // half of an isothermal atmosphere lies below T ln 2
    /// assert!((gas.height_of_fraction(0.5) - 10.0 * 2f64.ln()).abs() < 1e-12);
    /// # Ok::<(), gradient_mc::Error>(())
    /// ```
    #[must_use]
    pub fn height_of_fraction(&self, fraction: f64) -> f64 {
        if fraction.is_nan() {
            return fraction;
        }
        if fraction <= 0.0 {
            return self.base;
        }
        if fraction >= 1.0 {
            return self.top;
        }
        let wanted = fraction * self.column_density;
        let index = self.below.partition_point(|&below| below <= wanted).saturating_sub(1);
        let Some(panel) = self.panels.get(index) else {
            return self.base;
        };
        let wanted = wanted - self.below[index];
        let (mut low, mut high) = (panel.start, panel.end);
        let mut height = low + (high - low) * (wanted / panel.mass).clamp(0.0, 1.0);
        // Newton's method inside a bracket.
        for _ in 0..60 {
            let excess = panel.mass_below(height) - wanted;
            if excess > 0.0 {
                high = height;
            } else {
                low = height;
            }
            if excess.abs() <= 2.0 * f64::EPSILON * panel.mass {
                break;
            }
            let step = excess / panel.density_at(height);
            let proposal = height - step;
            let next = if proposal > low && proposal < high { proposal } else { 0.5 * (low + high) };
            let change = (next - height).abs();
            height = next;
            if change <= 4.0 * f64::EPSILON * height.abs().max(1.0) {
                break;
            }
        }
        height
    }

    /// The part of the column outside the [`Domain`] of the equation of state, if any. For a fluid
    /// equation it freezes there.
    #[must_use]
    pub fn domain_exit(&self) -> Option<DomainExit> {
        self.domain_exit
    }

    /// Heights of jumps with the densities just below and above.
    pub(super) fn jumps(&self) -> impl Iterator<Item = (f64, [f64; 2])> {
        self.panels.iter().filter(|panel| panel.jump).map(|panel| (panel.start, panel.edges))
    }

    fn index(&self, height: f64) -> Option<usize> {
        if !(height >= self.base && height <= self.top) || self.panels.is_empty() {
            return None;
        }
        Some(self.panels.partition_point(|panel| panel.end <= height).min(self.panels.len() - 1))
    }

    fn panel(&self, height: f64) -> Option<&Panel> {
        self.index(height).map(|index| &self.panels[index])
    }

    /// The range of the heights outside `domain`, with its ends refined by bisection.
    fn find_exit(&self, domain: Domain) -> Option<DomainExit> {
        /// Samples per panel, both ends included.
        const SAMPLES: u32 = 17;
        let mut heights: Vec<f64> = self
            .panels
            .iter()
            .flat_map(|panel| {
                (0..SAMPLES).map(|sample| panel.height(2.0 * f64::from(sample) / f64::from(SAMPLES) - 1.0))
            })
            .collect();
        heights.push(self.top);
        heights.push(self.density_maximum.0);
        heights.sort_by(f64::total_cmp);
        let etas: Vec<f64> = heights.iter().map(|&height| self.packing_fraction(height)).collect();
        let outside = |eta: f64| domain.side(eta).is_some();
        let first = etas.iter().position(|&eta| outside(eta))?;
        let last = etas.iter().rposition(|&eta| outside(eta))?;
        let refine = |mut inside: f64, mut out: f64| {
            for _ in 0..60 {
                let middle = 0.5 * (inside + out);
                if outside(self.packing_fraction(middle)) {
                    out = middle;
                } else {
                    inside = middle;
                }
            }
            out
        };
        let lowest_height = if first == 0 { heights[0] } else { refine(heights[first - 1], heights[first]) };
        let highest_height =
            heights.get(last + 1).map_or(heights[last], |&inside| refine(inside, heights[last]));
        let (least, most) =
            etas.iter().fold((f64::INFINITY, 0.0_f64), |(least, most), &eta| (least.min(eta), most.max(eta)));
        let (packing_fraction, limit, side) = if most > domain.highest {
            (most, domain.highest, DomainSide::Above)
        } else {
            (least, domain.lowest, DomainSide::Below)
        };
        Some(DomainExit { lowest_height, highest_height, packing_fraction, limit, side })
    }
}

impl Panel {
    /// Number density at a height of this panel.
    fn density_at(&self, height: f64) -> f64 {
        let t = self.abscissa(height);
        if self.jump {
            // The density of either side of the jump.
            self.edges[usize::from(t >= 0.0)]
        } else {
            libm::exp(evaluate(&self.ln_density, t))
        }
    }

    /// ∫ n dx from the start of this panel to a height in it.
    fn mass_below(&self, height: f64) -> f64 {
        let t = self.abscissa(height);
        let mass = if self.jump {
            0.5 * (t + 1.0) * self.mass
        } else {
            0.5 * (self.end - self.start) * evaluate_integral(&self.density, t)
        };
        mass.clamp(0.0, self.mass)
    }
}
