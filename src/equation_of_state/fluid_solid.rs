//! A fluid and a solid equation, joined at the phase transition.

use super::{Domain, EquationOfState, FREEZING, MELTING, ModifiedKolafa, SpeedySolid};
use crate::Error;

/// The state at which fluid and solid coexist.
///
/// The default is that of hard spheres: P/T = 11.5727(10), from simulations of up to 2916 spheres
/// extrapolated to infinitely many, where the fluid has 0.4918 and the solid 0.5434. L. A.
/// Fernandez, V. Martin-Mayor, B. Seoane and P. Verrocchio, Phys. Rev. Lett. 108, 165701 (2012),
/// doi:10.1103/PhysRevLett.108.165701.
///
/// ```
/// use gradient_mc::equation_of_state::{Coexistence, EquationOfState, ModifiedKolafa, number_density};
/// let spheres = Coexistence::default();
/// // The fluid reaches this pressure at the packing fraction of coexistence.
/// let eta = spheres.fluid;
/// let reduced_pressure = number_density(eta) * ModifiedKolafa.compressibility_factor(eta);
/// assert!((reduced_pressure / spheres.reduced_pressure - 1.0).abs() < 0.01);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coexistence {
    /// Packing fraction of the fluid.
    pub fluid: f64,
    /// Packing fraction of the solid.
    pub solid: f64,
    /// P/T of both phases, in inverse cubic diameters.
    pub reduced_pressure: f64,
}

impl Default for Coexistence {
    fn default() -> Self {
        Self { fluid: FREEZING, solid: MELTING, reduced_pressure: 11.5727 }
    }
}

/// An equation of state of the fluid below the transition, of the solid above it, and of both
/// phases in coexistence between.
///
/// The pressures of a fluid and a solid equation at the two packing fractions of a [`Coexistence`]
/// are never exactly equal. Therefore the pressure defines the transition: each equation is used up
/// to the packing fraction at which it reaches this pressure, and the given packing fractions only
/// start the two searches. [`coexistence`](Self::coexistence) returns the packing fractions found.
/// Between them P/T is constant, so Z decreases as 1/η.
/// [`packing_fraction_at`](EquationOfState::packing_fraction_at) jumps at the pressure of
/// coexistence, where it returns the fluid, and a column has a sharp front.
///
/// The chemical potential is continuous: that of the solid is shifted to the value of the fluid at
/// the transition, so the integration constant of the solid equation is not used.
///
/// ```
/// use gradient_mc::equation_of_state::{Coexistence, EquationOfState, FluidSolid, ModifiedKolafa, SpeedySolid};
/// let spheres = FluidSolid::new(ModifiedKolafa, SpeedySolid, Coexistence::default())?;
/// let (below, above) = (spheres.packing_fraction_at(11.57, None), spheres.packing_fraction_at(11.58, None));
/// assert!(below.unwrap() < 0.493 && above.unwrap() > 0.543);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FluidSolid<F = ModifiedKolafa, S = SpeedySolid> {
    fluid: F,
    solid: S,
    cuts: Coexistence,
}

impl Default for FluidSolid {
    /// The most accurate equation of the library: the modified Kolafa-Labík-Malijevský fluid and
    /// Speedy's solid, joined at P/T = 11.5727.
    fn default() -> Self {
        // The values that `new` finds, with the same bits; a test checks this.
        let cuts = Coexistence {
            fluid: 0.491_833_794_350_635_07,
            solid: 0.543_372_812_198_733,
            ..Coexistence::default()
        };
        Self { fluid: ModifiedKolafa, solid: SpeedySolid, cuts }
    }
}

impl<F: EquationOfState, S: EquationOfState> FluidSolid<F, S> {
    /// Joins the two at the pressure of `coexistence`.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] if one of them does not reach this pressure, or the solid is not
    /// denser than the fluid.
    pub fn new(fluid: F, solid: S, coexistence: Coexistence) -> Result<Self, Error> {
        let pressure = Error::require_positive("P/T of coexistence", coexistence.reduced_pressure)?;
        let invalid = |requirement| Error::InvalidParameter {
            name: "P/T of coexistence",
            value: pressure,
            requirement,
        };
        let liquid = fluid
            .packing_fraction_at(pressure, Some(coexistence.fluid))
            .ok_or_else(|| invalid("the fluid equation of state must reach it"))?;
        let crystal = solid
            .packing_fraction_at(pressure, Some(coexistence.solid))
            .ok_or_else(|| invalid("the solid equation of state must reach it"))?;
        if crystal <= liquid {
            return Err(invalid("the solid must be denser there than the fluid"));
        }
        let cuts = Coexistence { fluid: liquid, solid: crystal, reduced_pressure: pressure };
        Ok(Self { fluid, solid, cuts })
    }

    /// Joins the two at the pressure at which their chemical potentials are equal.
    ///
    /// Here the integration constant of the solid is used. With that of [`SpeedySolid`] the
    /// transition is at P/T = 11.571 for [`ModifiedKolafa`] and 11.572 for
    /// [`HansenGoos`](super::HansenGoos), while simulations of coexistence give 11.5727(10).
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] if the chemical potentials are not equal at any P/T between 11
    /// and 13.
    ///
    /// ```
    /// use gradient_mc::equation_of_state::{FluidSolid, HansenGoos, SpeedySolid};
    /// let spheres = FluidSolid::in_equilibrium(HansenGoos, SpeedySolid)?;
    /// assert!((spheres.coexistence().reduced_pressure - 11.572).abs() < 1e-3);
    /// # Ok::<(), gradient_mc::Error>(())
    /// ```
    pub fn in_equilibrium(fluid: F, solid: S) -> Result<Self, Error> {
        let (mut low, mut high) = (11.0, 13.0);
        // Chemical potential of the solid minus that of the fluid; it decreases with pressure.
        let difference = |reduced_pressure: f64| {
            let liquid = fluid.packing_fraction_at(reduced_pressure, Some(FREEZING))?;
            let crystal = solid.packing_fraction_at(reduced_pressure, Some(MELTING))?;
            let excess = solid.excess_chemical_potential(crystal) - fluid.excess_chemical_potential(liquid);
            Some(libm::log(crystal / liquid) + excess)
        };
        let melts = |reduced_pressure| difference(reduced_pressure).is_some_and(|excess| excess > 0.0);
        let freezes = |reduced_pressure| difference(reduced_pressure).is_some_and(|excess| excess <= 0.0);
        if !(melts(low) && freezes(high)) {
            return Err(Error::InvalidParameter {
                name: "P/T of coexistence",
                value: if melts(low) { high } else { low },
                requirement: "fluid and solid must have the same chemical potential between P/T = 11 and 13",
            });
        }
        while high - low > 1e-12 * high {
            let middle = 0.5 * (low + high);
            if melts(middle) { low = middle } else { high = middle }
        }
        Self::new(
            fluid,
            solid,
            Coexistence { reduced_pressure: 0.5 * (low + high), ..Coexistence::default() },
        )
    }

    /// The transition of these two equations: the pressure, and the packing fractions at which they
    /// reach it.
    #[must_use]
    pub fn coexistence(&self) -> Coexistence {
        self.cuts
    }
}

impl<F: EquationOfState, S: EquationOfState> EquationOfState for FluidSolid<F, S> {
    fn compressibility_factor(&self, packing_fraction: f64) -> f64 {
        if packing_fraction <= self.cuts.fluid {
            self.fluid.compressibility_factor(packing_fraction)
        } else if packing_fraction >= self.cuts.solid {
            self.solid.compressibility_factor(packing_fraction)
        } else {
            self.cuts.reduced_pressure / super::number_density(packing_fraction)
        }
    }
    fn compressibility_derivative(&self, packing_fraction: f64) -> f64 {
        if packing_fraction <= self.cuts.fluid {
            self.fluid.compressibility_derivative(packing_fraction)
        } else if packing_fraction >= self.cuts.solid {
            self.solid.compressibility_derivative(packing_fraction)
        } else {
            -self.compressibility_factor(packing_fraction)
        }
    }
    fn excess_chemical_potential(&self, packing_fraction: f64) -> f64 {
        if packing_fraction <= self.cuts.fluid {
            return self.fluid.excess_chemical_potential(packing_fraction);
        }
        // ln η plus this value is constant from one side of the transition to the other.
        let mixed = packing_fraction.min(self.cuts.solid);
        let along =
            self.fluid.excess_chemical_potential(self.cuts.fluid) + libm::log(self.cuts.fluid / mixed);
        if packing_fraction <= self.cuts.solid {
            return along;
        }
        along + self.solid.excess_chemical_potential(packing_fraction)
            - self.solid.excess_chemical_potential(self.cuts.solid)
    }
    /// From the lower end of the fluid to the upper end of the solid.
    fn domain(&self) -> Domain {
        Domain { lowest: self.fluid.domain().lowest, highest: self.solid.domain().highest }
    }
    fn packing_fraction_at(&self, reduced_pressure: f64, guess: Option<f64>) -> Option<f64> {
        // A guess from the other side of the transition is worse than the cut itself.
        if reduced_pressure <= self.cuts.reduced_pressure {
            let guess = guess.map(|eta| eta.min(self.cuts.fluid));
            self.fluid.packing_fraction_at(reduced_pressure, guess)
        } else {
            let guess = guess.map_or(self.cuts.solid, |eta| eta.max(self.cuts.solid));
            self.solid.packing_fraction_at(reduced_pressure, Some(guess))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_is_what_new_finds() {
        let found = FluidSolid::new(ModifiedKolafa, SpeedySolid, Coexistence::default()).unwrap();
        assert_eq!(FluidSolid::default(), found);
    }
}
