//! A user-defined adaptation in a checkpoint: an interrupted run has the same bits as an
//! uninterrupted one.

use super::{Gravity, Heights, HotPlate};
use gradient_mc::checkpoint::{Archive, Persist, Snapshot};
use gradient_mc::drive::{Adaptation, EffectivePotential, Scheme};
use gradient_mc::{
    AnyScene, Error, Field, Frame, Observer, ObserverError, Scene, Simulation, Slab, TemperatureProfile,
};

/// P/n = T (1 + 4η) with the packing fraction below the center of mass, smoothed over sweeps.
#[derive(Default)]
struct Crude {
    packing_fraction: f64,
}

impl Observer for Crude {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        let center = frame.heights().sum::<f64>() / frame.particles() as f64;
        let below = frame.heights().filter(|&height| height < center).count();
        let now = 0.5236 * below as f64 / (center * frame.slab().base_area());
        self.packing_fraction += 0.01 * (now - self.packing_fraction);
        Ok(())
    }
}

impl Adaptation<EffectivePotential> for Crude {
    fn adapt(&mut self, potential: &mut EffectivePotential, scene: &AnyScene<'_>) -> Result<(), Error> {
        let factor = 1.0 + 4.0 * self.packing_fraction;
        let heights: Vec<f64> = potential.heights().collect();
        potential.set(0.0, |bin| factor * scene.temperature().temperature(heights[bin]))
    }
}

impl Persist for Crude {
    fn persist(&mut self, archive: &mut Archive<'_>) -> Result<(), Error> {
        archive.value("packing fraction", &mut self.packing_fraction)
    }
}

#[derive(Clone)]
struct CrudeScheme;

impl<F: Field, T: TemperatureProfile> Scheme<F, T> for CrudeScheme {
    type Drive = EffectivePotential;
    type Adaptation = Crude;
    fn drive(self, scene: &Scene<F, T>) -> Result<(EffectivePotential, Crude), Error> {
        Ok((EffectivePotential::new(scene, 0.1)?, Crude::default()))
    }
}

impl Persist for Heights {
    fn persist(&mut self, archive: &mut Archive<'_>) -> Result<(), Error> {
        archive.same("limit", &self.limit)?;
        archive.value("count", &mut self.count)?;
        archive.value("sum", &mut self.sum)?;
        archive.value("sum of squares", &mut self.sum_of_squares)
    }
}

/// Mean heights of spheres in a run, and in the same run with a file in its middle.
pub fn mean_heights() -> Result<[f64; 2], Error> {
    let simulation = || {
        let scene = Scene::new(
            Slab::new(60.0, 4.0, 4.0)?,
            30,
            Gravity,
            HotPlate { plate: 6.0, far: 3.0, depth: 10.0 },
        )?;
        Ok::<_, Error>(Simulation::builder(scene).scheme(CrudeScheme).seed(4))
    };
    let mut whole = Heights::below(60.0);
    simulation()?.build()?.run(600, &mut whole)?;

    let mut first = Heights::below(60.0);
    let mut interrupted = simulation()?.build()?;
    interrupted.run(333, &mut first)?;
    let bytes = interrupted.snapshot(&mut first)?.to_bytes();
    let mut second = Heights::below(60.0);
    simulation()?.resume(&Snapshot::from_bytes(&bytes)?, &mut second)?.run(267, &mut second)?;
    Ok([whole.mean(), second.mean()])
}
