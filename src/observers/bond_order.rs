//! Classification of spheres as fcc, hcp or fluid.

use super::neighbors::Neighbors;
use super::steinhardt::{CubicInvariant, Harmonics};
use crate::Slab;
use nalgebra::Vector3;

/// Local structure around a sphere.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Structure {
    /// Face-centered cubic crystal, with layers stacked as ABC.
    FaceCenteredCubic,
    /// Hexagonal close-packed crystal, with layers stacked as ABA.
    HexagonalClosePacked,
    /// No crystal.
    Fluid,
}

/// Bond-orientational order around every sphere of a configuration, to classify spheres as fcc, hcp
/// or fluid.
///
/// It uses the invariants q₆ and w₄ of Steinhardt, Nelson and Ronchetti
/// (doi:10.1103/PhysRevB.28.784) for the bonds to the twelve nearest spheres, after averaging the
/// harmonics over the sphere and these twelve (Lechner and Dellago, doi:10.1063/1.2977970). A
/// sphere is crystalline if the averaged q₆ is above 0.3; it is then fcc if the averaged w₄ is
/// below −0.04, and hcp otherwise.
///
/// # Accuracy
/// In a crystal of mixed stacking the averages depend on the neighboring layers. A perfect hcp
/// layer has w₄ = 0.134 between hcp layers, 0.05 between an fcc and an hcp layer, and 0.01 between
/// an fcc layer and a wall; a perfect fcc layer has −0.159 between fcc layers and −0.103 between
/// hcp layers. The limit −0.04 is between these values; a limit of 0 is right only for a pure fcc
/// or hcp crystal.
///
/// Fraction of spheres classified correctly, measured in crystals of hard spheres with six
/// stackings, including faults and random stacking:
///
/// | packing fraction | fcc layers between fcc, mixed, hcp | hcp layers between hcp, fcc, mixed | second layer at a wall, worst case |
/// |---|---|---|---|
/// | 0.545 (melting) | 100, 99.8, 94.5 % right | 100, 99.9, 98.3 % | 90 % |
/// | 0.58 | 100, 100, 99.5 % | 100, 100, 99.97 % | 94 % |
/// | 0.64 | all | all | 99.9 % |
///
/// In a fluid just below freezing (P/T = 10 to 11) q₆ is above 0.3 for less than 0.5 % of the
/// spheres, and for 1 % in the second layer at a wall. In crystals at melting it is below 0.3 for
/// less than 0.1 %. For comparison, in the same crystals at melting, adaptive common-neighbor
/// analysis (doi:10.1088/0965-0393/20/4/045021) recognizes only two thirds of the spheres, and w₄
/// without averaging classifies a quarter of the hcp spheres as fcc.
///
/// # At the walls
/// The spheres of the layer at a wall (centers within half a diameter of contact) have no neighbors
/// on one side. They are not classified and not used in the averages of others; use
/// [`HexaticOrder`](super::HexaticOrder) for them. The second layer has all its neighbors and is
/// classified.
///
/// ```
/// use gradient_mc::observers::{BondOrder, Structure};
/// use gradient_mc::start::ClosePacked;
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// let slab = Slab::new(20.0, 8.0, 7.0)?;
/// let scene = Scene::new(slab, 448, UniformField::default(), Isothermal::new(0.1)?)?;
/// let simulation = Simulation::builder(scene).start(ClosePacked).build()?;
/// let mut order = BondOrder::new(&slab);
/// order.gather(simulation.positions());
/// let crystalline = |sphere: &usize| {
///     order.structure(*sphere).is_some_and(|structure| structure != Structure::Fluid)
/// };
/// assert!((0..448).filter(crystalline).count() > 250);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct BondOrder {
    slab: Slab,
    neighbors: Neighbors,
    cubic: CubicInvariant,
    /// The `NEAREST` nearest spheres of every sphere; missing ones are the sphere itself.
    nearest: Vec<[usize; NEAREST]>,
    /// Whether the sphere has twelve neighbors within the search radius.
    surrounded: Vec<bool>,
    at_wall: Vec<bool>,
    harmonics: Vec<Harmonics>,
    candidates: Vec<(f64, usize, Vector3<f64>)>,
}

/// Number of neighbors in close packing.
const NEAREST: usize = 12;
/// Search radius in diameters. The twelve nearest spheres are farther away only at packing
/// fractions well below those of a crystal. All slabs are at least twice as wide.
const RADIUS: f64 = 1.5;
/// Averaged q₆ above which a sphere is in a crystal.
const LEAST_CRYSTALLINE: f64 = 0.3;
/// Averaged w₄ below which a crystal is fcc.
const LARGEST_CUBIC: f64 = -0.04;
/// Spheres closer to wall contact than this, in diameters, are not classified.
const WALL_LAYER: f64 = 0.5;

impl BondOrder {
    /// Makes an analyzer for configurations in `slab`.
    #[must_use]
    pub fn new(slab: &Slab) -> Self {
        Self {
            slab: *slab,
            // The radius is at most half the width of any slab.
            neighbors: Neighbors::unchecked(slab, RADIUS),
            cubic: CubicInvariant::new(),
            nearest: Vec::new(),
            surrounded: Vec::new(),
            at_wall: Vec::new(),
            harmonics: Vec::new(),
            candidates: Vec::new(),
        }
    }

    /// Analyzes a configuration, given the positions of all its spheres. It replaces the previous
    /// one.
    pub fn gather(&mut self, positions: impl IntoIterator<Item = Vector3<f64>>) {
        let (lowest, highest) =
            (self.slab.lowest_center() + WALL_LAYER, self.slab.highest_center() - WALL_LAYER);
        let at_wall = &mut self.at_wall;
        at_wall.clear();
        self.neighbors.gather(positions.into_iter().inspect(|position| {
            at_wall.push(!(lowest..=highest).contains(&position.x));
        }));
        self.nearest.clear();
        self.surrounded.clear();
        self.harmonics.clear();
        for sphere in 0..self.neighbors.count() {
            self.candidates.clear();
            self.candidates.extend(
                self.neighbors.of(sphere).map(|neighbor| {
                    (neighbor.separation.norm_squared(), neighbor.index, neighbor.separation)
                }),
            );
            self.surrounded.push(self.candidates.len() >= NEAREST);
            if self.candidates.len() > NEAREST {
                // Equal distances are ordered by number, so the result does not depend on the order
                // of the search.
                let order =
                    |a: &(f64, usize, _), b: &(f64, usize, _)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
                self.candidates.select_nth_unstable_by(NEAREST - 1, order);
                self.candidates.truncate(NEAREST);
            }
            let mut nearest = [sphere; NEAREST];
            let mut sum = Harmonics::default();
            for (place, (squared, index, separation)) in nearest.iter_mut().zip(&self.candidates) {
                *place = *index;
                if *squared > 0.0 {
                    sum.add_bond(separation);
                }
            }
            let mut harmonics = Harmonics::default();
            harmonics.add(&sum, 1.0 / NEAREST as f64);
            self.nearest.push(nearest);
            self.harmonics.push(harmonics);
        }
    }

    /// Number of spheres in the configuration.
    #[must_use]
    pub fn count(&self) -> usize {
        self.harmonics.len()
    }

    /// Harmonics averaged over a sphere and its nearest spheres, without those at a wall.
    fn averaged(&self, sphere: usize) -> Option<Harmonics> {
        if self.at_wall.get(sphere).is_none_or(|&at_wall| at_wall) {
            return None;
        }
        let mut sum = self.harmonics[sphere];
        let mut count = 1.0;
        for &near in self.nearest[sphere].iter().filter(|&&near| near != sphere && !self.at_wall[near]) {
            sum.add(&self.harmonics[near], 1.0);
            count += 1.0;
        }
        let mut averaged = Harmonics::default();
        averaged.add(&sum, 1.0 / count);
        Some(averaged)
    }

    /// Averaged q₄, q₆ and w₄ of a sphere; `None` for a sphere at a wall or an index beyond the
    /// last.
    #[must_use]
    pub fn invariants(&self, sphere: usize) -> Option<[f64; 3]> {
        let averaged = self.averaged(sphere)?;
        Some([averaged.q4(), averaged.q6(), self.cubic.of(&averaged)])
    }

    /// Structure around a sphere; `None` for a sphere at a wall or an index beyond the last.
    #[must_use]
    pub fn structure(&self, sphere: usize) -> Option<Structure> {
        Some(self.order(sphere)?.1)
    }

    /// Averaged q₆ and structure of a sphere.
    pub(super) fn order(&self, sphere: usize) -> Option<(f64, Structure)> {
        let averaged = self.averaged(sphere)?;
        let q6 = averaged.q6();
        let structure = if !self.surrounded[sphere] || q6 < LEAST_CRYSTALLINE {
            Structure::Fluid
        } else if self.cubic.of(&averaged) < LARGEST_CUBIC {
            Structure::FaceCenteredCubic
        } else {
            Structure::HexagonalClosePacked
        };
        Some((q6, structure))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    /// Close-packed layers with nearest distance `spacing`, stacked by the letters, with random
    /// displacements of up to `jitter` along each axis.
    fn stacked(letters: &str, spacing: f64, jitter: f64) -> (Slab, Vec<Vector3<f64>>) {
        let (columns, rows) = (6, 4);
        let row = spacing * 3.0_f64.sqrt();
        let distance = spacing * (2.0_f64 / 3.0).sqrt();
        let layers = letters.len() as f64;
        let widths = [f64::from(columns) * spacing, f64::from(rows) * row];
        // Both walls are in the layers next to them.
        let slab = Slab::new(1.0 + (layers - 1.0) * distance + jitter, widths[0], widths[1]).unwrap();
        let mut generator = Pcg64Mcg::seed_from_u64(7);
        let mut positions = Vec::new();
        for (layer, letter) in letters.bytes().enumerate() {
            let shift = f64::from(letter - b'A') * row / 3.0;
            for (column, line) in (0..columns).flat_map(|column| (0..rows).map(move |line| (column, line))) {
                for half in [0.0, 0.5] {
                    let site = Vector3::new(
                        0.5 + layer as f64 * distance,
                        (f64::from(column) + half) * spacing,
                        (f64::from(line) + half) * row + shift,
                    );
                    let noise =
                        Vector3::from([(); 3].map(|()| jitter * (2.0 * generator.random::<f64>() - 1.0)));
                    let mut position = site + noise;
                    position.x = position.x.clamp(0.5, slab.highest_center());
                    for axis in 0..2 {
                        position[axis + 1] = position[axis + 1].rem_euclid(widths[axis]);
                    }
                    positions.push(position);
                }
            }
        }
        (slab, positions)
    }

    /// Fraction of correctly classified spheres in all layers between two others.
    fn recognized(letters: &str, spacing: f64, jitter: f64) -> f64 {
        let (slab, positions) = stacked(letters, spacing, jitter);
        let mut order = BondOrder::new(&slab);
        order.gather(positions);
        let letters = letters.as_bytes();
        let per_layer = order.count() / letters.len();
        let (mut right, mut all) = (0.0, 0.0);
        for layer in 0..letters.len() {
            for sphere in layer * per_layer..(layer + 1) * per_layer {
                let structure = order.structure(sphere);
                if layer == 0 || layer + 1 == letters.len() {
                    // So much noise takes spheres out of their layer.
                    assert!(jitter > 0.2 || structure.is_none());
                } else {
                    let expected = if letters[layer - 1] == letters[layer + 1] {
                        Structure::HexagonalClosePacked
                    } else {
                        Structure::FaceCenteredCubic
                    };
                    right += f64::from(u8::from(structure == Some(expected)));
                    all += 1.0;
                }
            }
        }
        right / all
    }

    /// Every surrounding of a layer by two on each side occurs in these.
    const STACKINGS: [&str; 6] =
        ["ABCABCABCABC", "ABABABABABAB", "ABACABACABAC", "ABCABCBACBAC", "ABCBABACBCAC", "ACBCABABCBCB"];

    #[test]
    fn perfect_crystals_and_faults_of_stacking_are_recognized() {
        for letters in STACKINGS {
            for spacing in [1.0, 1.11] {
                let right = recognized(letters, spacing, 1e-4);
                assert!(right > 0.999_999, "{letters}: {right}");
            }
        }
    }

    /// Independent displacements, which disturb bonds more than those of a crystal, where neighbors
    /// move together; for these see `tests/suite/structure.rs`.
    #[test]
    fn crystals_with_noise_are_recognized() {
        for letters in STACKINGS {
            let right = recognized(letters, 1.1, 0.1);
            assert!(right > 0.98, "{letters}: {right}");
        }
        // Noise that destroys the crystal.
        assert!(recognized(STACKINGS[0], 1.1, 0.6) < 0.05);
    }

    #[test]
    fn invariants_are_those_of_the_lattice_and_a_gas_is_a_fluid() {
        let (slab, positions) = stacked("ABCABCABCABC", 1.1, 0.0);
        let mut order = BondOrder::new(&slab);
        order.gather(positions);
        let invariants = order.invariants(order.count() / 2).unwrap();
        for (value, expected) in invariants.into_iter().zip([0.190_941, 0.574_524, -0.159_317]) {
            assert!((value - expected).abs() < 1e-6, "{value} instead of {expected}");
        }
        assert_eq!((order.structure(order.count()), order.invariants(0)), (None, None));
        order.gather((0..8).map(|sphere| Vector3::new(2.0 + 0.9 * f64::from(sphere), 1.0, 1.0)));
        assert!((0..8).all(|sphere| order.structure(sphere) == Some(Structure::Fluid)));
        // Coincident points, which ideal particles may be, have no direction.
        order.gather([Vector3::new(3.0, 1.0, 1.0); 14]);
        assert_eq!(order.structure(3), Some(Structure::Fluid));
        order.gather([]);
        assert_eq!(order.count(), 0);
    }
}
