//! Simulations that go on from a snapshot.

use super::{Configuration, Generator, Phase, Simulation, SimulationBuilder};
use crate::checkpoint::{Archive, Identity, Persist, Snapshot};
use crate::drive::Scheme;
use crate::{Error, Field, TemperatureProfile};

impl<F, T, S> Simulation<F, T, S>
where
    F: Field,
    T: TemperatureProfile,
    S: Scheme<F, T, Drive: Persist, Adaptation: Persist>,
{
    /// All that the run and what observes it have become; `&mut ()` observes nothing. Neither is
    /// changed: they are borrowed mutably because one method both writes and reads.
    ///
    /// # Errors
    /// Those of the observer, or of a drive or an adaptation of your own.
    pub fn snapshot<O: Persist + ?Sized>(&mut self, observer: &mut O) -> Result<Snapshot, Error> {
        let state = Snapshot::piece(|archive| self.persist(archive))?;
        let observer = Snapshot::piece(|archive| observer.persist(archive))?;
        let measured = if self.phase == Phase::Production { self.sweep - self.before_phase } else { 0 };
        Ok(Snapshot::of(&self.identity, [self.sweep, measured], state, observer))
    }

    /// Overwrites what the run has become by what it was in a snapshot, which must not be of an
    /// earlier sweep.
    pub(crate) fn restore<O: Persist + ?Sized>(
        &mut self,
        snapshot: &Snapshot,
        observer: &mut O,
    ) -> Result<(), Error> {
        snapshot.require_same(&self.identity)?;
        let (saved, given) = (snapshot.sweep(), self.sweep);
        if saved < given {
            let (saved, given) = (saved.to_string(), given.to_string());
            return Err(Error::CheckpointMismatch { what: "number of the sweep".into(), saved, given });
        }
        self.configuration = Configuration::empty(*self.driven.scene.slab());
        snapshot.restore(|archive| self.persist(archive))?;
        snapshot.restore_observer(observer)
    }

    fn persist(&mut self, archive: &mut Archive<'_>) -> Result<(), Error> {
        let Self { driven, adaptation, engine, configuration, generator, monitor, balance, .. } = self;
        archive.value("generator", generator)?;
        archive.check(is_odd(generator))?;
        archive.count("sweep", &mut self.sweep)?;
        archive.count("sweeps before the phase", &mut self.before_phase)?;
        archive.value("phase", &mut self.phase)?;
        archive.check(self.before_phase <= self.sweep)?;
        archive.part("moves counted", &mut self.move_counts)?;
        archive.within("drive", |archive| driven.drive.persist(archive))?;
        archive.within("adaptation", |archive| adaptation.persist(archive))?;
        archive.within("engine", |archive| engine.persist(archive, configuration.grid()))?;
        archive.part("monitor", monitor)?;
        archive.part("balance of forces", balance)?;
        archive.within("spheres", |archive| configuration.persist(archive, driven.scene.particles()))
    }
}

/// Whether the state of a generator is one that it can have: an odd number. It is the first and
/// only one that is written, its lowest bits first.
fn is_odd(generator: &Generator) -> bool {
    postcard::to_allocvec(generator).is_ok_and(|bytes| bytes.first().is_some_and(|byte| byte & 1 == 1))
}

impl<F: Field, T: TemperatureProfile, S> SimulationBuilder<F, T, S> {
    /// Makes a simulation as [`build`](Self::build) does and goes on from a `snapshot` of one, with
    /// the same bits as if it had not been interrupted. The observer, made anew by the same
    /// code too, gets back what it had seen. There is no start.
    ///
    /// # Errors
    /// [`Error::CheckpointMismatch`] with what differs if the snapshot is of another scene, scheme,
    /// seed, of other moves, or of another observer; [`Error::CheckpointDamaged`] for a state
    /// that cannot be; those of [`build`](Self::build). An observer that was to be read is of
    /// no use then.
    pub fn resume<O: Persist + ?Sized>(
        self,
        snapshot: &Snapshot,
        observer: &mut O,
    ) -> Result<Simulation<F, T, S>, Error>
    where
        S: Scheme<F, T, Drive: Persist, Adaptation: Persist>,
    {
        let mut simulation = self.place(|scene, _, _| Ok(Configuration::empty(*scene.slab())))?;
        simulation.restore(snapshot, observer)?;
        Ok(simulation)
    }

    /// What a simulation that this makes is of.
    pub(crate) fn identity(self) -> Result<Identity, Error>
    where
        S: Scheme<F, T>,
    {
        Ok(self.place(|scene, _, _| Ok(Configuration::empty(*scene.slab())))?.identity)
    }
}
