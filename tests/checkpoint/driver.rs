//! A program controlled by bytes: it builds a scene, a scheme, moves and observers, runs, evaluates
//! all results, is interrupted and continues. It must not panic or hang, and an interrupted run
//! must end with the same bits as an uninterrupted one. The fuzz target `api` supplies the bytes.

#![allow(clippy::unwrap_used)]

use gradient_mc::checkpoint::{Persist, Snapshot};
use gradient_mc::drive::{
    Automatic, AveragedThenFrozen, EquationOfStateClosure, Instantaneous, RunningAverage, Scheme,
    SelfConsistent,
};
use gradient_mc::equation_of_state::{IdealGas, ModifiedKolafa};
use gradient_mc::field::{ExponentialField, LinearField, UniformField};
use gradient_mc::moves::{EventChains, FieldEvent, LocalMoves, Moves};
use gradient_mc::observers::{
    BalancedDensityProfile, Bins, CenterOfMass, ChainPressureProfile, DensityProfile, DisplacementProfile,
    EquationOfStateFit, EquationOfStateProfile, HexaticOrder, NeighborAngles, PressureProfile,
    RadialDistribution, StructureProfile, WallPressure,
};
use gradient_mc::start::{ClosePacked, Positions, RandomInsertion, Start, Theory};
use gradient_mc::temperature::{ExponentialTemperature, Isothermal, LinearTemperature, TabulatedTemperature};
use gradient_mc::{
    Error, Every, Field, Scene, Simulation, SimulationBuilder, Slab, TemperatureProfile, Vector3,
};
use std::sync::Arc;

/// What the bytes choose, one after the other; zeros when there are no more.
struct Choices<'a>(&'a [u8]);

impl Choices<'_> {
    fn byte(&mut self) -> u8 {
        let Some((&byte, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        byte
    }

    fn below(&mut self, count: u8) -> u8 {
        self.byte() % count
    }

    /// Nearly always between two bounds, now and then a number that nobody should give.
    fn number(&mut self, low: f64, high: f64) -> f64 {
        const ODD: [f64; 8] = [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-300, 1e300, -0.0, 0.5];
        let (kind, place) = (self.byte(), f64::from(self.byte()) / 255.0);
        if kind >= 248 { ODD[usize::from(kind - 248)] } else { low + (high - low) * place }
    }
}

type AnyField = Arc<dyn Field>;
type AnyTemperature = Arc<dyn TemperatureProfile>;
type AnyScene = Scene<AnyField, AnyTemperature>;

fn scene(choices: &mut Choices<'_>) -> Result<AnyScene, Error> {
    let slab = Slab::new(choices.number(3.0, 30.0), choices.number(2.9, 5.0), choices.number(2.9, 5.0))?;
    let field: AnyField = match choices.below(4) {
        0 => Arc::new(UniformField::default()),
        1 => Arc::new(UniformField::new(choices.number(-2.0, 2.0))?),
        2 => Arc::new(ExponentialField::new(choices.number(-0.1, 0.1))?),
        _ => Arc::new(LinearField::new(choices.number(-1.0, 2.0), choices.number(-0.1, 0.1))?),
    };
    let temperature: AnyTemperature = match choices.below(5) {
        0 | 1 => Arc::new(Isothermal::new(choices.number(0.5, 8.0))?),
        2 => Arc::new(ExponentialTemperature::new(choices.number(1.0, 8.0), choices.number(-0.1, 0.2))?),
        3 => Arc::new(LinearTemperature::new(choices.number(2.0, 8.0), choices.number(-0.05, 0.1))?),
        _ => {
            let count = choices.below(5);
            let points = (0..count).map(|_| (choices.number(0.0, 30.0), choices.number(1.0, 8.0)));
            Arc::new(TabulatedTemperature::new(points.collect())?)
        }
    };
    Scene::new(slab, usize::from(choices.below(41)), field, temperature)
}

fn local_moves(choices: &mut Choices<'_>) -> Result<LocalMoves, Error> {
    match choices.below(3) {
        0 => LocalMoves::new(choices.number(0.01, 2.0)),
        1 => {
            let sizes: Vec<f64> = (0..choices.below(4)).map(|_| choices.number(0.01, 2.0)).collect();
            LocalMoves::mixture(&sizes)
        }
        _ => Ok(LocalMoves::tuned()),
    }
}

fn moves(choices: &mut Choices<'_>) -> Result<Option<Moves>, Error> {
    Ok(match choices.below(4) {
        0 => None,
        1 => Some(local_moves(choices)?.into()),
        _ => {
            let mut chains = match choices.below(2) {
                0 => EventChains::default(),
                _ => EventChains::with_length(choices.number(0.1, 10.0))?,
            };
            if choices.below(2) == 1 {
                chains = chains.field_event(FieldEvent::Reverse);
            }
            if choices.below(2) == 1 {
                chains = chains.vertical_fraction(choices.number(0.0, 1.0))?;
            }
            let local = match choices.below(3) {
                0 => chains,
                1 => chains.local_moves(None),
                _ => chains.local_moves(Some(local_moves(choices)?)),
            };
            Some(local.into())
        }
    })
}

fn start(choices: &mut Choices<'_>) -> Result<Box<dyn Start>, Error> {
    Ok(match choices.below(8) {
        0..=2 => Box::new(Theory),
        3 | 4 => Box::new(ClosePacked),
        5 | 6 => Box::new(RandomInsertion::new(choices.number(0.05, 0.6))?),
        _ => {
            let count = choices.below(6);
            let mut position = || {
                Vector3::new(choices.number(0.0, 30.0), choices.number(0.0, 5.0), choices.number(0.0, 5.0))
            };
            Box::new(Positions((0..count).map(|_| position()).collect()))
        }
    })
}

fn bins(choices: &mut Choices<'_>, slab: &Slab) -> Bins {
    let bins = match choices.below(2) {
        0 => Bins::count(usize::from(choices.byte() / 4)),
        _ => Bins::of_width(choices.number(0.1, 3.0)),
    };
    let height = slab.height();
    if choices.below(2) == 0 {
        bins
    } else {
        bins.from(height * choices.number(0.0, 0.4)).to(height * choices.number(0.4, 1.0))
    }
}

type Profiles = (
    Option<DensityProfile>,
    Option<PressureProfile>,
    Every<EquationOfStateProfile>,
    Option<ChainPressureProfile>,
    Option<BalancedDensityProfile>,
    Every<DisplacementProfile>,
);
type Structures = (
    Option<HexaticOrder>,
    Option<NeighborAngles>,
    Option<RadialDistribution>,
    Every<Option<StructureProfile>>,
    Option<EquationOfStateFit>,
    Option<WallPressure>,
);
type All = (CenterOfMass, Profiles, Structures);

fn observers(choices: &mut Choices<'_>, scene: &AnyScene) -> Result<All, Error> {
    let slab = scene.slab();
    let mut wanted = u16::from_le_bytes([choices.byte(), choices.byte()]);
    let mut want = || {
        wanted = wanted.rotate_right(1);
        wanted & 1 == 1
    };
    let profiles = (
        want().then(|| DensityProfile::new(slab, bins(choices, slab))).transpose()?,
        want().then(|| PressureProfile::new(slab, bins(choices, slab))).transpose()?,
        Every::new(u64::from(choices.below(4)) + 1, EquationOfStateProfile::new(slab, bins(choices, slab))?),
        want().then(|| ChainPressureProfile::new(slab, bins(choices, slab))).transpose()?,
        want().then(|| BalancedDensityProfile::new(slab, bins(choices, slab))).transpose()?,
        Every::new(u64::from(choices.below(4)) + 1, DisplacementProfile::new(slab, bins(choices, slab))?),
    );
    let [low, high] = [[0.0, 0.4], [0.4, 1.0]].map(|[low, high]| slab.height() * choices.number(low, high));
    let structures = (
        want().then(|| HexaticOrder::new(slab, low, high, choices.number(1.0, 2.0))).transpose()?,
        want().then(|| NeighborAngles::new(slab, low, high, usize::from(choices.below(64)))).transpose()?,
        want()
            .then(|| RadialDistribution::new(slab, low, high, usize::from(choices.below(64))))
            .transpose()?,
        Every::new(
            u64::from(choices.below(4)) + 1,
            want().then(|| StructureProfile::new(slab, bins(choices, slab))).transpose()?,
        ),
        want().then(|| EquationOfStateFit::new(scene)).transpose()?,
        want().then(|| WallPressure::new(scene)).transpose()?,
    );
    Ok((CenterOfMass::new(), profiles, structures))
}

/// Everything that can be asked of observers, as text.
fn answers((center, profiles, structures): &All) -> String {
    let (density, pressure, state, chain, balanced, displacement) = profiles;
    let (hexatic, angles, radial, structure, fit, wall) = structures;
    let center = (
        (center.estimate(), center.drift(), center.variance(), center.autocorrelation()),
        (center.equilibration(), center.equilibrated(), center.warnings()),
    );
    let profiles = (
        density.as_ref().map(|profile| (profile.points(), profile.layers(0.1), profile.warnings())),
        pressure.as_ref().map(|profile| (profile.points(), profile.warnings())),
        (state.observer.points(), state.observer.warnings(), state.observer.deviations_from(&ModifiedKolafa)),
        (
            chain.as_ref().map(ChainPressureProfile::points),
            balanced.as_ref().map(BalancedDensityProfile::points),
        ),
        displacement.observer.points(),
    );
    let structures = (
        hexatic.as_ref().map(|order| (order.local(), order.global())),
        angles.as_ref().map(|angles| (angles.points(), angles.neighbors_per_sphere())),
        radial.as_ref().map(|radial| (radial.points(), radial.lateral_density())),
        structure.observer.as_ref().map(|structure| (structure.points(), structure.front())),
        fit.as_ref().map(|fit| (fit.intervals(), fit.result().map(|measured| measured.warnings()))),
        wall.as_ref().map(|wall| (wall.at(gradient_mc::Wall::Base), wall.at(gradient_mc::Wall::Lid))),
    );
    format!("{center:?} {profiles:?} {structures:?}")
}

/// What is done to a run, in order.
#[derive(Clone, Copy)]
enum Step {
    Equilibrate(u64),
    Run(u64),
    Stop,
}

fn steps(choices: &mut Choices<'_>) -> Vec<Step> {
    let mut step = |_| match choices.below(4) {
        0 => Step::Equilibrate(u64::from(choices.below(24))),
        1 | 2 => Step::Run(u64::from(choices.below(24))),
        _ => Step::Stop,
    };
    (0..6).map(&mut step).collect()
}

/// Builds and runs whatever `bytes` say. What it returns is what came of it, in words.
pub fn drive(bytes: &[u8]) -> String {
    let mut choices = Choices(bytes);
    let outcome = scene(&mut choices).and_then(|scene| {
        let (start, moves) = (start(&mut choices)?, moves(&mut choices)?);
        let builder = Simulation::builder(scene.clone()).start(start).seed(u64::from(choices.byte()));
        let builder = match moves {
            Some(moves) => builder.moves(moves),
            None => builder,
        };
        match choices.below(9) {
            0..=2 => live(&scene, &builder.scheme(Automatic), &mut choices),
            3 => live(&scene, &builder.scheme(SelfConsistent::default()), &mut choices),
            4 => {
                let scheme = SelfConsistent::new(IdealGas).bin_width(choices.number(0.05, 1.0))?;
                live(&scene, &builder.scheme(scheme.closure_weight(choices.number(0.0, 1e5))?), &mut choices)
            }
            5 => live(&scene, &builder.scheme(EquationOfStateClosure::default()), &mut choices),
            6 => live(&scene, &builder.scheme(RunningAverage::new(choices.number(0.05, 1.0))?), &mut choices),
            7 => live(
                &scene,
                &builder.scheme(AveragedThenFrozen::new(choices.number(0.05, 1.0))?),
                &mut choices,
            ),
            _ => live(
                &scene,
                &builder.scheme(Instantaneous::new(choices.number(0.05, 1.0))?.any_moves()),
                &mut choices,
            ),
        }
    });
    match outcome {
        Ok(said) => said,
        Err(error) => {
            let said = error.to_string();
            assert!(!said.is_empty());
            said
        }
    }
}

fn live<S>(
    scene: &AnyScene,
    builder: &SimulationBuilder<AnyField, AnyTemperature, S>,
    choices: &mut Choices<'_>,
) -> Result<String, Error>
where
    S: Scheme<AnyField, AnyTemperature, Drive: Persist, Adaptation: Persist> + Clone,
{
    let seen = observers(choices, scene)?;
    let steps = steps(choices);
    let undisturbed = go(builder, &seen, &steps, false)?;
    assert!(undisturbed == go(builder, &seen, &steps, true)?, "what was stopped ends otherwise");
    Ok(undisturbed.1)
}

/// The snapshot at the end, and what can be asked then; `stops` says whether it stops where it is
/// told to.
fn go<S>(
    builder: &SimulationBuilder<AnyField, AnyTemperature, S>,
    fresh: &All,
    steps: &[Step],
    stops: bool,
) -> Result<(Vec<u8>, String), Error>
where
    S: Scheme<AnyField, AnyTemperature, Drive: Persist, Adaptation: Persist> + Clone,
{
    let mut seen = fresh.clone();
    let mut simulation = builder.clone().build()?;
    for &step in steps {
        match step {
            Step::Equilibrate(sweeps) => simulation.equilibrate(sweeps, &mut seen)?,
            Step::Run(sweeps) => simulation.run(sweeps, &mut seen)?,
            Step::Stop if stops => {
                let bytes = simulation.snapshot(&mut seen)?.to_bytes();
                seen = fresh.clone();
                simulation = builder.clone().resume(&Snapshot::from_bytes(&bytes).unwrap(), &mut seen)?;
                assert!(simulation.snapshot(&mut seen)?.to_bytes() == bytes);
            }
            Step::Stop => {}
        }
        let frame = simulation.frame();
        let slab = frame.slab();
        let inside = |height: f64| (slab.lowest_center()..=slab.highest_center()).contains(&height);
        assert!(frame.heights().all(inside) && frame.heights().count() == frame.particles());
    }
    let said = format!("{:?} {:?} {}", simulation.warnings(), simulation.certificate(0.05), answers(&seen));
    Ok((simulation.snapshot(&mut seen)?.to_bytes(), said))
}
