//! The crystal at α = 0.1: grown from a gas of spheres at random, then looked at.

use super::column::{BIN, Column};
use super::front::{self, Crossing};
use super::protocol::{Base, Protocol};
use gradient_mc::checkpoint::{Archive, Persist};
use gradient_mc::field::ExponentialField;
use gradient_mc::observers::{
    Bins, CenterOfMass, DensityProfile, DisplacementProfile, EquationOfStateProfile, Layer, NeighborAngles,
    RadialDistribution, StructureProfile,
};
use gradient_mc::start::{Positions, RandomInsertion};
use gradient_mc::statistics::Estimate;
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Error, Every, Frame, Observer, ObserverError, Simulation, Slab, Vector3, Warning};
use paper::study::count;
use paper::{Failure, Watch};

/// A crystal while it grows.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stand {
    /// Sweeps since the random start.
    pub(crate) sweep: u64,
    /// α by then.
    pub(crate) rate: f64,
    pub(crate) center_of_mass: f64,
    /// Layers that count as crystalline, from the base up without a gap.
    pub(crate) layers: usize,
    /// Position of the uppermost of them.
    pub(crate) height: f64,
}

/// A crystal and its structure.
#[derive(Debug, Clone)]
pub(crate) struct Crystal {
    pub(crate) base: Base,
    pub(crate) particles: usize,
    pub(crate) history: Vec<Stand>,
    /// Of the measurement.
    pub(crate) center_of_mass: CenterOfMass,
    pub(crate) density: DensityProfile,
    pub(crate) profile: EquationOfStateProfile,
    pub(crate) structure: StructureProfile,
    pub(crate) first_layer: RadialDistribution,
    /// Around which height, and the angles there.
    pub(crate) angles: Vec<(f64, NeighborAngles)>,
    pub(crate) mobility: DisplacementProfile,
    pub(crate) positions: Vec<Vector3<f64>>,
    /// Warnings about the measurement; that the fluid's theory does not hold in a crystal is said
    /// too.
    pub(crate) warnings: Vec<Warning>,
    pub(crate) growth_sweeps: u64,
    pub(crate) sweeps: u64,
    /// CPU seconds.
    pub(crate) busy: f64,
}

/// Bins of the fine profile: from the lowest centers to well above the column.
const FINE_BIN: f64 = 0.05;
pub(crate) const TOP: f64 = 44.5;
/// Layers are looked for down to this visibility of n(x).
const LEAST_VISIBILITY: f64 = 0.05;
/// Layers of at least this visibility count as crystalline: between minima half as dense as the
/// peaks and the layers that a fluid has at a wall there is room.
pub(crate) const CRYSTALLINE: f64 = 0.7;
/// Heights near which angles are measured, in the layer that is nearest.
const ANGLES_NEAR: [f64; 4] = [0.5, 9.0, 18.0, 32.0];

/// Sweeps of the measurement.
fn measured_sweeps(protocol: &Protocol) -> u64 {
    (protocol.growth_sweeps / 8).clamp(200, 2000)
}

/// Sweeps of a crystal in all, for the progress.
pub(crate) fn sweeps(protocol: &Protocol) -> u64 {
    protocol.growth_sweeps + measured_sweeps(protocol)
}

type Running = Simulation<ExponentialField, Isothermal>;

/// Grows a crystal and measures it.
pub(crate) fn grow(
    base: Base,
    protocol: &Protocol,
    seed: u64,
    watch: &Watch<'_>,
) -> Result<Crystal, Failure> {
    let (simulation, history) = watch_growth(base, protocol, seed, watch)?;
    let column = Column { rate: Protocol::CRYSTAL_RATE, base };
    let mut crystal = measure(column, simulation, protocol, seed, watch)?;
    crystal.history = history;
    crystal.busy = watch.cpu_seconds();
    Ok(crystal)
}

/// Lets a crystal grow from the random start, and takes stock now and then.
fn watch_growth(
    base: Base,
    protocol: &Protocol,
    seed: u64,
    watch: &Watch<'_>,
) -> Result<(Running, Vec<Stand>), Failure> {
    const LOOKS: u64 = 30;
    /// Number of frames of each sample.
    const FRAMES: u64 = 40;
    let slab = base.slab()?;
    let mut rate = protocol.growth.rate(0.0);
    let column = Column { rate, base };
    let moves = protocol.growth.moves()?;
    let mut simulation = Simulation::builder(column.scene()?)
        .start(RandomInsertion::default())
        .moves(moves)
        .seed(seed)
        .build()?;
    let (mut history, mut sweep) = (Vec::new(), 0);
    for look in 0..LOOKS {
        let next_rate = protocol.growth.rate((look + 1) as f64 / LOOKS as f64);
        if next_rate > rate {
            rate = next_rate;
            simulation = Simulation::builder(Column { rate, base }.scene()?)
                .start(Positions(simulation.positions()))
                .moves(moves)
                .seed(seed.wrapping_add(look << 32))
                .build()?;
        }
        let chunk = protocol.growth_sweeps * (look + 1) / LOOKS - protocol.growth_sweeps * look / LOOKS;
        let interval = (chunk / (2 * FRAMES)).max(1);
        watch.equilibrate(&mut simulation, chunk / 2, 1, &mut ())?;
        let mut seen = Every::new(interval, (CenterOfMass::new(), fine_profile(&slab)?));
        watch.equilibrate(&mut simulation, chunk - chunk / 2, 1, &mut seen)?;
        sweep += chunk;
        let (center_of_mass, density) = seen.observer;
        let layers = crystalline(&density.layers(LEAST_VISIBILITY)?);
        let heights = center_of_mass.heights();
        history.push(Stand {
            sweep,
            rate,
            center_of_mass: heights.iter().sum::<f64>() / heights.len() as f64,
            layers: layers.len(),
            height: layers.last().map_or(0.5, |layer| layer.position.mean),
        });
    }
    Ok((simulation, history))
}

fn fine_profile(slab: &Slab) -> Result<DensityProfile, Failure> {
    Ok(DensityProfile::new(slab, Bins::count(count((TOP - 0.5) / FINE_BIN)).from(0.5).to(TOP))?)
}

/// The layers from the base up that count as crystalline.
fn crystalline(layers: &[Layer]) -> Vec<Layer> {
    layers.iter().take_while(|layer| layer.visibility.mean >= CRYSTALLINE).copied().collect()
}

fn measure(
    column: Column,
    mut simulation: Running,
    protocol: &Protocol,
    seed: u64,
    watch: &Watch<'_>,
) -> Result<Crystal, Failure> {
    let slab = *simulation.scene().slab();
    let sweeps = measured_sweeps(protocol);
    let interval = (sweeps / 400).max(1);
    // Where the layers are, to put the bins of angles around them.
    let mut probe = Every::new(interval, fine_profile(&slab)?);
    watch.equilibrate(&mut simulation, sweeps / 4, 1, &mut probe)?;
    let layers = probe.observer.layers(LEAST_VISIBILITY)?;
    let (mut heights, mut angles) = (Vec::new(), Vec::new());
    for near in ANGLES_NEAR {
        let distance = |layer: &&Layer| (layer.position.mean - near).abs();
        let nearest = layers.iter().min_by(|first, second| distance(first).total_cmp(&distance(second)));
        // Above the last layer: where it is fluid, a range as high as a layer.
        let height = nearest.filter(|layer| distance(layer) < 0.5).map_or(near, |layer| layer.position.mean);
        let low = (height - 0.35).max(0.5);
        heights.push(height);
        angles.push(NeighborAngles::new(&slab, low, height + 0.35, 120)?);
    }
    let bins = count(Protocol::HEIGHT / BIN);
    let mut center_of_mass = Every::new(interval, CenterOfMass::new());
    let mut profiles =
        Every::new(interval, (fine_profile(&slab)?, EquationOfStateProfile::new(&slab, Bins::count(bins))?));
    let mut first_layer = Every::new(4 * interval, RadialDistribution::new(&slab, 0.5, 0.9, 100)?);
    let mut structure =
        Every::new(4 * interval, StructureProfile::new(&slab, Bins::count(40).from(0.5).to(40.5))?);
    let left = sweeps - sweeps / 4;
    let mut angles = Every::new(4 * interval, AllOf(angles));
    let mut observers = (&mut center_of_mass, &mut profiles, &mut first_layer, &mut structure, &mut angles);
    watch.run(&mut simulation, left, 1, &mut observers)?;
    let positions = simulation.positions();
    let (density, profile) = profiles.observer;
    Ok(Crystal {
        base: column.base,
        particles: column.base.particles(),
        history: Vec::new(),
        center_of_mass: center_of_mass.observer,
        density,
        profile,
        structure: structure.observer,
        first_layer: first_layer.observer,
        angles: heights.into_iter().zip(angles.observer.0).collect(),
        mobility: column.mobility(&positions, seed)?,
        positions,
        warnings: simulation.warnings(),
        growth_sweeps: protocol.growth_sweeps,
        sweeps: left,
        busy: 0.0,
    })
}

/// Observers of the same kind, however many.
struct AllOf<O>(Vec<O>);

impl<O: Observer> Observer for AllOf<O> {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.0.iter_mut().try_for_each(|observer| observer.observe(frame))
    }
}

impl<O: Persist> Persist for AllOf<O> {
    fn persist(&mut self, archive: &mut Archive<'_>) -> Result<(), Error> {
        self.0.persist(archive)
    }
}

impl Crystal {
    /// All resolved layers, upwards.
    pub(crate) fn layers(&self) -> Result<Vec<Layer>, Failure> {
        Ok(self.density.layers(LEAST_VISIBILITY)?)
    }

    /// Those that count as crystalline.
    pub(crate) fn crystalline_layers(&self) -> Result<Vec<Layer>, Failure> {
        Ok(crystalline(&self.layers()?))
    }

    /// Where the crystal ends, by each criterion.
    pub(crate) fn fronts(&self) -> Result<Fronts, Failure> {
        let layers = self.layers()?;
        let visibility: Vec<Crossing> =
            layers.iter().map(|layer| Crossing::new(layer.position.mean, layer.visibility)).collect();
        let by_layers = front::falls_below(&visibility, CRYSTALLINE);
        let missing = Estimate::new(f64::NAN, f64::NAN);
        let bonds = self.structure.front()?.unwrap_or(missing);
        let reduced: Vec<Crossing> = self
            .profile
            .points()?
            .iter()
            .map(|point| {
                let pressure = point.pressure;
                let scaled = pressure / point.temperature;
                Crossing::new(point.height, scaled)
            })
            .collect();
        let coexistence = gradient_mc::equation_of_state::Coexistence::default().reduced_pressure;
        let by_pressure = front::falls_below(&reduced, coexistence);
        let mobility: Vec<Crossing> = self
            .mobility
            .points()?
            .iter()
            .map(|point| Crossing::new(point.height, point.mean_displacement))
            .collect();
        let by_mobility = front::midway_rise(&mobility, bonds.mean);
        Ok(Fronts { bonds, layers: by_layers, mobility: by_mobility, pressure: by_pressure })
    }
}

/// Heights of the front.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fronts {
    /// Where half of the spheres have the surroundings of a crystal.
    pub(crate) bonds: Estimate,
    /// Where the visibility of the layers falls below [`CRYSTALLINE`].
    pub(crate) layers: Estimate,
    /// Where the mean accepted displacement is half way between crystal and fluid.
    pub(crate) mobility: Estimate,
    /// No structure: where the measured P/T is that of coexistence.
    pub(crate) pressure: Estimate,
}
