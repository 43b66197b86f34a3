//! Checks of acceptance rules. They return what they find wrong, so that rules known to be wrong
//! can be shown to fail them.

use gradient_mc::{AcceptedMove, Frame, Observer, ObserverError, Recorder};
use thiserror::Error;

/// How a rule breaks detailed balance.
#[derive(Debug, Error)]
pub enum Violation {
    /// A probability above 1, or none at all.
    #[error("ln p({from} -> {to}) = {logarithm}: a probability is at most 1")]
    NotAProbability { from: f64, to: f64, logarithm: f64 },
    /// A ratio of acceptances that is not the Boltzmann factor.
    #[error("ln p({from} -> {to}) - ln p(back) = {found}, but the potential demands {expected}")]
    WrongRatio { from: f64, to: f64, found: f64, expected: f64 },
    /// Ratios that multiply to something else than 1 around a cycle: no potential can explain them.
    #[error("the ratios around the cycle of heights {heights:?} sum to {sum}, not 0")]
    Cycle { heights: [f64; 3], sum: f64 },
    /// Accepted moves that are too many or too few.
    #[error(
        "{accepted} moves of class {class} were accepted where {expected:.1} +- {deviation:.1} should be"
    )]
    WrongFrequency { class: usize, accepted: u64, expected: f64, deviation: f64 },
}

/// ln p(a -> b) - ln p(b -> a).
fn logarithm_of_ratio(log_acceptance: &impl Fn(f64, f64) -> f64, a: f64, b: f64) -> Result<f64, Violation> {
    let one_way = |from: f64, to: f64| {
        let logarithm = log_acceptance(from, to);
        // A NaN is refused too.
        if logarithm <= 0.0 { Ok(logarithm) } else { Err(Violation::NotAProbability { from, to, logarithm }) }
    };
    Ok(one_way(a, b)? - one_way(b, a)?)
}

/// Detailed balance with respect to `potential` u, in every pair and both directions:
/// ln p(a -> b) - ln p(b -> a) = -(u(b) - u(a)), within `tolerance` of |u(a)| + |u(b)| and the
/// rounding of terms of order one, of which u may be a small difference.
///
/// The scale is that of the potentials, not of their difference, since that is where rounding
/// enters.
pub fn check_detailed_balance(
    log_acceptance: impl Fn(f64, f64) -> f64,
    potential: impl Fn(f64) -> f64,
    pairs: &[[f64; 2]],
    tolerance: f64,
) -> Result<(), Violation> {
    // Four evaluations of u, by the rule and by the test at two heights. Each is the sum of two terms
    // of order one, that of the field and that of the temperature, which are right to an ulp, ε;
    // larger terms that do not cancel are within `tolerance`.
    const ROUNDING: f64 = 4.0 * 2.0 * f64::EPSILON;
    for &[a, b] in pairs {
        for (from, to) in [(a, b), (b, a)] {
            let found = logarithm_of_ratio(&log_acceptance, from, to)?;
            let (start, end) = (potential(from), potential(to));
            let expected = start - end;
            let allowed = tolerance * (start.abs() + end.abs()) + ROUNDING;
            if (found - expected).abs() > allowed || !found.is_finite() {
                return Err(Violation::WrongRatio { from, to, found, expected });
            }
        }
    }
    Ok(())
}

/// Kolmogorov's criterion, which knows no potential: around a -> b -> c -> a the ratios cancel,
/// within `tolerance` of their size seen from `reference`.
pub fn check_cycles(
    log_acceptance: impl Fn(f64, f64) -> f64,
    triples: &[[f64; 3]],
    reference: f64,
    tolerance: f64,
) -> Result<(), Violation> {
    for &heights in triples {
        let [a, b, c] = heights;
        let ratio = |from, to| logarithm_of_ratio(&log_acceptance, from, to);
        let sum = ratio(a, b)? + ratio(b, c)? + ratio(c, a)?;
        let mut scale = 0.0;
        for height in heights {
            scale += ratio(reference, height)?.abs();
        }
        if sum.abs() > tolerance * scale || !sum.is_finite() {
            return Err(Violation::Cycle { heights, sum });
        }
    }
    Ok(())
}

/// One trial of a simulation of one sphere: where from, and by how much along x if accepted.
#[derive(Debug, Clone, Copy)]
pub struct Trial {
    pub from: f64,
    pub accepted: Option<f64>,
}

/// Records every [`Trial`] of a simulation of one sphere, whose sweeps are single trials.
#[derive(Debug, Default)]
pub struct TrialRecorder {
    pub trials: Vec<Trial>,
    accepted: Option<AcceptedMove>,
}

impl Observer for TrialRecorder {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        assert_eq!(frame.particles(), 1);
        self.trials.extend(frame.heights().map(|height| match &self.accepted {
            Some(accepted) => {
                // The frame must agree with what the move reported.
                assert_eq!((accepted.from_height + accepted.displacement.x).to_bits(), height.to_bits());
                Trial { from: accepted.from_height, accepted: Some(accepted.displacement.x) }
            }
            None => Trial { from: height, accepted: None },
        }));
        self.accepted = None;
        Ok(())
    }
    fn recorder(&mut self) -> Option<&mut dyn Recorder> {
        Some(self)
    }
}

impl Recorder for TrialRecorder {
    fn record_move(&mut self, accepted: &AcceptedMove) {
        self.accepted = Some(*accepted);
    }
}

/// Whether trials with displacements uniform in (-S, S) were accepted as often as
/// min(1, exp(-[u(x') - u(x)])) says, within 4 standard deviations, in 16 classes: up or down,
/// short or long, and four ranges of the height they started from.
///
/// Given its start, each trial is one Bernoulli trial of known probability, so that the sums are
/// normal whatever the correlation of successive heights.
pub fn check_frequencies(
    trials: &[Trial],
    potential: impl Fn(f64) -> f64,
    maximum_displacement: f64,
    range: [f64; 2],
) -> Result<(), Violation> {
    const POINTS: usize = 60;
    const CLASSES: usize = 16;
    let [lowest, highest] = range;
    let quarter = (highest - lowest) / 4.0;
    let half = 0.5 * maximum_displacement;
    let (mut accepted, mut expected, mut variance) = ([0_u64; CLASSES], [0.0; CLASSES], [0.0; CLASSES]);
    for trial in trials {
        let start = potential(trial.from);
        let zone = if trial.from < lowest + quarter {
            0
        } else if trial.from < lowest + 2.0 * quarter {
            1
        } else if trial.from < lowest + 3.0 * quarter {
            2
        } else {
            3
        };
        for (direction, sign) in [1.0, -1.0].into_iter().enumerate() {
            let room = if sign > 0.0 { highest - trial.from } else { trial.from - lowest };
            for (length, nearest) in [0.0, half].into_iter().enumerate() {
                let class = 4 * zone + 2 * direction + length;
                let farthest = (nearest + half).min(room);
                let mut probability = 0.0;
                if farthest > nearest {
                    let step = (farthest - nearest) / POINTS as f64;
                    for point in 0..POINTS {
                        let distance = nearest + (point as f64 + 0.5) * step;
                        let rise = potential(trial.from + sign * distance) - start;
                        probability += (-rise).exp().min(1.0) * step / (2.0 * maximum_displacement);
                    }
                }
                expected[class] += probability;
                variance[class] += probability * (1.0 - probability);
                if trial.accepted.is_some_and(|moved| {
                    moved * sign > 0.0 && moved.abs() >= nearest && moved.abs() < nearest + half
                }) {
                    accepted[class] += 1;
                }
            }
        }
    }
    for class in 0..CLASSES {
        let deviation = f64::sqrt(variance[class]);
        // One count of slack for classes that are all but empty.
        if (accepted[class] as f64 - expected[class]).abs() > 4.0 * deviation + 1.0 {
            return Err(Violation::WrongFrequency {
                class,
                accepted: accepted[class],
                expected: expected[class],
                deviation,
            });
        }
    }
    Ok(())
}
