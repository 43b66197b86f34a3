//! Error bars of correlated data: blocking, the jackknife, autocorrelation times, and the two
//! measures that the paper prints.
//!
//! | given | take |
//! |---|---|
//! | a series of numbers | [`blocking`], [`variance`], [`drift`], [`autocorrelation`] |
//! | a series that begins with a relaxation | [`equilibration`] |
//! | vectors that arrive one by one, too many to keep | [`BlockAverages`] |
//! | a function of several averages (a ratio) | [`BlockAverages::jackknife`] |
//! | independent runs | [`Merge`](crate::Merge) for [`BlockAverages`]; [`mean_of_replicas`]; the paper's σ and δ: [`deviations`] |
//!
//! Numbers that are not finite propagate: one NaN among the observations makes the mean and the
//! error of its component NaN, and leaves the other components alone.

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

/// Fewest blocks from which an error is estimated: it is then itself uncertain by 1/√(2·15) = 18 %.
pub(crate) const MINIMUM_BLOCKS: usize = 16;

/// Mean of a series; of one that never changes, that number to the last bit, so that its variance
/// is zero.
pub(crate) fn mean(series: &[f64]) -> f64 {
    let Some(&first) = series.first() else { return f64::NAN };
    first + series.iter().map(|value| value - first).sum::<f64>() / series.len() as f64
}

/// The part of the first in the mean of two correlated numbers that has the smallest variance, from
/// their variances and that of their difference; NaN if all are zero.
pub(crate) fn share_of_first(first: f64, second: f64, difference: f64) -> f64 {
    ((difference + second - first) / (2.0 * difference)).clamp(0.0, 1.0)
}

/// The larger of two errors, NaN if either is (`f64::max` would hide it).
fn larger(first: f64, second: f64) -> f64 {
    if first.is_nan() || first > second { first } else { second }
}
