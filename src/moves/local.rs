//! Local trial moves: one sphere, a small uniform displacement, Metropolis acceptance.

use super::Sweep;
use crate::configuration::wrap;
use crate::drive::{Drive, log_acceptance};
use crate::observer::AcceptedMove;
use crate::random::{index, symmetric, unit};
use crate::{Error, Slab};
use nalgebra::Vector3;

/// Moves of one sphere, chosen at random, by a displacement uniform in the cube (−S, S)³.
///
/// A trial that leaves the slab or overlaps is rejected; otherwise it is accepted with probability
/// min(1, exp(−Δu)) (eq. 12 of doi:10.1103/PhysRevE.83.061306 and those derived from it). A trial and
/// its reverse are proposed with the same probability, so detailed balance holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalMoves {
    maximum_displacement: f64,
}

impl LocalMoves {
    /// S = `maximum_displacement` in diameters.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] unless 0 < S ≤ half the smallest side of the slab.
    pub fn new(maximum_displacement: f64, slab: &Slab) -> Result<Self, Error> {
        let moves = Self { maximum_displacement };
        moves.check(slab)?;
        Ok(moves)
    }

    /// Whether the moves suit a slab.
    pub(crate) fn check(self, slab: &Slab) -> Result<(), Error> {
        let maximum_displacement = self.maximum_displacement;
        let [width_y, width_z] = slab.widths();
        let largest = 0.5 * slab.height().min(width_y).min(width_z);
        if maximum_displacement > 0.0 && maximum_displacement <= largest {
            Ok(())
        } else {
            Err(Error::InvalidParameter {
                name: "maximum displacement",
                value: maximum_displacement,
                requirement: "it must be positive and at most half the smallest side of the slab",
            })
        }
    }

    /// S in diameters, to be checked when the slab is known.
    pub(crate) fn unchecked(maximum_displacement: f64) -> Self {
        Self { maximum_displacement }
    }

    /// S in diameters.
    #[must_use]
    pub fn maximum_displacement(&self) -> f64 {
        self.maximum_displacement
    }

    /// One sweep: as many trials as there are spheres.
    ///
    /// # Errors
    /// [`Error::InvalidPotential`] where a field or a temperature turns out not to be finite between
    /// the heights that were probed; the configuration stays valid.
    pub(super) fn sweep<F, T, D: Drive<F, T>>(self, sweep: &mut Sweep<'_, F, T, D>) -> Result<(), Error> {
        let Sweep { scene, drive, configuration, generator, tally, recorder, .. } = sweep;
        let slab = *configuration.slab();
        let [width_y, width_z] = slab.widths();
        let particles = configuration.len();
        let mut accepted = 0;
        for _ in 0..particles {
            let sphere = index(generator, particles);
            let [dx, dy, dz] = [0; 3].map(|_| self.maximum_displacement * symmetric(generator));
            let [x, y, z] = configuration.position(sphere);
            let height = x + dx;
            if height < slab.lowest_center() || height > slab.highest_center() {
                continue;
            }
            let trial = [height, wrap(y + dy, width_y), wrap(z + dz, width_z)];
            if configuration.overlaps(sphere, trial) {
                continue;
            }
            let exponent = log_acceptance(*drive, scene, x, height);
            if exponent.is_nan() {
                let potential = drive.reduced_potential(scene, height);
                return Err(Error::InvalidPotential { height, potential });
            }
            if exponent < 0.0 && unit(generator) >= libm::exp(exponent) {
                continue;
            }
            configuration.relocate(sphere, trial);
            if let Some(recorder) = recorder {
                let displacement = Vector3::new(dx, dy, dz);
                recorder.record_move(&AcceptedMove { from_height: x, displacement });
            }
            accepted += 1;
        }
        tally.trials += particles as u64;
        tally.accepted += accepted;
        Ok(())
    }
}
