//! gradient-mc, through its public interface; nothing else here names it.

use crate::Failure;
use crate::contest::{Count, Engine};
use crate::state::State;
use gradient_mc::field::UniformField;
use gradient_mc::start::Positions;
use gradient_mc::temperature::Isothermal;
use gradient_mc::{MoveCounts, Scene, Simulation, Slab, Vector3};

/// A simulation by local moves.
#[derive(Debug)]
pub(crate) struct Library {
    simulation: Simulation<UniformField, Isothermal>,
}

fn scene(state: &State) -> Result<Scene<UniformField, Isothermal>, Failure> {
    let [height, width_y, width_z] = state.size;
    let slab = Slab::new(height, width_y, width_z)?;
    let (field, temperature) = (UniformField::new(state.gravity)?, Isothermal::new(state.temperature)?);
    Ok(Scene::new(slab, state.particles, field, temperature)?)
}

/// Positions that every engine starts from: equilibrated, and in the order of a grid, which is the order
/// in which hoomd-mc then sweeps.
pub(crate) fn prepare(state: &State, sweeps: u64) -> Result<Vec<[f64; 3]>, Failure> {
    let mut simulation = Simulation::builder(scene(state)?)
        .maximum_displacement(state.maximum_displacement)
        .seed(1)
        .build()?;
    simulation.equilibrate(sweeps, &mut ())?;
    let mut positions: Vec<[f64; 3]> = simulation.positions().into_iter().map(Into::into).collect();
    positions.sort_by(|a, b| {
        let cell = |position: &[f64; 3]| position.map(f64::floor);
        cell(a).partial_cmp(&cell(b)).unwrap_or(std::cmp::Ordering::Equal)
    });
    Ok(positions)
}

impl Library {
    pub(crate) fn new(state: &State, positions: &[[f64; 3]]) -> Result<Self, Failure> {
        let positions = positions.iter().map(|&position| Vector3::from(position)).collect();
        let simulation = Simulation::builder(scene(state)?)
            .start(Positions(positions))
            .maximum_displacement(state.maximum_displacement)
            .seed(2)
            .build()?;
        Ok(Self { simulation })
    }
}

impl Engine for Library {
    fn label(&self) -> String {
        "gradient-mc, local moves".into()
    }

    fn run(&mut self, sweeps: u64) -> Result<Count, Failure> {
        let before = *self.simulation.move_counts();
        self.simulation.run(sweeps, &mut ())?;
        let MoveCounts { trials, accepted, left_domain, .. } = self.simulation.move_counts().since(&before);
        Ok(Count { trials, accepted, left_domain })
    }
}
