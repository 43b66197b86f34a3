//! The command line, and the protocol of the runs.

use clap::ValueEnum;
use gradient_mc::Slab;
use gradient_mc::moves::{EventChains, LocalMoves, Moves};
use paper::study::count;
use paper::{Failure, Session};
use std::fmt;
use std::str::FromStr;

/// Figures 7 to 13 of doi:10.1103/PhysRevE.83.061306: T = 20 in a field exp(αx), with the crystal
/// at α = 0.1.
#[derive(clap::Args, Debug)]
pub(crate) struct Arguments {
    /// Part of the study to run
    #[arg(long, value_enum, default_value_t = Part::All)]
    pub(crate) part: Part,

    /// Use the full protocol of the paper: base 25 x 25, local moves, random start, 500000 sweeps
    /// of equilibration, five intervals of 100000 sweeps (hours)
    #[arg(long)]
    pub(crate) paper: bool,

    /// Base of a crystal in diameters, for example 8.6x9.4; may be given several times [default:
    /// 8.64x9.353; with --paper: 25x25]
    #[arg(long)]
    pub(crate) base: Vec<Base>,

    /// Number of crystals on every base
    #[arg(long, default_value_t = 1)]
    pub(crate) crystals: u64,

    /// Method of growing crystals [default: rising; with --paper: settling]
    #[arg(long, value_enum)]
    pub(crate) growth: Option<Growth>,

    /// Sweeps of growth [default: the number that 30 layers usually need]
    #[arg(long)]
    pub(crate) growth_sweeps: Option<u64>,
}

/// What is simulated.
#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Part {
    /// The three fluid columns and the crystal: all figures
    All,
    /// Only the fluid columns: figures 7, 8 and 13, and their part of figure 12
    Fluids,
    /// Only the crystals: figures 9 to 11, and their part of figures 12 and 13
    Crystals,
}

impl Part {
    pub(crate) fn fluids(self) -> bool {
        self != Self::Crystals
    }

    pub(crate) fn crystals(self) -> bool {
        self != Self::Fluids
    }
}

/// Method of growing a crystal from the random start.
#[derive(ValueEnum, Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Growth {
    /// Local moves with S = 0.25, as in the paper: the crystal grows while the gas settles slowly
    Settling,
    /// Short event chains with tuned moves between them: the gas settles at once and then
    /// crystallizes
    Chains,
    /// The same, while α rises from 0.055, where all is fluid, to 0.1 over two thirds of the sweeps
    Rising,
}

impl Growth {
    /// α after a fraction of the growth.
    pub(crate) fn rate(self, share: f64) -> f64 {
        const FLUID: f64 = 0.055;
        let last = Protocol::CRYSTAL_RATE;
        match self {
            Self::Settling | Self::Chains => last,
            Self::Rising => (FLUID + (last - FLUID) * 1.5 * share).min(last),
        }
    }

    pub(crate) fn moves(self) -> Result<Moves, Failure> {
        match self {
            Self::Settling => Protocol::local_moves(Protocol::CRYSTAL_RATE),
            Self::Chains | Self::Rising => Protocol::crystal_moves(),
        }
    }

    /// In words.
    pub(crate) fn describe(self) -> &'static str {
        match self {
            Self::Settling => "settling from a gas by local moves, S = 0.25",
            Self::Chains => "from a gas that falls at once, by short event chains",
            Self::Rising => "by short event chains while α rises from 0.055 to 0.1",
        }
    }
}

/// Sides of a base along y and z, in diameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Base(pub(crate) [f64; 2]);

impl FromStr for Base {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let side = |text: &str| text.parse::<f64>().map_err(|error| format!("{text}: {error}"));
        let (first, second) = text.split_once('x').unwrap_or((text, text));
        Ok(Self([side(first)?, side(second)?]))
    }
}

impl fmt::Display for Base {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}x{}", self.0[0], self.0[1])
    }
}

impl Base {
    pub(crate) fn slab(self) -> Result<Slab, Failure> {
        Ok(Slab::new(Protocol::HEIGHT, self.0[0], self.0[1])?)
    }

    /// Spheres that make the paper's column on this base.
    pub(crate) fn particles(self) -> usize {
        count(Protocol::COLUMN_DENSITY * self.0[0] * self.0[1])
    }
}

/// What one stage of a run consists of.
#[derive(Debug, Clone)]
pub(crate) struct Stage {
    pub(crate) moves: Moves,
    /// Sweeps before anything but the center of mass is measured.
    pub(crate) equilibration: u64,
    /// Consecutive intervals of measurement, in sweeps; the paper's runs.
    pub(crate) intervals: Vec<u64>,
    /// Sweeps between two samples.
    pub(crate) interval: u64,
}

impl Stage {
    pub(crate) fn sweeps(&self) -> u64 {
        self.equilibration + self.intervals.iter().sum::<u64>()
    }
}

/// Everything that the runs depend on.
#[derive(Debug, Clone)]
pub(crate) struct Protocol {
    pub(crate) paper: bool,
    /// Of the fluid columns.
    pub(crate) base: Base,
    /// Of the columns whose relaxation by the paper's moves is shown.
    pub(crate) relaxation_base: Base,
    pub(crate) replicas: u64,
    pub(crate) crystal_bases: Vec<Base>,
    pub(crate) crystals: u64,
    pub(crate) growth: Growth,
    pub(crate) growth_sweeps: u64,
    /// Of the relaxation by the paper's moves, without --paper.
    pub(crate) relaxation_sweeps: u64,
    short: bool,
    first_seed: u64,
}

impl Protocol {
    /// Height of the box, in diameters.
    pub(crate) const HEIGHT: f64 = 400.0;
    /// Spheres per area of the base.
    pub(crate) const COLUMN_DENSITY: f64 = 40.0;
    /// T, in m g d.
    pub(crate) const TEMPERATURE: f64 = 20.0;
    /// α of the columns that stay fluid, per diameter.
    pub(crate) const FLUID_RATES: [f64; 3] = [0.0025, 0.02, 0.05];
    /// α of the column that freezes.
    pub(crate) const CRYSTAL_RATE: f64 = 0.1;

    pub(crate) fn new(arguments: &Arguments, session: &Session) -> Result<Self, Failure> {
        let paper = arguments.paper;
        let width = if paper { 25.0 } else { session.choose(8.0, 4.0) };
        let growth = arguments.growth.unwrap_or(if paper { Growth::Settling } else { Growth::Rising });
        let usual_growth = match growth {
            Growth::Settling => session.choose(500_000, 10_000),
            Growth::Chains | Growth::Rising => session.choose(15_000, 1500),
        };
        let mut crystal_bases = arguments.base.clone();
        if crystal_bases.is_empty() {
            crystal_bases.push(Base(if paper {
                [25.0, 25.0]
            } else {
                session.choose([8.64, 9.353], [4.32, 4.677])
            }));
        }
        if arguments.crystals == 0 {
            return Err("--crystals must be at least 1".into());
        }
        Ok(Self {
            paper,
            base: Base([width, width]),
            relaxation_base: Base(if paper { [width, width] } else { [5.0, 5.0] }),
            replicas: if paper { 1 } else { 2 },
            crystal_bases,
            crystals: arguments.crystals,
            growth,
            growth_sweeps: arguments.growth_sweeps.unwrap_or(usual_growth),
            relaxation_sweeps: session.choose(100_000, 2000),
            short: session.short,
            first_seed: session.seed(0),
        })
    }

    /// S of the paper, in diameters.
    pub(crate) fn maximum_displacement(rate: f64) -> f64 {
        if rate < 0.1 { 0.75 } else { 0.25 }
    }

    /// The moves of the paper in a field of this rate.
    pub(crate) fn local_moves(rate: f64) -> Result<Moves, Failure> {
        Ok(LocalMoves::new(Self::maximum_displacement(rate))?.into())
    }

    /// Relaxation from the random start to the steady state by the moves of the paper.
    pub(crate) fn relaxation(&self, rate: f64) -> Result<Stage, Failure> {
        let moves = Self::local_moves(rate)?;
        Ok(if self.paper {
            Stage { moves, equilibration: 500_000, intervals: vec![100_000; 5], interval: 20 }
        } else {
            Stage { moves, equilibration: self.relaxation_sweeps, intervals: Vec::new(), interval: 100 }
        })
    }

    /// The steady state by faster moves: tuned local moves, or event chains if the base is dense.
    pub(crate) fn steady_state(&self, rate: f64) -> Stage {
        const DENSE: f64 = 0.03;
        if rate < DENSE {
            let moves = LocalMoves::tuned().into();
            return self.stage(moves, [4000, 40_000], 20);
        }
        let moves = EventChains::default().local_moves(Some(LocalMoves::tuned())).into();
        self.stage(moves, [1500, 12_000], 5)
    }

    fn stage(&self, moves: Moves, sweeps: [u64; 2], interval: u64) -> Stage {
        let [equilibration, measured] = sweeps.map(|sweeps| if self.short { sweeps / 5 } else { sweeps });
        Stage { moves, equilibration, intervals: vec![measured], interval }
    }

    /// Moves for growth and production of a dense crystal: chains of a few diameters, half of them
    /// lateral. Long chains, which move the column as a whole, are not needed. With the default path
    /// the front does not follow coexistence.
    pub(crate) fn crystal_moves() -> Result<Moves, Failure> {
        let chains = EventChains::with_length(5.0)?.vertical_fraction(0.5)?.path_per_sphere(1.2)?;
        Ok(chains.local_moves(Some(LocalMoves::tuned())).into())
    }

    /// Seed of a run: the same for any number of threads.
    pub(crate) fn seed(&self, run: u64) -> u64 {
        self.first_seed.wrapping_add(run)
    }
}
