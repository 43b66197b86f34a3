//! The columns of Figure 17: of each of the paper's systems the one with the steepest gradient.

use gradient_mc::equation_of_state::FluidSolid;
use gradient_mc::field::ExponentialField;
use gradient_mc::temperature::ExponentialTemperature;
use gradient_mc::{HydrostaticProfile, Hydrostatics, Slab};
use paper::Failure;

/// Spheres per area of the base.
pub(crate) const COLUMN_DENSITY: f64 = 40.0;
/// Of the box.
pub(crate) const HEIGHT: f64 = 400.0;
/// Below it the fluid is layered; the paper leaves out five to eight diameters.
const LOWEST: f64 = 8.0;
/// Thickness of the fluid above the front that the crystal orders, in diameters.
const ABOVE_FRONT: f64 = 3.0;
/// Below this packing fraction there are too few spheres: the paper leaves it out, too.
const MOST_DILUTE: f64 = 0.01;

/// a = e^{αx}, T = T₀ e^{−βx}.
#[derive(Debug, Clone)]
pub(crate) struct Case {
    /// Panel of the figure.
    pub(crate) panel: &'static str,
    pub(crate) temperature: f64,
    /// α.
    pub(crate) growth_rate: f64,
    /// β.
    pub(crate) decay_rate: f64,
    pub(crate) slab: Slab,
    /// Between walls; modified Kolafa-Labík-Malijevský, and Speedy's solid where it freezes.
    pub(crate) theory: HydrostaticProfile,
    /// Ranges of height in which the packing fraction changes by 0.05, or that are six diameters
    /// high, with enough spheres in each.
    pub(crate) groups: Vec<[f64; 2]>,
}

/// Panel, T₀, α, β.
type Parameters = (&'static str, f64, f64, f64);

/// The paper leaves crystals out of panel b, so the steepest field that freezes nothing is there,
/// and beside it what is fluid in the one that does.
const PARAMETERS: [Parameters; 4] =
    [("17a", 5.0, 0.0, 0.0), ("17b", 20.0, 0.05, 0.0), ("17b", 20.0, 0.1, 0.0), ("17c", 20.0, 0.0, 0.05)];

impl Case {
    pub(crate) fn all(width: f64) -> Result<Vec<Self>, Failure> {
        PARAMETERS.into_iter().map(|parameters| Self::new(parameters, width)).collect()
    }

    fn new((panel, temperature, growth_rate, decay_rate): Parameters, width: f64) -> Result<Self, Failure> {
        let slab = Slab::new(HEIGHT, width, width)?;
        let profile = ExponentialTemperature::new(temperature, decay_rate)?;
        let field = ExponentialField::new(growth_rate)?;
        let theory =
            Hydrostatics::new(field, profile, FluidSolid::default()).between_walls(&slab, COLUMN_DENSITY)?;
        let mut case = Self { panel, temperature, growth_rate, decay_rate, slab, theory, groups: Vec::new() };
        case.groups = case.divide();
        Ok(case)
    }

    /// From the lowest height that is neither layered nor frozen upwards, in steps of packing
    /// fraction or height.
    fn divide(&self) -> Vec<[f64; 2]> {
        const STEP: f64 = 0.05;
        const MOST: f64 = 6.0;
        /// Spheres per area: a fiftieth of the column.
        const FEWEST: f64 = 0.8;
        let mut edges = vec![self.lowest()];
        let mut low = self.lowest();
        let mut height = low;
        while self.theory.packing_fraction(height) > MOST_DILUTE {
            height += 0.1;
            let change = self.theory.packing_fraction(height) - self.theory.packing_fraction(low);
            let spheres = self.theory.column_above(low) - self.theory.column_above(height);
            if spheres >= FEWEST && (change.abs() >= STEP || height - low >= MOST) {
                edges.push(height);
                low = height;
            }
        }
        // What is left is too little for a range of its own.
        if edges.len() > 1 {
            edges.pop();
        }
        edges.push(height);
        paper::groups::ranges_between(&edges)
    }

    /// The lowest height that is compared.
    pub(crate) fn lowest(&self) -> f64 {
        match self.front() {
            Some(front) => front + ABOVE_FRONT,
            None => LOWEST,
        }
    }

    /// The highest height that is compared.
    pub(crate) fn highest(&self) -> f64 {
        self.groups.last().map_or(self.lowest(), |group| group[1])
    }

    /// Height of the front of the crystal in theory, if there is one: the density jumps there.
    pub(crate) fn front(&self) -> Option<f64> {
        let jump = |height: f64| self.theory.packing_fraction(height) > 0.52;
        let (mut low, mut high) = (1.0, HEIGHT - 1.0);
        if !jump(low) {
            return None;
        }
        while high - low > 1e-6 {
            let middle = f64::midpoint(low, high);
            if jump(middle) { low = middle } else { high = middle }
        }
        Some(low)
    }

    /// T at a height.
    pub(crate) fn temperature_at(&self, height: f64) -> f64 {
        self.temperature * libm::exp(-self.decay_rate * height)
    }

    /// Spheres.
    pub(crate) fn particles(&self) -> usize {
        paper::study::count(COLUMN_DENSITY * self.slab.base_area())
    }

    /// The packing fraction at which |dn/dx| is largest outside the base, and |d ln n/dx| there.
    pub(crate) fn steepest(&self) -> (f64, f64) {
        let mut steepest = (0.0, 0.0, 0.0);
        let mut height = self.lowest();
        while height < self.highest() {
            let slope = self.slope(height);
            if slope.abs() > steepest.0 {
                let density = self.theory.number_density(height);
                steepest = (slope.abs(), self.theory.packing_fraction(height), slope.abs() / density);
            }
            height += 0.1;
        }
        (steepest.1, steepest.2)
    }

    /// dn/dx of the theory.
    fn slope(&self, height: f64) -> f64 {
        (self.theory.number_density(height + 0.05) - self.theory.number_density(height - 0.05)) / 0.1
    }

    /// Mean packing fraction of a range of heights in theory.
    pub(crate) fn mean_packing_fraction(&self, [low, high]: [f64; 2]) -> f64 {
        let spheres = self.theory.column_below(high) - self.theory.column_below(low);
        gradient_mc::equation_of_state::packing_fraction(spheres / (high - low))
    }

    /// As it is called in pictures and tables.
    pub(crate) fn label(&self) -> String {
        let Self { temperature, growth_rate, decay_rate, .. } = self;
        if *growth_rate > 0.0 {
            format!("T₀ = {temperature}, α = {growth_rate}")
        } else if *decay_rate > 0.0 {
            format!("T₀ = {temperature}, β = {decay_rate}")
        } else {
            format!("T₀ = {temperature}")
        }
    }
}
