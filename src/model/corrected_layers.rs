//! The layers of a density functional on the bulk of a better equation of state.

use super::accuracy::densities;
use crate::functional::{Bulk, LayeredProfile, WhiteBear2};
use crate::{Error, Field, HydrostaticProfile, Scene, TemperatureProfile};

/// [`WhiteBear2`] solved for a scene, and what its equation of state makes wrong, taken away.
///
/// Its uniform fluid is that of Carnahan and Starling, whose pressure is up to 0.3 % off. The local
/// theory between walls tells what that does to the profile: the difference of the two equations is
/// added.
#[derive(Debug, Clone)]
pub struct CorrectedLayers {
    layers: LayeredProfile,
    /// In bins one diameter high.
    correction: Vec<f64>,
}

impl CorrectedLayers {
    /// For a scene, with its theory profile by the better equation.
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

    /// The functional's own profile.
    #[must_use]
    pub fn layers(&self) -> &LayeredProfile {
        &self.layers
    }

    /// Number densities in bins one diameter high, corrected.
    #[must_use]
    pub fn densities<F: Field, T: TemperatureProfile>(&self, scene: &Scene<F, T>) -> Vec<f64> {
        let own = densities(scene, self.layers.as_hydrostatic());
        // Where next to nothing is left, a difference of rounded numbers may be less.
        own.iter().zip(&self.correction).map(|(own, correction)| (own + correction).max(0.5 * own)).collect()
    }
}
