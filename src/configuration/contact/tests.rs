//! `first_contact` against a search over all pairs and images. Only `empty`, `push`, `overlapping` and
//! `first_contact` are used, so that the tests outlive any way of storing the spheres.

use crate::Slab;
use crate::configuration::Configuration;
use proptest::prelude::*;

/// Every image of another sphere that lies ahead and near enough to be touched.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    sphere: usize,
    /// Path to the contact at a distance of exactly one diameter.
    distance: f64,
    separation: f64,
    /// One, less the squared distance across the direction of motion.
    room: f64,
}

impl Candidate {
    /// How far the answer may be off: spheres touch a few roundings above one diameter, which counts
    /// most where they graze.
    fn tolerance(&self, largest: f64) -> f64 {
        1e-13 + (2e-14 + 64.0 * f64::EPSILON * largest) / self.room.max(1e-16).sqrt()
    }

    /// Whether no rounding can make the two miss each other.
    fn certain(&self) -> bool {
        self.room > 1e-11
    }
}

fn candidates(
    extents: [f64; 3],
    positions: &[[f64; 3]],
    moving: usize,
    axis: usize,
    forward: bool,
) -> Vec<Candidate> {
    let from = positions[moving];
    let mut found = Vec::new();
    let images = |axis: usize| if axis == 0 { vec![0.0] } else { vec![-extents[axis], 0.0, extents[axis]] };
    for (sphere, &to) in positions.iter().enumerate().filter(|&(sphere, _)| sphere != moving) {
        for shift_y in images(1) {
            for shift_z in images(2) {
                let apart = [to[0] - from[0], to[1] + shift_y - from[1], to[2] + shift_z - from[2]];
                let ahead = if forward { apart[axis] } else { -apart[axis] };
                let across: f64 = (0..3).filter(|&a| a != axis).map(|a| apart[a] * apart[a]).sum();
                let room = 1.0 - across;
                if room > -1e-12 && ahead > 0.0 {
                    let separation = room.max(0.0).sqrt();
                    found.push(Candidate {
                        sphere,
                        distance: (ahead - separation).max(0.0),
                        separation,
                        room,
                    });
                }
            }
        }
    }
    found
}

/// Checks the answer for one sphere and direction.
fn check(
    extents: [f64; 3],
    positions: &[[f64; 3]],
    configuration: &Configuration,
    moving: usize,
    axis: usize,
    forward: bool,
) {
    let largest = extents.into_iter().fold(1.0, f64::max);
    let room = if forward { extents[0] - 0.5 - positions[moving][0] } else { positions[moving][0] - 0.5 };
    let limit = if axis == 0 { room } else { 0.5 * extents[axis] };
    let candidates = candidates(extents, positions, moving, axis, forward);
    let sure = candidates.iter().filter(|candidate| candidate.certain());
    let nearest = sure.min_by(|a, b| a.distance.total_cmp(&b.distance));
    let context =
        || format!("sphere {moving} along {axis} {forward} in {extents:?}: {positions:?}, {nearest:?}");
    let Some(contact) = configuration.first_contact(moving, axis, forward, limit) else {
        assert!(
            nearest.is_none_or(|it| it.distance > limit - it.tolerance(largest)),
            "missed: {}",
            context()
        );
        return;
    };
    assert!(contact.distance >= 0.0 && contact.distance < limit, "{contact:?} {}", context());
    let matching = candidates.iter().any(|candidate| {
        let tolerance = candidate.tolerance(largest);
        candidate.sphere == contact.sphere
            && (candidate.distance - contact.distance).abs() <= tolerance
            && (candidate.separation - contact.separation).abs() <= 2.0 * tolerance
    });
    assert!(matching, "{contact:?} is none of {candidates:?}: {}", context());
    if let Some(nearest) = nearest {
        assert!(
            contact.distance <= nearest.distance + nearest.tolerance(largest),
            "{contact:?} {}",
            context()
        );
    }
    // Who goes there overlaps nobody.
    let mut moved = positions[moving];
    moved[axis] += if forward { contact.distance } else { -contact.distance };
    for (sphere, &other) in positions.iter().enumerate().filter(|&(sphere, _)| sphere != moving) {
        let squared: f64 = (0..3)
            .map(|axis| {
                let apart = (moved[axis] - other[axis]).abs();
                let apart = if axis == 0 { apart } else { apart.min((extents[axis] - apart).abs()) };
                apart * apart
            })
            .sum();
        assert!(squared >= 1.0 - 1e-14, "{sphere} at {squared}: {contact:?} {}", context());
    }
    // A shorter move does not get there.
    if contact.distance > 1e-9 {
        let short = configuration.first_contact(moving, axis, forward, 0.999 * contact.distance);
        assert!(short.is_none(), "{short:?} before {contact:?}: {}", context());
    }
}

fn check_all(extents: [f64; 3], positions: &[[f64; 3]]) {
    let mut configuration = Configuration::empty(Slab::new(extents[0], extents[1], extents[2]).unwrap());
    for &position in positions {
        configuration.push(position);
    }
    for moving in 0..positions.len() {
        for axis in 0..3 {
            check(extents, positions, &configuration, moving, axis, true);
            check(extents, positions, &configuration, moving, axis, false);
        }
    }
}

fn wrapped(value: f64, width: f64) -> f64 {
    let value = value.rem_euclid(width);
    if value < width { value } else { 0.0 }
}

/// How to add a sphere: anywhere, or touching an earlier one, along an axis or obliquely.
#[derive(Debug, Clone, Copy)]
enum Addition {
    Anywhere([f64; 3]),
    Touching { partner: prop::sample::Index, axis: usize, cosine: f64, angle: f64, distance: f64 },
}

fn addition() -> impl Strategy<Value = Addition> {
    let fraction = || prop_oneof![4 => 0.0..1.0_f64, 1 => Just(0.0)];
    prop_oneof![
        2 => [fraction(), fraction(), fraction()].prop_map(Addition::Anywhere),
        1 => (
            any::<prop::sample::Index>(),
            0_usize..5,
            -1.0..1.0_f64,
            0.0..std::f64::consts::TAU,
            prop::sample::select(vec![1.0, 1.0 + 1e-15, 1.0 + 1e-14, 1.0 + 1e-9]),
        )
            .prop_map(|(partner, axis, cosine, angle, distance)| Addition::Touching {
                partner,
                axis,
                cosine,
                angle,
                distance,
            }),
    ]
}

/// Spheres that do not overlap, made by additions of which those that find no room are left out.
fn place(extents: [f64; 3], additions: &[Addition]) -> Vec<[f64; 3]> {
    let mut configuration = Configuration::empty(Slab::new(extents[0], extents[1], extents[2]).unwrap());
    let mut positions: Vec<[f64; 3]> = Vec::new();
    for &addition in additions {
        let position = match addition {
            Addition::Anywhere([x, y, z]) => [
                0.5 + x * (extents[0] - 1.0),
                wrapped(y * extents[1], extents[1]),
                wrapped(z * extents[2], extents[2]),
            ],
            Addition::Touching { partner, axis, cosine, angle, distance } if !positions.is_empty() => {
                let sine = (1.0 - cosine * cosine).sqrt();
                let direction = match axis {
                    0 => [cosine.signum(), 0.0, 0.0],
                    1 => [0.0, cosine.signum(), 0.0],
                    2 => [0.0, 0.0, cosine.signum()],
                    _ => [cosine, sine * libm::cos(angle), sine * libm::sin(angle)],
                };
                let center = partner.get(&positions);
                [
                    center[0] + distance * direction[0],
                    wrapped(center[1] + distance * direction[1], extents[1]),
                    wrapped(center[2] + distance * direction[2], extents[2]),
                ]
            }
            Addition::Touching { .. } => continue,
        };
        if position[0] >= 0.5
            && position[0] <= extents[0] - 0.5
            && configuration.overlapping(position).is_none()
        {
            configuration.push(position);
            positions.push(position);
        }
    }
    positions
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    #[test]
    fn first_contact_equals_search_over_all_pairs(
        height in prop_oneof![prop::sample::select(vec![2.0, 2.5, 3.0, 4.0]), 2.0..14.0_f64],
        width_y in prop_oneof![2 => prop::sample::select(vec![3.0, 3.5, 4.0]), 1 => 3.0..12.0_f64],
        width_z in prop_oneof![2 => prop::sample::select(vec![3.0, 3.5, 4.0]), 1 => 3.0..12.0_f64],
        additions in prop::collection::vec(addition(), 1..120),
    ) {
        let extents = [height, width_y, width_z];
        check_all(extents, &place(extents, &additions));
    }
}

#[test]
fn touching_rows_pass_the_motion_on_at_once() {
    for width in [3.0, 4.0, 7.0] {
        let extents = [5.0, width, width];
        let count = (0..).take_while(|&sphere| f64::from(sphere) < width);
        let row = |axis: usize| -> Vec<[f64; 3]> {
            let place = |sphere: i32| {
                let mut position = [1.5, 0.25, 0.25];
                position[axis] = f64::from(sphere);
                position
            };
            count.clone().map(place).collect()
        };
        for axis in [1, 2] {
            let positions = row(axis);
            check_all(extents, &positions);
            let mut configuration =
                Configuration::empty(Slab::new(extents[0], extents[1], extents[2]).unwrap());
            for &position in &positions {
                configuration.push(position);
            }
            for sphere in 0..positions.len() {
                let contact = configuration.first_contact(sphere, axis, true, 0.5 * width).unwrap();
                assert!(contact.distance < 1e-14);
                assert_eq!(contact.sphere, (sphere + 1) % positions.len());
            }
        }
    }
    // A stack between the walls.
    check_all([4.0, 3.0, 3.0], &[[0.5, 1.0, 1.0], [1.5, 1.0, 1.0], [2.5, 1.0, 1.0], [3.5, 1.0, 1.0]]);
}

/// Whatever the order in memory, which depends on what the two did before.
#[test]
fn of_two_that_are_touched_at_once_the_number_decides() {
    let slab = Slab::new(10.0, 5.0, 5.0).unwrap();
    // Both in one cell, and as far to the one side as to the other.
    let positions = [[0.5, 1.8125, 2.0], [2.0, 1.25, 2.0], [2.0, 2.375, 2.0]];
    let mut configuration = Configuration::new(slab, &positions).unwrap();
    for _ in 0..2 {
        assert_eq!(configuration.first_contact(0, 0, true, 8.0).unwrap().sphere, 1);
        for sphere in [1, 2] {
            configuration.relocate(sphere, [8.0, positions[sphere][1], 2.0]);
        }
        for sphere in [2, 1] {
            configuration.relocate(sphere, positions[sphere]);
        }
    }
}
