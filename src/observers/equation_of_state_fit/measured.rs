//! The measured equation of state.

use super::least_squares::LeastSquares;
use crate::equation_of_state::{Domain, EquationOfState, MOST_TERMS, Series};
use crate::statistics::{Estimate, Jackknife, chi_squared_quantile, share_of_first};
use crate::{Error, Warning};
use nalgebra::DVector;
use std::f64::consts::PI;

/// Smallest number of terms of a fit.
pub(super) const FEWEST_TERMS: usize = 3;

/// One of the two routes to Z.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Route {
    Ranks,
    Collisions,
}

/// Coefficients of both routes for every number of terms, in one list; NaN if there is no fit.
pub(super) fn fits(mut fit: impl FnMut(Route, usize) -> Option<Vec<f64>>) -> Vec<f64> {
    let mut values = Vec::new();
    for terms in FEWEST_TERMS..=MOST_TERMS {
        for route in [Route::Ranks, Route::Collisions] {
            let mut coefficients = fit(route, terms).unwrap_or_else(|| vec![f64::NAN]);
            coefficients.resize(MOST_TERMS, 0.0);
            values.append(&mut coefficients);
        }
    }
    values
}

/// The series of one route in this list.
fn fitted(values: &[f64], route: Route, terms: usize) -> Series {
    let first = MOST_TERMS * (2 * (terms - FEWEST_TERMS) + usize::from(route == Route::Collisions));
    Series::new(&values[first..first + MOST_TERMS])
}

/// Equation of state Z(η) with errors, measured in a run or in merged replicas by an
/// [`EquationOfStateFit`](super::EquationOfStateFit).
///
/// The number of terms of the fits is the smallest, at least three, for which one more term changes
/// Z by at most four standard errors of the change at all densities. The two routes are combined
/// with the weights of the smallest variance, at as many packing fractions as there are terms. If
/// they disagree ([`warnings`](Self::warnings)), only the collisions are used, because they need
/// only local equilibrium.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredEquationOfState {
    jackknife: Jackknife,
    terms: usize,
    heights: [f64; 2],
    highest: f64,
    /// Packing fractions at which the routes are combined, and the weight of the ranks.
    shares: Vec<(f64, f64)>,
    too_steep: Option<Warning>,
    disagreement: Option<Warning>,
}

impl MeasuredEquationOfState {
    pub(super) fn new(
        jackknife: &Jackknife,
        heights: [f64; 2],
        highest: f64,
        too_steep: Option<Warning>,
    ) -> Self {
        let of = |terms| {
            let mut measured = Self {
                jackknife: jackknife.clone(),
                terms,
                heights,
                highest,
                shares: Vec::new(),
                too_steep: None,
                disagreement: None,
            };
            measured.combine();
            measured
        };
        let mut measured = of(FEWEST_TERMS);
        while measured.terms < MOST_TERMS {
            let richer = of(measured.terms + 1);
            if !richer.differs_from(&measured) {
                break;
            }
            measured = richer;
        }
        measured.too_steep = too_steep;
        measured
    }

    /// Whether Z differs at some density by more than four standard errors of the difference.
    fn differs_from(&self, poorer: &Self) -> bool {
        const LARGEST: f64 = 4.0;
        let etas: Vec<f64> = (1..=16).map(|step| self.highest * f64::from(step) / 16.0).collect();
        let changes = self.jackknife.estimates(|values| {
            let [rich, poor] = [self, poorer].map(|fit| fit.series(values, None));
            let change = |&eta: &f64| rich.compressibility_factor(eta) - poor.compressibility_factor(eta);
            etas.iter().map(change).collect::<Vec<f64>>()
        });
        changes.iter().any(|change| change.deviation_from(0.0).abs() > LARGEST)
    }

    /// Computes the weights of the routes at Chebyshev nodes.
    fn combine(&mut self) {
        let count = self.terms;
        let angle = |node: usize| PI * (node as f64 + 0.5) / count as f64;
        let etas: Vec<f64> =
            (0..count).map(|node| 0.5 * self.highest * (1.0 - libm::cos(angle(node)))).collect();
        let both = |values: &[f64]| -> [Vec<f64>; 2] {
            [Route::Ranks, Route::Collisions].map(|route| {
                let series = fitted(values, route, count);
                etas.iter().map(|&eta| series.compressibility_factor(eta)).collect()
            })
        };
        let differences = |values: &[f64]| -> Vec<f64> {
            let [ranks, collisions] = both(values);
            ranks.iter().zip(&collisions).map(|(one, other)| one - other).collect()
        };
        let known = self.jackknife.estimates(|values| both(values).concat());
        let (ranks, collisions) = known.split_at(count);
        let apart = self.jackknife.estimates(differences);
        let square = |estimate: &Estimate| estimate.standard_error * estimate.standard_error;
        let is_known = |route: &[Estimate]| route.iter().all(|factor| factor.standard_error.is_finite());
        let part = |node: usize| match (is_known(ranks), is_known(collisions)) {
            (true, true) => {
                let [r, c, d] = [&ranks[node], &collisions[node], &apart[node]].map(square);
                share_of_first(r, c, d)
            }
            (true, false) => 1.0,
            (false, _) => 0.0,
        };
        self.shares = etas.iter().enumerate().map(|(node, &eta)| (eta, part(node))).collect();
        let covariance = self.jackknife.covariance(differences);
        let difference = DVector::from_iterator(count, apart.iter().map(|estimate| estimate.mean));
        let Some(solved) = covariance.cholesky().map(|factor| factor.solve(&difference)) else { return };
        let chi_squared = difference.dot(&solved);
        if chi_squared > chi_squared_quantile(count, 4.0) {
            let distance = |node: &usize| apart[*node].deviation_from(0.0).abs();
            let worst =
                (0..count).max_by(|one, other| distance(one).total_cmp(&distance(other))).unwrap_or(0);
            self.disagreement = Some(Warning::RoutesDisagree {
                packing_fraction: etas[worst],
                ranks: ranks[worst],
                collisions: collisions[worst],
            });
            for (_, share) in &mut self.shares {
                *share = 0.0;
            }
        }
    }

    /// The series of one route, or of both combined.
    fn series(&self, values: &[f64], route: Option<Route>) -> Series {
        if let Some(route) = route {
            return fitted(values, route, self.terms);
        }
        let routes = [Route::Ranks, Route::Collisions].map(|route| fitted(values, route, self.terms));
        let mut equations = LeastSquares::new(self.terms);
        for &(eta, share) in &self.shares {
            // A route with weight 0 may be NaN.
            let weighed = routes.iter().zip([share, 1.0 - share]).filter(|&(_, share)| share > 0.0);
            let excess: f64 =
                weighed.map(|(series, share)| share * (series.compressibility_factor(eta) - 1.0)).sum();
            equations.add(&Series::terms(eta)[..self.terms], excess, 1.0 / (excess * excess));
        }
        equations.solve().map_or(Series::new(&[f64::NAN]), |solution| Series::new(&solution))
    }

    /// Z from both routes combined.
    #[must_use]
    pub fn combined(&self) -> EquationOfStateCurve<'_> {
        self.curve(None)
    }

    /// Z from ranks alone; NaN if they do not determine it, as in a box without a field.
    #[must_use]
    pub fn ranks(&self) -> EquationOfStateCurve<'_> {
        self.curve(Some(Route::Ranks))
    }

    /// Z from collisions alone; NaN without event chains.
    #[must_use]
    pub fn collisions(&self) -> EquationOfStateCurve<'_> {
        self.curve(Some(Route::Collisions))
    }

    fn curve(&self, route: Option<Route>) -> EquationOfStateCurve<'_> {
        EquationOfStateCurve { measured: self, route, series: self.series(self.jackknife.values(), route) }
    }

    /// The range of heights that is used, in diameters, without the layers at the walls.
    #[must_use]
    pub fn heights(&self) -> [f64; 2] {
        self.heights
    }

    /// The largest packing fraction in this range. Curves can be evaluated from 0 to this value.
    #[must_use]
    pub fn highest_packing_fraction(&self) -> f64 {
        self.highest
    }

    /// Number of coefficients of each fit.
    #[must_use]
    pub fn terms(&self) -> usize {
        self.terms
    }

    /// [`Warning::RoutesDisagree`] if the two routes differ significantly, by a χ² test at the
    /// level of four standard deviations. [`Warning::SteepGradient`] if more than a tenth of the
    /// spheres are at heights where the density changes by more than e within about three
    /// diameters, because the packing fractions of the collisions are smoothed too much there.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        self.too_steep.iter().chain(&self.disagreement).cloned().collect()
    }
}

/// A curve Z(η) of a [`MeasuredEquationOfState`], with errors. It is an [`EquationOfState`].
///
/// Packing fractions must be between 0 and [the highest
/// measured](MeasuredEquationOfState::highest_packing_fraction).
///
/// ```
/// use gradient_mc::EquationOfState;
/// use gradient_mc::observers::EquationOfStateFit;
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// let scene = Scene::new(Slab::new(60.0, 4.0, 4.0)?, 160, UniformField::default(), Isothermal::new(5.0)?)?;
/// let mut simulation = Simulation::builder(scene).seed(1).build()?;
/// let mut fit = EquationOfStateFit::new(&scene)?;
/// simulation.equilibrate(200, &mut ())?;
/// simulation.run(1024, &mut fit)?;
/// let measured = fit.result()?;
/// let curve = measured.combined();
/// let factor = curve.compressibility_factor_at(&[0.1])?[0];
/// // Z = 1.522 by the modified Kolafa equation.
/// assert!(factor.deviation_from(1.522).abs() < 4.0 && factor.standard_error < 0.1, "{factor}");
/// // Without errors it is an equation of state like any other.
/// assert!((curve.compressibility_factor(0.1) - factor.mean).abs() < 1e-9);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct EquationOfStateCurve<'a> {
    measured: &'a MeasuredEquationOfState,
    route: Option<Route>,
    series: Series,
}

impl EquationOfStateCurve<'_> {
    fn each(&self, values: &[f64], etas: &[f64], function: impl Fn(&Series, f64) -> f64) -> Vec<f64> {
        let series = self.measured.series(values, self.route);
        etas.iter().map(|&eta| function(&series, eta)).collect()
    }

    fn require_measured(&self, packing_fractions: &[f64]) -> Result<(), Error> {
        match packing_fractions.iter().find(|eta| !(0.0..=self.measured.highest).contains(*eta)) {
            None => Ok(()),
            Some(&value) => {
                let requirement =
                    "it must lie between 0 and the largest one measured (highest_packing_fraction)";
                Err(Error::InvalidParameter { name: "packing fraction", value, requirement })
            }
        }
    }

    fn estimates(
        &self,
        packing_fractions: &[f64],
        function: impl Fn(&Series, f64) -> f64,
    ) -> Result<Vec<Estimate>, Error> {
        self.require_measured(packing_fractions)?;
        let jackknife = &self.measured.jackknife;
        Ok(jackknife.estimates(|values| self.each(values, packing_fractions, &function)))
    }

    /// Compressibility factor Z = P/(nT) at packing fractions, with standard errors.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] for a packing fraction outside the measured range.
    pub fn compressibility_factor_at(&self, packing_fractions: &[f64]) -> Result<Vec<Estimate>, Error> {
        self.estimates(packing_fractions, Series::compressibility_factor)
    }

    /// Covariance matrix of Z at packing fractions, by rows.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] for a packing fraction outside the measured range.
    pub fn covariance_at(&self, packing_fractions: &[f64]) -> Result<Vec<Vec<f64>>, Error> {
        self.require_measured(packing_fractions)?;
        let covariance = self
            .measured
            .jackknife
            .covariance(|values| self.each(values, packing_fractions, Series::compressibility_factor));
        Ok(covariance.row_iter().map(|row| row.iter().copied().collect()).collect())
    }

    /// The isothermal compressibility over that of an ideal gas, n T κ = 1/(Z + dZ/d ln η), at
    /// packing fractions.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] for a packing fraction outside the measured range.
    pub fn reduced_compressibility_at(&self, packing_fractions: &[f64]) -> Result<Vec<Estimate>, Error> {
        self.estimates(packing_fractions, |series, eta| {
            1.0 / (series.compressibility_factor(eta) + series.compressibility_derivative(eta))
        })
    }

    /// Excess chemical potential over temperature, Z − 1 + ∫₀^η (Z − 1)/η′ dη′, at packing
    /// fractions.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] for a packing fraction outside the measured range.
    pub fn excess_chemical_potential_at(&self, packing_fractions: &[f64]) -> Result<Vec<Estimate>, Error> {
        self.estimates(packing_fractions, Series::excess_chemical_potential)
    }

    /// B₂, B₃ and B₄ of Z = 1 + B₂η + B₃η² + …; those of hard spheres are 4, 10 and 18.36. The
    /// errors are statistical. With three terms the form of the fit has additional errors of 0.2 %
    /// in B₂, 1 % in B₃ and 1.5 % in B₄.
    #[must_use]
    pub fn virial_coefficients(&self) -> Vec<Estimate> {
        let jackknife = &self.measured.jackknife;
        jackknife.estimates(|values| self.measured.series(values, self.route).virial_coefficients())
    }
}

/// Values without errors; outside the measured range the fit is extrapolated.
impl EquationOfState for EquationOfStateCurve<'_> {
    fn compressibility_factor(&self, packing_fraction: f64) -> f64 {
        self.series.compressibility_factor(packing_fraction)
    }
    fn compressibility_derivative(&self, packing_fraction: f64) -> f64 {
        self.series.compressibility_derivative(packing_fraction)
    }
    fn excess_chemical_potential(&self, packing_fraction: f64) -> f64 {
        self.series.excess_chemical_potential(packing_fraction)
    }
    fn domain(&self) -> Domain {
        Domain { lowest: 0.0, highest: self.measured.highest }
    }
}
