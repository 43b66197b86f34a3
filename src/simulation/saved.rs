//! Snapshots of simulations, and simulations that continue from one.

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
    /// Takes a snapshot of the complete state of the run and of `observer` (`&mut ()` for none).
    /// Both are unchanged; they are borrowed mutably because one method both writes and reads.
    ///
    /// # Errors
    /// Those of the observer, and of your own drive or adaptation.
    pub fn snapshot<O: Persist + ?Sized>(&mut self, observer: &mut O) -> Result<Snapshot, Error> {
        let state = Snapshot::piece(|archive| self.persist(archive))?;
        let observer = Snapshot::piece(|archive| observer.persist(archive))?;
        let measured = if self.phase == Phase::Production { self.sweep - self.before_phase } else { 0 };
        Ok(Snapshot::of(&self.identity, [self.sweep, measured], state, observer))
    }

    /// Overwrites the state of the run by that of a snapshot, which must not be of an earlier
    /// sweep.
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

/// Whether the state of a generator is valid: an odd number. It is written as a single number with
/// the lowest bits first.
fn is_odd(generator: &Generator) -> bool {
    postcard::to_allocvec(generator).is_ok_and(|bytes| bytes.first().is_some_and(|byte| byte & 1 == 1))
}

impl<F: Field, T: TemperatureProfile, S> SimulationBuilder<F, T, S> {
    /// Builds the simulation and continues from a `snapshot`, with the same bits as without the
    /// interruption. The state of `observer`, made by the same code, is overwritten by that of the
    /// snapshot. The start is not used.
    ///
    /// # Errors
    /// [`Error::CheckpointMismatch`] if scene, scheme, moves, seed or observer differ from those of
    /// the snapshot; [`Error::CheckpointDamaged`] if the state is invalid; those of
    /// [`build`](Self::build). The observer must not be used after an error.
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

    /// The identity of the simulation that this builder makes.
    pub(crate) fn identity(self) -> Result<Identity, Error>
    where
        S: Scheme<F, T>,
    {
        Ok(self.place(|scene, _, _| Ok(Configuration::empty(*scene.slab())))?.identity)
    }
}
