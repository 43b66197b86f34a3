//! The runs: five independent replicas, or five successive intervals as in the paper.

use super::case::{COLUMN_DENSITY, Case};
use gradient_mc::checkpoint::Persist;
use gradient_mc::drive::{EquationOfStateClosure, Instantaneous, Scheme, SelfConsistent};
use gradient_mc::field::ExponentialField;
use gradient_mc::moves::{EventChains, LocalMoves, Moves};
use gradient_mc::observers::{Bins, EquationOfStateProfile};
use gradient_mc::start::{ClosePacked, Positions, RandomInsertion, Start};
use gradient_mc::temperature::{ExponentialTemperature, Isothermal};
use gradient_mc::{Every, Scene, Simulation, TemperatureProfile, Vector3, Warning};
use paper::study::count;
use paper::{Failure, Side, Watch};

/// Runs of eq. (32).
pub(crate) const RUNS: u64 = 5;
/// Bins of the paper.
pub(crate) const BIN: f64 = 0.1;

/// How a run is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Plan {
    /// One replica: event chains with tuned moves between them; in a temperature gradient the field
    /// is iterated, then frozen.
    Ours { number: u64, equilibration: u64, sweeps: u64 },
    /// The paper's field, which follows every configuration, and its small moves, over a smaller
    /// base with wider bins of the field that make as much counting noise, from a start that
    /// jumps have brought to its steady state; five intervals.
    Field { side: Side, jumps: u64, equilibration: u64, sweeps: u64 },
    /// The paper's protocol: from a uniform gas of n = 0.1, small moves only; five intervals.
    Protocol { equilibration: u64, sweeps: u64 },
}

impl Plan {
    /// Number of independent runs.
    pub(crate) fn replicas(self) -> u64 {
        match self {
            Self::Ours { .. } | Self::Protocol { .. } => 1,
            Self::Field { .. } => 6,
        }
    }
}

/// One run.
#[derive(Debug, Clone)]
pub(crate) struct Run {
    pub(crate) case: Case,
    pub(crate) plan: Plan,
    pub(crate) seed: u64,
}

/// What came of a run.
#[derive(Debug, Clone)]
pub(crate) struct Measured {
    pub(crate) profiles: Vec<EquationOfStateProfile>,
    pub(crate) warnings: Vec<Warning>,
}

/// Base and bins of the field of [`Plan::Field`]. What counts is (part of a move outside the bin
/// where it starts)/(A Δx): 0.0141 here, 0.0144 over the paper's 25 x 25 with bins of 0.1, with S =
/// 0.75 in both (`docs/seven_per_cent.md`).
pub(crate) const NOISY_WIDTH: f64 = 10.5;
const NOISY_BIN: f64 = 0.4;

/// Sweeps of chains that bring a column near the steady state.
const APPROACH: u64 = 600;

impl Run {
    /// Moves, for the progress bar; chains are an order of magnitude dearer than trials.
    pub(crate) fn work(&self) -> u64 {
        let sweeps = match self.plan {
            Plan::Ours { equilibration, sweeps, .. } => 10 * (equilibration + sweeps),
            Plan::Field { jumps, equilibration, sweeps, .. } => {
                10 * APPROACH + jumps + equilibration + RUNS * sweeps
            }
            Plan::Protocol { equilibration, sweeps } => equilibration + RUNS * sweeps,
        };
        sweeps * self.case.particles() as u64
    }

    /// One profile, or one for each interval, and the warnings about the run.
    pub(crate) fn measure(&self, watch: &Watch<'_>) -> Result<Measured, Failure> {
        let case = &self.case;
        let field = ExponentialField::new(case.growth_rate)?;
        if case.decay_rate > 0.0 {
            let temperature = ExponentialTemperature::new(case.temperature, case.decay_rate)?;
            let scene = Scene::new(case.slab, case.particles(), field, temperature)?;
            let builder = Simulation::builder(scene).seed(self.seed).moves(self.moves()?);
            match self.plan {
                Plan::Ours { .. } => {
                    let builder = builder.scheme(SelfConsistent::default());
                    self.profiles(builder.start(self.start()?).build()?, watch)
                }
                Plan::Field { .. } => {
                    let start = Positions(self.near_the_steady_state(&scene, watch)?);
                    let simulation = builder.scheme(Instantaneous::new(NOISY_BIN)?).start(start).build()?;
                    self.profiles(simulation, watch)
                }
                Plan::Protocol { .. } => {
                    let builder = builder.scheme(Instantaneous::new(BIN)?);
                    self.profiles(builder.start(RandomInsertion::default()).build()?, watch)
                }
            }
        } else {
            let scene = Scene::new(case.slab, case.particles(), field, Isothermal::new(case.temperature)?)?;
            let builder = Simulation::builder(scene).seed(self.seed).moves(self.moves()?);
            self.profiles(builder.start(self.start()?).build()?, watch)
        }
    }

    fn side(&self) -> Side {
        match self.plan {
            // A crystal that is to grow from the fluid must not be there already.
            Plan::Ours { .. } if self.case.front().is_some() => Side::Above,
            Plan::Ours { number, .. } => Side::of(number),
            Plan::Field { side, .. } => side,
            Plan::Protocol { .. } => Side::Above,
        }
    }

    /// Far above the steady state; the paper's own start is higher still.
    fn gas(&self) -> Result<RandomInsertion, Failure> {
        Ok(match self.plan {
            Plan::Protocol { .. } => RandomInsertion::default(),
            // In this field a sphere at height x has e^{αx} times the weight.
            _ if self.case.growth_rate > 0.0 => RandomInsertion::new(0.5)?,
            _ => RandomInsertion::new(0.25)?,
        })
    }

    fn start(&self) -> Result<Box<dyn Start>, Failure> {
        Ok(match self.side() {
            Side::Above => Box::new(self.gas()?),
            Side::Below => Box::new(ClosePacked),
        })
    }

    fn moves(&self) -> Result<Moves, Failure> {
        Ok(match self.plan {
            Plan::Ours { .. } => EventChains::default().local_moves(Some(LocalMoves::tuned())).into(),
            Plan::Field { .. } | Plan::Protocol { .. } => {
                // The paper has smaller moves where it freezes.
                let size = if self.case.growth_rate > 0.09 { 0.25 } else { 0.75 };
                LocalMoves::new(size)?.into()
            }
        })
    }

    /// Chains in the theory's field, then jumps in the paper's: small moves would take a hundred
    /// thousand sweeps.
    fn near_the_steady_state(
        &self,
        scene: &Scene<ExponentialField, ExponentialTemperature>,
        watch: &Watch<'_>,
    ) -> Result<Vec<Vector3<f64>>, Failure> {
        let Plan::Field { jumps, .. } = self.plan else { return Ok(Vec::new()) };
        let builder = Simulation::builder(*scene)
            .scheme(EquationOfStateClosure::default())
            .moves(EventChains::default())
            .seed(self.seed ^ 0x5eed);
        let mut near = builder.start(self.start()?).build()?;
        let particles = self.case.particles() as u64;
        watch.equilibrate(&mut near, APPROACH, 10 * particles, &mut ())?;
        let mut near = Simulation::builder(*scene)
            .scheme(Instantaneous::new(NOISY_BIN)?)
            .moves(LocalMoves::tuned())
            .start(Positions(near.positions()))
            .seed(self.seed ^ 0xbed)
            .build()?;
        watch.equilibrate(&mut near, jumps, particles, &mut ())?;
        Ok(near.positions())
    }

    fn profiles<T: TemperatureProfile, S>(
        &self,
        mut simulation: Simulation<ExponentialField, T, S>,
        watch: &Watch<'_>,
    ) -> Result<Measured, Failure>
    where
        S: Scheme<ExponentialField, T, Drive: Persist, Adaptation: Persist>,
    {
        let (equilibration, intervals, sweeps, weight) = match self.plan {
            Plan::Ours { equilibration, sweeps, .. } => (equilibration, 1, sweeps, 10),
            Plan::Field { equilibration, sweeps, .. } | Plan::Protocol { equilibration, sweeps } => {
                (equilibration, RUNS, sweeps, 1)
            }
        };
        // Small moves change little in a sweep.
        let interval = if matches!(self.plan, Plan::Ours { .. }) { 1 } else { 4 };
        let size = weight * self.case.particles() as u64;
        watch.equilibrate(&mut simulation, equilibration, size, &mut ())?;
        let mut profiles = Vec::new();
        for _ in 0..intervals {
            let mut profile = Every::new(interval, self.profile()?);
            watch.run(&mut simulation, sweeps, size, &mut profile)?;
            profiles.push(profile.observer);
        }
        Ok(Measured { profiles, warnings: simulation.warnings() })
    }

    /// From the lowest center to a little above what is compared.
    fn profile(&self) -> Result<EquationOfStateProfile, Failure> {
        let bins = count((self.case.highest() + 10.0) / BIN);
        let top = 0.5 + bins as f64 * BIN;
        Ok(EquationOfStateProfile::new(&self.case.slab, Bins::count(bins).from(0.5).to(top))?)
    }

    /// In words.
    pub(crate) fn describe(plan: Plan) -> String {
        match plan {
            Plan::Ours { equilibration, sweeps, .. } => format!(
                "{RUNS} independent runs of event chains with tuned moves, alternately from above and below, {equilibration} sweeps of \
                equilibration, {sweeps} of production"
            ),
            Plan::Field { jumps, equilibration, sweeps, .. } => format!(
                "the field of the paper, in bins of {NOISY_BIN} with the same counting noise as 0.1 over 25 x 25, and its moves (S = 0.75): \
                equilibration by {APPROACH} sweeps of chains, {jumps} of jumps and {equilibration} of small moves, {RUNS} intervals of {sweeps} \
                sweeps of production, once from above and once from below"
            ),
            Plan::Protocol { equilibration, sweeps } => format!(
                "the protocol of the paper: from n = 0.1, moves up to 0.75 (0.25 at α = 0.1), {equilibration} sweeps of equilibration, {RUNS} \
                intervals of {sweeps} sweeps of production"
            ),
        }
    }
}

/// What the case is simulated over, in words.
pub(crate) fn describe_box(case: &Case) -> String {
    let [width, _] = case.slab.widths();
    format!(
        "N/A = {COLUMN_DENSITY}, {} spheres, box {} x {width} x {width}",
        case.particles(),
        case.slab.height()
    )
}
