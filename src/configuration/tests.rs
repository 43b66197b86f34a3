//! Neighbor search against a search over all pairs and images, and its bookkeeping.

use super::grid::division;
use super::layer::NONE;
use super::page::{NOWHERE, SLOTS};
use super::*;
use proptest::prelude::*;

/// Periodic widths whose division into cells is error-prone.
const WIDTHS: [f64; 10] =
    [3.0, 3.000_000_000_000_000_4, 3.5, 3.99, 4.0, 4.000_000_000_000_001, 4.000_000_1, 5.2, 7.0, 16.3];
const HEIGHTS: [f64; 9] = [2.0, 2.5, 2.99, 3.0, 3.000_000_000_000_000_4, 3.99, 4.0, 5.2, 23.7];

/// Whether any image of any sphere but `ignored` is nearer than one diameter to `position`.
fn overlaps_some_pair(
    positions: &[[f64; 3]],
    ignored: Option<usize>,
    widths: [f64; 2],
    position: [f64; 3],
) -> bool {
    positions.iter().enumerate().filter(|&(sphere, _)| Some(sphere) != ignored).any(|(_, other)| {
        let image = |distance: f64, width: f64| distance.abs().min(width - distance.abs());
        let dx = position[0] - other[0];
        let dy = image(position[1] - other[1], widths[0]);
        let dz = image(position[2] - other[2], widths[1]);
        dx * dx + dy * dy + dz * dz < 1.0
    })
}

impl Configuration {
    /// Layer and index of a sphere.
    fn place(&self, sphere: usize) -> (usize, u32) {
        let mut layers = self.layers.iter().enumerate();
        let find = |layer: &Layer| layer.spheres.iter().position(|other| other.number as usize == sphere);
        let (layer, index) = layers.find_map(|(number, layer)| Some((number, find(layer)?))).unwrap();
        (layer, u32::try_from(index).unwrap())
    }

    /// Whether a sphere would overlap another at a position.
    fn overlaps_others(&self, sphere: usize, position: [f64; 3]) -> bool {
        let ((layer, index), spot) = (self.place(sphere), self.grid.spot(position));
        let in_sight = layer.wrapping_sub(spot.layer as usize) < 3;
        self.overlaps(if in_sight { self.layers[layer].occupant(index) } else { NOBODY }, position)
    }

    /// Moves a sphere to a position that was found free.
    fn relocate(&mut self, sphere: usize, position: [f64; 3]) {
        let (from, index) = self.place(sphere);
        let (grid, layers) = self.parts_mut();
        let spot = grid.spot(position);
        let (to, site) = (spot.layer as usize + 1, grid.site(&spot, position));
        if from == to {
            layers[to].shift(grid, index, &site);
        } else {
            let number = layers[from].remove(grid, index);
            layers[to].insert(grid, &site, number);
        }
    }
}

/// Every sphere is found at its place, in the cell of its position, and nothing else is there.
fn assert_consistent(configuration: &Configuration, positions: &[[f64; 3]]) {
    let Configuration { grid, layers, .. } = configuration;
    let [_, rows, columns] = grid.cells;
    assert_eq!(configuration.len(), positions.len());
    assert_eq!(layers.len(), grid.cells[0] + 2);
    let mut found = vec![0; positions.len()];
    for (number, layer) in layers.iter().enumerate() {
        let beyond = number == 0 || number == layers.len() - 1;
        let mut used = vec![false; layer.pages.len()];
        used[NONE as usize] = true;
        for y in 0..rows {
            for z in 0..columns {
                let cell = grid.cell(y, z);
                let head = layer.heads[cell];
                let mut page = head >> 1;
                assert_eq!(head & 1 == 1, layer.next[page as usize] != NONE, "says whether pages follow");
                assert!(page == NONE || !beyond, "spheres beyond a wall");
                let mut inhabitants = 0;
                while page != NONE {
                    assert!(!std::mem::replace(&mut used[page as usize], true), "page {page} is used twice");
                    let content = &layer.pages[page as usize];
                    assert!(!content.is_empty());
                    for slot in 0..SLOTS {
                        let occupant = content.occupants.to_array()[slot];
                        if occupant == NOBODY {
                            assert!(content.x.to_array()[slot].to_bits() == NOWHERE.to_bits(), "a ghost");
                            continue;
                        }
                        inhabitants += 1;
                        let index = occupant >> 2;
                        assert_eq!(occupant, layer.occupant(index));
                        let sphere = &layer.spheres[index as usize];
                        let truth = positions[sphere.number as usize];
                        assert_eq!(sphere.position.map(f64::to_bits), truth.map(f64::to_bits));
                        assert_eq!(sphere.cell as usize, cell);
                        let spot = grid.spot(truth);
                        assert_eq!(
                            (spot.layer as usize + 1, spot.cell as usize),
                            (number, cell),
                            "{truth:?}"
                        );
                        let seen = [content.x, content.y, content.z].map(|along| along.to_array()[slot]);
                        assert_eq!(seen.map(f32::to_bits), grid.relative(&spot, truth).map(f32::to_bits));
                        found[sphere.number as usize] += 1;
                    }
                    page = layer.next[page as usize];
                }
                // The neighboring cells have it marked.
                for neighbor in 0..9 {
                    let y = (y + rows + neighbor / 3 - 1) % rows;
                    let z = (z + columns + neighbor % 3 - 1) % columns;
                    let known = layer.nearby[grid.cell(y, z)] >> (8 - neighbor) & 1 == 1;
                    assert_eq!(known, inhabitants > 0);
                }
            }
        }
        // The margin repeats the opposite end.
        for y in 0..rows + 2 {
            for z in 0..columns + 2 {
                let repeated = grid.cell((y + rows - 1) % rows, (z + columns - 1) % columns);
                assert_eq!(layer.heads[y * (columns + 2) + z], layer.heads[repeated]);
            }
        }
        let mut spare = layer.spare_page;
        while spare != NONE {
            assert!(!std::mem::replace(&mut used[spare as usize], true), "page {spare} is spare and used");
            assert!(layer.pages[spare as usize].is_empty());
            spare = layer.next[spare as usize];
        }
        assert!(used.into_iter().all(|used| used), "a page is lost");
        let mut gaps = 0;
        let mut gap = layer.gap;
        while gap != NOBODY {
            gaps += 1;
            assert_eq!(layer.spheres[gap as usize].number, NOBODY);
            gap = layer.spheres[gap as usize].cell;
        }
        assert_eq!(
            layer.spheres.iter().filter(|sphere| sphere.number != NOBODY).count() + gaps,
            layer.spheres.len(),
            "a gap is lost"
        );
    }
    assert!(found.iter().all(|&times| times == 1), "{found:?}");
    assert_eq!(configuration.positions(), positions);
}

/// Spheres at given positions, which may overlap.
fn configuration_of(extents: [f64; 3], positions: &[[f64; 3]]) -> Configuration {
    let mut configuration = Configuration::empty(slab(extents));
    for &position in positions {
        configuration.push(position);
    }
    configuration
}

/// Compares the search with that over all pairs, for an additional sphere at `position`.
fn assert_same_answer(configuration: &Configuration, positions: &[[f64; 3]], position: [f64; 3]) {
    let expected = overlaps_some_pair(positions, None, configuration.grid.widths, position);
    let found = configuration.overlapping(position);
    assert_eq!(found.is_some(), expected, "query at {position:?}");
    // For every direction from which it may have come, also in two steps.
    let (grid, spot) = (&configuration.grid, configuration.grid.spot(position));
    for octant in 0..8 {
        let probe = configuration.probe(&spot, position, octant, NOBODY);
        assert_eq!(probe.overlaps(grid, configuration.around(&spot)), expected);
        let (early, candidates) = probe.overlaps_early::<2>(grid, configuration.around(&spot));
        let probe = Probe { candidates, ..probe };
        assert_eq!(early || probe.overlaps(grid, configuration.around(&spot)), expected);
    }
    if let Some((sphere, distance)) = found {
        assert!(overlaps_some_pair(&positions[sphere..=sphere], None, configuration.grid.widths, position));
        assert!(distance <= 1.0 + 1e-15);
    }
}

/// A periodic coordinate: anywhere, at an edge of the box or of a cell, or within rounding of one.
fn periodic_coordinate(width: f64) -> impl Strategy<Value = f64> {
    let cells = division(width);
    prop_oneof![
        3 => 0.0..width,
        1 => prop::sample::select(vec![
            0.0, -0.0, f64::MIN_POSITIVE, 1e-17, width.next_down(), width - 1e-12, 1.0, width - 1.0, 0.5 * width,
        ]),
        2 => (0..cells, -2_i32..=2).prop_map(move |(cell, steps)| {
            shifted_by_steps(cell as f64 * width / cells as f64, steps).clamp(0.0, width.next_down())
        }),
    ]
}

/// The height of a center, walls and cell edges included.
fn height_coordinate(height: f64) -> impl Strategy<Value = f64> {
    let cells = division(height);
    let highest = height - 0.5;
    prop_oneof![
        3 => 0.5..=highest,
        1 => prop::sample::select(vec![0.5, 0.5_f64.next_up(), highest, highest.next_down()])
            .prop_map(move |value: f64| value.clamp(0.5, highest)),
        2 => (0..=cells, -2_i32..=2).prop_map(move |(cell, steps)| {
            shifted_by_steps(cell as f64 * height / cells as f64, steps).clamp(0.5, highest)
        }),
    ]
}

/// One diameter, or so near it that single precision cannot tell.
fn distance_near_contact() -> impl Strategy<Value = f64> {
    prop_oneof![
        Just(1.0),
        prop::sample::select(vec![1.0_f64.next_up(), 1.0_f64.next_down()]),
        (-16.0..-5.0_f64, any::<bool>()).prop_map(|(power, outside)| {
            let excess = 10_f64.powf(power);
            if outside { 1.0 + excess } else { 1.0 - excess }
        }),
    ]
}

/// A sphere, and a step of nearly one diameter from it.
fn step_to_contact() -> impl Strategy<Value = (prop::sample::Index, [f64; 3])> {
    (
        any::<prop::sample::Index>(),
        (-1.0..1.0_f64, 0.0..std::f64::consts::TAU, distance_near_contact(), 0_usize..4),
    )
        .prop_map(|(chosen, (cosine, angle, distance, axis))| {
            let sine = (1.0 - cosine * cosine).sqrt();
            // Along one axis the distance is met to the last bit; otherwise within rounding.
            let direction = match axis {
                0 => [cosine.signum(), 0.0, 0.0],
                1 => [0.0, cosine.signum(), 0.0],
                2 => [0.0, 0.0, cosine.signum()],
                _ => [cosine, sine * angle.cos(), sine * angle.sin()],
            };
            (chosen, direction.map(|along| distance * along))
        })
}

/// The end of a step, if it is between the walls.
fn stepped(center: [f64; 3], step: [f64; 3], extents: [f64; 3]) -> Option<[f64; 3]> {
    let height = center[0] + step[0];
    let across = |axis: usize| wrapped(center[axis] + step[axis], extents[axis]);
    (height >= 0.5 && height <= extents[0] - 0.5).then(|| [height, across(1), across(2)])
}

fn shifted_by_steps(mut value: f64, steps: i32) -> f64 {
    for _ in 0..steps.abs() {
        value = if steps > 0 { value.next_up() } else { value.next_down() };
    }
    value
}

fn position_in([height, width_y, width_z]: [f64; 3]) -> impl Strategy<Value = [f64; 3]> {
    (height_coordinate(height), periodic_coordinate(width_y), periodic_coordinate(width_z))
        .prop_map(|(x, y, z)| [x, y, z])
}

fn extents() -> impl Strategy<Value = [f64; 3]> {
    (
        prop_oneof![prop::sample::select(HEIGHTS.to_vec()), 2.0..30.0_f64],
        prop_oneof![3 => prop::sample::select(WIDTHS.to_vec()), 1 => 3.0..12.0_f64],
        prop_oneof![3 => prop::sample::select(WIDTHS.to_vec()), 1 => 3.0..12.0_f64],
    )
        .prop_map(|(x, y, z)| [x, y, z])
}

fn slab([height, width_y, width_z]: [f64; 3]) -> Slab {
    Slab::new(height, width_y, width_z).unwrap()
}

/// Box, spheres (which may overlap), and points to test.
fn scene() -> impl Strategy<Value = ([f64; 3], Vec<[f64; 3]>, Vec<[f64; 3]>)> {
    extents().prop_flat_map(|extents| {
        (
            Just(extents),
            prop::collection::vec(position_in(extents), 1..40),
            prop::collection::vec(position_in(extents), 60),
        )
    })
}

/// The periodic coordinate in `[0, width)` of `value`, which is at most one width outside.
fn wrapped(value: f64, width: f64) -> f64 {
    let value = if value < 0.0 { value + width } else { value };
    let value = if value >= width { value - width } else { value };
    value.clamp(0.0, width.next_down())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn query_equals_search_over_all_pairs((extents, positions, queries) in scene()) {
        let configuration = configuration_of(extents, &positions);
        assert_consistent(&configuration, &positions);
        for position in queries {
            assert_same_answer(&configuration, &positions, position);
        }
    }

    #[test]
    fn query_near_contact_equals_search_over_all_pairs(
        (extents, positions, _) in scene(),
        steps in prop::collection::vec(step_to_contact(), 60),
    ) {
        let configuration = configuration_of(extents, &positions);
        for (chosen, step) in steps {
            if let Some(query) = stepped(*chosen.get(&positions), step, extents) {
                assert_same_answer(&configuration, &positions, query);
            }
        }
    }

    #[test]
    fn relocation_keeps_the_list_consistent(
        (extents, mut positions, targets) in scene(),
        chosen in prop::collection::vec(any::<prop::sample::Index>(), 60),
    ) {
        let mut configuration = configuration_of(extents, &positions);
        for (sphere, target) in chosen.into_iter().zip(targets) {
            let sphere = sphere.index(positions.len());
            // The sphere that moves must not see itself, but must see all others.
            prop_assert_eq!(
                configuration.overlaps_others(sphere, target),
                overlaps_some_pair(&positions, Some(sphere), configuration.grid.widths, target)
            );
            configuration.relocate(sphere, target);
            positions[sphere] = target;
            assert_consistent(&configuration, &positions);
        }
    }

    #[test]
    fn overlap_is_mutual((extents, positions, _) in scene(), steps in prop::collection::vec(step_to_contact(), 60)) {
        let mut pairs: Vec<_> = positions.windows(2).map(|pair| [pair[0], pair[1]]).collect();
        let touching = steps.into_iter().filter_map(|(chosen, step)| {
            let center = *chosen.get(&positions);
            Some([center, stepped(center, step, extents)?])
        });
        pairs.extend(touching);
        let mut alone = [0, 1].map(|side| configuration_of(extents, &[pairs.first().map_or(positions[0], |pair| pair[side])]));
        for pair in pairs {
            let [first, second] = &mut alone;
            first.relocate(0, pair[0]);
            second.relocate(0, pair[1]);
            // Exactly: a move and its reverse must be judged alike.
            prop_assert_eq!(first.overlapping(pair[1]).is_some(), second.overlapping(pair[0]).is_some());
        }
    }
}

#[test]
fn touching_is_not_overlapping_along_any_axis_or_edge() {
    for width in [3.0, 3.5, 4.0, 5.25, 16.0] {
        let slab = slab([8.0, width, width]);
        let centers = [
            ([2.0, 1.0, 1.0], [3.0, 1.0, 1.0]),
            ([2.0, 1.0, 1.0], [2.0, 2.0, 1.0]),
            ([2.0, 1.0, 1.0], [2.0, 1.0, 2.0]),
            ([2.0, 0.25, 1.0], [2.0, width - 0.75, 1.0]),
            ([2.0, 1.0, 0.25], [2.0, 1.0, width - 0.75]),
            ([2.0, 0.0, 1.0], [2.0, width - 1.0, 1.0]),
            ([2.0, -0.0, 0.0], [2.0, 0.0, width - 1.0]),
            ([7.5, 1.0, 1.0], [6.5, 1.0, 1.0]),
            ([0.5, 1.0, 1.0], [1.5, 1.0, 1.0]),
        ];
        for (first, second) in centers {
            let axis = (0..3).find(|&axis| (first[axis] - second[axis]).abs() > 0.5).unwrap();
            // Nearer across the edge means farther along the axis.
            let inwards = (first[axis] - second[axis]).signum();
            let across = (first[axis] - second[axis]).abs() > 1.5;
            for (change, overlap) in [(0.0, false), (1e-12, true), (-1e-12, false)] {
                let mut configuration = Configuration::empty(slab);
                configuration.push(first);
                let mut moved = second;
                moved[axis] += if across { -inwards * change } else { inwards * change };
                assert_eq!(
                    configuration.overlapping(moved).is_some(),
                    overlap,
                    "{first:?} and {moved:?} in width {width}"
                );
            }
        }
    }
}

#[test]
fn spheres_either_side_of_a_periodic_edge_meet() {
    for width in WIDTHS {
        let slab = slab([4.0, width, width]);
        for first in [[1.0, 0.0, 0.0], [1.0, -0.0, -0.0], [1.0, f64::MIN_POSITIVE, 1e-17]] {
            for second in [[1.0, width.next_down(), 0.0], [1.9, width.next_down(), width.next_down()]] {
                let mut configuration = Configuration::empty(slab);
                configuration.push(first);
                let (sphere, distance) = configuration.overlapping(second).expect("the two overlap");
                assert_eq!(sphere, 0);
                approx::assert_abs_diff_eq!(distance, second[0] - first[0], epsilon = 1e-12);
            }
        }
    }
}

#[test]
fn cells_are_wide_enough_at_their_rounded_edges() {
    // Of two points whose cells are not neighbors, no rounding may put one less than a diameter
    // from the other. The danger is an extent just above an integer, and most of all a tall one.
    for integer in [4.0, 5.0, 64.0, 400.0, 4096.0, 99_999.0] {
        for excess in [0.0, 1e-15, 1e-14, 1e-13, 1e-12, 3e-12, 1e-11, 3e-11, 1e-10, 1e-9, 1e-8] {
            let height = integer * (1.0 + excess);
            let grid = Grid::new(&slab([height, 3.0, 3.0]));
            let layer_of = |height: f64| grid.spot([height, 1.0, 1.0]).layer as usize;
            // The lowest height that belongs to a cell.
            let lowest_of = |cell: usize| {
                let mut edge = cell as f64 * grid.sides[0];
                while layer_of(edge) >= cell {
                    edge = edge.next_down();
                }
                while layer_of(edge) < cell {
                    edge = edge.next_up();
                }
                edge
            };
            let cells = grid.cells[0];
            for cell in 1..cells - 1 {
                let (highest_below, lowest_above) = (lowest_of(cell).next_down(), lowest_of(cell + 1));
                assert!(
                    lowest_above - highest_below >= 1.0,
                    "heights {highest_below} and {lowest_above} are two cells apart in a slab of {height}"
                );
            }
        }
    }
}

#[test]
fn dense_cells_chain_pages() {
    // Sides of 1.33 diameters: the middle cell takes eight spheres that do not overlap.
    let slab = slab([3.99, 3.99, 3.99]);
    let mut configuration = Configuration::empty(slab);
    let ends = [1.34, 2.65];
    let mut positions = Vec::new();
    for x in ends {
        for y in ends {
            for z in ends {
                let position = [x, y, z];
                assert!(configuration.overlapping(position).is_none());
                configuration.push(position);
                positions.push(position);
                assert_consistent(&configuration, &positions);
            }
        }
    }
    // All in one cell: two full pages, chained.
    let (cell, layer) = (configuration.grid.cell(1, 1), &configuration.layers[2]);
    assert_eq!(layer.indices_in(cell).count(), 8);
    assert_eq!(layer.heads[cell] & 1, 1);
    // Take the spheres out one by one, and put them back.
    for target in [0.5, 1.34] {
        for sphere in 0..4 {
            let mut position = positions[sphere];
            position[0] = target;
            assert!(!configuration.overlaps_others(sphere, position));
            configuration.relocate(sphere, position);
            positions[sphere] = position;
            assert_consistent(&configuration, &positions);
        }
    }
}

#[test]
fn face_centered_crystal_is_free_of_overlaps_at_contact_and_full_below() {
    // Conventional cells of side sqrt 2: touching neighbors, three cells across.
    let side = 2.0_f64.sqrt() * (1.0 + 1e-14);
    let width = 3.0 * side;
    let slab = slab([width + 1.0, width, width]);
    let basis = [[0.0, 0.0, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5], [0.5, 0.5, 0.0]];
    let mut positions = Vec::new();
    for cell in 0..27 {
        let origin = [cell / 9, cell / 3 % 3, cell % 3];
        for offset in basis {
            let along = |axis: usize| (f64::from(origin[axis]) + offset[axis]) * side;
            positions.push([0.5 + along(0), along(1), along(2)]);
        }
    }
    let mut configuration = Configuration::empty(slab);
    for (sphere, &position) in positions.iter().enumerate() {
        assert!(configuration.overlapping(position).is_none(), "sphere {sphere}");
        configuration.push(position);
    }
    assert_consistent(&configuration, &positions);
    for (sphere, &[x, y, z]) in positions.iter().enumerate() {
        assert!(!configuration.overlaps_others(sphere, [x, y, z]));
        // Jammed: inside the crystal any step of 1e-9 overlaps.
        if x > 1.0 && x < width - 0.5 {
            for step in [1e-9, -1e-9] {
                assert!(configuration.overlaps_others(sphere, [x + step, y, z]));
                assert!(configuration.overlaps_others(sphere, [x, wrapped(y + step, width), z]));
                assert!(configuration.overlaps_others(sphere, [x, y, wrapped(z + step, width)]));
            }
        }
    }
}
