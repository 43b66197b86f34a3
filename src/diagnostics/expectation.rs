//! The theory profile of a scene, with which a run is compared.

use crate::equation_of_state::{EquationOfState, FREEZING, FluidSolid, ModifiedKolafa};
use crate::statistics::Estimate;
use crate::{Error, Field, HydrostaticProfile, Scene, TemperatureProfile, Wall, Warning, temperature};

/// The theory profile of a scene between its walls.
#[derive(Debug, Clone)]
pub(super) struct Expectation {
    profile: HydrostaticProfile,
    particles: usize,
    /// Height of the centers in contact with the wall on which the column rests.
    rest: f64,
}

impl Expectation {
    /// Number of parts of the column, with equal numbers of spheres, used in sums.
    const PARTS: u32 = 512;
    /// The local theory is not used for fewer spheres.
    const FEWEST_SPHERES: usize = 64;
    /// Largest relative deviation of the height of the center of mass from the theory. Equilibrated
    /// columns deviate by less than a third of it.
    const TOLERANCE: f64 = 0.03;
    /// Smallest significant deviation in standard errors, large enough for errors underestimated by
    /// half.
    const SIGNIFICANT: f64 = 6.0;

    pub(super) fn new<F: Field, T: TemperatureProfile>(scene: &Scene<F, T>) -> Result<Self, Error> {
        let profile = scene
            .hydrostatics(&FluidSolid::default())
            // The front between fluid and solid is the most difficult part to solve. The metastable
            // fluid has no front, and gives a warning of its own.
            .or_else(|_| scene.hydrostatics(&ModifiedKolafa))?;
        Ok(Self {
            profile,
            particles: scene.particles(),
            rest: scene.open_end().opposite().contact_height(scene.slab()),
        })
    }

    pub(super) fn profile(&self) -> &HydrostaticProfile {
        &self.profile
    }

    /// Equilibrium variance of the height of the center of mass, in the field that gives this
    /// density.
    ///
    /// It is the response to a uniform field: Var(h) = −(1/N) dh/dε for a reduced potential u + εx,
    /// whatever u is. With a local equation of state δn = nχ (δμ − εx), where χ = 1/(Z + dZ/d
    /// ln η) and δμ keeps the number of spheres, so N Var(h) is the mean of χ(x − x̄)² over
    /// spheres, about x̄ with weights χ. For an isothermal column in a uniform field this is the
    /// sum rule Var(h) = (T²/N) dh/dT.
    pub(super) fn variance(&self) -> f64 {
        let (mut zeroth, mut first, mut second) = (0.0, 0.0, 0.0);
        for part in 0..Self::PARTS {
            let height = self.profile.height_of_fraction((f64::from(part) + 0.5) / f64::from(Self::PARTS));
            let eta = self.profile.packing_fraction(height);
            let equation = FluidSolid::default();
            let stiffness = equation.compressibility_factor(eta) + equation.compressibility_derivative(eta);
            // The stiffness would be zero between fluid and solid, where there is no sphere.
            let compressibility = 1.0 / stiffness.max(1.0);
            zeroth += compressibility;
            first += compressibility * height;
            second += compressibility * height * height;
        }
        (second - first * first / zeroth) / (f64::from(Self::PARTS) * self.particles as f64)
    }

    /// Whether this theory is accurate enough to predict the center of mass.
    fn is_good(&self) -> bool {
        let (_, density) = self.profile.density_maximum();
        let steep = |warning: &Warning| matches!(warning, Warning::SteepGradient { .. });
        self.particles >= Self::FEWEST_SPHERES
            && crate::equation_of_state::packing_fraction(density) <= FREEZING
            && !self.profile.warnings().iter().any(steep)
    }

    /// Compares a measured height of the center of mass with the theory.
    pub(super) fn far_from(&self, center_of_mass: Estimate) -> Option<Warning> {
        let theory = self.profile.center_of_mass();
        let far = (center_of_mass.mean - theory).abs() > Self::TOLERANCE * (theory - self.rest).abs()
            && center_of_mass.deviation_from(theory).abs() > Self::SIGNIFICANT;
        (far && self.is_good()).then_some(Warning::FarFromTheory { center_of_mass, theory })
    }

    /// Warnings that need no sweep.
    pub(super) fn of_the_scene<F, T: TemperatureProfile>(&self, scene: &Scene<F, T>) -> Vec<Warning> {
        // An isothermal simulation is exact for any gradient. If the temperature varies, the scene
        // is defined by P = n T Z(η) at every height, which needs small gradients.
        let slab = scene.slab();
        let varies = temperature::constant(scene.temperature(), slab).is_none();
        let concerns_simulation = |warning: &Warning| match warning {
            Warning::SteepGradient { .. } | Warning::DensityJump { .. } => varies,
            Warning::LidTooLow { .. } => true,
            _ => false,
        };
        let mut warnings = self.profile.warnings();
        warnings.retain(concerns_simulation);
        for warning in &mut warnings {
            if let Warning::LidTooLow { lid, .. } = warning {
                // The wall itself, not the height where the bulk profile begins.
                *lid = if scene.open_end() == Wall::Lid { slab.height() } else { 0.0 };
            }
        }
        warnings
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{ExponentialField, SumField, UniformField};
    use crate::temperature::Isothermal;
    use crate::{Hydrostatics, Slab};

    /// dh/dε of a field to which ε is added, by two solutions.
    fn response<F: Field + Copy>(field: F, temperature: f64, slab: &Slab, spheres: f64) -> f64 {
        let step = 1e-3;
        let height = |more: f64| {
            let field = SumField(field, UniformField::new(more).unwrap());
            let theory =
                Hydrostatics::new(field, Isothermal::new(temperature).unwrap(), FluidSolid::default());
            theory.between_walls(slab, spheres).unwrap().center_of_mass()
        };
        (height(step) - height(-step)) / (2.0 * step)
    }

    #[test]
    fn the_variance_is_the_response_of_the_theory() {
        let slab = Slab::new(400.0, 5.0, 5.0).unwrap();
        for temperature in [12.0, 15.0, 30.0] {
            let uniform =
                Scene::new(slab, 1000, UniformField::default(), Isothermal::new(temperature).unwrap());
            let varying = Scene::new(
                slab,
                1000,
                ExponentialField::new(0.02).unwrap(),
                Isothermal::new(temperature).unwrap(),
            );
            let pairs = [
                (
                    Expectation::new(&uniform.unwrap()).unwrap(),
                    response(UniformField::default(), temperature, &slab, 40.0),
                ),
                (
                    Expectation::new(&varying.unwrap()).unwrap(),
                    response(ExponentialField::new(0.02).unwrap(), temperature, &slab, 40.0),
                ),
            ];
            for (expectation, response) in pairs {
                let required = -temperature * response / 1000.0;
                assert!(
                    (expectation.variance() / required - 1.0).abs() < 0.02,
                    "{required} {}",
                    expectation.variance()
                );
            }
        }
        // Of Carnahan-Starling: (T²/N) dh/dT with dh/dT = 1.3206 at T = 15.
        let scene = Scene::new(slab, 1000, UniformField::default(), Isothermal::new(15.0).unwrap()).unwrap();
        let variance = Expectation::new(&scene).unwrap().variance();
        assert!((variance / (225.0 * 1.3206 / 1000.0) - 1.0).abs() < 0.02, "{variance}");
    }
}
