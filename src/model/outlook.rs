//! What a model will be off by, and what it will cost, before it is run.
//!
//! All constants are fitted to runs of columns ([`constants`](super::constants)); how is said in `docs/models.md`.

use super::constants::{
    ALLOWANCE, BULK, FINITE_BASE, HEAD_START, IDEAL_COST, INEFFICIENCY, LAYERS, LAYERS_SCATTER,
    PLAN_ALLOWANCE, SEED_SCATTER, START_COST, SWEEP_COST, THEORY_COST,
};
use super::ideal_column::IdealColumn;
use super::plan::{MonteCarloPlan, MoveFamily};
use super::planned_drive::constant_temperature;
use super::total_variation::{densities, total_variation_distance};
use crate::equation_of_state::{FREEZING, FluidSolid, ModifiedKolafa};
use crate::hydrostatics::DomainExit;
use crate::{Error, Field, HydrostaticProfile, Scene, TemperatureProfile};

/// Spheres per area of a wall that the theory between walls puts into the wrong bin, as a function of the packing fraction at the wall.
///
/// To leading order it is 0.42 η², from the density of a dilute gas at a wall (n(z)/n − 1 = 2η(1 − z)²(2 + z)); the rest is fitted to columns. It
/// is |B(η)| with what the fit misses added in quadrature, since B changes its sign near η = 0.08.
pub(super) fn layering(packing_fraction: f64) -> f64 {
    let eta = packing_fraction;
    let polynomial = LAYERS.iter().rev().fold(0.0, |sum, coefficient| sum * eta + coefficient);
    eta * eta * polynomial.hypot(LAYERS_SCATTER)
}

/// Total variation distance of an average over `samples` independent spheres: ½ Σ |δp| with binomial δp, ½ √(2/π) Σ √(p(1 − p)/samples).
pub(super) fn counting_noise(spread: f64, samples: f64) -> f64 {
    0.5 * std::f64::consts::FRAC_2_PI.sqrt() * spread / samples.sqrt()
}

/// What is known of a scene without a simulation.
#[derive(Debug, Clone)]
pub(super) struct Outlook {
    pub(super) ideal: IdealColumn,
    pub(super) theory: HydrostaticProfile,
    /// Where the column freezes; then the theory is that of fluid and solid.
    pub(super) freezing: Option<DomainExit>,
    pub(super) column_density: f64,
    pub(super) height: f64,
    pub(super) isothermal: bool,
    /// Total variation distance of the ideal gas if the theory were true.
    pub(super) excluded_volume: f64,
    /// Packing fractions at base and lid.
    pub(super) walls: [f64; 2],
    /// Σ √(p(1 − p)) over the bins.
    pub(super) spread: f64,
    /// Largest |d ln n/dx| where the column is, and its height.
    pub(super) steepest: (f64, f64),
}

impl Outlook {
    pub(super) fn new<F: Field, T: TemperatureProfile>(scene: &Scene<F, T>) -> Result<Self, Error> {
        let slab = scene.slab();
        let column_density = scene.column_density();
        let ideal = IdealColumn::new(scene)?;
        let fluid = scene.hydrostatics(&ModifiedKolafa);
        let (theory, freezing) = match fluid {
            Ok(profile) if profile.domain_exit().is_none() => (profile, None),
            // No fluid carries the weight, or one that would freeze.
            fluid => {
                let exit = fluid.ok().and_then(|profile| profile.domain_exit());
                let both = scene.hydrostatics(&FluidSolid::default())?;
                let exit = exit.or_else(|| frozen_part(&both));
                (both, exit)
            }
        };
        let ideal_densities = densities(slab, |height| ideal.column_below(height));
        let theory_densities = densities(slab, |height| theory.column_below(height));
        let spread = theory_densities
            .iter()
            .map(|density| {
                let part = density / column_density;
                (part * (1.0 - part)).max(0.0).sqrt()
            })
            .sum();
        Ok(Self {
            excluded_volume: total_variation_distance(&ideal_densities, &theory_densities),
            walls: [theory.base_packing_fraction(), theory.packing_fraction(theory.top())],
            steepest: steepest(&theory),
            ideal,
            theory,
            freezing,
            column_density,
            height: slab.height(),
            isothermal: constant_temperature(scene).is_some(),
            spread,
        })
    }

    /// Total variation distance by the layers at base and lid.
    pub(super) fn layers(&self) -> [f64; 2] {
        self.walls.map(|eta| layering(eta) / self.column_density)
    }

    /// Total variation distance of the theory.
    pub(super) fn theory_error(&self) -> f64 {
        let [base, lid] = self.layers();
        (base + lid).hypot(self.bulk())
    }

    /// Total variation distance by equation of state and gradients; a gas without excluded volume has none.
    pub(super) fn bulk(&self) -> f64 {
        BULK * self.excluded_volume
    }

    /// Total variation distance of the ideal gas.
    pub(super) fn ideal_error(&self) -> f64 {
        self.excluded_volume.hypot(self.theory_error())
    }

    /// What an error that is expected may become.
    pub(super) fn allowance() -> f64 {
        ALLOWANCE
    }

    /// What the noise of a single run may become: the expected root mean square may be as much too small as the fit has scatter, and a seed
    /// two standard deviations worse than others.
    pub(super) fn plan_allowance(family: MoveFamily) -> f64 {
        PLAN_ALLOWANCE[index(family)] * (1.0 + 2.0 * SEED_SCATTER[index(family)])
    }

    pub(super) fn ideal_cost(&self) -> f64 {
        power_law(IDEAL_COST, self.height)
    }

    pub(super) fn theory_cost(&self) -> f64 {
        power_law(THEORY_COST, self.height)
    }

    /// Total variation distance that a base with `particles` spheres adds: of the pairs that make excluded volume, 1/N are missing.
    pub(super) fn finite_base(&self, particles: usize) -> f64 {
        FINITE_BASE * self.excluded_volume / particles as f64
    }

    /// Fewest spheres whose base adds no more than `error`.
    pub(super) fn particles_for(&self, error: f64) -> f64 {
        FINITE_BASE * self.excluded_volume / error
    }

    /// Variance of a run in units of that of as many independent spheres.
    fn inefficiency(&self, family: MoveFamily) -> f64 {
        let [constant, with_packing, with_extent, varying] = INEFFICIENCY[index(family)];
        let extent = self.theory.center_of_mass() - self.theory.base();
        let varying = if self.isothermal { 0.0 } else { varying };
        libm::exp(constant + with_packing * self.densest() + with_extent * libm::log(extent) + varying)
    }

    fn densest(&self) -> f64 {
        crate::equation_of_state::packing_fraction(self.theory.density_maximum().1)
    }

    /// Statistical total variation distance of a run; the theory, at which it starts, counts for some sweeps.
    pub(super) fn noise(&self, particles: usize, family: MoveFamily, sweeps: f64) -> f64 {
        let counted = (1.0 - MonteCarloPlan::EQUILIBRATION) * (sweeps + HEAD_START[index(family)]);
        counting_noise(self.spread, counted * particles as f64 / self.inefficiency(family))
    }

    /// Sweeps for a statistical total variation distance; zero or less where the start would be enough.
    pub(super) fn sweeps_for(&self, particles: usize, family: MoveFamily, error: f64) -> f64 {
        let unit = self.noise(particles, family, 1.0) / error;
        let head_start = HEAD_START[index(family)];
        unit * unit * (1.0 + head_start) - head_start
    }

    /// CPU seconds of a run.
    pub(super) fn plan_cost(&self, particles: usize, family: MoveFamily, sweeps: f64) -> f64 {
        let [dilute, slope] = SWEEP_COST[index(family)];
        let start = START_COST[usize::from(!self.isothermal)] * self.theory_cost();
        // Nothing was measured beyond freezing, and the straight lines end there.
        let densest = self.densest().min(FREEZING);
        start + particles as f64 * sweeps * (dilute + slope * densest)
    }
}

/// Position of a family in the constants.
fn index(family: MoveFamily) -> usize {
    match family {
        MoveFamily::TunedLocal => 0,
        MoveFamily::Chains => 1,
    }
}

fn power_law([factor, power]: [f64; 2], value: f64) -> f64 {
    factor * libm::pow(value, power)
}

/// The part of a profile of fluid and solid that is denser than the fluid can be.
fn frozen_part(profile: &HydrostaticProfile) -> Option<DomainExit> {
    use crate::equation_of_state::{DomainSide, packing_fraction};
    const SAMPLES: u32 = 4096;
    let extent = profile.top() - profile.base();
    let heights =
        (0..=SAMPLES).map(|sample| profile.base() + extent * f64::from(sample) / f64::from(SAMPLES));
    let mut dense = heights.filter(|&height| profile.packing_fraction(height) > FREEZING + 1e-3);
    let lowest_height = dense.next()?;
    let highest_height = dense.next_back().unwrap_or(lowest_height);
    let packing_fraction = packing_fraction(profile.density_maximum().1);
    Some(DomainExit {
        lowest_height,
        highest_height,
        packing_fraction,
        limit: FREEZING,
        side: DomainSide::Above,
    })
}

/// Largest |d ln n/dx| among the quantiles of a column, and its height.
fn steepest(profile: &HydrostaticProfile) -> (f64, f64) {
    const QUANTILES: u32 = 64;
    const STEP: f64 = 0.01;
    let mut steepest = (0.0, profile.base());
    for quantile in 0..QUANTILES {
        let height = profile.height_of_fraction((f64::from(quantile) + 0.5) / f64::from(QUANTILES));
        let (low, high) = ((height - STEP).max(profile.base()), (height + STEP).min(profile.top()));
        let change = libm::log(profile.number_density(high) / profile.number_density(low)) / (high - low);
        if change.is_finite() && change.abs() > steepest.0 {
            steepest = (change.abs(), height);
        }
    }
    steepest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::UniformField;
    use crate::random::unit;
    use crate::temperature::Isothermal;
    use crate::{Generator, Slab};
    use rand::SeedableRng;

    fn outlook(temperature: f64, column_density: f64) -> Outlook {
        // 400 spheres.
        let side = (400.0 / column_density).sqrt();
        let slab = Slab::new(40.0, side, side).unwrap();
        let scene =
            Scene::new(slab, 400, UniformField::default(), Isothermal::new(temperature).unwrap()).unwrap();
        Outlook::new(&scene).unwrap()
    }

    /// Points drawn from a known distribution are misplaced as the formula says.
    #[test]
    fn counting_noise_is_that_of_independent_points() {
        const SAMPLES: usize = 400;
        const REPEATS: usize = 400;
        let parts = [0.4, 0.25, 0.15, 0.1, 0.06, 0.04];
        let spread: f64 = parts.iter().map(|part| f64::sqrt(part * (1.0 - part))).sum();
        let mut generator = Generator::seed_from_u64(5);
        let errors: Vec<f64> = (0..REPEATS)
            .map(|_| {
                let mut counts = [0.0; 6];
                for _ in 0..SAMPLES {
                    let mut left = unit(&mut generator);
                    let bin = parts.iter().position(|part| {
                        left -= part;
                        left < 0.0
                    });
                    counts[bin.unwrap_or(5)] += 1.0;
                }
                total_variation_distance(&counts, &parts.map(|part| part * SAMPLES as f64))
            })
            .collect();
        let mean = errors.iter().sum::<f64>() / REPEATS as f64;
        let variance =
            errors.iter().map(|error| (error - mean) * (error - mean)).sum::<f64>() / REPEATS as f64;
        let error = (variance / REPEATS as f64).sqrt();
        let expected = counting_noise(spread, SAMPLES as f64);
        assert!(error < 0.02 * expected);
        // Counts of so few spheres are not quite Gaussian.
        assert!(
            (mean - expected).abs() < 4.0 * error + 0.01 * expected,
            "{mean} instead of {expected} ± {error}"
        );
    }

    #[test]
    fn sweeps_are_those_that_reach_the_noise() {
        let outlook = outlook(3.0, 2.0);
        for family in MoveFamily::ALL {
            for error in [0.1, 0.01, 0.001] {
                let sweeps = outlook.sweeps_for(100, family, error);
                approx::assert_relative_eq!(outlook.noise(100, family, sweeps), error, max_relative = 1e-12);
            }
        }
    }

    /// The density of a dilute gas at a wall is known, and so is what the theory makes of it; by quadrature, not by the algebra that
    /// gave the coefficient.
    #[test]
    fn layers_of_a_dilute_gas_are_exact() {
        // Steps of the quadrature over half a diameter.
        const STEPS: u32 = 20_000;
        let eta = 1e-4;
        let number_density = crate::equation_of_state::number_density(eta);
        // Surplus over the bulk in the lowest bin, which centers enter at x = ½.
        let surplus: f64 = (0..STEPS)
            .map(|step| {
                let gap = 0.5 * (f64::from(step) + 0.5) / f64::from(STEPS);
                2.0 * eta * (1.0 - gap) * (1.0 - gap) * (2.0 + gap) * 0.5 / f64::from(STEPS)
            })
            .sum();
        let begins = (1.0 - eta) / (2.0 * (1.0 + 2.0 * eta));
        let misplaced = number_density * (1.0 - begins) - number_density * (0.5 + surplus);
        approx::assert_relative_eq!(misplaced, LAYERS[0] * eta * eta, max_relative = 2e-3);
    }

    #[test]
    fn dilute_columns_have_small_errors_and_dense_ones_freeze() {
        let (dilute, dense, frozen) = (outlook(20.0, 0.1), outlook(2.0, 10.0), outlook(1.0, 20.0));
        assert!(dilute.ideal_error() < 0.02 && dilute.theory_error() < 1e-3);
        assert!(dense.ideal_error() > 0.3 && dense.freezing.is_none());
        let exit = frozen.freezing.unwrap();
        assert!(
            exit.lowest_height < 1.0 && exit.highest_height > 5.0 && exit.highest_height < 15.0,
            "{exit:?}"
        );
    }
}
