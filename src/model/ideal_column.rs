//! The cheapest candidate: points instead of spheres.

use crate::{Error, Field, Scene, TemperatureProfile};

/// The ideal gas of a scene between its walls, without a solver: n ∝ exp(−∫ dφ/T)/T, which is exp(−φ/T) where T is constant
/// (eqs. 10 and 28 of doi:10.1103/PhysRevE.83.061306).
///
/// The centers lie half a diameter off the walls, as those of spheres; that is all it knows of their size. ln n is a straight line
/// between nodes an eighth of a diameter apart: exact for T constant in a uniform field, and within (1/8)²/8 times
/// the second derivative of ln n else.
///
/// ```
/// use gradient_mc::model::IdealColumn;
/// use gradient_mc::{Scene, Slab, field::UniformField, temperature::Isothermal};
/// let slab = Slab::new(101.0, 5.0, 5.0)?;
/// let scene = Scene::new(slab, 50, UniformField::default(), Isothermal::new(10.0)?)?;
/// let gas = IdealColumn::new(&scene)?;
/// let exact = 2.0 * (1.0 - (-0.95_f64).exp()) / (1.0 - (-10.0_f64).exp());
/// assert!((gas.column_below(10.0) - exact).abs() < 1e-12);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct IdealColumn {
    base: f64,
    spacing: f64,
    /// Of each node: n, and the spheres per area below it.
    nodes: Vec<[f64; 2]>,
}

impl IdealColumn {
    /// Most of the distance between two nodes, in diameters.
    const SPACING: f64 = 0.125;

    /// The column of `scene`.
    ///
    /// # Errors
    /// [`Error::InvalidPotential`] where ∫ dφ/T is not finite.
    pub fn new<F: Field, T: TemperatureProfile>(scene: &Scene<F, T>) -> Result<Self, Error> {
        let (base, top) = (scene.slab().lowest_center(), scene.slab().highest_center());
        // Heights are at most 1e6.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let intervals = ((top - base) / Self::SPACING).ceil() as usize;
        let spacing = (top - base) / intervals as f64;
        let potential = |height: f64| scene.field().potential(height);
        let inverse = |height: f64| 1.0 / scene.temperature().temperature(height);
        let mut logarithms = Vec::with_capacity(intervals + 1);
        let mut sum = 0.0;
        let (mut height, mut before, mut inverse_before) = (base, potential(base), inverse(base));
        logarithms.push(libm::log(inverse_before));
        for node in 1..=intervals {
            let next = base + node as f64 * spacing;
            let (here, inverse_here) = (potential(next), inverse(next));
            // Simpson's rule in φ.
            let middle = inverse(0.5 * (height + next));
            sum += (here - before) * (inverse_before + 4.0 * middle + inverse_here) / 6.0;
            if !sum.is_finite() {
                return Err(Error::InvalidPotential { height: next, potential: sum });
            }
            logarithms.push(libm::log(inverse_here) - sum);
            (height, before, inverse_before) = (next, here, inverse_here);
        }
        let largest = logarithms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let densities: Vec<f64> = logarithms.iter().map(|value| libm::exp(value - largest)).collect();
        let mut below = 0.0;
        let mut nodes: Vec<[f64; 2]> = Vec::with_capacity(intervals + 1);
        for (node, &density) in densities.iter().enumerate() {
            if node > 0 {
                below += exponential_mass(densities[node - 1], density, spacing);
            }
            nodes.push([density, below]);
        }
        let scale = scene.column_density() / below;
        for node in &mut nodes {
            *node = node.map(|value| value * scale);
        }
        Ok(Self { base, spacing, nodes })
    }

    /// Number density n(x); 0 where no center can be.
    #[must_use]
    pub fn number_density(&self, height: f64) -> f64 {
        self.interval(height).map_or(0.0, |(node, part)| self.between(node, part))
    }

    /// Spheres per unit area below `height`.
    #[must_use]
    pub fn column_below(&self, height: f64) -> f64 {
        match self.interval(height) {
            None if height < self.base => 0.0,
            None => self.nodes.last().map_or(0.0, |node| node[1]),
            Some((node, part)) => {
                let [density, below] = self.nodes[node];
                below + exponential_mass(density, self.between(node, part), part * self.spacing)
            }
        }
    }

    /// The node below a height, and how far the next one is away from it in units of the spacing.
    fn interval(&self, height: f64) -> Option<(usize, f64)> {
        let scaled = (height - self.base) / self.spacing;
        if !(scaled >= 0.0 && scaled <= (self.nodes.len() - 1) as f64) {
            return None;
        }
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let node = (scaled as usize).min(self.nodes.len() - 2);
        Some((node, scaled - node as f64))
    }

    fn between(&self, node: usize, part: f64) -> f64 {
        let (low, high) = (self.nodes[node][0], self.nodes[node + 1][0]);
        if low > 0.0 && high > 0.0 {
            low * libm::exp(part * libm::log(high / low))
        } else {
            low + part * (high - low)
        }
    }
}

/// ∫ n dx over `width`, n exponential between two values.
fn exponential_mass(low: f64, high: f64, width: f64) -> f64 {
    if !(low > 0.0 && high > 0.0) {
        return 0.5 * (low + high) * width;
    }
    let rise = libm::log(high / low);
    // Below this the series is exact to rounding.
    if rise.abs() < 1e-4 {
        low * width * (1.0 + 0.5 * rise + rise * rise / 6.0)
    } else {
        (high - low) / rise * width
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::equation_of_state::IdealGas;
    use crate::field::ExponentialField;
    use crate::model::{densities, total_variation_distance};
    use crate::temperature::ExponentialTemperature;
    use crate::{Hydrostatics, Slab};

    /// The solver is another way to the same numbers.
    #[test]
    fn it_agrees_with_the_solver() {
        for (base, decay_rate, rate) in
            [(1.0, 0.0, 0.1), (20.0, 0.05, 0.0), (5.0, 0.03, 0.05), (2.0, -0.02, 0.0)]
        {
            let slab = Slab::new(60.5, 5.0, 5.0).unwrap();
            let temperature = ExponentialTemperature::new(base, decay_rate).unwrap();
            let scene = Scene::new(slab, 20, ExponentialField::new(rate).unwrap(), temperature).unwrap();
            let solved = Hydrostatics::new(scene.field(), scene.temperature(), IdealGas)
                .base(0.5)
                .lid(60.0)
                .column_density(scene.column_density())
                .unwrap();
            let gas = IdealColumn::new(&scene).unwrap();
            let ours = densities(&slab, |height| gas.column_below(height));
            let theirs = densities(&slab, |height| solved.column_below(height));
            let error = total_variation_distance(&ours, &theirs);
            assert!(error < 1e-4, "{base} {decay_rate} {rate}: {error}");
            approx::assert_relative_eq!(
                gas.number_density(7.3),
                solved.number_density(7.3),
                max_relative = 1e-3
            );
            approx::assert_relative_eq!(ours.iter().sum::<f64>(), 0.8, max_relative = 1e-12);
        }
    }
}
