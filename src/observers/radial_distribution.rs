//! Order in the plane of a layer: the lateral radial distribution function.

use super::bins::{HeightBins, Place};
use super::neighbors::{Neighbors, half_width};
use super::one_run::OneRun;
use crate::statistics::{BlockAverages, Estimate};
use crate::{Error, Frame, Merge, Observer, ObserverError, Slab};
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Lateral radial distribution function g(r) of the spheres in a range of heights, r = √(Δy² +
/// Δz²).
///
/// g is the mean number of spheres at a lateral distance between r₁ and r₂ from a sphere, over ρ
/// π(r₂² − r₁²), where ρ = ⟨M⟩/A is the mean lateral density of the M spheres in the range. It is 1
/// without correlations and has peaks at the neighbor distances of a crystal. For the lowest 0.1
/// diameters it is shown in the inset of figure 4 and in figure 11 (left) of the paper
/// (doi:10.1103/PhysRevE.83.061306).
///
/// M fluctuates, and g is computed as A ⟨pairs⟩/(⟨M⟩² π(r₂² − r₁²)) with ordered pairs. Independent
/// points with Poisson-distributed M give exactly 1, and a fixed M gives 1 − 1/M. Distances are
/// lateral, so r can be below one diameter if the range is high enough for spheres above each
/// other.
///
/// ```
/// use gradient_mc::observers::RadialDistribution;
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// let slab = Slab::new(60.0, 6.0, 6.0)?;
/// let scene = Scene::new(slab, 180, UniformField::default(), Isothermal::new(5.0)?)?;
/// let mut first_layer = RadialDistribution::new(&slab, 0.5, 0.6, 30)?;
/// Simulation::builder(scene).build()?.run(64, &mut first_layer)?;
/// for point in first_layer.points()? {
///     println!("{:.2}  {}", point.distance, point.radial_distribution);
/// }
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct RadialDistribution {
    run: OneRun,
    heights: HeightBins,
    neighbors: Neighbors,
    bins: usize,
    /// Numbers of ordered pairs in bins of distance, and the number of spheres.
    sample: Vec<f64>,
    averages: BlockAverages,
}

/// The distribution in one bin of distances, with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct RadialDistributionPoint {
    /// Middle of the bin, in diameters.
    pub distance: f64,
    /// Mean of g(r) over the area of the bin. NaN if the range was always empty.
    pub radial_distribution: Estimate,
}

impl RadialDistribution {
    /// Makes an observer of the spheres at heights from `low` to `high`, with `bins` of equal width
    /// from r = 0 to half the smaller width of the slab.
    ///
    /// # Errors
    /// Those of [`with_maximum_distance`](Self::with_maximum_distance).
    pub fn new(slab: &Slab, low: f64, high: f64, bins: usize) -> Result<Self, Error> {
        Self::with_maximum_distance(slab, low, high, half_width(slab), bins)
    }

    /// [`new`](Self::new) with distances up to `maximum_distance`, in diameters. A short distance
    /// is faster: the time is proportional to the number of spheres.
    ///
    /// # Errors
    /// [`Error::InvalidBins`] if the number of bins is not between 1 and
    /// [`MAXIMUM_BINS`](super::MAXIMUM_BINS); [`Error::InvalidParameter`] if not 0 ≤ low < high ≤
    /// height of the slab, or if the distance is not positive or above half the smaller width.
    pub fn with_maximum_distance(
        slab: &Slab,
        low: f64,
        high: f64,
        maximum_distance: f64,
        bins: usize,
    ) -> Result<Self, Error> {
        let neighbors = Neighbors::new(slab, maximum_distance)?;
        if bins == 0 || bins > super::MAXIMUM_BINS {
            let maximum = super::MAXIMUM_BINS;
            return Err(Error::InvalidBins { bins, extent: maximum_distance, maximum });
        }
        Ok(Self {
            run: OneRun::in_slab(slab),
            heights: HeightBins::new(slab, low, high, 1)?,
            neighbors,
            bins,
            sample: vec![0.0; bins + 1],
            averages: BlockAverages::new(bins + 1)?.said_of("frames for a radial distribution"),
        })
    }

    /// Number of frames observed.
    #[must_use]
    pub fn observations(&self) -> u64 {
        self.averages.observations()
    }

    /// Mean number of spheres in the range of heights per area of the base, in inverse square
    /// diameters.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] for fewer than 16 frames.
    pub fn lateral_density(&self) -> Result<Estimate, Error> {
        let spheres = self.averages.estimates()?[self.bins];
        let area = self.heights.base_area();
        Ok(Estimate::new(spheres.mean / area, spheres.standard_error / area))
    }

    /// The distribution, from r = 0 outwards, with errors by the jackknife.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] for fewer than 16 frames.
    pub fn points(&self) -> Result<Vec<RadialDistributionPoint>, Error> {
        let width = self.neighbors.radius() / self.bins as f64;
        let ratios = self.averages.jackknife(|means| {
            let spheres = means[self.bins];
            let pairs_per_area = spheres * spheres / self.heights.base_area();
            let rows = means[..self.bins].iter().enumerate();
            rows.map(|(bin, pairs)| {
                let area = PI * width * width * (2 * bin + 1) as f64;
                if spheres > 0.0 { pairs / (pairs_per_area * area) } else { f64::NAN }
            })
            .collect::<Vec<f64>>()
        })?;
        let points = ratios.into_iter().enumerate().map(|(bin, radial_distribution)| {
            RadialDistributionPoint { distance: (bin as f64 + 0.5) * width, radial_distribution }
        });
        Ok(points.collect())
    }
}

impl Merge for RadialDistribution {
    fn merge(&mut self, other: &Self) -> Result<(), Error> {
        self.heights.require_same(&other.heights)?;
        super::require_same_radius(&self.neighbors, &other.neighbors)?;
        self.run.pool(&mut self.averages, &other.run, &other.averages)
    }
}

impl Observer for RadialDistribution {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.run.admit(frame)?;
        self.neighbors.gather(in_the_plane(frame, &self.heights));
        self.sample.fill(0.0);
        self.sample[self.bins] = self.neighbors.count() as f64;
        let bins_per_diameter = self.bins as f64 / self.neighbors.radius();
        for sphere in 0..self.neighbors.count() {
            // Each pair is found once and counted as two ordered pairs.
            for neighbor in self.neighbors.of(sphere).filter(|neighbor| neighbor.index > sphere) {
                // Not negative.
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                let bin = (neighbor.separation.norm() * bins_per_diameter) as usize;
                self.sample[bin.min(self.bins - 1)] += 2.0;
            }
        }
        self.averages.push(&self.sample)?;
        Ok(())
    }
}

/// The spheres in a range of heights, all moved to the same height.
pub(super) fn in_the_plane(frame: &Frame<'_>, heights: &HeightBins) -> impl Iterator<Item = Vector3<f64>> {
    let inside = |position: &Vector3<f64>| matches!(heights.locate(position.x), Place::Inside(..));
    frame.positions().filter(inside).map(|position| Vector3::new(0.0, position.y, position.z))
}

persist!(RadialDistribution { part run, same heights, part neighbors, same bins, part averages });

#[cfg(test)]
mod tests {
    use super::super::test_frame::{Scene, hexagonal_layer};
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    /// Independent points, as many at heights below 1 as a column of ideal particles happens to
    /// have there.
    fn ideal(frames: u64, seed: u64) -> RadialDistribution {
        let mut generator = Pcg64Mcg::seed_from_u64(seed);
        let mut scene = Scene::new(10.0, &[]);
        let mut distribution = RadialDistribution::new(&scene.slab, 0.0, 1.0, 10).unwrap();
        for _ in 0..frames {
            // 2000 points in ten diameters: binomial, with ⟨M(M − 1)⟩ = ⟨M⟩²(1 − 1/2000).
            scene.positions = (0..2000)
                .map(|_| [10.0, 5.0, 5.0].map(|extent| extent * generator.random::<f64>()))
                .collect();
            distribution.observe(&scene.frame()).unwrap();
        }
        distribution
    }

    #[test]
    fn independent_points_have_no_structure() {
        let mut distribution = ideal(100, 1);
        distribution.merge(&ideal(60, 2)).unwrap();
        assert_eq!(distribution.observations(), 160);
        let density = distribution.lateral_density().unwrap();
        assert!(density.deviation_from(8.0).abs() < 4.0 && density.standard_error < 0.1, "{density}");
        for point in distribution.points().unwrap() {
            let value = point.radial_distribution;
            assert!(value.deviation_from(1.0 - 1.0 / 2000.0).abs() < 4.0, "{value} at {}", point.distance);
            let cap = 0.01 * (0.5 / point.distance).max(1.0);
            assert!(value.standard_error < cap, "{value} at {}", point.distance);
        }
        let other = RadialDistribution::new(&Scene::new(10.0, &[]).slab, 0.0, 1.0, 11).unwrap();
        assert!(matches!(distribution.merge(&other), Err(Error::InvalidParameter { .. })));
    }

    /// Hard discs, sampled exactly: independent points, accepted if no two overlap. To first order
    /// in their density ρ, g(r) = 1 + ρ B(r), where B is the common area of two discs of radius 1
    /// at distance r.
    #[test]
    fn a_dilute_gas_of_hard_discs_has_its_first_peak() {
        const DISCS: usize = 20;
        let mut generator = Pcg64Mcg::seed_from_u64(4);
        let mut scene = Scene { slab: Slab::new(10.0, 20.0, 20.0).unwrap(), ..Scene::new(10.0, &[]) };
        let mut distribution =
            RadialDistribution::with_maximum_distance(&scene.slab, 0.5, 1.0, 4.0, 20).unwrap();
        let overlap = |first: &[f64; 3], second: &[f64; 3]| {
            let along = |axis: usize| {
                let difference = (first[axis] - second[axis]).abs();
                difference.min(20.0 - difference)
            };
            along(1) * along(1) + along(2) * along(2) < 1.0
        };
        for _ in 0..40_000 {
            scene.positions.clear();
            while scene.positions.len() < DISCS {
                let disc = [0.6, 20.0 * generator.random::<f64>(), 20.0 * generator.random::<f64>()];
                if scene.positions.iter().any(|other| overlap(&disc, other)) {
                    // Start again with all discs; a new trial of this disc alone would be biased.
                    scene.positions.clear();
                } else {
                    scene.positions.push(disc);
                }
            }
            distribution.observe(&scene.frame()).unwrap();
        }
        let density = DISCS as f64 / 400.0;
        // For a fixed number M, the other M − 1 discs share the area left free by one.
        let far = (1.0 - 1.0 / DISCS as f64) / (1.0 - PI / 400.0);
        let mut from_ideal = 0.0_f64;
        for point in distribution.points().unwrap() {
            let (distance, value) = (point.distance, point.radial_distribution);
            if distance < 1.0 {
                assert!(value.mean.abs() < 1e-15);
                continue;
            }
            let shared = 2.0 * (0.5 * distance).acos() - 0.5 * distance * (4.0 - distance * distance).sqrt();
            let expected = far * if distance < 2.0 { 1.0 + density * shared } else { 1.0 };
            // The next order, ρ², is about 0.2 %.
            let off = (value.mean - expected).abs();
            assert!(off < 4.0 * value.standard_error + 0.004, "{value} and not {expected} at {distance}");
            // The error from independent frames is 0.009. Errors scatter by 15 %; there are fifty
            // bins.
            assert!(value.standard_error < 0.013, "{value}");
            from_ideal = from_ideal.max((value.mean - far) / value.standard_error);
        }
        // The increase by 6 % near contact is significant.
        assert!(from_ideal > 5.0, "{from_ideal}");
    }

    /// Six neighbors at a, six at √3 a, six at 2a, twelve at √7 a.
    #[test]
    fn a_hexagonal_layer_has_its_shells() {
        let (mut scene, spacing) = hexagonal_layer(8, 1.103);
        // A layer above that must not count.
        let above: Vec<[f64; 3]> = scene.positions.iter().map(|&[x, y, z]| [x + 0.9, z, y]).collect();
        let spheres = scene.positions.len() as f64;
        scene.positions.extend(above);
        let bins = 400;
        let mut distribution =
            RadialDistribution::with_maximum_distance(&scene.slab, 0.5, 1.0, 4.0, bins).unwrap();
        for _ in 0..16 {
            distribution.observe(&scene.frame()).unwrap();
        }
        let area = scene.slab.base_area();
        let points = distribution.points().unwrap();
        let mut expected = vec![0.0; bins];
        for (squared, count) in
            [(1.0, 6.0), (3.0, 6.0), (4.0, 6.0), (7.0, 12.0), (9.0, 6.0), (12.0, 6.0), (13.0, 12.0)]
        {
            let distance = spacing * f64::sqrt(squared);
            let bin = points.iter().position(|point| (point.distance - distance).abs() <= 0.005).unwrap();
            let shell = PI * (points[bin].distance * 2.0) * 0.01;
            expected[bin] = count * area / (spheres * shell);
        }
        for (point, expected) in points.iter().zip(expected) {
            let value = point.radial_distribution.mean;
            approx::assert_relative_eq!(value, expected, max_relative = 1e-9);
        }
        approx::assert_relative_eq!(
            distribution.lateral_density().unwrap().mean,
            2.0 / (3.0_f64.sqrt() * spacing * spacing),
            max_relative = 1e-12
        );
    }

    #[test]
    fn senseless_ranges_are_refused_and_nobody_is_nan() {
        let scene = Scene::new(10.0, &[3.0]);
        let slab = scene.slab;
        assert!(matches!(RadialDistribution::new(&slab, 0.0, 1.0, 0), Err(Error::InvalidBins { .. })));
        assert!(matches!(RadialDistribution::new(&slab, 1.0, 1.0, 9), Err(Error::InvalidParameter { .. })));
        let far = RadialDistribution::with_maximum_distance(&slab, 0.0, 1.0, 2.6, 9);
        assert!(matches!(far, Err(Error::InvalidParameter { .. })));
        let mut empty = RadialDistribution::new(&slab, 0.0, 1.0, 9).unwrap();
        assert!(matches!(empty.points(), Err(Error::TooFewObservations { .. })));
        for _ in 0..16 {
            empty.observe(&scene.frame()).unwrap();
        }
        assert!(empty.points().unwrap().iter().all(|point| point.radial_distribution.mean.is_nan()));
        let other = Scene { slab: Slab::new(10.0, 5.0, 6.0).unwrap(), ..Scene::new(10.0, &[]) };
        assert!(empty.observe(&other.frame()).is_err());
    }
}
