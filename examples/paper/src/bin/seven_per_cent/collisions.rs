//! A corrected form of the scheme of the paper: the field is updated every sweep, but from Z as
//! measured by collisions so far (eq. 20) instead of P/n of one configuration (eq. 24).

use gradient_mc::checkpoint::{Archive, Persist};
use gradient_mc::drive::{Adaptation, EffectivePotential, Scheme};
use gradient_mc::{
    AcceptedMove, AnyScene, Collision, Error, Field, Frame, Observer, ObserverError, Recorder, Scene,
    TemperatureProfile,
};

/// P/n = T Z with Z = 1 + (sum of separations)/(path) of all event chains so far, in bins of one
/// diameter; 1 where none has passed. Bins of the potential have the width given.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RunningCollisions {
    pub(crate) bin_width: f64,
}

/// The adaptation of [`RunningCollisions`]: paths and separations by height.
#[derive(Debug)]
pub(crate) struct Sums(Vec<[f64; 2]>);

impl<F: Field, T: TemperatureProfile> Scheme<F, T> for RunningCollisions {
    type Drive = EffectivePotential;
    type Adaptation = Sums;

    fn drive(self, scene: &Scene<F, T>) -> Result<(EffectivePotential, Sums), Error> {
        let sums = Sums(vec![[0.0; 2]; bin(scene.slab().height()) + 1]);
        let mut potential = EffectivePotential::new(scene, self.bin_width)?;
        sums.set(&mut potential, |height| scene.temperature().temperature(height))?;
        Ok((potential, sums))
    }
}

fn bin(height: f64) -> usize {
    // Heights are inside the slab; the cast saturates.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let bin = height as usize;
    bin
}

impl Sums {
    fn add(&mut self, height: f64, which: usize, value: f64) {
        let last = self.0.len() - 1;
        self.0[bin(height).min(last)][which] += value;
    }

    fn set(&self, potential: &mut EffectivePotential, temperature: impl Fn(f64) -> f64) -> Result<(), Error> {
        let ratio = |height: f64| {
            let [path, separations] = self.0[bin(height)];
            temperature(height) * (1.0 + if path > 0.0 { separations / path } else { 0.0 })
        };
        let ratios: Vec<f64> = potential.heights().map(ratio).collect();
        potential.set(0.0, |bin| ratios[bin])
    }
}

impl Observer for Sums {
    fn observe(&mut self, _: &Frame<'_>) -> Result<(), ObserverError> {
        Ok(())
    }

    fn recorder(&mut self) -> Option<&mut dyn Recorder> {
        Some(self)
    }
}

impl Recorder for Sums {
    fn record_move(&mut self, accepted: &AcceptedMove) {
        if let Some(axis) = accepted.chain_axis {
            let middle = accepted.from_height + 0.5 * accepted.displacement.x;
            self.add(middle, 0, accepted.displacement[axis].abs());
        }
    }

    fn record_collision(&mut self, collision: &Collision) {
        for height in [collision.from_height, collision.to_height] {
            self.add(height, 1, 0.5 * collision.separation);
        }
    }

    fn wants_local_moves(&mut self) -> bool {
        false
    }
}

impl Persist for Sums {
    fn persist(&mut self, archive: &mut Archive<'_>) -> Result<(), Error> {
        archive.slice("paths and separations", &mut self.0)
    }
}

impl Adaptation<EffectivePotential> for Sums {
    fn adapt(&mut self, potential: &mut EffectivePotential, scene: &AnyScene<'_>) -> Result<(), Error> {
        self.set(potential, |height| scene.temperature().temperature(height))
    }
}
