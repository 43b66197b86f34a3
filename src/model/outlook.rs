//! Expected errors of the models, without running them.
//!
//! All constants are fitted to runs of columns ([`constants`](super::constants)), as
//! `docs/models.md` describes.

use super::accuracy::{Accuracy, Quantity, densities, height};
use super::constants::{
    ADSORPTION, ALLOWANCE, BULK, FINITE_BASE, FUNCTIONAL, FUNCTIONAL_ADSORPTION, FUNCTIONAL_ALLOWANCE,
    FUNCTIONAL_SHAPE, LAYERS, LAYERS_SCATTER, LAYERS_SHAPE, MOVES, NOISE, Noise,
};
use super::plan::{MonteCarloPlan, MoveFamily};
use crate::diagnostics::LEAST_LAYER;
use crate::equation_of_state::{FREEZING, FluidSolid, IdealGas, ModifiedKolafa};
use crate::hydrostatics::DomainExit;
use crate::{Error, Field, HydrostaticProfile, Hydrostatics, Scene, TemperatureProfile, Wall, temperature};

/// Spheres per area of a wall that the theory between walls puts into the wrong bin, by the packing
/// fraction at the wall.
///
/// To leading order it is 0.42 η², from the density of a dilute gas at a wall, n(z)/n − 1 = 2η(1 −
/// z)²(2 + z). The rest is fitted to columns. The scatter of the fit is added to |B(η)| in
/// quadrature, since B changes its sign near η = 0.08.
fn layering(packing_fraction: f64) -> f64 {
    let eta = packing_fraction;
    let polynomial = LAYERS.iter().rev().fold(0.0, |sum, coefficient| sum * eta + coefficient);
    eta * eta * polynomial.hypot(LAYERS_SCATTER)
}

/// The same for a density functional, with the resolution of the runs at low packing fractions in
/// quadrature.
fn functional_layering(packing_fraction: f64) -> f64 {
    let [dense, unresolved] = FUNCTIONAL;
    let square = packing_fraction * packing_fraction;
    square * (dense * square * square).hypot(unresolved)
}

/// Shift of the column above the layers in the theory, in diameters, by the packing fraction at the
/// wall.
fn rise(eta: f64) -> f64 {
    ADSORPTION * eta
}

/// The same for a density functional.
fn functional_rise(eta: f64) -> f64 {
    let [dense, unresolved] = FUNCTIONAL_ADSORPTION;
    let cube = eta * eta * eta;
    (dense * cube * cube).hypot(unresolved * eta)
}

/// Expected errors of all models of a scene, for one accuracy.
#[derive(Debug, Clone)]
pub(super) struct Outlook {
    pub(super) ideal: HydrostaticProfile,
    pub(super) theory: HydrostaticProfile,
    /// The part of the column that freezes, if any. The theory is then that of fluid and solid.
    pub(super) freezing: Option<DomainExit>,
    pub(super) column_density: f64,
    quantity: Quantity,
    isothermal: bool,
    /// Error of the ideal gas relative to the theory.
    pub(super) excluded_volume: f64,
    /// Errors of the theory: from the layers at the walls, and from equation of state and local
    /// density beyond them.
    pub(super) layers: f64,
    pub(super) bulk: f64,
    /// Error of a density functional in the layers at the walls.
    pub(super) functional_layers: f64,
    /// Errors of P and Z in theory and functional from the shift of the column above the layers,
    /// which hold a wrong number of spheres.
    pub(super) adsorption: [f64; 2],
    /// Error by a base with one sphere, extrapolated from small errors.
    finite_base: f64,
    /// Error of a single configuration of one sphere.
    spread: f64,
    /// Mean distance of the spheres from the wall on which the column rests.
    extent: f64,
    /// Pressure at the open end over that in the outermost bin that counts; 0 for n.
    pub(super) open_end: f64,
}

impl Outlook {
    pub(super) fn new<F: Field, T: TemperatureProfile>(
        scene: &Scene<F, T>,
        accuracy: &Accuracy,
    ) -> Result<Self, Error> {
        /// A share so small that errors are linear in it.
        const SMALL: f64 = 1e-3;
        let (slab, column_density) = (scene.slab(), scene.column_density());
        // Points, but between the lowest and the highest centers of spheres.
        let ideal = Hydrostatics::new(scene.field(), scene.temperature(), IdealGas)
            .base(slab.lowest_center())
            .lid(slab.highest_center())
            .column_density(column_density)?;
        let fluid = scene.hydrostatics(&ModifiedKolafa);
        let (theory, freezing) = match fluid {
            Ok(profile) if profile.domain_exit().is_none() => (profile, None),
            // The fluid does not carry the weight, or freezes.
            fluid => {
                let exit = fluid.ok().and_then(|profile| profile.domain_exit());
                let both = scene.hydrostatics(&FluidSolid::default())?;
                let exit = exit.or_else(|| frozen_part(&both));
                let freezes = |exit: &DomainExit| {
                    both.column_below(exit.highest_height) - both.column_below(exit.lowest_height)
                        >= LEAST_LAYER
                };
                let exit = exit.filter(freezes);
                (both, exit)
            }
        };
        let [points, spheres] = [&ideal, &theory].map(|profile| densities(scene, profile));
        let bins = accuracy.bins(scene, &spheres);
        // Relative errors of P and Z need spheres in every bin; far up the density may be zero to
        // rounding.
        let inside = &spheres[bins.clone()];
        let nothing = match accuracy.quantity() {
            Quantity::Density => inside.iter().all(|&density| density <= 0.0),
            _ => inside.is_empty() || inside.iter().any(|&density| density <= 0.0),
        };
        if nothing {
            let requirement = "the column must have spheres between the two heights";
            let (name, distance) = match scene.open_end() {
                Wall::Lid => ("highest height", bins.end),
                Wall::Base => ("lowest height", bins.end),
            };
            let value = height(scene, distance as f64);
            return Err(Error::InvalidParameter { name, value, requirement });
        }
        // Profiles between the two.
        let mixed = |part: f64| -> Vec<f64> {
            points.iter().zip(&spheres).map(|(point, sphere)| sphere + part * (point - sphere)).collect()
        };
        let ends = [
            (theory.base(), theory.base_packing_fraction(), theory.base_pressure()),
            (theory.top(), theory.packing_fraction(theory.top()), theory.lid_pressure()),
        ];
        let [resting, open] = match scene.open_end() {
            Wall::Lid => ends,
            Wall::Base => [ends[1], ends[0]],
        };
        let layered = |shape: [f64; 8], layering: fn(f64) -> f64| {
            let mut layered = spheres.clone();
            for (from_wall, part) in shape.iter().enumerate().take(layered.len()) {
                let [near, far] = [resting, open].map(|(_, eta, _)| 2.0 * layering(eta) * part);
                // Densities stay positive.
                for (bin, change) in [(from_wall, near), (layered.len() - 1 - from_wall, far)] {
                    layered[bin] = (layered[bin] + change).max(0.1 * spheres[bin]);
                }
            }
            layered
        };
        // The column, raised by a small share of a diameter.
        let risen: Vec<f64> = {
            let flow = |edge: usize| match edge {
                0 => 0.0,
                _ => theory.number_density(height(scene, edge as f64)),
            };
            let lifted = |(bin, sphere): (usize, &f64)| {
                (sphere + SMALL * (flow(bin) - flow(bin + 1))).max(0.1 * sphere)
            };
            spheres.iter().enumerate().map(lifted).collect()
        };
        let error = |profile: &[f64]| accuracy.error(scene, profile, &spheres);
        let outermost = height(scene, bins.end as f64 - 0.5).clamp(theory.base(), theory.top());
        let needs_weight = accuracy.quantity() != Quantity::Density;
        Ok(Self {
            quantity: accuracy.quantity(),
            isothermal: temperature::constant(scene.temperature(), slab).is_some(),
            excluded_volume: error(&points),
            layers: error(&layered(LAYERS_SHAPE, layering)),
            functional_layers: error(&layered(FUNCTIONAL_SHAPE, functional_layering)),
            adsorption: match accuracy.quantity() {
                // For n it is part of the error of the layers.
                Quantity::Density => [0.0; 2],
                _ => [rise, functional_rise].map(|rise| error(&risen) / SMALL * rise(resting.1)),
            },
            bulk: error(&mixed(BULK)),
            finite_base: error(&mixed(SMALL)) / SMALL * FINITE_BASE,
            spread: accuracy.noise(scene, &spheres, 1.0),
            extent: (theory.center_of_mass() - resting.0).abs(),
            open_end: if needs_weight { open.2 / theory.pressure(outermost) } else { 0.0 },
            ideal,
            theory,
            freezing,
            column_density,
        })
    }

    /// Error of the theory.
    pub(super) fn theory_error(&self) -> f64 {
        self.layers.hypot(self.bulk).hypot(self.adsorption[0])
    }

    /// Error of the density functional; beyond the layers that of the theory.
    pub(super) fn functional_error(&self) -> f64 {
        self.functional_layers.hypot(self.bulk).hypot(self.adsorption[1])
    }

    /// Factor by which this error may be larger.
    pub(super) fn functional_allowance(&self) -> f64 {
        FUNCTIONAL_ALLOWANCE[self.quantity as usize]
    }

    /// Error of the ideal gas.
    pub(super) fn ideal_error(&self) -> f64 {
        self.excluded_volume.hypot(self.theory_error())
    }

    /// Factor by which the error of ideal gas or theory may be larger.
    pub(super) fn allowance(&self) -> f64 {
        ALLOWANCE[self.quantity as usize]
    }

    /// Factor by which the noise of a single run may be larger: one scatter of the fit, and a seed
    /// two standard deviations above the root mean square.
    pub(super) fn plan_allowance(&self, family: MoveFamily) -> f64 {
        let Noise { scatter, seeds, .. } = self.constants(family);
        libm::exp(scatter) * (1.0 + 2.0 * seeds)
    }

    fn constants(&self, family: MoveFamily) -> Noise {
        NOISE[self.quantity as usize][family as usize]
    }

    /// Error by a base with N = `particles` spheres: 1/N of the pairs that make up excluded volume
    /// are missing.
    pub(super) fn finite_base(&self, particles: usize) -> f64 {
        self.finite_base / particles as f64
    }

    /// Fewest spheres whose base adds no more than `error`.
    pub(super) fn particles_for(&self, error: f64) -> f64 {
        self.finite_base / error
    }

    /// Variance of a run relative to that of as many independent spheres.
    fn inefficiency(&self, family: MoveFamily) -> f64 {
        let [constant, with_packing, with_extent, varying] = self.constants(family).inefficiency;
        let varying = if self.isothermal { 0.0 } else { varying };
        libm::exp(constant + with_packing * self.densest() + with_extent * libm::log(self.extent) + varying)
    }

    /// The largest packing fraction, at most that of freezing, where the calibration ends.
    fn densest(&self) -> f64 {
        crate::equation_of_state::packing_fraction(self.theory.density_maximum().1).min(FREEZING)
    }

    /// Statistical error of a run. The start at the theory profile counts as some additional
    /// sweeps.
    pub(super) fn noise(&self, particles: usize, family: MoveFamily, sweeps: f64) -> f64 {
        let counted = (1.0 - MonteCarloPlan::EQUILIBRATION) * (sweeps + self.constants(family).head_start);
        self.spread * (self.inefficiency(family) / (counted * particles as f64)).sqrt()
    }

    /// Sweeps that reach a statistical error; zero or less if the start is accurate enough.
    pub(super) fn sweeps_for(&self, particles: usize, family: MoveFamily, error: f64) -> f64 {
        let unit = self.noise(particles, family, 1.0) / error;
        let head_start = self.constants(family).head_start;
        unit * unit * (1.0 + head_start) - head_start
    }

    /// Trials and events of a run.
    pub(super) fn moves(&self, particles: usize, family: MoveFamily, sweeps: f64) -> f64 {
        let [dilute, slope] = MOVES[family as usize];
        particles as f64 * sweeps * (dilute + slope * self.densest())
    }
}

/// The part of a profile of fluid and solid that is denser than the fluid at freezing.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::LinearField;
    use crate::field::UniformField;
    use crate::random::unit;
    use crate::temperature::Isothermal;
    use crate::{Generator, Slab};
    use rand::SeedableRng;

    /// In the paper's steep field the density is zero to rounding in the upper half of the slab.
    #[test]
    fn a_slab_may_be_empty_far_up() {
        let slab = Slab::new(400.0, 5.0, 5.0).unwrap();
        let field = crate::field::ExponentialField::new(0.02).unwrap();
        let scene = Scene::new(slab, 1000, field, Isothermal::new(20.0).unwrap()).unwrap();
        for accuracy in [Accuracy::density(0.01), Accuracy::pressure(0.01)] {
            assert!(scene.model_for(accuracy.unwrap()).unwrap().is_adequate());
        }
        for accuracy in [Accuracy::density(0.01), Accuracy::compressibility_factor(0.01)] {
            let above = accuracy.unwrap().between(390.0, 399.0).unwrap();
            assert!(matches!(scene.model_for(above), Err(Error::InvalidParameter { .. })));
        }
    }

    fn outlook(temperature: f64, column_density: f64, accuracy: &Accuracy) -> Outlook {
        // 400 spheres.
        let side = (400.0 / column_density).sqrt();
        let slab = Slab::new(40.0, side, side).unwrap();
        let scene =
            Scene::new(slab, 400, UniformField::default(), Isothermal::new(temperature).unwrap()).unwrap();
        Outlook::new(&scene, accuracy).unwrap()
    }

    /// Errors of n, P and Z from points of a known distribution are those of the formulas.
    #[test]
    fn noise_is_that_of_independent_points() {
        const SAMPLES: usize = 4000;
        const REPEATS: usize = 1600;
        let parts = [0.3, 0.25, 0.2, 0.12, 0.08, 0.05];
        // A weight that grows with height.
        let field = LinearField::new(1.0, 0.5).unwrap();
        let scene =
            Scene::new(Slab::new(6.0, 4.0, 4.0).unwrap(), 16, field, Isothermal::new(1.0).unwrap()).unwrap();
        for quantity in Quantity::ALL {
            let accuracy = Accuracy::new(quantity, 0.1).unwrap().between(1.0, 5.0).unwrap();
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
                        counts[bin.unwrap_or(5)] += 1.0 / SAMPLES as f64;
                    }
                    accuracy.error(&scene, &counts, &parts)
                })
                .collect();
            // The formulas give the mean for n, and the mean square for the others.
            let is_mean = quantity == Quantity::Density;
            let values: Vec<f64> =
                errors.iter().map(|error| if is_mean { *error } else { error * error }).collect();
            let mean = values.iter().sum::<f64>() / REPEATS as f64;
            let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
            let error = squares.sqrt() / REPEATS as f64;
            let expected = accuracy.noise(&scene, &parts, SAMPLES as f64);
            let expected = if is_mean { expected } else { expected * expected };
            assert!(error < 0.06 * expected, "{quantity:?}");
            // Counts of so few spheres are not quite Gaussian.
            assert!(
                (mean - expected).abs() < 4.0 * error + 0.01 * expected,
                "{quantity:?}: {mean} instead of {expected} ± {error}"
            );
        }
    }

    #[test]
    fn sweeps_are_those_that_reach_the_noise() {
        for quantity in Quantity::ALL {
            let outlook = outlook(3.0, 2.0, &Accuracy::new(quantity, 0.1).unwrap());
            for family in MoveFamily::ALL {
                for error in [0.1, 0.01, 0.001] {
                    let sweeps = outlook.sweeps_for(100, family, error);
                    let noise = outlook.noise(100, family, sweeps);
                    approx::assert_relative_eq!(noise, error, max_relative = 1e-12);
                }
            }
        }
    }

    /// The error of the theory in a dilute gas at a wall is known exactly; here by quadrature.
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

    /// Errors of n by the layers and beyond them are the total variation distances of the fit.
    #[test]
    fn errors_of_n_are_those_of_the_fit() {
        let outlook = outlook(2.0, 3.0, &Accuracy::density(0.1).unwrap());
        let share = layering(outlook.theory.base_packing_fraction()) / outlook.column_density;
        approx::assert_relative_eq!(outlook.layers, share, max_relative = 1e-3);
        approx::assert_relative_eq!(outlook.bulk, BULK * outlook.excluded_volume, max_relative = 1e-9);
    }

    #[test]
    fn dilute_columns_have_small_errors_and_dense_ones_freeze() {
        let accuracy = Accuracy::density(0.1).unwrap();
        let [dilute, dense, frozen] =
            [(20.0, 0.1), (2.0, 10.0), (1.0, 20.0)].map(|(t, n)| outlook(t, n, &accuracy));
        assert!(dilute.ideal_error() < 0.02 && dilute.theory_error() < 1e-3);
        assert!(dense.ideal_error() > 0.3 && dense.freezing.is_none());
        let exit = frozen.freezing.unwrap();
        assert!(
            exit.lowest_height < 1.0 && exit.highest_height > 5.0 && exit.highest_height < 15.0,
            "{exit:?}"
        );
        // Above the layers the theory is better in P and Z.
        let accuracy = Accuracy::pressure(0.1).unwrap();
        let [everywhere, above] =
            [accuracy, accuracy.between(9.0, 20.0).unwrap()].map(|accuracy| outlook(4.0, 10.0, &accuracy));
        assert!(above.theory_error() < everywhere.theory_error());
    }
}
