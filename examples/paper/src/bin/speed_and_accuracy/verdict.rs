//! The claims of the study, tested with the data.

use crate::chart::Data;
use crate::contest::{Contest, Crossing, Task, Way};
use crate::method::{Method, Moves, Scheme, Start};
use crate::point::{Point, Quantity};
use crate::report::{self, Family, families, time};
use crate::system::System;
use paper::verdict::Verdicts;

/// Largest error of a reference.
const FLOOR: f64 = 1e-3;

/// Judges everything.
pub(crate) fn judge(all: &[Data<'_>], contest: &Contest, target: f64) -> Verdicts {
    let mut judge = Judge(Verdicts::new());
    for data in all {
        judge.system(data);
    }
    judge.contest(contest, target);
    judge.0
}

/// The claims so far.
struct Judge(Verdicts);

impl Judge {
    fn claim(&mut self, holds: bool, words: &str) {
        self.0.is_so("speed and accuracy", words, holds);
    }

    /// Of one system.
    fn system(&mut self, data: &Data<'_>) {
        let system = data.system.title();
        let own = data.reference.errors.misplaced;
        self.claim(
            own <= FLOOR,
            &format!("{system}: error of n of the reference {own:.1e}, at most {FLOOR:.0e}"),
        );
        let families = families(data);
        let is_theory = |family: &&Family<'_>| family.points.iter().all(|point| point.is_theory());
        for quantity in Quantity::BOTH {
            let cheapest = |target: f64, theories: bool| -> Option<(&Family<'_>, f64)> {
                families
                    .iter()
                    .filter(|family| is_theory(family) == theories)
                    .filter_map(|family| Some((family, family.time_to(quantity, target)?)))
                    .min_by(|one, other| one.1.total_cmp(&other.1))
            };
            let words = |found: &Option<(&Family<'_>, f64)>| {
                found.as_ref().map_or("nothing".to_owned(), |(family, seconds)| {
                    format!("{} ({})", family.name, time(Some(*seconds)))
                })
            };
            let (theory, simulation) = (cheapest(0.01, true), cheapest(0.01, false));
            let holds = match (&theory, &simulation) {
                (Some(theory), Some(simulation)) => theory.1 < simulation.1,
                (theory, _) => theory.is_some(),
            };
            self.claim(
                holds,
                &format!(
                    "{system}: the fastest method for {} within 1 % is a theory, {}; of simulations {}",
                    quantity.symbol(),
                    words(&theory),
                    words(&simulation),
                ),
            );
            println!(
                "fastest for {} within 0.3 %, {system}: of theories {}, of simulations {}",
                quantity.symbol(),
                words(&cheapest(0.003, true)),
                words(&cheapest(0.003, false)),
            );
        }
        // Tuned moves have smaller errors than S = 0.75 of the paper, from a random start.
        for width in [crate::method::SMALL, crate::method::FULL] {
            let last = |moves| {
                last_point(
                    data,
                    Method { moves, start: Start::Uniform, width, scheme: Scheme::SelfConsistent },
                )
            };
            if let (Some(paper), Some(tuned)) = (last(Moves::Paper), last(Moves::Tuned)) {
                let ratio = paper.errors.misplaced / tuned.errors.misplaced;
                self.claim(
                    ratio > 1.0,
                    &format!(
                        "{system}, {width} x {width}, random start, total variation distance: S = 0.75 after {} {:.2} %, tuned \
                        moves {:.2} % after {}",
                        time(Some(paper.seconds)),
                        100.0 * paper.errors.misplaced,
                        100.0 * tuned.errors.misplaced,
                        time(Some(tuned.seconds)),
                    ),
                );
            }
        }
        if data.system == System::VaryingTemperature {
            self.schemes(data);
        }
    }

    fn schemes(&mut self, data: &Data<'_>) {
        let width = crate::method::SMALL;
        let last =
            |scheme| last_point(data, Method { moves: Moves::Tuned, start: Start::Theory, width, scheme });
        if let (Some(paper), Some(ours)) = (last(Scheme::Instantaneous), last(Scheme::SelfConsistent)) {
            let over = paper.is_over_confident(Quantity::Density, data.reference)
                || paper.is_over_confident(Quantity::Pressure, data.reference);
            self.claim(
                over,
                &format!(
                    "the instantaneous scheme on 5 x 5 is over-confident: total variation distance {:.2} %, estimated {:.2} %",
                    100.0 * paper.errors.misplaced,
                    100.0 * paper.claims.map_or(f64::NAN, |claims| claims.misplaced),
                ),
            );
            self.claim(
                !ours.is_over_confident(Quantity::Density, data.reference),
                &format!(
                    "the self-consistent scheme is not: total variation distance {:.2} %, estimated {:.2} %",
                    100.0 * ours.errors.misplaced,
                    100.0 * ours.claims.map_or(f64::NAN, |claims| claims.misplaced),
                ),
            );
        }
    }

    /// Of the equation of state.
    fn contest(&mut self, contest: &Contest, target: f64) {
        for way in [Way::Local, Way::Chains] {
            let [sigmas, deviation, error] = contest.agreement(way);
            self.claim(
                sigmas < 4.0 && error < 0.01,
                &format!(
                    "{}: Z agrees with the modified Kolafa equation within {sigmas:.1} standard errors at every density; at most \
                     {:.2} % off, errors at most {:.2} %",
                    way.label(),
                    100.0 * deviation,
                    100.0 * error,
                ),
            );
        }
        for task in
            [Task::NINE, Task::SEVENTEEN, Task::SIXTY_FIVE, Task::Curve(8), Task::ChemicalPotential(8)]
        {
            let [gradient, homogeneous] = report::best(contest, task, target, true);
            let words = |found: Option<(Way, Crossing)>| {
                found.map_or("not reached".to_owned(), |(way, time)| format!("{}, {time} s", way.label()))
            };
            let followed = [Task::NINE, Task::SEVENTEEN].contains(&task);
            self.claim(
                // More densities are not followed that far.
                !followed || homogeneous.is_some_and(|(_, time)| !time.extrapolated),
                &format!(
                    "equation of state ({}) to {} %: {}; {}",
                    task.label(),
                    100.0 * target,
                    words(homogeneous),
                    words(gradient),
                ),
            );
            for (name, opponent) in [
                ("event chains", report::time_to(contest, Way::Chains, task, target, true)),
                (
                    "event chains at the speed of the library",
                    report::time_to(contest, Way::ChainsAtPace, task, target, true),
                ),
                ("local moves", report::time_to(contest, Way::Local, task, target, true)),
            ] {
                if let (Some((_, gradient)), Some(opponent)) = (gradient, opponent) {
                    let gain = opponent.seconds / gradient.seconds;
                    let outcome = if gain > 1.0 { "faster" } else { "slower" };
                    println!(
                        "time of homogeneous {name} over that of the column, {}: {gain:.3} (the column is {outcome})",
                        task.label()
                    );
                }
            }
        }
    }
}

/// The longest run of a method on one thread.
fn last_point<'a>(data: &Data<'a>, method: Method) -> Option<&'a Point> {
    data.points.iter().rfind(|point| point.simulation(1).is_some_and(|(own, _)| own == method))
}
