//! The ways of moving a column, behind one face.

use crate::column::{HEIGHT, TEMPERATURE, particles};
use gradient_mc::drive::Drive;
use gradient_mc::field::UniformField;
use gradient_mc::moves::{EventChains, LocalMoves, Moves};
use gradient_mc::start::{RandomInsertion, Start, Theory};
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Field, Scene, Simulation, Slab, TemperatureProfile};
use paper::Failure;
use paper::plain::PlainColumn;

/// The paper's largest displacement.
const DISPLACEMENT: f64 = 0.75;
/// Sweeps in which what can be tuned is; they count like all others.
const EQUILIBRATION: u64 = 1024;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Method {
    Plain,
    LocalFromUniform,
    TunedFromUniform,
    ChainsFromUniform,
    LocalFromTheory,
    TunedFromTheory,
    ChainsFromTheory,
}

impl Method {
    pub(crate) const ALL: [Self; 7] = [
        Self::TunedFromTheory,
        Self::TunedFromUniform,
        Self::ChainsFromTheory,
        Self::ChainsFromUniform,
        Self::LocalFromTheory,
        Self::LocalFromUniform,
        Self::Plain,
    ];

    pub(crate) fn label(self) -> &'static str {
        match self {
            Self::Plain => "the paper's algorithm, uniform start",
            Self::LocalFromUniform => "local moves, uniform start",
            Self::TunedFromUniform => "tuned local moves, uniform start",
            Self::ChainsFromUniform => "event chains, uniform start",
            Self::LocalFromTheory => "local moves, theory start",
            Self::TunedFromTheory => "tuned local moves, theory start",
            Self::ChainsFromTheory => "event chains, theory start",
        }
    }

    /// A replica, at its start.
    pub(crate) fn engine(self, width: f64, seed: u64) -> Result<Box<dyn Engine>, Failure> {
        let slab = Slab::new(HEIGHT, width, width)?;
        let scene =
            Scene::new(slab, particles(width), UniformField::default(), Isothermal::new(TEMPERATURE)?)?;
        let local: Moves = LocalMoves::new(DISPLACEMENT, &slab)?.into();
        let tuned: Moves = LocalMoves::tuned().into();
        let chains: Moves = EventChains::default().into();
        match self {
            Self::Plain => {
                let start =
                    Simulation::builder(scene).start(RandomInsertion::default()).seed(seed).build()?;
                let positions = start.positions();
                Ok(Box::new(PlainColumn::new(HEIGHT, width, TEMPERATURE, DISPLACEMENT, &positions, seed)))
            }
            Self::LocalFromUniform => library(scene, RandomInsertion::default(), local, seed),
            Self::TunedFromUniform => library(scene, RandomInsertion::default(), tuned, seed),
            Self::ChainsFromUniform => library(scene, RandomInsertion::default(), chains, seed),
            Self::LocalFromTheory => library(scene, Theory, local, seed),
            Self::TunedFromTheory => library(scene, Theory, tuned, seed),
            Self::ChainsFromTheory => library(scene, Theory, chains, seed),
        }
    }
}

fn library<S: Start>(
    scene: Scene<UniformField, Isothermal>,
    start: S,
    moves: Moves,
    seed: u64,
) -> Result<Box<dyn Engine>, Failure> {
    Ok(Box::new(Simulation::builder(scene).start(start).moves(moves).seed(seed).build()?))
}

/// Something that moves spheres.
pub(crate) trait Engine: Send {
    fn sweep(&mut self, sweeps: u64) -> Result<(), Failure>;
    /// Calls `look` with the height of every sphere.
    fn heights(&self, look: &mut dyn FnMut(f64));
}

impl<F: Field + Send, T: TemperatureProfile + Send, D: Drive<F, T> + Send> Engine for Simulation<F, T, D> {
    fn sweep(&mut self, sweeps: u64) -> Result<(), Failure> {
        // What adapts does so at first, and is fixed then.
        let adapting = EQUILIBRATION.saturating_sub(self.frame().sweep()).min(sweeps);
        self.equilibrate(adapting, &mut ())?;
        if adapting < sweeps {
            self.run(sweeps - adapting, &mut ())?;
        }
        Ok(())
    }

    fn heights(&self, look: &mut dyn FnMut(f64)) {
        self.frame().heights().for_each(look);
    }
}

impl Engine for PlainColumn {
    fn sweep(&mut self, sweeps: u64) -> Result<(), Failure> {
        for _ in 0..sweeps {
            self.sweep();
        }
        Ok(())
    }

    fn heights(&self, look: &mut dyn FnMut(f64)) {
        self.positions().iter().for_each(|position| look(position[0]));
    }
}
