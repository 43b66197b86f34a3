//! One column at T = 20 in a field exp(αx): from the random start to its steady state, and what it
//! does there.

use super::protocol::{Base, Protocol, Stage};
use gradient_mc::equation_of_state::EquationOfState;
use gradient_mc::field::ExponentialField;
use gradient_mc::hydrostatics::{HydrostaticProfile, Hydrostatics};
use gradient_mc::observers::{Bins, CenterOfMass, DisplacementProfile, EquationOfStateProfile};
use gradient_mc::start::{Positions, RandomInsertion, Start};
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Error, Every, Merge, Scene, Simulation, Vector3, Warning};
use paper::study::count;
use paper::{Failure, Watch};

/// A column of the paper's system (b).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Column {
    /// α, per diameter.
    pub(crate) rate: f64,
    pub(crate) base: Base,
}

/// What a run of a column saw.
#[derive(Debug, Clone)]
pub(crate) struct Run {
    /// From the start on.
    pub(crate) center_of_mass: CenterOfMass,
    /// One for each interval of measurement.
    pub(crate) profiles: Vec<EquationOfStateProfile>,
    pub(crate) positions: Vec<Vector3<f64>>,
    /// Warnings about its measurement.
    pub(crate) warnings: Vec<Warning>,
    /// CPU seconds.
    pub(crate) busy: f64,
}

/// Height of the bins, that of the paper.
pub(crate) const BIN: f64 = 0.1;

impl Column {
    pub(crate) fn scene(&self) -> Result<Scene<ExponentialField, Isothermal>, Failure> {
        let temperature = Isothermal::new(Protocol::TEMPERATURE)?;
        let field = ExponentialField::new(self.rate)?;
        Ok(Scene::new(self.base.slab()?, self.base.particles(), field, temperature)?)
    }

    /// The theory profile between the walls.
    pub(crate) fn theory<E: EquationOfState + Clone>(
        &self,
        equation_of_state: E,
    ) -> Result<HydrostaticProfile, Failure> {
        let temperature = Isothermal::new(Protocol::TEMPERATURE)?;
        let theory = Hydrostatics::new(ExponentialField::new(self.rate)?, temperature, equation_of_state);
        Ok(theory.between_walls(&self.base.slab()?, Protocol::COLUMN_DENSITY)?)
    }

    /// From spheres at random, n = 0.1, as the paper starts.
    pub(crate) fn settle(&self, stage: &Stage, seed: u64, watch: &Watch<'_>) -> Result<Run, Failure> {
        self.run(RandomInsertion::default(), stage, seed, watch)
    }

    /// Runs a stage and samples the column.
    fn run(
        &self,
        start: impl Start + 'static,
        stage: &Stage,
        seed: u64,
        watch: &Watch<'_>,
    ) -> Result<Run, Failure> {
        let mut simulation =
            Simulation::builder(self.scene()?).start(start).moves(stage.moves).seed(seed).build()?;
        let mut center_of_mass = Every::new(stage.interval, CenterOfMass::new());
        watch.equilibrate(&mut simulation, stage.equilibration, 1, &mut center_of_mass)?;
        let mut profiles = Vec::new();
        for &sweeps in &stage.intervals {
            let slab = *simulation.scene().slab();
            let profile = EquationOfStateProfile::new(&slab, Bins::count(count(Protocol::HEIGHT / BIN)))?;
            let mut profile = Every::new(stage.interval, profile);
            watch.run(&mut simulation, sweeps, 1, &mut (&mut center_of_mass, &mut profile))?;
            profiles.push(profile.observer);
        }
        Ok(Run {
            center_of_mass: center_of_mass.observer,
            profiles,
            positions: simulation.positions(),
            warnings: if stage.intervals.is_empty() { Vec::new() } else { simulation.warnings() },
            busy: watch.cpu_seconds(),
        })
    }

    /// How far the paper's moves get in a sweep, by height, from a steady state that other moves
    /// have reached.
    pub(crate) fn mobility(
        &self,
        positions: &[Vector3<f64>],
        seed: u64,
    ) -> Result<DisplacementProfile, Failure> {
        /// Sweeps for the structure around a sphere to become that of these moves' own run, and of
        /// the measurement.
        const SWEEPS: [u64; 2] = [200, 3200];
        const INTERVAL: u64 = 20;
        let scene = self.scene()?;
        let slab = *scene.slab();
        let mut simulation = Simulation::builder(scene)
            .start(Positions(positions.to_vec()))
            .moves(Protocol::local_moves(self.rate)?)
            .seed(seed)
            .build()?;
        let profile = DisplacementProfile::new(&slab, Bins::count(100).from(0.5).to(100.5))?;
        let mut profile = Every::new(INTERVAL, profile);
        simulation.equilibrate(SWEEPS[0], &mut ())?;
        simulation.run(SWEEPS[1], &mut profile)?;
        Ok(profile.observer)
    }
}

/// All profiles of some runs as one.
pub(crate) fn pooled<'a>(
    profiles: impl IntoIterator<Item = &'a EquationOfStateProfile>,
) -> Result<EquationOfStateProfile, Failure> {
    let mut profiles = profiles.into_iter();
    let mut sum = profiles.next().ok_or("nothing was measured")?.clone();
    for profile in profiles {
        sum.merge(profile)?;
    }
    Ok(sum)
}

/// What is left of the series of all runs after `equilibration` sweeps, and after what the data
/// then still show of it; and where that begins, unless a series is too short to tell.
///
/// The fall from the random start is cut off first. It is so high that it hides everything else,
/// and since it decays as slowly as the column forgets, a rule that maximizes the number of
/// independent heights takes it for one of many fluctuations.
pub(crate) fn plateau(runs: &[Run], equilibration: u64) -> Result<(CenterOfMass, Vec<Option<u64>>), Error> {
    let mut sum = CenterOfMass::new();
    let mut beginnings = Vec::new();
    for run in runs {
        let measured = run.center_of_mass.since(equilibration);
        let (rest, beginning) = match measured.equilibrated() {
            Ok(rest) => {
                let first = rest.sweeps().first().copied();
                (rest, first)
            }
            Err(Error::NotEquilibrated { .. }) => (measured, None),
            Err(error) => return Err(error),
        };
        sum.merge(&rest)?;
        beginnings.push(beginning);
    }
    Ok((sum, beginnings))
}
