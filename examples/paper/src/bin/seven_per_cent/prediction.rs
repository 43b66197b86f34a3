//! The predicted bias of a field from instantaneous counts.

use super::run::Column;
use gradient_mc::drive::over_weight;
use gradient_mc::equation_of_state::{EquationOfState, ModifiedKolafa, packing_fraction};
use gradient_mc::field::UniformField;
use gradient_mc::temperature::ExponentialTemperature;
use gradient_mc::{HydrostaticProfile, Hydrostatics, Slab};
use paper::Failure;

/// The theory profile of a column, for predictions.
#[derive(Debug, Clone)]
pub(crate) struct Prediction {
    column: Column,
    profile: HydrostaticProfile,
}

impl Prediction {
    pub(crate) fn new(column: Column) -> Result<Self, Failure> {
        let temperature = ExponentialTemperature::new(column.temperature, column.decay_rate)?;
        // The width of the slab does not matter.
        let slab = Slab::new(column.height, 25.0, 25.0)?;
        let theory = Hydrostatics::new(UniformField::default(), temperature, ModifiedKolafa);
        Ok(Self { column, profile: theory.between_walls(&slab, column.spheres_per_area)? })
    }

    /// P/(nTZ) − 1 at `height` for bins of width `bin` over `area`, if every move ran through many
    /// bins.
    ///
    /// The gradient term of the field holds W/n. With k spheres in a bin of mean λ, W/k is on
    /// average b W/λ, so the forces hold up P/T = W/T − ∫ₓ (b − 1) β (W/T) dx' only, and P
    /// exceeds n T Z by the relative (T/W) ∫ₓ (b − 1) β (W/T) dx'.
    pub(crate) fn deviation(&self, area: f64, bin: f64, height: f64) -> f64 {
        const STEP: f64 = 0.05;
        let Self { column, profile } = self;
        let load = |x: f64| profile.column_above(x) * libm::exp(column.decay_rate * x);
        let mut lost = 0.0;
        let mut x = height + 0.5 * STEP;
        while x < column.height {
            let density = profile.number_density(x);
            let factor = ModifiedKolafa.compressibility_factor(packing_fraction(density));
            lost += (over_weight(density * area * bin, factor) - 1.0) * column.decay_rate * load(x) * STEP;
            x += STEP;
        }
        // The forces hold up less than the weight, and the density changes until they are equal:
        // P/(nTZ) = 1/(1 − lost).
        1.0 / (1.0 - lost / load(height)) - 1.0
    }
}

/// The part of the field's work that a move does outside the bin in which it starts, for
/// displacements uniform in (−S, S) and starts uniform in the bin.
///
/// Within the starting bin n and 1/n are from the same count and there is no bias. A displacement d
/// < w is outside the bin for d²/(2w) of its length on average, a longer one for d − w/2. Each is
/// weighted with its length d, because its contribution to the drift is d times the change of
/// potential along it.
pub(crate) fn part_outside(maximum_displacement: f64, bin: f64) -> f64 {
    let (s, w) = (maximum_displacement, bin);
    if s <= w {
        3.0 * s / (8.0 * w)
    } else {
        let long = (s * s * s - w * w * w) / 3.0 - w * (s * s - w * w) / 4.0;
        (w * w * w / 8.0 + long) / (s * s * s / 3.0)
    }
}
