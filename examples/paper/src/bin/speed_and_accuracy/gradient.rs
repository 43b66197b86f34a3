//! The equation of state from one run of a column.

use crate::contest::{self, Curve};
use gradient_mc::equation_of_state::{
    CarnahanStarling, EquationOfState, ModifiedKolafa, PercusYevickVirial, number_density,
};
use gradient_mc::field::{DesignedField, UniformField};
use gradient_mc::moves::EventChains;
use gradient_mc::observers::EquationOfStateFit;
use gradient_mc::start::{RandomInsertion, Start, Theory};
use gradient_mc::temperature::Isothermal;
use gradient_mc::{AnyScene, Error, Field, Generator, Hydrostatics, Scene, Simulation, Slab, Vector3};
use paper::Failure;
use paper::clock::cpu_seconds;

/// Packing fractions at base and lid of the designed column: a little more than is asked for, and
/// than the layers at the base hide.
const ENDS: [f64; 2] = [0.485, 0.03];
/// Height of the designed column.
const HEIGHT: f64 = 100.0;
/// Side of the base.
const WIDTH: f64 = 6.0;
/// Part of the path of all chains that is vertical.
const VERTICAL: f64 = 0.5;
/// Sweeps of the shortest run.
const SHORTEST: u64 = 64;
/// Of the uniform field; and its packing fraction above the layers, at so many diameters.
const TEMPERATURE: f64 = 10.0;
const DENSEST: f64 = 0.467;
const LAYERS: f64 = 8.0;

/// A column, and where its spheres are at first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Column {
    /// In a field designed for a packing fraction that falls linearly.
    Designed,
    /// The same, from the profile that the Percus-Yevick equation (virial) has in its field: wrong
    /// by up to 15 % in Z.
    WrongStart,
    /// The same, from spheres at random places.
    RandomStart,
    /// In a uniform field, as heavy as it takes.
    Uniform,
}

impl Column {
    pub(crate) const ALL: [Self; 4] = [Self::Designed, Self::WrongStart, Self::RandomStart, Self::Uniform];

    pub(crate) fn label(self) -> String {
        match self {
            Self::Designed => "designed field".to_owned(),
            Self::WrongStart => "designed field, Percus-Yevick start".to_owned(),
            Self::RandomStart => "designed field, random start".to_owned(),
            Self::Uniform => format!("uniform field, T = {TEMPERATURE}"),
        }
    }
}

/// The route by which a run gives the equation of state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Route {
    Collisions,
    Ranks,
    Both,
}

impl Route {
    pub(crate) const ALL: [Self; 3] = [Self::Collisions, Self::Ranks, Self::Both];

    pub(crate) fn label(self) -> &'static str {
        match self {
            Self::Collisions => "collisions",
            Self::Ranks => "ranks",
            Self::Both => "both",
        }
    }
}

/// The result of a run and its CPU time.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
pub(crate) struct Yield {
    /// CPU seconds to equilibrate and to measure.
    pub(crate) seconds: [f64; 2],
    /// By each route of [`Route::ALL`]; a short run has the first alone.
    curves: Vec<Curve>,
}

impl Yield {
    pub(crate) fn curve(&self, route: Route) -> Option<&Curve> {
        self.curves.get(Route::ALL.iter().position(|&own| own == route)?)
    }
}

impl Column {
    /// Runs of 64, 128 ... measured sweeps after a quarter as many, and the number of spheres.
    pub(crate) fn follow(self, seed: u64, patience: f64) -> Result<(usize, Vec<Yield>), Failure> {
        let begin = cpu_seconds();
        if self == Self::Uniform {
            let temperature = Isothermal::new(TEMPERATURE)?;
            let pressure = number_density(DENSEST) * ModifiedKolafa.compressibility_factor(DENSEST);
            let column_density = TEMPERATURE * pressure + LAYERS * number_density(DENSEST);
            let field = UniformField::default();
            let theory =
                Hydrostatics::new(field, temperature, ModifiedKolafa).column_density(column_density)?;
            let slab = Slab::new((1.5 * theory.height_of_fraction(0.9999)).ceil(), WIDTH, WIDTH)?;
            let scene = Scene::with_column_density(slab, column_density, field, temperature)?;
            return follow(scene, Theory, begin, seed, patience);
        }
        let temperature = Isothermal::new(1.0)?;
        let slab = Slab::new(HEIGHT, WIDTH, WIDTH)?;
        let field = DesignedField::linear(ENDS, temperature, CarnahanStarling, &slab)?;
        let scene = Scene::with_column_density(slab, field.column_density(), &field, temperature)?;
        match self {
            Self::Designed | Self::Uniform => follow(scene, Theory, begin, seed, patience),
            Self::WrongStart => follow(scene, PercusYevick, begin, seed, patience),
            Self::RandomStart => follow(scene, RandomInsertion::new(0.4)?, begin, seed, patience),
        }
    }
}

fn follow<F: Field + Clone>(
    scene: Scene<F, Isothermal>,
    start: impl Start + 'static,
    begin: f64,
    seed: u64,
    patience: f64,
) -> Result<(usize, Vec<Yield>), Failure> {
    let moves = EventChains::default().vertical_fraction(VERTICAL)?.local_moves(None);
    let mut column = Simulation::builder(scene).start(start).moves(moves).seed(seed).build()?;
    let mut equilibration = cpu_seconds() - begin;
    let (mut yields, mut sweeps, mut done) = (Vec::new(), SHORTEST, 0);
    loop {
        let start = cpu_seconds();
        column.equilibrate(contest::equilibration(sweeps) - done, &mut ())?;
        done = contest::equilibration(sweeps);
        equilibration += cpu_seconds() - start;
        let mut production = column.clone();
        let start = cpu_seconds();
        let mut fit = EquationOfStateFit::new(production.scene())?;
        production.run(sweeps, &mut fit)?;
        let curves = match fit.result() {
            Ok(measured) => {
                [measured.collisions(), measured.ranks(), measured.combined()].map(Curve::of).to_vec()
            }
            Err(Error::TooFewObservations { .. }) => vec![Curve::of(fit.collisions_without_errors()?)],
            Err(error) => return Err(error.into()),
        };
        let measurement = cpu_seconds() - start;
        yields.push(Yield { seconds: [equilibration, measurement], curves });
        if 2.0 * (equilibration + measurement) > patience {
            return Ok((production.scene().particles(), yields));
        }
        sweeps *= 2;
    }
}

/// The hydrostatic profile of the Percus-Yevick equation (virial).
struct PercusYevick;

impl Start for PercusYevick {
    fn place(&self, scene: &AnyScene<'_>, generator: &mut Generator) -> Result<Vec<Vector3<f64>>, Error> {
        let slab = *scene.slab();
        let profile = scene.hydrostatics(&PercusYevickVirial)?;
        // The field in which the equation of the usual start has this profile.
        let wrong = |height: f64| profile.packing_fraction(height.clamp(1.0, slab.height() - 1.0));
        let temperature = Isothermal::new(1.0)?;
        let field = DesignedField::new(wrong, temperature, ModifiedKolafa, &slab)?;
        let scene = Scene::new(slab, scene.particles(), field, temperature)?;
        Theory.place(&scene.as_any(), generator)
    }
}
