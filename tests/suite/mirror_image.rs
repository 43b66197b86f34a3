//! A scene with a field that pulls up is the mirror image of one with a field that pulls down.

use gradient_mc::drive::{Adaptation, Drive, EquationOfStateClosure, Instantaneous, Scheme};
use gradient_mc::equation_of_state::FluidSolid;
use gradient_mc::field::UniformField;
use gradient_mc::model::{Accuracy, Quantity};
use gradient_mc::observers::{Bins, DensityProfile, EquationOfStateProfile, PressureProfile};
use gradient_mc::start::{Positions, Start, Theory};
use gradient_mc::temperature::ExponentialTemperature;
use gradient_mc::{Observer, Scene, Simulation, Slab, Vector3, Wall};

const HEIGHT: f64 = 20.0;

type Column = Scene<UniformField, ExponentialTemperature>;

/// A column under the lid, and its mirror image on the base.
fn both(decay_rate: f64) -> [Column; 2] {
    let slab = Slab::new(HEIGHT, 5.0, 5.0).unwrap();
    let scene = |acceleration: f64, base: f64, rate: f64| {
        let temperature = ExponentialTemperature::new(base, rate).unwrap();
        Scene::new(slab, 20, UniformField::new(acceleration).unwrap(), temperature).unwrap()
    };
    let at_lid = 3.0 * libm::exp(-decay_rate * HEIGHT);
    [scene(-1.0, 3.0, decay_rate), scene(1.0, at_lid, -decay_rate)]
}

fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-8 * expected.abs().max(1e-3), "{found} instead of {expected}");
}

/// Heights of centers, and those of the mirror image.
fn heights() -> impl Iterator<Item = [f64; 2]> {
    (0..=190).map(|step| 0.5 + 0.1 * f64::from(step)).map(|height| [height, HEIGHT - height])
}

#[test]
fn theory_and_closure() {
    let [hanging, standing] = both(0.05);
    assert_eq!([hanging.open_end(), standing.open_end()], [Wall::Base, Wall::Lid]);
    let theory = [hanging, standing].map(|scene| scene.hydrostatics(&FluidSolid::default()).unwrap());
    close(theory[0].base_pressure(), theory[1].lid_pressure());
    close(theory[0].lid_pressure(), theory[1].base_pressure());
    close(theory[0].center_of_mass(), HEIGHT - theory[1].center_of_mass());
    let kinds = theory
        .each_ref()
        .map(|theory| theory.warnings().iter().map(gradient_mc::Warning::kind).collect::<Vec<_>>());
    assert_eq!(kinds[0], kinds[1]);
    let drives = [hanging, standing].map(|scene| EquationOfStateClosure::default().drive(&scene).unwrap().0);
    for [height, mirrored] in heights() {
        close(theory[0].number_density(height), theory[1].number_density(mirrored));
        close(theory[0].pressure(height), theory[1].pressure(mirrored));
        close(theory[0].column_below(height), theory[1].column_above(mirrored));
        // Between edges of bins, where the force is continuous.
        let (height, mirrored) = (height.min(19.4) + 0.05, (HEIGHT - height.min(19.4)) - 0.05);
        let forces =
            [drives[0].reduced_force(&hanging, height), drives[1].reduced_force(&standing, mirrored)];
        close(forces[0], -forces[1]);
    }
}

#[test]
fn what_one_configuration_says() {
    let scenes = both(0.05);
    let mut generator = <gradient_mc::Generator as rand::SeedableRng>::seed_from_u64(4);
    let placed = Theory.place(&scenes[0].as_any(), &mut generator).unwrap();
    let mirrored: Vec<Vector3<f64>> =
        placed.iter().map(|center| Vector3::new(HEIGHT - center.x, center.y, center.z)).collect();
    let [hanging, standing] = [(scenes[0], placed), (scenes[1], mirrored)].map(|(scene, centers)| {
        let simulation = Simulation::builder(scene).start(Positions(centers)).build().unwrap();
        let frame = simulation.frame();
        let mut pressure = PressureProfile::new(scene.slab(), Bins::count(40)).unwrap();
        pressure.observe(&frame).unwrap();
        let (mut potential, mut adaptation) = Instantaneous::new(0.5).unwrap().drive(&scene).unwrap();
        adaptation.observe(&frame).unwrap();
        adaptation.adapt(&mut potential, &scene.as_any()).unwrap();
        let forces: Vec<f64> =
            potential.heights().map(|height| potential.reduced_force(&scene, height)).collect();
        (pressure.means(), forces)
    });
    for (found, expected) in hanging.0.iter().zip(standing.0.iter().rev()) {
        close(*found, *expected);
    }
    assert!(hanging.0.iter().all(|&pressure| pressure >= 0.0) && hanging.0[39] > 0.79, "{:?}", hanging.0);
    for (found, expected) in hanging.1.iter().zip(standing.1.iter().rev()) {
        close(-found, *expected);
    }
}

#[test]
fn verdicts_and_profiles_of_runs() {
    for decay_rate in [0.0, 0.05] {
        let [hanging, standing] = both(decay_rate).map(|scene| {
            let mut simulation = Simulation::builder(scene).seed(6).build().unwrap();
            simulation.equilibrate(20_000, &mut ()).unwrap();
            let bins = || Bins::count(19).from(0.5).to(19.5);
            let slab = scene.slab();
            let mut profiles = (
                DensityProfile::new(slab, bins()).unwrap(),
                PressureProfile::new(slab, bins()).unwrap(),
                EquationOfStateProfile::new(slab, bins()).unwrap(),
            );
            simulation.run(60_000, &mut profiles).unwrap();
            let certificate = simulation.certificate(0.04).unwrap();
            assert!(certificate.is_converged(), "{certificate}");
            let density = profiles.0.points().unwrap().into_iter().map(|point| point.number_density);
            let pressure = profiles.1.points().unwrap().into_iter().map(|point| point.pressure);
            let factors = profiles
                .2
                .jackknife(|states| {
                    states.iter().map(|state| state.pressure / state.number_density).collect::<Vec<f64>>()
                })
                .unwrap();
            density.zip(pressure).zip(factors).collect::<Vec<_>>()
        });
        let pairs = hanging.iter().zip(standing.iter().rev());
        let mut compared = 0;
        for ((hanging, factor), (standing, other_factor)) in pairs {
            for (found, expected) in
                [(hanging.0, standing.0), (hanging.1, standing.1), (*factor, *other_factor)]
            {
                let error = found.standard_error.hypot(expected.standard_error);
                if error < 0.1 * expected.mean {
                    assert!((found.mean - expected.mean).abs() < 4.0 * error, "{found}, mirrored {expected}");
                    compared += 1;
                }
            }
        }
        assert!(compared > 30, "{compared}");
    }
}

/// A column of `spheres` over 5 x 5 under a lid at `height`, with `temperature` there, which varies
/// at the rate `decay_rate`, and its mirror image.
fn pair(height: f64, spheres: usize, temperature: f64, decay_rate: f64) -> [Column; 2] {
    let slab = Slab::new(height, 5.0, 5.0).unwrap();
    let scene = |acceleration: f64, base: f64, rate: f64| {
        let profile = ExponentialTemperature::new(base, rate).unwrap();
        Scene::new(slab, spheres, UniformField::new(acceleration).unwrap(), profile).unwrap()
    };
    let at_base = temperature * libm::exp(-decay_rate * height);
    [scene(-1.0, at_base, -decay_rate), scene(1.0, temperature, decay_rate)]
}

#[test]
fn models_for_a_scene() {
    // Dilute and dense, in a slab of whole diameters and not, with T that varies, under a lid that is
    // too low, and one that freezes.
    let scenes = [
        (20.0, 20, 1.5, 0.0),
        (20.3, 75, 1.5, 0.0),
        (30.6, 50, 2.0, 0.03),
        (12.0, 50, 4.0, 0.0),
        (30.0, 500, 0.5, 0.0),
    ];
    for (height, spheres, temperature, decay_rate) in scenes {
        let scenes = pair(height, spheres, temperature, decay_rate);
        for quantity in Quantity::ALL {
            for (tolerance, near) in [(0.2, None), (0.01, None), (0.05, Some([1.0, 4.0]))] {
                let accuracy = Accuracy::new(quantity, tolerance).unwrap();
                let of = |[low, high]: [f64; 2]| accuracy.between(low, high).unwrap();
                let mirrored = |[low, high]: [f64; 2]| [height - high, height - low];
                let [down, up] = [near.map(mirrored), near].map(|range| range.map_or(accuracy, of));
                let case = format!("{height} {spheres} {temperature} {decay_rate} {up}");
                let choices = [scenes[0].model_for(down).unwrap(), scenes[1].model_for(up).unwrap()];
                let [hanging, standing] = &choices;
                assert_eq!(hanging.is_adequate(), standing.is_adequate(), "{case}");
                // What is said of heights and of the open end; and the models, with their errors.
                let lines = choices.each_ref().map(|choice| choice.to_string().lines().count());
                assert_eq!(lines[0], lines[1], "{case}");
                let freezing = choices.each_ref().map(gradient_mc::model::ModelChoice::freezing);
                assert_eq!(freezing[0].is_some(), spheres == 500, "{case}");
                assert_eq!(freezing[1].is_some(), spheres == 500, "{case}");
                for (found, expected) in hanging.candidates().iter().zip(standing.candidates()) {
                    assert_eq!(found.is_adequate, expected.is_adequate, "{case}");
                    let (error, same) = (found.expected_error, expected.expected_error);
                    assert!((error - same).abs() < 1e-6 * same, "{case}: {error} instead of {same}");
                    let moves = (found.expected_moves, expected.expected_moves);
                    assert!((moves.0 - moves.1).abs() <= 1e-3 * moves.1, "{case}: {moves:?}");
                }
                let theory = |of: usize| choices[of].candidates()[1].model.densities(&scenes[of], 0).unwrap();
                let [found, expected] = [theory(0), theory(1)];
                for (found, expected) in found.into_iter().zip(expected) {
                    close(found, expected);
                }
            }
        }
    }
}

/// A few cold spheres lie on a wall as a gas, however little room they have.
#[test]
fn thin_cold_layers_do_not_freeze() {
    for spheres in [2, 20] {
        for scene in pair(12.0, spheres, 0.005, 0.0) {
            let choice = scene.model_for(Accuracy::density(0.05).unwrap()).unwrap();
            assert!(choice.freezing().is_none() && choice.is_adequate(), "{choice}");
        }
    }
    for scene in pair(12.0, 50, 0.005, 0.0) {
        assert!(scene.model_for(Accuracy::density(0.05).unwrap()).unwrap().freezing().is_some());
    }
}

/// The theory of a column is that of its mirror image also where next to nothing is left at the far
/// wall; and a run can start from it.
#[test]
fn cold_columns() {
    for spheres in [10, 50, 200] {
        let scenes = pair(12.0, spheres, 0.005, 0.0).map(|scene| {
            let slab = Slab::new(12.0, 10.0, 10.0).unwrap();
            Scene::new(slab, spheres, *scene.field(), *scene.temperature()).unwrap()
        });
        let [hanging, standing] =
            scenes.each_ref().map(|scene| scene.hydrostatics(&FluidSolid::default()).unwrap());
        close(hanging.lid_pressure(), standing.base_pressure());
        for step in 0..=240 {
            let height = 0.05 * f64::from(step);
            close(hanging.column_below(height), standing.column_above(12.0 - height));
            close(hanging.pressure(height), standing.pressure(12.0 - height));
        }
        for scene in scenes {
            Simulation::builder(scene).seed(1).build().unwrap();
        }
    }
}
