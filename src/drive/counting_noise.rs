//! Bias of an effective field by the counting noise in its bins (`docs/seven_per_cent.md`).

use crate::equation_of_state::{EquationOfState, FluidSolid, packing_fraction};
use crate::{Error, Field, HydrostaticProfile, Scene, TemperatureProfile, Warning};

/// A smaller deviation of P is not reported.
const SMALLEST_DEVIATION: f64 = 1e-3;

/// A warning if P/(nTZ) is biased at the base of the theory profile, for moves that cross bins of
/// this width.
///
/// The gradient term of the field contains P/n. With k spheres in a bin of mean λ it is too large
/// by the factor b = ⟨λ/k⟩, where an empty bin counts as an ideal gas. Therefore P/(nTZ) = 1/(1 −
/// (T/P) ∫ₓ (b − 1) (P/T) (−T'/T) dx').
///
/// # Errors
/// Those of [`Scene::hydrostatics`].
pub(super) fn warning<F: Field, T: TemperatureProfile>(
    scene: &Scene<F, T>,
    bin_width: f64,
) -> Result<Option<Warning>, Error> {
    /// Number of parts of the column, with equal numbers of spheres.
    const PARTS: u32 = 64;
    let theory = scene.hydrostatics(&FluidSolid::default())?;
    let pressure_deviation = deviation(scene, &theory, bin_width, theory.base());
    let density = |part: u32| {
        theory.number_density(theory.height_of_fraction((f64::from(part) + 0.5) / f64::from(PARTS)))
    };
    let mean_density = (0..PARTS).map(density).sum::<f64>() / f64::from(PARTS);
    let spheres_per_bin = mean_density * scene.slab().base_area() * bin_width;
    let matters = pressure_deviation.abs() > SMALLEST_DEVIATION;
    Ok(matters.then_some(Warning::CountingNoise { spheres_per_bin, pressure_deviation }))
}

/// The predicted P/(nTZ) − 1 at a height.
fn deviation<F, T: TemperatureProfile>(
    scene: &Scene<F, T>,
    theory: &HydrostaticProfile,
    bin_width: f64,
    height: f64,
) -> f64 {
    /// Number of steps of the integral over the column above.
    const STEPS: u32 = 2000;
    let step = (theory.top() - height) / f64::from(STEPS);
    let load = |x: f64| theory.pressure(x) / scene.temperature().temperature(x);
    let bin_volume = scene.slab().base_area() * bin_width;
    let lost: f64 = (0..STEPS)
        .map(|index| {
            let x = height + (f64::from(index) + 0.5) * step;
            let density = theory.number_density(x);
            let factor = FluidSolid::default().compressibility_factor(packing_fraction(density));
            let decay = -scene.temperature().logarithmic_gradient(x);
            (over_weight(density * bin_volume, factor) - 1.0) * load(x) * decay * step
        })
        .sum();
    let part = lost / load(height);
    // If the forces hold up nothing, the column has no steady state.
    if part < 1.0 { 1.0 / (1.0 - part) - 1.0 } else { f64::INFINITY }
}

/// The mean of λ/k over Poisson counts k of mean λ, where an empty bin counts as an ideal gas, 1/Z:
/// the factor by which the gradient term of a field from counts is too large
/// (`docs/seven_per_cent.md`).
///
/// ```
/// // Many spheres: 1 + 1/λ.
/// assert!((gradient_mc::drive::over_weight(1e4, 2.0) - 1.0001).abs() < 1e-7);
/// ```
#[must_use]
pub fn over_weight(mean: f64, compressibility_factor: f64) -> f64 {
    if mean > 200.0 {
        // The series 1 + 1/λ + 2/λ² + 6/λ³; the rest is below 1e-8.
        return 1.0 + (1.0 + (2.0 + 6.0 / mean) / mean) / mean;
    }
    let mut probability = libm::exp(-mean);
    let mut sum = probability / compressibility_factor;
    let mut count = 0.0;
    while count < mean + 12.0 * mean.sqrt() + 20.0 {
        count += 1.0;
        probability *= mean / count;
        sum += probability * mean / count;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Slab;
    use crate::field::UniformField;
    use crate::temperature::ExponentialTemperature;

    /// A column of `docs/seven_per_cent.md`: T = 20 exp(−0.05 x), 40 spheres per area.
    fn column(
        width: f64,
        temperature: ExponentialTemperature,
    ) -> Scene<UniformField, ExponentialTemperature> {
        let slab = Slab::new(150.0, width, width).unwrap();
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let particles = (40.0 * width * width) as usize;
        Scene::new(slab, particles, UniformField::default(), temperature).unwrap()
    }

    #[test]
    fn it_is_what_the_paper_saw() {
        let scene = column(25.0, ExponentialTemperature::new(20.0, 0.05).unwrap());
        let theory = scene.hydrostatics(&FluidSolid::default()).unwrap();
        // The values of its table, in per cent, at heights 10 and 26, for moves with S = 0.75.
        for (bin, low, high) in [(0.1, 8.2, 3.6), (0.05, 20.2, 8.2), (0.2, 3.4, 1.5), (0.5, 0.9, 0.4)] {
            let (cube, part): (f64, f64) = (0.75 * 0.75 * 0.75, 0.75 * 0.75 - bin * bin);
            // The share of a displacement outside the bin in which it starts.
            let outside =
                (0.125 * bin * bin * bin + (cube - bin * bin * bin) / 3.0 - 0.25 * bin * part) / (cube / 3.0);
            for (height, expected) in [(10.0, low), (26.0, high)] {
                let found = 100.0 * outside * deviation(&scene, &theory, bin, height);
                assert!((found - expected).abs() < 0.06 + 0.02 * expected, "{bin} {height}: {found}");
            }
        }
        let Some(Warning::CountingNoise { spheres_per_bin, pressure_deviation }) =
            warning(&scene, 0.1).unwrap()
        else {
            panic!("no warning");
        };
        assert!(pressure_deviation > 0.1 && pressure_deviation < 0.2, "{pressure_deviation}");
        // 40 spheres per area over about 60 diameters.
        assert!(spheres_per_bin > 35.0 && spheres_per_bin < 60.0, "{spheres_per_bin}");
        // A case without a steady state in simulation.
        let narrow = column(12.5, *scene.temperature());
        let Some(Warning::CountingNoise { pressure_deviation, .. }) = warning(&narrow, 0.05).unwrap() else {
            panic!("no warning");
        };
        assert!(pressure_deviation > 5.0, "{pressure_deviation}");
        // Without a gradient there is no noisy term.
        assert_eq!(
            warning(&column(5.0, ExponentialTemperature::new(20.0, 0.0).unwrap()), 0.1).unwrap(),
            None
        );
    }
}
