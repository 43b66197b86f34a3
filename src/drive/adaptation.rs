//! The adaptation of the effective potential during a run.

use super::MeasuredShare;
use crate::observer::Observer;
use crate::scene::AnyScene;
use crate::{Error, Warning};

/// Changes the potential `P` of a run by what it samples: the part in which the schemes of this
/// module differ.
///
/// It is an [`Observer`] and gets the same frames, single moves and collisions as all others. After
/// each sweep it may change the potential.
///
/// ```
/// use gradient_mc::drive::{Adaptation, EffectivePotential, Scheme};
/// use gradient_mc::{AnyScene, Error, Field, Frame, Observer, ObserverError, Scene, TemperatureProfile};
/// /// Uses Z = 1 + 4η with the mean packing fraction below the center of mass, until production.
/// #[derive(Debug, Default)]
/// struct Crude {
///     packing_fraction: f64,
///     frozen: bool,
/// }
/// impl Observer for Crude {
///     fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
///         let center = frame.heights().sum::<f64>() / frame.particles() as f64;
///         let below = frame.heights().filter(|&height| height < center).count();
///         self.packing_fraction = 0.5236 * below as f64 / (center * frame.slab().base_area());
///         Ok(())
///     }
/// }
/// impl Adaptation<EffectivePotential> for Crude {
///     fn adapt(&mut self, potential: &mut EffectivePotential, scene: &AnyScene<'_>) -> Result<(), Error> {
///         if self.frozen {
///             return Ok(());
///         }
///         let factor = 1.0 + 4.0 * self.packing_fraction;
///         let heights: Vec<f64> = potential.heights().collect();
///         potential.set(0.0, |bin| factor * scene.temperature().temperature(heights[bin]))
///     }
///     fn start_production(&mut self, _: &mut EffectivePotential, _: &AnyScene<'_>) -> Result<(), Error> {
///         self.frozen = true;
///         Ok(())
///     }
/// }
/// /// Makes potential and adaptation.
/// struct CrudeScheme;
/// impl<F: Field, T: TemperatureProfile> Scheme<F, T> for CrudeScheme {
///     type Drive = EffectivePotential;
///     type Adaptation = Crude;
///     fn drive(self, scene: &Scene<F, T>) -> Result<(EffectivePotential, Crude), Error> {
///         Ok((EffectivePotential::new(scene, 0.1)?, Crude::default()))
///     }
/// }
/// ```
pub trait Adaptation<P>: Observer + Send + Sync {
    /// Changes the potential after a sweep. The default does not change it.
    ///
    /// # Errors
    /// Any [`Error`]; it ends the run.
    #[inline]
    fn adapt(&mut self, _potential: &mut P, _scene: &AnyScene<'_>) -> Result<(), Error> {
        Ok(())
    }

    /// Called when production starts, before its first sweep; the default does nothing.
    ///
    /// # Errors
    /// Any [`Error`]; it ends the run.
    #[inline]
    fn start_production(&mut self, _potential: &mut P, _scene: &AnyScene<'_>) -> Result<(), Error> {
        Ok(())
    }

    /// Whether the potential changes with every configuration. A certificate of such a run is never
    /// converged.
    fn follows_every_configuration(&self) -> bool {
        false
    }

    /// The part of the effective field that was measured, printed in certificates; by default
    /// `None`, unknown.
    fn measured_share(&self) -> Option<MeasuredShare> {
        None
    }

    /// Warnings about production in addition to those of the balance of forces; by default none.
    fn warnings(&self, _potential: &P, _scene: &AnyScene<'_>) -> Vec<Warning> {
        Vec::new()
    }
}

/// The potential does not change, so nothing of it is measured.
impl<P> Adaptation<P> for () {
    fn measured_share(&self) -> Option<MeasuredShare> {
        Some(MeasuredShare::NONE)
    }
}
