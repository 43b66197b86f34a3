//! An isothermal scene carries nothing of the feedback that other temperatures need: no state, and no
//! allocation in a sweep. That it costs no time either is shown by `cargo bench --bench throughput`,
//! which compares it with a drive specialized by hand.

#![allow(clippy::unwrap_used)]

use gradient_mc::drive::{IsothermalDrive, SelfConsistent, SelfConsistentDrive};
use gradient_mc::field::UniformField;
use gradient_mc::moves::LocalMoves;
use gradient_mc::temperature::{ExponentialTemperature, Isothermal};
use gradient_mc::{Scene, Simulation, Slab};

fn slab() -> Slab {
    Slab::new(60.0, 5.0, 5.0).unwrap()
}

#[test]
fn the_isothermal_drive_has_no_size() {
    assert_eq!(size_of::<IsothermalDrive>(), 0);
    assert_eq!(size_of::<Isothermal>(), size_of::<f64>());
    assert_eq!(size_of::<UniformField>(), size_of::<f64>());
    let isothermal = size_of::<Simulation<UniformField, Isothermal>>();
    let feedback = size_of::<Simulation<UniformField, Isothermal, SelfConsistentDrive>>();
    // But for padding.
    let padding = align_of::<Simulation<UniformField, Isothermal>>();
    assert!((feedback - isothermal).abs_diff(size_of::<SelfConsistentDrive>()) < padding);
}

#[test]
fn isothermal_sweeps_allocate_nothing() {
    let scene = Scene::new(slab(), 200, UniformField::default(), Isothermal::new(4.0).unwrap()).unwrap();
    let mut simulation = Simulation::builder(scene).seed(1).build().unwrap();
    // The cell list makes a page at most for each sphere at first; then it reuses them.
    simulation.equilibrate(2000, &mut ()).unwrap();
    let counted = allocation_counter::measure(|| simulation.run(200, &mut ()).unwrap());
    assert_eq!(counted.count_total, 0);

    // Sizes that were tuned are as cheap as others once they are fixed.
    let moves = LocalMoves::tuned();
    let mut simulation = Simulation::builder(scene).moves(moves).seed(1).build().unwrap();
    simulation.equilibrate(2000, &mut ()).unwrap();
    simulation.run(200, &mut ()).unwrap();
    let counted = allocation_counter::measure(|| simulation.run(200, &mut ()).unwrap());
    assert_eq!(counted.count_total, 0);

    // The counter counts: a drive that adapts does allocate.
    let temperature = ExponentialTemperature::new(4.0, 0.02).unwrap();
    let scene = Scene::new(slab(), 200, UniformField::default(), temperature).unwrap();
    let builder = Simulation::builder(scene).scheme(SelfConsistent::default());
    let mut simulation = builder.seed(1).build().unwrap();
    simulation.equilibrate(2000, &mut ()).unwrap();
    let counted = allocation_counter::measure(|| simulation.equilibrate(200, &mut ()).unwrap());
    assert!(counted.count_total > 0);
}
