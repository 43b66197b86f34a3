//! Columns along the axis of the chains, in which spheres are looked up.

/// Columns at least one diameter wide.
#[derive(Debug, Clone, Copy)]
pub(super) struct Columns {
    origins: [f64; 2],
    sides: [f64; 2],
    inverse_sides: [f64; 2],
    counts: [usize; 2],
    /// Periods of the coordinates across the axis; `None` where they are not periodic.
    repeats: [Option<f64>; 2],
}

impl Columns {
    pub(super) fn new(extents: [[f64; 2]; 2], repeats: [Option<f64>; 2]) -> Self {
        /// A margin for rounding, also in single precision.
        const SIDE: f64 = 1.0 + 1e-5;
        let origins = extents.map(|[origin, _]| origin);
        // Extents are at most 1e6.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let counts = extents.map(|[_, extent]| ((extent / SIDE) as usize).max(1));
        let sides = [0, 1].map(|axis| extents[axis][1] / counts[axis] as f64);
        let inverse_sides = sides.map(|side| 1.0 / side);
        Self { origins, sides, inverse_sides, counts, repeats }
    }

    pub(super) fn count(&self) -> usize {
        self.counts[0] * self.counts[1]
    }

    #[inline]
    pub(super) fn column(&self, across: [f64; 2]) -> u32 {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let [first, second] = [0, 1].map(|axis| {
            let column = ((across[axis] - self.origins[axis]) * self.inverse_sides[axis]) as usize;
            column.min(self.counts[axis] - 1)
        });
        #[allow(clippy::cast_possible_truncation)]
        let column = (first * self.counts[1] + second) as u32;
        column
    }

    /// Coordinates across the axis, relative to the corner of a column.
    #[inline]
    // Single precision is meant.
    #[allow(clippy::cast_possible_truncation)]
    pub(super) fn relative(&self, column: u32, across: [f64; 2]) -> [f32; 2] {
        let at = [column as usize / self.counts[1], column as usize % self.counts[1]];
        [0, 1].map(|axis| (across[axis] - self.origins[axis] - at[axis] as f64 * self.sides[axis]) as f32)
    }

    /// Squared distance across the axis.
    #[inline]
    pub(super) fn squared_distance(&self, a: [f64; 2], b: [f64; 2]) -> f64 {
        let [first, second] = [0, 1].map(|axis| {
            let distance = (a[axis] - b[axis]).abs();
            self.repeats[axis].map_or(distance, |period| distance.min(period - distance))
        });
        first * first + second * second
    }

    /// The neighborhood of each column.
    pub(super) fn all_around(&self, all: &mut Vec<Around>) {
        all.clear();
        all.reserve(self.count());
        for first in 0..self.counts[0] {
            for second in 0..self.counts[1] {
                all.push(self.around([first, second]));
            }
        }
    }

    fn around(&self, at: [usize; 2]) -> Around {
        let mut around = Around { columns: [(0, 0); 9], count: 0 };
        for shift in 0..9_u8 {
            // One column down (0), the same (1), or one up (2) along each axis.
            let steps = [shift / 3, shift % 3];
            let [first, second] = [0, 1].map(|axis: usize| {
                let (to, count) = (at[axis] + usize::from(steps[axis]), self.counts[axis]);
                let inside = to >= 1 && to <= count;
                (inside || self.repeats[axis].is_some()).then_some((to + count - 1) % count)
            });
            if let (Some(first), Some(second)) = (first, second) {
                // The number of columns fits a u32.
                #[allow(clippy::cast_possible_truncation)]
                let column = (first * self.counts[1] + second) as u32;
                around.columns[around.count] = (column, shift);
                around.count += 1;
            }
        }
        around
    }

    /// Shift from coordinates relative to a column to those relative to its neighbor.
    #[inline]
    // Single precision is meant.
    #[allow(clippy::cast_possible_truncation)]
    pub(super) fn shift(&self, shift: u8) -> [f32; 2] {
        [(shift / 3, self.sides[0]), (shift % 3, self.sides[1])]
            .map(|(step, side)| (1.0 - f32::from(step)) * side as f32)
    }
}

/// A column and its neighbors.
#[derive(Debug, Clone, Copy)]
pub(super) struct Around {
    /// The number of each, and its direction for [`Columns::shift`].
    columns: [(u32, u8); 9],
    count: usize,
}

impl Around {
    /// Each column, and its direction for [`Columns::shift`].
    #[inline]
    pub(super) fn iter(&self) -> impl Iterator<Item = (usize, u8)> {
        self.columns[..self.count].iter().map(|&(column, shift)| (column as usize, shift))
    }
}
