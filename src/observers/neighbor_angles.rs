//! Order in the plane of a layer: the angles between the neighbors of a sphere.

use super::bins::HeightBins;
use super::neighbors::Neighbors;
use super::one_run::OneRun;
use super::radial_distribution::in_the_plane;
use crate::statistics::{BlockAverages, Estimate};
use crate::{Error, Frame, Merge, Observer, ObserverError, Slab};

/// Lateral distance of neighbors in the paper, in diameters.
const NEIGHBOR_DISTANCE: f64 = 1.2;

/// Distribution g(θ) of the angles between the neighbors of a sphere, for the spheres in a range of
/// heights.
///
/// The neighbors of a sphere are the other spheres of the range within a lateral distance, 1.2
/// diameters in figure 11 of the paper (doi:10.1103/PhysRevE.83.061306). For all ordered pairs of
/// neighbors, θ is the angle from the first to the second, in the plane and counterclockwise, from
/// 0 to 360 degrees. g is symmetric: g(θ) = g(360° − θ). In a hexagonal layer its peaks are 60
/// degrees apart.
///
/// g is 1 if all angles are equally likely. Bins are centered on multiples of their width, the
/// first on 0. With a multiple of six bins, the angles of a perfect layer are in the middle of
/// bins.
///
/// ```
/// use gradient_mc::observers::NeighborAngles;
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// let slab = Slab::new(60.0, 6.0, 6.0)?;
/// let scene = Scene::new(slab, 180, UniformField::default(), Isothermal::new(5.0)?)?;
/// let mut first_layer = NeighborAngles::new(&slab, 0.5, 0.6, 72)?;
/// Simulation::builder(scene).build()?.run(64, &mut first_layer)?;
/// for point in first_layer.points()? {
///     println!("{:3.0}  {}", point.degrees, point.angular_distribution);
/// }
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct NeighborAngles {
    run: OneRun,
    heights: HeightBins,
    neighbors: Neighbors,
    bins: usize,
    /// Directions of the neighbors of a sphere, in turns.
    directions: Vec<f64>,
    /// Numbers of angles in bins, then numbers of neighbors and spheres.
    sample: Vec<f64>,
    averages: BlockAverages,
}

/// The distribution in one bin of angles, with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct NeighborAnglePoint {
    /// Middle of the bin, in degrees from 0 to below 360.
    pub degrees: f64,
    /// Mean of g(θ) over the bin. NaN if no sphere had two neighbors.
    pub angular_distribution: Estimate,
}

impl NeighborAngles {
    /// Makes an observer of the spheres at heights from `low` to `high`, with neighbors within 1.2
    /// diameters and `bins` of equal width over the full circle.
    ///
    /// # Errors
    /// [`Error::InvalidBins`] if the number of bins is not between 1 and
    /// [`MAXIMUM_BINS`](super::MAXIMUM_BINS); [`Error::InvalidParameter`] if not 0 ≤ low < high ≤
    /// height of the slab.
    pub fn new(slab: &Slab, low: f64, high: f64, bins: usize) -> Result<Self, Error> {
        if bins == 0 || bins > super::MAXIMUM_BINS {
            return Err(Error::InvalidBins { bins, extent: 360.0, maximum: super::MAXIMUM_BINS });
        }
        Ok(Self {
            run: OneRun::in_slab(slab),
            heights: HeightBins::new(slab, low, high, 1)?,
            neighbors: Neighbors::unchecked(slab, NEIGHBOR_DISTANCE),
            bins,
            directions: Vec::new(),
            sample: vec![0.0; bins + 2],
            averages: BlockAverages::new(bins + 2)?.said_of("frames for neighbor angles"),
        })
    }

    /// Number of frames observed.
    #[must_use]
    pub fn observations(&self) -> u64 {
        self.averages.observations()
    }

    /// Mean number of neighbors of a sphere; NaN if the range was always empty.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] for fewer than 16 frames.
    pub fn neighbors_per_sphere(&self) -> Result<Estimate, Error> {
        let ratio = |means: &[f64]| [means[self.bins] / means[self.bins + 1]];
        Ok(self.averages.jackknife(ratio)?.pop().unwrap_or(Estimate::new(f64::NAN, f64::NAN)))
    }

    /// The distribution, from 0 to 360 degrees, with errors by the jackknife.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] for fewer than 16 frames.
    pub fn points(&self) -> Result<Vec<NeighborAnglePoint>, Error> {
        let ratios = self.averages.jackknife(|means| {
            let angles = &means[..self.bins];
            let mean = angles.iter().sum::<f64>() / self.bins as f64;
            angles.iter().map(|&angles| angles / mean).collect::<Vec<f64>>()
        })?;
        let points = ratios.into_iter().enumerate().map(|(bin, angular_distribution)| NeighborAnglePoint {
            degrees: 360.0 * bin as f64 / self.bins as f64,
            angular_distribution,
        });
        Ok(points.collect())
    }
}

impl Merge for NeighborAngles {
    fn merge(&mut self, other: &Self) -> Result<(), Error> {
        self.heights.require_same(&other.heights)?;
        self.run.pool(&mut self.averages, &other.run, &other.averages)
    }
}

impl Observer for NeighborAngles {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.run.admit(frame)?;
        self.neighbors.gather(in_the_plane(frame, &self.heights));
        self.sample.fill(0.0);
        let (angles, counts) = self.sample.split_at_mut(self.bins);
        for sphere in 0..self.neighbors.count() {
            self.directions.clear();
            self.directions.extend(self.neighbors.of(sphere).map(|neighbor| {
                libm::atan2(neighbor.separation.z, neighbor.separation.y) / std::f64::consts::TAU
            }));
            counts[0] += self.directions.len() as f64;
            counts[1] += 1.0;
            for (first, reference) in self.directions.iter().enumerate() {
                for direction in &self.directions[first + 1..] {
                    let turn = (direction - reference) * self.bins as f64;
                    for turn in [turn, -turn] {
                        // Between −bins and bins.
                        #[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap)]
                        let bin = (turn.round() as isize).rem_euclid(self.bins as isize);
                        angles[bin.unsigned_abs()] += 1.0;
                    }
                }
            }
        }
        self.averages.push(&self.sample)?;
        Ok(())
    }
}

persist!(NeighborAngles { part run, same heights, part neighbors, same bins, part averages });

#[cfg(test)]
mod tests {
    use super::super::test_frame::{Scene, hexagonal_layer};
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    #[test]
    fn a_hexagonal_layer_has_peaks_sixty_degrees_apart() {
        let (scene, _) = hexagonal_layer(6, 1.1);
        let mut angles = NeighborAngles::new(&scene.slab, 0.5, 0.6, 180).unwrap();
        for _ in 0..16 {
            angles.observe(&scene.frame()).unwrap();
        }
        assert!((angles.neighbors_per_sphere().unwrap().mean - 6.0).abs() < 1e-12);
        for point in angles.points().unwrap() {
            // Five angles, each in its own bin, give 180/5; none is at zero.
            let peak = point.degrees % 60.0 == 0.0 && point.degrees > 0.0;
            let expected = if peak { 36.0 } else { 0.0 };
            assert!((point.angular_distribution.mean - expected).abs() < 1e-12, "at {}", point.degrees);
        }
    }

    fn independent_points(frames: u64, seed: u64) -> NeighborAngles {
        let mut generator = Pcg64Mcg::seed_from_u64(seed);
        let mut scene = Scene::new(10.0, &[]);
        let mut angles = NeighborAngles::new(&scene.slab, 0.0, 1.0, 12).unwrap();
        for _ in 0..frames {
            scene.positions =
                (0..50).map(|_| [1.0, 5.0, 5.0].map(|extent| extent * generator.random::<f64>())).collect();
            angles.observe(&scene.frame()).unwrap();
        }
        angles
    }

    #[test]
    fn independent_points_are_all_around() {
        let mut angles = independent_points(300, 1);
        angles.merge(&independent_points(300, 2)).unwrap();
        assert_eq!(angles.observations(), 600);
        let neighbors = angles.neighbors_per_sphere().unwrap();
        let exact = 49.0 * std::f64::consts::PI * 1.44 / 25.0;
        assert!(neighbors.deviation_from(exact).abs() < 4.0 && neighbors.standard_error < 0.05);
        let points = angles.points().unwrap();
        for (bin, point) in points.iter().enumerate() {
            let value = point.angular_distribution;
            assert!(value.deviation_from(1.0).abs() < 4.0 && value.standard_error < 0.01, "{value}");
            let mirrored = points[(12 - bin) % 12].angular_distribution;
            assert!((value.mean - mirrored.mean).abs() < 1e-12);
        }
        let other = NeighborAngles::new(&Scene::new(10.0, &[]).slab, 0.0, 1.5, 12);
        assert!(matches!(angles.merge(&other.unwrap()), Err(Error::InvalidParameter { .. })));
    }

    #[test]
    fn senseless_ranges_are_refused_and_loners_are_nan() {
        let scene = Scene::new(10.0, &[0.7]);
        assert!(matches!(NeighborAngles::new(&scene.slab, 0.0, 1.0, 0), Err(Error::InvalidBins { .. })));
        assert!(matches!(NeighborAngles::new(&scene.slab, 2.0, 1.0, 9), Err(Error::InvalidParameter { .. })));
        let mut alone = NeighborAngles::new(&scene.slab, 0.0, 1.0, 6).unwrap();
        for _ in 0..16 {
            alone.observe(&scene.frame()).unwrap();
        }
        assert!(alone.points().unwrap()[0].angular_distribution.mean.is_nan());
        assert!(alone.neighbors_per_sphere().unwrap().mean.abs() < 1e-15);
    }
}
