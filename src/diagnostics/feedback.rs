//! Checks whether the effective field is self-consistent.

use crate::Warning;
use crate::drive::{Certificate, Convergence, ForceBalance, Suggestion};

/// [`Warning::FeedbackNotConverged`] if the field is off by more than 2 %, or its standard error
/// does not exclude a deviation of 5 %; [`Warning::TooShort`] if `sweeps` sweeps of production are
/// too few to judge.
pub(super) fn warning(balance: &ForceBalance, sweeps: u64) -> Option<Warning> {
    /// Largest relative deviation of the balance of forces without a warning.
    const TOLERANCE: f64 = 0.02;
    /// Relative deviation that a run must be able to exclude.
    const KNOWN_TO: f64 = 0.05;
    let cannot_tell = |certificate: &Certificate| {
        let Convergence::NotConverged { suggestion, .. } = certificate.convergence else { return false };
        suggestion == Suggestion::MeasureLonger
    };
    let verdict = match balance.certificate(TOLERANCE) {
        Ok(certificate) if cannot_tell(&certificate) => balance.certificate(KNOWN_TO),
        verdict => verdict,
    };
    match verdict {
        Ok(certificate) if certificate.is_converged() => None,
        Ok(certificate) => Some(Warning::FeedbackNotConverged { certificate }),
        Err(_) => Some(Warning::TooShort { sweeps, needed: ForceBalance::FEWEST_SWEEPS }),
    }
}
