//! What is known without simulation.

use super::protocol::{COLUMN_DENSITY, HEIGHT, TEMPERATURES};
use gradient_mc::equation_of_state::{CarnahanStarling, ModifiedKolafa};
use gradient_mc::field::UniformField;
use gradient_mc::functional::DensityFunctional;
use gradient_mc::temperature::Isothermal;
use gradient_mc::{EquationOfState, HydrostaticProfile, Hydrostatics, Slab};
use paper::Failure;
use paper::functionals::{self, Named, base_bins};

/// Theory of one temperature.
#[derive(Debug, Clone)]
pub(crate) struct Theory {
    /// Hydrostatics between walls with the modified Kolafa-Labík-Malijevský equation: the best for
    /// the bulk.
    pub(crate) kolafa: HydrostaticProfile,
    /// The same with Carnahan-Starling.
    pub(crate) carnahan_starling: HydrostaticProfile,
    /// Eq. (27) of the paper, without walls: from x = 0 on.
    pub(crate) paper: HydrostaticProfile,
    /// Derivative of its center of mass by temperature.
    pub(crate) slope: f64,
    /// By density functionals, in the order of [`functionals::all`].
    pub(crate) functionals: Vec<Layers>,
}

/// The results of a density functional for a column.
#[derive(Debug, Clone)]
pub(crate) struct Layers {
    pub(crate) name: &'static str,
    pub(crate) center_of_mass: f64,
    /// n(x) at the base: middles of bins of 0.1, and the mean in each.
    pub(crate) base: Vec<(f64, f64)>,
}

impl Layers {
    fn new(temperature: f64, functional: &Named) -> Result<Self, Failure> {
        let temperature = Isothermal::new(temperature)?;
        let profile = DensityFunctional::new(UniformField::default(), temperature, &*functional.functional)
            .lid(HEIGHT)
            .column_density(COLUMN_DENSITY)?;
        Ok(Self {
            name: functional.name,
            center_of_mass: profile.center_of_mass(),
            base: base_bins(&profile).collect(),
        })
    }
}

impl Theory {
    pub(crate) fn new(temperature: f64) -> Result<Self, Failure> {
        let step = 0.01 * temperature;
        let [below, above] = [temperature - step, temperature + step]
            .map(|temperature| between_walls(temperature, ModifiedKolafa));
        let rise = above?.center_of_mass() - below?.center_of_mass();
        let functionals = functionals::all();
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
            functionals: functionals
                .iter()
                .map(|functional| Layers::new(temperature, functional))
                .collect::<Result<_, _>>()?,
        })
    }

    /// White Bear II (doi:10.1088/0953-8984/18/37/002), made of the Carnahan-Starling equation.
    pub(crate) fn white_bear(&self) -> &Layers {
        &self.functionals[functionals::WHITE_BEAR_2]
    }

    /// White Bear II corrected for its equation of state, by the difference in the local theory.
    pub(crate) fn corrected_white_bear(&self) -> f64 {
        self.white_bear().center_of_mass + self.kolafa.center_of_mass()
            - self.carnahan_starling.center_of_mass()
    }

    /// The ideal gas of the same chemical potential, n₀ exp(−x/T): what the column becomes at its
    /// dilute top.
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

/// How well the theory between walls knows the center of mass: the largest difference from White
/// Bear II, when both are made of the same equation of state.
pub(crate) fn accuracy() -> Result<f64, Failure> {
    let mut largest = 0.0;
    let functionals = functionals::all();
    for temperature in TEMPERATURES {
        let local = between_walls(temperature, CarnahanStarling)?.center_of_mass();
        let white_bear = Layers::new(temperature, &functionals[functionals::WHITE_BEAR_2])?;
        largest = f64::max(largest, (local - white_bear.center_of_mass).abs());
    }
    Ok(largest)
}
