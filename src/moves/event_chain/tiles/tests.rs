//! Chains in tiles of any size keep the distribution; wrong rules do not.

use super::*;
use crate::centers::Centers;
use crate::configuration::Configuration;
use crate::drive::{Automatic, Scheme};
use crate::field::{ExponentialField, UniformField};
use crate::frame::{Frame, MoveCounts, Phase, Still};
use crate::moves::LocalMoves;
use crate::moves::event_chain::tests::{NEAR, SIDE, exact_moments};
use crate::moves::event_chain::{Engine, FieldEvent};
use crate::observer::Observer;
use crate::observers::{Bins, CenterOfMass, ChainPressureProfile, DensityProfile};
use crate::statistics::{BlockAverages, Estimate};
use crate::temperature::Isothermal;
use crate::{Scene, Slab};
use rand::SeedableRng;

/// The smallest tiles: most of their spheres touch frozen ones.
const SMALL: Sizes = Sizes { spheres: 0.0, least: [0.45, 0.45], together: 2 };
/// The whole base is one tile.
const NONE: Sizes = Sizes { spheres: f64::INFINITY, ..SMALL };

/// A column and its chains.
struct Column<F: Field> {
    scene: Scene<F, Isothermal>,
    drive: <Automatic as Scheme<F, Isothermal>>::Drive,
    configuration: Configuration,
    engine: Engine,
    generator: Generator,
    move_counts: MoveCounts,
    sweeps: u64,
}

impl<F: Field> Column<F> {
    fn new(
        extents: [f64; 3],
        field: F,
        temperature: f64,
        positions: &[[f64; 3]],
        chains: EventChains,
    ) -> Self {
        let slab = Slab::new(extents[0], extents[1], extents[2]).unwrap();
        let temperature = Isothermal::new(temperature).unwrap();
        let scene = Scene::new(slab, positions.len(), field, temperature).unwrap();
        Self {
            drive: Automatic.drive(&scene).unwrap().0,
            scene,
            configuration: Configuration::new(slab, positions).unwrap(),
            engine: Engine::new(chains),
            generator: Generator::seed_from_u64(5),
            move_counts: MoveCounts::default(),
            sweeps: 0,
        }
    }

    fn in_tiles(mut self, sizes: Sizes, frozen: Frozen) -> Self {
        self.engine.tiles = Box::new(Tiles { frozen, ..Tiles::new(sizes) });
        let tiles = Cut::new(0, self.scene.slab(), self.configuration.len(), &sizes).tiles();
        assert_eq!(tiles >= 4, sizes.spheres < 1.0);
        self
    }

    fn sweep(&mut self, observer: &mut impl Observer) {
        self.engine
            .sweep(&mut Sweep {
                scene: &self.scene,
                drive: &self.drive,
                configuration: &mut self.configuration,
                generator: &mut self.generator,
                move_counts: &mut self.move_counts,
                phase: Phase::Production,
                recorder: observer.recorder(),
            })
            .unwrap();
        self.sweeps += 1;
        let frame = Frame {
            scene: self.scene.as_any(),
            potential: &Still(0),
            centers: Centers::new(&self.configuration),
            sweep: self.sweeps,
            phase: Phase::Production,
            sweep_of_phase: self.sweeps,
            move_counts: &self.move_counts,
        };
        observer.observe(&frame).unwrap();
    }
}

/// Deviation of an estimate from an exact value, in standard errors, which are at most `cap`.
fn deviation(what: &str, estimate: Estimate, exact: f64, cap: f64) -> f64 {
    let deviation = estimate.deviation_from(exact);
    println!("{what}: {estimate} against {exact}, {deviation:.1} sigma, cap {cap}");
    assert!(estimate.standard_error < cap, "{what}: {estimate}, cap {cap}");
    deviation
}

#[test]
fn one_sphere_in_many_tiles_follows_the_barometric_law() {
    let (temperature, range) = (1.5, 11.0);
    let chains = EventChains::with_length(3.0).unwrap().local_moves(None);
    for rule in [FieldEvent::Relocate, FieldEvent::Reverse] {
        let extents = [range + 1.0, 6.0, 5.0];
        let chains = chains.field_event(rule);
        let mut column = Column::new(extents, UniformField::default(), temperature, &[[1.0; 3]], chains)
            .in_tiles(SMALL, Frozen::Turns);
        column.engine.length.path_per_visit = 6.0;
        let mut moments = BlockAverages::new(2).unwrap();
        let mut across = [0_u32; 2];
        let sweeps = 400_000;
        for _ in 0..sweeps {
            column.sweep(&mut ());
            let [x, y, z] = column.configuration.positions()[0];
            moments.push(&[x - 0.5, (x - 0.5) * (x - 0.5)]).unwrap();
            across[0] += u32::from(y > 3.0);
            across[1] += u32::from(z > 2.5);
        }
        let tail = libm::expm1(range / temperature);
        let expected = [
            temperature - range / tail,
            2.0 * temperature * temperature - range * (range + 2.0 * temperature) / tail,
        ];
        for (estimate, expected) in moments.estimates().unwrap().into_iter().zip(expected) {
            assert!(deviation("moment", estimate, expected, 0.03 * expected).abs() < 4.0);
        }
        // All places across are equally likely.
        for times in across {
            assert!((f64::from(times) / f64::from(sweeps) - 0.5).abs() < 0.05, "{across:?}");
        }
    }
}

/// Mean height, difference in height and probability of near contact of two spheres in tiles, each
/// with its exact value.
fn two_spheres(rule: FieldEvent, frozen: Frozen, sweeps: u64) -> [(Estimate, f64); 3] {
    let (height, temperature) = (6.0, 3.0);
    let field = ExponentialField::new(0.3).unwrap();
    let exact = exact_moments(height, |x| field.potential(x) / temperature);
    let chains = EventChains::with_length(3.0).unwrap().field_event(rule).local_moves(None);
    let chains = chains.vertical_fraction(0.5).unwrap();
    let positions = [[1.0, 1.0, 1.0], [3.0, 1.0, 1.0]];
    let mut column =
        Column::new([height, SIDE, SIDE], field, temperature, &positions, chains).in_tiles(SMALL, frozen);
    let mut moments = BlockAverages::new(3).unwrap();
    let image = |distance: f64| distance.abs().min(SIDE - distance.abs());
    for sweep in 0..sweeps {
        column.sweep(&mut ());
        if sweep > 10_000 {
            let positions = column.configuration.positions();
            let (a, b) = (positions[0], positions[1]);
            let [x, y, z] = [a[0] - b[0], image(a[1] - b[1]), image(a[2] - b[2])];
            let near = x * x + y * y + z * z < NEAR * NEAR;
            moments.push(&[0.5 * (a[0] + b[0]), x.abs(), f64::from(u8::from(near))]).unwrap();
        }
    }
    let estimates = moments.estimates().unwrap();
    [0, 1, 2].map(|item| (estimates[item], exact[item]))
}

#[test]
fn two_spheres_tell_what_a_frozen_sphere_must_do() {
    for rule in [FieldEvent::Relocate, FieldEvent::Reverse] {
        let [height, difference, near] = two_spheres(rule, Frozen::Turns, 1_200_000);
        assert!(deviation("mean height", height.0, height.1, 0.01).abs() < 4.0);
        assert!(deviation("difference", difference.0, difference.1, 0.01).abs() < 4.0);
        assert!(deviation("near contact", near.0, near.1, 0.04 * near.1).abs() < 4.0);
    }
    // If chains end at frozen spheres, the two stay near each other.
    let [_, difference, near] = two_spheres(FieldEvent::Relocate, Frozen::Ends, 600_000);
    assert!(deviation("difference", difference.0, difference.1, 0.02) < -4.0);
    assert!(deviation("near contact", near.0, near.1, 0.005) > 4.0);
}

/// Contact density, center of mass, profile and pressures of a column of 96 spheres over a base 6 x
/// 5.
fn observe(sizes: Sizes, frozen: Frozen, sweeps: u64) -> Vec<Estimate> {
    let (temperature, extents) = (3.0, [30.0, 6.0, 5.0]);
    let positions: Vec<[f64; 3]> = (0..96)
        .map(|sphere| {
            let (layer, place) = (sphere / 20, sphere % 20);
            [0.6 + 1.1 * f64::from(layer), 1.2 * f64::from(place / 4), 1.25 * f64::from(place % 4)]
        })
        .collect();
    let local = LocalMoves::one(0.4);
    let chains =
        EventChains::with_length(2.0).unwrap().vertical_fraction(0.7).unwrap().local_moves(Some(local));
    let column = Column::new(extents, UniformField::default(), temperature, &positions, chains);
    let mut column = column.in_tiles(sizes, frozen);
    for _ in 0..sweeps / 10 {
        column.sweep(&mut ());
    }
    let slab = *column.scene.slab();
    let profile = DensityProfile::new(&slab, Bins::count(8).from(0.5).to(8.5)).unwrap();
    let near_base = DensityProfile::new(&slab, Bins::count(2).from(0.5).to(0.58)).unwrap();
    let pressures = ChainPressureProfile::new(&slab, Bins::count(3).from(1.0).to(7.0)).unwrap();
    let mut observers = (CenterOfMass::new(), profile, near_base, pressures);
    for _ in 0..sweeps {
        column.sweep(&mut observers);
    }
    let (center, profile, near_base, pressures) = observers;
    let contact = near_base.jackknife(|bins: &[f64]| [1.5 * bins[0] - 0.5 * bins[1]]).unwrap()[0];
    let mut values = vec![contact, center.estimate().unwrap()];
    values.extend(profile.points().unwrap().iter().map(|point| point.number_density));
    for point in pressures.points().unwrap() {
        values.extend([point.normal, point.lateral]);
    }
    values
}

#[test]
fn a_column_in_small_tiles_agrees_with_one_in_none() {
    const SWEEPS: u64 = 40_000;
    let expected = observe(NONE, Frozen::Turns, SWEEPS);
    let deviations = |found: &[Estimate]| -> Vec<f64> {
        let pairs = found.iter().zip(&expected).enumerate();
        pairs
            .map(|(item, (found, expected))| {
                let joint = Estimate::new(found.mean, found.standard_error.hypot(expected.standard_error));
                deviation(&format!("item {item}"), joint, expected.mean, 0.05 * expected.mean)
            })
            .collect()
    };
    let found = observe(SMALL, Frozen::Turns, SWEEPS);
    // The contact theorem: n(1/2) T is the weight on the base.
    assert!(deviation("contact", found[0], 96.0 / 30.0 / 3.0, 0.05).abs() < 4.0);
    let found = deviations(&found);
    assert!(found.iter().all(|deviation| deviation.abs() < 4.0), "{found:?} sigma");
    // A chain that ends at a frozen sphere leaves the base too full, and the center of mass too
    // low.
    let wrong = deviations(&observe(SMALL, Frozen::Ends, SWEEPS / 2));
    assert!(wrong[1] < -4.0, "{wrong:?} sigma");
}
