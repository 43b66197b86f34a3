//! The drive: where field and temperature become the one reduced potential that every move reads.
//!
//! A move from x to x' is accepted with probability min(1, exp(−[u(x') − u(x)])), u = U/T. Since every
//! acceptance is a difference of one function of height, detailed balance holds for any drive that
//! is not changed in between; what a [`Scheme`] guarantees is therefore a statement about *when* u
//! changes:
//!
//! | scheme | u is | detailed balance | what it rests on |
//! |---|---|---|---|
//! | [`ClosedForm`] | φ(x)/T, in closed form | exact | nothing: isothermal scenes only |
//! | [`SelfConsistent`] | iterated while equilibrating, then frozen | exact in production | the equilibration was long enough |
//! | [`EquationOfStateClosure`] | from the theory profile, once | exact | the equation of state |
//! | [`AveragedThenFrozen`] | a running average while equilibrating, then frozen | exact in production | the start is forgotten, slowly |
//! | [`RunningAverage`] | a running average, for ever | asymptotically | the same |
//! | [`Instantaneous`] | remade every sweep from that sweep's histogram (the 2011 paper) | violated | many spheres in every bin |
//!
//! Whatever the scheme, [`Simulation::certificate`](crate::Simulation::certificate) says after a production run whether
//! the field was that of the density that it made.
//!
//! # The effective field
//! With a temperature that varies, T(x) put straight into the Metropolis rule gives a wrong profile.
//! The steady state n(x) of dP/dx = −a n, P = n T(x) Z is that of an isothermal system in an effective
//! field g, whose reduced force is (eqs. 20 and 24 of doi:10.1103/PhysRevE.83.061306, for any a and T)
//!
//! u'(x) = a/T + (P/n) T'/T² = −(1/n) d(P/T)/dx,  P(x) = P(lid) + ∫ₓ a n dx'.
//!
//! To add a scheme, implement [`Scheme`] and [`Adaptation`] in a file of its own (or [`Drive`], for a potential that is
//! not an effective one); nothing else decides acceptance.

mod certificate;
mod column_average;
mod counting_noise;
mod effective_potential;
mod equation_of_state_closure;
mod instantaneous;
mod isothermal;
mod mapped;
mod running_average;
mod self_consistent;

pub use certificate::{Certificate, Convergence, ForceBalance, ForceBalancePoint, Suggestion};
pub use counting_noise::over_weight;
pub use effective_potential::EffectivePotential;
pub use equation_of_state_closure::{EquationOfStateClosure, Imposed};
pub use instantaneous::{EverySweep, Instantaneous, InstantaneousDrive};
pub use isothermal::{ClosedForm, IsothermalDrive};
pub use mapped::{Adaptation, MappedDrive};
pub use running_average::{AveragedThenFrozen, Averaging, RunningAverage};
pub use self_consistent::{Iteration, SelfConsistent, SelfConsistentDrive};

use crate::numerics::differentiate;
use crate::{Centers, Error, Scene, Warning};

/// What part of a run a sweep belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// Before the measurement: a drive may adapt.
    Equilibration,
    /// The measurement.
    Production,
}

/// The reduced potential u(x) = U(x)/T of a scene, as a run uses it.
pub trait Drive<F, T>: Sync {
    /// u at `height`. Only differences matter.
    fn reduced_potential(&self, scene: &Scene<F, T>, height: f64) -> f64;

    /// u' at `height`, at which event chains run into the field; the default differentiates
    /// [`reduced_potential`](Self::reduced_potential).
    fn reduced_force(&self, scene: &Scene<F, T>, height: f64) -> f64 {
        differentiate(|x| self.reduced_potential(scene, x), height, 1e-3)
    }

    /// Number of times that u has changed: what was derived from it can be kept while this is the same.
    #[inline]
    fn generation(&self) -> u64 {
        0
    }

    /// Shows the configuration after each sweep; the default, for a drive that never changes, does
    /// nothing and compiles to nothing.
    ///
    /// # Errors
    /// Any [`Error`]; it ends the run.
    #[inline]
    fn after_sweep(
        &mut self,
        _scene: &Scene<F, T>,
        _centers: Centers<'_>,
        _phase: Phase,
    ) -> Result<(), Error> {
        Ok(())
    }

    /// What production has seen of the balance of forces, where u could be the wrong one; by default nothing.
    #[inline]
    fn force_balance(&self) -> Option<&ForceBalance> {
        None
    }

    /// What it has to say against the production run so far, for [`Simulation::warnings`](crate::Simulation::warnings);
    /// by default nothing.
    #[inline]
    fn warnings(&self, _scene: &Scene<F, T>) -> Vec<Warning> {
        Vec::new()
    }

    /// Called when production starts, before its first sweep.
    ///
    /// # Errors
    /// Any [`Error`]; it ends the run.
    #[inline]
    fn start_production(&mut self, _scene: &Scene<F, T>) -> Result<(), Error> {
        Ok(())
    }
}

/// A way to make the [`Drive`] of a scene.
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot drive a scene with temperature profile `{T}`",
    note = "a temperature that varies needs a scheme: `.scheme(SelfConsistent::default())`, or another \
            of `gradient_mc::drive`"
)]
pub trait Scheme<F, T> {
    /// What it makes.
    type Drive: Drive<F, T>;

    /// Makes the drive.
    ///
    /// # Errors
    /// Any [`Error`], as documented by the scheme.
    fn drive(self, scene: &Scene<F, T>) -> Result<Self::Drive, Error>;
}

/// Logarithm of the Metropolis acceptance of a move between two heights, free of overlaps:
/// min(0, u(from) − u(to)); NaN where the potential is.
///
/// ```
/// use gradient_mc::{Scene, Slab, drive::{ClosedForm, Scheme, log_acceptance}};
/// use gradient_mc::{field::UniformField, temperature::Isothermal};
/// let slab = Slab::new(50.0, 5.0, 5.0)?;
/// let scene = Scene::new(slab, 100, UniformField::default(), Isothermal::new(2.0)?)?;
/// let drive = ClosedForm.drive(&scene)?;
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
