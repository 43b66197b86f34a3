//! The measures of error of the paper, eqs. (32) and (33), in its bins.

use super::case::Case;
use gradient_mc::equation_of_state::{CarnahanStarling, EquationOfState, packing_fraction};
use gradient_mc::observers::EquationOfStateProfile;
use gradient_mc::statistics::deviations::{deviation, scatter};
use paper::Failure;

/// One bin.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PaperPoint {
    pub(crate) height: f64,
    /// ν, of the mean density of the runs.
    pub(crate) packing_fraction: f64,
    /// δ, eq. (33): |P − P(CS)|/P(CS) of the mean pressure of the runs.
    pub(crate) deviation: f64,
    /// Standard error of P/P(CS) by the jackknife over all runs: most of it is counting noise of
    /// the density in the bin.
    pub(crate) deviation_error: f64,
    /// σ, eq. (32): the mean of |Pᵢ − P| over the runs, over P.
    pub(crate) scatter: f64,
}

/// δ and σ of every bin outside the base; `all` are the runs, merged.
pub(crate) fn measures(
    case: &Case,
    runs: &[EquationOfStateProfile],
    all: &EquationOfStateProfile,
) -> Result<Vec<PaperPoint>, Failure> {
    let errors = all.deviations_from(&CarnahanStarling)?;
    let runs: Vec<_> = runs.iter().map(EquationOfStateProfile::points).collect::<Result<_, _>>()?;
    let first = runs.first().ok_or("no runs")?;
    let mut points = Vec::new();
    for (bin, point) in first.iter().enumerate() {
        if !(case.lowest()..case.highest()).contains(&point.height) {
            continue;
        }
        let pressures: Vec<f64> = runs.iter().map(|run| run[bin].pressure.mean).collect();
        let count = runs.len() as f64;
        let pressure = pressures.iter().sum::<f64>() / count;
        let density = runs.iter().map(|run| run[bin].number_density.mean).sum::<f64>() / count;
        let eta = packing_fraction(density);
        let theory =
            density * case.temperature_at(point.height) * CarnahanStarling.compressibility_factor(eta);
        points.push(PaperPoint {
            height: point.height,
            packing_fraction: eta,
            deviation: deviation(pressure, theory),
            deviation_error: errors[bin].deviation.standard_error,
            scatter: scatter(&pressures)?,
        });
    }
    Ok(points)
}
