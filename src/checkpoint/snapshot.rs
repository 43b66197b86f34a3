//! The complete state of a run.

use super::file::{Reader, Writer};
use super::{Archive, Identity, Persist};
use crate::Error;
use std::fmt;

/// The complete state of a run as plain data. [`Simulation::snapshot`](crate::Simulation::snapshot)
/// makes it, and [`SimulationBuilder::resume`](crate::SimulationBuilder::resume) continues from it.
///
/// Two snapshots are equal only if the runs have the same bits.
///
/// ```
/// use gradient_mc::checkpoint::Snapshot;
/// use gradient_mc::observers::CenterOfMass;
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 36, UniformField::default(), Isothermal::new(5.0)?)?;
/// let builder = Simulation::builder(scene).seed(1);
/// let mut observer = CenterOfMass::new();
/// let mut simulation = builder.clone().build()?;
/// simulation.run(100, &mut observer)?;
/// let path = std::env::temp_dir().join(format!("gradient-mc-{}.checkpoint", std::process::id()));
/// simulation.snapshot(&mut observer)?.write(&path)?;
/// // In a later process:
/// let mut observer = CenterOfMass::new();
/// let mut simulation = builder.resume(&Snapshot::read(&path)?, &mut observer)?;
/// simulation.run(100, &mut observer)?;
/// assert_eq!(observer.heights().len(), 200);
/// # std::fs::remove_file(path).ok();
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Clone, PartialEq, Eq)]
pub struct Snapshot {
    pub(super) seed: u64,
    pub(super) sweep: u64,
    /// Number of sweeps of production.
    pub(super) measured: u64,
    /// Identity of the run.
    pub(super) identity: String,
    /// State of the simulation.
    pub(super) state: Vec<u8>,
    pub(super) observer: Vec<u8>,
}

impl Snapshot {
    pub(crate) fn of(
        identity: &Identity,
        [sweep, measured]: [u64; 2],
        state: Vec<u8>,
        observer: Vec<u8>,
    ) -> Self {
        let Identity { seed, simulated } = identity.clone();
        Self { seed, sweep, measured, identity: simulated, state, observer }
    }

    /// The bytes that `write` writes.
    pub(crate) fn piece(write: impl FnOnce(&mut Archive<'_>) -> Result<(), Error>) -> Result<Vec<u8>, Error> {
        let mut archive = Archive::writing();
        write(&mut archive)?;
        archive.finish()
    }

    pub(crate) fn require_same(&self, identity: &Identity) -> Result<(), Error> {
        identity.require_same(&self.identity)?;
        identity.require_same_seed(self.seed)
    }

    /// Reads the state of the simulation.
    pub(crate) fn restore(
        &self,
        read: impl FnOnce(&mut Archive<'_>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let mut archive = Archive::reading(&self.state);
        read(&mut archive)?;
        archive.finish().map(|_| ())
    }

    pub(crate) fn restore_observer<O: Persist + ?Sized>(&self, observer: &mut O) -> Result<(), Error> {
        let mut archive = Archive::reading(&self.observer);
        observer.persist(&mut archive)?;
        archive.finish().map(|_| ())
    }

    /// Seed of the run.
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Number of sweeps so far, equilibration included.
    #[must_use]
    pub fn sweep(&self) -> u64 {
        self.sweep
    }

    /// The bytes of a [file](crate::checkpoint#the-file).
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        let Self { seed, sweep, measured, identity, state, observer } = self;
        let mut writer = Writer::new(identity.len() + state.len() + observer.len());
        for number in [seed, sweep, measured] {
            writer.number(*number);
        }
        for piece in [identity.as_bytes(), state, observer] {
            writer.piece(piece);
        }
        writer.finish()
    }

    /// Makes a snapshot from the bytes of [`to_bytes`](Self::to_bytes). Whether it belongs to a
    /// simulation is checked when the run is continued.
    ///
    /// # Errors
    /// [`Error::CheckpointDamaged`] if the bytes are not a valid checkpoint;
    /// [`Error::CheckpointVersion`] for another version of the format.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, Error> {
        let mut reader = Reader::new(bytes)?;
        let [seed, sweep, measured] = [reader.number()?, reader.number()?, reader.number()?];
        let [identity, state, observer] = [reader.piece()?, reader.piece()?, reader.piece()?];
        reader.finish()?;
        let identity = String::from_utf8(identity)
            .map_err(|_| Error::CheckpointDamaged { what: "identity of the run".into() })?;
        Ok(Self { seed, sweep, measured, identity, state, observer })
    }
}

impl fmt::Debug for Snapshot {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Snapshot")
            .field("seed", &self.seed)
            .field("sweep", &self.sweep)
            .field("sweeps_of_production", &self.measured)
            .field("bytes", &(self.identity.len() + self.state.len() + self.observer.len()))
            .finish_non_exhaustive()
    }
}
