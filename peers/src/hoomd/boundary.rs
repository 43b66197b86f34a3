//! hoomd-mc's boundaries are closed or periodic along all axes; this one is ours: walls along the first
//! axis, periodic along the others. Wrapping is cheaper than in hoomd-mc's own `Periodic`, which divides.

use arrayvec::ArrayVec;
use hoomd_mc::{Cover, HypercuboidCheckerboard};
use hoomd_microstate::boundary::{Error, GenerateGhosts, MAX_GHOSTS, Wrap};
use hoomd_microstate::property::Position;
use hoomd_utility::valid::PositiveReal;
use hoomd_vector::Cartesian;
use rand::Rng;

const WALLED: usize = 0;
const PERIODIC: [usize; 2] = [1, 2];
const RANGE: f64 = 1.0;

/// A slab around the origin.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WalledSlab {
    pub(crate) edges: [PositiveReal; 3],
    /// Largest distance of a center from the middle.
    farthest: f64,
    half_edges: [f64; 3],
}

impl WalledSlab {
    pub(crate) fn new(size: [f64; 3]) -> Result<Self, crate::Failure> {
        let [height, width_y, width_z] = size;
        let edges = [height.try_into()?, width_y.try_into()?, width_z.try_into()?];
        Ok(Self { edges, farthest: 0.5 * (height - 1.0), half_edges: size.map(|edge| 0.5 * edge) })
    }
}

impl<P: Position<Position = Cartesian<3>>> Wrap<P> for WalledSlab {
    #[inline]
    fn wrap(&self, mut properties: P) -> Result<P, Error> {
        let position = properties.position_mut();
        if position[WALLED].abs() > self.farthest {
            return Err(Error::CannotWrapProperties);
        }
        for axis in PERIODIC {
            if position[axis] >= self.half_edges[axis] {
                position[axis] -= self.edges[axis].get();
            } else if position[axis] < -self.half_edges[axis] {
                position[axis] += self.edges[axis].get();
            }
        }
        Ok(properties)
    }
}

impl<S: Position<Position = Cartesian<3>> + Copy> GenerateGhosts<S> for WalledSlab {
    fn maximum_interaction_range(&self) -> f64 {
        RANGE
    }

    #[inline]
    fn generate_ghosts(&self, site: &S) -> ArrayVec<S, MAX_GHOSTS> {
        let mut ghosts = ArrayVec::new();
        let shifts = PERIODIC.map(|axis| {
            let coordinate = site.position()[axis];
            if coordinate > self.half_edges[axis] - RANGE {
                -self.edges[axis].get()
            } else if coordinate < -self.half_edges[axis] + RANGE {
                self.edges[axis].get()
            } else {
                0.0
            }
        });
        let mut push = |shift_y: f64, shift_z: f64| {
            let mut ghost = *site;
            ghost.position_mut()[PERIODIC[0]] += shift_y;
            ghost.position_mut()[PERIODIC[1]] += shift_z;
            ghosts.push(ghost);
        };
        let near = shifts.map(|shift| shift != 0.0);
        if near[0] {
            push(shifts[0], 0.0);
        }
        if near[1] {
            push(0.0, shifts[1]);
        }
        if near[0] && near[1] {
            push(shifts[0], shifts[1]);
        }
        ghosts
    }
}

impl Cover<Cartesian<3>> for WalledSlab {
    type Checkerboard = HypercuboidCheckerboard<3>;

    fn cover<R: Rng + ?Sized>(&self, rng: &mut R, interaction_range: PositiveReal) -> Self::Checkerboard {
        HypercuboidCheckerboard::new(rng, interaction_range, self.edges, [false, true, true])
    }

    fn cover_into<R: Rng + ?Sized>(
        &self,
        checkerboard: &mut Self::Checkerboard,
        rng: &mut R,
        interaction_range: PositiveReal,
    ) {
        checkerboard.update(rng, interaction_range, self.edges, [false, true, true]);
    }
}
