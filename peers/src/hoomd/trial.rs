//! Trial displacements.

use hoomd_mc::{LocalTrial, Translate};
use hoomd_microstate::property::Position;
use hoomd_vector::Cartesian;
use rand::{Rng, RngExt};
use std::sync::atomic::{AtomicU64, Ordering};

/// Uniform in the cube (−S, S)³, as in gradient-mc.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cube(pub(crate) f64);

impl<B: Position<Position = Cartesian<3>>> LocalTrial<B> for Cube {
    #[inline]
    fn propose<R: Rng>(&self, rng: &mut R, mut body: B) -> B {
        let displacement: [f64; 3] = [0; 3].map(|_| self.0 * (2.0 * rng.random::<f64>() - 1.0));
        *body.position_mut() += displacement.into();
        body
    }
}

/// hoomd-mc's own: uniform in a ball, with the mean square displacement S² of the [`Cube`].
pub(crate) fn ball(maximum_displacement: f64) -> Result<Translate<Cartesian<3>>, crate::Failure> {
    // A ball of radius R has ⟨r²⟩ = 3R²/5.
    let radius = maximum_displacement * (5.0_f64 / 3.0).sqrt();
    Ok(Translate::with_maximum_distance(radius.try_into()?))
}

/// Counts proposals. Not for a run that is timed: threads would fight for the counter.
#[derive(Debug)]
pub(crate) struct Counted<'a, L>(pub(crate) L, pub(crate) &'a AtomicU64);

impl<B, L: LocalTrial<B>> LocalTrial<B> for Counted<'_, L> {
    fn propose<R: Rng>(&self, rng: &mut R, body: B) -> B {
        self.1.fetch_add(1, Ordering::Relaxed);
        self.0.propose(rng, body)
    }
}
