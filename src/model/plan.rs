//! A planned Monte Carlo run.

use super::accuracy::bins;
use crate::frame::Frame;
use crate::moves::{EventChains, LocalMoves, Moves};
use crate::observer::{Observer, ObserverError};
use crate::{Error, Field, Scene, Simulation, Slab, TemperatureProfile, Wall};
use std::fmt;

/// The moves of a [`MonteCarloPlan`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum MoveFamily {
    /// [`LocalMoves::tuned`], for a dilute base.
    TunedLocal,
    /// [`EventChains`] with tuned local moves in between, for a dense base.
    Chains,
}

impl MoveFamily {
    /// Both families.
    pub const ALL: [Self; 2] = [Self::TunedLocal, Self::Chains];

    /// The moves for [`SimulationBuilder::moves`](crate::SimulationBuilder::moves).
    #[must_use]
    pub fn moves(self) -> Moves {
        match self {
            Self::TunedLocal => LocalMoves::tuned().into(),
            Self::Chains => EventChains::default().local_moves(Some(LocalMoves::tuned())).into(),
        }
    }
}

impl fmt::Display for MoveFamily {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::TunedLocal => "tuned local moves",
            Self::Chains => "event chains with tuned local moves",
        })
    }
}

/// A box with the N/A of a scene, a family of moves, and numbers of sweeps.
///
/// ```
/// use gradient_mc::model::{MonteCarloPlan, MoveFamily};
/// use gradient_mc::{Scene, Slab, field::UniformField, observers::CenterOfMass, temperature::Isothermal};
/// let scene = Scene::new(Slab::new(40.0, 25.0, 25.0)?, 625, UniformField::default(), Isothermal::new(3.0)?)?;
/// let plan = MonteCarloPlan::new(&scene, 100, MoveFamily::TunedLocal, 400)?;
/// let mut simulation = plan.simulation(&scene, 1)?;
/// simulation.equilibrate(plan.equilibration_sweeps(), &mut ())?;
/// let mut center_of_mass = CenterOfMass::new();
/// simulation.run(plan.production_sweeps(), &mut center_of_mass)?;
/// println!("{plan}: {}", center_of_mass.estimate()?);
/// assert_eq!(plan.family(), MoveFamily::TunedLocal);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MonteCarloPlan {
    slab: Slab,
    particles: usize,
    family: MoveFamily,
    sweeps: u64,
}

impl MonteCarloPlan {
    /// Share of the sweeps for equilibration.
    pub const EQUILIBRATION: f64 = 0.25;

    /// A plan for `scene` with `particles` spheres over a square base of the same N/A, in `sweeps`
    /// sweeps in total.
    ///
    /// # Errors
    /// [`Error::SlabTooSmall`] or [`Error::InvalidParameter`] for a base that is not possible.
    pub fn new<F: Field, T: TemperatureProfile>(
        scene: &Scene<F, T>,
        particles: usize,
        family: MoveFamily,
        sweeps: u64,
    ) -> Result<Self, Error> {
        let side = (particles as f64 / scene.column_density()).sqrt();
        let slab = Slab::new(scene.slab().height(), side, side)?;
        Ok(Self { slab, particles, family, sweeps: sweeps.max(2) })
    }

    /// The box: a square base, the height of the scene.
    #[must_use]
    pub fn slab(&self) -> &Slab {
        &self.slab
    }

    /// Number of spheres.
    #[must_use]
    pub fn particles(&self) -> usize {
        self.particles
    }

    /// The family of moves.
    #[must_use]
    pub fn family(&self) -> MoveFamily {
        self.family
    }

    /// Sweeps in total.
    #[must_use]
    pub fn sweeps(&self) -> u64 {
        self.sweeps
    }

    /// Sweeps before the measurement: a [quarter](Self::EQUILIBRATION) of all.
    #[must_use]
    pub fn equilibration_sweeps(&self) -> u64 {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let sweeps = (Self::EQUILIBRATION * self.sweeps as f64).round() as u64;
        sweeps.max(1)
    }

    /// Sweeps of the measurement.
    #[must_use]
    pub fn production_sweeps(&self) -> u64 {
        self.sweeps - self.equilibration_sweeps()
    }

    /// The same box and moves with another number of sweeps.
    #[must_use]
    pub fn with_sweeps(self, sweeps: u64) -> Self {
        Self { sweeps: sweeps.max(2), ..self }
    }

    /// The simulation of `scene` in the box of this plan, at the theory profile; it borrows field
    /// and temperature.
    ///
    /// # Errors
    /// What [`Scene::new`] and [`SimulationBuilder::build`](crate::SimulationBuilder::build)
    /// return.
    pub fn simulation<'a, F: Field, T: TemperatureProfile>(
        &self,
        scene: &'a Scene<F, T>,
        seed: u64,
    ) -> Result<Simulation<&'a F, &'a T>, Error> {
        let planned = Scene::new(self.slab, self.particles, scene.field(), scene.temperature())?;
        Simulation::builder(planned).moves(self.family.moves()).seed(seed).build()
    }

    /// Runs the plan. Returns number densities in bins one diameter high, as
    /// [`densities`](super::densities).
    ///
    /// # Errors
    /// As [`simulation`](Self::simulation) and [`Simulation::run`].
    pub fn densities<F: Field, T: TemperatureProfile>(
        &self,
        scene: &Scene<F, T>,
        seed: u64,
    ) -> Result<Vec<f64>, Error> {
        let mut simulation = self.simulation(scene, seed)?;
        simulation.equilibrate(self.equilibration_sweeps(), &mut ())?;
        let mut heights = Heights::new(scene, &self.slab);
        simulation.run(self.production_sweeps(), &mut heights)?;
        Ok(heights.densities(&self.slab))
    }
}

impl fmt::Display for MonteCarloPlan {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            formatter,
            "{} spheres over {:.2} x {:.2}, {}, {} sweeps to equilibrate and {} to measure",
            self.particles,
            self.slab.widths()[0],
            self.slab.widths()[1],
            self.family,
            self.equilibration_sweeps(),
            self.production_sweeps()
        )
    }
}

/// Counts spheres in bins one diameter high from the wall on which the column rests. It needs no
/// error bars, so it works for a few sweeps.
#[derive(Debug, Clone)]
struct Heights {
    open_end: Wall,
    counts: Vec<u64>,
    frames: u64,
}

impl Heights {
    fn new<F: Field, T: TemperatureProfile>(scene: &Scene<F, T>, slab: &Slab) -> Self {
        Self { open_end: scene.open_end(), counts: vec![0; bins(slab)], frames: 0 }
    }

    fn densities(&self, slab: &Slab) -> Vec<f64> {
        let scale = 1.0 / (self.frames as f64 * slab.base_area());
        self.counts.iter().map(|&count| count as f64 * scale).collect()
    }
}

impl Observer for Heights {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.frames += 1;
        for height in frame.heights() {
            let distance = match self.open_end {
                Wall::Lid => height,
                Wall::Base => frame.slab().height() - height,
            };
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let bin = (distance as usize).min(self.counts.len() - 1);
            self.counts[bin] += 1;
        }
        Ok(())
    }
}
