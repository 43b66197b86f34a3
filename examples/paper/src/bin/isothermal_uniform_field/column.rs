//! One column: relaxation from its start to the steady state, and measurements.

use super::layers;
use super::protocol::{Family, HEIGHT, Task};
use gradient_mc::field::UniformField;
use gradient_mc::moves::LocalMoves;
use gradient_mc::observers::{
    Bins, CenterOfMass, DensityProfile, DisplacementProfile, EquationOfStateProfile, RadialDistribution,
};
use gradient_mc::start::{ClosePacked, Positions, RandomInsertion};
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Every, Merge, Scene, Simulation, Slab};
use paper::study::count;
use paper::{Failure, Side, Watch};

/// Height of the bins of the whole column, in diameters.
pub(crate) const BIN_WIDTH: f64 = 0.5;
/// Height of the bins at the base, which resolve the contact density and the peaks.
pub(crate) const FINE_BIN_WIDTH: f64 = 0.01;
/// Where those bins begin, at the lowest center, and end.
pub(crate) const FINE_RANGE: [f64; 2] = [0.5, 3.5];
/// The base in the paper's bins.
const BASE_RANGE: [f64; 2] = [0.5, 8.5];
/// Branches in which the base is measured.
const ROUNDS: u64 = 32;
/// Sweeps of small local moves between two samples of the base and of the order in its first layer.
const LAYERS_INTERVAL: u64 = 5;
const FIRST_LAYER_INTERVAL: u64 = 20;
/// The first layer, a bin of the paper's at the wall.
const FIRST_LAYER: [f64; 2] = [0.5, 0.6];
/// Width of the bins of the radial distribution.
const RADIAL_BIN_WIDTH: f64 = 0.05;

/// What one column has shown.
pub(crate) struct Column {
    pub(crate) task: Task,
    /// From the first sweep on.
    pub(crate) center_of_mass: CenterOfMass,
    /// Whole column, in the steady state, as all that follows.
    pub(crate) profile: EquationOfStateProfile,
    /// The base as the moves that made the column steady have it.
    pub(crate) by_own_moves: DensityProfile,
    pub(crate) layers: Option<Layers>,
    pub(crate) mobility: Option<DisplacementProfile>,
    pub(crate) busy: f64,
}

/// The base, measured in branches by small local moves that leave the steady state of the column's
/// own moves at equal distances.
///
/// Small displacements renew the structure of a layer soonest, but hardly move the column as a
/// whole, on whose height the base depends: in one long run of them the base would keep the height
/// that it began with, and its error bars would not tell.
pub(crate) struct Layers {
    pub(crate) base: Every<DensityProfile>,
    pub(crate) fine: Every<DensityProfile>,
    pub(crate) first_layer: Every<RadialDistribution>,
}

impl Merge for Layers {
    fn merge(&mut self, other: &Self) -> Result<(), gradient_mc::Error> {
        self.base.merge(&other.base)?;
        self.fine.merge(&other.fine)?;
        self.first_layer.merge(&other.first_layer)
    }
}

impl Layers {
    fn new(task: &Task, slab: &Slab) -> Result<Self, Failure> {
        let [layer_low, layer_high] = FIRST_LAYER;
        let radial_bins = count(0.5 * task.width / RADIAL_BIN_WIDTH);
        let first_layer = RadialDistribution::new(slab, layer_low, layer_high, radial_bins)?;
        Ok(Self {
            base: Every::new(LAYERS_INTERVAL, base(slab, BASE_RANGE, layers::BIN_WIDTH)?),
            fine: Every::new(LAYERS_INTERVAL, base(slab, FINE_RANGE, FINE_BIN_WIDTH)?),
            first_layer: Every::new(FIRST_LAYER_INTERVAL, first_layer),
        })
    }
}

fn base(slab: &Slab, [low, high]: [f64; 2], width: f64) -> Result<DensityProfile, Failure> {
    Ok(DensityProfile::new(slab, Bins::count(count((high - low) / width)).from(low).to(high))?)
}

impl Column {
    /// The center of mass in the steady state.
    pub(crate) fn steady(&self) -> CenterOfMass {
        self.center_of_mass.since(self.task.equilibration + 1)
    }

    pub(crate) fn weight(&self) -> f64 {
        self.task.particles() as f64 * self.task.production as f64
    }
}

/// The sweeps of one round, of all.
fn share(sweeps: u64, round: u64) -> u64 {
    sweeps * (round + 1) / ROUNDS - sweeps * round / ROUNDS
}

/// Simulates a column.
pub(crate) fn simulate(task: Task, watch: &Watch<'_>) -> Result<Column, Failure> {
    let slab = task.slab()?;
    let scene =
        Scene::new(slab, task.particles(), UniformField::default(), Isothermal::new(task.temperature)?)?;
    let builder = Simulation::builder(scene).moves(task.family.moves()?).seed(task.seed);
    let mut simulation = match task.side {
        Side::Above => builder.start(RandomInsertion::default()).build()?,
        Side::Below => builder.start(ClosePacked).build()?,
    };
    let mut center_of_mass = Every::new(task.interval, CenterOfMass::new());
    let mut profile = Every::new(
        task.interval,
        EquationOfStateProfile::new(
            &slab,
            Bins::count(count((HEIGHT - 1.0) / BIN_WIDTH)).from(0.5).to(HEIGHT - 0.5),
        )?,
    );
    let mut by_own_moves = Every::new(task.interval, base(&slab, BASE_RANGE, layers::BIN_WIDTH)?);
    let (cost, particles) = (task.cost_of_sweep(), task.particles() as u64);
    watch.equilibrate(&mut simulation, task.equilibration, cost, &mut center_of_mass)?;
    let mut layers: Option<Layers> = None;
    for round in 0..ROUNDS {
        let mut observers = (&mut center_of_mass, &mut profile, &mut by_own_moves);
        watch.run(&mut simulation, share(task.production, round), cost, &mut observers)?;
        if task.layers > 0 {
            let start = Positions(simulation.positions());
            let moves = LocalMoves::new(task.small_displacement())?;
            let builder = Simulation::builder(scene).moves(moves).seed(task.seed ^ ((1 + round) << 40));
            let mut branch = builder.start(start).build()?;
            let mut seen = Layers::new(&task, &slab)?;
            let mut observers = (&mut seen.base, &mut seen.fine, &mut seen.first_layer);
            watch.run(&mut branch, share(task.layers, round), particles, &mut observers)?;
            match &mut layers {
                None => layers = Some(seen),
                Some(layers) => layers.merge(&seen)?,
            }
        }
    }
    let mobility = if task.mobility > 0 {
        // The moves of the paper in the steady state reached by faster moves.
        let start = Positions(simulation.positions());
        let builder = Simulation::builder(scene).moves(Family::Paper.moves()?).seed(!task.seed);
        let mut simulation = builder.start(start).build()?;
        let mut mobility = Every::new(
            task.interval,
            DisplacementProfile::new(
                &slab,
                Bins::count(count((HEIGHT - 1.0) / BIN_WIDTH)).from(0.5).to(HEIGHT - 0.5),
            )?,
        );
        watch.run(&mut simulation, task.mobility, particles, &mut mobility)?;
        Some(mobility.observer)
    } else {
        None
    };
    Ok(Column {
        task,
        center_of_mass: center_of_mass.observer,
        profile: profile.observer,
        by_own_moves: by_own_moves.observer,
        layers,
        mobility,
        busy: watch.cpu_seconds(),
    })
}
