//! The check that an observer samples one run only.

use crate::statistics::BlockAverages;
use crate::{Error, Frame, Merge as _, Slab};

/// Number of heights, unevenly spaced, at which field and temperature are compared.
const PROBES: usize = 8;

/// Identifies the run of an observer. Frames with another slab, number of spheres, field or
/// temperature are refused, and frames whose sweep number does not increase.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct OneRun {
    /// Slab given to the constructor of the observer.
    slab: Option<Slab>,
    scene: Option<Seen>,
    last_sweep: Option<u64>,
}

/// The properties of a scene that are compared.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "checkpoint", derive(serde::Serialize, serde::Deserialize))]
struct Seen {
    extents: [f64; 3],
    particles: usize,
    potentials: [f64; PROBES],
    temperatures: [f64; PROBES],
}

impl Seen {
    fn of(frame: &Frame<'_>) -> Self {
        let slab = *frame.slab();
        let [lowest, highest] = [slab.lowest_center(), slab.highest_center()];
        let heights: [f64; PROBES] = std::array::from_fn(|probe| {
            // Multiples of the golden ratio fill an interval uniformly.
            lowest + (highest - lowest) * (probe as f64 * 0.618_033_988_749_895).fract()
        });
        Self {
            extents: extents(&slab),
            particles: frame.particles(),
            potentials: heights.map(|height| frame.field().potential(height)),
            temperatures: heights.map(|height| frame.temperature().temperature(height)),
        }
    }

    /// Name of the first property that differs, and its two values.
    fn difference(&self, other: &Self) -> Option<(&'static str, f64, f64)> {
        let particles = ("number of spheres", self.particles as f64, other.particles as f64);
        let of = |name: &'static str, mine: [f64; PROBES], others: [f64; PROBES]| {
            mine.into_iter().zip(others).map(move |(mine, other)| (name, mine, other))
        };
        lengths(self.extents, other.extents)
            .chain([particles])
            .chain(of("potential of the field", self.potentials, other.potentials))
            .chain(of("temperature", self.temperatures, other.temperatures))
            .find(differs)
    }
}

fn extents(slab: &Slab) -> [f64; 3] {
    let [width_y, width_z] = slab.widths();
    [slab.height(), width_y, width_z]
}

fn lengths(mine: [f64; 3], other: [f64; 3]) -> impl Iterator<Item = (&'static str, f64, f64)> {
    let names = ["height of the slab", "width along y", "width along z"];
    names.into_iter().zip(mine.into_iter().zip(other)).map(|(name, (mine, other))| (name, mine, other))
}

fn differs((_, mine, other): &(&'static str, f64, f64)) -> bool {
    mine.to_bits() != other.to_bits()
}

impl OneRun {
    /// For an observer that was made for a slab.
    pub(super) fn in_slab(slab: &Slab) -> Self {
        Self { slab: Some(*slab), ..Self::default() }
    }

    /// Checks and records a frame, before anything is counted.
    ///
    /// # Errors
    /// [`Error::AnotherRun`] for a frame of another run; the record is unchanged then.
    pub(super) fn admit(&mut self, frame: &Frame<'_>) -> Result<(), Error> {
        let other_slab = || lengths(extents(self.slab.as_ref()?), extents(frame.slab())).find(differs);
        let shown = Seen::of(frame);
        let other_scene = || self.scene?.difference(&shown);
        let earlier = || {
            let last = self.last_sweep.filter(|&last| frame.sweep() <= last)?;
            Some(("number of the sweep", last as f64, frame.sweep() as f64))
        };
        if let Some((what, seen, shown)) = other_slab().or_else(other_scene).or_else(earlier) {
            return Err(Error::AnotherRun { what, seen, shown });
        }
        (self.scene, self.last_sweep) = (Some(shown), Some(frame.sweep()));
        Ok(())
    }

    /// Whether the last frame was of this sweep or a later one.
    #[cfg(feature = "checkpoint")]
    pub(super) fn is_past(&self, sweep: u64) -> bool {
        self.last_sweep.is_some_and(|last| sweep <= last)
    }

    /// Fails if two observers have sampled different scenes.
    pub(super) fn require_same_scene(&self, other: &Self) -> Result<(), Error> {
        match self.scene.zip(other.scene).and_then(|(mine, other)| mine.difference(&other)) {
            None => Ok(()),
            Some((name, _, value)) => {
                let requirement = "observers can only be pooled if they sampled the same scene";
                Err(Error::InvalidParameter { name, value, requirement })
            }
        }
    }

    /// Merges the averages of a replica, which must be of the same scene.
    pub(super) fn pool(
        &mut self,
        averages: &mut BlockAverages,
        other: &Self,
        others: &BlockAverages,
    ) -> Result<(), Error> {
        self.require_same_scene(other)?;
        averages.merge(others)?;
        self.join(other);
        Ok(())
    }

    /// Merges the record of a replica. An observer without frames takes over its scene.
    pub(super) fn join(&mut self, other: &Self) {
        self.scene = self.scene.or(other.scene);
    }
}

persist!(OneRun { same slab, value scene, value last_sweep });

#[cfg(test)]
mod tests {
    use super::super::test_frame::Scene;
    use super::super::{Bins, CenterOfMass, ChainPressureProfile, DensityProfile, DisplacementProfile};
    use super::super::{EquationOfStateFit, WallPressure};
    use super::super::{EquationOfStateProfile, HexaticOrder, NeighborAngles, PressureProfile};
    use super::super::{RadialDistribution, StructureProfile};
    use super::*;
    use crate::field::UniformField;
    use crate::temperature::Isothermal;
    use crate::{Merge, Observer};

    /// An observer that has seen sweep 7 accepts sweep 8, and refuses frames of another run.
    fn looks_at_one_run<O: Observer + Merge + Clone>(observer: &O) {
        let scene = || Scene::new(20.0, &[1.0, 2.0, 3.5]);
        let mut observer = observer.clone();
        let fresh = observer.clone();
        let first = scene();
        first.sweep.set(7);
        observer.observe(&first.frame()).unwrap();
        let mut others = [scene(), scene(), scene(), scene(), scene(), scene()];
        others[0].slab = Slab::new(20.5, 5.0, 5.0).unwrap();
        others[1].slab = Slab::new(20.0, 5.0, 4.0).unwrap();
        others[2].place(&[1.0, 2.0]);
        others[3].field = Box::new(UniformField::new(1.01).unwrap());
        others[4].temperature = Box::new(Isothermal::new(5.1).unwrap());
        let names = ["height", "width along z", "number of spheres", "potential", "temperature", "sweep"];
        for (other, name) in others.iter().zip(names) {
            other.sweep.set(if name == "sweep" { 7 } else { 8 });
            let refused = observer.observe(&other.frame()).unwrap_err();
            let refused = refused.downcast::<Error>().unwrap();
            assert!(matches!(*refused, Error::AnotherRun { what, .. } if what.contains(name)), "{refused}");
            // Its slab is known before the first frame; other properties are not.
            let mut other_observer = fresh.clone();
            if other_observer.observe(&other.frame()).is_ok() && name != "sweep" {
                let refused = observer.merge(&other_observer).unwrap_err();
                assert!(matches!(refused, Error::InvalidParameter { .. }), "{refused}");
            }
        }
        observer.observe(&first.frame()).unwrap();
        // A replica has its own sweep numbers, and an empty one takes over the scene when it is
        // merged.
        let mut replica = fresh.clone();
        replica.merge(&observer).unwrap();
        assert!(replica.observe(&others[2].frame()).is_err());
        others[5].sweep.set(1);
        replica.observe(&others[5].frame()).unwrap();
        observer.merge(&replica).unwrap();
    }

    #[test]
    fn every_observer_looks_at_one_run() {
        let (field, temperature) = (UniformField::default(), Isothermal::new(5.0).unwrap());
        let scene = crate::Scene::unchecked(Scene::new(20.0, &[]).slab, 3, field, temperature);
        looks_at_one_run(&EquationOfStateFit::new(&scene).unwrap());
        looks_at_one_run(&WallPressure::new(&scene).unwrap());
        let slab = Scene::new(20.0, &[]).slab;
        let bins = Bins::count(10);
        looks_at_one_run(&CenterOfMass::new());
        looks_at_one_run(&DensityProfile::new(&slab, bins).unwrap());
        looks_at_one_run(&PressureProfile::new(&slab, bins).unwrap());
        looks_at_one_run(&EquationOfStateProfile::new(&slab, bins).unwrap());
        looks_at_one_run(&ChainPressureProfile::new(&slab, bins).unwrap());
        looks_at_one_run(&DisplacementProfile::new(&slab, bins).unwrap());
        looks_at_one_run(&StructureProfile::new(&slab, bins).unwrap());
        looks_at_one_run(&RadialDistribution::new(&slab, 0.0, 1.0, 10).unwrap());
        looks_at_one_run(&NeighborAngles::new(&slab, 0.0, 1.0, 10).unwrap());
        looks_at_one_run(&HexaticOrder::new(&slab, 0.0, 1.0, 1.4).unwrap());
    }
}
