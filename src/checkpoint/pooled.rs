//! Merging the results of many processes.

use super::{Persist, Snapshot};
use crate::drive::Scheme;
use crate::{Error, Field, Merge, SimulationBuilder, TemperatureProfile};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

impl<F: Field, T: TemperatureProfile, S: Scheme<F, T>> SimulationBuilder<F, T, S> {
    /// Reads the observers of several runs of this simulation from their checkpoints and
    /// [merges](Merge) them in this order. The runs are replicas by other processes or on other
    /// machines. `observer` is an empty observer, made as those of the runs.
    ///
    /// The result has the same bits as that of [`Replicas`](crate::Replicas) in one process. A run
    /// need not be finished.
    ///
    /// ```
    /// use gradient_mc::checkpoint::Run;
    /// use gradient_mc::observers::CenterOfMass;
    /// use gradient_mc::{Replicas, Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
    /// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 36, UniformField::default(), Isothermal::new(5.0)?)?;
    /// let builder = Simulation::builder(scene);
    /// let folder = std::env::temp_dir().join(format!("gradient-mc-pooled-{}", std::process::id()));
    /// let paths = [0, 1, 2].map(|task| folder.join(format!("task_{task}")));
    /// // Each of these in a process of its own.
    /// for task in 0..3 {
    ///     let seed = Replicas::new(3).seed(1).replica(task).seed();
    ///     Run::new(&paths[task], 100, 200).of(builder.clone().seed(seed), &mut CenterOfMass::new())?;
    /// }
    /// println!("{}", builder.pooled(paths, &CenterOfMass::new())?.estimate()?);
    /// # std::fs::remove_dir_all(folder).ok();
    /// # Ok::<(), gradient_mc::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::CheckpointFile`] with the path of the first file that cannot be used, and the cause
    /// as its source: the file cannot be read, is damaged, has another scene, scheme, moves or
    /// observer, or has no production yet. [`Error::SameSeed`] if two runs have the same seed;
    /// [`Error::TooFewObservations`] if there is no file.
    pub fn pooled<O: Persist + Merge + Clone>(
        self,
        paths: impl IntoIterator<Item = impl AsRef<Path>>,
        observer: &O,
    ) -> Result<O, Error> {
        let identity = self.identity()?;
        let mut seeds = HashMap::<u64, PathBuf>::new();
        let mut pooled: Option<O> = None;
        for path in paths {
            let path = path.as_ref();
            let snapshot = Snapshot::read(path)?;
            if let Some(other) = seeds.insert(snapshot.seed, path.into()) {
                return Err(Error::SameSeed { seed: snapshot.seed, paths: [other, path.into()] });
            }
            let mut merge = || {
                identity.require_same(&snapshot.identity)?;
                require_measured(&snapshot)?;
                let mut seen = observer.clone();
                snapshot.restore_observer(&mut seen)?;
                if let Some(pooled) = &mut pooled {
                    return pooled.merge(&seen);
                }
                pooled = Some(seen);
                Ok(())
            };
            merge().map_err(|error| Error::CheckpointFile { path: path.into(), source: error.into() })?;
        }
        let what = "checkpoints to be pooled";
        pooled.ok_or(Error::TooFewObservations { what, available: 0, needed: 1 })
    }
}

fn require_measured(snapshot: &Snapshot) -> Result<(), Error> {
    let what = "sweeps of production in a checkpoint";
    if snapshot.measured > 0 {
        Ok(())
    } else {
        Err(Error::TooFewObservations { what, available: 0, needed: 1 })
    }
}
