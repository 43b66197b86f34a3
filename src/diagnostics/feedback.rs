//! Whether the effective field was that of the density that it made.

use crate::Warning;
use crate::drive::{Certificate, Convergence, ForceBalance, Suggestion};

/// [`Warning::FeedbackNotConverged`] where the field is off by more than 2 %, or not known to be
/// within 5 %; [`Warning::TooShort`] if that cannot be judged after so many `sweeps` of production.
pub(super) fn warning(balance: &ForceBalance, sweeps: u64) -> Option<Warning> {
    /// The relative deviation of the balance of forces above which a run that can tell is warned
    /// of.
    const TOLERANCE: f64 = 0.02;
    /// That below which a run should be able to tell.
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
