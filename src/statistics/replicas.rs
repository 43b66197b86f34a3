//! The mean of independent numbers.

use super::Estimate;
use crate::Error;

/// The mean of N independent numbers, one of each replica, with the standard error that their
/// scatter gives: √(Σ (x − mean)²/(N(N − 1))).
///
/// It does not depend on the correlations within a replica. But few replicas do not determine it
/// well: it is itself uncertain by 1/√(2(N − 1)), by 41 % for four and by 27 % for eight, and four
/// of it are not 4 sigma of a normal number (Student's distribution with N − 1 degrees of freedom).
///
/// ```
/// use gradient_mc::statistics::mean_of_replicas;
/// assert_eq!(mean_of_replicas(&[1.0, 2.0, 3.0])?.to_string(), "2.00(58)");
/// # Ok::<(), gradient_mc::Error>(())
/// ```
///
/// # Errors
/// [`Error::TooFewObservations`] below two numbers.
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
