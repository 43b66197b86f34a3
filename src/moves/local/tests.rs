//! Sweeps by domains leave the distribution as it is, however small the domains are.

use super::*;
use crate::Scene;
use crate::configuration::Configuration;
use crate::drive::{Automatic, Scheme};
use crate::field::UniformField;
use crate::frame::{MoveCounts, Phase};
use crate::statistics::{BlockAverages, Estimate};
use crate::temperature::Isothermal;

/// A gas in a column, swept in domains that are as small as they can be.
pub(super) struct Column {
    scene: Scene<UniformField, Isothermal>,
    drive: <Automatic as Scheme<UniformField, Isothermal>>::Drive,
    pub(super) configuration: Configuration,
    pub(super) engine: Engine,
    generator: Generator,
    pub(super) move_counts: MoveCounts,
    pub(super) phase: Phase,
}

impl Column {
    pub(super) fn new(
        extents: [f64; 3],
        temperature: f64,
        positions: &[[f64; 3]],
        moves: LocalMoves,
    ) -> Self {
        let slab = Slab::new(extents[0], extents[1], extents[2]).unwrap();
        moves.check(&slab).unwrap();
        let temperature = Isothermal::new(temperature).unwrap();
        let mut engine = Engine::new(moves);
        engine.domains = Domains::new(Sizes { thickness: 6.0, width: 6.0, least: 0, most: 0.0 });
        let scene = Scene::new(slab, positions.len(), UniformField::default(), temperature).unwrap();
        Self {
            drive: Automatic.drive(&scene).unwrap().0,
            scene,
            configuration: Configuration::new(slab, positions).unwrap(),
            engine,
            generator: Generator::seed_from_u64(5),
            move_counts: MoveCounts::default(),
            phase: Phase::Production,
        }
    }

    pub(super) fn sweep(&mut self) {
        self.engine
            .sweep(&mut Sweep {
                scene: &self.scene,
                drive: &self.drive,
                configuration: &mut self.configuration,
                generator: &mut self.generator,
                move_counts: &mut self.move_counts,
                phase: self.phase,
                recorder: None,
            })
            .unwrap();
    }
}

#[test]
fn one_sphere_in_many_domains_follows_the_barometric_law() {
    // Domains of three diameters: their faces reject a fifth of the trials.
    let (temperature, range) = (1.5, 11.0);
    let mut column =
        Column::new([range + 1.0, 6.0, 6.0], temperature, &[[1.0, 1.0, 1.0]], LocalMoves::one(0.5));
    let mut moments = BlockAverages::new(2).unwrap();
    let mut across = [0_u32; 2];
    let sweeps = 2_000_000;
    for _ in 0..sweeps {
        column.sweep();
        let [x, y, z] = column.configuration.positions()[0];
        let above = x - 0.5;
        moments.push(&[above, above * above]).unwrap();
        across[0] += u32::from(y > 3.0);
        across[1] += u32::from(z > 3.0);
    }
    assert!(column.engine.domains.slabs() >= 3 && column.engine.domains.tiles() >= 4);
    assert!(column.move_counts.acceptance() < 0.85);
    for deviation in barometric_deviations(&moments, temperature, range, 0.04) {
        assert!(deviation.abs() < 4.0, "{deviation} sigma");
    }
    // All places across are equally likely.
    for times in across {
        assert!((f64::from(times) / f64::from(sweeps) - 0.5).abs() < 0.05, "{across:?}");
    }
}

/// Without a field only walls and the faces of domains reject trials of a single sphere. Walls
/// reject S/(2L) of them.
#[test]
fn trials_that_leave_a_domain_are_counted() {
    let (size, range, sweeps) = (1.0, 12.0, 1_000_000);
    let mut column = Column::new([range + 1.0, 12.0, 12.0], 1.0, &[[1.0; 3]], LocalMoves::one(size));
    let (slab, temperature) = (*column.scene.slab(), *column.scene.temperature());
    column.scene = Scene::new(slab, 1, UniformField::new(0.0).unwrap(), temperature).unwrap();
    (0..sweeps).for_each(|_| column.sweep());
    assert!(column.engine.domains.slabs() >= 2 && column.engine.domains.tiles() >= 4);
    let MoveCounts { trials, accepted, left_domain, .. } = column.move_counts;
    assert!(left_domain as f64 > 0.1 * trials as f64);
    let walls = (trials - accepted - left_domain) as f64 / trials as f64;
    // Some 6000 independent heights, of which a sixth lie near a wall.
    let expected = size / (2.0 * range);
    assert!((walls / expected - 1.0).abs() < 0.06, "{walls} instead of {expected}");
    // A system of one domain.
    column.engine.domains = Domains::new(Sizes::GOOD);
    column.move_counts = MoveCounts::default();
    (0..1000).for_each(|_| column.sweep());
    assert_eq!(column.move_counts.left_domain, 0);
}

/// Deviations, in standard errors, of the first two moments of the height above contact from those
/// of exp(−x/T), for one sphere in a box that leaves it `range`. A standard error is at most `cap`
/// times its moment.
pub(super) fn barometric_deviations(
    moments: &BlockAverages,
    temperature: f64,
    range: f64,
    cap: f64,
) -> Vec<f64> {
    let tail = libm::expm1(range / temperature);
    let expected = [
        temperature - range / tail,
        2.0 * temperature * temperature - range * (range + 2.0 * temperature) / tail,
    ];
    let pairs = moments.estimates().unwrap().into_iter().zip(expected);
    let deviation = |(estimate, expected): (Estimate, f64)| {
        println!("{estimate} for {expected}");
        assert!(estimate.standard_error < cap * expected, "{estimate} for {expected}");
        estimate.deviation_from(expected)
    };
    pairs.map(deviation).collect()
}

#[test]
fn many_spheres_in_small_domains_weigh_what_they_weigh() {
    check_contact(LocalMoves::one(0.4), 0, 60_000);
}

/// Contact theorem: n(1/2) T is the weight on the base, whatever the density. Returns the column.
pub(super) fn check_contact(moves: LocalMoves, equilibration: u64, sweeps: u64) -> Column {
    let (temperature, width) = (3.0, 6.0);
    let particles = 72;
    let positions: Vec<[f64; 3]> = (0..particles)
        .map(|sphere| {
            let (layer, place) = (sphere / 16, sphere % 16);
            [0.6 + 1.1 * f64::from(layer), 1.5 * f64::from(place / 4), 1.5 * f64::from(place % 4)]
        })
        .collect();
    let mut column = Column::new([40.0, width, width], temperature, &positions, moves);
    column.phase = Phase::Equilibration;
    (0..equilibration).for_each(|_| column.sweep());
    column.phase = Phase::Production;
    let mut near_base = BlockAverages::new(2).unwrap();
    // Two thin slices, whose densities are extrapolated to the wall.
    let thickness = 0.04;
    for sweep in 0..sweeps {
        column.sweep();
        if sweep > 2000 {
            let mut counts = [0.0; 2];
            column.configuration.heights().map(|height| (height - 0.5) / thickness).for_each(|slice| {
                if slice < 2.0 {
                    counts[usize::from(slice >= 1.0)] += 1.0;
                }
            });
            near_base.push(&counts).unwrap();
        }
    }
    let volume = thickness * width * width;
    let contact =
        near_base.jackknife(|counts: &[f64]| [(1.5 * counts[0] - 0.5 * counts[1]) / volume]).unwrap();
    let expected = f64::from(particles) / (width * width * temperature);
    assert!(contact[0].deviation_from(expected).abs() < 4.0, "{contact:?} for {expected}");
    assert!(contact[0].standard_error < 0.03 * expected);
    column
}
