//! Results that are known exactly, and how a sampled one is compared with them.

use gradient_mc::drive::Scheme;
use gradient_mc::observers::CenterOfMass;
use gradient_mc::statistics::Estimate;
use gradient_mc::{Every, Field, Simulation, TemperatureProfile};

/// Whether an estimate agrees with an exact value: 4 standard errors, the error bar capped.
pub fn agrees(what: &str, estimate: Estimate, exact: f64, largest_error: f64) -> Result<(), String> {
    let deviation = (estimate.mean - exact).abs();
    println!("{what}: {estimate} against {exact:.6}, error at most {largest_error}");
    if estimate.standard_error > largest_error || estimate.standard_error <= 0.0 {
        Err(format!("{what}: error bar {:e} is not in (0, {largest_error:e}]", estimate.standard_error))
    } else if deviation > 4.0 * estimate.standard_error {
        Err(format!("{what}: {estimate} against {exact}, {:.1} sigma", deviation / estimate.standard_error))
    } else {
        Ok(())
    }
}

/// Whether two independent estimates agree: 4 joint standard errors, these at most a share `cap` of
/// the second.
pub fn meet(what: &str, first: Estimate, second: Estimate, cap: f64) -> Result<(), String> {
    let joint = first.minus_independent(second).standard_error;
    agrees(what, Estimate::new(first.mean, joint), second.mean, cap * second.mean)
}

/// Mean height of a density given up to a factor, over the heights of a center, by Simpson's rule.
pub fn mean_height(height: f64, density: impl Fn(f64) -> f64) -> f64 {
    let (low, high, panels) = (0.5, height - 0.5, 20_000);
    let width = (high - low) / f64::from(2 * panels);
    let (mut norm, mut moment) = (0.0, 0.0);
    for node in 0..=2 * panels {
        let weight = if node == 0 || node == 2 * panels { 1.0 } else { f64::from(2 + 2 * (node % 2)) };
        let x = low + f64::from(node) * width;
        norm += weight * density(x);
        moment += weight * density(x) * x;
    }
    moment / norm
}

/// The ideal-gas profile n ∝ exp(−∫a/T)/T, eq. (28), with both fields varying.
pub fn ideal_gas_mean(height: f64, base: f64, alpha: f64, beta: f64) -> f64 {
    let rate = alpha + beta;
    mean_height(height, |x| (-(rate * x).exp_m1() / (rate * base) + beta * x).exp())
}

/// Mean height of the center of mass of two spheres on a base 3 x 3 at temperature 1, by quadrature
/// of exp(−Δ/T)[L² − π(1 − Δ²)₊] over the height difference Δ.
pub const TWO_SPHERES_MEAN: f64 = 1.567_105_973_366_81;
/// Its variance.
pub const TWO_SPHERES_VARIANCE: f64 = 0.519_298_716_998_895;

/// Contact value of a density in ten bins of 0.02: least-squares parabola of its logarithm.
pub fn contact_density(bins: &[f64]) -> f64 {
    let mut normal = nalgebra::Matrix3::<f64>::zeros();
    let mut right = nalgebra::Vector3::<f64>::zeros();
    for (bin, density) in bins.iter().enumerate() {
        let x = (bin as f64 + 0.5) * 0.02;
        let row = nalgebra::Vector3::new(1.0, x, x * x);
        normal += row * row.transpose();
        right += row * density.ln();
    }
    normal.lu().solve(&right).map_or(f64::NAN, |solution| solution[0].exp())
}

/// Center-of-mass series, every `interval` sweeps, from a run of the given length, equilibrated for
/// a tenth of it.
pub fn center_of_mass<F, T, S>(
    mut simulation: Simulation<F, T, S>,
    sweeps: u64,
    interval: u64,
) -> CenterOfMass
where
    F: Field,
    T: TemperatureProfile,
    S: Scheme<F, T>,
{
    let mut observer = Every::new(interval, CenterOfMass::new());
    simulation.equilibrate(sweeps / 10, &mut ()).unwrap();
    simulation.run(sweeps, &mut observer).unwrap();
    observer.observer
}
