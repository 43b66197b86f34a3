//! How long, how many and from where: the command line, made definite.

use super::case::Case;
use clap::ValueEnum;
use gradient_mc::Slab;
use gradient_mc::moves::{EventChains, LocalMoves, Moves};
use paper::study::count;
use paper::{Failure, Session};
use std::fmt;

/// Simulates the three systems of doi:10.1103/PhysRevE.83.061306 and compares each with theory.
#[derive(clap::Args, Debug)]
pub(crate) struct Arguments {
    /// Where the spheres are at first [default: theory; with --paper: random-insertion]
    #[arg(long, value_enum)]
    pub(crate) start: Option<StartChoice>,

    /// How the varying temperature of case (c) enters
    #[arg(long, value_enum, default_value_t = SchemeChoice::SelfConsistent)]
    pub(crate) scheme: SchemeChoice,

    /// What sweeps consist of [default: both; with --paper: local]
    #[arg(long, value_enum)]
    pub(crate) moves: Option<MovesChoice>,

    /// Sweeps measured in every replica [default: 6000; with --paper: 500000]
    #[arg(long)]
    pub(crate) sweeps: Option<u64>,

    /// Sweeps before the measurement [default: 1500; with --paper: 500000]
    #[arg(long)]
    pub(crate) equilibration: Option<u64>,

    /// Spheres [default: 5760; with --paper: 25000]. The base is a square of area N/40, so that the
    /// column stays that of the paper
    #[arg(long)]
    pub(crate) particles: Option<usize>,

    /// Independent replicas of every case [default: 4; with --paper: 1]
    #[arg(long)]
    pub(crate) replicas: Option<u64>,

    /// Height of the bins in diameters [default: 0.5; with --paper: 0.1]
    #[arg(long)]
    pub(crate) bin_width: Option<f64>,

    /// The full protocol of the paper: random insertion of 25 000 spheres, 500000 sweeps, then five
    /// intervals of 100000 (hours). Options given beside it take precedence
    #[arg(long)]
    pub(crate) paper: bool,
}

/// Where the spheres are at first.
#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum StartChoice {
    /// Random insertion at n = 0.1: far too high
    RandomInsertion,
    /// The hydrostatic profile of theory: close to the answer, and therefore no evidence
    Theory,
    /// A crystal on the base: far too low
    ClosePacked,
}

/// What sweeps consist of.
#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum MovesChoice {
    /// Event chains: nothing is rejected, and the column relaxes in a thousandth of the time
    Chains,
    /// The paper's trial displacements of single spheres
    Local,
    /// Displacements of single spheres whose sizes are tuned by height, with long jumps among them
    Tuned,
    /// Event chains, and tuned displacements between them
    Both,
}

/// How a temperature that varies enters the acceptance.
#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SchemeChoice {
    /// Measured while equilibrating, then frozen
    SelfConsistent,
    /// From the equation of state: it is imposed, not measured
    Closure,
    /// From every sweep's histogram, as the paper is written
    Instantaneous,
}

/// Everything that a run depends on.
#[derive(Debug, Clone)]
pub(crate) struct Protocol {
    pub(crate) start: StartChoice,
    pub(crate) moves: MovesChoice,
    pub(crate) scheme: SchemeChoice,
    pub(crate) particles: usize,
    pub(crate) replicas: u64,
    pub(crate) equilibration: u64,
    /// Consecutive intervals of measurement, in sweeps: the paper's runs.
    pub(crate) intervals: Vec<u64>,
    pub(crate) bin_width: f64,
    first_seed: u64,
}

impl Protocol {
    /// Height of the box, in diameters.
    pub(crate) const HEIGHT: f64 = 400.0;
    /// Spheres per area of the base.
    pub(crate) const COLUMN_DENSITY: f64 = 40.0;
    /// Largest displacement in a trial move, in diameters.
    const MAXIMUM_DISPLACEMENT: f64 = 0.75;
    /// Of event chains between tuned moves: collisions and ranks then become known about equally
    /// well.
    const PATH_PER_SPHERE: f64 = 0.12;

    pub(crate) fn new(arguments: &Arguments, session: &Session) -> Result<Self, Failure> {
        let choose =
            |given: Option<u64>, paper, usual| given.unwrap_or(if arguments.paper { paper } else { usual });
        let sweeps = choose(arguments.sweeps, 500_000, session.choose(6000, 600));
        let count = if arguments.paper { 5 } else { 1 };
        let replicas = choose(arguments.replicas, 1, 4);
        if replicas == 0 {
            return Err("--replicas must be at least 1".into());
        }
        let usual_start = if arguments.paper { StartChoice::RandomInsertion } else { StartChoice::Theory };
        let usual_moves = if arguments.paper { MovesChoice::Local } else { MovesChoice::Both };
        Ok(Self {
            start: arguments.start.unwrap_or(usual_start),
            moves: arguments.moves.unwrap_or(usual_moves),
            scheme: arguments.scheme,
            particles: arguments.particles.unwrap_or(if arguments.paper { 25_000 } else { 5760 }),
            replicas,
            equilibration: choose(arguments.equilibration, 500_000, session.choose(1500, 600)),
            intervals: (0..count).map(|k| sweeps * (k + 1) / count - sweeps * k / count).collect(),
            bin_width: arguments.bin_width.unwrap_or(if arguments.paper { 0.1 } else { 0.5 }),
            first_seed: session.seed(0),
        })
    }

    /// A few sweeps near the steady state, to see how fast this machine is.
    pub(crate) fn trial(&self) -> Self {
        Self { start: StartChoice::Theory, equilibration: 40, intervals: Vec::new(), ..self.clone() }
    }

    /// What the library is to make sweeps of.
    pub(crate) fn moves(&self) -> Result<Moves, Failure> {
        Ok(match self.moves {
            MovesChoice::Chains => EventChains::default().into(),
            MovesChoice::Tuned => LocalMoves::tuned().into(),
            MovesChoice::Both => {
                let chains = EventChains::default().path_per_sphere(Self::PATH_PER_SPHERE)?;
                chains.local_moves(Some(LocalMoves::tuned())).into()
            }
            MovesChoice::Local => LocalMoves::new(Self::MAXIMUM_DISPLACEMENT)?.into(),
        })
    }

    /// The moves as they stand on the command line.
    pub(crate) fn moves_name(&self) -> String {
        name_of(&self.moves)
    }

    pub(crate) fn slab(&self) -> Result<Slab, Failure> {
        Ok(Slab::new(Self::HEIGHT, self.width(), self.width())?)
    }

    /// Side of the square base, in diameters.
    pub(crate) fn width(&self) -> f64 {
        (self.particles as f64 / Self::COLUMN_DENSITY).sqrt()
    }

    /// Bins of the whole height, as near to the width asked for as divides it.
    pub(crate) fn bins(&self) -> usize {
        count(Self::HEIGHT / self.bin_width)
    }

    /// Sweeps measured.
    pub(crate) fn production(&self) -> u64 {
        self.intervals.iter().sum()
    }

    /// Sweeps of one replica, equilibration included.
    pub(crate) fn sweeps_per_replica(&self) -> u64 {
        self.equilibration + self.production()
    }

    /// Seed of a replica: the same for any number of threads.
    pub(crate) fn seed(&self, case: Case, replica: u64) -> u64 {
        self.first_seed.wrapping_add(replica * Case::ALL.len() as u64 + case as u64)
    }
}

impl fmt::Display for Protocol {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            formatter,
            "{} spheres in {} x {:.4} x {:.4}; {} start; {} moves; {} replicas of {} + {} sweeps; bins of {:.3}",
            self.particles,
            Self::HEIGHT,
            self.width(),
            self.width(),
            name_of(&self.start),
            self.moves_name(),
            self.replicas,
            self.equilibration,
            self.production(),
            Self::HEIGHT / self.bins() as f64,
        )
    }
}

/// A choice as it stands on the command line.
fn name_of(choice: &impl ValueEnum) -> String {
    choice.to_possible_value().map_or(String::new(), |value| value.get_name().to_owned())
}
