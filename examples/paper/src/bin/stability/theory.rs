//! Theory beyond its domain: equations of state in columns that freeze, and steep profiles.

use crate::column::{self, Length, particles, run};
use crate::map::{Findings, Map, Trial};
use crate::said::Said;
use crate::verdict::Quantity;
use gradient_mc::drive::SelfConsistent;
use gradient_mc::equation_of_state::{
    CarnahanStarling, EquationOfState, FluidSolid, IdealGas, ModifiedKolafa, PercusYevickCompressibility,
    PercusYevickVirial, VirialSeries,
};
use gradient_mc::field::UniformField;
use gradient_mc::moves::LocalMoves;
use gradient_mc::statistics::Estimate;
use gradient_mc::temperature::{ExponentialTemperature, Isothermal};
use gradient_mc::{HydrostaticProfile, Hydrostatics, Simulation, Slab};
use paper::Failure;
use paper::clock::cpu_seconds;

/// Equations of state where the column freezes.
pub(crate) fn equations() -> Map {
    const TEMPERATURES: [f64; 8] = [40.0, 20.0, 10.0, 5.0, 4.0, 3.0, 2.0, 1.0];
    let mut map =
        Map::new("equation_of_state", "Hydrostatics: equations of state, N/A = 40", "temperature T / mgd");
    for temperature in TEMPERATURES {
        map.add("Kolafa-Labík-M.", temperature, move |_| compare(ModifiedKolafa, temperature));
        map.add("Carnahan-Starling", temperature, move |_| compare(CarnahanStarling, temperature));
        map.add("virial series to B10", temperature, move |_| compare(VirialSeries::new(10)?, temperature));
        map.add("PY, compressibility", temperature, move |_| {
            compare(PercusYevickCompressibility, temperature)
        });
        map.add("PY, virial", temperature, move |_| compare(PercusYevickVirial, temperature));
        map.add("ideal gas", temperature, move |_| compare(IdealGas, temperature));
    }
    map
}

/// The center of mass by an equation of state against that of the best one, fluid and solid.
fn compare(equation_of_state: impl EquationOfState + Clone, temperature: f64) -> Result<Findings, Failure> {
    let slab = Slab::new(400.0, 25.0, 25.0)?;
    let temperature = Isothermal::new(temperature)?;
    let best = Hydrostatics::new(UniformField::default(), temperature, FluidSolid::default())
        .between_walls(&slab, 40.0)?;
    let profile = Hydrostatics::new(UniformField::default(), temperature, equation_of_state)
        .between_walls(&slab, 40.0)?;
    Ok(against(&profile, Estimate::exact(best.center_of_mass())))
}

/// The center of mass of a profile against a true one.
fn against(profile: &HydrostaticProfile, truth: Estimate) -> Findings {
    let measured = Estimate::exact(profile.center_of_mass());
    let mut quantity = Quantity::relative("center of mass", measured, truth.mean);
    quantity.truth_error = truth.standard_error / truth.mean;
    Findings {
        quantities: vec![quantity.tolerating(0.005, 0.005)],
        said: Said::warnings(&profile.warnings()),
        ..Findings::default()
    }
}

/// Columns so cold that ln n changes by of order 1 over a diameter.
pub(crate) fn steep() -> Map {
    const TEMPERATURES: [f64; 6] = [0.2, 0.5, 1.0, 2.0, 5.0, 10.0];
    let mut map =
        Map::new("steep_field", "Local theory: columns of few layers, against simulation", "T / mgd");
    for density in [0.1, 1.0, 4.0] {
        for temperature in TEMPERATURES {
            map.add(&format!("N/A = {density}"), temperature, move |trial| cold(density, temperature, trial));
        }
    }
    map
}

fn cold(density: f64, temperature: f64, trial: Trial) -> Result<Findings, Failure> {
    // Enough spheres that one more or less does not matter: their own volume is not excluded to
    // themselves.
    let width = if density < 2.0 { 12.0 } else { 6.0 };
    let scene = column::scene(
        30.0 + 12.0 * temperature,
        width,
        density,
        UniformField::default(),
        Isothermal::new(temperature)?,
    )?;
    let spheres = particles(density, width) as f64;
    let sweeps = paper::study::count((4e6 / spheres).floor()) as u64;
    let before = cpu_seconds();
    let moves = LocalMoves::tuned();
    let simulation = Simulation::builder(scene).moves(moves).seed(trial.seed).build()?;
    let run = run(simulation, Length { equilibration: sweeps / 4, sweeps }, trial)?;
    let measured = run.center_of_mass(1.0, 0.0)?;
    let truth = 1.0 + measured.error;
    let seconds = cpu_seconds() - before;
    let mut findings = against(&column::theory(&scene)?, truth);
    findings.remark = format!("simulated h_c {truth}, {seconds:.1} s");
    Ok(findings)
}

/// d ln T/dx up to order 1: theory and simulation.
pub(crate) fn steep_temperatures() -> Map {
    const RATES: [f64; 7] = [0.02, 0.05, 0.1, 0.2, 0.4, 0.8, 1.6];
    let mut map = Map::new(
        "steep_temperature",
        "Steep temperatures: T = 5 exp(−βx), N/A = 2",
        "decay rate β of the temperature",
    );
    for rate in RATES {
        map.add("theory against simulation", rate, move |trial| falling(rate, true, trial));
        map.add("P/(nTZ) where spheres are", rate, move |trial| falling(rate, false, trial));
    }
    map
}

fn falling(rate: f64, theory: bool, trial: Trial) -> Result<Findings, Failure> {
    let temperature = ExponentialTemperature::new(5.0, rate)?;
    // Below T = 1e-6 there is nothing to see.
    let height = (14.0 / rate).min(80.0);
    let scene = column::scene(height, 6.0, 2.0, UniformField::default(), temperature)?;
    let builder = Simulation::builder(scene).scheme(SelfConsistent::default()).moves(LocalMoves::tuned());
    let run =
        run(builder.seed(trial.seed).build()?, Length { equilibration: 30_000, sweeps: 60_000 }, trial)?;
    let best = column::theory(&scene)?;
    if theory {
        let measured = run.center_of_mass(1.0, 0.0)?;
        let truth = 1.0 + measured.error;
        let mut findings = against(&best, truth);
        findings.remark = format!("simulated h_c {truth}");
        return Ok(findings);
    }
    // Where the middle half of the spheres is.
    let range = [
        best.height_of_fraction(0.25),
        best.height_of_fraction(0.75).max(best.height_of_fraction(0.25) + 1.0),
    ];
    let equation_of_state = run.equation_of_state(range)?.tolerating(0.015, 0.015);
    Ok(run.with([equation_of_state]))
}
