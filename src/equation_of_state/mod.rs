//! Equations of state of hard spheres: Z(η) = P/(nT). To add one, implement [`EquationOfState`] for
//! a type of your own (one method).
//!
//! | equation | phase | valid for η | error in Z |
//! |---|---|---|---|
//! | [`IdealGas`] | point particles | any | 1 % for spheres at η = 0.0025 |
//! | [`CarnahanStarling`] | fluid | to freezing | 0.3 % |
//! | [`ModifiedKolafa`] | fluid | to freezing | smallest of these |
//! | [`HansenGoos`] | fluid | to freezing | within 0.015 % of the modified Kolafa |
//! | [`PercusYevickCompressibility`] | fluid | to freezing | +7 % at freezing |
//! | [`PercusYevickVirial`] | fluid | to freezing | −15 % at freezing |
//! | [`VirialSeries`] | fluid | to 0.4 | −0.4 % at 0.4 (all ten terms) |
//! | [`SpeedySolid`] | fcc crystal | from 0.52 | P/T = 11.57 at melting |
//! | [`FluidSolid`] | both | that of its parts | that of its parts |

mod carnahan_starling;
mod fluid_solid;
mod hansen_goos;
mod ideal_gas;
mod modified_kolafa;
mod percus_yevick_compressibility;
mod percus_yevick_virial;
mod series;
mod speedy_solid;
mod virial_series;

pub use carnahan_starling::CarnahanStarling;
pub use fluid_solid::{Coexistence, FluidSolid};
pub use hansen_goos::HansenGoos;
pub use ideal_gas::IdealGas;
pub use modified_kolafa::ModifiedKolafa;
pub use percus_yevick_compressibility::PercusYevickCompressibility;
pub use percus_yevick_virial::PercusYevickVirial;
pub(crate) use series::{MOST_TERMS, Series};
pub use speedy_solid::SpeedySolid;
pub use virial_series::VirialSeries;

use crate::numerics::{differentiate, integrate_panel};
use std::f64::consts::{FRAC_PI_6, PI, SQRT_2};
use std::sync::Arc;

/// Packing fraction at which the hard-sphere fluid freezes: where [`ModifiedKolafa`] reaches the
/// pressure of [`Coexistence`].
pub const FREEZING: f64 = 0.4918;
/// Packing fraction at which the fcc crystal melts: where [`SpeedySolid`] reaches that pressure.
pub const MELTING: f64 = 0.5434;
/// Largest packing fraction of equal spheres, π/√18.
pub const CLOSE_PACKING: f64 = PI / (3.0 * SQRT_2);

/// Number density n = 6η/π of a packing fraction, in inverse cubic diameters.
#[must_use]
pub fn number_density(packing_fraction: f64) -> f64 {
    packing_fraction * (6.0 / PI)
}

/// Packing fraction η = πn/6 of a number density.
///
/// ```
/// use gradient_mc::equation_of_state::{number_density, packing_fraction};
/// assert!((packing_fraction(1.0) - std::f64::consts::PI / 6.0).abs() < 1e-15);
/// assert!((number_density(packing_fraction(0.7)) - 0.7).abs() < 1e-15);
/// ```
#[must_use]
pub fn packing_fraction(number_density: f64) -> f64 {
    number_density * (PI / 6.0)
}

/// The range of packing fractions in which an equation of state is valid, ends included.
///
/// An equation can be evaluated outside its domain; a theory profile that does so reports it (see
/// [`HydrostaticProfile::domain_exit`](crate::hydrostatics::HydrostaticProfile::domain_exit)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Domain {
    /// Smallest packing fraction; above zero for a solid.
    pub lowest: f64,
    /// Largest packing fraction.
    pub highest: f64,
}

/// The side on which a packing fraction is outside a [`Domain`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DomainSide {
    /// Below the domain: too dilute.
    Below,
    /// Above the domain: too dense.
    Above,
}

impl Domain {
    /// Every packing fraction.
    pub const ALL: Self = Self { lowest: 0.0, highest: f64::INFINITY };
    /// The stable fluid, from vacuum to [`FREEZING`].
    pub const FLUID: Self = Self { lowest: 0.0, highest: FREEZING };

    /// The side on which `packing_fraction` is outside; `None` inside.
    ///
    /// ```
    /// use gradient_mc::equation_of_state::{Domain, DomainSide};
    /// assert_eq!(Domain::FLUID.side(0.3), None);
    /// assert_eq!(Domain::FLUID.side(0.5), Some(DomainSide::Above));
    /// ```
    #[must_use]
    pub fn side(&self, packing_fraction: f64) -> Option<DomainSide> {
        if packing_fraction < self.lowest {
            Some(DomainSide::Below)
        } else if packing_fraction > self.highest {
            Some(DomainSide::Above)
        } else {
            None
        }
    }
}

/// An equation of state of hard spheres: the compressibility factor Z(η) = P/(nT).
///
/// Only [`compressibility_factor`](Self::compressibility_factor) is required. The defaults compute
/// derivative, chemical potential and inverse numerically, with several calls each.
///
/// ```
/// use gradient_mc::EquationOfState;
/// /// Second virial coefficient only.
/// struct Dilute;
/// impl EquationOfState for Dilute {
///     fn compressibility_factor(&self, packing_fraction: f64) -> f64 {
///         1.0 + 4.0 * packing_fraction
///     }
/// }
/// assert!((Dilute.compressibility_derivative(0.1) - 0.4).abs() < 1e-9);
/// assert!((Dilute.excess_chemical_potential(0.1) - 0.8).abs() < 1e-12);
/// let reduced_pressure = 6.0 / std::f64::consts::PI * 0.1 * 1.4;
/// let packing_fraction = Dilute.packing_fraction_at(reduced_pressure, None);
/// assert!((packing_fraction.unwrap() - 0.1).abs() < 1e-14);
/// ```
///
/// It is `Send` and `Sync`, because threads share it. `&`, `Box` and `Arc` of an equation of state
/// are equations of state too.
pub trait EquationOfState: Send + Sync {
    /// Compressibility factor Z(η), for `packing_fraction` ≥ 0.
    fn compressibility_factor(&self, packing_fraction: f64) -> f64;

    /// d Z/d ln η; the default differentiates
    /// [`compressibility_factor`](Self::compressibility_factor).
    fn compressibility_derivative(&self, packing_fraction: f64) -> f64 {
        let step = 1e-3 * packing_fraction;
        if step == 0.0 {
            return 0.0;
        }
        packing_fraction * differentiate(|eta| self.compressibility_factor(eta), packing_fraction, step)
    }

    /// Excess chemical potential over temperature, Z − 1 + ∫₀^η (Z − 1)/η' dη'; the default
    /// integrates numerically.
    fn excess_chemical_potential(&self, packing_fraction: f64) -> f64 {
        const PANELS: usize = 32;
        if packing_fraction == 0.0 {
            return 0.0;
        }
        let width = packing_fraction / PANELS as f64;
        let integral: f64 = (0..PANELS)
            .map(|panel| {
                let low = panel as f64 * width;
                integrate_panel(|eta| (self.compressibility_factor(eta) - 1.0) / eta, low, low + width)
            })
            .sum();
        self.compressibility_factor(packing_fraction) - 1.0 + integral
    }

    /// The range in which the equation is valid; by default the stable fluid, [`Domain::FLUID`].
    fn domain(&self) -> Domain {
        Domain::FLUID
    }

    /// The packing fraction at which P/T = nZ equals `reduced_pressure` (in inverse cubic
    /// diameters); `None` if there is none.
    ///
    /// The search starts at the lower end of the [`domain`](Self::domain) and follows the branch on
    /// which the pressure rises. States beyond a maximum of the pressure are unstable and never
    /// returned. The upper end of the domain is not a limit. A close `guess` saves time; it must be
    /// on this branch.
    fn packing_fraction_at(&self, reduced_pressure: f64, guess: Option<f64>) -> Option<f64> {
        invert(self, reduced_pressure, guess)
    }
}

/// Newton's iteration for ln(ηZ) = ln(πp/6) in ln η, with a bracket that is updated in every step.
fn invert<E: EquationOfState + ?Sized>(
    equation: &E,
    reduced_pressure: f64,
    guess: Option<f64>,
) -> Option<f64> {
    /// Longest step in ln η without an upper bound; it prevents a step across a pole of Z.
    const LONGEST_STEP: f64 = 0.2;
    let target = FRAC_PI_6 * reduced_pressure;
    if target == 0.0 {
        return (equation.domain().lowest == 0.0).then_some(0.0);
    }
    if !(target > 0.0 && target.is_finite()) {
        return None;
    }
    let lowest = equation.domain().lowest;
    // Without a guess start at a low density, because the search from below stays on the stable
    // branch.
    let mut eta = guess
        .filter(|eta| eta.is_finite() && *eta > 0.0)
        .unwrap_or_else(|| if lowest > 0.0 { lowest } else { target.min(0.2) })
        .max(lowest);
    let (mut low, mut high) = (lowest, f64::INFINITY);
    let mut at_high_is_stable = true;
    for _ in 0..200 {
        let factor = equation.compressibility_factor(eta);
        let slope = 1.0 + equation.compressibility_derivative(eta) / factor;
        let stable = factor > 0.0 && factor.is_finite() && slope > 0.0 && slope.is_finite();
        let residual = libm::log(eta * factor / target);
        let step = -residual / slope;
        if stable && step.abs() < 1e-13 {
            let refined = eta * (1.0 + step);
            return (refined >= lowest * (1.0 - 1e-12)).then_some(refined);
        }
        if !stable || residual > 0.0 {
            high = eta;
            at_high_is_stable = stable;
        } else {
            low = eta;
        }
        if high <= low * (1.0 + 1e-15) {
            // The bracket has contracted to a maximum of the pressure, or to the end of the domain.
            break;
        }
        let middle = if low > 0.0 { (low * high).sqrt() } else { 0.5 * high };
        let proposal = eta * libm::exp(step.clamp(-10.0, LONGEST_STEP));
        eta = if stable && proposal > low && proposal < high {
            proposal
        } else if high.is_infinite() {
            return None;
        } else {
            middle
        };
        if eta <= low || eta >= high {
            // There is no number between the two. It is a root only if the pressure crosses here.
            return (at_high_is_stable && low > lowest).then_some(high);
        }
    }
    None
}

/// Implements the trait for pointers by forwarding every method.
macro_rules! forward {
    ($pointer:ty) => {
        impl<E: EquationOfState + ?Sized> EquationOfState for $pointer {
            fn compressibility_factor(&self, packing_fraction: f64) -> f64 {
                (**self).compressibility_factor(packing_fraction)
            }
            fn compressibility_derivative(&self, packing_fraction: f64) -> f64 {
                (**self).compressibility_derivative(packing_fraction)
            }
            fn excess_chemical_potential(&self, packing_fraction: f64) -> f64 {
                (**self).excess_chemical_potential(packing_fraction)
            }
            fn domain(&self) -> Domain {
                (**self).domain()
            }
            fn packing_fraction_at(&self, reduced_pressure: f64, guess: Option<f64>) -> Option<f64> {
                (**self).packing_fraction_at(reduced_pressure, guess)
            }
        }
    };
}
forward!(&E);
forward!(Box<E>);
forward!(Arc<E>);
