//! Profiles of normal and lateral pressure from event chains.

use super::bins::{Bins, HeightBins, Place};
use super::one_run::OneRun;
use crate::statistics::{BlockAverages, Estimate};
use crate::{Collision, Error, Frame, Merge, Observer, ObserverError, Recorder, Slab};

/// Profiles of the normal pressure `P_xx(x)` and the lateral pressure `P_yy(x)` = `P_zz(x)`, in m
/// g/d², from the collisions of event chains. They do not use the weight of the column.
///
/// Chains visit all spheres with equal probability, and their collisions sample the virial (for
/// homogeneous systems: Michel, Kapfer and Krauth, doi:10.1063/1.4863991). To resolve the pressure
/// by height, the momentum transfer of a collision is spread along the line between the centers
/// (Irving and Kirkwood). The pressure in a bin of width w is
///
/// P/T = n + N/(A w ℓ) Σ s q,
///
/// The sum is over the collisions of all chains along the axis. ℓ is the total length of these
/// chains, s the separation of the two centers along the axis, and q the fraction of the line
/// between them that is in the bin. If the temperature varies, this relation for P/T holds in the
/// isothermal system at every height. Therefore every sphere and every part of a line is multiplied
/// by T at its own height, with a resolution of 1/8 diameter, and P is the mean over the bin for
/// any bin width.
///
/// Centers cannot be within half a diameter of a wall. Pressures are means over the accessible part
/// of a bin, and NaN in a bin without one.
///
/// In a stationary column the normal pressure equals the weight of the column at every height, also
/// in the layers at the walls. Comparing the two tests whether the column is stationary. The
/// lateral pressure differs from the normal pressure in the layers.
///
/// ```
/// use gradient_mc::observers::{Bins, ChainPressureProfile};
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// let slab = Slab::new(60.0, 6.0, 6.0)?;
/// let scene = Scene::new(slab, 36, UniformField::default(), Isothermal::new(5.0)?)?;
/// let mut profile = ChainPressureProfile::new(&slab, Bins::count(20))?;
/// Simulation::builder(scene).build()?.run(100, &mut profile)?;
/// for point in profile.points()? {
///     println!("{:4.1}  {}  {}", point.height, point.normal, point.lateral);
/// }
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct ChainPressureProfile {
    run: OneRun,
    bins: HeightBins,
    /// The bins, each divided into stretches of constant temperature.
    stretches: HeightBins,
    /// Temperatures in the middles of the stretches; empty before the first frame.
    temperatures: Vec<f64>,
    /// Current interval: Σ s q of vertical and of lateral chains in all stretches, and the two path
    /// lengths.
    collisions: Vec<f64>,
    paths: [f64; 2],
    /// Scratch for one sample: Σ T s q of vertical and of lateral chains in all bins, Σ T of
    /// spheres in all bins, and the two path lengths.
    sample: Vec<f64>,
    particles: f64,
    /// Number of incomplete sweeps up to the last frame.
    incomplete: u64,
    averages: BlockAverages,
}

/// Mean pressures of one bin, over all frames or over a jackknife sample of them; see
/// [`ChainPressureProfile::jackknife`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct BinPressures {
    /// Middle of the bin, in diameters.
    pub height: f64,
    /// Normal pressure `P_xx`, in m g/d².
    pub normal: f64,
    /// Lateral pressure, the mean of `P_yy` and `P_zz`, in m g/d².
    pub lateral: f64,
}

/// Pressures in one bin, with standard errors.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct ChainPressurePoint {
    /// Middle of the bin, in diameters.
    pub height: f64,
    /// Normal pressure `P_xx`, in m g/d².
    pub normal: Estimate,
    /// Lateral pressure, the mean of `P_yy` and `P_zz`, in m g/d².
    pub lateral: Estimate,
}

impl ChainPressureProfile {
    /// Makes an empty profile with `bins` over the heights of `slab`.
    ///
    /// # Errors
    /// Those of [`Bins`].
    pub fn new(slab: &Slab, bins: Bins) -> Result<Self, Error> {
        /// Longest stretch of constant temperature, in diameters.
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

    /// Number of frames observed.
    #[must_use]
    pub fn observations(&self) -> u64 {
        self.averages.observations()
    }

    /// The profile, from the lowest bin upwards, with errors by the jackknife. A pressure is NaN if
    /// no chain ran along its axes, or if the bin is not accessible to centers.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] for fewer than 16 frames.
    pub fn points(&self) -> Result<Vec<ChainPressurePoint>, Error> {
        let pressures = self
            .jackknife(|bins| bins.iter().flat_map(|bin| [bin.normal, bin.lateral]).collect::<Vec<f64>>())?;
        let rows = self.bins.centers().zip(pressures.chunks_exact(2));
        Ok(rows
            .map(|(height, pair)| ChainPressurePoint { height, normal: pair[0], lateral: pair[1] })
            .collect())
    }

    /// Values of any `function` of the pressures of all bins, with errors by the jackknife over
    /// blocks: for example means over groups of bins, or fits. `function` gets the bins upwards and
    /// must always return the same number of values.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] for fewer than 16 frames.
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
                // 0/0 in a bin that is not accessible.
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
        self.run.pool(&mut self.averages, &other.run, &other.averages)?;
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
            // The length of a chain that ended with an error is not recorded, so its collisions are
            // dropped.
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
