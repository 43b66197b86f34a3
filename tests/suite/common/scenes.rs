//! Random scenes, and their potentials by formulas and quadrature that owe nothing to the library.

use gradient_mc::equation_of_state::EquationOfState;
use gradient_mc::field::{ExponentialField, FieldFn, LinearField, SumField, UniformField};
use gradient_mc::temperature::{
    ExponentialTemperature, Isothermal, LinearTemperature, TabulatedTemperature, TemperatureFn,
};
use gradient_mc::{Field, Slab, TemperatureProfile};
use proptest::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// P = nT.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoInteraction;

impl EquationOfState for NoInteraction {
    fn compressibility_factor(&self, _packing_fraction: f64) -> f64 {
        1.0
    }
}

/// An equation of state of its own: the scaled-particle (Percus-Yevick compressibility) one.
#[derive(Debug, Clone, Copy, Default)]
pub struct ScaledParticle;

impl EquationOfState for ScaledParticle {
    fn compressibility_factor(&self, packing_fraction: f64) -> f64 {
        (1.0 + packing_fraction + packing_fraction * packing_fraction) / (1.0 - packing_fraction).powi(3)
    }
}

/// A field that counts how often its acceleration is asked for.
#[derive(Debug)]
pub struct Counted<F>(F, AtomicU64);

impl<F> Counted<F> {
    pub fn new(field: F) -> Self {
        Self(field, AtomicU64::new(0))
    }

    /// Evaluations since the last call.
    pub fn take(&self) -> u64 {
        self.1.swap(0, Ordering::Relaxed)
    }
}

impl<F: Field> Field for Counted<F> {
    fn potential(&self, height: f64) -> f64 {
        self.0.potential(height)
    }
    fn acceleration(&self, height: f64) -> f64 {
        self.1.fetch_add(1, Ordering::Relaxed);
        self.0.acceleration(height)
    }
}

/// ∫₀ˣ exp(rate x') dx'.
pub fn exponential_integral(rate: f64, height: f64) -> f64 {
    let exponent = rate * height;
    if exponent.abs() < 1e-5 {
        height * (1.0 + exponent * (0.5 + exponent / 6.0))
    } else {
        exponent.exp_m1() / rate
    }
}

/// Integral by `panels` panels of the three-point Gauss-Legendre rule.
pub fn integrate(f: impl Fn(f64) -> f64, low: f64, high: f64, panels: usize) -> f64 {
    let width = (high - low) / panels as f64;
    let node = 0.5 * width * 0.6_f64.sqrt();
    let panel = |index: usize| {
        let middle = low + (index as f64 + 0.5) * width;
        width * (5.0 * f(middle - node) + 8.0 * f(middle) + 5.0 * f(middle + node)) / 18.0
    };
    (0..panels).map(panel).sum()
}

/// A field of the library, chosen at random.
#[derive(Debug, Clone, Copy)]
pub enum FieldCase {
    Uniform(f64),
    Exponential(f64),
    Linear(f64, f64),
    Sum(f64, f64, f64),
    Wave(f64, f64),
}

impl FieldCase {
    pub fn make(self, slab: &Slab) -> Box<dyn Field> {
        match self {
            Self::Uniform(acceleration) => Box::new(UniformField::new(acceleration).unwrap()),
            Self::Exponential(rate) => Box::new(ExponentialField::new(rate).unwrap()),
            Self::Linear(base, slope) => Box::new(LinearField::new(base, slope).unwrap()),
            Self::Sum(rate, base, slope) => Box::new(SumField(
                ExponentialField::new(rate).unwrap(),
                LinearField::new(base, slope).unwrap(),
            )),
            Self::Wave(size, number) => {
                Box::new(FieldFn::new(move |height| 1.0 + size * (number * height).sin(), slab).unwrap())
            }
        }
    }

    pub fn acceleration(self, height: f64) -> f64 {
        match self {
            Self::Uniform(acceleration) => acceleration,
            Self::Exponential(rate) => (rate * height).exp(),
            Self::Linear(base, slope) => base + slope * height,
            Self::Sum(rate, base, slope) => (rate * height).exp() + base + slope * height,
            Self::Wave(size, number) => 1.0 + size * (number * height).sin(),
        }
    }

    /// The potential in closed form.
    pub fn potential(self, height: f64) -> f64 {
        match self {
            Self::Uniform(acceleration) => acceleration * height,
            Self::Exponential(rate) => exponential_integral(rate, height),
            Self::Linear(base, slope) => base * height + slope * height * height / 2.0,
            Self::Sum(rate, base, slope) => {
                exponential_integral(rate, height) + base * height + slope * height * height / 2.0
            }
            Self::Wave(size, number) => height + size * (1.0 - (number * height).cos()) / number,
        }
    }

    /// How far the library's potential may be from the closed form, relative: rounding, or for
    /// closures the interpolation error documented at `FieldFn`.
    pub fn accuracy(self) -> f64 {
        if matches!(self, Self::Wave(..)) { 1e-8 } else { 0.0 }
    }
}

/// A temperature profile of the library, chosen at random.
#[derive(Debug, Clone, Copy)]
pub enum TemperatureCase {
    Constant(f64),
    Exponential(f64, f64),
    Linear(f64, f64),
    Table(f64, f64, f64),
    Wave(f64, f64, f64),
}

impl TemperatureCase {
    pub fn make(self, height: f64) -> Box<dyn TemperatureProfile> {
        match self {
            Self::Constant(temperature) => Box::new(Isothermal::new(temperature).unwrap()),
            Self::Exponential(base, rate) => Box::new(ExponentialTemperature::new(base, rate).unwrap()),
            Self::Linear(base, top) => Box::new(LinearTemperature::new(base, (top - base) / height).unwrap()),
            Self::Table(base, middle, top) => Box::new(
                TabulatedTemperature::new(vec![(0.0, base), (0.5 * height, middle), (height, top)]).unwrap(),
            ),
            Self::Wave(base, size, number) => {
                Box::new(TemperatureFn(move |x: f64| base * (1.0 + size * (number * x).sin())))
            }
        }
    }
}

/// Fields that vary by at most a factor of some twenty over 60 diameters; some point up somewhere.
pub fn field_case() -> impl Strategy<Value = FieldCase> {
    prop_oneof![
        (-1.0..2.0).prop_map(FieldCase::Uniform),
        (-0.05..0.05).prop_map(FieldCase::Exponential),
        (-0.5..1.5, -0.02..0.03).prop_map(|(base, slope)| FieldCase::Linear(base, slope)),
        (-0.05..0.05, -0.5..0.5, -0.01..0.01)
            .prop_map(|(rate, base, slope)| FieldCase::Sum(rate, base, slope)),
        (0.1..1.5, 0.05..0.5).prop_map(|(size, number)| FieldCase::Wave(size, number)),
    ]
}

pub fn temperature_case() -> impl Strategy<Value = TemperatureCase> {
    let warm = || 3.0..40.0;
    prop_oneof![
        warm().prop_map(TemperatureCase::Constant),
        (warm(), -0.03..0.05).prop_map(|(base, rate)| TemperatureCase::Exponential(base, rate)),
        (warm(), warm()).prop_map(|(base, top)| TemperatureCase::Linear(base, top)),
        (warm(), warm(), warm()).prop_map(|(base, middle, top)| TemperatureCase::Table(base, middle, top)),
        (warm(), 0.1..0.7, 0.05..0.5)
            .prop_map(|(base, size, number)| TemperatureCase::Wave(base, size, number)),
    ]
}

/// Heights of centers: anywhere, and the walls.
pub fn height_in(slab: Slab) -> impl Strategy<Value = f64> {
    let (lowest, highest) = (slab.lowest_center(), slab.highest_center());
    prop_oneof![8 => lowest..=highest, 1 => Just(lowest), 1 => Just(highest)]
}

/// Pairs of heights: near, as moves connect them, and far.
pub fn pairs_in(slab: Slab) -> impl Strategy<Value = Vec<[f64; 2]>> {
    let (lowest, highest) = (slab.lowest_center(), slab.highest_center());
    let near = (height_in(slab), -0.75..0.75_f64)
        .prop_map(move |(height, step)| [height, (height + step).clamp(lowest, highest)]);
    let far = (height_in(slab), height_in(slab)).prop_map(|(a, b)| [a, b]);
    prop::collection::vec(prop_oneof![near, far], 40)
}

pub fn triples_in(slab: Slab) -> impl Strategy<Value = Vec<[f64; 3]>> {
    prop::collection::vec(
        (height_in(slab), height_in(slab), height_in(slab)).prop_map(|(a, b, c)| [a, b, c]),
        40,
    )
}

/// The reduced potential of a scene whose temperature varies, built anew from its definition
/// u = φ/T(0) + ∫ a (1/T - 1/T(0)) dx - ∫ (P/n) d(1/T), the sum of the last two linear within bins
/// and P/n constant.
#[derive(Debug, Clone)]
pub struct Rebuilt {
    lowest: f64,
    width: f64,
    /// The highest temperature at an edge of a bin.
    pub reference: f64,
    edges: Vec<f64>,
}

impl Rebuilt {
    /// `ratio(bin)` is P/n in a bin.
    pub fn new(
        bins: usize,
        slab: &Slab,
        acceleration: impl Fn(f64) -> f64,
        temperature: &dyn TemperatureProfile,
        ratio: impl Fn(usize) -> f64,
    ) -> Self {
        let (lowest, width) = (slab.lowest_center(), (slab.height() - 1.0) / bins as f64);
        let inverse = |height: f64| 1.0 / temperature.temperature(height);
        let heights = (0..=bins).map(|bin| lowest + bin as f64 * width);
        let reference = heights.map(|height| temperature.temperature(height)).fold(0.0, f64::max);
        let mut edges = vec![0.0];
        let mut sum = 0.0;
        for bin in 0..bins {
            let (low, high) = (lowest + bin as f64 * width, lowest + (bin + 1) as f64 * width);
            sum += integrate(|x| acceleration(x) * (inverse(x) - 1.0 / reference), low, high, 8);
            sum -= ratio(bin) * (inverse(high) - inverse(low));
            edges.push(sum);
        }
        Self { lowest, width, reference, edges }
    }

    /// The correction to φ over the reference.
    pub fn correction(&self, height: f64) -> f64 {
        let scaled = (height - self.lowest) / self.width;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let bin = (scaled as usize).min(self.edges.len() - 2);
        let part = scaled - bin as f64;
        self.edges[bin] * (1.0 - part) + self.edges[bin + 1] * part
    }
}
