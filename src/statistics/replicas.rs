//! The mean of independent replicas.

use super::Estimate;
use crate::Error;

/// The mean of N independent numbers, one from each replica, with the standard error from their
/// scatter: √(Σ (x − mean)²/(N(N − 1))).
///
/// This error does not depend on the correlations within a replica. With few replicas it is
/// uncertain: its relative standard error is 1/√(2(N − 1)), 41 % for four and 27 % for eight
/// replicas. Deviations divided by it follow Student's distribution with N − 1 degrees of freedom,
/// not the normal distribution.
///
/// ```
/// use gradient_mc::statistics::mean_of_replicas;
/// assert_eq!(mean_of_replicas(&[1.0, 2.0, 3.0])?.to_string(), "2.00(58)");
/// # Ok::<(), gradient_mc::Error>(())
/// ```
///
/// # Errors
/// [`Error::TooFewObservations`] for fewer than two numbers.
pub fn mean_of_replicas(values: &[f64]) -> Result<Estimate, Error> {
    if values.len() < 2 {
        return Err(Error::TooFewObservations {
            what: "replicas for a scatter",
            available: values.len(),
            needed: 2,
        });
    }
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean) * (value - mean)).sum();
    Ok(Estimate::new(mean, (squares / (count * (count - 1.0))).sqrt()))
}
