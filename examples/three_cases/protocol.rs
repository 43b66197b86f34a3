//! The command line, and the protocol of the runs.

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
    /// Initial configuration [default: theory; with --paper: random-insertion]
    #[arg(long, value_enum)]
    pub(crate) start: Option<StartChoice>,

    /// Scheme for the effective field of case (c)
    #[arg(long, value_enum, default_value_t = SchemeChoice::SelfConsistent)]
    pub(crate) scheme: SchemeChoice,

    /// Moves of a sweep [default: both; with --paper: local]
    #[arg(long, value_enum)]
    pub(crate) moves: Option<MovesChoice>,

    /// Sweeps of production of every replica [default: 6000; with --paper: 500000]
    #[arg(long)]
    pub(crate) sweeps: Option<u64>,

    /// Sweeps of equilibration of every replica [default: 1500; with --paper: 500000]
    #[arg(long)]
    pub(crate) equilibration: Option<u64>,

    /// Number of spheres N; the base is a square of N/40 d² [default: 5760; with --paper: 25000]
    #[arg(long)]
    pub(crate) particles: Option<usize>,

    /// Independent replicas of every case [default: 4; with --paper: 1]
    #[arg(long)]
    pub(crate) replicas: Option<u64>,

    /// Height of the bins in diameters [default: 0.5; with --paper: 0.1]
    #[arg(long)]
    pub(crate) bin_width: Option<f64>,

    /// Use the protocol of the paper: random insertion of 25000 spheres, 500000 sweeps of
    /// equilibration, five intervals of 100000 sweeps (hours); other options take precedence
    #[arg(long)]
    pub(crate) paper: bool,
}

/// Initial configuration.
#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum StartChoice {
    /// Random insertion at n = 0.1/d³: the column starts far too high
    RandomInsertion,
    /// The hydrostatic profile: close to the steady state, so agreement with theory is no test
    Theory,
    /// A close-packed crystal on the base: the column starts far too low
    ClosePacked,
}

/// Moves of a sweep.
#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum MovesChoice {
    /// Event chains: no rejections, and the column relaxes more than a hundred times faster
    Chains,
    /// Trial displacements of single spheres, as in the paper
    Local,
    /// Trial displacements of single spheres with sizes tuned by height, and long jumps
    Tuned,
    /// Event chains with tuned displacements between them
    Both,
}

/// Scheme for the effective field if the temperature varies.
#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SchemeChoice {
    /// Iterated from measurements in equilibration, then frozen
    SelfConsistent,
    /// From an equation of state, which is an input and not measured
    Closure,
    /// From the histogram of every sweep, as in the paper
    Instantaneous,
}

/// All parameters of a run.
#[derive(Debug, Clone)]
pub(crate) struct Protocol {
    pub(crate) start: StartChoice,
    pub(crate) moves: MovesChoice,
    pub(crate) scheme: SchemeChoice,
    pub(crate) particles: usize,
    pub(crate) replicas: u64,
    pub(crate) equilibration: u64,
    /// Consecutive intervals of production, in sweeps: the runs of the paper.
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
    /// Path of event chains per sphere and sweep, between tuned moves, in diameters. With this
    /// value Z from collisions and from ranks has similar errors.
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

    /// A short protocol near the steady state, to measure the speed of this machine.
    pub(crate) fn trial(&self) -> Self {
        Self { start: StartChoice::Theory, equilibration: 40, intervals: Vec::new(), ..self.clone() }
    }

    /// The moves for the library.
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

    /// The moves as named on the command line.
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

    /// Number of bins over the whole height, with about the requested width.
    pub(crate) fn bins(&self) -> usize {
        count(Self::HEIGHT / self.bin_width)
    }

    /// Number of sweeps of production.
    pub(crate) fn production(&self) -> u64 {
        self.intervals.iter().sum()
    }

    /// Number of sweeps of one replica, including equilibration.
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

/// A choice as named on the command line.
fn name_of(choice: &impl ValueEnum) -> String {
    choice.to_possible_value().map_or(String::new(), |value| value.get_name().to_owned())
}
