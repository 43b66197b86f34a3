//! The simulations, by the default scheme and by the protocol of the paper.

use super::column::{Column, HEIGHT};
use gradient_mc::drive::{EquationOfStateClosure, ForceBalance, Instantaneous, SelfConsistent};
use gradient_mc::moves::{EventChains, LocalMoves};
use gradient_mc::observers::{Bins, CenterOfMass, DisplacementProfile, EquationOfStateProfile};
use gradient_mc::start::{ClosePacked, Positions, RandomInsertion};
use gradient_mc::{Every, Merge, Simulation, Slab, Warning};
use paper::study::count;
use paper::{Failure, Side, Watch};

/// Largest displacement of the paper's moves along each axis.
pub(crate) const MAXIMUM_DISPLACEMENT: f64 = 0.75;
/// Bins of density and pressure: those of the paper's field are 0.1 always.
pub(crate) const BIN: f64 = 0.25;

/// How long, how often and how wide.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Protocol {
    /// Side of the base.
    pub(crate) width: f64,
    /// Independent runs for every β, half of them from above and half from below.
    pub(crate) replicas: u64,
    /// Sweeps of equilibration.
    pub(crate) equilibration: u64,
    /// Sweeps of production.
    pub(crate) sweeps: u64,
    /// Sweeps of small moves for the mobility.
    pub(crate) mobility_sweeps: u64,
    /// Sweeps of the paper's protocol that are discarded, and as many that are measured; none: it
    /// is left out.
    pub(crate) paper_sweeps: Option<u64>,
}

impl Protocol {
    /// Sweeps of equilibration and production; steep columns relax slowest.
    pub(crate) fn sweeps_of(&self, decay_rate: f64) -> [u64; 2] {
        let times = if decay_rate > 0.025 { 2 } else { 1 };
        [times * self.equilibration, times * self.sweeps]
    }
}

/// Whose run it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Method {
    /// Event chains and tuned moves in a field that was iterated, then frozen.
    Ours,
    /// Small moves in a field that follows every configuration.
    Papers,
}

/// What a run measured.
#[derive(Debug, Clone)]
pub(crate) struct Measured {
    pub(crate) profile: EquationOfStateProfile,
    pub(crate) center_of_mass: CenterOfMass,
    pub(crate) mobility: DisplacementProfile,
    pub(crate) balance: ForceBalance,
    pub(crate) side: Side,
    pub(crate) warnings: Vec<Warning>,
}

impl Measured {
    /// Adds another run of the same column; the centers of mass stay apart.
    pub(crate) fn merge(&mut self, other: &Self) -> Result<(), Failure> {
        self.profile.merge(&other.profile)?;
        self.mobility.merge(&other.mobility)?;
        Ok(self.balance.merge(&other.balance)?)
    }
}

/// One run.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Run<'a> {
    pub(crate) column: &'a Column,
    pub(crate) protocol: Protocol,
    pub(crate) method: Method,
    pub(crate) side: Side,
    pub(crate) seed: u64,
}

impl Run<'_> {
    /// In words.
    pub(crate) fn name(&self) -> String {
        format!("β = {}, {:?}, from {:?}, seed {}", self.column.decay_rate, self.method, self.side, self.seed)
    }

    /// Sweeps, for the progress bar.
    pub(crate) fn work(&self) -> u64 {
        match self.method {
            Method::Ours => self.protocol.sweeps_of(self.column.decay_rate).iter().sum(),
            Method::Papers => 2 * self.protocol.paper_sweeps.unwrap_or(0),
        }
    }

    pub(crate) fn measure(&self, watch: &Watch<'_>) -> Result<Measured, Failure> {
        match self.method {
            Method::Ours => self.ours(watch),
            Method::Papers => self.papers(watch),
        }
    }

    fn ours(&self, watch: &Watch<'_>) -> Result<Measured, Failure> {
        let moves = EventChains::default().local_moves(Some(LocalMoves::tuned()));
        let builder = Simulation::builder(self.column.scene()?)
            .scheme(SelfConsistent::default())
            .moves(moves)
            .seed(self.seed);
        let mut simulation = match self.side {
            Side::Above => builder.start(RandomInsertion::default()).build()?,
            Side::Below => builder.start(ClosePacked).build()?,
        };
        let [equilibration, sweeps] = self.protocol.sweeps_of(self.column.decay_rate);
        watch.equilibrate(&mut simulation, equilibration, 1, &mut ())?;
        // The dilute top decorrelates within a sweep, so frequent samples are useful.
        let mut observers = Every::new(2, (profile(&self.column.slab)?, CenterOfMass::new()));
        watch.run(&mut simulation, sweeps, 1, &mut observers)?;
        let balance = simulation.force_balance().ok_or("no balance of forces was recorded")?.clone();
        let warnings = simulation.warnings();
        // The paper's moves, from here on, for the mobility, in the theory's field, which is within a fifth
        // of a per cent of the one that was measured.
        let moves = LocalMoves::new(MAXIMUM_DISPLACEMENT)?;
        let mut slow = Simulation::builder(self.column.scene()?)
            .scheme(EquationOfStateClosure::default())
            .moves(moves)
            .start(Positions(simulation.positions()))
            .seed(self.seed ^ 0x5eed)
            .build()?;
        let mut mobility = Every::new(5, mobility(&self.column.slab)?);
        watch.run(&mut slow, self.protocol.mobility_sweeps, 0, &mut mobility)?;
        let (profile, center_of_mass) = observers.observer;
        Ok(Measured {
            profile,
            center_of_mass,
            mobility: mobility.observer,
            balance,
            side: self.side,
            warnings,
        })
    }

    fn papers(&self, watch: &Watch<'_>) -> Result<Measured, Failure> {
        let moves = LocalMoves::new(MAXIMUM_DISPLACEMENT)?;
        let mut simulation = Simulation::builder(self.column.scene()?)
            .scheme(Instantaneous::default())
            .moves(moves)
            .start(RandomInsertion::default())
            .seed(self.seed)
            .build()?;
        let sweeps = self.protocol.paper_sweeps.unwrap_or(0);
        watch.equilibrate(&mut simulation, sweeps, 1, &mut ())?;
        let slab = &self.column.slab;
        let mut observers = Every::new(10, (profile(slab)?, CenterOfMass::new(), mobility(slab)?));
        watch.run(&mut simulation, sweeps, 1, &mut observers)?;
        let balance = simulation.force_balance().ok_or("no balance of forces was recorded")?.clone();
        let (profile, center_of_mass, mobility) = observers.observer;
        let warnings = simulation.warnings();
        Ok(Measured { profile, center_of_mass, mobility, balance, side: self.side, warnings })
    }
}

/// From the lowest center to the highest.
fn profile(slab: &Slab) -> Result<EquationOfStateProfile, Failure> {
    Ok(EquationOfStateProfile::new(
        slab,
        Bins::count(count((HEIGHT - 1.0) / BIN)).from(0.5).to(HEIGHT - 0.5),
    )?)
}

/// In bins of a diameter.
fn mobility(slab: &Slab) -> Result<DisplacementProfile, Failure> {
    Ok(DisplacementProfile::new(slab, Bins::count(399).from(0.5).to(HEIGHT - 0.5))?)
}
