//! Positions of the spheres, and the invariants that every move keeps: no two overlap, all are inside.

use crate::cell_list::{CellList, Contact};
use crate::{Error, Slab};

/// Positions indexed by sphere, with a cell list that is always up to date.
#[derive(Debug, Clone)]
pub(crate) struct Configuration {
    slab: Slab,
    positions: Vec<[f64; 3]>,
    cells: CellList,
}

impl Configuration {
    /// A configuration without spheres.
    pub(crate) fn empty(slab: Slab) -> Self {
        Self { slab, positions: Vec::new(), cells: CellList::new(&slab) }
    }

    /// Checks positions and takes them over.
    pub(crate) fn new(slab: Slab, positions: &[[f64; 3]]) -> Result<Self, Error> {
        let mut configuration = Self::empty(slab);
        let [width_y, width_z] = slab.widths();
        let bounds =
            [('x', slab.lowest_center(), slab.highest_center()), ('y', 0.0, width_y), ('z', 0.0, width_z)];
        for (index, &position) in positions.iter().enumerate() {
            for (value, (axis, lowest, highest)) in position.into_iter().zip(bounds) {
                // A NaN fails the comparison too.
                if !(value >= lowest && value <= highest) {
                    return Err(Error::OutsideSlab { index, axis, value, lowest, highest });
                }
            }
            let position = [position[0], wrap(position[1], width_y), wrap(position[2], width_z)];
            if let Some((first, distance)) = configuration.cells.overlapping(position) {
                return Err(Error::Overlap { first, second: index, distance });
            }
            configuration.push(position);
        }
        Ok(configuration)
    }

    /// Adds a sphere if there is room for it.
    pub(crate) fn try_push(&mut self, position: [f64; 3]) -> bool {
        let free = self.cells.overlapping(position).is_none();
        if free {
            self.push(position);
        }
        free
    }

    fn push(&mut self, position: [f64; 3]) {
        self.cells.insert(position);
        self.positions.push(position);
    }

    pub(crate) fn slab(&self) -> &Slab {
        &self.slab
    }

    pub(crate) fn len(&self) -> usize {
        self.positions.len()
    }

    pub(crate) fn positions(&self) -> &[[f64; 3]] {
        &self.positions
    }

    #[inline]
    pub(crate) fn position(&self, sphere: usize) -> [f64; 3] {
        self.positions[sphere]
    }

    /// Whether `sphere`, moved to `position` (wrapped, inside), would overlap another.
    #[inline]
    pub(crate) fn overlaps(&self, sphere: usize, position: [f64; 3]) -> bool {
        self.cells.overlaps(sphere, position)
    }

    /// The first sphere that `sphere` touches on its way along `axis`; see [`CellList::first_contact`].
    #[inline]
    pub(crate) fn first_contact(
        &self,
        sphere: usize,
        axis: usize,
        forward: bool,
        limit: f64,
    ) -> Option<Contact> {
        self.cells.first_contact(sphere, self.positions[sphere], axis, forward, limit)
    }

    /// Moves `sphere` to a position that was found free.
    #[inline]
    pub(crate) fn relocate(&mut self, sphere: usize, position: [f64; 3]) {
        self.cells.relocate(sphere, self.positions[sphere], position);
        self.positions[sphere] = position;
    }
}

/// The coordinate in `[0, width)` that `value`, less than one width outside, stands for.
#[inline]
pub(crate) fn wrap(value: f64, width: f64) -> f64 {
    let wrapped = if value < 0.0 {
        value + width
    } else if value >= width {
        value - width
    } else {
        value
    };
    // A negative number below the resolution of `width` rounds up to it.
    if wrapped < width { wrapped } else { 0.0 }
}
