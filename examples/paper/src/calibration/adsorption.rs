//! By how much the column above the layers lies too high or too low, since a formula holds a wrong
//! number of spheres in them; and how well all that is expected of the functional describes it.

use super::data::Formula;
use super::fit::is;
use super::functional::DENSE;
use super::scenes::Parameters;
use crate::Failure;
use gradient_mc::equation_of_state::ModifiedKolafa;
use gradient_mc::model::constants::{ADSORPTION, FUNCTIONAL_ADSORPTION};
use gradient_mc::model::{Accuracy, Assessment, Cause, Model, Quantity};

/// Places of theory and functional among the formulas.
const FORMULAS: [usize; 2] = [1, 2];
/// Below what is expected of a formula nearly anywhere, so that the functional is asked for.
const SMALL: f64 = 1e-4;

/// A formula against a column, with what the library expects.
struct Row {
    quantity: usize,
    formula: usize,
    /// Packing fraction at the base.
    eta: f64,
    error: f64,
    noise: f64,
    expected: f64,
    /// Error by adsorption alone in units of its distance, and everything else.
    unit: f64,
    rest: f64,
}

/// All of them.
pub(super) struct Rows(Vec<Row>);

impl Rows {
    pub(super) fn new(formulas: &[Formula]) -> Result<Self, Failure> {
        let mut rows = Vec::new();
        for (column, parameters) in Parameters::calibration().into_iter().enumerate() {
            let (particles, side) = Parameters::WIDE;
            let scene = parameters.scene(particles, side)?;
            let eta = scene.hydrostatics(&ModifiedKolafa)?.base_packing_fraction();
            for (quantity, asked) in Quantity::ALL.into_iter().enumerate() {
                let choice = scene.model_for(Accuracy::new(asked, SMALL)?)?;
                for formula in FORMULAS {
                    let is_it = |candidate: &&Assessment| match candidate.model {
                        Model::Hydrostatics(_) => formula == 1,
                        Model::DensityFunctional(_) => formula == 2,
                        _ => false,
                    };
                    let of_it = |row: &&Formula| {
                        is(row.column, column) && is(row.quantity, quantity) && is(row.formula, formula)
                    };
                    // The functional is not asked for where the theory is so good.
                    let (Some(candidate), Some(row)) =
                        (choice.candidates().iter().find(is_it), formulas.iter().find(of_it))
                    else {
                        continue;
                    };
                    let quadrature = |is_adsorption: bool| {
                        let causes = candidate.causes.iter();
                        let ours = causes.filter(|(cause, _)| (*cause == Cause::Adsorption) == is_adsorption);
                        ours.fold(0.0_f64, |sum, (_, error)| sum.hypot(*error))
                    };
                    let distance = match formula {
                        1 => ADSORPTION * eta,
                        _ => (FUNCTIONAL_ADSORPTION[0] * sixth(eta)).hypot(FUNCTIONAL_ADSORPTION[1] * eta),
                    };
                    rows.push(Row {
                        quantity,
                        formula,
                        eta,
                        error: row.error,
                        noise: row.noise,
                        expected: candidate.expected_error,
                        unit: quadrature(true) / distance,
                        rest: quadrature(false),
                    });
                }
            }
        }
        Ok(Self(rows))
    }

    /// Packing fractions, squares of the distances that P tells, and their errors.
    fn squares(&self, formula: usize) -> impl Iterator<Item = [f64; 3]> {
        self.0.iter().filter(move |row| row.formula == formula && row.quantity == 1).map(|row| {
            let square = |value: f64| value * value / (row.unit * row.unit);
            [row.eta, square(row.error) - square(row.noise) - square(row.rest), square(row.noise)]
        })
    }

    /// Of the theory: a distance in proportion to η.
    pub(super) fn of_theory(&self) -> f64 {
        /// What columns differ by, in units of the mean square.
        const SCATTER: f64 = 3e-3;
        let squares = self.squares(1).map(|[eta, square, error]| [square, error].map(|it| it / (eta * eta)));
        mean(squares, SCATTER)[0].max(0.0).sqrt()
    }

    /// Of the functional: of η⁶, from dense columns, and of η, which the others do not resolve.
    pub(super) fn of_functional(&self) -> [f64; 2] {
        /// As above.
        const SCATTER: f64 = 3.0;
        let power = |eta: f64| sixth(eta) * sixth(eta);
        let dense = self.squares(2).filter(|[eta, ..]| *eta > DENSE);
        let dense = dense.map(|[eta, square, error]| [square, error].map(|it| it / power(eta)));
        let factor = mean(dense, SCATTER)[0].max(0.0);
        let rest = self
            .squares(2)
            .filter(|[eta, ..]| *eta <= DENSE)
            .map(|[eta, square, error]| [square - factor * power(eta), error].map(|it| it / (eta * eta)));
        let [rest, error] = mean(rest, 0.0);
        [factor.sqrt(), (rest.max(0.0) + error).sqrt()]
    }

    /// What the expected errors of the functional may become in n, P and Z: two standard deviations
    /// of errors that are Gaussian about nothing, since most are lost in the noise of the columns.
    /// The mean square in excess of that, and one standard error more.
    pub(super) fn allowances(&self) -> [f64; 3] {
        [0, 1, 2].map(|quantity| {
            let rows = self.0.iter().filter(|row| row.formula == 2 && row.quantity == quantity);
            let squares = rows.map(|row| {
                let [error, noise] = [row.error, row.noise].map(|it| it * it / (row.expected * row.expected));
                [error - noise, noise]
            });
            let [square, error] = mean(squares, 1.0);
            2.0 * (square.max(0.0) + error).sqrt()
        })
    }
}

/// η⁶.
fn sixth(eta: f64) -> f64 {
    let cube = eta * eta * eta;
    cube * cube
}

/// Mean of values with errors, and the scatter beside these; and its error.
fn mean(values: impl Iterator<Item = [f64; 2]>, scatter: f64) -> [f64; 2] {
    let (mut sum, mut weights) = (0.0, 0.0);
    for [value, error] in values {
        let weight = 1.0 / (error * error + scatter * scatter);
        sum += weight * value;
        weights += weight;
    }
    [sum / weights, 1.0 / weights.sqrt()]
}
