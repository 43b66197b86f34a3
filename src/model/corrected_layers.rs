//! The layers of a density functional with the bulk of a better equation of state.

use super::accuracy::densities;
use crate::functional::{Bulk, LayeredProfile, WhiteBear2};
use crate::{Error, Field, HydrostaticProfile, Scene, TemperatureProfile};

/// The profile of [`WhiteBear2`] for a scene, corrected for the error of its equation of state.
///
/// Its uniform fluid is that of Carnahan and Starling, whose pressure is off by up to 0.3 %. The
/// correction is the difference of the profiles of the local theory between walls with a better
/// equation and with this one.
///
/// ```
/// use gradient_mc::equation_of_state::ModifiedKolafa;
/// use gradient_mc::model::CorrectedLayers;
/// use gradient_mc::{Scene, Slab, field::UniformField, temperature::Isothermal};
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 360, UniformField::default(), Isothermal::new(5.0)?)?;
/// let layers = CorrectedLayers::new(&scene, &scene.hydrostatics(&ModifiedKolafa)?)?;
/// let densities = layers.densities(&scene);
/// assert!((densities.iter().sum::<f64>() - 10.0).abs() < 1e-6);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct CorrectedLayers {
    layers: LayeredProfile,
    /// Correction of the densities in bins one diameter high.
    correction: Vec<f64>,
}

impl CorrectedLayers {
    /// Solves for a scene. `theory` is its theory profile by the better equation.
    ///
    /// # Errors
    /// As [`Scene::density_functional`].
    pub fn new<F: Field, T: TemperatureProfile>(
        scene: &Scene<F, T>,
        theory: &HydrostaticProfile,
    ) -> Result<Self, Error> {
        let layers = scene.density_functional(&WhiteBear2)?;
        let own = densities(scene, &scene.hydrostatics(&Bulk(WhiteBear2))?);
        let correction = densities(scene, theory).iter().zip(own).map(|(better, own)| better - own).collect();
        Ok(Self { layers, correction })
    }

    /// The profile of the functional without the correction.
    #[must_use]
    pub fn layers(&self) -> &LayeredProfile {
        &self.layers
    }

    /// Number densities in bins one diameter high, corrected.
    #[must_use]
    pub fn densities<F: Field, T: TemperatureProfile>(&self, scene: &Scene<F, T>) -> Vec<f64> {
        let own = densities(scene, self.layers.as_hydrostatic());
        // Where few spheres are left, rounding of the difference could make the sum negative.
        own.iter().zip(&self.correction).map(|(own, correction)| (own + correction).max(0.5 * own)).collect()
    }
}
