//! The drive: where field and temperature become the one reduced potential that every move reads.
//!
//! A move from x to x' is accepted with probability min(1, exp(−[u(x') − u(x)])), u = U/T. Since
//! every acceptance is a difference of one function of height, detailed balance holds for any drive
//! that is not changed in between; what a [`Scheme`] guarantees is therefore a statement about
//! *when* u changes:
//!
//! | scheme | u is | detailed balance | what it rests on |
//! |---|---|---|---|
//! | [`Automatic`], T constant | φ(x)/T, in closed form | exact | nothing |
//! | [`Automatic`], T varies: [`SelfConsistent`] | iterated from collisions and counts while equilibrating, then frozen | exact in production | the equilibration was long enough |
//! | [`EquationOfStateClosure`] | from the theory profile, once | exact | the equation of state |
//! | [`AveragedThenFrozen`] | a running average while equilibrating, then frozen | exact in production | the start is forgotten, slowly |
//! | [`RunningAverage`] | a running average, for ever | asymptotically | the same |
//! | [`Instantaneous`] | remade every sweep from that sweep's histogram (the 2011 paper) | violated | many spheres in every bin |
//!
//! Whatever the scheme, [`Simulation::certificate`](crate::Simulation::certificate) says after a
//! production run whether the field was that of the density that it made.
//!
//! # The effective field
//! With a temperature that varies, T(x) put straight into the Metropolis rule gives a wrong
//! profile. The steady state n(x) of dP/dx = −a n, P = n T(x) Z is that of an isothermal system in
//! an effective field g, whose reduced force is (eqs. 20 and 24 of doi:10.1103/PhysRevE.83.061306,
//! for any a and T)
//!
//! u'(x) = a/T + (P/n) T'/T² = −(1/n) d(P/T)/dx,  P(x) = P(lid) + ∫ₓ a n dx',
//!
//! summed from the base, P(x) = P(base) − ∫ a n dx', where the field pulls up
//! ([`Scene::open_end`]).
//!
//! A drive is a potential, and what adapts it is an observer that may change it: nothing else
//! decides acceptance. To add a scheme, implement [`Scheme`] in a file of its own, with an
//! [`EffectivePotential`] or a [`Drive`] of its own, and with an [`Adaptation`] if it changes.

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

/// The reduced potential u(x) = U(x)/T of a scene, as a run uses it.
pub trait Drive<F, T>: Send + Sync {
    /// u at `height`. Only differences matter.
    fn reduced_potential(&self, scene: &Scene<F, T>, height: f64) -> f64;

    /// u' at `height`, at which event chains run into the field; the default differentiates
    /// [`reduced_potential`](Self::reduced_potential).
    fn reduced_force(&self, scene: &Scene<F, T>, height: f64) -> f64 {
        differentiate(|x| self.reduced_potential(scene, x), height, 1e-3)
    }

    /// Number of times that u has changed: what was derived from it can be kept while this is the
    /// same.
    #[inline]
    fn generation(&self) -> u64 {
        0
    }

    /// Pressure on the wall at the [open end](Scene::open_end) of the column, in m g/d², that u
    /// assumes; by default none, as under an open sky.
    #[inline]
    fn open_end_pressure(&self) -> f64 {
        0.0
    }
}

/// A way to make the [`Drive`] of a scene, and what adapts it.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no scheme for a field `{F}` and a temperature profile `{T}`",
    label = "not a scheme for this scene",
    note = "leave `.scheme()` out, or take one of `gradient_mc::drive`: `SelfConsistent::default()`, say; a scheme of \
            your own implements `Scheme`"
)]
pub trait Scheme<F, T> {
    /// The potential.
    type Drive: Drive<F, T>;
    /// What changes it while a run goes on; `()` if nothing does.
    type Adaptation: Adaptation<Self::Drive>;

    /// Makes both.
    ///
    /// # Errors
    /// Any [`Error`], as documented by the scheme.
    fn drive(self, scene: &Scene<F, T>) -> Result<(Self::Drive, Self::Adaptation), Error>;

    /// Whether the steady state depends on the moves, because balance does not hold; by default
    /// not. If it does, a simulation that names no moves has the paper's local ones, and event
    /// chains are refused.
    fn depends_on_moves(&self) -> bool {
        false
    }
}

/// Logarithm of the Metropolis acceptance of a move between two heights, free of overlaps:
/// min(0, u(from) − u(to)); NaN where the potential is.
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

/// A scene and its drive: what is simulated.
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
