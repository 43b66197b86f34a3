//! Error bars of short runs are correct: a small version of the study `error_bars`.

use gradient_mc::equation_of_state::{EquationOfState, ModifiedKolafa};
use gradient_mc::field::UniformField;
use gradient_mc::moves::{EventChains, LocalMoves, Moves};
use gradient_mc::observers::{Bins, CenterOfMass, EquationOfStateFit, EquationOfStateProfile};
use gradient_mc::start::Positions;
use gradient_mc::statistics::Estimate;
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Every, Scene, Simulation, Slab, WarningKind};

const REPLICAS: u64 = 64;
const QUANTITIES: usize = 7;

/// Results of a run of so many sweeps that starts in equilibrium, and whether it is warned of.
fn run(moves: Moves, sweeps: u64, seed: u64) -> ([Estimate; QUANTITIES], bool) {
    let slab = Slab::new(60.0, 3.0, 3.0).unwrap();
    let scene = Scene::new(slab, 90, UniformField::default(), Isothermal::new(5.0).unwrap()).unwrap();
    let mut relaxed = Simulation::builder(scene).seed(seed).build().unwrap();
    relaxed.equilibrate(600, &mut ()).unwrap();
    let builder = Simulation::builder(scene).start(Positions(relaxed.positions()));
    let mut simulation = builder.moves(moves).seed(!seed).build().unwrap();
    simulation.equilibrate(50, &mut ()).unwrap();
    let profile = EquationOfStateProfile::new(&slab, Bins::of_width(0.25).from(0.5).to(16.0)).unwrap();
    let mut observers = Every::new(2, (CenterOfMass::new(), profile));
    simulation.run(sweeps, &mut observers).unwrap();
    let (center, profile) = &observers.observer;
    let points = profile.points().unwrap();
    let at = |height: f64| points.iter().find(|point| (point.height - height).abs() < 0.01).unwrap();
    let results = [
        center.estimate().unwrap(),
        at(0.625).number_density,
        at(8.125).number_density,
        at(0.625).pressure,
        at(8.125).pressure,
        at(8.125).compressibility_factor,
        at(15.125).compressibility_factor,
    ];
    let mut warnings = simulation.warnings();
    warnings.extend(profile.warnings());
    let about_sampling = [
        WarningKind::TooShort,
        WarningKind::NotMixed,
        WarningKind::NothingMoved,
        WarningKind::CorrelatedBins,
        WarningKind::FarFromTheory,
    ];
    (results, warnings.iter().any(|warning| about_sampling.contains(&warning.kind())))
}

/// Mean squares of (value − mean of all)/error, and the share of runs that are warned of.
fn calibration(moves: &Moves, sweeps: u64) -> ([f64; QUANTITIES], f64) {
    let runs: Vec<_> = (0..REPLICAS).map(|seed| run(*moves, sweeps, 7000 + seed)).collect();
    let replicas = REPLICAS as f64;
    let squares = std::array::from_fn(|index| {
        let mean = runs.iter().map(|(results, _)| results[index].mean).sum::<f64>() / replicas;
        let pulls = runs.iter().map(|(results, _)| results[index].deviation_from(mean));
        let squares = pulls.map(|pull| pull * pull);
        squares.sum::<f64>() / (replicas - 1.0)
    });
    (squares, runs.iter().filter(|(_, warned)| *warned).count() as f64 / replicas)
}

/// Σ (value − mean)²/σ² of R runs has a χ² distribution with R − 1 degrees of freedom, whose mean
/// over R − 1 scatters by √(2/(R − 1)) = 0.18 about 1. Claimed errors scatter too, by some 25 %: by
/// as much as if there were half as many runs. So the mean square of one quantity lies within 1 ± 4
/// × 0.25, and of all seven, which count as three, within 1 ± 4 × 0.15. Without the memory in the
/// errors (an inefficiency of 1) the mean squares are above 4.
#[test]
fn deviations_of_short_runs_are_as_large_as_their_errors() {
    for (moves, sweeps) in [
        (Moves::from(EventChains::default().local_moves(Some(LocalMoves::tuned()))), 600),
        (LocalMoves::tuned().into(), 3000),
    ] {
        let (squares, warned) = calibration(&moves, sweeps);
        let mean = squares.iter().sum::<f64>() / squares.len() as f64;
        println!("{squares:.2?}, mean {mean:.2}, warned of {warned:.2}");
        assert!(squares.iter().all(|square| (0.25..2.0).contains(square)), "{squares:?}");
        assert!((0.4..1.6).contains(&mean), "{squares:?}");
        // One in ten, and four times what 64 scatter by.
        assert!(warned <= 0.1 + 4.0 * (0.09 / REPLICAS as f64).sqrt(), "warned of {warned}");
    }
}

/// Small moves leave a run where it started: errors are far too small, and it is told.
#[test]
fn runs_with_dishonest_errors_are_warned_of() {
    let (squares, warned) = calibration(&LocalMoves::new(0.1).unwrap().into(), 400);
    assert!(squares[0] > 10.0, "{squares:?}");
    assert!(warned > 0.95, "warned of {warned}");
}

/// Z by ranks, by collisions and by both, from runs of some seconds in all: mean squares of (Z −
/// that of the modified Kolafa-Labík-Malijevský equation)/error. The bounds are those of
/// `deviations_of_short_runs_are_as_large_as_their_errors`, with 24 runs at two packing fractions
/// that count as one and a half: 4 √(2 · 2/36) = 1.3 about 1. Blocks taken for independent have
/// mean squares of 3 and more for ranks.
#[test]
fn equations_of_state_are_as_far_off_as_they_say() {
    const RUNS: u64 = 24;
    let etas = [0.1, 0.2];
    let slab = Slab::new(60.0, 4.0, 4.0).unwrap();
    let scene = Scene::new(slab, 256, UniformField::default(), Isothermal::new(6.0).unwrap()).unwrap();
    let mut squares = [0.0; 3];
    for seed in 0..RUNS {
        let mut simulation = Simulation::builder(scene).seed(100 + seed).build().unwrap();
        simulation.equilibrate(500, &mut ()).unwrap();
        let mut fit = EquationOfStateFit::new(&scene).unwrap();
        simulation.run(3000, &mut fit).unwrap();
        let measured = fit.result().unwrap();
        let curves = [measured.ranks(), measured.collisions(), measured.combined()];
        for (square, curve) in squares.iter_mut().zip(curves) {
            for (factor, eta) in curve.compressibility_factor_at(&etas).unwrap().iter().zip(etas) {
                let pull = factor.deviation_from(ModifiedKolafa.compressibility_factor(eta));
                *square += pull * pull / (RUNS as f64 * etas.len() as f64);
            }
        }
    }
    println!("ranks, collisions, both: {squares:.2?}");
    assert!(squares.iter().all(|square| (0.2..2.3).contains(square)), "{squares:?}");
}
