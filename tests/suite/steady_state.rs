//! Runs that start far too high and far too low reach the same steady state.
//!
//! Standard errors are from independent replicas, so that they include what a single run does not
//! show: its slowest mode, and the noise of the frozen self-consistent field.

use gradient_mc::drive::{Automatic, Scheme, SelfConsistent};
use gradient_mc::field::UniformField;
use gradient_mc::moves::EventChains;
use gradient_mc::observers::{Bins, CenterOfMass, DensityProfile};
use gradient_mc::start::{ClosePacked, RandomInsertion, Start};
use gradient_mc::temperature::{ExponentialTemperature, Isothermal};
use gradient_mc::{Every, Scene, Simulation, Slab, TemperatureProfile};

const REPLICAS: u64 = 5;
/// Density is compared in bands of this height, from the base.
const BAND: f64 = 4.0;
const BANDS: usize = 5;
/// A t variate of 8 degrees of freedom exceeds 6 as rarely as a Gaussian one exceeds about 3.6.
const SIGMAS: f64 = 6.0;

/// Center of mass and densities of one replica.
fn observe<T: TemperatureProfile, S: Scheme<UniformField, T>>(
    mut simulation: Simulation<UniformField, T, S>,
    equilibration: u64,
    sweeps: u64,
) -> Vec<f64> {
    let slab = *simulation.scene().slab();
    let bands =
        DensityProfile::new(&slab, Bins::count(BANDS).from(0.5).to(0.5 + BAND * BANDS as f64)).unwrap();
    let mut observers = Every::new(2, (CenterOfMass::new(), bands));
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
    println!("from above {high:.4?}, from below {low:.4?}");
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

/// Whether the center of mass is still above: by more than the same number of joint errors, the
/// relative error below `cap`.
fn is_above(high: &[(f64, f64)], low: &[(f64, f64)], cap: f64) -> Result<(), String> {
    let (a, b) = (high[0], low[0]);
    let error = a.1.hypot(b.1);
    if error < cap * a.0 && a.0 - b.0 > SIGMAS * error {
        Ok(())
    } else {
        Err(format!("{a:?} is not above {b:?}"))
    }
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
    P: Start + Copy + 'static,
{
    let slab = Slab::new(80.0, 5.0, 5.0).unwrap();
    let scene = Scene::new(slab, 250, UniformField::default(), temperature).unwrap();
    replicate(|replica| {
        let builder = Simulation::builder(scene).scheme(scheme).start(start);
        let simulation = builder.moves(EventChains::default()).seed(seed + replica).build().unwrap();
        observe(simulation, equilibration, sweeps)
    })
}

#[test]
fn isothermal_column_from_above_and_below() {
    let temperature = Isothermal::new(5.0).unwrap();
    let high = side(temperature, Automatic, RandomInsertion::default(), 100, 500, 2_500);
    let low = side(temperature, Automatic, ClosePacked, 200, 500, 2_500);
    meet(&high, &low, 0.01).unwrap();
    // Without the equilibration they do not: the test would notice.
    let early = side(temperature, Automatic, RandomInsertion::default(), 100, 0, 50);
    is_above(&early, &low, 0.03).unwrap();
}

#[test]
fn column_in_a_temperature_gradient_from_above_and_below() {
    let temperature = ExponentialTemperature::new(6.0, 0.04).unwrap();
    let scheme = SelfConsistent::default();
    let high = side(temperature, scheme, RandomInsertion::default(), 300, 2_000, 3_000);
    let low = side(temperature, scheme, ClosePacked, 400, 2_000, 3_000);
    meet(&high, &low, 0.015).unwrap();
    let early = side(temperature, scheme, RandomInsertion::default(), 300, 0, 50);
    is_above(&early, &low, 0.03).unwrap();
}
