//! Number density from counts and from the balance of forces.

use super::bins::{Bins, HeightBins};
use super::one_run::OneRun;
use super::pressure::weigh_column;
use super::{DensityPoint, packing_fraction};
use crate::statistics::{BlockAverages, Estimate, share_of_first};
use crate::{Collision, Error, Frame, Merge, Observer, ObserverError, Recorder, Slab};

/// Number density n(x) in bins of equal height, in inverse cubic diameters, from counts and forces.
/// For event chains it has less noise than [`DensityProfile`](super::DensityProfile) of the same
/// run.
///
/// Besides the counts, each bin has a second estimate from the balance of forces ("force sampling",
/// doi:10.1103/PhysRevLett.120.120603). The normal pressure over T is the sum of the reduced forces
/// on the spheres above, per area. The collisions of vertical chains give its excess part; the rest
/// is the ideal part n:
///
/// n = `p_end` + (1/A) Σ u′(xᵢ) − N/(A w ℓ) Σ s q,
///
/// with the symbols of [`ChainPressureProfile`](super::ChainPressureProfile). `p_end`, at the open
/// end of the column, is 0 if no sphere comes within a diameter of that wall, and the mean
/// difference between the two estimates otherwise. In narrow bins counts are noisier than forces.
/// The two estimates are combined in each bin with the weights of the smallest variance. Forces are
/// used in bins that are completely accessible to centers; in other bins, and without chains, only
/// counts are used.
///
/// As every estimate from forces, it assumes a stationary column.
///
/// ```
/// use gradient_mc::observers::{BalancedDensityProfile, Bins};
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// let slab = Slab::new(60.0, 6.0, 6.0)?;
/// let scene = Scene::new(slab, 360, UniformField::default(), Isothermal::new(5.0)?)?;
/// let mut simulation = Simulation::builder(scene).seed(1).build()?;
/// let mut profile = BalancedDensityProfile::new(&slab, Bins::of_width(0.1).from(0.5).to(8.5))?;
/// simulation.equilibrate(200, &mut ())?;
/// simulation.run(400, &mut profile)?;
/// println!("{}", profile.points()?[0].number_density);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct BalancedDensityProfile {
    run: OneRun,
    bins: HeightBins,
    /// Current interval: Σ s q of vertical chains in all bins, and their path.
    collisions: Vec<f64>,
    path: f64,
    particles: f64,
    incomplete: u64,
    weights: Vec<f64>,
    /// Scratch for one sample: numbers in bins, weights over T on bins, Σ s q in bins; path, and
    /// spheres at the open end.
    sample: Vec<f64>,
    averages: BlockAverages,
}

impl BalancedDensityProfile {
    /// Makes an empty profile with `bins` over the heights of `slab`.
    ///
    /// # Errors
    /// Those of [`Bins`].
    pub fn new(slab: &Slab, bins: Bins) -> Result<Self, Error> {
        let bins = bins.of(slab)?;
        let count = bins.count();
        Ok(Self {
            run: OneRun::in_slab(slab),
            bins,
            collisions: vec![0.0; count],
            path: 0.0,
            particles: 0.0,
            incomplete: 0,
            weights: vec![0.0; count],
            sample: vec![0.0; 3 * count + 2],
            averages: BlockAverages::new(3 * count + 2)?,
        })
    }

    /// Number of frames observed.
    #[must_use]
    pub fn observations(&self) -> u64 {
        self.averages.observations()
    }

    /// The profile, from the lowest bin upwards.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] for fewer than 16 frames.
    pub fn points(&self) -> Result<Vec<DensityPoint>, Error> {
        let count = self.bins.count();
        let both = self.averages.jackknifed(|means| {
            let [counted, balanced] = self.densities(means);
            [counted, balanced].concat()
        })?;
        let known = both.estimates(<[f64]>::to_vec);
        let differences = both.estimates(|densities| {
            let (counted, balanced) = densities.split_at(count);
            counted.iter().zip(balanced).map(|(one, other)| one - other).collect::<Vec<f64>>()
        });
        let square = |estimate: &Estimate| estimate.standard_error * estimate.standard_error;
        // Variances are averaged over neighboring bins, because that of a single bin is noisy.
        let around = |estimates: &[Estimate], bin: usize| {
            let neighbors = &estimates[bin.saturating_sub(2)..(bin + 3).min(count)];
            neighbors.iter().map(square).filter(|square| square.is_finite()).sum::<f64>()
        };
        let shares: Vec<f64> = (0..count)
            .map(|bin| {
                let (counted, balanced) = known.split_at(count);
                if !balanced[bin].standard_error.is_finite() {
                    return 0.0;
                }
                let [c, b, d] = [counted, balanced, &differences[..]].map(|estimates| around(estimates, bin));
                let share = share_of_first(b, c, d);
                if share.is_nan() { 0.0 } else { share }
            })
            .collect();
        let densities = both.estimates(|densities| {
            let (counted, balanced) = densities.split_at(count);
            let rows = counted.iter().zip(balanced).zip(&shares);
            rows.map(
                |((counted, balanced), &share)| {
                    if share > 0.0 { counted + share * (balanced - counted) } else { *counted }
                },
            )
            .collect::<Vec<f64>>()
        });
        let rows = self.bins.centers().zip(densities);
        Ok(rows
            .map(|(height, number_density)| DensityPoint {
                height,
                number_density,
                packing_fraction: packing_fraction(number_density),
            })
            .collect())
    }

    /// Densities of all bins from counts and from forces; NaN where forces give no estimate.
    fn densities(&self, means: &[f64]) -> [Vec<f64>; 2] {
        let count = self.bins.count();
        let (counts, rest) = means.split_at(count);
        let (weights, rest) = rest.split_at(count);
        let (transfers, rest) = rest.split_at(count);
        let (path, at_end) = (rest[0], rest[1]);
        let volume = self.bins.volume();
        let counted: Vec<f64> = counts.iter().map(|count| count / volume).collect();
        let mut balanced: Vec<f64> = (0..count)
            .map(|bin| {
                let whole = self.bins.accessible_volume(bin) > (1.0 - 1e-9) * volume;
                let collided = self.particles * transfers[bin] / (volume * path);
                if whole { weights[bin] / self.bins.base_area() - collided } else { f64::NAN }
            })
            .collect();
        if at_end > 0.0 {
            let rows = counted.iter().zip(&balanced).filter(|(_, balanced)| balanced.is_finite());
            let differences: Vec<f64> = rows.map(|(counted, balanced)| counted - balanced).collect();
            let end = crate::statistics::mean(&differences);
            for balanced in &mut balanced {
                *balanced += end;
            }
        }
        [counted, balanced]
    }
}

impl Merge for BalancedDensityProfile {
    fn merge(&mut self, other: &Self) -> Result<(), Error> {
        self.bins.require_same(&other.bins)?;
        self.run.pool(&mut self.averages, &other.run, &other.averages)?;
        self.particles = self.particles.max(other.particles);
        Ok(())
    }
}

impl Observer for BalancedDensityProfile {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.run.admit(frame)?;
        self.particles = frame.particles() as f64;
        let incomplete = frame.move_counts().incomplete_sweeps;
        if std::mem::replace(&mut self.incomplete, incomplete) != incomplete {
            // The length of a chain that ended with an error is not recorded, so its collisions are
            // dropped.
            self.collisions.fill(0.0);
            self.path = 0.0;
        }
        let count = self.bins.count();
        let (counts, rest) = self.sample.split_at_mut(count);
        let (weights, rest) = rest.split_at_mut(count);
        counts.fill(0.0);
        let weight = |height: f64| frame.reduced_force(height);
        weigh_column(frame, &self.bins, weight, &mut self.weights, weights, |bin| counts[bin] += 1.0);
        rest[..count].copy_from_slice(&self.collisions);
        let contact = frame.scene().open_end().contact_height(frame.slab());
        let at_end = frame.heights().filter(|height| (height - contact).abs() < 1.0).count();
        (rest[count], rest[count + 1]) = (self.path, at_end as f64);
        self.averages.push(&self.sample)?;
        self.collisions.fill(0.0);
        self.path = 0.0;
        Ok(())
    }

    fn recorder(&mut self) -> Option<&mut dyn Recorder> {
        Some(self)
    }
}

impl Recorder for BalancedDensityProfile {
    fn record_collision(&mut self, collision: &Collision) {
        if collision.axis == 0 {
            let low = collision.from_height.min(collision.to_height);
            let high = collision.from_height.max(collision.to_height);
            let sums = &mut self.collisions;
            self.bins.spread(low, high, |bin, part| sums[bin] += collision.separation * part);
        }
    }

    fn record_chain(&mut self, axis: usize, length: f64) {
        if axis == 0 {
            self.path += length;
        }
    }

    fn wants_local_moves(&mut self) -> bool {
        false
    }
}

persist!(
    BalancedDensityProfile {
        part run,
        same bins,
        slice collisions,
        value path,
        value particles,
        count incomplete,
        part averages,
    }
);

#[cfg(test)]
mod tests {
    use super::super::DensityProfile;
    use super::*;
    use crate::field::{LinearField, UniformField};
    use crate::temperature::Isothermal;
    use crate::{Field, Scene, Simulation};

    /// Mean square of (difference of the two profiles)/(error of that), and of the ratio of their
    /// errors.
    fn compare(field: impl Field + Clone, height: f64, bins: Bins) -> [f64; 2] {
        let slab = Slab::new(height, 4.0, 4.0).unwrap();
        let scene = Scene::new(slab, 120, field, Isothermal::new(4.0).unwrap()).unwrap();
        let profiles: Vec<_> = (0..4)
            .map(|seed| {
                let mut simulation = Simulation::builder(scene.clone()).seed(seed).build().unwrap();
                simulation.equilibrate(300, &mut ()).unwrap();
                let (balanced, counted) =
                    (BalancedDensityProfile::new(&slab, bins), DensityProfile::new(&slab, bins));
                let mut both = (balanced.unwrap(), counted.unwrap());
                simulation.run(2000, &mut both).unwrap();
                both
            })
            .collect();
        let (balanced, counted) = Merge::pooled(&profiles).unwrap();
        assert_eq!(balanced.observations(), counted.observations());
        let rows = balanced.points().unwrap().into_iter().zip(counted.points().unwrap());
        let (mut sums, mut number) = ([0.0; 2], 0.0);
        for (balanced, counted) in rows.filter(|(_, counted)| counted.number_density.mean > 0.02) {
            let [one, other] = [balanced.number_density, counted.number_density];
            let ratio = one.standard_error / other.standard_error;
            // The variance of the difference between an optimal mean and one of its parts is the
            // difference of their variances.
            let variance = other.standard_error * other.standard_error * (1.0 - ratio * ratio).max(0.05);
            sums[0] += (one.mean - other.mean) * (one.mean - other.mean) / variance;
            sums[1] += ratio;
            number += 1.0;
        }
        sums.map(|sum| sum / number)
    }

    #[test]
    fn forces_and_counts_agree_and_both_know_more() {
        for (field, height, bins, largest) in [
            // Open at the top, and with a lid; wide bins and narrow ones.
            (LinearField::new(1.0, 0.0).unwrap(), 60.0, Bins::of_width(0.5).from(0.5).to(20.5), 0.9),
            (LinearField::new(1.0, 0.0).unwrap(), 60.0, Bins::of_width(0.05).from(0.5).to(3.5), 0.5),
            (LinearField::new(0.3, 0.05).unwrap(), 15.0, Bins::of_width(0.1).from(0.5).to(14.5), 0.65),
        ] {
            let [square, ratio] = compare(field, height, bins);
            assert!((0.3..2.5).contains(&square), "{height}: {square}, {ratio}");
            assert!(ratio < largest, "{height}: {square}, {ratio}");
        }
        // A box without a field.
        let [square, ratio] =
            compare(UniformField::new(0.0).unwrap(), 12.0, Bins::of_width(0.1).from(0.5).to(11.5));
        assert!((0.3..2.5).contains(&square) && ratio < 1.05, "{square}, {ratio}");
    }
}
