//! The columns of the calibration and of its test.

use gradient_mc::equation_of_state::{FluidSolid, ModifiedKolafa};
use gradient_mc::field::ExponentialField;
use gradient_mc::model::Accuracy;
use gradient_mc::temperature::ExponentialTemperature;
use gradient_mc::{Error, Generator, Hydrostatics, Scene, Slab};
use rand::{RngExt, SeedableRng};

/// A scene with the field and temperature of the paper.
pub type Column = Scene<ExponentialField, ExponentialTemperature>;

/// Parameters of a column: a(x) = exp(αx), T(x) = T₀ exp(−βx), N/A.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    pub temperature: f64,
    pub field_rate: f64,
    pub decay_rate: f64,
    pub column_density: f64,
}

/// T₀, α, β, N/A: the paper's three systems first, then dense and dilute, tall and flat, in both
/// gradients.
const CALIBRATION: [[f64; 4]; 26] = [
    [20.0, 0.0, 0.0, 40.0],
    [20.0, 0.02, 0.0, 40.0],
    [20.0, 0.0, 0.02, 40.0],
    [5.0, 0.0, 0.0, 40.0],
    [1.0, 0.0, 0.0, 0.3],
    [1.0, 0.0, 0.0, 1.0],
    [1.0, 0.0, 0.0, 3.0],
    [1.0, 0.0, 0.0, 8.0],
    [2.0, 0.0, 0.0, 6.0],
    [4.0, 0.05, 0.0, 4.0],
    [4.0, 0.0, 0.05, 4.0],
    [2.0, 0.1, 0.0, 1.5],
    [10.0, 0.0, 0.0, 0.5],
    [10.0, 0.05, 0.03, 10.0],
    [40.0, 0.0, 0.0, 40.0],
    [3.0, 0.0, 0.03, 12.0],
    [40.0, 0.0, 0.0, 2.0],
    [1.5, 0.0, 0.04, 1.5],
    [1.0, 0.1, 0.05, 1.0],
    [1.0, 0.0, 0.05, 2.0],
    [3.0, 0.1, 0.0, 3.0],
    [1.0, 0.0, 0.0, 10.0],
    [1.0, 0.0, 0.0, 0.6],
    [6.0, 0.0, 0.0, 1.5],
    [2.0, 0.0, 0.0, 0.25],
    [1.5, 0.05, 0.02, 5.0],
];

/// A scene that is not used in the fit, and the accuracies that are asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldOut {
    pub parameters: Parameters,
    /// For n, P and Z.
    pub tolerances: [f64; 3],
    /// Parts of the spheres that lie below the heights between which P is asked for, and Z.
    quantiles: [[f64; 2]; 2],
}

impl HeldOut {
    const SEED: u64 = 2027;

    /// The first draws of one generator:
    ///
    /// - T₀ = 40^(u²): between 1 and 40, flat columns more often than tall ones, since tall ones
    ///   hardly need a simulation;
    /// - weight N/(A T₀) log-uniform between 0.005 and 10 (the hard-sphere fluid freezes at P/T =
    ///   11.57 and α, β add to it);
    /// - α = 0 in half of them, else uniform up to 0.1; β = 0 in half of them, else uniform up to
    ///   0.05;
    /// - tolerances of n, P and Z log-uniform between 0.1 and 10 %, each on its own;
    /// - P and Z between heights below which lie up to half of the spheres, and 60 to 98 %;
    ///
    /// numbers rounded to three significant digits; N/A outside [0.05, 40] is drawn again.
    pub fn draw(count: usize) -> Vec<Self> {
        let mut generator = Generator::seed_from_u64(Self::SEED);
        let mut unit = || generator.random::<f64>();
        let mut scenes = Vec::with_capacity(count);
        while scenes.len() < count {
            let root = unit();
            let temperature = three_digits(libm::pow(40.0, root * root));
            let weight = log_uniform(unit(), 0.005, 10.0);
            let [field, decay] = [0.1, 0.05].map(|most| (unit() < 0.5, three_digits(most * unit())));
            let tolerances = [(); 3].map(|()| three_digits(log_uniform(unit(), 0.001, 0.1)));
            let quantiles = [(); 2].map(|()| [0.5 * unit(), 0.6 + 0.38 * unit()]);
            let column_density = three_digits(weight * temperature);
            let rate = |(is_zero, rate): (bool, f64)| if is_zero { 0.0 } else { rate };
            let parameters =
                Parameters { temperature, field_rate: rate(field), decay_rate: rate(decay), column_density };
            if (0.05..=40.0).contains(&column_density) {
                scenes.push(Self { parameters, tolerances, quantiles });
            }
        }
        scenes
    }

    /// The column over a base that is wide enough to be true to 0.02 %, with a lid so high that it
    /// carries nothing.
    pub fn scene(&self) -> Result<Column, Error> {
        self.parameters.scene_below(1e-7, 1200, 10.0)
    }

    /// What is asked: n everywhere, P and Z between heights.
    pub fn accuracies(&self, scene: &Column) -> Result<[Accuracy; 3], Error> {
        let theory = scene.hydrostatics(&ModifiedKolafa)?;
        let [density, pressure, compressibility] = self.tolerances;
        let between = |accuracy: Accuracy, [low, high]: [f64; 2]| {
            let lowest = theory.height_of_fraction(low).floor();
            accuracy.between(lowest, theory.height_of_fraction(high).ceil().max(lowest + 1.0))
        };
        Ok([
            Accuracy::density(density)?,
            between(Accuracy::pressure(pressure)?, self.quantiles[0])?,
            between(Accuracy::compressibility_factor(compressibility)?, self.quantiles[1])?,
        ])
    }
}

fn log_uniform(unit: f64, low: f64, high: f64) -> f64 {
    low * libm::pow(high / low, unit)
}

fn three_digits(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

impl Parameters {
    /// Fewest spheres over the base of a reference, and its smallest side.
    pub const WIDE: (usize, f64) = (300, 8.0);

    /// Whether the fluid of the theory freezes, or has no state at this weight.
    pub fn freezes(&self) -> Result<bool, Error> {
        let field = ExponentialField::new(self.field_rate)?;
        let temperature = ExponentialTemperature::new(self.temperature, self.decay_rate)?;
        let theory = Hydrostatics::new(field, temperature, ModifiedKolafa).base(0.5);
        match theory.column_density(self.column_density) {
            Ok(profile) => Ok(profile.domain_exit().is_some()),
            // The column is too dense for the solver.
            Err(Error::EquationOfStateExhausted { .. } | Error::HydrostaticsNotConverged { .. }) => Ok(true),
            Err(error) => Err(error),
        }
    }

    pub fn calibration() -> Vec<Self> {
        CALIBRATION
            .iter()
            .map(|&[temperature, field_rate, decay_rate, column_density]| Self {
                temperature,
                field_rate,
                decay_rate,
                column_density,
            })
            .collect()
    }

    /// The scene over a square base with at least `particles` spheres on at least `side` x `side`;
    /// the lid lies where the theory has one sphere in 10⁵ above, and two diameters more.
    pub fn scene(&self, particles: usize, side: f64) -> Result<Column, Error> {
        self.scene_below(1e-5, particles, side)
    }

    /// The same with another part of the spheres above the lid.
    fn scene_below(&self, above: f64, particles: usize, side: f64) -> Result<Column, Error> {
        let field = ExponentialField::new(self.field_rate)?;
        let temperature = ExponentialTemperature::new(self.temperature, self.decay_rate)?;
        let theory = Hydrostatics::new(field, temperature, FluidSolid::default())
            .base(0.5)
            .column_density(self.column_density)?;
        let height = theory.height_of_fraction(1.0 - above).ceil() + 2.0;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let particles = particles.max((self.column_density * side * side).ceil() as usize);
        let side = (particles as f64 / self.column_density).sqrt();
        Scene::new(Slab::new(height, side, side)?, particles, field, temperature)
    }
}
