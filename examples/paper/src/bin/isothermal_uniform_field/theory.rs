//! What is known without simulation.

use super::protocol::{COLUMN_DENSITY, HEIGHT};
use gradient_mc::equation_of_state::{CarnahanStarling, ModifiedKolafa};
use gradient_mc::field::UniformField;
use gradient_mc::statistics::Estimate;
use gradient_mc::temperature::Isothermal;
use gradient_mc::{EquationOfState, HydrostaticProfile, Hydrostatics, Slab};
use paper::Failure;

/// Center of mass by the White Bear II functional (doi:10.1088/0953-8984/18/37/002), made of the Carnahan-Starling equation: from
/// a solver of its own, independent of this library (`tests/reference/README.md`).
pub(crate) const WHITE_BEAR: [(f64, f64); 4] =
    [(5.0, 27.9942), (15.0, 42.9804), (20.0, 49.3939), (30.0, 61.3926)];

/// The functional's n(x) at the base, means over bins of 0.1, for two temperatures.
const WHITE_BEAR_BASE: [(f64, &str); 2] = [
    (5.0, include_str!("../../../../../tests/reference/fmt_WBII_T5_bins_extrapolated.csv")),
    (15.0, include_str!("../../../../../tests/reference/fmt_WBII_T15_bins_extrapolated.csv")),
];

/// n(x) at the base at T₀ = 5 by a Monte Carlo program that has nothing in common with this library, in bins of 0.1 with errors.
const INDEPENDENT_BASE: &str = include_str!("../../../../../tests/reference/layers_T5_monte_carlo.csv");

/// Theory of one temperature.
#[derive(Debug, Clone)]
pub(crate) struct Theory {
    /// Hydrostatics between walls with the modified Kolafa-Labík-Malijevský equation: the best for the bulk.
    pub(crate) kolafa: HydrostaticProfile,
    /// The same with Carnahan-Starling.
    pub(crate) carnahan_starling: HydrostaticProfile,
    /// The paper's eq. (27), which knows no wall: from x = 0 on.
    pub(crate) paper: HydrostaticProfile,
    /// Derivative of its center of mass by temperature.
    pub(crate) slope: f64,
    /// Center of mass by White Bear II.
    pub(crate) white_bear: f64,
    /// Its n(x) at the base, as middles of bins and densities; empty where there is no reference.
    pub(crate) white_bear_base: Vec<(f64, f64)>,
}

impl Theory {
    pub(crate) fn new(temperature: f64) -> Result<Self, Failure> {
        let step = 0.01 * temperature;
        let [below, above] = [temperature - step, temperature + step]
            .map(|temperature| between_walls(temperature, ModifiedKolafa));
        let rise = above?.center_of_mass() - below?.center_of_mass();
        let (_, white_bear) = WHITE_BEAR
            .into_iter()
            .find(|&(tabulated, _)| tabulated == temperature)
            .ok_or("White Bear II was solved for other temperatures")?;
        let base = WHITE_BEAR_BASE.into_iter().find(|&(tabulated, _)| tabulated == temperature);
        Ok(Self {
            kolafa: between_walls(temperature, ModifiedKolafa)?,
            carnahan_starling: between_walls(temperature, CarnahanStarling)?,
            paper: Hydrostatics::new(
                UniformField::default(),
                Isothermal::new(temperature)?,
                CarnahanStarling,
            )
            .lid(HEIGHT)
            .column_density(COLUMN_DENSITY)?,
            slope: rise / (2.0 * step),
            white_bear,
            white_bear_base: base.map_or(Ok(Vec::new()), |(_, text)| read_base(text))?,
        })
    }

    /// What White Bear II would say if it were made of the better equation of state, as far as the local theory tells
    /// the difference.
    pub(crate) fn corrected_white_bear(&self) -> f64 {
        self.white_bear + self.kolafa.center_of_mass() - self.carnahan_starling.center_of_mass()
    }

    /// The ideal gas of the same chemical potential, n₀ exp(−x/T): what the column becomes at its dilute top.
    pub(crate) fn ideal_gas(&self, temperature: f64, height: f64) -> f64 {
        // There, interactions change the density by less than a part in a thousand.
        let far = self.kolafa.height_of_fraction(1.0 - 1e-8).min(HEIGHT - 5.0);
        self.kolafa.number_density(far) * libm::exp((far - height) / temperature)
    }
}

/// The local theory of the box, with the layers at its walls accounted for.
pub(crate) fn between_walls(
    temperature: f64,
    equation_of_state: impl EquationOfState + Clone,
) -> Result<HydrostaticProfile, Failure> {
    let theory = Hydrostatics::new(UniformField::default(), Isothermal::new(temperature)?, equation_of_state);
    Ok(theory.between_walls(&Slab::new(HEIGHT, 25.0, 25.0)?, COLUMN_DENSITY)?)
}

/// How well the theory between walls knows the center of mass: the largest difference from White Bear II, when both are made of
/// the same equation of state.
pub(crate) fn accuracy() -> Result<f64, Failure> {
    let mut largest = 0.0;
    for (temperature, white_bear) in WHITE_BEAR {
        let local = between_walls(temperature, CarnahanStarling)?.center_of_mass();
        largest = f64::max(largest, (local - white_bear).abs());
    }
    Ok(largest)
}

/// The independent simulation of the base at T₀ = 5.
pub(crate) fn independent_base() -> Result<Vec<Estimate>, Failure> {
    Ok(read(INDEPENDENT_BASE)?
        .into_iter()
        .map(|[_, _, density, error]| Estimate::new(density, error))
        .collect())
}

fn read_base(text: &str) -> Result<Vec<(f64, f64)>, Failure> {
    Ok(read(text)?.into_iter().map(|[low, high, density, _]| (f64::midpoint(low, high), density)).collect())
}

/// The first four columns of a reference.
fn read(text: &str) -> Result<Vec<[f64; 4]>, Failure> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let mut bins = Vec::new();
    for record in reader.records() {
        let record = record?;
        let number = |column: usize| -> Result<f64, Failure> {
            Ok(record.get(column).ok_or("the reference has a short line")?.parse()?)
        };
        bins.push([number(0)?, number(1)?, number(2)?, number(3)?]);
    }
    Ok(bins)
}
