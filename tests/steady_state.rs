//! The steady state is reached from both sides: a start far too high and one far too compact meet.
//!
//! Errors come from independent replicas, so that they contain whatever a single run cannot know about
//! itself: its slowest mode, and the noise that a self-consistent field was frozen with.

#![allow(clippy::unwrap_used)]

use gradient_mc::drive::{ClosedForm, Drive, Scheme, SelfConsistent};
use gradient_mc::field::UniformField;
use gradient_mc::observers::{Bins, CenterOfMass, DensityProfile};
use gradient_mc::start::{ClosePacked, RandomInsertion, Start};
use gradient_mc::temperature::{ExponentialTemperature, Isothermal};
use gradient_mc::{Every, Scene, Simulation, Slab, TemperatureProfile};

const REPLICAS: u64 = 5;
/// Density is compared in bands of this height, from the base.
const BAND: f64 = 4.0;
const BANDS: usize = 5;

/// Center of mass and densities of one replica.
fn observe<T: TemperatureProfile, D: Drive<UniformField, T>>(
    mut simulation: Simulation<UniformField, T, D>,
    equilibration: u64,
    sweeps: u64,
) -> Vec<f64> {
    let slab = *simulation.scene().slab();
    let bands =
        DensityProfile::new(&slab, Bins::count(BANDS).from(0.5).to(0.5 + BAND * BANDS as f64)).unwrap();
    let mut observers = Every::new(10, (CenterOfMass::new(), bands));
    simulation.equilibrate(equilibration, &mut ()).unwrap();
    simulation.run(sweeps, &mut observers).unwrap();
    let (center_of_mass, bands) = observers.observer;
    let mut values = vec![center_of_mass.estimate().unwrap().mean];
    values.extend(bands.means());
    values
}

/// Means over replicas and their standard errors.
fn replicate(replica: impl Fn(u64) -> Vec<f64>) -> Vec<(f64, f64)> {
    let runs: Vec<Vec<f64>> = (0..REPLICAS).map(replica).collect();
    (0..runs[0].len())
        .map(|item| {
            let mean = runs.iter().map(|run| run[item]).sum::<f64>() / REPLICAS as f64;
            let square = runs.iter().map(|run| (run[item] - mean) * (run[item] - mean)).sum::<f64>();
            (mean, (square / (REPLICAS * (REPLICAS - 1)) as f64).sqrt())
        })
        .collect()
}

/// Whether two sides meet: within `sigmas` joint errors, the relative error capped.
fn meet(high: &[(f64, f64)], low: &[(f64, f64)], cap: f64) -> Result<(), String> {
    // A t variate of 8 degrees of freedom exceeds 6 as rarely as a Gaussian one exceeds about 3.6.
    const SIGMAS: f64 = 6.0;
    for (item, (a, b)) in high.iter().zip(low).enumerate() {
        let error = a.1.hypot(b.1);
        if error > cap * a.0 {
            return Err(format!("item {item}: error {error} of {} is above the cap", a.0));
        }
        if (a.0 - b.0).abs() > SIGMAS * error {
            return Err(format!("item {item}: {a:?} from above, {b:?} from below"));
        }
    }
    Ok(())
}

/// A column of 250 spheres over a base 5 x 5, from one side.
fn side<T, S, P>(
    temperature: T,
    scheme: S,
    start: P,
    seed: u64,
    equilibration: u64,
    sweeps: u64,
) -> Vec<(f64, f64)>
where
    T: TemperatureProfile + Copy,
    S: Scheme<UniformField, T> + Copy,
    P: Start + Copy,
{
    let slab = Slab::new(80.0, 5.0, 5.0).unwrap();
    let scene = Scene::new(slab, 250, UniformField::default(), temperature).unwrap();
    replicate(|replica| {
        let builder = Simulation::builder(scene).scheme(scheme).start(start);
        let simulation = builder.maximum_displacement(0.8).seed(seed + replica).build().unwrap();
        observe(simulation, equilibration, sweeps)
    })
}

#[test]
fn isothermal_column_from_above_and_below() {
    let temperature = Isothermal::new(5.0).unwrap();
    let high = side(temperature, ClosedForm, RandomInsertion::default(), 100, 8_000, 24_000);
    let low = side(temperature, ClosedForm, ClosePacked, 200, 8_000, 24_000);
    meet(&high, &low, 0.01).unwrap();
    // Without the equilibration they do not: the test would notice.
    let early = side(temperature, ClosedForm, RandomInsertion::default(), 100, 0, 200);
    meet(&early, &low, 0.5).unwrap_err();
}

#[test]
fn column_in_a_temperature_gradient_from_above_and_below() {
    let temperature = ExponentialTemperature::new(6.0, 0.04).unwrap();
    let scheme = SelfConsistent::default();
    let high = side(temperature, scheme, RandomInsertion::default(), 300, 16_000, 24_000);
    let low = side(temperature, scheme, ClosePacked, 400, 16_000, 24_000);
    meet(&high, &low, 0.015).unwrap();
    let early = side(temperature, scheme, RandomInsertion::default(), 300, 0, 200);
    meet(&early, &low, 0.5).unwrap_err();
}
