//! Checkpoints: runs that are stopped and continued with the same bits.
//!
//! A [`Snapshot`] holds the complete state of a run: positions, random number generator, tuned and
//! adapted parameters, records for warnings, and the data of observers. To continue, the same code
//! builds the simulation again and the snapshot overwrites its state
//! ([`SimulationBuilder::resume`](crate::SimulationBuilder::resume)). Fields, temperatures and
//! closures are not stored, but compared. A run of 2k sweeps has the same bits as one of k sweeps,
//! a checkpoint, and k more.
//!
//! | purpose | use |
//! |---|---|
//! | a long run in one call, continued after an interruption | [`Run`] |
//! | several stages, each with its own observers | [`Run::on`] |
//! | end a run by a signal | `Signals`, with the feature `signals` |
//! | merge the results of many processes | [`SimulationBuilder::pooled`](crate::SimulationBuilder::pooled) |
//! | your own observer, drive or adaptation in checkpoints | [`Persist`] |
//! | single steps | [`Simulation::snapshot`](crate::Simulation::snapshot), [`Snapshot::write`], [`Snapshot::read`] |
//!
//! # Many tasks of a queue
//! Each task of a job array runs one replica, chosen by its number, and gets a signal before its
//! time limit. Submit the same script again to continue. With Slurm:
//!
//! ```sh
//! #!/bin/sh
//! #SBATCH --array=0-99
//! #SBATCH --time=24:00:00
//! # SIGUSR1 to the program, ten minutes before the end.
//! #SBATCH --signal=USR1@600
//! srun ./my_program "$SLURM_ARRAY_TASK_ID"
//! ```
//!
//! The program makes the [`Run`] of its task, with `stop_on(signals.flag())`:
//!
//! ```
//! use gradient_mc::checkpoint::Run;
//! use gradient_mc::observers::CenterOfMass;
//! use gradient_mc::{Replicas, Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
//! # let folder = std::env::temp_dir().join(format!("gradient-mc-array-{}", std::process::id()));
//! # let arguments = ["my_program", "0"].map(String::from);
//! // let arguments: Vec<String> = std::env::args().collect();
//! let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 36, UniformField::default(), Isothermal::new(5.0)?)?;
//! let builder = Simulation::builder(scene);
//! let task: usize = arguments[1].parse()?;
//! let seed = Replicas::new(100).seed(1).replica(task).seed();
//! let path = folder.join(format!("task_{task}"));
//! let (_, ended) = Run::new(&path, 100, 200).of(builder.clone().seed(seed), &mut CenterOfMass::new())?;
//! println!("{ended}");
//! // When all tasks are finished: the merged results, as from one process.
//! let paths = (0..100).map(|task| folder.join(format!("task_{task}"))).filter(|path| path.exists());
//! println!("{}", builder.pooled(paths, &CenterOfMass::new())?.estimate()?);
//! # std::fs::remove_dir_all(folder)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The file
//! The file begins with eight bytes `gmc-ckpt`, the version of the format (four bytes; all numbers
//! are little-endian), the CRC-32 of the rest, and the length of the rest in bytes. Then follow
//! seed, sweep and sweeps of production, and three pieces, each after its length: the identity of
//! the run, the state of the simulation, and the state of the observer. A piece is a list of items
//! encoded by [`postcard`](https://postcard.jamesmunns.com/wire-format), each after its name. A
//! file of another version is refused.
//!
//! A damaged file gives an error. Reading a file needs at most 32 times its size in memory, in
//! addition to the memory of the scene.

mod archive;
mod file;
mod identity;
mod parts;
mod pooled;
mod run;
#[cfg(feature = "signals")]
mod signals;
mod snapshot;

pub use archive::{Archive, Persist};
pub(crate) use identity::Identity;
pub use run::{Ended, Progress, Reason, Run};
#[cfg(feature = "signals")]
pub use signals::Signals;
pub use snapshot::Snapshot;
