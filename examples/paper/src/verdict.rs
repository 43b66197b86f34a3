//! Verdicts: the claims of a figure, each with a measured number and its allowed range.

use super::table::Table;
use super::{Ending, Failure, output};
use gradient_mc::statistics::Estimate;
use std::fmt;
use std::path::Path;

/// A claim with the number that decides it.
#[derive(Debug, Clone)]
pub struct Verdict {
    /// The figure of the paper, such as "7 inset".
    pub figure: String,
    /// The claim in words, with the measured quantity and its unit.
    pub claim: String,
    pub measured: Estimate,
    /// Allowed range of the measured mean; one end may be infinite.
    pub lowest: f64,
    pub highest: f64,
}

impl Verdict {
    /// Whether the measured mean is in the range; false for NaN.
    ///
    /// The error bar is not used: claims within a number of standard errors include them in the
    /// range, or measure the deviation in standard errors.
    pub fn holds(&self) -> bool {
        (self.lowest..=self.highest).contains(&self.measured.mean)
    }

    /// The measured value, with its error if it has one.
    pub fn measured_in_words(&self) -> String {
        if self.measured.standard_error > 0.0 { self.measured.to_string() } else { brief(self.measured.mean) }
    }

    /// The range in words.
    pub fn range(&self) -> String {
        match (self.lowest.is_finite(), self.highest.is_finite()) {
            (true, true) => format!("{} to {}", brief(self.lowest), brief(self.highest)),
            (true, false) => format!("at least {}", brief(self.lowest)),
            (false, true) => format!("at most {}", brief(self.highest)),
            (false, false) => "anything".into(),
        }
    }
}

/// The columns of `verdicts.csv`.
const COLUMNS: [&str; 7] = ["figure", "claim", "measured", "standard_error", "lowest", "highest", "holds"];

/// All verdicts of a study.
#[derive(Debug, Clone, Default)]
pub struct Verdicts(Vec<Verdict>);

impl Verdicts {
    pub fn new() -> Self {
        Self::default()
    }

    /// Claims that the measured mean is `threshold` at most.
    pub fn at_most(&mut self, figure: &str, claim: &str, measured: Estimate, threshold: f64) {
        self.between(figure, claim, measured, f64::NEG_INFINITY, threshold);
    }

    /// Claims that the measured mean is `threshold` at least.
    pub fn at_least(&mut self, figure: &str, claim: &str, measured: Estimate, threshold: f64) {
        self.between(figure, claim, measured, threshold, f64::INFINITY);
    }

    /// Claims that the measured mean is between two thresholds.
    pub fn between(&mut self, figure: &str, claim: &str, measured: Estimate, lowest: f64, highest: f64) {
        let (figure, claim) = (figure.to_owned(), claim.to_owned());
        self.0.push(Verdict { figure, claim, measured, lowest, highest });
    }

    /// Claims that the measured mean agrees with `expected` within `standard_errors` standard
    /// errors, and that the standard error is at most `largest_error`.
    pub fn agrees(
        &mut self,
        figure: &str,
        claim: &str,
        measured: Estimate,
        (expected, standard_errors): (f64, f64),
        largest_error: f64,
    ) {
        let error = measured.standard_error;
        // If the error is too large or missing, the range is empty.
        let reach = if error <= largest_error { standard_errors * error } else { f64::NAN };
        self.between(figure, claim, measured, expected - reach, expected + reach);
    }

    /// Claims that a condition holds.
    pub fn is_so(&mut self, figure: &str, claim: &str, so: bool) {
        self.at_least(figure, claim, Estimate::new(f64::from(u8::from(so)), 0.0), 1.0);
    }

    pub fn iter(&self) -> impl Iterator<Item = &Verdict> {
        self.0.iter()
    }

    /// How a study with these verdicts ends. Without any verdict it fails.
    pub fn ending(&self) -> Ending {
        let good = !self.0.is_empty() && self.0.iter().all(Verdict::holds);
        if good { Ending::Finished } else { Ending::ClaimFailed }
    }

    /// Writes `verdicts.csv`: figure, claim, measured, error, range, and `holds` as true or false.
    pub fn write_csv(&self, directory: &Path) -> Result<(), Failure> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(COLUMNS)?;
        for verdict in &self.0 {
            writer.write_record([
                verdict.figure.clone(),
                verdict.claim.clone(),
                verdict.measured.mean.to_string(),
                verdict.measured.standard_error.to_string(),
                verdict.lowest.to_string(),
                verdict.highest.to_string(),
                verdict.holds().to_string(),
            ])?;
        }
        output::write(&directory.join("verdicts.csv"), writer.into_inner()?)
    }
}

impl fmt::Display for Verdicts {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table = Table::new(["figure: claim", "measured", "must be", "holds"]);
        for verdict in &self.0 {
            let holds = if verdict.holds() { "yes" } else { "NO" };
            let label = format!("{}: {}", verdict.figure, verdict.claim);
            table.row(&label, [verdict.measured_in_words(), verdict.range(), holds.to_owned()]);
        }
        let held = self.0.iter().filter(|verdict| verdict.holds()).count();
        writeln!(formatter, "{table}{held} of {} claims hold", self.0.len())
    }
}

/// Four significant digits.
fn brief(value: f64) -> String {
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    format!("{rounded}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn holds(claim: impl FnOnce(&mut Verdicts)) -> bool {
        let mut verdicts = Verdicts::new();
        claim(&mut verdicts);
        verdicts.ending() == Ending::Finished
    }

    #[test]
    fn a_claim_holds_in_its_range_and_what_was_not_measured_nowhere() {
        let measured = |mean: f64| Estimate::new(mean, 0.1);
        assert!(holds(|verdicts| verdicts.at_most("1", "small", measured(1.0), 1.0)));
        assert!(!holds(|verdicts| verdicts.at_most("1", "small", measured(1.1), 1.0)));
        assert!(holds(|verdicts| verdicts.at_least("1", "large", measured(1.1), 1.0)));
        for range in [(-1.0, 1.0), (f64::NEG_INFINITY, f64::INFINITY)] {
            let unknown = Estimate::new(f64::NAN, 0.1);
            assert!(!holds(|verdicts| verdicts.between("1", "something", unknown, range.0, range.1)));
        }
        assert!(holds(|verdicts| verdicts.is_so("1", "so", true)));
        assert!(!holds(|verdicts| verdicts.is_so("1", "so", false)));
        assert!(!holds(|_| ()), "a study without a claim fails");
    }

    #[test]
    fn agreement_needs_an_error_bar_that_says_something() {
        let agrees = |mean: f64, error: f64| {
            holds(|verdicts| verdicts.agrees("1", "as expected", Estimate::new(mean, error), (2.0, 4.0), 0.1))
        };
        assert!(agrees(2.3, 0.1) && !agrees(2.5, 0.1));
        assert!(!agrees(2.0, 0.2) && !agrees(2.0, f64::NAN) && !agrees(2.1, 0.0));
    }

    #[test]
    fn ranges_and_numbers_in_words() {
        let verdict = |lowest: f64, highest: f64| Verdict {
            figure: "1".into(),
            claim: String::new(),
            measured: Estimate::new(0.123_456, 0.0),
            lowest,
            highest,
        };
        assert_eq!(verdict(-1.0, 2.0).range(), "-1 to 2");
        assert_eq!(verdict(f64::NEG_INFINITY, 0.333_333).range(), "at most 0.3333");
        assert_eq!(verdict(1.0, f64::INFINITY).range(), "at least 1");
        assert_eq!(verdict(1.0, 2.0).measured_in_words(), "0.1235");
    }
}
