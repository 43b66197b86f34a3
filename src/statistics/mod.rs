//! Standard errors of correlated data: blocking, the jackknife, autocorrelation times, and the two
//! measures of error of the paper.
//!
//! | data | use |
//! |---|---|
//! | a series of numbers | [`blocking`], [`variance`], [`drift`], [`autocorrelation`] |
//! | a series with a relaxation at its beginning | [`equilibration`] |
//! | many vectors, in bounded memory | [`BlockAverages`] |
//! | a function of several averages, such as a ratio | [`BlockAverages::jackknife`] |
//! | independent runs | [`Merge`](crate::Merge) for [`BlockAverages`]; [`mean_of_replicas`]; σ and δ of the paper: [`deviations`] |
//!
//! One NaN among the observations makes the mean and the error of its component NaN; other
//! components are not affected.

mod autocorrelation;
mod block_averages;
mod blocking;
mod chi_squared;
pub mod deviations;
mod equilibration;
mod estimate;
mod jackknife;
mod memory;
mod replicas;
#[cfg(test)]
pub(crate) mod test_series;

pub use autocorrelation::{Autocorrelation, autocorrelation};
pub use block_averages::BlockAverages;
pub(crate) use blocking::plateau;
pub use blocking::{blocking, drift, variance};
pub(crate) use chi_squared::chi_squared_quantile;
pub use equilibration::{Equilibration, equilibration};
pub use estimate::Estimate;
pub(crate) use jackknife::Jackknife;
pub(crate) use memory::{FEWEST_INDEPENDENT, independent, scattered};
pub use replicas::mean_of_replicas;

/// Smallest number of blocks for a standard error; the error is then uncertain by 1/√(2·15) = 18 %.
pub(crate) const MINIMUM_BLOCKS: usize = 16;

/// Mean of a series. For a constant series it is exactly this number, so the variance is zero.
pub(crate) fn mean(series: &[f64]) -> f64 {
    let Some(&first) = series.first() else { return f64::NAN };
    first + series.iter().map(|value| value - first).sum::<f64>() / series.len() as f64
}

/// Weight of the first of two correlated numbers in the mean with the smallest variance, from their
/// variances and that of their difference; NaN if all are zero.
pub(crate) fn share_of_first(first: f64, second: f64, difference: f64) -> f64 {
    ((difference + second - first) / (2.0 * difference)).clamp(0.0, 1.0)
}

/// The larger of two errors; NaN if either is NaN, which `f64::max` would ignore.
fn larger(first: f64, second: f64) -> f64 {
    if first.is_nan() || first > second { first } else { second }
}
