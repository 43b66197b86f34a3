//! Pages: spheres of a cell in the form used by the search for overlaps.

use wide::{f32x4, u32x4};

/// Spheres per page.
pub(super) const SLOTS: usize = 4;
/// Code for "no sphere".
pub(crate) const NOBODY: u32 = u32::MAX;
/// All slots of a page, one bit for each.
const ALL: u32 = (1 << SLOTS) - 1;
/// Coordinate of an empty slot: out of reach of every sphere, so that all slots of a page are
/// tested.
pub(super) const NOWHERE: f32 = 1e9;

/// Up to four spheres of one cell, in one cache line.
///
/// Coordinates are relative to the cell and in single precision. They show which pairs certainly
/// overlap, which certainly do not, and which must be decided in double precision.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct Page {
    pub(super) x: f32x4,
    pub(super) y: f32x4,
    pub(super) z: f32x4,
    /// The spheres, as [`Layer::occupant`] writes them.
    pub(super) occupants: u32x4,
}

impl Page {
    pub(super) const EMPTY: Self = Self {
        x: f32x4::new([NOWHERE; SLOTS]),
        y: f32x4::new([0.0; SLOTS]),
        z: f32x4::new([0.0; SLOTS]),
        occupants: u32x4::new([NOBODY; SLOTS]),
    };

    #[inline]
    pub(super) fn set(&mut self, slot: usize, occupant: u32, [x, y, z]: [f32; 3]) {
        self.x.as_mut_array()[slot] = x;
        self.y.as_mut_array()[slot] = y;
        self.z.as_mut_array()[slot] = z;
        self.occupants.as_mut_array()[slot] = occupant;
    }

    #[inline]
    pub(super) fn clear(&mut self, slot: usize) {
        self.x.as_mut_array()[slot] = NOWHERE;
        self.occupants.as_mut_array()[slot] = NOBODY;
    }

    /// Which slots hold `occupant`, one bit for each.
    #[inline]
    fn slots_of(&self, occupant: u32) -> u32 {
        self.occupants.simd_eq(u32x4::splat(occupant)).to_bitmask()
    }

    #[inline]
    pub(super) fn is_empty(&self) -> bool {
        self.slots_of(NOBODY) == ALL
    }

    /// A slot that holds `occupant`.
    #[inline]
    pub(super) fn slot_of(&self, occupant: u32) -> Option<usize> {
        let slots = self.slots_of(occupant);
        (slots != 0).then_some(slots.trailing_zeros() as usize)
    }

    /// A very large number in the slot of `occupant`, zero in the others.
    #[inline]
    pub(super) fn masked(&self, occupant: u32x4) -> f32x4 {
        let slots: f32x4 = bytemuck::cast(self.occupants.simd_eq(occupant));
        slots & f32x4::splat(NOWHERE)
    }
}
