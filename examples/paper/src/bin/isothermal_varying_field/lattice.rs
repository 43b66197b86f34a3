//! The hexagonal layer that fits a rectangular periodic base best, and its strain.

use super::protocol::Base;

/// Two periods of a hexagonal lattice laid on the two sides of a base.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fit {
    /// Spheres of a layer.
    pub(crate) spheres: u32,
    /// Strains along y and z and of the angle between them that lay an unstrained layer on the
    /// base.
    pub(crate) strain: [f64; 3],
}

impl Fit {
    /// Of the change of area.
    pub(crate) fn areal(&self) -> f64 {
        self.strain[0] + self.strain[1]
    }

    /// What is left of the strain without the change of area.
    pub(crate) fn shear(&self) -> f64 {
        let [along_y, along_z, angle] = self.strain;
        (0.5 * (along_y - along_z)).hypot(0.5 * angle)
    }

    /// Measure of the strain: change of area and shear with equal weights.
    fn magnitude(&self) -> f64 {
        self.shear().hypot(0.5 * self.areal())
    }
}

/// The layer with `lattice_constant`, in any orientation, that needs the smallest strain to fill
/// the base.
pub(crate) fn best_fit(base: Base, lattice_constant: f64) -> Option<Fit> {
    /// Periods that are longer or shorter than the side by more than this are not looked at.
    const LARGEST_STRAIN: f64 = 0.12;
    let candidates = |side: f64| {
        let units = side / lattice_constant;
        #[allow(clippy::cast_possible_truncation)]
        let most = (1.3 * units).ceil() as i32 + 1;
        let mut found = Vec::new();
        for first in -most..=most {
            for second in -most..=most {
                // In units of the lattice constant, with the second basis vector at 60 degrees.
                let (i, j) = (f64::from(first), f64::from(second));
                let period = [i + 0.5 * j, j * 0.75_f64.sqrt()];
                let strain = units / period[0].hypot(period[1]) - 1.0;
                if strain.abs() < LARGEST_STRAIN {
                    found.push(((first, second), period, strain));
                }
            }
        }
        found
    };
    let (along_y, along_z) = (candidates(base.0[0]), candidates(base.0[1]));
    let mut best: Option<Fit> = None;
    for (y, period_y, strain_y) in &along_y {
        for (z, period_z, strain_z) in &along_z {
            let spheres = y.0 * z.1 - y.1 * z.0;
            let dot = period_y[0] * period_z[0] + period_y[1] * period_z[1];
            let lengths = period_y[0].hypot(period_y[1]) * period_z[0].hypot(period_z[1]);
            let angle = dot / lengths;
            if spheres <= 0 || angle.abs() > 2.0 * LARGEST_STRAIN {
                continue;
            }
            let fit = Fit { spheres: spheres.unsigned_abs(), strain: [*strain_y, *strain_z, angle] };
            if best.is_none_or(|best| fit.magnitude() < best.magnitude()) {
                best = Some(fit);
            }
        }
    }
    best
}

/// Distance of neighbors in a face-centered or hexagonal close-packed crystal of this number
/// density.
pub(crate) fn lattice_constant(number_density: f64) -> f64 {
    libm::cbrt(std::f64::consts::SQRT_2 / number_density)
}

/// Spheres per area of a hexagonal layer with this distance of neighbors.
pub(crate) fn lateral_density(lattice_constant: f64) -> f64 {
    2.0 / (3.0_f64.sqrt() * lattice_constant * lattice_constant)
}
