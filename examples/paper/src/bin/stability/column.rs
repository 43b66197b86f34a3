//! A column and its measurements.

use crate::map::{Findings, Trial};
use crate::said;
use crate::verdict::Quantity;
use gradient_mc::drive::Scheme;
use gradient_mc::equation_of_state::{FluidSolid, ModifiedKolafa};
use gradient_mc::observers::{Bins, CenterOfMass, DensityProfile, EquationOfStateProfile};
use gradient_mc::{Error, Every, Field, HydrostaticProfile, Scene, Simulation, Slab, TemperatureProfile};
use paper::least_squares::least_squares;

/// How long a run is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Length {
    pub(crate) equilibration: u64,
    pub(crate) sweeps: u64,
}

/// Number of spheres that makes `column_density` over a square base.
pub(crate) fn particles(column_density: f64, width: f64) -> usize {
    paper::study::count(column_density * width * width).max(1)
}

/// A scene over a square base.
pub(crate) fn scene<F: Field, T: TemperatureProfile>(
    height: f64,
    width: f64,
    column_density: f64,
    field: F,
    temperature: T,
) -> Result<Scene<F, T>, Error> {
    Scene::new(Slab::new(height, width, width)?, particles(column_density, width), field, temperature)
}

/// The best theory of a scene: right in the bulk to 0.2 %, its center of mass to some 0.03
/// diameters.
pub(crate) fn theory<F: Field, T: TemperatureProfile>(
    scene: &Scene<F, T>,
) -> Result<HydrostaticProfile, Error> {
    scene.hydrostatics(&FluidSolid::default())
}

/// A run and its measurements.
pub(crate) struct Run {
    first_center: f64,
    center_of_mass: CenterOfMass,
    contact: DensityProfile,
    contact_bin: f64,
    pub(crate) profile: EquationOfStateProfile,
    pub(crate) findings: Findings,
}

/// Bins over which the density is extrapolated to contact.
const CONTACT_BINS: usize = 10;

/// Equilibrates and measures.
pub(crate) fn run<F: Field, T: TemperatureProfile, S: Scheme<F, T>>(
    mut simulation: Simulation<F, T, S>,
    length: Length,
    trial: Trial,
) -> Result<Run, Error> {
    let slab = *simulation.scene().slab();
    let heights = simulation.frame().heights();
    let first_center = heights.sum::<f64>() / simulation.scene().particles() as f64;
    // The density at a wall falls by e over one sphere's share of the area there.
    let weight = simulation.scene().field().acceleration(0.5) * simulation.scene().column_density();
    let decay = simulation.scene().temperature().temperature(0.5) / weight;
    let contact_bin = decay.min(0.2) / CONTACT_BINS as f64;
    let contact = DensityProfile::new(
        &slab,
        Bins::count(CONTACT_BINS).from(0.5).to(0.5 + CONTACT_BINS as f64 * contact_bin),
    )?;
    // Half a diameter, up to where at most some hundred bins reach.
    let top = slab.height().min(100.0).floor();
    let profile =
        EquationOfStateProfile::new(&slab, Bins::count(paper::study::count(2.0 * top)).from(0.0).to(top))?;
    let mut observers = Every::new(2, (CenterOfMass::new(), contact, profile));
    simulation.equilibrate(trial.sweeps(length.equilibration), &mut ())?;
    simulation.run(trial.sweeps(length.sweeps), &mut observers)?;
    let (center_of_mass, contact, profile) = observers.observer;
    let acceptance = simulation.move_counts().acceptance();
    let remark = if acceptance.is_nan() { String::new() } else { format!("acceptance {acceptance:.4}") };
    let findings = Findings { quantities: Vec::new(), said: said::by(&simulation), remark, foreign: false };
    Ok(Run { first_center, center_of_mass, contact, contact_bin, profile, findings })
}

impl Run {
    /// Height of the center of mass against a true one that is known to `uncertainty`.
    pub(crate) fn center_of_mass(&self, truth: f64, uncertainty: f64) -> Result<Quantity, Error> {
        let mut quantity = Quantity::relative("center of mass", self.center_of_mass.estimate()?, truth);
        quantity.truth_error = uncertainty / truth;
        quantity.start = Some(self.first_center / truth - 1.0);
        let drift = self.center_of_mass.drift()?;
        quantity.drift = Some(drift / truth);
        Ok(quantity)
    }

    /// The density at the base against the contact theorem, n(½⁺) = `exact`.
    pub(crate) fn contact(&self, exact: f64) -> Result<Quantity, Error> {
        let width = self.contact_bin;
        let extrapolated = self.contact.jackknife(|densities| [extrapolate(densities, width)])?;
        Ok(Quantity::relative("contact density", extrapolated[0], exact).tolerating(0.05, 0.12))
    }

    /// P/(n T Z) − 1 over a range of heights, Z after Kolafa, Labík and Malijevský, modified.
    pub(crate) fn equation_of_state(&self, range: [f64; 2]) -> Result<Quantity, Error> {
        let deviation = self.profile.deviations_over(&[range], &ModifiedKolafa)?;
        Ok(Quantity::absolute("P/(nTZ) - 1", deviation[0]).tolerating(0.01, 0.01))
    }

    pub(crate) fn with(mut self, quantities: impl IntoIterator<Item = Quantity>) -> Findings {
        self.findings.quantities.extend(quantities);
        self.findings
    }
}

/// Value at the lower edge of the first bin of the least-squares parabola through the logarithms.
fn extrapolate(densities: &[f64], width: f64) -> f64 {
    let rows: Vec<([f64; 3], f64, f64)> = densities
        .iter()
        .enumerate()
        .map(|(bin, density)| {
            let x = (bin as f64 + 0.5) * width;
            ([1.0, x, x * x], libm::log(*density), 1.0)
        })
        .collect();
    let [logarithm, ..] = least_squares(&rows);
    libm::exp(logarithm)
}
