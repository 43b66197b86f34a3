//! hoomd-mc 1.4: the same spheres, walls and field.
//!
//! What counts as a trial: `Sweep` proposes one move to every sphere and counts each as accepted or
//! rejected, those into a wall too, as gradient-mc does. `ParallelSweep` leaves out of its count the moves
//! that leave their checkerboard space: these are rejected trials like any other, so
//! [`proposals_per_trial`] says how many are missing. It also takes one sphere from every space, crowded or
//! not: in a column it tries the dilute top far more often, where more is accepted and a trial costs less.

mod boundary;
mod trial;

use crate::Failure;
use crate::contest::{Count, Engine};
use crate::state::State;
use boundary::WalledSlab;
use hoomd_interaction::external::Linear;
use hoomd_interaction::pairwise::HardSphere;
use hoomd_interaction::{DeltaEnergyOne, External, PairwiseCutoff};
use hoomd_mc::{HypercuboidCheckerboard, LocalTrial, ParallelSweep, Sweep, Trial};
use hoomd_microstate::property::Point;
use hoomd_microstate::{Body, Microstate, SiteKey};
use hoomd_simulation::macrostate::Isothermal;
use hoomd_spatial::{HashCell, PointUpdate, PointsNearBall, VecCell};
use hoomd_vector::Cartesian;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::atomic::{AtomicU64, Ordering};
use trial::{Counted, Cube};

/// Sweeps between two calls of `sort_sites`, which is cheap and of which hoomd-mc advises "every few
/// hundred steps".
const SORT_INTERVAL: u64 = 200;

type Sphere = Point<Cartesian<3>>;
type Spheres<X> = Microstate<Sphere, Sphere, X, WalledSlab>;

/// Which of hoomd-mc's neighbor searches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Grid {
    /// `VecCell`: a cube of cells around the origin.
    Dense,
    /// `HashCell`: only cells that were ever occupied.
    Hashed,
}

/// What hoomd-mc leaves to its user.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Settings {
    pub(crate) grid: Grid,
    /// Nominal search radius.
    pub(crate) cell_width: f64,
    /// Body interaction range of the parallel sweep, at least the diameter.
    pub(crate) checkerboard_width: f64,
}

/// Which trial displacements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Displacements {
    /// Uniform in a cube, as in gradient-mc.
    Cube,
    /// Uniform in a ball, which is what hoomd-mc has, with the same mean square.
    Ball,
}

/// Which way through the spheres.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Mode {
    Sequential,
    /// On this many threads.
    Parallel(usize),
}

/// Neighbor searches, with what only one of them can do.
trait Cells:
    PointUpdate<Cartesian<3>, SiteKey> + PointsNearBall<Cartesian<3>, SiteKey> + Send + Sync + 'static
{
    fn new(cell_width: f64) -> Result<Self, Failure>
    where
        Self: Sized;
    fn sort(spheres: &mut Spheres<Self>)
    where
        Self: Sized;
}

impl Cells for VecCell<SiteKey, 3> {
    fn new(cell_width: f64) -> Result<Self, Failure> {
        Ok(Self::builder().nominal_search_radius(cell_width.try_into()?).maximum_search_radius(1.0).build())
    }

    fn sort(spheres: &mut Spheres<Self>) {
        spheres.sort_sites();
    }
}

impl Cells for HashCell<SiteKey, 3> {
    fn new(cell_width: f64) -> Result<Self, Failure> {
        Ok(Self::builder().nominal_search_radius(cell_width.try_into()?).maximum_search_radius(1.0).build())
    }

    /// Sites can be sorted only along a `VecCell`.
    fn sort(_: &mut Spheres<Self>) {}
}

type Overlap = PairwiseCutoff<HardSphere>;
const OVERLAP: Overlap = PairwiseCutoff(HardSphere { diameter: 1.0 });

/// Overlaps first: they are enough to reject.
#[derive(Debug, DeltaEnergyOne)]
struct Heavy {
    overlap: Overlap,
    weight: External<Linear<Cartesian<3>>>,
}

impl Heavy {
    fn new(gravity: f64) -> Result<Self, Failure> {
        let weight = Linear {
            alpha: gravity,
            plane_origin: Cartesian::from([0.0; 3]),
            plane_normal: [1.0, 0.0, 0.0].try_into()?,
        };
        Ok(Self { overlap: OVERLAP, weight: External(weight) })
    }
}

/// Spheres and what moves them.
struct Hoomd<X, H, M> {
    label: String,
    spheres: Spheres<X>,
    hamiltonian: H,
    moves: M,
    macrostate: Isothermal,
    since_sort: u64,
    /// None for the thread that calls.
    pool: Option<ThreadPool>,
}

impl<X, H, M> Engine for Hoomd<X, H, M>
where
    X: Cells,
    H: Sync,
    M: Trial<Spheres<X>, H, Isothermal, Count = hoomd_mc::Count> + Send,
{
    fn label(&self) -> String {
        self.label.clone()
    }

    fn run(&mut self, sweeps: u64) -> Result<Count, Failure> {
        let Self { spheres, hamiltonian, moves, macrostate, since_sort, .. } = self;
        let mut run = || {
            let mut count = hoomd_mc::Count::default();
            for _ in 0..sweeps {
                count += moves.apply(spheres, hamiltonian, macrostate);
                spheres.increment_step();
                *since_sort += 1;
                if *since_sort == SORT_INTERVAL {
                    X::sort(spheres);
                    *since_sort = 0;
                }
            }
            Count { trials: count.total(), accepted: count.accepted, left_domain: 0 }
        };
        Ok(match &self.pool {
            Some(pool) => pool.install(run),
            None => run(),
        })
    }
}

fn spheres<X: Cells>(
    state: &State,
    settings: Settings,
    positions: &[[f64; 3]],
) -> Result<Spheres<X>, Failure> {
    let [height, width_y, width_z] = state.size;
    let bodies = positions.iter().map(|[x, y, z]| {
        Body::point(Cartesian::from([x - 0.5 * height, y - 0.5 * width_y, z - 0.5 * width_z]))
    });
    Ok(Microstate::builder()
        .boundary(WalledSlab::new(state.size)?)
        .spatial_data(X::new(settings.cell_width)?)
        .seed(3)
        .bodies(bodies)
        .try_build()?)
}

/// The parallel sweep with its types.
type Checkered<L> = ParallelSweep<L, HypercuboidCheckerboard<3>, Sphere, Sphere>;

fn engine<X, H, L>(
    label: String,
    spheres: Spheres<X>,
    hamiltonian: H,
    trial: L,
    mode: Mode,
    state: &State,
    settings: Settings,
) -> Result<Box<dyn Engine>, Failure>
where
    X: Cells,
    H: DeltaEnergyOne<Sphere, Sphere, X, WalledSlab> + Send + Sync + 'static,
    L: LocalTrial<Sphere> + Send + Sync + 'static,
{
    let macrostate = Isothermal { temperature: state.temperature };
    let since_sort = 0;
    Ok(match mode {
        Mode::Sequential => {
            let moves = Sweep(trial);
            Box::new(Hoomd { label, spheres, hamiltonian, moves, macrostate, since_sort, pool: None })
        }
        Mode::Parallel(threads) => {
            let moves = Checkered::new(settings.checkerboard_width.try_into()?, trial);
            let pool = Some(ThreadPoolBuilder::new().num_threads(threads).build()?);
            Box::new(Hoomd { label, spheres, hamiltonian, moves, macrostate, since_sort, pool })
        }
    })
}

fn with_cells<X: Cells>(
    state: &State,
    settings: Settings,
    displacements: Displacements,
    mode: Mode,
    positions: &[[f64; 3]],
) -> Result<Box<dyn Engine>, Failure>
where
    Overlap: DeltaEnergyOne<Sphere, Sphere, X, WalledSlab>,
{
    let spheres = spheres::<X>(state, settings, positions)?;
    let label = match (mode, displacements) {
        (Mode::Sequential, Displacements::Cube) => "hoomd-mc Sweep, cube".into(),
        (Mode::Sequential, Displacements::Ball) => "hoomd-mc Sweep, its own ball".into(),
        (Mode::Parallel(1), _) => "hoomd-mc ParallelSweep, 1 thread".into(),
        (Mode::Parallel(threads), _) => format!("hoomd-mc ParallelSweep, {threads} threads"),
    };
    let cube = Cube(state.maximum_displacement);
    match (state.gravity > 0.0, displacements) {
        (false, Displacements::Cube) => engine(label, spheres, OVERLAP, cube, mode, state, settings),
        (false, Displacements::Ball) => {
            let ball = trial::ball(state.maximum_displacement)?;
            engine(label, spheres, OVERLAP, ball, mode, state, settings)
        }
        (true, Displacements::Cube) => {
            engine(label, spheres, Heavy::new(state.gravity)?, cube, mode, state, settings)
        }
        (true, Displacements::Ball) => {
            let ball = trial::ball(state.maximum_displacement)?;
            engine(label, spheres, Heavy::new(state.gravity)?, ball, mode, state, settings)
        }
    }
}

/// An engine that starts from `positions`.
pub(crate) fn new(
    state: &State,
    settings: Settings,
    displacements: Displacements,
    mode: Mode,
    positions: &[[f64; 3]],
) -> Result<Box<dyn Engine>, Failure> {
    match settings.grid {
        Grid::Dense => with_cells::<VecCell<SiteKey, 3>>(state, settings, displacements, mode, positions),
        Grid::Hashed => with_cells::<HashCell<SiteKey, 3>>(state, settings, displacements, mode, positions),
    }
}

/// Moves proposed by the parallel sweep for each that it counts, from `sweeps` untimed sweeps.
pub(crate) fn proposals_per_trial(
    state: &State,
    settings: Settings,
    positions: &[[f64; 3]],
    sweeps: u64,
) -> Result<f64, Failure> {
    let mut spheres = spheres::<HashCell<SiteKey, 3>>(state, settings, positions)?;
    let proposals = AtomicU64::new(0);
    let trial = Counted(Cube(state.maximum_displacement), &proposals);
    let mut moves = Checkered::new(settings.checkerboard_width.try_into()?, trial);
    let hamiltonian = Heavy::new(state.gravity)?;
    let macrostate = Isothermal { temperature: state.temperature };
    let mut count = hoomd_mc::Count::default();
    for _ in 0..sweeps {
        count += moves.apply(&mut spheres, &hamiltonian, &macrostate);
        spheres.increment_step();
    }
    Ok(proposals.load(Ordering::Relaxed) as f64 / count.total() as f64)
}
