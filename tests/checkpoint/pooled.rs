//! Merging the results of many processes.

use gradient_mc::checkpoint::Run;
use gradient_mc::field::UniformField;
use gradient_mc::observers::{Bins, CenterOfMass, DensityProfile, EquationOfStateProfile};
use gradient_mc::temperature::Isothermal;
use gradient_mc::{Error, Replicas, Scene, Simulation, SimulationBuilder, Slab};
use std::error::Error as _;
use std::fs;
use tempfile::tempdir;

type Observed = (EquationOfStateProfile, CenterOfMass);

fn builder(temperature: f64) -> SimulationBuilder<UniformField, Isothermal> {
    let slab = Slab::new(30.0, 4.0, 4.0).unwrap();
    let scene = Scene::new(slab, 40, UniformField::default(), Isothermal::new(temperature).unwrap()).unwrap();
    Simulation::builder(scene)
}

fn observer() -> Observed {
    let slab = Slab::new(30.0, 4.0, 4.0).unwrap();
    (EquationOfStateProfile::new(&slab, Bins::count(6)).unwrap(), CenterOfMass::new())
}

#[test]
fn files_of_any_number_of_processes_give_what_one_gives() {
    let folder = tempdir().unwrap();
    for count in [1, 5] {
        let replicas = Replicas::new(count).seed(7);
        let outcome = replicas
            .run(|replica| {
                let mut observer = observer();
                let mut simulation = builder(4.0).seed(replica.seed()).build()?;
                simulation.equilibrate(50, &mut ())?;
                simulation.run(150 + 13 * replica.index() as u64, &mut observer)?;
                Ok(observer)
            })
            .unwrap();
        let expected = outcome.merged().unwrap();
        let paths: Vec<_> = (0..count)
            .map(|task| {
                let path = folder.path().join(format!("{count}_{task}"));
                let seed = replicas.replica(task).seed();
                let run = Run::new(&path, 50, 150 + 13 * task as u64);
                run.of(builder(4.0).seed(seed), &mut observer()).unwrap();
                path
            })
            .collect();
        let pooled = builder(4.0).pooled(&paths, &observer()).unwrap();
        // In full, NaN included.
        let results = |(profile, centers): &Observed| {
            format!("{:?} {:?} {centers:?}", profile.points().unwrap(), profile.observations())
        };
        assert_eq!(results(&pooled), results(&expected));
    }
}

#[test]
fn files_that_do_not_belong_together_are_refused() {
    let folder = tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let run = |name: &str, temperature: f64, seed: u64, production: u64| {
        let run = Run::new(path(name), 50, production);
        run.of(builder(temperature).seed(seed), &mut observer()).unwrap();
    };
    run("first", 4.0, 1, 60);
    run("second", 4.0, 2, 60);
    run("same seed", 4.0, 1, 70);
    run("hotter", 4.5, 3, 60);
    run("not measured", 4.0, 4, 0);
    let bytes = fs::read(path("second")).unwrap();
    fs::write(path("truncated"), &bytes[..bytes.len() - 1]).unwrap();
    let pooled = |names: &[&str]| builder(4.0).pooled(names.iter().map(|name| path(name)), &observer());
    assert_eq!(pooled(&["first", "second"]).unwrap().0.observations(), 120);
    let error = pooled(&["second", "first", "same seed"]).unwrap_err();
    assert!(
        matches!(&error, Error::SameSeed { seed: 1, paths, .. } if paths[1].ends_with("same seed")),
        "{error}"
    );
    for (name, reason) in [
        ("hotter", "temperature was 4.5"),
        ("not measured", "sweeps of production"),
        ("truncated", "damaged"),
        ("absent", ""),
    ] {
        let error = pooled(&["first", name]).unwrap_err();
        assert!(matches!(&error, Error::CheckpointFile { path, .. } if path.ends_with(name)), "{error}");
        assert!(error.source().unwrap().to_string().contains(reason), "{error:?}");
    }
    let slab = Slab::new(30.0, 4.0, 4.0).unwrap();
    let other = DensityProfile::new(&slab, Bins::count(6)).unwrap();
    assert!(matches!(builder(4.0).pooled([path("first")], &other), Err(Error::CheckpointFile { .. })));
    assert!(matches!(pooled(&[]), Err(Error::TooFewObservations { .. })));
}
