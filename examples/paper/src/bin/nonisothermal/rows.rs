//! Profiles as they are drawn and written: bins joined to ranges of heights.

use super::column::LOWEST;
use super::run::BIN;
use gradient_mc::equation_of_state::packing_fraction;
use gradient_mc::observers::EquationOfStateProfile;
use gradient_mc::statistics::Estimate;
use paper::Failure;
use paper::groups::means_over;

/// Means over a range of heights.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row {
    pub(crate) range: [f64; 2],
    pub(crate) number_density: Estimate,
    /// P/T, with T of each bin.
    pub(crate) pressure_over_temperature: Estimate,
}

impl Row {
    pub(crate) fn height(&self) -> f64 {
        f64::midpoint(self.range[0], self.range[1])
    }

    pub(crate) fn packing_fraction(&self) -> Estimate {
        let Estimate { mean, standard_error, .. } = self.number_density;
        Estimate::new(packing_fraction(mean), packing_fraction(standard_error))
    }
}

/// Up to here, where there are layers, every bin is shown; above, ranges of a diameter.
const LAYERS: f64 = 6.5;

/// Ranges of heights that follow each other.
fn ranges(lowest: f64, highest: f64, height: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
    let mut ranges = Vec::new();
    let mut low = lowest;
    while low < highest {
        let high = low + height(low);
        ranges.push([low, high]);
        low = high;
    }
    ranges
}

/// For the density.
pub(crate) fn fine(highest: f64) -> Vec<[f64; 2]> {
    ranges(0.5, highest, |low| if low < LAYERS { BIN } else { 1.0 })
}

/// For the equation of state, which does not hold in the layers.
pub(crate) fn coarse(highest: f64) -> Vec<[f64; 2]> {
    ranges(LOWEST, highest, |_| 3.0)
}

/// The means over these ranges.
pub(crate) fn rows(profile: &EquationOfStateProfile, ranges: &[[f64; 2]]) -> Result<Vec<Row>, Failure> {
    let estimates = profile.jackknife(|states| {
        let mut means = means_over(states, ranges, |state| state.number_density);
        means.extend(means_over(states, ranges, |state| state.pressure / state.temperature));
        means
    })?;
    let (densities, ratios) = estimates.split_at(ranges.len());
    let rows = ranges.iter().zip(densities.iter().zip(ratios)).map(
        |(&range, (&number_density, &pressure_over_temperature))| Row {
            range,
            number_density,
            pressure_over_temperature,
        },
    );
    Ok(rows.collect())
}
