//! User-defined field, temperature profile, equation of state, observer and adaptation.
//!
//! Each is used in a small scene with a known result; `cargo run` prints the results and fails if
//! one is wrong.

mod interrupted;

use gradient_mc::drive::{Drive, EquationOfStateClosure, SelfConsistent};
use gradient_mc::moves::LocalMoves;
use gradient_mc::start::ClosePacked;
use gradient_mc::temperature::Isothermal;
use gradient_mc::{
    EquationOfState, Error, Every, Field, Frame, Observer, ObserverError, Scene, Simulation, Slab,
    TemperatureProfile,
};
use std::error::Error as _;
use std::process::ExitCode;

/// A spring to a height: spheres below it are pushed up. One method is enough.
struct Spring {
    stiffness: f64,
    center: f64,
}

impl Field for Spring {
    fn potential(&self, height: f64) -> f64 {
        0.5 * self.stiffness * (height - self.center).powi(2)
    }
}

/// Gravity, with the acceleration given as well, which saves its numerical derivative.
struct Gravity;

impl Field for Gravity {
    fn potential(&self, height: f64) -> f64 {
        height
    }
    fn acceleration(&self, _height: f64) -> f64 {
        1.0
    }
}

/// Heated from below: T falls towards a constant far above.
struct HotPlate {
    plate: f64,
    far: f64,
    depth: f64,
}

impl TemperatureProfile for HotPlate {
    fn temperature(&self, height: f64) -> f64 {
        self.far + (self.plate - self.far) * (-height / self.depth).exp()
    }
}

/// Exact to the third virial coefficient, and good enough for a dilute column.
struct ThreeVirialCoefficients;

impl EquationOfState for ThreeVirialCoefficients {
    fn compressibility_factor(&self, packing_fraction: f64) -> f64 {
        1.0 + packing_fraction * (4.0 + 10.0 * packing_fraction)
    }
}

/// What can go wrong in the observer below.
#[derive(Debug, thiserror::Error)]
#[error("a sphere reached height {height}, above the limit of {limit}")]
struct TooHigh {
    height: f64,
    limit: f64,
}

/// Mean and variance of the heights; refuses spheres above a limit.
struct Heights {
    limit: f64,
    count: f64,
    sum: f64,
    sum_of_squares: f64,
}

impl Heights {
    fn below(limit: f64) -> Self {
        Self { limit, count: 0.0, sum: 0.0, sum_of_squares: 0.0 }
    }
    fn mean(&self) -> f64 {
        self.sum / self.count
    }
    fn variance(&self) -> f64 {
        self.sum_of_squares / self.count - self.mean() * self.mean()
    }
}

impl Observer for Heights {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        for height in frame.heights() {
            if height > self.limit {
                return Err(TooHigh { height, limit: self.limit }.into());
            }
            self.count += 1.0;
            self.sum += height;
            self.sum_of_squares += height * height;
        }
        Ok(())
    }
}

/// Prints a comparison, and whether it holds.
fn check(what: &str, found: f64, expected: f64, tolerance: f64) -> bool {
    let holds = (found - expected).abs() <= tolerance;
    let verdict = if holds { "ok" } else { "WRONG" };
    println!("{what:<64} {found:9.4}  expected {expected:9.4} +- {tolerance:.4}  {verdict}");
    holds
}

fn main() -> Result<ExitCode, Error> {
    let mut all_hold = true;

    // One sphere on a spring is Gaussian: mean at the center, variance T/stiffness.
    let slab = Slab::new(40.0, 4.0, 4.0)?;
    let scene = Scene::new(slab, 1, Spring { stiffness: 0.5, center: 20.0 }, Isothermal::new(2.0)?)?;
    let mut simulation =
        Simulation::builder(scene).start(ClosePacked).moves(LocalMoves::new(2.0)?).seed(1).build()?;
    let mut heights = Heights::below(40.0);
    simulation.equilibrate(10_000, &mut ())?;
    simulation.run(2_000_000, &mut heights)?;
    all_hold &= check("own field: mean height of a sphere on a spring", heights.mean(), 20.0, 0.05);
    all_hold &= check("own field: variance of its height", heights.variance(), 4.0, 0.1);

    // With an equation of state imposed, u' = a/T + Z T'/T. Far above the bed Z is 1.
    let slab = Slab::new(80.0, 8.0, 8.0)?;
    let plate = || HotPlate { plate: 8.0, far: 4.0, depth: 10.0 };
    let scene = Scene::new(slab, 64, Gravity, plate())?;
    let closure = EquationOfStateClosure::new(ThreeVirialCoefficients);
    let mut imposed = Simulation::builder(scene).scheme(closure).start(ClosePacked).seed(2).build()?;
    let potential = |height| imposed.drive().reduced_potential(imposed.scene(), height);
    let rise = potential(70.0) - potential(60.0);
    let expected = rise_of_ideal_gas(&plate(), 60.0, 70.0);
    all_hold &= check("own equation of state: rise of u far above", rise, expected, 1e-3);

    // With the effective field measured instead, the column stands as high, and between those that are
    // as hot everywhere as the plate, and as cold as far away.
    let scene = Scene::new(slab, 64, Gravity, plate())?;
    let scheme = SelfConsistent::default();
    let mut simulation = Simulation::builder(scene).scheme(scheme).start(ClosePacked).seed(3).build()?;
    let mut heights = [(); 2].map(|()| Every::new(5, Heights::below(80.0)));
    imposed.equilibrate(5_000, &mut ())?;
    imposed.run(50_000, &mut heights[0])?;
    simulation.equilibrate(20_000, &mut ())?;
    simulation.run(50_000, &mut heights[1])?;
    let [imposed, measured] = heights.map(|heights| heights.observer.mean());
    all_hold &= check("own temperature: center of mass, measured or imposed field", measured, imposed, 0.25);
    all_hold &= check("own temperature: above the cold and below the hot column", measured, 7.5, 2.0);

    // The observer's own error arrives as the source, and the run can go on.
    let mut limited = Heights::below(5.0);
    let error = simulation.run(10, &mut limited).err();
    let own = error.as_ref().and_then(|error| error.source()?.downcast_ref::<TooHigh>());
    println!("own observer: failed as it should: {own:?}");
    all_hold &= own.is_some_and(|too_high| too_high.height > too_high.limit);
    simulation.run(10, &mut ())?;

    // A checkpoint keeps an observer and an adaptation of one's own, to the last bit.
    let [whole, interrupted] = interrupted::mean_heights()?;
    all_hold &= check("own adaptation: mean height in an interrupted run", interrupted, whole, 0.0);

    Ok(if all_hold { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Rise of u where Z = 1: ∫ dx/T + Δ ln T, by the midpoint rule.
fn rise_of_ideal_gas(profile: &impl TemperatureProfile, low: f64, high: f64) -> f64 {
    let steps = 1000;
    let width = (high - low) / f64::from(steps);
    let inverse = |step: f64| 1.0 / profile.temperature(low + step * width);
    let integral: f64 = (0..steps).map(|step| inverse(f64::from(step) + 0.5) * width).sum();
    integral + (profile.temperature(high) / profile.temperature(low)).ln()
}
