//! Normal and lateral pressure against height, from event chains.

use super::bins::{Bins, HeightBins, Place};
use crate::statistics::{BlockAverages, Estimate};
use crate::{Collision, Error, Frame, Merge, Observer, ObserverError, Recorder, Slab};

/// The pressures `P_xx(x)` and `P_yy(x)` = `P_zz(x)` of a simulation by event chains, from the collisions of
/// the chains: an estimate that owes nothing to the weight of the column.
///
/// A chain visits every sphere with the same probability and collides with its neighbors at the rate at
/// which they are found in contact, so that collisions sample the virial (homogeneous systems:
/// Michel, Kapfer and Krauth, doi:10.1063/1.4863991). Resolved by height, with the momentum that a
/// collision transfers spread along the line between the centers (Irving and Kirkwood), the
/// pressure in a bin of width w is
///
/// P/T = n + N/(A w ℓ) Σ s q,
///
/// summed over the collisions of all chains along the axis, whose lengths add up to ℓ; s is the separation
/// of the two centers along that axis, and q the part of the line between them that lies in
/// the bin. For a scene whose temperature varies, T is that of the height: P/T is then what
/// the isothermal system on which the scene is mapped obeys.
///
/// Force balance makes the normal pressure equal to the weight of the column at every height, layers at the
/// walls included, once the column is in equilibrium: the two together test that it is. The lateral
/// pressure differs from it where the fluid is layered.
#[derive(Debug, Clone)]
pub struct ChainPressureProfile {
    bins: HeightBins,
    temperatures: Vec<f64>,
    /// Of the interval under way: Σ s q of vertical and of lateral chains in all bins, spheres in
    /// all bins, and the two path lengths.
    sample: Vec<f64>,
    particles: f64,
    averages: BlockAverages,
}

/// Pressures in one bin.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ChainPressurePoint {
    /// Middle of the bin.
    pub height: f64,
    /// Normal pressure `P_xx`, in m g/d².
    pub normal: Estimate,
    /// Lateral pressure, the mean of `P_yy` and `P_zz`.
    pub lateral: Estimate,
}

impl ChainPressureProfile {
    /// A profile over `bins` of the heights of `slab`.
    ///
    /// # Errors
    /// Those of [`Bins`].
    pub fn new(slab: &Slab, bins: Bins) -> Result<Self, Error> {
        let bins = bins.of(slab)?;
        let components = 3 * bins.count() + 2;
        Ok(Self {
            bins,
            temperatures: Vec::new(),
            sample: vec![0.0; components],
            particles: 0.0,
            averages: BlockAverages::new(components)?,
        })
    }

    /// Frames observed.
    #[must_use]
    pub fn observations(&self) -> u64 {
        self.averages.observations()
    }

    /// The profile, upwards, with errors by the jackknife. A pressure is NaN if no chain ran along its
    /// axes.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] below 16 frames.
    pub fn points(&self) -> Result<Vec<ChainPressurePoint>, Error> {
        let bins = self.bins.count();
        let volume = self.bins.volume();
        let pressures = self.averages.jackknife(|means| {
            let (sums, paths) = means.split_at(3 * bins);
            let mut pressures = Vec::with_capacity(2 * bins);
            for (axis, &path) in paths.iter().enumerate() {
                for bin in 0..bins {
                    let transferred = self.particles * sums[axis * bins + bin] / path;
                    pressures.push(self.temperatures[bin] * (sums[2 * bins + bin] + transferred) / volume);
                }
            }
            pressures
        })?;
        let (normal, lateral) = pressures.split_at(bins);
        let rows = self.bins.centers().zip(normal.iter().zip(lateral));
        Ok(rows.map(|(height, (&normal, &lateral))| ChainPressurePoint { height, normal, lateral }).collect())
    }
}

fn require_particles(mine: f64, value: f64) -> Result<(), Error> {
    if mine.to_bits() == value.to_bits() {
        return Ok(());
    }
    let requirement = "profiles can only be pooled if they are of the same scene";
    Err(Error::InvalidParameter { name: "number of spheres", value, requirement })
}

impl Merge for ChainPressureProfile {
    fn merge(&mut self, other: &Self) -> Result<(), Error> {
        self.bins.require_same(&other.bins)?;
        if self.temperatures.is_empty() {
            self.temperatures.clone_from(&other.temperatures);
            self.particles = other.particles;
        } else if !other.temperatures.is_empty() {
            super::require_same_temperatures(&self.temperatures, other.temperatures.iter().copied())?;
            require_particles(self.particles, other.particles)?;
        }
        self.averages.merge(&other.averages)
    }
}

impl Observer for ChainPressureProfile {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.bins.require_slab_of(frame)?;
        let temperatures = self.bins.centers().map(|height| frame.temperature().temperature(height));
        let particles = frame.particles() as f64;
        if self.temperatures.is_empty() {
            self.temperatures.extend(temperatures);
            self.particles = particles;
        } else {
            super::require_same_temperatures(&self.temperatures, temperatures)?;
            require_particles(self.particles, particles)?;
        }
        let counts = &mut self.sample[2 * self.bins.count()..];
        for height in frame.heights() {
            if let Place::Inside(bin, _) = self.bins.locate(height) {
                counts[bin] += 1.0;
            }
        }
        self.averages.push(&self.sample)?;
        self.sample.fill(0.0);
        Ok(())
    }

    fn recorder(&mut self) -> Option<&mut dyn Recorder> {
        Some(self)
    }
}

impl Recorder for ChainPressureProfile {
    fn record_collision(&mut self, collision: &Collision) {
        let first = usize::from(collision.axis != 0) * self.bins.count();
        let (low, high) = if collision.from_height < collision.to_height {
            (collision.from_height, collision.to_height)
        } else {
            (collision.to_height, collision.from_height)
        };
        let sums = &mut self.sample[first..first + self.bins.count()];
        self.bins.spread(low, high, |bin, part| sums[bin] += collision.separation * part);
    }

    fn record_chain(&mut self, axis: usize, length: f64) {
        let first_path = 3 * self.bins.count();
        self.sample[first_path + usize::from(axis != 0)] += length;
    }
}
