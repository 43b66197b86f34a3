//! Upper bounds of the reduced force, layer by layer.

use crate::drive::Drive;
use crate::{Error, Field, Scene, TemperatureProfile};

/// Bounds of u' and of −u' in layers of one diameter.
///
/// Thinning events are drawn at these rates, and accepted as field events with the ratio of the
/// true force to its bound (Lewis and Shedler, doi:10.1002/nav.3800260304). This is exact as long
/// as the bounds hold. A bound is the largest force at the probes of a layer, plus the range of
/// their forces as a margin. The mean force between two probes is a difference of potentials. If it
/// exceeds the bound, the drive is refused, since chains would hardly notice so narrow a feature. A
/// force above its bound is an error when a chain meets it.
#[derive(Debug, Clone, Default)]
pub(super) struct ForceBounds {
    /// Bounds of u', which stops rising spheres, and of −u', which stops sinking ones.
    layers: Vec<[f64; 2]>,
    generation: u64,
}

/// Smallest number of probes per diameter.
const LEAST_PROBES: u32 = 16;
/// Largest number of probes per diameter, for a fine [`Drive::resolution`].
const MOST_PROBES: f64 = 65_536.0;
/// Largest force that is accepted.
const LARGEST: f64 = 1e300;

impl ForceBounds {
    /// Probes the drive again if it has changed.
    pub(super) fn follow<F: Field, T: TemperatureProfile, D: Drive<F, T>>(
        &mut self,
        drive: &D,
        scene: &Scene<F, T>,
    ) -> Result<(), Error> {
        if !self.layers.is_empty() && self.generation == drive.generation() {
            return Ok(());
        }
        self.generation = drive.generation();
        self.layers.clear();
        let height = scene.slab().height();
        // The cast saturates at zero.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let probes = ((1.0 / drive.resolution()).min(MOST_PROBES).ceil() as u32).max(LEAST_PROBES);
        let mut low = 0.0;
        while low < height {
            let heights = (0..=probes).map(|probe| {
                (low + f64::from(probe) / f64::from(probes))
                    .clamp(scene.slab().lowest_center(), scene.slab().highest_center())
            });
            let (mut smallest, mut largest) = (f64::INFINITY, f64::NEG_INFINITY);
            for x in heights.clone() {
                let force = drive.reduced_force(scene, x);
                // Bounds are up to three times as large, and must be finite too.
                if force.is_nan() || force.abs() > LARGEST {
                    return Err(Error::InvalidForce { height: x, force, bound: LARGEST });
                }
                (smallest, largest) = (force.min(smallest), force.max(largest));
            }
            // The second term covers the rounding of a derivative taken numerically.
            let margin = largest - smallest + 1e-8 * largest.abs().max(smallest.abs());
            let bounds = [(largest + margin).max(0.0), (margin - smallest).max(0.0)];
            check_mean_forces(drive, scene, heights, bounds)?;
            self.layers.push(bounds);
            low += 1.0;
        }
        Ok(())
    }

    /// The thinning event of a sphere that moves from `height` over `distance`: its distance and
    /// the bound there, or `None`. `until_event` is the integral of the bound up to the event; the
    /// part that is used without an event is subtracted.
    #[inline]
    pub(super) fn thinning_event(
        &self,
        until_event: &mut f64,
        height: f64,
        rising: bool,
        distance: f64,
    ) -> Option<(f64, f64)> {
        let side = usize::from(!rising);
        // Heights are inside the slab, below 1e6.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let mut layer = (height as usize).min(self.layers.len() - 1);
        let within = height - layer as f64;
        let mut begin = 0.0;
        let mut end = if rising { 1.0 - within } else { within };
        loop {
            let bound = self.layers[layer][side];
            let stretch = end.min(distance) - begin;
            if *until_event < bound * stretch {
                return Some((begin + *until_event / bound, bound));
            }
            *until_event -= bound * stretch;
            if end >= distance {
                return None;
            }
            (begin, end) = (end, end + 1.0);
            // Only rounding at a wall could lead beyond the first and the last layer.
            layer = if rising { (layer + 1).min(self.layers.len() - 1) } else { layer.saturating_sub(1) };
        }
    }
}

/// Fails where the potential between two probes changes by more than the bounds of its force
/// allow.
fn check_mean_forces<F: Field, T: TemperatureProfile, D: Drive<F, T>>(
    drive: &D,
    scene: &Scene<F, T>,
    heights: impl Iterator<Item = f64>,
    bounds: [f64; 2],
) -> Result<(), Error> {
    /// Relative tolerance. An interpolated potential agrees with its force to 1e-8; rounding adds
    /// 1e-14.
    const CONSISTENCY: f64 = 1e-5;
    let mut probes = heights.map(|x| (x, drive.reduced_potential(scene, x)));
    let Some((mut from, mut before)) = probes.next() else { return Ok(()) };
    for (to, after) in probes {
        let allowed = 1e-12 * (before.abs() + after.abs()) + 1e-12;
        for (rise, bound) in [(after - before, bounds[0]), (before - after, bounds[1])] {
            if rise > (1.0 + CONSISTENCY) * bound * (to - from) + allowed {
                let force = (after - before) / (to - from);
                return Err(Error::InvalidForce { height: 0.5 * (from + to), force, bound });
            }
        }
        (from, before) = (to, after);
    }
    Ok(())
}
