//! Observers from closures.

use crate::{Frame, Observer, ObserverError};

/// An observer from a closure that is called with every frame. The closure stores its results in
/// the variables that it captures.
///
/// ```
/// use gradient_mc::{ObserverFn, Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 36, UniformField::default(), Isothermal::new(5.0)?)?;
/// let mut highest = 0.0;
/// let mut observer = ObserverFn::new(|frame| {
///     highest = frame.heights().fold(highest, f64::max);
///     Ok(())
/// });
/// Simulation::builder(scene).build()?.run(100, &mut observer)?;
/// assert!(highest > 0.5);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Clone)]
pub struct ObserverFn<F>(F);

impl<F: FnMut(&Frame<'_>) -> Result<(), ObserverError>> ObserverFn<F> {
    /// Wraps the closure. An error that it returns ends the run, with the configuration intact.
    pub fn new(observe: F) -> Self {
        Self(observe)
    }
}

impl<F> std::fmt::Debug for ObserverFn<F> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("ObserverFn").finish_non_exhaustive()
    }
}

impl<F: FnMut(&Frame<'_>) -> Result<(), ObserverError>> Observer for ObserverFn<F> {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        (self.0)(frame)
    }
}
