//! One run of the column at T₀ = 20, β = 0.05: what P/(nTZ) − 1 it has at each height.

use crate::collisions::RunningCollisions;
use gradient_mc::checkpoint::Persist;
use gradient_mc::drive::{
    AveragedThenFrozen, Certificate, EquationOfStateClosure, Instantaneous, RunningAverage, Scheme,
    SelfConsistent,
};
use gradient_mc::equation_of_state::ModifiedKolafa;
use gradient_mc::field::UniformField;
use gradient_mc::moves::{EventChains, LocalMoves, Moves};
use gradient_mc::observers::{Bins, CenterOfMass, EquationOfStateProfile};
use gradient_mc::start::{ClosePacked, Positions, RandomInsertion, Start};
use gradient_mc::statistics::Estimate;
use gradient_mc::temperature::ExponentialTemperature;
use gradient_mc::{Every, Scene, Simulation, Slab, Warning};
use paper::study::count;
use paper::{Failure, Side, Watch};

/// A column in a uniform field, T = T₀ e^{−βx}.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Column {
    pub(crate) temperature: f64,
    pub(crate) decay_rate: f64,
    /// Spheres per area of the base.
    pub(crate) spheres_per_area: f64,
    /// Height of the box.
    pub(crate) height: f64,
}

/// The paper's worst case. In this box a start at n = 0.25 fits, and no sphere ever gets near the
/// lid afterwards.
pub(crate) const COLUMN: Column =
    Column { temperature: 20.0, decay_rate: 0.05, spheres_per_area: 40.0, height: 200.0 };

/// What the certificates of the runs tolerate.
const TOLERANCE: f64 = 0.01;

/// How n(x) enters the effective field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SchemeChoice {
    Instantaneous,
    RunningAverage,
    AveragedThenFrozen,
    RunningCollisions,
    Closure,
    SelfConsistent,
}

/// What sweeps consist of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum MovesChoice {
    /// The fastest: event chains, and local moves between them.
    Chains,
    /// Local moves as in the paper, with this maximum displacement along each axis, in diameters.
    Local(f64),
}

/// One run.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Setup {
    pub(crate) scheme: SchemeChoice,
    pub(crate) area: f64,
    /// Bins of the density that enters the field.
    pub(crate) acceptance_bin: f64,
    pub(crate) moves: MovesChoice,
    pub(crate) side: Side,
    /// Sweeps of chains that bring a column near its steady state, still on its side of it by some
    /// per cent; and of jumps that small moves start from.
    pub(crate) approach: [u64; 2],
    pub(crate) equilibration: u64,
    pub(crate) sweeps: u64,
    pub(crate) seed: u64,
}

/// What a run measured.
#[derive(Debug, Clone)]
pub(crate) struct Outcome {
    /// P/(nTZ) − 1 over ranges of height, for each of [`MEASURING_BINS`].
    pub(crate) bands: Vec<Vec<Band>>,
    pub(crate) center_of_mass: Estimate,
    pub(crate) certificate: Certificate,
    /// Warnings about the run.
    pub(crate) warnings: Vec<Warning>,
}

/// P/(nTZ) − 1 in the fluid over a range of heights, Z after Kolafa, Labík and Malijevský,
/// modified.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Band {
    pub(crate) height: f64,
    pub(crate) deviation: Estimate,
}

/// Bins of the densities that are compared with the equation of state, all in the same runs.
pub(crate) const MEASURING_BINS: [f64; 3] = [0.1, 0.05, 0.5];

/// Edges of the bands: 8 is above the layers at the base, 56 below the steep top.
pub(crate) const BANDS: [[f64; 2]; 12] = [
    [8.0, 12.0],
    [12.0, 16.0],
    [16.0, 20.0],
    [20.0, 24.0],
    [24.0, 28.0],
    [28.0, 32.0],
    [32.0, 36.0],
    [36.0, 40.0],
    [40.0, 44.0],
    [44.0, 48.0],
    [48.0, 52.0],
    [52.0, 56.0],
];

impl Setup {
    fn slab(&self) -> Result<Slab, Failure> {
        Ok(Slab::new(COLUMN.height, self.area.sqrt(), self.area.sqrt())?)
    }

    /// Number of spheres.
    pub(crate) fn particles(&self) -> usize {
        count(COLUMN.spheres_per_area * self.area)
    }

    /// Progress that a sweep is worth: six times as much for a sphere as in the small column.
    fn work_of_sweep(&self) -> u64 {
        6 * self.particles() as u64
    }

    /// Of the whole run.
    pub(crate) fn work(&self) -> u64 {
        (self.equilibration + self.sweeps) * self.work_of_sweep()
    }

    pub(crate) fn run(&self, watch: &Watch<'_>) -> Result<Outcome, Failure> {
        match self.scheme {
            SchemeChoice::Instantaneous => {
                // Chains on purpose: what the steady state owes to the moves is part of the study.
                self.run_with(Instantaneous::new(self.acceptance_bin)?.any_moves(), watch)
            }
            SchemeChoice::RunningAverage => self.run_with(RunningAverage::new(self.acceptance_bin)?, watch),
            SchemeChoice::AveragedThenFrozen => {
                self.run_with(AveragedThenFrozen::new(self.acceptance_bin)?, watch)
            }
            SchemeChoice::RunningCollisions => {
                self.run_with(RunningCollisions { bin_width: self.acceptance_bin }, watch)
            }
            SchemeChoice::Closure => {
                let scheme = EquationOfStateClosure::default().bin_width(self.acceptance_bin)?;
                self.run_with(scheme, watch)
            }
            SchemeChoice::SelfConsistent => {
                let scheme = SelfConsistent::default().bin_width(self.acceptance_bin)?;
                self.run_with(scheme, watch)
            }
        }
    }

    fn run_with<S>(&self, scheme: S, watch: &Watch<'_>) -> Result<Outcome, Failure>
    where
        S: Scheme<UniformField, ExponentialTemperature, Drive: Persist, Adaptation: Persist> + Copy,
    {
        let start: Box<dyn Start> = match self.side {
            Side::Above => Box::new(RandomInsertion::new(0.25)?),
            Side::Below => Box::new(ClosePacked),
        };
        let slab = self.slab()?;
        let temperature = ExponentialTemperature::new(COLUMN.temperature, COLUMN.decay_rate)?;
        let scene = Scene::new(slab, self.particles(), UniformField::default(), temperature)?;
        let moves: Moves = match self.moves {
            MovesChoice::Chains => EventChains::default().into(),
            MovesChoice::Local(size) => LocalMoves::new(size)?.into(),
        };
        // Far from the steady state only chains get on: they bring the column near it, in the theory's
        // field.
        let builder = Simulation::builder(scene).scheme(EquationOfStateClosure::default());
        let mut near = builder.start(start).moves(EventChains::default()).seed(self.seed ^ 0x5eed).build()?;
        watch.equilibrate(&mut near, self.approach[0], 0, &mut ())?;
        let mut positions = near.positions();
        if let MovesChoice::Local(_) = self.moves {
            // Small moves take 100 000 sweeps to where jumps are after 10 000, in a field of the same kind.
            let builder = Simulation::builder(scene).scheme(scheme).moves(LocalMoves::tuned());
            let mut near = builder.start(Positions(positions)).seed(self.seed ^ 0xbed).build()?;
            watch.equilibrate(&mut near, self.approach[1], 0, &mut ())?;
            positions = near.positions();
        }
        let builder = Simulation::builder(scene).scheme(scheme).moves(moves).seed(self.seed);
        let mut simulation = builder.start(Positions(positions)).build()?;
        let size = self.work_of_sweep();
        watch.equilibrate(&mut simulation, self.equilibration, size, &mut ())?;
        // Well above what any sphere reaches.
        let top = 80.0;
        let profile =
            |bin: f64| EquationOfStateProfile::new(&slab, Bins::count(count(top / bin)).from(0.0).to(top));
        let [first, second, third] = MEASURING_BINS;
        let profiles = (profile(first)?, profile(second)?, profile(third)?);
        let mut observers = Every::new(5, (profiles, CenterOfMass::new()));
        watch.run(&mut simulation, self.sweeps, size, &mut observers)?;
        let ((first, second, third), center_of_mass) = observers.observer;
        let certificate = simulation.certificate(TOLERANCE)?;
        let warnings = simulation.warnings();
        Ok(Outcome {
            bands: [first, second, third].iter().map(bands).collect::<Result<_, _>>()?,
            center_of_mass: center_of_mass.estimate()?,
            certificate,
            warnings,
        })
    }
}

/// Means over the bands of P over those of n T Z.
fn bands(profile: &EquationOfStateProfile) -> Result<Vec<Band>, Failure> {
    let deviations = profile.deviations_over(&BANDS, &ModifiedKolafa)?;
    let bands = BANDS.iter().zip(deviations);
    Ok(bands.map(|(&[low, high], deviation)| Band { height: f64::midpoint(low, high), deviation }).collect())
}
