//! The common form of the functionals: Φ = −n₀ ln(1 − n₃) + (n₁n₂ − **n**₁·**n**₂) f₂(n₃) + Φ₃
//! f₃(n₃), with Φ₃ of third order in the surface densities.

use super::{FreeEnergy, WeightedDensities};
use std::f64::consts::PI;

/// A function of n₃ and its derivative.
#[derive(Debug, Clone, Copy)]
pub(super) struct Factor {
    pub(super) value: f64,
    pub(super) slope: f64,
}

impl Factor {
    /// 1/(1 − n₃).
    pub(super) fn inverse_void(packing: f64) -> Self {
        let inverse = 1.0 / (1.0 - packing);
        Self { value: inverse, slope: inverse * inverse }
    }

    /// 1/(1 − n₃)².
    pub(super) fn inverse_square(packing: f64) -> Self {
        let inverse = 1.0 / (1.0 - packing);
        Self { value: inverse * inverse, slope: 2.0 * inverse * inverse * inverse }
    }

    /// The sum of a power series, used where differences of large terms would lose digits.
    pub(super) fn from_series(packing: f64, coefficient: impl Fn(f64) -> f64) -> Self {
        /// 0.05¹⁴ is below rounding.
        const TERMS: u32 = 14;
        let (mut value, mut slope) = (0.0, 0.0);
        for term in (0..TERMS).rev() {
            slope = slope * packing + value;
            value = value * packing + coefficient(f64::from(term));
        }
        Self { value, slope }
    }

    /// Below this n₃ the power series is used.
    pub(super) const SERIES: f64 = 0.05;
}

/// The term of third order and its derivatives.
#[derive(Debug, Clone, Copy)]
pub(super) struct Third {
    pub(super) value: f64,
    pub(super) by_surface: f64,
    pub(super) by_vector: f64,
    pub(super) by_tensor: f64,
}

impl Third {
    /// (n₂³ − 3n₂ **n**₂²)/(24π), of Rosenfeld.
    pub(super) fn rosenfeld(weighted: &WeightedDensities) -> Self {
        const SCALE: f64 = 1.0 / (24.0 * PI);
        let WeightedDensities { surface, vector, .. } = *weighted;
        let (surface_squared, vector_squared) = (surface * surface, vector * vector);
        Self {
            value: SCALE * surface * (surface_squared - 3.0 * vector_squared),
            by_surface: 3.0 * SCALE * (surface_squared - vector_squared),
            by_vector: -6.0 * SCALE * surface * vector,
            by_tensor: 0.0,
        }
    }
}

/// Φ from its parts.
pub(super) fn free_energy(
    weighted: &WeightedDensities,
    second_factor: Factor,
    third: Third,
    third_factor: Factor,
) -> FreeEnergy {
    let WeightedDensities { packing, surface, vector, .. } = *weighted;
    let logarithm = libm::log1p(-packing);
    let second = (surface * surface - vector * vector) / (2.0 * PI);
    FreeEnergy {
        density: -surface * logarithm / PI + second * second_factor.value + third.value * third_factor.value,
        by_packing: surface / (PI * (1.0 - packing))
            + second * second_factor.slope
            + third.value * third_factor.slope,
        by_surface: -logarithm / PI
            + surface * second_factor.value / PI
            + third.by_surface * third_factor.value,
        by_vector: -vector * second_factor.value / PI + third.by_vector * third_factor.value,
        by_tensor: third.by_tensor * third_factor.value,
    }
}
