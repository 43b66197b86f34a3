//! Monte Carlo of hard spheres in a tall slab whose gravity and temperature vary with height: one
//! run yields a whole equation of state (Mehrotra, Puri and Khakhar,
//! doi:10.1103/PhysRevE.83.061306).
//!
//! ```
//! use gradient_mc::equation_of_state::{EquationOfState, ModifiedKolafa};
//! use gradient_mc::observers::{Bins, EquationOfStateProfile};
//! use gradient_mc::{Every, Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
//!
//! let slab = Slab::new(60.0, 6.0, 6.0)?;
//! let scene = Scene::new(slab, 360, UniformField::default(), Isothermal::new(5.0)?)?;
//! let mut simulation = Simulation::builder(scene).seed(1).build()?;
//! let mut profile = Every::new(5, EquationOfStateProfile::new(&slab, Bins::count(60))?);
//! simulation.equilibrate(200, &mut ())?;
//! simulation.run(400, &mut profile)?;
//! for point in profile.observer.deviations_from(&ModifiedKolafa)? {
//!     println!("{:5.1}  {}  {}", point.height, point.packing_fraction, point.deviation);
//! }
//! # Ok::<(), gradient_mc::Error>(())
//! ```
//!
//! Units: the sphere diameter, the mass, g and Boltzmann's constant are 1, so temperature is in
//! m g d and pressure in m g/d².
//!
//! A [`Scene`] is a [`Slab`], a number of spheres, a [`Field`] and a [`TemperatureProfile`]. A
//! [`Simulation`] moves the spheres in the reduced potential of its [`drive`], and [`Observer`]s
//! record. [`hydrostatics`] is the theory of the same scene with any [`EquationOfState`]. Each of
//! the four traits has one required method. [`Simulation::warnings`] lists what makes a result
//! doubtful.
//!
//! The defaults suit any scene: the scheme [`drive::Automatic`], the start [`start::Theory`], and
//! event chains with tuned local moves between them ([`moves`]).
//!
//! | feature | what it adds |
//! |---|---|
//! | `rayon` | sweeps on all threads of the pool that they run in, with the same results |
//! | `checkpoint` | runs that stop and go on with the same bits (`checkpoint::Run`) |
//! | `signals` | signals that stop a run |
//! | `csv`, `serde` | profiles as tables, estimates as data |
//!
//! The package contains `docs/start.md` (ten minutes), `docs/how_to.md` (twelve tasks) and
//! `docs/long_runs.md`. The repository has the physics, proofs and measurements.
//!
//! # What a version promises
//! `nalgebra`'s [`Vector3`] and `rand_pcg`'s generator ([`Generator`]) are part of the public
//! interface, so a new major version of either is a new major version of this crate. Variants of
//! [`Error`] and [`Warning`] may get more fields in any version: match them with `..`.
//!
//! ```
//! use gradient_mc::{Error, Slab};
//! assert!(matches!(Slab::new(60.0, 2.0, 6.0), Err(Error::SlabTooSmall { direction: 'y', .. })));
//! ```
//!
//! # Limits
//! Equal hard spheres; at most 2·10⁸ cubic diameters; a self-consistent field that has to be
//! checked (`docs/physics.md`, "Known limits").

#![warn(
    missing_docs,
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    clippy::print_stderr
)]
#![cfg_attr(
    test,
    allow(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        clippy::print_stdout,
        clippy::disallowed_methods
    )
)]

#[macro_use]
mod persist;

mod centers;
#[cfg(feature = "checkpoint")]
pub mod checkpoint;
mod configuration;
mod diagnostics;
pub mod drive;
pub mod equation_of_state;
mod error;
mod failed_observer;
pub mod field;
mod frame;
pub mod functional;
mod gsd;
pub mod hydrostatics;
mod legendre;
mod merge;
pub mod model;
mod monitor;
pub mod moves;
mod numbers;
mod numerics;
mod observer;
mod observer_fn;
pub mod observers;
mod random;
mod replicas;
mod scene;
mod simulation;
mod slab;
pub mod start;
pub mod statistics;
#[cfg(feature = "csv")]
mod table;
pub mod temperature;
mod warning;
mod warning_kind;

pub use equation_of_state::EquationOfState;
pub use error::Error;
pub use field::Field;
pub use frame::{Frame, MoveCounts, Phase};
pub use hydrostatics::{HydrostaticProfile, Hydrostatics};
pub use merge::Merge;
pub use nalgebra::Vector3;
pub use observer::{AcceptedMove, ChainPiece, Collision, Every, Observer, ObserverError, Recorder};
pub use observer_fn::ObserverFn;
pub use random::Generator;
pub use replicas::{Outcome, Replica, Replicas};
pub use scene::{AnyScene, Scene, Wall};
pub use simulation::{Simulation, SimulationBuilder};
pub use slab::Slab;
#[cfg(feature = "csv")]
pub use table::{Row, WriteCsv};
pub use temperature::TemperatureProfile;
pub use warning::{Disagreement, MixingEvidence, Quantity, Warning};
pub use warning_kind::WarningKind;

/// The programs of the documentation, compiled.
#[cfg(doctest)]
mod programs {
    #[doc = include_str!("../README.md")]
    struct Readme;
    #[doc = include_str!("../docs/start.md")]
    struct Start;
    #[doc = include_str!("../docs/how_to.md")]
    struct HowTo;
    #[cfg(feature = "signals")]
    #[doc = include_str!("../docs/long_runs.md")]
    struct LongRuns;
}
