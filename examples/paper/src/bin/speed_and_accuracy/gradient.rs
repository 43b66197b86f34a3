//! The equation of state from one run of a column.

use gradient_mc::equation_of_state::{EquationOfState, ModifiedKolafa, number_density};
use gradient_mc::field::UniformField;
use gradient_mc::moves::{EventChains, LocalMoves};
use gradient_mc::observers::{Bins, EquationOfStateProfile};
use gradient_mc::start::RandomInsertion;
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Every, Hydrostatics, Scene, Simulation, Slab};
use paper::Failure;
use paper::clock::cpu_seconds;

/// Below it the fluid is layered.
const LOWEST: f64 = 8.0;
/// Packing fraction there, a little above what is wanted.
const DENSEST: f64 = 0.467;
/// Side of the base.
const WIDTH: f64 = 6.0;
/// Bins per diameter.
const RESOLUTION: f64 = 2.0;
/// Sweeps of the shortest run.
const SHORTEST: u64 = 64;

/// A column at one temperature, as heavy as it takes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Gradient {
    pub(crate) temperature: f64,
}

/// What a run yields, and what it takes.
#[derive(Debug, Clone)]
pub(crate) struct Yield {
    /// CPU seconds to equilibrate and to measure.
    pub(crate) seconds: [f64; 2],
    /// Of each bin: P/T and the packing fraction.
    states: Vec<[f64; 2]>,
}

fn reduced_pressure(eta: f64) -> f64 {
    number_density(eta) * ModifiedKolafa.compressibility_factor(eta)
}

impl Gradient {
    /// Spheres per area, such that the packing fraction above the layers is as wanted.
    pub(crate) fn column_density(self) -> f64 {
        self.temperature * reduced_pressure(DENSEST) + LOWEST * number_density(DENSEST)
    }

    fn scene(self) -> Result<Scene<UniformField, Isothermal>, Failure> {
        let (field, temperature) = (UniformField::default(), Isothermal::new(self.temperature)?);
        let theory =
            Hydrostatics::new(field, temperature, ModifiedKolafa).column_density(self.column_density())?;
        // Room for a start that is too high, and for all but nothing of the top.
        let slab = Slab::new((1.5 * theory.height_of_fraction(0.9999)).ceil(), WIDTH, WIDTH)?;
        Ok(Scene::with_column_density(slab, self.column_density(), field, temperature)?)
    }

    /// Number of spheres.
    pub(crate) fn particles(self) -> Result<usize, Failure> {
        Ok(self.scene()?.particles())
    }

    /// Runs of 64, 128 ... sweeps to equilibrate and as many measured, from a start that knows nothing.
    pub(crate) fn follow(self, seed: u64, patience: f64) -> Result<Vec<Yield>, Failure> {
        let begin = cpu_seconds();
        let scene = self.scene()?;
        let slab = *scene.slab();
        let moves = EventChains::default().local_moves(Some(LocalMoves::tuned()));
        let mut column =
            Simulation::builder(scene).start(RandomInsertion::new(0.4)).moves(moves).seed(seed).build()?;
        let mut equilibration = cpu_seconds() - begin;
        // Some hundreds.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let bins = ((slab.height() - LOWEST) * RESOLUTION).round() as usize;
        let (mut yields, mut sweeps, mut done) = (Vec::new(), SHORTEST, 0);
        loop {
            let start = cpu_seconds();
            column.equilibrate(sweeps - done, &mut ())?;
            done = sweeps;
            equilibration += cpu_seconds() - start;
            let mut production = column.clone();
            let start = cpu_seconds();
            let profile =
                EquationOfStateProfile::new(&slab, Bins::count(bins).from(LOWEST).to(slab.height()))?;
            let mut profile = Every::new((sweeps / 250).clamp(1, 5), profile);
            production.run(sweeps, &mut profile)?;
            let points = profile.observer.points()?;
            let measurement = cpu_seconds() - start;
            let states = points
                .iter()
                .map(|point| [point.pressure.mean / point.temperature, point.packing_fraction.mean])
                .collect();
            yields.push(Yield { seconds: [equilibration, measurement], states });
            if 2.0 * (equilibration + measurement) > patience {
                return Ok(yields);
            }
            sweeps *= 2;
        }
    }
}

impl Yield {
    /// Z over that of the modified Kolafa equation, less 1, at packing fractions that are `spacing` apart.
    ///
    /// The bins whose P/T, which is known far better than their n, lies half a spacing around are taken together. In them the
    /// sum of n is compared with that which the equation has at their P/T: linear in n, so that its noise makes no
    /// bias; and δZ/Z at a given density is −(1 + d ln Z/d ln η) times the relative deviation of n at a given P/T.
    pub(crate) fn deviations(&self, grid: &[f64], spacing: f64) -> Vec<f64> {
        let mut guess = None;
        grid.iter()
            .map(|&eta| {
                let [low, high] = [-0.5, 0.5].map(|part| reduced_pressure(eta + part * spacing));
                let (mut measured, mut expected) = (0.0, 0.0);
                for &[reduced, own] in &self.states {
                    if (low..high).contains(&reduced) {
                        let theory = ModifiedKolafa.packing_fraction_at(reduced, guess);
                        guess = theory;
                        measured += own;
                        expected += theory.unwrap_or(f64::NAN);
                    }
                }
                let stiffness = 1.0
                    + ModifiedKolafa.compressibility_derivative(eta)
                        / ModifiedKolafa.compressibility_factor(eta);
                -stiffness * (measured / expected - 1.0)
            })
            .collect()
    }

    /// The largest packing fraction that a bin has.
    pub(crate) fn densest(&self) -> f64 {
        self.states.iter().map(|state| state[1]).fold(0.0, f64::max)
    }
}
