//! No more model than the scene needs.
//!
//! Ideal gas, hydrostatic theory and Monte Carlo give the same profile with more and more effort. [`Scene::model_for`] tells which is the
//! cheapest whose error stays below a tolerance, and what the cheaper ones miss.
//!
//! | candidate | error | cost |
//! |---|---|---|
//! | [`IdealColumn`] | excluded volume: what the theory says it moves | some 10⁻⁴ CPU s |
//! | [`Hydrostatics::between_walls`](crate::Hydrostatics::between_walls) | the layers at the walls | some 10⁻² CPU s |
//! | [`MonteCarloPlan`] | counting noise, a finite base | as 1/error² |
//!
//! The error of a model is its [`total_variation_distance`]: ½ ∫ |n′ − n| dx over N/A, with n averaged over bins one diameter high. In a
//! uniform field P(x) at the edges of these bins is no further off, relative to the base pressure. How the estimates were made, and how well they do on scenes that they
//! have not seen, is said in `docs/models.md`.

mod choice;
mod constants;
mod ideal_column;
mod outlook;
mod plan;
mod planned_drive;
mod reason;
mod total_variation;

pub use choice::{Assessment, Model, ModelChoice};
pub use ideal_column::IdealColumn;
pub use plan::{MonteCarloPlan, MoveFamily};
pub use planned_drive::{Planned, PlannedDrive};
pub use reason::{Reason, Wall};
pub use total_variation::{densities, total_variation_distance};

use crate::{Error, Field, Scene, TemperatureProfile};

impl<F: Field, T: TemperatureProfile> Scene<F, T> {
    /// The cheapest model whose [`total_variation_distance`] stays below `tolerance` in this scene, with the reasons in words and numbers.
    ///
    /// Ideal gas, hydrostatic theory and Monte Carlo are considered, in this order. To decide between them takes both formulas, some milliseconds. The
    /// base of the scene does not matter, except where the column freezes: profiles depend on N/A, and a plan comes with a base of its own.
    ///
    /// ```
    /// use gradient_mc::model::Model;
    /// use gradient_mc::{Scene, Slab, field::UniformField, temperature::Isothermal};
    /// let slab = Slab::new(30.0, 20.0, 20.0)?;
    /// let scene = Scene::new(slab, 400, UniformField::default(), Isothermal::new(2.0)?)?;
    /// // A third of the spheres may be misplaced: they might as well be points.
    /// assert!(matches!(scene.model_for(0.3)?.model(), Model::IdealGas(_)));
    /// // A twentieth.
    /// assert!(matches!(scene.model_for(0.05)?.model(), Model::Hydrostatics(_)));
    /// // One in two hundred: the layers at the base count.
    /// let choice = scene.model_for(0.005)?;
    /// println!("{choice}");
    /// let Model::MonteCarlo(plan) = choice.model() else { panic!("{choice}") };
    /// let mut simulation = plan.simulation(&scene, 1)?;
    /// simulation.equilibrate(plan.equilibration_sweeps(), &mut ())?;
    /// // ... or all of it at once, also for the other two:
    /// let densities = choice.model().densities(&scene, 1)?;
    /// assert_eq!(densities.len(), 30);
    /// # Ok::<(), gradient_mc::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] for a tolerance that is not positive and finite; what [`Hydrostatics`](crate::Hydrostatics) returns for a
    /// scene that it cannot solve; [`Error::SlabTooLarge`] if no base is wide enough for so small an error.
    pub fn model_for(&self, tolerance: f64) -> Result<ModelChoice, Error> {
        ModelChoice::new(self, tolerance)
    }
}
