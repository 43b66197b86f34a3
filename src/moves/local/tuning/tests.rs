//! Balance where S differs from slab to slab, and the gain by tuning.

use super::super::Sizes;
use super::super::tests::{Column, barometric_deviations, check_contact};
use super::*;
use crate::field::UniformField;
use crate::start::RandomInsertion;
use crate::statistics::BlockAverages;
use crate::temperature::Isothermal;
use crate::{Scene, Simulation, Slab};
use std::cell::Cell;

const TEMPERATURE: f64 = 3.0;
const RANGE: f64 = 24.0;

/// One sphere, and a plan whose S alternates between small and large.
fn one_sphere() -> Column {
    let extents = [RANGE + 1.0, 6.0, 6.0];
    let mut column = Column::new(extents, TEMPERATURE, &[[1.0, 1.0, 1.0]], LocalMoves::tuned());
    // Slabs of about four diameters, which many trials would leave.
    column.engine.domains = Domains::new(Sizes { thickness: 1.2, width: 1.2, least: 0, most: 0.0 });
    column.sweep();
    let tuning = column.engine.tuning.as_mut().unwrap();
    tuning.plan.short.iter_mut().enumerate().for_each(|(band, best)| *best = Some([3, SHORT - 1][band % 2]));
    (tuning.plan.long, tuning.plan.share_of_long) = (Some(SHORT), 0.25);
    column
}

/// Height above contact and its square, each sweep preceded by `before`.
fn moments(mut column: Column, before: impl Fn(&mut Column)) -> (Column, BlockAverages) {
    let mut moments = BlockAverages::new(2).unwrap();
    for _ in 0..1_000_000 {
        before(&mut column);
        column.sweep();
        let above = column.configuration.positions()[0][0] - 0.5;
        moments.push(&[above, above * above]).unwrap();
    }
    (column, moments)
}

#[test]
fn one_sphere_in_slabs_of_different_sizes_follows_the_barometric_law() {
    let slabs = Cell::new(0);
    let (column, moments) =
        moments(one_sphere(), |column| slabs.set(column.engine.domains.slabs().max(slabs.get())));
    for deviation in barometric_deviations(&moments, TEMPERATURE, RANGE, 0.05) {
        assert!(deviation.abs() < 4.0, "{deviation} sigma");
    }
    assert!(slabs.get() >= 5 && column.move_counts.acceptance() < 0.5);
    let tuning = column.engine.tuning.unwrap();
    let sizes = [tuning.short(1.0), tuning.short(5.0), tuning.long()].map(Option::unwrap);
    assert!(sizes[0] < 0.5 && sizes[1] > 2.9 && sizes[2] > 5.9, "{sizes:?}");
}

#[test]
fn sizes_by_the_height_of_the_sphere_are_noticed() {
    // S follows the height of the sphere, not the slab. No trial leaves its domain, so none is
    // rejected for that.
    let plan = one_sphere().engine.tuning.unwrap();
    let mut column = one_sphere();
    column.engine.tuning = None;
    column.engine.domains = Domains::new(Sizes::GOOD);
    let (_, moments) = moments(column, |column| {
        let height = column.configuration.positions()[0][0];
        column.engine.moves = LocalMoves::one(plan.short(height).unwrap());
    });
    // The sphere stays too long where S is small, first of all at the base.
    let deviations = barometric_deviations(&moments, TEMPERATURE, RANGE, 0.1);
    assert!(deviations.iter().all(|deviation| *deviation < -4.0), "{deviations:?} sigma");
}

#[test]
fn a_plan_that_follows_the_sphere_is_noticed() {
    // The slabs are right, but their S depends on the position of the sphere.
    let (_, moments) = moments(one_sphere(), |column| {
        let height = column.configuration.positions()[0][0];
        let tuning = column.engine.tuning.as_mut().unwrap();
        tuning.plan.share_of_long = if height < 3.0 { 0.0 } else { 0.9 };
    });
    // Long jumps take it down, but not up again.
    let deviations = barometric_deviations(&moments, TEMPERATURE, RANGE, 0.04);
    assert!(deviations.iter().all(|deviation| *deviation < -4.0), "{deviations:?} sigma");
}

#[test]
fn tuned_spheres_weigh_what_they_weigh() {
    let column = check_contact(LocalMoves::tuned(), 2000, 150_000);
    let tuning = column.engine.tuning.unwrap();
    assert!(!tuning.adapting() && tuning.short(2.0).is_some() && tuning.long().is_some());
}

#[test]
fn sizes_that_were_never_tuned_are_drawn_and_right() {
    let column = check_contact(LocalMoves::tuned(), 0, 60_000);
    let tuning = column.engine.tuning.unwrap();
    assert!(tuning.short(2.0).is_none() && tuning.long().is_none());
}

fn column(
    temperature: f64,
    extents: [f64; 3],
    particles: usize,
    moves: LocalMoves,
) -> Simulation<UniformField, Isothermal> {
    let slab = Slab::new(extents[0], extents[1], extents[2]).unwrap();
    let temperature = Isothermal::new(temperature).unwrap();
    let scene = Scene::new(slab, particles, UniformField::default(), temperature).unwrap();
    Simulation::builder(scene).start(RandomInsertion::default()).moves(moves).seed(4).build().unwrap()
}

#[test]
fn any_slab_will_do() {
    for (extents, particles) in
        [([2.0, 3.0, 3.0], 1), ([2.5, 3.0, 40.0], 30), ([5000.0, 3.0, 3.5], 40), ([13.0, 90.0, 80.0], 9000)]
    {
        let mut simulation = column(1.0, extents, particles, LocalMoves::tuned());
        simulation.equilibrate(100, &mut ()).unwrap();
        simulation.run(100, &mut ()).unwrap();
        let tuned = simulation.tuned_displacements().unwrap();
        let largest = 0.5 * extents[0].min(extents[1]).min(extents[2]);
        for height in [-1.0, 0.0, 0.5 * extents[0], extents[0], 1e9, f64::INFINITY] {
            assert!(tuned.short(height).is_none_or(|size| size > 0.0 && size <= largest.min(3.0)));
        }
        assert!(tuned.short(f64::NAN).is_none());
        assert!(tuned.long().is_none_or(|size| size > 2.0 && size <= 0.5 * extents[0]));
        // No long sweeps in a low slab.
        assert!(extents[0] > 6.0 || tuned.long().is_none());
        // Valid positions, or this would fail.
        crate::configuration::Configuration::new(
            *simulation.scene().slab(),
            &simulation.positions().into_iter().map(Into::into).collect::<Vec<_>>(),
        )
        .unwrap();
    }
}

#[test]
fn sizes_fall_with_the_density_and_are_frozen_in_production() {
    // Packing fraction 0.48 at the base.
    let mut simulation = column(2.0, [80.0, 5.0, 5.0], 500, LocalMoves::tuned());
    simulation.equilibrate(4000, &mut ()).unwrap();
    simulation.run(1, &mut ()).unwrap();
    let sizes = |simulation: &Simulation<_, _>| {
        let tuned = simulation.tuned_displacements().unwrap();
        let short: Vec<Option<f64>> = (1..40).map(|height| tuned.short(2.0 * f64::from(height))).collect();
        (short, tuned.long(), tuned.share_of_long())
    };
    let (short, long, share) = sizes(&simulation);
    assert!(short[1].unwrap() < 0.4, "dense: {short:?}");
    assert!(short[16].unwrap() > 0.7, "dilute: {short:?}");
    assert!(short[..16].is_sorted(), "{short:?}");
    assert!(long.unwrap() > 4.0 && (0.1..0.9).contains(&share));
    simulation.run(500, &mut ()).unwrap();
    assert_eq!(sizes(&simulation), (short, long, share));
}

#[test]
fn a_tuned_column_falls_two_hundred_times_sooner() {
    let extents = [400.0, 5.0, 5.0];
    let sweeps = |moves: LocalMoves, interval: u64| {
        let mut simulation = column(20.0, extents, 1000, moves);
        while simulation.frame().heights().sum::<f64>() > 160.0 * 1000.0 {
            simulation.equilibrate(interval, &mut ()).unwrap();
            assert!(simulation.sweep() < 100_000);
        }
        simulation.sweep()
    };
    let [fixed, tuned] = [sweeps(LocalMoves::new(0.75).unwrap(), 100), sweeps(LocalMoves::tuned(), 1)];
    assert!(fixed > 200 * tuned, "{fixed} sweeps with S = 0.75, {tuned} with S tuned");
}
