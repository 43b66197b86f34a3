//! The columns of the paper in a temperature gradient, and their theory.

use gradient_mc::equation_of_state::ModifiedKolafa;
use gradient_mc::field::UniformField;
use gradient_mc::temperature::ExponentialTemperature;
use gradient_mc::{HydrostaticProfile, Hydrostatics, Scene, Slab};
use paper::{Failure, groups, study::count};

/// T at the base.
pub(crate) const TEMPERATURE: f64 = 20.0;
/// β of the columns.
pub(crate) const DECAY_RATES: [f64; 5] = [0.005, 0.01, 0.02, 0.03, 0.05];
/// Spheres per area of the base.
pub(crate) const COLUMN_DENSITY: f64 = 40.0;
/// Of the box.
pub(crate) const HEIGHT: f64 = 400.0;
/// Below it the fluid is layered; the paper leaves out five to eight diameters.
pub(crate) const LOWEST: f64 = 8.0;
/// Where ln n changes faster the density is not local.
const STEEPEST: f64 = 0.1;
const GROUPS: usize = 6;

/// T = T₀ e^{−βx} over a square base, with its theory between walls.
#[derive(Debug, Clone)]
pub(crate) struct Column {
    pub(crate) decay_rate: f64,
    pub(crate) slab: Slab,
    /// Modified Kolafa-Labík-Malijevský.
    pub(crate) theory: HydrostaticProfile,
    /// Ranges with equally many spheres where the theory can be expected to hold.
    pub(crate) groups: Vec<[f64; 2]>,
    /// What the ideal-gas law, eq. (28), has in place of the density at the base, where the column
    /// is dilute.
    pub(crate) prefactor: f64,
}

impl Column {
    pub(crate) fn new(decay_rate: f64, width: f64) -> Result<Self, Failure> {
        let slab = Slab::new(HEIGHT, width, width)?;
        let temperature = ExponentialTemperature::new(TEMPERATURE, decay_rate)?;
        let theory = Hydrostatics::new(UniformField::default(), temperature, ModifiedKolafa)
            .between_walls(&slab, COLUMN_DENSITY)?;
        let highest = groups::end_of_gentle_slope(&theory, LOWEST, STEEPEST, HEIGHT);
        let edges = groups::edges_of_equal_numbers(&theory, [LOWEST, highest], GROUPS);
        let mut column =
            Self { decay_rate, slab, theory, groups: groups::ranges_between(&edges), prefactor: 1.0 };
        // So dilute that Z differs from one by less than 10⁻⁵.
        let dilute = column.height_of_density(2e-6);
        column.prefactor = column.theory.number_density(dilute) / column.ideal_gas(dilute);
        Ok(column)
    }

    pub(crate) fn scene(&self) -> Result<Scene<UniformField, ExponentialTemperature>, Failure> {
        let particles = count(COLUMN_DENSITY * self.slab.base_area());
        let temperature = ExponentialTemperature::new(TEMPERATURE, self.decay_rate)?;
        Ok(Scene::new(self.slab, particles, UniformField::default(), temperature)?)
    }

    /// Top of the groups.
    pub(crate) fn highest(&self) -> f64 {
        self.groups.last().map_or(LOWEST, |group| group[1])
    }

    /// n of the ideal-gas law, eq. (28): the prefactor times exp(−(e^{βx} − 1)/(βT₀) + βx).
    pub(crate) fn ideal_gas(&self, height: f64) -> f64 {
        let exponent = self.decay_rate * height;
        self.prefactor * libm::exp(exponent - libm::expm1(exponent) / (self.decay_rate * TEMPERATURE))
    }

    /// The height above which the theory's density stays below this one.
    pub(crate) fn height_of_density(&self, density: f64) -> f64 {
        let (mut low, mut high) = (self.theory.density_maximum().0, HEIGHT - 0.5);
        while high - low > 1e-6 {
            let middle = f64::midpoint(low, high);
            if self.theory.number_density(middle) > density { low = middle } else { high = middle }
        }
        low
    }

    /// Where the theory has its maximum, if that is inside the column and not at its base.
    pub(crate) fn maximum(&self) -> Option<f64> {
        let (height, _) = self.theory.density_maximum();
        (height > LOWEST).then_some(height)
    }

    /// As it is called in pictures.
    pub(crate) fn label(&self) -> String {
        format!("β = {}", self.decay_rate)
    }
}
