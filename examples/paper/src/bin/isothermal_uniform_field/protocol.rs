//! The command line, and the protocol of the runs.

use gradient_mc::Slab;
use gradient_mc::moves::{EventChains, LocalMoves, Moves};
use paper::study::count;
use paper::{Failure, Session, Side};
use std::fmt;

/// Figures 2 to 6 of doi:10.1103/PhysRevE.83.061306: an isothermal column in a uniform field, and
/// the layers at its base.
#[derive(clap::Args, Debug)]
pub(crate) struct Arguments {
    /// Use the full protocol of the paper: base 25 x 25, its moves, random start, 500000 sweeps of
    /// equilibration, 500000 of production (hours)
    #[arg(long)]
    pub(crate) paper: bool,

    /// With --paper: side of the base, 4 to 100 diameters; the time is proportional to its square
    #[arg(long, default_value_t = 25.0, value_parser = width, requires = "paper")]
    pub(crate) width: f64,

    /// With --paper: only this temperature, 5, 15, 20 or 30 m g d; may be given several times
    #[arg(long = "temperature", value_parser = temperature, requires = "paper")]
    pub(crate) temperatures: Vec<f64>,
}

impl Arguments {
    /// The temperatures that are simulated, the densest column first.
    pub(crate) fn temperatures(&self) -> impl Iterator<Item = f64> {
        TEMPERATURES
            .into_iter()
            .filter(|known| self.temperatures.is_empty() || self.temperatures.contains(known))
    }
}

fn temperature(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(temperature) if TEMPERATURES.contains(&temperature) => Ok(temperature),
        Ok(_) => Err("use 5, 15, 20 or 30".into()),
        Err(error) => Err(format!("{error}")),
    }
}

fn width(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(width) if (4.0..=100.0).contains(&width) => Ok(width),
        Ok(_) => Err("use 4 to 100".into()),
        Err(error) => Err(format!("{error}")),
    }
}

/// Height of the box, in diameters.
pub(crate) const HEIGHT: f64 = 400.0;
/// Spheres per area of the base.
pub(crate) const COLUMN_DENSITY: f64 = 40.0;
/// The paper's largest displacement in a trial move, in diameters.
pub(crate) const PAPER_DISPLACEMENT: f64 = 0.75;
/// Temperatures T₀ in m g d: those of the paper's figures 2 to 6, the densest first.
pub(crate) const TEMPERATURES: [f64; 4] = [5.0, 15.0, 20.0, 30.0];
/// Temperatures drawn in most figures (20 only in figure 5).
pub(crate) const DRAWN: [f64; 3] = [5.0, 15.0, 30.0];

/// The moves of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Family {
    /// Local moves as in the paper: displacements up to 0.75 along each axis.
    Paper,
    /// Tuned local moves, which are fastest if the base is not dense.
    Tuned,
    /// Event chains with tuned local moves between them.
    Chains,
}

impl Family {
    pub(crate) fn moves(self) -> Result<Moves, Failure> {
        Ok(match self {
            Self::Paper => LocalMoves::new(PAPER_DISPLACEMENT)?.into(),
            Self::Tuned => LocalMoves::tuned().into(),
            Self::Chains => EventChains::default().local_moves(Some(LocalMoves::tuned())).into(),
        })
    }

    /// Cost of a sweep per sphere, in units of one of the paper's trials; for the progress bar
    /// alone.
    fn cost(self) -> u64 {
        if self == Self::Chains { 6 } else { 1 }
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Paper => "moves of the paper",
            Self::Tuned => "tuned local moves",
            Self::Chains => "event chains with tuned local moves",
        }
    }
}

/// One column to be simulated.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Task {
    pub(crate) temperature: f64,
    /// Side of the square base, in diameters.
    pub(crate) width: f64,
    /// From above: random insertion at n = 0.1, as in the paper, with the center of mass at 200; or
    /// from a crystal below 20.
    pub(crate) side: Side,
    pub(crate) family: Family,
    pub(crate) equilibration: u64,
    pub(crate) production: u64,
    /// Sweeps between two samples.
    pub(crate) interval: u64,
    /// Sweeps of small local moves, from the steady state, in which the layers at the base are
    /// measured.
    pub(crate) layers: u64,
    /// Sweeps of the paper's moves, from the steady state, in which displacements are recorded.
    pub(crate) mobility: u64,
    pub(crate) seed: u64,
}

impl Task {
    /// In words.
    pub(crate) fn name(&self) -> String {
        let Self { temperature, width, side, family, seed, .. } = self;
        format!("T = {temperature}, base {width}, from {side:?}, moves {family:?}, seed {seed}")
    }

    pub(crate) fn slab(&self) -> Result<Slab, Failure> {
        Ok(Slab::new(HEIGHT, self.width, self.width)?)
    }

    pub(crate) fn particles(&self) -> usize {
        count(COLUMN_DENSITY * self.width * self.width)
    }

    /// S with which the structure at the base is renewed the soonest: smaller where it is dense.
    pub(crate) fn small_displacement(&self) -> f64 {
        if self.temperature < 10.0 { 0.15 } else { 0.3 }
    }

    /// Progress that a sweep is worth.
    pub(crate) fn cost_of_sweep(&self) -> u64 {
        self.particles() as u64 * self.family.cost()
    }

    pub(crate) fn cost(&self) -> u64 {
        let from_steady = (self.layers + self.mobility) * self.particles() as u64;
        (self.equilibration + self.production) * self.cost_of_sweep() + from_steady
    }
}

/// All columns.
#[derive(Debug, Clone)]
pub(crate) struct Protocol {
    /// Columns that are brought to their steady state and measured.
    pub(crate) steady: Vec<Task>,
    /// Columns that fall by the paper's moves, for figure 2. With the paper's protocol the steady
    /// ones show that.
    pub(crate) falling: Vec<Task>,
}

impl Protocol {
    /// Bases of the columns that are measured: figures are drawn from the wider.
    pub(crate) const WIDTHS: [f64; 2] = [12.0, 8.0];

    pub(crate) fn new(arguments: &Arguments, session: &Session) -> Self {
        let scaled = |sweeps: f64| count(sweeps * session.choose(1.0, 0.1)) as u64;
        let base = Task {
            temperature: 0.0,
            width: arguments.width,
            side: Side::Above,
            family: Family::Paper,
            equilibration: scaled(500_000.0),
            production: scaled(500_000.0),
            interval: 20,
            layers: 0,
            mobility: 0,
            seed: 0,
        };
        let mut steady = Vec::new();
        let mut falling = Vec::new();
        for temperature in arguments.temperatures() {
            if arguments.paper {
                steady.push(Task { temperature, ..base });
            } else {
                for width in Self::WIDTHS {
                    for side in Side::BOTH {
                        steady.push(Task { width, side, ..Self::column(temperature, base, &scaled) });
                    }
                }
                if DRAWN.contains(&temperature) {
                    // The paper's moves take the longest where the column is highest.
                    let sweeps = match temperature {
                        5.0 => 150_000.0,
                        15.0 => 190_000.0,
                        _ => 320_000.0,
                    };
                    falling.push(Task {
                        temperature,
                        width: 4.0,
                        equilibration: scaled(sweeps),
                        production: 0,
                        ..base
                    });
                }
            }
        }
        // Layers are measured over the widest base, displacements in one column there.
        let widest = steady.iter().map(|task| task.width).fold(0.0, f64::max);
        for task in steady.iter_mut().filter(|task| task.width == widest) {
            task.layers = scaled(match task.temperature {
                5.0 => 13_000.0,
                // The third layer is broad, and its place hard to tell.
                15.0 => 26_000.0,
                _ => 11_000.0,
            });
            if task.side == Side::Above && [5.0, 20.0].contains(&task.temperature) {
                task.mobility = scaled(3000.0);
            }
        }
        for (number, task) in steady.iter_mut().chain(&mut falling).enumerate() {
            task.seed = session.seed(number as u64);
        }
        Self { steady, falling }
    }

    /// A column with fast moves: chains if the base is dense.
    fn column(temperature: f64, base: Task, scaled: &impl Fn(f64) -> u64) -> Task {
        let (family, equilibration, production) = match temperature {
            5.0 => (Family::Chains, 1500.0, 7000.0),
            15.0 => (Family::Tuned, 3000.0, 8000.0),
            20.0 => (Family::Tuned, 2000.0, 12_000.0),
            _ => (Family::Tuned, 1000.0, 7000.0),
        };
        let (equilibration, production) = (scaled(equilibration), scaled(production));
        Task { temperature, family, equilibration, production, interval: 5, ..base }
    }

    /// All columns, the measured ones first.
    pub(crate) fn tasks(&self) -> impl Iterator<Item = &Task> {
        self.steady.iter().chain(&self.falling)
    }
}

impl fmt::Display for Protocol {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let describe = |formatter: &mut fmt::Formatter<'_>, task: &Task| {
            let start = if task.side == Side::Above { "random" } else { "close-packed" };
            writeln!(
                formatter,
                "T = {:2}: {:5} spheres over {} x {}, {start} start, {}, {} + {} sweeps, seed {}",
                task.temperature,
                task.particles(),
                task.width,
                task.width,
                task.family.name(),
                task.equilibration,
                task.production,
                task.seed,
            )
        };
        self.tasks().try_for_each(|task| describe(formatter, task))
    }
}
