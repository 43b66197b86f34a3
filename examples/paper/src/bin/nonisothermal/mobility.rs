//! Checks that the mobility is that of one fluid at every height.

use super::outcome::Outcome;
use gradient_mc::statistics::Estimate;

/// Mean accepted displacements of all columns against packing fraction, and their differences at
/// the same packing fraction.
///
/// In a fluid the mobility of small moves depends on the packing fraction (and by a few per cent on
/// the force). A frozen or glassy part would be less mobile than the fluid of another column at the
/// same packing fraction.
#[derive(Debug, Clone)]
pub(crate) struct Mobility {
    /// Packing fraction, mean accepted displacement, decay rate: of every bin outside the layers.
    pub(crate) points: Vec<(f64, Estimate, f64)>,
}

impl Mobility {
    pub(crate) fn of(outcomes: &[Outcome]) -> Self {
        let points = outcomes.iter().flat_map(|outcome| {
            let inside = outcome
                .mobility
                .iter()
                .filter(|point| (super::column::LOWEST..outcome.column.highest()).contains(&point.height));
            inside.map(|point| {
                let eta = outcome.column.theory.packing_fraction(point.height);
                (eta, point.mean_displacement, outcome.column.decay_rate)
            })
        });
        let mut points: Vec<(f64, Estimate, f64)> = points.collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self { points }
    }

    /// The largest relative difference between the mean displacement of a column in a window of
    /// packing fraction and that of all columns there, on a straight line through the window;
    /// windows are 0.02 wide.
    pub(crate) fn largest_spread(&self) -> f64 {
        const WIDTH: f64 = 0.02;
        let windows = (0..25).map(|window| {
            let low = WIDTH * f64::from(window);
            let inside = self.points.iter().filter(|point| (low..low + WIDTH).contains(&point.0));
            spread(&inside.copied().collect::<Vec<_>>())
        });
        windows.fold(0.0, f64::max)
    }
}

/// Of the points of a window; zero if there are too few, or only one column's.
fn spread(points: &[(f64, Estimate, f64)]) -> f64 {
    const FEWEST: usize = 3;
    let count = points.len() as f64;
    let middle = points.iter().map(|point| point.0).sum::<f64>() / count;
    let mean = points.iter().map(|point| point.1.mean).sum::<f64>() / count;
    let square: f64 = points.iter().map(|point| (point.0 - middle) * (point.0 - middle)).sum();
    let slope = points.iter().map(|point| (point.0 - middle) * (point.1.mean - mean)).sum::<f64>() / square;
    let of_column = |decay_rate: f64| {
        let of_column = points.iter().filter(|point| point.2.total_cmp(&decay_rate).is_eq());
        let off: Vec<f64> = of_column.map(|point| point.1.mean - mean - slope * (point.0 - middle)).collect();
        if off.len() < FEWEST { 0.0 } else { (off.iter().sum::<f64>() / off.len() as f64 / mean).abs() }
    };
    super::column::DECAY_RATES.into_iter().map(of_column).fold(0.0, f64::max)
}
