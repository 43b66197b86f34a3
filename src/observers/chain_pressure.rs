//! Normal and lateral pressure against height, from event chains.

use super::bins::{Bins, HeightBins, Place};
use super::one_run::OneRun;
use crate::statistics::{BlockAverages, Estimate};
use crate::{Collision, Error, Frame, Merge, Observer, ObserverError, Recorder, Slab};

/// The pressures `P_xx(x)` and `P_yy(x)` = `P_zz(x)` of a simulation by event chains, from the
/// collisions of the chains: an estimate that does not use the weight of the column.
///
/// A chain visits every sphere with the same probability and collides with its neighbors at the
/// rate at which they are found in contact, so that collisions sample the virial (homogeneous
/// systems: Michel, Kapfer and Krauth, doi:10.1063/1.4863991). Resolved by height, with the
/// momentum that a collision transfers spread along the line between the centers (Irving and
/// Kirkwood), the pressure in a bin of width w is
///
/// P/T = n + N/(A w ℓ) Σ s q,
///
/// summed over the collisions of all chains along the axis, whose lengths add up to ℓ; s is the
/// separation of the two centers along that axis, and q the part of the line between them that lies
/// in the bin. For a scene whose temperature varies, P/T is what the isothermal system on which the
/// scene is mapped obeys at every height. So every sphere counts with the T of its height, and
/// every part of a line with that of its own, read in the middle of stretches of at most an eighth
/// of a diameter: P is the mean over the bin, however wide that is.
///
/// No center lies within half a diameter of a wall, and the walls bear what is missing there:
/// pressures are means over the part of a bin in which centers can be, and NaN in a bin that has
/// none.
///
/// Force balance makes the normal pressure equal to the weight of the column at every height,
/// layers at the walls included, once the column is in equilibrium: the two together test that it
/// is. The lateral pressure differs from it where the fluid is layered.
#[derive(Debug, Clone)]
pub struct ChainPressureProfile {
    run: OneRun,
    bins: HeightBins,
    /// The bins, each divided evenly into stretches in which the temperature is one number.
    stretches: HeightBins,
    /// Of the scene in the middles of the stretches; empty before the first frame.
    temperatures: Vec<f64>,
    /// Of the interval under way: Σ s q of vertical and of lateral chains in all stretches, and the
    /// two path lengths.
    collisions: Vec<f64>,
    paths: [f64; 2],
    /// Scratch for what is averaged: Σ T s q of vertical and of lateral chains in all bins, Σ T of
    /// spheres in all bins, and the two path lengths.
    sample: Vec<f64>,
    particles: f64,
    /// Sweeps that ended with an error, up to the last frame.
    incomplete: u64,
    averages: BlockAverages,
}

/// Means of one bin over all frames, or over those that a jackknife leaves; see
/// [`ChainPressureProfile::jackknife`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct BinPressures {
    /// Middle of the bin.
    pub height: f64,
    /// Normal pressure `P_xx`, in m g/d².
    pub normal: f64,
    /// Lateral pressure, the mean of `P_yy` and `P_zz`.
    pub lateral: f64,
}

/// Pressures in one bin.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
        /// Longest stretch in which the temperature is one number, in diameters.
        const STRETCH: f64 = 0.125;
        let bins = bins.of(slab)?;
        let components = 3 * bins.count() + 2;
        let stretches = bins.divided(STRETCH);
        Ok(Self {
            run: OneRun::in_slab(slab),
            bins,
            temperatures: Vec::new(),
            collisions: vec![0.0; 2 * stretches.count()],
            stretches,
            paths: [0.0; 2],
            sample: vec![0.0; components],
            particles: 0.0,
            incomplete: 0,
            averages: BlockAverages::new(components)?
                .said_of("frames for a profile of pressures from chains"),
        })
    }

    /// Frames observed.
    #[must_use]
    pub fn observations(&self) -> u64 {
        self.averages.observations()
    }

    /// The profile, upwards, with errors by the jackknife. A pressure is NaN if no chain ran along
    /// its axes, or if no center can be in the bin.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] below 16 frames.
    pub fn points(&self) -> Result<Vec<ChainPressurePoint>, Error> {
        let pressures = self
            .jackknife(|bins| bins.iter().flat_map(|bin| [bin.normal, bin.lateral]).collect::<Vec<f64>>())?;
        let rows = self.bins.centers().zip(pressures.chunks_exact(2));
        Ok(rows
            .map(|(height, pair)| ChainPressurePoint { height, normal: pair[0], lateral: pair[1] })
            .collect())
    }

    /// Any function of the pressures of all bins, upwards, with errors by the jackknife over
    /// blocks: means over groups of bins, differences from the weight of the column, fits.
    /// `function` must return the same number of values each time.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] below 16 frames.
    pub fn jackknife<R: AsRef<[f64]>>(
        &self,
        mut function: impl FnMut(&[BinPressures]) -> R,
    ) -> Result<Vec<Estimate>, Error> {
        let bins = self.bins.count();
        let mut pressures = Vec::with_capacity(bins);
        self.averages.jackknife(|means| {
            let (sums, paths) = means.split_at(3 * bins);
            pressures.clear();
            pressures.extend(self.bins.centers().enumerate().map(|(bin, height)| {
                // 0/0 where no center can be.
                let volume = self.bins.accessible_volume(bin);
                let pressure = |axis: usize| {
                    let transferred = self.particles * sums[axis * bins + bin] / paths[axis];
                    (sums[2 * bins + bin] + transferred) / volume
                };
                BinPressures { height, normal: pressure(0), lateral: pressure(1) }
            }));
            function(&pressures)
        })
    }
}

impl Merge for ChainPressureProfile {
    fn merge(&mut self, other: &Self) -> Result<(), Error> {
        self.bins.require_same(&other.bins)?;
        self.run.require_same_scene(&other.run)?;
        self.averages.merge(&other.averages)?;
        self.run.join(&other.run);
        if self.temperatures.is_empty() {
            self.temperatures.clone_from(&other.temperatures);
            self.particles = other.particles;
        }
        Ok(())
    }
}

impl Observer for ChainPressureProfile {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.run.admit(frame)?;
        let temperature = |height: f64| frame.temperature().temperature(height);
        if self.temperatures.is_empty() {
            self.temperatures = self.stretches.centers().map(temperature).collect();
            self.particles = frame.particles() as f64;
        }
        let incomplete = frame.move_counts().incomplete_sweeps;
        if std::mem::replace(&mut self.incomplete, incomplete) != incomplete {
            // A chain that ended with an error has collisions and no length.
            self.collisions.fill(0.0);
            self.paths = [0.0; 2];
        }
        let bins = self.bins.count();
        let divisions = self.stretches.count() / bins;
        let (transfers, rest) = self.sample.split_at_mut(2 * bins);
        let (spheres, paths) = rest.split_at_mut(bins);
        let rows =
            self.collisions.chunks_exact(divisions).zip(self.temperatures.chunks_exact(divisions).cycle());
        for (transfer, (collisions, temperatures)) in transfers.iter_mut().zip(rows) {
            *transfer = collisions.iter().zip(temperatures).map(|(sum, temperature)| sum * temperature).sum();
        }
        spheres.fill(0.0);
        for height in frame.heights() {
            if let Place::Inside(bin, _) = self.bins.locate(height) {
                spheres[bin] += temperature(height);
            }
        }
        paths.copy_from_slice(&self.paths);
        self.averages.push(&self.sample)?;
        self.collisions.fill(0.0);
        self.paths = [0.0; 2];
        Ok(())
    }

    fn recorder(&mut self) -> Option<&mut dyn Recorder> {
        Some(self)
    }
}

impl Recorder for ChainPressureProfile {
    fn record_collision(&mut self, collision: &Collision) {
        let count = self.stretches.count();
        let first = usize::from(collision.axis != 0) * count;
        let (low, high) = if collision.from_height < collision.to_height {
            (collision.from_height, collision.to_height)
        } else {
            (collision.to_height, collision.from_height)
        };
        let sums = &mut self.collisions[first..first + count];
        self.stretches.spread(low, high, |stretch, part| sums[stretch] += collision.separation * part);
    }

    fn record_chain(&mut self, axis: usize, length: f64) {
        self.paths[usize::from(axis != 0)] += length;
    }

    fn wants_local_moves(&mut self) -> bool {
        false
    }
}

persist!(
    ChainPressureProfile {
        part run,
        same bins,
        value temperatures,
        slice collisions,
        value paths,
        value particles,
        count incomplete,
        part averages,
    },
    |profile| profile.temperatures.is_empty() || profile.temperatures.len() == profile.stretches.count()
);
