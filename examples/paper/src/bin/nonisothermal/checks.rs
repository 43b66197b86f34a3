//! What figures 14 to 16 claim, and the numbers that decide it.

use super::column::{LOWEST, TEMPERATURE};
use super::mobility::Mobility;
use super::outcome::{DILUTE, Outcome};
use gradient_mc::equation_of_state::{EquationOfState, FREEZING, ModifiedKolafa, packing_fraction};
use gradient_mc::statistics::Estimate;
use paper::groups::{self, farthest_from_zero, magnitude};
use paper::verdict::Verdicts;

/// The paper's list has 2 % for n(x) outside the base.
const DENSITY: f64 = 0.01;
/// The paper's line for P against n T Z, here in the mean over a sixth of the spheres.
const LINE: f64 = 0.02;
/// Largest error of such a mean, and of the mean over all columns.
const LARGEST_ERRORS: [f64; 2] = [0.006, 0.0015];
/// Standard errors that a number may be off.
const SIGMAS: f64 = 4.0;
/// Largest relative error of the number of spheres in the dilute top.
const LARGEST_TAIL_ERROR: f64 = 0.08;

pub(crate) fn verdicts(outcomes: &[Outcome]) -> Verdicts {
    let mut verdicts = Verdicts::new();
    for outcome in outcomes {
        density(outcome, &mut verdicts);
    }
    for outcome in outcomes {
        dilute(outcome, &mut verdicts);
    }
    mobility(outcomes, &mut verdicts);
    for outcome in outcomes {
        equation_of_state(outcome, &mut verdicts);
    }
    all_columns(outcomes, &mut verdicts);
    verdicts
}

fn density(outcome: &Outcome, verdicts: &mut Verdicts) {
    let label = outcome.column.label();
    let top = outcome.column.highest();
    let largest = magnitude(farthest_from_zero(outcome.densities.iter().copied()));
    verdicts.at_most(
        "14a",
        &format!("{label}: largest |n/n(theory) − 1| of six groups of heights from {LOWEST} to {top:.0}"),
        largest,
        DENSITY,
    );
    if let Some(difference) = outcome.difference_of_sides {
        let claim = format!("{label}: h_c from above minus h_c from below");
        verdicts.agrees("14a", &claim, difference, (0.0, SIGMAS), 0.3);
    }
    if let Some(maximum) = outcome.maximum {
        let rate = outcome.column.decay_rate;
        let factor = ModifiedKolafa.compressibility_factor(packing_fraction(maximum.number_density.mean));
        let expected = libm::log(TEMPERATURE * factor * rate) / rate;
        let claim = format!(
            "{label}: height x_m of the maximum of n; ln(T₀ Z β)/β with Z at its density is expected"
        );
        verdicts.agrees("14a", &claim, maximum.height, (expected, SIGMAS), maximum.flatness);
        let claim = format!("{label}: P β/n where the theory has its maximum");
        verdicts.agrees("14a", &claim, maximum.balance, (1.0, SIGMAS), 0.01);
    }
    let certified = f64::from(u8::from(outcome.certificate.is_converged()));
    let claim = format!("{label}: certificate (1: the effective field is self-consistent)");
    verdicts.at_least("14a", &claim, Estimate::exact(certified), 1.0);
}

fn dilute(outcome: &Outcome, verdicts: &mut Verdicts) {
    let label = outcome.column.label();
    let [of_law, of_theory] = outcome.dilute;
    let [low, high] = DILUTE;
    let claim = format!("{label}: spheres where n is {low} to {high}, over those of the theory");
    verdicts.agrees("14b", &claim, of_theory, (1.0, SIGMAS), LARGEST_TAIL_ERROR);
    // Excluded volume makes the law too high by 8 η: 4 % at the dense end of the range, half of it on
    // average.
    let reach = SIGMAS * of_law.standard_error;
    let reach = if of_law.standard_error < LARGEST_TAIL_ERROR { reach } else { f64::NAN };
    let claim = format!("{label}: the same, over those of the ideal-gas law with the correct prefactor");
    verdicts.between("14b", &claim, of_law, 0.96 - reach, 1.0 + reach);
    let factor = outcome.column.prefactor / outcome.column.theory.number_density(0.5);
    let claim = format!(
        "{label}: common logarithm of the same, over the law with the prefactor n(0), eq. (28) as printed"
    );
    let printed = Estimate::new(
        libm::log10(of_law.mean * factor),
        of_law.standard_error / of_law.mean / std::f64::consts::LN_10,
    );
    verdicts.at_least("14b", &claim, printed, 2.0);
}

fn mobility(outcomes: &[Outcome], verdicts: &mut Verdicts) {
    let mobility = Mobility::of(outcomes);
    verdicts.at_most(
        "15",
        "largest relative difference of mean accepted displacements at the same packing fraction",
        Estimate::exact(mobility.largest_spread()),
        0.03,
    );
    let densest = mobility.points.last().map_or(f64::NAN, |point| point.0);
    verdicts.at_most(
        "15",
        "largest packing fraction outside the layers; below freezing",
        Estimate::exact(densest),
        FREEZING,
    );
}

fn equation_of_state(outcome: &Outcome, verdicts: &mut Verdicts) {
    let label = outcome.column.label();
    let largest = magnitude(farthest_from_zero(outcome.deviations.iter().copied()));
    let claim = format!("{label}: largest |P/(nTZ) − 1| of six groups of heights, Z after modified Kolafa");
    verdicts.at_most("16", &claim, largest, LINE);
    let errors = outcome.deviations.iter().map(|deviation| deviation.deviation_from(0.0).abs());
    let claim = format!("{label}: the largest of these in standard errors");
    verdicts.at_most("16", &claim, Estimate::exact(groups::largest(errors)), SIGMAS);
    let errors = outcome.deviations.iter().map(|deviation| deviation.standard_error);
    let claim = format!("{label}: the largest standard error of these");
    verdicts.at_most("16", &claim, Estimate::exact(groups::largest(errors)), LARGEST_ERRORS[0]);
}

/// All groups of all columns together. The groups of a column move together, so their errors are
/// added up; columns are independent.
fn all_columns(outcomes: &[Outcome], verdicts: &mut Verdicts) {
    let columns =
        outcomes.iter().map(|outcome| groups::mean_of_correlated(outcome.deviations.iter().copied()));
    let mean = Estimate::mean_of_independent(columns);
    let claim = "mean of P/(nTZ) − 1 over all groups of all columns, Z after modified Kolafa";
    verdicts.agrees("16", claim, mean, (0.0, SIGMAS), LARGEST_ERRORS[1]);
}
