//! The cheapest model that is accurate enough for a scene.
//!
//! Ideal gas, hydrostatic theory, a density functional and Monte Carlo predict the same profile at
//! increasing cost. [`Scene::model_for`] finds the cheapest that reaches an [`Accuracy`] of n, P or
//! Z, and states the errors of the cheaper ones.
//!
//! | candidate | error | cost |
//! |---|---|---|
//! | [`Hydrostatics`](crate::Hydrostatics) with [`IdealGas`](crate::equation_of_state::IdealGas) | excluded volume | milliseconds |
//! | [`Hydrostatics::between_walls`](crate::Hydrostatics::between_walls) | the layers at the walls | milliseconds |
//! | [`CorrectedLayers`] | the layers of the functional | tenths of a second |
//! | [`MonteCarloPlan`] | counting noise, a finite base | proportional to 1/error² |
//!
//! `docs/models.md` describes how the estimates are made, and tests them on other scenes.

mod accuracy;
mod choice;
#[doc(hidden)]
pub mod constants;
mod corrected_layers;
mod outlook;
mod plan;

pub use accuracy::{Accuracy, Quantity, densities, total_variation_distance};
pub use choice::{Assessment, Cause, Model, ModelChoice};
pub use corrected_layers::CorrectedLayers;
pub use plan::{MonteCarloPlan, MoveFamily};

use crate::{Error, Field, Scene, TemperatureProfile};

impl<F: Field, T: TemperatureProfile> Scene<F, T> {
    /// The cheapest model of this scene that reaches `accuracy`, with the reasons.
    ///
    /// The candidates are ideal gas, hydrostatic theory, a density functional and Monte Carlo, in
    /// this order. The decision takes milliseconds, or tenths of a second if the functional must be
    /// solved. The base of the scene does not matter unless the column freezes: profiles depend on
    /// N/A, and a plan has its own base.
    ///
    /// ```
    /// use gradient_mc::model::{Accuracy, Model};
    /// use gradient_mc::{Scene, Slab, field::UniformField, temperature::Isothermal};
    /// let slab = Slab::new(30.0, 20.0, 20.0)?;
    /// let scene = Scene::new(slab, 400, UniformField::default(), Isothermal::new(2.0)?)?;
    /// // A third of the spheres may be at a wrong height: they might as well be points.
    /// assert!(matches!(scene.model_for(Accuracy::density(0.3)?)?.model(), Model::IdealGas(_)));
    /// // A twentieth.
    /// assert!(matches!(scene.model_for(Accuracy::density(0.05)?)?.model(), Model::Hydrostatics(_)));
    /// // One in two hundred: the layers at the base count.
    /// assert!(matches!(scene.model_for(Accuracy::density(0.005)?)?.model(), Model::DensityFunctional(_)));
    /// // Better than any theory is known to be.
    /// let choice = scene.model_for(Accuracy::density(1e-4)?)?;
    /// println!("{choice}");
    /// let Model::MonteCarlo(plan) = choice.model() else { panic!("{choice}") };
    /// let mut simulation = plan.simulation(&scene, 1)?;
    /// simulation.equilibrate(100, &mut ())?;
    /// // ... or all of it at once, as for the others:
    /// let densities = scene.model_for(Accuracy::density(0.02)?)?.model().densities(&scene, 1)?;
    /// assert_eq!(densities.len(), 30);
    /// # Ok::<(), gradient_mc::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] for a range of heights without spheres; the errors of
    /// [`Hydrostatics`](crate::Hydrostatics); [`Error::SlabTooLarge`] if no base is wide enough for
    /// so small an error.
    pub fn model_for(&self, accuracy: Accuracy) -> Result<ModelChoice, Error> {
        ModelChoice::new(self, accuracy)
    }
}
