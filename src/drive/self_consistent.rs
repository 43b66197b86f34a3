//! The effective field averaged while equilibrating, then frozen for production.

use super::effective_potential::{EffectivePotential, Histogram, Mapping};
use super::equation_of_state_closure::theory_ratios;
use super::{Drive, Phase, Scheme};
use crate::equation_of_state::{EquationOfState, FluidSolid, packing_fraction};
use crate::{Centers, Error, Field, Scene, TemperatureProfile};

/// The effective field from the measured density, averaged over the later part of the equilibration
/// and frozen when production starts. The default choice for temperatures that vary.
///
/// Production holds detailed balance exactly, in the field that was frozen. What it rests on is that
/// the equilibration was long compared with the relaxation of the column: verify that P/T of the
/// production run matches the frozen field, and start from both sides.
///
/// - Counts and weights are averaged, never ratios of single configurations, so there is no noise
///   bias of order 1/(spheres per bin and sweep).
/// - The average runs over a window between the last half and the last three quarters of the
///   equilibration so far: a start is forgotten as fast as a power of the length allows, with no gain
///   to tune.
/// - While the column is still far from mechanical balance, the theory's field takes the place of the measured
///   one: a column that falls or rises would otherwise be held where it is by the field that its own
///   weight makes. Balance is judged by ∫P dx from the weights against ∫nTZ dx, to 10 %;
///   [`SelfConsistentDrive::follows_measurement`] tells.
/// - The theory profile stands in with the weight of [`PRIOR_SPHERES`](SelfConsistent::PRIOR_SPHERES) counted spheres
///   per bin: the layers of a lattice start, whose gaps would get an enormous P/n, and a top that few spheres
///   visit do no harm, and a bin of five spheres owes a thousandth to it after 200 000 configurations. The
///   part that is owed is multiplied by what the equation of state misses, some 0.1 %.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SelfConsistent {
    bin_width: f64,
    update_interval: u64,
}

impl Default for SelfConsistent {
    /// Bins of 0.1 diameters, updated every 10 sweeps.
    fn default() -> Self {
        Self { bin_width: 0.1, update_interval: 10 }
    }
}

impl SelfConsistent {
    /// Counted spheres per bin that the theory profile stands for. With a single one a column of
    /// 4000 spheres was seen to drive its top away: P/n of a bin that is empty by chance pushes spheres up.
    pub const PRIOR_SPHERES: f64 = 1000.0;

    /// Bins of the given width, in diameters.
    #[must_use]
    pub fn bin_width(self, bin_width: f64) -> Self {
        Self { bin_width, ..self }
    }

    /// Sweeps between two updates of the field; zero counts as one.
    #[must_use]
    pub fn update_interval(self, sweeps: u64) -> Self {
        Self { update_interval: sweeps.max(1), ..self }
    }
}

/// The drive of [`SelfConsistent`].
#[derive(Debug, Clone)]
pub struct SelfConsistentDrive {
    potential: EffectivePotential,
    generation: u64,
    mapping: Mapping,
    /// P/n of the theory profile.
    prior: Vec<f64>,
    follows_measurement: bool,
    /// The window: everything since the last power of two but one.
    older: Histogram,
    newer: Histogram,
    sweeps: u64,
    next_window: u64,
    update_interval: u64,
}

impl<F: Field, T: TemperatureProfile> Scheme<F, T> for SelfConsistent {
    type Drive = SelfConsistentDrive;

    fn drive(self, scene: &Scene<F, T>) -> Result<SelfConsistentDrive, Error> {
        let mapping = Mapping::new(scene, self.bin_width)?;
        let prior = theory_ratios(scene, &mapping, &FluidSolid::default())?;
        let potential = mapping.potential(|bin| prior[bin]);
        mapping.check(&potential)?;
        let histogram = Histogram::new(mapping.bins());
        Ok(SelfConsistentDrive {
            potential,
            generation: 0,
            mapping,
            prior,
            follows_measurement: false,
            older: histogram.clone(),
            newer: histogram,
            sweeps: 0,
            next_window: 2,
            update_interval: self.update_interval,
        })
    }
}

impl SelfConsistentDrive {
    /// Number of configurations in the average that makes the field.
    #[must_use]
    pub fn averaged_configurations(&self) -> u64 {
        self.older.configurations() + self.newer.configurations()
    }

    /// Whether the field in force was measured; until the column is near balance, it is the theory's.
    #[must_use]
    pub fn follows_measurement(&self) -> bool {
        self.follows_measurement
    }

    /// Whether the weights and the equation of state agree on ∫P dx to 10 %.
    fn near_balance<F, T: TemperatureProfile>(
        &self,
        scene: &Scene<F, T>,
        window: &Histogram,
        rows: &[[f64; 2]],
    ) -> bool {
        const TOLERANCE: f64 = 0.1;
        /// Densities are smoothed over this many diameters, more than a layer at the wall.
        const SMOOTHING: f64 = 2.0;
        /// Above this no equation of state makes sense, and the column is surely not balanced.
        const DENSEST: f64 = 0.72;
        let equation_of_state = FluidSolid::default();
        let width = self.mapping.width();
        // At least one bin, at most all.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let group = ((SMOOTHING / width).ceil() as usize).clamp(1, rows.len());
        let volume = scene.slab().base_area() * width * window.configurations() as f64;
        let (mut weights, mut theory) = (0.0, 0.0);
        for (index, rows) in rows.chunks(group).enumerate() {
            let count: f64 = rows.iter().map(|row| row[0]).sum();
            let eta = packing_fraction(count / (volume * rows.len() as f64)).min(DENSEST);
            let height = (index * group) as f64 * width + 0.5 * width * rows.len() as f64;
            let temperature = scene.temperature().temperature(height);
            theory += count * temperature * equation_of_state.compressibility_factor(eta);
            weights += rows.iter().map(|row| row[1]).sum::<f64>();
        }
        (weights / theory - 1.0).abs() < TOLERANCE
    }

    fn update<F: Field, T: TemperatureProfile>(&mut self, scene: &Scene<F, T>) -> Result<(), Error> {
        if self.averaged_configurations() == 0 {
            return Ok(());
        }
        let mut window = self.older.clone();
        window.absorb(&self.newer);
        let lid = window.lid_pressure(&self.mapping, scene, 1.0);
        let rows = window.counts_and_pressures(&self.mapping, scene.slab().base_area(), lid);
        self.follows_measurement = self.near_balance(scene, &window, &rows);
        let (prior, measured) = (&self.prior, self.follows_measurement);
        self.mapping.update(&mut self.potential, |bin| {
            let [count, pressure] = rows[bin];
            if measured {
                (pressure + SelfConsistent::PRIOR_SPHERES * prior[bin])
                    / (count + SelfConsistent::PRIOR_SPHERES)
            } else {
                prior[bin]
            }
        });
        self.generation += 1;
        self.mapping.check(&self.potential)
    }
}

impl<F: Field, T: TemperatureProfile> Drive<F, T> for SelfConsistentDrive {
    #[inline]
    fn reduced_potential(&self, scene: &Scene<F, T>, height: f64) -> f64 {
        self.potential.reduced_potential(scene, height)
    }

    #[inline]
    fn reduced_force(&self, scene: &Scene<F, T>, height: f64) -> f64 {
        self.potential.reduced_force(scene, height)
    }

    #[inline]
    fn generation(&self) -> u64 {
        self.generation
    }

    fn after_sweep(&mut self, scene: &Scene<F, T>, centers: Centers<'_>, phase: Phase) -> Result<(), Error> {
        if phase == Phase::Production {
            return Ok(());
        }
        self.sweeps += 1;
        if self.sweeps == self.next_window {
            self.next_window *= 2;
            std::mem::swap(&mut self.older, &mut self.newer);
            self.newer.clear();
        }
        self.newer.add(&self.mapping, scene, centers);
        if self.sweeps.is_multiple_of(self.update_interval) { self.update(scene) } else { Ok(()) }
    }

    fn start_production(&mut self, scene: &Scene<F, T>) -> Result<(), Error> {
        self.update(scene)
    }
}
