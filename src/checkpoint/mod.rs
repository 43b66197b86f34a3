//! Runs that are stopped and go on as if they had not been.
//!
//! A [`Snapshot`] holds all that a run has become: positions, the generator, what was tuned and
//! adapted, what judges the run, and what observers have seen, also in an interval under way. It
//! goes on in a simulation made by the same code, whose numbers are overwritten
//! ([`SimulationBuilder::resume`](crate::SimulationBuilder::resume)); fields, temperatures and
//! closures are not kept, but compared. 2k sweeps are the same bits as k, a file, and k more.
//!
//! | you want | take |
//! |---|---|
//! | a long run in one call, that goes on where it was stopped | [`Run`] |
//! | stages, each with observers of its own | [`Run::on`] |
//! | to end it by a signal | `Signals`, with the feature `signals` |
//! | the results of many processes in one | [`SimulationBuilder::pooled`](crate::SimulationBuilder::pooled) |
//! | an observer, a drive or an adaptation of your own in it | [`Persist`] |
//! | each step by yourself | [`Simulation::snapshot`](crate::Simulation::snapshot), [`Snapshot::write`], [`Snapshot::read`] |
//!
//! # Many tasks of a queue
//! Each task is one replica, told by its number which, and is sent a signal before its time is
//! over; the same script, sent again, goes on. With Slurm:
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
//! // Once all are done, by whoever wants to know: all that is there, as one process would have measured it.
//! let paths = (0..100).map(|task| folder.join(format!("task_{task}"))).filter(|path| path.exists());
//! println!("{}", builder.pooled(paths, &CenterOfMass::new())?.estimate()?);
//! # std::fs::remove_dir_all(folder)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The file
//! Eight bytes `gmc-ckpt`, the version of the format (four bytes, as all numbers the lowest first),
//! the CRC-32 of what follows, the number of bytes that follow, and these: seed, sweep and sweeps
//! of production, and three pieces, each after its length: what is simulated and how, the state of
//! the simulation, that of the observer. The pieces are items by [`postcard`](https://postcard.jamesmunns.com/wire-format), each after its name. A file of another version is refused.
//!
//! Any damage is an error. To read a file takes at most 32 times its size in memory, and what the
//! scene takes by itself.

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
