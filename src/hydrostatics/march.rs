//! Integration of ln P upwards from the base.
//!
//! d ln P/dx = −a/(T Z), with η from P/T. The temperature itself enters, not its derivative, so T
//! may jump. A panel holds the values at Gauss nodes that satisfy the integral equation
//! (collocation, order 32), and is halved until the Legendre series of ln n has decayed. A panel
//! with a jump of T, or of η at a phase transition, is narrowed to the limit of rounding.

use crate::equation_of_state::{DomainSide, EquationOfState, number_density};
use crate::field::{END_MARGIN, acceleration_below};
use crate::legendre::{Legendre, ORDER, Series, evaluate};
use crate::{Error, Field, TemperatureProfile};
use std::cell::Cell;

/// Largest coefficient allowed among the last of the series of ln n.
const TAIL_TOLERANCE: f64 = 1e-11;
/// The same, when halving a panel no longer helps: rounding in a field or an equation of state.
const NOISE_TOLERANCE: f64 = 1e-9;
/// Largest change of ln P over a panel.
const LARGEST_DROP: f64 = 3.0;
/// The column ends where ln P has fallen this far below its maximum: P is 1e-300 of it.
const LOGARITHM_OF_NOTHING: f64 = 690.0;
/// A column that reaches this height has no end.
const HIGHEST_CLIMB: f64 = 1e9;
/// At [`HIGHEST_CLIMB`] a column counts as held if ln P has fallen this far.
const DROP_THAT_COUNTS_AS_HELD: f64 = 60.0;
/// Panels of up to this many rounding widths may lose the fall of ln P in rounding.
const MOST_STAGNANT: f64 = 1024.0;
/// Largest number of panels.
const MOST_PANELS: usize = 20_000;
/// Largest number of trials of all marches of one solution, which bounds the time. A temperature
/// that doubles with every half diameter needs about a tenth.
const MOST_TRIALS: u32 = 60_000;
/// A tail above this is not that of a solution.
const SENSELESS: f64 = 1e3;
/// Such a trial counts as this many more, because its states are the slowest to find.
const COST_OF_SENSELESS: u32 = 25;
/// Outside this range of ln(P/T) the gas is ideal to rounding, or the number is out of range.
const LOGARITHMIC_RANGE: f64 = 650.0;

/// A panel of the column, solved to rounding.
#[derive(Debug, Clone)]
pub(super) struct Panel {
    pub(super) start: f64,
    pub(super) end: f64,
    /// Series of ln n.
    pub(super) ln_density: Series,
    /// Series of ln P.
    pub(super) ln_pressure: Series,
    /// Series of n.
    pub(super) density: Series,
    /// Whether this is a panel of rounding width around a jump, where the series is meaningless.
    pub(super) jump: bool,
    /// Density at the start and the end.
    pub(super) edges: [f64; 2],
    /// ∫ n dx over the panel.
    pub(super) mass: f64,
    /// ∫ (x − base) n dx over the panel.
    pub(super) moment: f64,
}

/// The scene that is integrated.
#[derive(Debug)]
pub(super) struct Column<'a, F, T, E> {
    pub(super) field: &'a F,
    pub(super) temperature: &'a T,
    pub(super) equation_of_state: &'a E,
    pub(super) base: f64,
    /// Height of the lid; `None` is open.
    pub(super) lid: Option<f64>,
    pub(super) rule: Legendre,
    /// Trials so far.
    pub(super) trials: Cell<u32>,
}

/// A tentative panel, with the numbers to accept it and to go on.
struct Trial {
    panel: Panel,
    tail: f64,
    ln_pressure_at_end: f64,
    packing_fraction_at_end: Option<f64>,
}

/// Z of a state, and its packing fraction unless the gas is ideal to rounding.
struct State {
    factor: f64,
    packing_fraction: Option<f64>,
}

impl<F: Field, T: TemperatureProfile, E: EquationOfState> Column<'_, F, T, E> {
    /// The acceleration.
    fn pull(&self, height: f64) -> f64 {
        acceleration_below(self.field, height, self.lid.unwrap_or(f64::INFINITY))
    }

    /// The acceleration, checked.
    fn acceleration(&self, height: f64) -> Result<f64, Error> {
        let acceleration = self.pull(height);
        if acceleration.is_finite() {
            return Ok(acceleration);
        }
        Err(Error::InvalidField { height, acceleration, potential: self.field.potential(height) })
    }

    /// The temperature, checked.
    pub(super) fn temperature(&self, height: f64) -> Result<f64, Error> {
        let temperature = self.temperature.temperature(height);
        if temperature.is_finite() && temperature > 0.0 {
            return Ok(temperature);
        }
        Err(Error::InvalidTemperature { height, temperature })
    }

    /// The state at a given ln P/T.
    fn state(&self, height: f64, ln_reduced_pressure: f64, guess: Option<f64>) -> Result<State, Error> {
        let reduced_pressure = libm::exp(ln_reduced_pressure);
        let exhausted = || {
            let lowest = self.equation_of_state.domain().lowest;
            let end = number_density(lowest) * self.equation_of_state.compressibility_factor(lowest);
            let side = if reduced_pressure < end { DomainSide::Below } else { DomainSide::Above };
            Error::EquationOfStateExhausted { height, reduced_pressure, side }
        };
        if ln_reduced_pressure < -LOGARITHMIC_RANGE {
            // Ideal to rounding, unless the domain of the equation ends at a higher density.
            let ends = self.equation_of_state.domain().lowest > 0.0;
            return if ends { Err(exhausted()) } else { Ok(State { factor: 1.0, packing_fraction: None }) };
        }
        if ln_reduced_pressure > LOGARITHMIC_RANGE || ln_reduced_pressure.is_nan() {
            return Err(exhausted());
        }
        let eta =
            self.equation_of_state.packing_fraction_at(reduced_pressure, guess).ok_or_else(exhausted)?;
        let factor = self.equation_of_state.compressibility_factor(eta);
        if factor > 0.0 && factor.is_finite() {
            Ok(State { factor, packing_fraction: Some(eta) })
        } else {
            Err(exhausted())
        }
    }

    /// The packing fraction at the base for a given pressure there.
    pub(super) fn packing_fraction_at_base(&self, ln_pressure: f64) -> Result<f64, Error> {
        let ln_reduced_pressure = ln_pressure - libm::log(self.temperature(self.base)?);
        let state = self.state(self.base, ln_reduced_pressure, None)?;
        Ok(state
            .packing_fraction
            .unwrap_or_else(|| crate::equation_of_state::packing_fraction(libm::exp(ln_reduced_pressure))))
    }

    /// All panels of the column with the given ln P at the base.
    pub(super) fn march(&self, ln_base_pressure: f64) -> Result<Vec<Panel>, Error> {
        let mut panels: Vec<Panel> = Vec::with_capacity(512);
        let (mut height, mut ln_pressure, mut highest) = (self.base, ln_base_pressure, ln_base_pressure);
        let mut guess = None;
        // The width of the next attempt, and the tail of the last rejected one.
        let (mut width, mut rejected_tail) = (f64::INFINITY, f64::INFINITY);
        // Just before a jump, panels may become so narrow that the fall of ln P is lost in
        // rounding. Then the next panel may be this wide, to step over the jump.
        let mut stagnant = 0.0;
        let mut attempts = 0;
        loop {
            if self.lid.is_some_and(|lid| height >= lid) || highest - ln_pressure > LOGARITHM_OF_NOTHING {
                return Ok(panels);
            }
            let climb = height - self.base;
            if self.lid.is_none() && climb > HIGHEST_CLIMB {
                if highest - ln_pressure > DROP_THAT_COUNTS_AS_HELD {
                    return Ok(panels);
                }
                return Err(Error::UnboundedColumn { height, pressure: libm::exp(ln_pressure) });
            }
            attempts += 1;
            self.trials.set(self.trials.get() + 1);
            let beyond = attempts > 2 * MOST_PANELS || panels.len() > MOST_PANELS;
            if beyond || self.trials.get() > MOST_TRIALS {
                let residual = if rejected_tail.is_finite() { rejected_tail } else { 0.0 };
                return Err(Error::HydrostaticsNotConverged { height, residual });
            }
            // Near the base, nodes resolve features wider than half a diameter.
            let resolution = 4.0 * f64::EPSILON * height.abs().max(1.0);
            width = width.min(2.0 + 0.02 * climb).max(resolution);
            let end = match self.lid {
                // Avoid a very narrow last panel below the lid.
                Some(lid) if height + 1.001 * width >= lid => lid,
                _ => height + width,
            };
            let rounding = 64.0 * f64::EPSILON * end.abs().max(height.abs()).max(1.0);
            let at_limit = end - height <= f64::max(stagnant, rounding);
            let trial = match self.trial(height, end, ln_pressure, guess) {
                Ok(trial) => trial,
                // The iteration may have left the range of the true solution.
                Err(Error::EquationOfStateExhausted { .. }) if !at_limit => {
                    rejected_tail = f64::INFINITY;
                    width = 0.5 * (end - height);
                    continue;
                }
                Err(error) => return Err(error),
            };
            if trial.tail > SENSELESS || trial.tail.is_nan() {
                self.trials.set(self.trials.get() + COST_OF_SENSELESS);
            }
            let drop = (trial.ln_pressure_at_end - ln_pressure).abs();
            // The tolerance grows toward the thin top, where rounding errors of a steep scene grow.
            let noise = NOISE_TOLERANCE * libm::exp((0.1 * (highest - ln_pressure)).clamp(0.0, 14.0));
            let smooth =
                trial.tail <= TAIL_TOLERANCE || (trial.tail <= noise && trial.tail > 0.25 * rejected_tail);
            // NaN fails this comparison and is halved down to the limit.
            let accepted = smooth && drop <= 1.2 * LARGEST_DROP;
            if !accepted && !at_limit {
                rejected_tail = trial.tail;
                width = 0.5 * (end - height);
                continue;
            }
            if !trial.ln_pressure_at_end.is_finite() {
                return Err(Error::HydrostaticsNotConverged { height, residual: trial.tail });
            }
            let mut panel = trial.panel;
            panel.jump = !accepted;
            panels.push(panel);
            // Widen at once, unless this panel was halved: the feature that required this is just
            // ahead.
            let halved = rejected_tail.is_finite() && trial.tail <= TAIL_TOLERANCE;
            let growth = if halved { 1.0 } else { 4.0 };
            let slope = drop / (end - height);
            width = (growth * (end - height)).min(LARGEST_DROP / slope.max(1e-300));
            let lost = drop == 0.0 && end - height <= MOST_STAGNANT * rounding;
            stagnant = if lost { 4.0 * (end - height) } else { 0.0 };
            rejected_tail = f64::INFINITY;
            height = end;
            ln_pressure = trial.ln_pressure_at_end;
            highest = highest.max(ln_pressure);
            guess = trial.packing_fraction_at_end.or(guess);
        }
    }

    /// Solves the integral equation on one panel by Picard iteration, which contracts because Z
    /// changes much less than P.
    fn trial(&self, start: f64, end: f64, ln_pressure: f64, guess: Option<f64>) -> Result<Trial, Error> {
        const MOST_ITERATIONS: usize = 40;
        let half = 0.5 * (end - start);
        let heights = self.rule.nodes.map(|t| (start + half * (t + 1.0)).min(end));
        let mut pull = [0.0; ORDER];
        let mut ln_temperature = [0.0; ORDER];
        for ((&height, pull), logarithm) in heights.iter().zip(&mut pull).zip(&mut ln_temperature) {
            let temperature = self.temperature(height)?;
            *pull = self.acceleration(height)? / temperature;
            *logarithm = libm::log(temperature);
        }
        let mut ln_pressures = [ln_pressure; ORDER];
        let mut guesses = [guess; ORDER];
        let mut factors = [1.0; ORDER];
        let mut slopes = [0.0; ORDER];
        let mut change = f64::INFINITY;
        for _ in 0..MOST_ITERATIONS {
            for i in 0..ORDER {
                let state = self.state(heights[i], ln_pressures[i] - ln_temperature[i], guesses[i])?;
                guesses[i] = state.packing_fraction.or(guesses[i]);
                factors[i] = state.factor;
                slopes[i] = -pull[i] / state.factor;
            }
            let rises = self.rule.integrate_to_nodes(&slopes);
            change = 0.0;
            for (value, rise) in ln_pressures.iter_mut().zip(rises) {
                let new = ln_pressure + half * rise;
                change = change.max((new - *value).abs());
                *value = new;
            }
            if change <= 1e-14 * ln_pressure.abs().max(1.0) {
                break;
            }
        }
        let ln_densities: Series =
            std::array::from_fn(|i| ln_pressures[i] - ln_temperature[i] - libm::log(factors[i]));
        let densities = ln_densities.map(libm::exp);
        let mass = half * self.rule.integrate(&densities);
        let moments: Series = std::array::from_fn(|i| (heights[i] - self.base) * densities[i]);
        let ln_density = self.rule.coefficients(&ln_densities);
        let ln_pressure_series = self.rule.coefficients(&ln_pressures);
        let ln_pressure_at_end = ln_pressure + half * self.rule.integrate(&slopes);
        // The outermost nodes lie inside the panel: a jump beyond them shows only at the ends.
        let pull_series = self.rule.coefficients(&pull);
        let mut edges = [0.0; 2];
        let mut mismatch = 0.0_f64;
        for (edge, height, t, value, node) in
            [(0, start, -1.0, ln_pressure, 0), (1, end, 1.0, ln_pressure_at_end, ORDER - 1)]
        {
            let temperature = self.temperature(height)?;
            let ln_reduced_pressure = value - libm::log(temperature);
            let state = self.state(height, ln_reduced_pressure, guesses[node])?;
            let ln_density_here = ln_reduced_pressure - libm::log(state.factor);
            edges[edge] = libm::exp(ln_density_here);
            let pull_here = self.acceleration(height)? / temperature;
            mismatch = mismatch
                .max((ln_density_here - evaluate(&ln_density, t)).abs())
                .max(half * (pull_here - evaluate(&pull_series, t)).abs());
        }
        // An unconverged iteration counts like an unconverged series.
        let tail = ln_density[ORDER - 3..].iter().fold(change.max(mismatch), |tail, coefficient| {
            if coefficient.is_nan() { f64::NAN } else { tail.max(coefficient.abs()) }
        });
        let panel = Panel {
            start,
            end,
            ln_density,
            ln_pressure: ln_pressure_series,
            density: self.rule.coefficients(&densities),
            jump: false,
            edges,
            mass,
            moment: half * self.rule.integrate(&moments),
        };
        Ok(Trial { panel, tail, ln_pressure_at_end, packing_fraction_at_end: guesses[ORDER - 1] })
    }

    /// Height and number density of the densest point of a solved column.
    pub(super) fn densest(&self, panels: &[Panel]) -> (f64, f64) {
        // Candidates: ends and nodes of all panels, in rising order.
        let samples: Vec<(usize, f64)> = panels
            .iter()
            .enumerate()
            .filter(|(_, panel)| !panel.jump)
            .flat_map(|(index, _)| {
                std::iter::once(-1.0)
                    .chain(self.rule.nodes)
                    .chain(std::iter::once(1.0))
                    .map(move |t| (index, t))
            })
            .collect();
        let value = |&(index, t): &(usize, f64)| evaluate(&panels[index].ln_density, t);
        let height = |&(index, t): &(usize, f64)| panels[index].height(t);
        let mut best = 0;
        let mut highest = f64::NEG_INFINITY;
        for (index, sample) in samples.iter().enumerate() {
            // A small margin prefers the lower point, so that rounding does not lift a flat
            // maximum.
            if value(sample) > highest + 1e-14 {
                (best, highest) = (index, value(sample));
            }
        }
        let Some(sample) = samples.get(best) else {
            return (self.base, 0.0);
        };
        let mut result = (height(sample), highest);
        let low = samples.get(best.saturating_sub(1)).map_or(result.0, height);
        let high = samples.get(best + 1).map_or(result.0, height);
        if let Some(refined) = self.refine_maximum(panels, low, high)
            && refined.1 >= result.1 - 1e-12
        {
            result = refined;
        }
        (result.0, libm::exp(result.1))
    }

    /// The interior maximum between two heights, where a/(TZ) + d ln T/dx changes sign.
    ///
    /// That is the condition of eq. (7) of doi:10.1103/PhysRevE.83.061306; it fixes the height much
    /// better than comparing densities, which are flat there.
    fn refine_maximum(&self, panels: &[Panel], mut low: f64, mut high: f64) -> Option<(f64, f64)> {
        let locate = |x: f64| {
            let index = panels.partition_point(|panel| panel.end <= x).min(panels.len() - 1);
            (&panels[index], panels[index].abscissa(x))
        };
        let decline = |x: f64| {
            let (panel, t) = locate(x);
            let factor = libm::exp(evaluate(&panel.ln_pressure, t) - evaluate(&panel.ln_density, t));
            let below = self.lid.map_or(x, |lid| x.min(lid - END_MARGIN).max(self.base));
            self.pull(x) / factor + self.temperature.logarithmic_gradient(below)
        };
        if !(low < high && decline(low) < 0.0 && decline(high) > 0.0) {
            return None;
        }
        for _ in 0..80 {
            let middle = 0.5 * (low + high);
            if decline(middle) < 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        let x = 0.5 * (low + high);
        let (panel, t) = locate(x);
        // At a jump the sign changes without a maximum; its neighbors are candidates already.
        (!panel.jump).then(|| (x, evaluate(&panel.ln_density, t)))
    }
}

impl Panel {
    /// Height of the point t of [−1, 1].
    pub(super) fn height(&self, t: f64) -> f64 {
        if t >= 1.0 { self.end } else { self.start + 0.5 * (self.end - self.start) * (t + 1.0) }
    }

    /// The point of [−1, 1] at a height.
    pub(super) fn abscissa(&self, height: f64) -> f64 {
        (2.0 * (height - self.start) / (self.end - self.start) - 1.0).clamp(-1.0, 1.0)
    }
}
