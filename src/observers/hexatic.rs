//! Hexatic order in the plane of a layer.

use super::bins::HeightBins;
use super::neighbors::Neighbors;
use super::one_run::OneRun;
use super::radial_distribution::in_the_plane;
use crate::statistics::{BlockAverages, Estimate};
use crate::{Error, Frame, Merge, Observer, ObserverError, Slab};

/// Hexatic order of the spheres in a range of heights: ψ₆ of a sphere is the mean of e^{6iθ} over
/// the directions θ of its neighbors in the plane (Nelson and Halperin,
/// doi:10.1103/PhysRevB.19.2457).
///
/// Use it for the layer at a wall, which [`BondOrder`](super::BondOrder) does not classify. The
/// neighbors of a sphere are the other spheres of the range within a lateral distance. Choose this
/// distance at the first minimum of g(r), and a range that contains the whole layer: heights 0.5 to
/// 1 for the first layer.
///
/// ```
/// use gradient_mc::observers::HexaticOrder;
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// let slab = Slab::new(60.0, 6.0, 6.0)?;
/// let scene = Scene::new(slab, 360, UniformField::default(), Isothermal::new(5.0)?)?;
/// let mut first_layer = HexaticOrder::new(&slab, 0.5, 1.0, 1.4)?;
/// Simulation::builder(scene).build()?.run(64, &mut first_layer)?;
/// println!("{} {}", first_layer.local()?, first_layer.global()?);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct HexaticOrder {
    run: OneRun,
    heights: HeightBins,
    neighbors: Neighbors,
    averages: BlockAverages,
}

impl HexaticOrder {
    /// Makes an observer of the spheres at heights from `low` to `high`, with neighbors within the
    /// lateral distance `neighbor_distance`, all in diameters.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] if not 0 ≤ low < high ≤ height of the slab, or if the distance
    /// is not positive or above half the smaller width.
    pub fn new(slab: &Slab, low: f64, high: f64, neighbor_distance: f64) -> Result<Self, Error> {
        Ok(Self {
            run: OneRun::in_slab(slab),
            heights: HeightBins::new(slab, low, high, 1)?,
            neighbors: Neighbors::new(slab, neighbor_distance)?,
            averages: BlockAverages::new(3)?.said_of("frames for the hexatic order"),
        })
    }

    /// Number of frames observed.
    #[must_use]
    pub fn observations(&self) -> u64 {
        self.averages.observations()
    }

    /// Mean of |ψ₆| over spheres: 1 if all neighbors are at multiples of 60°, in any orientation. A
    /// sphere without neighbors counts as 0; NaN if the range was always empty.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] for fewer than 16 frames.
    pub fn local(&self) -> Result<Estimate, Error> {
        self.ratio(1)
    }

    /// Mean of |Σψ₆|/M over frames, for the M spheres of a frame: near 1 if all have the same
    /// orientation, of order 1/√M for short-range order.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] for fewer than 16 frames.
    pub fn global(&self) -> Result<Estimate, Error> {
        self.ratio(2)
    }

    fn ratio(&self, numerator: usize) -> Result<Estimate, Error> {
        let ratio = self.averages.jackknife(|means| [means[numerator] / means[0]])?;
        Ok(ratio.into_iter().next().unwrap_or(Estimate::new(f64::NAN, f64::NAN)))
    }
}

impl Merge for HexaticOrder {
    fn merge(&mut self, other: &Self) -> Result<(), Error> {
        self.heights.require_same(&other.heights)?;
        super::require_same_radius(&self.neighbors, &other.neighbors)?;
        self.run.pool(&mut self.averages, &other.run, &other.averages)
    }
}

impl Observer for HexaticOrder {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.run.admit(frame)?;
        self.neighbors.gather(in_the_plane(frame, &self.heights));
        let (mut local, mut total) = (0.0, [0.0; 2]);
        for sphere in 0..self.neighbors.count() {
            let (mut sum, mut count) = ([0.0; 2], 0.0);
            for neighbor in self.neighbors.of(sphere) {
                let angle = 6.0 * libm::atan2(neighbor.separation.z, neighbor.separation.y);
                sum[0] += libm::cos(angle);
                sum[1] += libm::sin(angle);
                count += 1.0;
            }
            if count > 0.0 {
                local += sum[0].hypot(sum[1]) / count;
                total[0] += sum[0] / count;
                total[1] += sum[1] / count;
            }
        }
        let spheres = self.neighbors.count() as f64;
        self.averages.push(&[spheres, local, total[0].hypot(total[1])])?;
        Ok(())
    }
}

persist!(HexaticOrder { part run, same heights, part neighbors, part averages });

#[cfg(test)]
mod tests {
    use super::super::test_frame::hexagonal_layer;
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    #[test]
    fn a_hexagonal_layer_is_ordered_and_independent_points_are_not() {
        let (mut scene, _) = hexagonal_layer(8, 1.1);
        let mut order = HexaticOrder::new(&scene.slab, 0.5, 1.0, 1.4).unwrap();
        let mut disorder = order.clone();
        let mut generator = Pcg64Mcg::seed_from_u64(1);
        for _ in 0..64 {
            order.observe(&scene.frame()).unwrap();
        }
        let widths = scene.slab.widths();
        for _ in 0..400 {
            for position in &mut scene.positions {
                *position =
                    [0.5, widths[0] * generator.random::<f64>(), widths[1] * generator.random::<f64>()];
            }
            disorder.observe(&scene.frame()).unwrap();
        }
        assert!((order.local().unwrap().mean - 1.0).abs() < 1e-12);
        assert!((order.global().unwrap().mean - 1.0).abs() < 1e-12);
        let (local, global) = (disorder.local().unwrap(), disorder.global().unwrap());
        // For k random directions √(π/4k), with k = 5 on average; both numbers are rough bounds.
        assert!(local.mean > 0.35 && local.mean < 0.55, "{local}");
        assert!(global.mean < 0.12, "{global}");
        order.merge(&disorder).unwrap();
        assert_eq!(order.observations(), 464);
        let other = HexaticOrder::new(&scene.slab, 0.5, 1.0, 1.3).unwrap();
        assert!(matches!(order.merge(&other), Err(Error::InvalidParameter { .. })));
        assert!(matches!(HexaticOrder::new(&scene.slab, 0.5, 1.0, 9.0), Err(Error::InvalidParameter { .. })));
        assert!(matches!(other.local(), Err(Error::TooFewObservations { .. })));
    }
}
