//! The part of a configuration stored in checkpoints.

use super::layer::Sphere;
use super::page::NOBODY;
use super::{Configuration, Grid, most_in_a_layer};
use crate::Error;
use crate::checkpoint::Archive;

/// A layer in a checkpoint. Moves pick spheres by their index in the layer, and gaps are filled in
/// a fixed order, so both are stored. Cells and pages follow from the positions.
#[derive(Default, serde::Serialize, serde::Deserialize)]
struct SavedLayer {
    /// Number of the sphere at each index, plus one; 0 in a gap.
    numbers: Vec<u32>,
    /// Positions of the spheres, in this order.
    positions: Vec<[f64; 3]>,
    /// Gaps in the order in which they are filled.
    gaps: Vec<u32>,
}

impl Configuration {
    pub(crate) fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Writes `particles` spheres, or reads so many into an empty configuration; see
    /// [`Persist`](crate::checkpoint::Persist).
    pub(crate) fn persist(&mut self, archive: &mut Archive<'_>, particles: usize) -> Result<(), Error> {
        let reads = archive.is_reading();
        let mut found = vec![false; if reads { particles } else { 0 }];
        for number in 1..self.layers.len() - 1 {
            let mut saved = if reads { SavedLayer::default() } else { self.saved(number) };
            archive.value("layer", &mut saved)?;
            archive.check(!reads || self.restore(number, &saved, &mut found).is_some())?;
        }
        if reads {
            self.len = particles;
        }
        archive.check(found.into_iter().all(|found| found))
    }

    fn saved(&self, number: usize) -> SavedLayer {
        let layer = &self.layers[number];
        let spheres = || layer.spheres.iter().filter(|sphere| sphere.number != NOBODY);
        let gap = |index: u32| (index != NOBODY).then_some(index);
        SavedLayer {
            // A gap has the largest number.
            numbers: layer.spheres.iter().map(|sphere| sphere.number.wrapping_add(1)).collect(),
            positions: spheres().map(|sphere| sphere.position).collect(),
            gaps: std::iter::successors(gap(layer.gap), |&index| gap(layer.spheres[index as usize].cell))
                .collect(),
        }
    }

    /// Fills an empty layer; `None` if the data are invalid. `found` marks the spheres found so
    /// far.
    fn restore(&mut self, number: usize, saved: &SavedLayer, found: &mut [bool]) -> Option<()> {
        /// Marks a gap that is not in the list yet.
        const UNLISTED: u32 = NOBODY - 1;
        let SavedLayer { numbers, positions, gaps } = saved;
        let all = positions.len() + gaps.len();
        // There are no more places than there were spheres at some time.
        (numbers.len() == all && all <= most_in_a_layer(&self.slab, &self.grid)).then_some(())?;
        let gap = Sphere { position: [0.0; 3], number: NOBODY, cell: UNLISTED };
        self.layers[number].spheres.resize(all, gap);
        let widths = self.slab.widths();
        let mut positions = positions.iter();
        for (index, sphere) in (0..).zip(numbers.iter().map(|number| number.wrapping_sub(1))) {
            if sphere == NOBODY {
                continue;
            }
            if std::mem::replace(found.get_mut(sphere as usize)?, true) {
                return None;
            }
            let &position = positions.next()?;
            let inside = (self.slab.lowest_center()..=self.slab.highest_center()).contains(&position[0])
                && (0.0..widths[0]).contains(&position[1])
                && (0.0..widths[1]).contains(&position[2]);
            // The cell is defined only inside.
            let spot = inside.then(|| self.grid.spot(position))?;
            if spot.layer as usize + 1 != number || self.overlaps(NOBODY, position) {
                return None;
            }
            let site = self.grid.site(&spot, position);
            let layer = &mut self.layers[number];
            layer.spheres[index as usize] = Sphere { position, number: sphere, cell: site.cell };
            layer.enter(&self.grid, &site, index);
        }
        let layer = &mut self.layers[number];
        // From the last, which nothing follows, to the first.
        for &index in gaps.iter().rev() {
            let gap = layer.spheres.get_mut(index as usize)?;
            (gap.number == NOBODY && gap.cell == UNLISTED).then_some(())?;
            gap.cell = std::mem::replace(&mut layer.gap, index);
        }
        Some(())
    }
}
