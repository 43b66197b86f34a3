//! Pressures on base and lid, in open columns and in closed boxes.

use gradient_mc::equation_of_state::ModifiedKolafa;
use gradient_mc::field::UniformField;
use gradient_mc::moves::{EventChains, LocalMoves, Moves};
use gradient_mc::observers::{Bins, EquationOfStateProfile, WallPressure};
use gradient_mc::statistics::Estimate;
use gradient_mc::temperature::{ExponentialTemperature, Isothermal};
use gradient_mc::{
    Error, Every, Merge, Observer, Scene, Simulation, Slab, TemperatureProfile, Wall, Warning,
};

type AtAnyTemperature = Scene<UniformField, Box<dyn TemperatureProfile>>;

/// In a slab of this height over 5 x 5, T = `temperature` exp(-decay x).
fn scene(height: f64, spheres: usize, acceleration: f64, temperature: f64, decay: f64) -> AtAnyTemperature {
    let profile: Box<dyn TemperatureProfile> = if decay == 0.0 {
        Box::new(Isothermal::new(temperature).unwrap())
    } else {
        Box::new(ExponentialTemperature::new(temperature, decay).unwrap())
    };
    let slab = Slab::new(height, 5.0, 5.0).unwrap();
    Scene::new(slab, spheres, UniformField::new(acceleration).unwrap(), profile).unwrap()
}

fn observed<O: Observer>(
    scene: &AtAnyTemperature,
    moves: Moves,
    seed: u64,
    sweeps: u64,
    mut observer: O,
) -> O {
    let mut simulation = Simulation::builder(scene_of(scene)).moves(moves).seed(seed).build().unwrap();
    simulation.equilibrate(200, &mut ()).unwrap();
    simulation.run(sweeps, &mut observer).unwrap();
    observer
}

/// The same, borrowed.
fn scene_of(scene: &AtAnyTemperature) -> Scene<UniformField, &dyn TemperatureProfile> {
    Scene::new(*scene.slab(), scene.particles(), *scene.field(), &**scene.temperature()).unwrap()
}

/// In the middle of a closed box the pressure of the walls, and the weight above, are those of the
/// equation of state.
#[test]
fn the_walls_of_a_closed_box_bear_the_pressure_of_the_fluid() {
    for (acceleration, decay) in [(0.0, 0.0), (0.2, 0.03)] {
        let scene = scene(20.0, 175, acceleration, 5.0, decay);
        let parts = (
            WallPressure::new(&scene).unwrap(),
            Every::new(4, EquationOfStateProfile::new(scene.slab(), Bins::of_width(0.5)).unwrap()),
        );
        let runs = (0..4).map(|seed| observed(&scene, Moves::default(), seed, 1500, parts.clone()));
        let runs: Vec<_> = runs.collect();
        let (walls, mut profile) = Merge::pooled(&runs).unwrap();
        assert_eq!(walls.observations(), 6000);
        let lid = walls.at(Wall::Lid).unwrap();
        assert!(lid.standard_error > 0.0 && lid.standard_error < 0.006 * lid.mean, "{lid}");
        profile.observer.set_open_end_pressure(lid).unwrap();
        let deviation = profile.observer.deviations_over(&[[7.0, 13.0]], &ModifiedKolafa).unwrap()[0];
        assert!(
            deviation.deviation_from(0.0).abs() < 4.0 && deviation.standard_error < 0.01,
            "{acceleration} {decay}: {deviation}"
        );
        // The other wall bears the weight too.
        let weight = acceleration * scene.column_density();
        approx::assert_relative_eq!(
            walls.at(Wall::Base).unwrap().mean,
            lid.mean + weight,
            max_relative = 1e-9
        );
    }
}

/// Two spheres in a box without weight, where centers have a height L over a base A. With Δ the
/// difference of their heights
///
/// Q(L) = A ∫∫ [A − π (1 − Δ²)₊] dx dx′ = A (A L² − 4π L/3 + π/2) from L = 1 on, and P = (T/A) d ln
/// Q/dL.
///
/// Collisions make 8.2 % of it: with collisions that are off by 3 % it is off by 0.25 %. Short
/// chains know it best.
#[test]
fn two_spheres_in_a_box_press_as_they_must() {
    const PI: f64 = std::f64::consts::PI;
    let (slab, temperature) = (Slab::new(3.0, 3.0, 3.0).unwrap(), Isothermal::new(2.0).unwrap());
    let scene = Scene::new(slab, 2, UniformField::new(0.0).unwrap(), temperature).unwrap();
    let (area, height) = (9.0, 2.0);
    let configurations = area * height * height - 4.0 * PI * height / 3.0 + PI / 2.0;
    let exact = 2.0 / area * (2.0 * area * height - 4.0 * PI / 3.0) / configurations;
    let ideal = 2.0 / area * 2.0 / height;
    let chains = EventChains::with_length(1.0).unwrap().path_per_sphere(8.0).unwrap();
    let chains = chains.vertical_fraction(0.5).unwrap().local_moves(None);
    let mut simulation = Simulation::builder(scene).moves(chains).seed(1).build().unwrap();
    let mut walls = WallPressure::new(&scene).unwrap();
    simulation.equilibrate(1000, &mut ()).unwrap();
    simulation.run(1_000_000, &mut walls).unwrap();
    for wall in [Wall::Lid, Wall::Base] {
        let pressure = walls.at(wall).unwrap();
        println!("{pressure}, exactly {exact:.5}, of an ideal gas {ideal:.5}");
        assert!(pressure.deviation_from(exact).abs() < 4.0, "{pressure} instead of {exact}");
        // Seven errors and more.
        assert!(0.03 * (exact - ideal) > 7.0 * pressure.standard_error, "{pressure}");
    }
}

/// Errors are those of the scatter of replicas, and local moves, which know less, agree.
#[test]
fn errors_of_the_pressure_are_honest() {
    const REPLICAS: u64 = 16;
    // A closed box, a column under a low lid, and one that hangs from it above a base that it hardly
    // touches.
    let scenes =
        [scene(10.0, 100, 0.0, 2.0, 0.0), scene(25.0, 100, 1.0, 6.0, 0.02), scene(25.0, 100, -1.0, 5.0, 0.0)];
    for scene in &scenes {
        let end = scene.open_end();
        let walls = WallPressure::new(scene).unwrap();
        let runs: Vec<WallPressure> =
            (0..REPLICAS).map(|seed| observed(scene, Moves::default(), seed, 600, walls.clone())).collect();
        let pressures: Vec<Estimate> = runs.iter().map(|run| run.at(end).unwrap()).collect();
        let mean = pressures.iter().map(|pressure| pressure.mean).sum::<f64>() / REPLICAS as f64;
        let squares = pressures.iter().map(|pressure| pressure.deviation_from(mean).powi(2)).sum::<f64>();
        let pull = (squares / (REPLICAS - 1) as f64).sqrt();
        // Of 16 replicas it is known to 18 %, four of which either side.
        assert!(pull > 0.28 && pull < 1.72, "{pull}");
        let pooled = WallPressure::pooled(&runs).unwrap().at(end).unwrap();
        let local = observed(scene, LocalMoves::tuned().into(), 1, 4000, walls).at(end).unwrap();
        assert!(local.deviation_from(pooled.mean).abs() < 4.0, "{pooled} {local}");
        assert!(local.standard_error > 4.0 * pooled.standard_error, "{pooled} {local}");
    }
}

/// Nobody is told to raise the lid of a box that is meant to be closed.
#[test]
fn a_closed_box_has_no_lid_that_is_too_low() {
    let message = |scene: &AtAnyTemperature| {
        let simulation = Simulation::builder(scene_of(scene)).build().unwrap();
        let lid =
            simulation.warnings().into_iter().find(|warning| matches!(warning, Warning::LidTooLow { .. }));
        lid.unwrap().to_string()
    };
    let closed = message(&scene(10.0, 100, 0.0, 2.0, 0.0));
    assert!(closed.contains("WallPressure") && !closed.contains("raise"), "{closed}");
    let low = message(&scene(25.0, 100, 1.0, 5.0, 0.0));
    assert!(low.contains("WallPressure") && low.contains("raise the lid"), "{low}");
}

#[test]
fn walls_that_were_not_seen_have_no_pressure() {
    let scene = scene(10.0, 100, 0.0, 2.0, 0.0);
    let walls = WallPressure::new(&scene).unwrap();
    assert!(matches!(walls.at(Wall::Lid), Err(Error::TooFewObservations { available: 0, .. })));
    let other = WallPressure::new(&self::scene(10.5, 100, 0.0, 2.0, 0.0)).unwrap();
    assert!(matches!(walls.clone().merge(&other), Err(Error::InvalidParameter { .. })));
}
