//! Profile of the fractions of crystal and fluid.

use super::bins::{Bins, HeightBins, Place};
use super::bond_order::{BondOrder, Structure};
use super::one_run::OneRun;
use crate::statistics::{BlockAverages, Estimate};
use crate::{Error, Frame, Merge, Observer, ObserverError, Slab};

/// Fractions of fcc-like, hcp-like and fluid-like spheres in bins of equal height, by
/// [`BondOrder`].
///
/// The layer at a wall is not classified and not counted, because its spheres have no neighbors on
/// one side.
///
/// ```
/// use gradient_mc::observers::{Bins, StructureProfile};
/// use gradient_mc::{Every, Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// let slab = Slab::new(60.0, 6.0, 6.0)?;
/// let scene = Scene::new(slab, 360, UniformField::default(), Isothermal::new(5.0)?)?;
/// let mut structure = Every::new(4, StructureProfile::new(&slab, Bins::count(12).from(1.0).to(13.0))?);
/// Simulation::builder(scene).build()?.run(64, &mut structure)?;
/// for point in structure.observer.points()? {
///     println!("{:4.1}  {}  {}", point.height, point.face_centered_cubic, point.fluid);
/// }
/// assert_eq!(structure.observer.front()?, None);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct StructureProfile {
    run: OneRun,
    bins: HeightBins,
    order: BondOrder,
    /// For every bin: numbers of fcc-like, hcp-like and fluid-like spheres, and the sum of their
    /// averaged q₆.
    sample: Vec<f64>,
    averages: BlockAverages,
}

/// Structure of the spheres in one bin or range of heights, with standard errors.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct StructurePoint {
    /// Middle of the bin, in diameters.
    pub height: f64,
    /// Fraction of fcc-like spheres, from 0 to 1. All fractions are NaN if no sphere was
    /// classified.
    pub face_centered_cubic: Estimate,
    /// Fraction of hcp-like spheres.
    pub hexagonal_close_packed: Estimate,
    /// Fraction of fluid-like spheres.
    pub fluid: Estimate,
    /// Mean of the averaged q₆ over spheres.
    pub bond_order: Estimate,
}

/// Number of values per bin.
const VALUES: usize = 4;

impl StructureProfile {
    /// Makes an empty profile with `bins` over the heights of `slab`.
    ///
    /// # Errors
    /// Those of [`Bins`].
    pub fn new(slab: &Slab, bins: Bins) -> Result<Self, Error> {
        let bins = bins.of(slab)?;
        let components = VALUES * bins.count();
        let averages = BlockAverages::new(components)?.said_of("frames for a structure profile");
        Ok(Self {
            run: OneRun::in_slab(slab),
            bins,
            order: BondOrder::new(slab),
            sample: vec![0.0; components],
            averages,
        })
    }

    /// Number of frames observed.
    #[must_use]
    pub fn observations(&self) -> u64 {
        self.averages.observations()
    }

    /// The profile, from the lowest bin upwards, with errors by the jackknife.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] for fewer than 16 frames.
    pub fn points(&self) -> Result<Vec<StructurePoint>, Error> {
        let ratios = self.averages.jackknife(|means| {
            means.chunks_exact(VALUES).flat_map(|bin| fractions(bin.iter().copied())).collect::<Vec<f64>>()
        })?;
        Ok(self
            .bins
            .centers()
            .zip(ratios.chunks_exact(VALUES))
            .map(|(height, values)| point(height, values))
            .collect())
    }

    /// Structure of all spheres in the bins whose middles are in `[low, high)`.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] for fewer than 16 frames.
    pub fn over(&self, low: f64, high: f64) -> Result<StructurePoint, Error> {
        let inside: Vec<bool> = self.bins.centers().map(|height| (low..high).contains(&height)).collect();
        let ratios = self.averages.jackknife(|means| {
            let mut sums = [0.0; VALUES];
            for (bin, _) in means.chunks_exact(VALUES).zip(&inside).filter(|(_, inside)| **inside) {
                for (sum, value) in sums.iter_mut().zip(bin) {
                    *sum += value;
                }
            }
            fractions(sums)
        })?;
        Ok(point(0.5 * (low + high), &ratios))
    }

    /// Height of the uppermost front of the crystal, in diameters: where the crystalline fraction
    /// decreases through one half, interpolated between the middles of two bins. `None` if there is
    /// no such height in the mean profile.
    ///
    /// The error is by the jackknife; it is NaN if the front is missing in a part of the run.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] for fewer than 16 frames.
    pub fn front(&self) -> Result<Option<Estimate>, Error> {
        let heights: Vec<f64> = self.bins.centers().collect();
        let front = self.averages.jackknife(|means| {
            let crystalline = |bin: usize| {
                let values = &means[VALUES * bin..];
                let crystal = values[0] + values[1];
                // Empty bins are above the bed.
                if crystal > 0.0 { crystal / (crystal + values[2]) } else { 0.0 }
            };
            let last = (0..heights.len()).rev().find(|&bin| crystalline(bin) >= 0.5);
            [match last {
                Some(bin) if bin + 1 < heights.len() => {
                    let (below, above) = (crystalline(bin), crystalline(bin + 1));
                    heights[bin] + (heights[bin + 1] - heights[bin]) * (below - 0.5) / (below - above)
                }
                _ => f64::NAN,
            }]
        })?;
        Ok(front.into_iter().next().filter(|front| !front.mean.is_nan()))
    }
}

/// Fractions and mean order, from numbers of spheres and the sum of q₆.
fn fractions(values: impl IntoIterator<Item = f64>) -> [f64; VALUES] {
    let mut result = [0.0; VALUES];
    for (result, value) in result.iter_mut().zip(values) {
        *result = value;
    }
    let all: f64 = result[..3].iter().sum();
    result.map(|value| if all > 0.0 { value / all } else { f64::NAN })
}

fn point(height: f64, values: &[Estimate]) -> StructurePoint {
    StructurePoint {
        height,
        face_centered_cubic: values[0],
        hexagonal_close_packed: values[1],
        fluid: values[2],
        bond_order: values[3],
    }
}

impl Merge for StructureProfile {
    fn merge(&mut self, other: &Self) -> Result<(), Error> {
        self.bins.require_same(&other.bins)?;
        self.run.pool(&mut self.averages, &other.run, &other.averages)
    }
}

impl Observer for StructureProfile {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.run.admit(frame)?;
        self.order.gather(frame.positions());
        self.sample.fill(0.0);
        for (sphere, height) in frame.heights().enumerate() {
            let Place::Inside(bin, _) = self.bins.locate(height) else { continue };
            let Some((bond_order, structure)) = self.order.order(sphere) else { continue };
            let kind = match structure {
                Structure::FaceCenteredCubic => 0,
                Structure::HexagonalClosePacked => 1,
                Structure::Fluid => 2,
            };
            self.sample[VALUES * bin + kind] += 1.0;
            self.sample[VALUES * bin + VALUES - 1] += bond_order;
        }
        self.averages.push(&self.sample)?;
        Ok(())
    }
}

persist!(StructureProfile { part run, same bins, part averages });

#[cfg(test)]
mod tests {
    use super::super::test_frame::Scene;
    use super::*;

    /// Layers ABCABC... up to `height`, touching at 1.1, and a gas above.
    fn crystal_below(height: f64) -> Scene {
        let (spacing, columns) = (1.1, 5_u32);
        let row = spacing * 3.0_f64.sqrt();
        let mut scene = Scene::new(20.0, &[]);
        scene.slab = Slab::new(20.0, f64::from(columns) * spacing, 3.0 * row).unwrap();
        let mut layer = 0_u32;
        loop {
            let x = 0.5 + f64::from(layer) * spacing * (2.0_f64 / 3.0).sqrt();
            if x > 18.0 {
                break scene;
            }
            for site in 0..30 {
                let (column, line) = (site % 10, site / 10);
                let y = 0.5 * f64::from(column) * spacing;
                let z = (f64::from(line) + 0.5 * f64::from(column % 2) + f64::from(layer % 3) / 3.0) * row;
                if x < height || site % 5 == 0 {
                    scene.positions.push([x, y, z % (3.0 * row)]);
                }
            }
            layer += 1;
        }
    }

    #[test]
    fn a_crystal_under_a_gas_has_a_front() {
        let scene = crystal_below(10.0);
        let mut profile = StructureProfile::new(&scene.slab, Bins::count(20)).unwrap();
        let mut other = profile.clone();
        for _ in 0..16 {
            profile.observe(&scene.frame()).unwrap();
            other.observe(&scene.frame()).unwrap();
        }
        profile.merge(&other).unwrap();
        assert_eq!(profile.observations(), 32);
        let points = profile.points().unwrap();
        assert!(points[0].fluid.mean.is_nan());
        for point in &points[1..8] {
            assert!((point.face_centered_cubic.mean - 1.0).abs() < 1e-12, "{point:?}");
            assert!(point.hexagonal_close_packed.mean.abs() + point.fluid.mean.abs() < 1e-12);
            assert!(point.bond_order.mean > 0.5);
        }
        assert!(points[12..18].iter().all(|point| (point.fluid.mean - 1.0).abs() < 1e-12));
        let front = profile.front().unwrap().unwrap();
        assert!(front.mean > 8.4 && front.mean < 10.0 && front.standard_error < 1e-12, "{front}");
        let crystal = profile.over(1.0, 8.0).unwrap();
        assert!(
            (crystal.face_centered_cubic.mean - 1.0).abs() < 1e-12 && (crystal.height - 4.5).abs() < 1e-12
        );
        let both = profile.over(1.0, 20.0).unwrap();
        let sum = both.face_centered_cubic.mean + both.hexagonal_close_packed.mean + both.fluid.mean;
        assert!((sum - 1.0).abs() < 1e-12 && both.fluid.mean > 0.1);
    }

    #[test]
    fn without_crystal_or_spheres_there_is_no_front() {
        let scene = crystal_below(0.0);
        let mut profile = StructureProfile::new(&scene.slab, Bins::count(20)).unwrap();
        assert!(matches!(profile.points(), Err(Error::TooFewObservations { .. })));
        for _ in 0..16 {
            profile.observe(&scene.frame()).unwrap();
        }
        assert_eq!(profile.front().unwrap(), None);
        assert!(profile.over(30.0, 31.0).unwrap().fluid.mean.is_nan());
        let other = StructureProfile::new(&scene.slab, Bins::count(19)).unwrap();
        assert!(matches!(profile.merge(&other), Err(Error::InvalidParameter { .. })));
        assert!(profile.observe(&Scene::new(10.0, &[]).frame()).is_err());
    }
}
