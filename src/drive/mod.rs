//! The drive: field and temperature become the reduced potential u(x) that all moves use.
//!
//! A move from x to x' is accepted with probability min(1, exp(−[u(x') − u(x)])), u = U/T. Since
//! the acceptance depends only on differences of one function of height, detailed balance holds for
//! any u that is constant in time. The schemes differ in how and when u changes:
//!
//! | scheme | reduced potential u | detailed balance | requirement |
//! |---|---|---|---|
//! | [`Automatic`], T constant | φ(x)/T, in closed form | exact | none |
//! | [`Automatic`], T varies: [`SelfConsistent`] | iterated from collisions and counts in equilibration, then frozen | exact in production | a long enough equilibration |
//! | [`EquationOfStateClosure`] | from the theory profile, constant | exact | an accurate equation of state |
//! | [`AveragedThenFrozen`] | from a running average in equilibration, then frozen | exact in production | a very long equilibration, because the start decays slowly |
//! | [`RunningAverage`] | from a running average, always | asymptotic | the same |
//! | [`Instantaneous`] | from the histogram of every sweep (the 2011 paper) | violated | many spheres in every bin |
//!
//! For all schemes, [`Simulation::certificate`](crate::Simulation::certificate) checks after
//! production whether the effective field is self-consistent.
//!
//! # The effective field
//! If the temperature varies, using T(x) directly in the Metropolis rule gives a wrong profile. The
//! steady state n(x) of dP/dx = −a n, P = n T(x) Z is that of an isothermal system in an effective
//! field, whose reduced force is (eqs. 20 and 24 of doi:10.1103/PhysRevE.83.061306, for any a and
//! T)
//!
//! u'(x) = a/T + (P/n) T'/T² = −(1/n) d(P/T)/dx,  P(x) = P(lid) + ∫ₓ a n dx'.
//!
//! If the field pulls up, P is summed from the base, P(x) = P(base) − ∫ a n dx'
//! ([`Scene::open_end`]).
//!
//! A [`Drive`] is a potential, and an [`Adaptation`] is an observer that may change it. Nothing
//! else decides the acceptance. To add a scheme, implement [`Scheme`] for a type of your own, with
//! [`EffectivePotential`] or your own [`Drive`], and with an [`Adaptation`] if the potential
//! changes.

mod adaptation;
mod automatic;
mod certificate;
mod column_average;
mod counting_noise;
mod effective_potential;
mod equation_of_state_closure;
mod instantaneous;
mod measured_share;
mod own_equation;
mod running_average;
mod self_consistent;

pub use adaptation::Adaptation;
pub use automatic::Automatic;
pub use certificate::{Certificate, Convergence, ForceBalance, ForceBalancePoint, Suggestion};
pub(crate) use column_average::WallContact;
pub use counting_noise::over_weight;
pub use effective_potential::EffectivePotential;
pub use equation_of_state_closure::EquationOfStateClosure;
pub use instantaneous::Instantaneous;
pub use measured_share::MeasuredShare;
pub use running_average::{AveragedThenFrozen, RunningAverage};
pub use self_consistent::SelfConsistent;

use crate::frame::InForce;
use crate::numerics::differentiate;
use crate::{Error, Field, Scene, TemperatureProfile};

/// The reduced potential u(x) = U(x)/T of a scene, used by all moves; [`Scheme`] has an example.
pub trait Drive<F, T>: Send + Sync {
    /// The reduced potential u at `height`, up to a constant.
    fn reduced_potential(&self, scene: &Scene<F, T>, height: f64) -> f64;

    /// The reduced force u' = du/dx at `height`, in inverse diameters. Event chains use it as the
    /// rate of field events. The default differentiates
    /// [`reduced_potential`](Self::reduced_potential).
    fn reduced_force(&self, scene: &Scene<F, T>, height: f64) -> f64 {
        differentiate(|x| self.reduced_potential(scene, x), height, 1e-3)
    }

    /// Distance of heights, in diameters, at which values of the force miss none of its features; by
    /// default 1/16. Event chains bound the force by such values.
    #[inline]
    fn resolution(&self) -> f64 {
        1.0 / 16.0
    }

    /// Number of changes of u so far. Values derived from u stay valid while it is the same.
    #[inline]
    fn generation(&self) -> u64 {
        0
    }

    /// Pressure on the wall at the [open end](Scene::open_end) of the column, in m g/d², that u
    /// assumes; by default 0.
    #[inline]
    fn open_end_pressure(&self) -> f64 {
        0.0
    }
}

/// A scheme: makes the [`Drive`] of a scene and its [`Adaptation`].
///
/// ```
/// use gradient_mc::drive::{Drive, Scheme};
/// use gradient_mc::{Error, Field, Scene, Simulation, Slab, TemperatureProfile};
/// use gradient_mc::{field::UniformField, temperature::Isothermal};
/// struct OneTemperature(f64);
/// impl<F: Field, T: TemperatureProfile> Drive<F, T> for OneTemperature {
///     fn reduced_potential(&self, scene: &Scene<F, T>, height: f64) -> f64 {
///         scene.field().potential(height) / self.0
///     }
/// }
/// impl<F: Field, T: TemperatureProfile> Scheme<F, T> for OneTemperature {
///     type Drive = Self;
///     type Adaptation = ();
///     fn drive(self, _: &Scene<F, T>) -> Result<(Self, ()), Error> {
///         Ok((self, ()))
///     }
/// }
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 36, UniformField::default(), Isothermal::new(5.0)?)?;
/// Simulation::builder(scene).scheme(OneTemperature(4.0)).build()?.run(10, &mut ())?;
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a scheme for a field `{F}` and a temperature profile `{T}`",
    label = "not a scheme for this scene",
    note = "leave `.scheme()` out, or use one of `gradient_mc::drive`, for example `SelfConsistent::default()`; your own \
    scheme must implement `Scheme`"
)]
pub trait Scheme<F, T> {
    /// The reduced potential.
    type Drive: Drive<F, T>;
    /// The type that changes it during a run; `()` if it is constant.
    type Adaptation: Adaptation<Self::Drive>;

    /// Makes the potential and its adaptation.
    ///
    /// # Errors
    /// Any [`Error`], as documented by the scheme.
    fn drive(self, scene: &Scene<F, T>) -> Result<(Self::Drive, Self::Adaptation), Error>;

    /// Whether the steady state depends on the moves because detailed balance does not hold; by
    /// default `false`. With `true`, the default moves are the local moves of the paper, and event
    /// chains are refused.
    fn depends_on_moves(&self) -> bool {
        false
    }
}

/// Logarithm of the Metropolis acceptance of a move between two heights without overlaps: min(0,
/// u(from) − u(to)); NaN if u is NaN.
///
/// ```
/// use gradient_mc::{Scene, Slab, drive::{Automatic, Scheme, log_acceptance}};
/// use gradient_mc::{field::UniformField, temperature::Isothermal};
/// let slab = Slab::new(50.0, 5.0, 5.0)?;
/// let scene = Scene::new(slab, 100, UniformField::default(), Isothermal::new(2.0)?)?;
/// let (drive, _) = Automatic.drive(&scene)?;
/// assert_eq!(log_acceptance(&drive, &scene, 10.0, 11.0), -0.5);
/// assert_eq!(log_acceptance(&drive, &scene, 11.0, 10.0), 0.0);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[inline]
pub fn log_acceptance<F, T>(drive: &impl Drive<F, T>, scene: &Scene<F, T>, from: f64, to: f64) -> f64 {
    let gain = drive.reduced_potential(scene, from) - drive.reduced_potential(scene, to);
    // Not `min`, which would turn a NaN into certain acceptance.
    if gain > 0.0 { 0.0 } else { gain }
}

/// A scene and its drive.
#[derive(Debug, Clone)]
pub(crate) struct Driven<F, T, D> {
    pub(crate) scene: Scene<F, T>,
    pub(crate) drive: D,
}

impl<F: Field, T: TemperatureProfile, D: Drive<F, T>> InForce for Driven<F, T, D> {
    fn reduced_potential(&self, height: f64) -> f64 {
        self.drive.reduced_potential(&self.scene, height)
    }
    fn reduced_force(&self, height: f64) -> f64 {
        self.drive.reduced_force(&self.scene, height)
    }
    fn generation(&self) -> u64 {
        self.drive.generation()
    }
    fn open_end_pressure(&self) -> f64 {
        self.drive.open_end_pressure()
    }
}
