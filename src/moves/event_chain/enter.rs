//! How spheres that chains have moved are entered where they belong.

use super::visit::Outcome;
use crate::configuration::{Grid, Layer, Site};

/// A sphere on its way to another layer.
#[derive(Debug, Clone, Copy, Default)]
struct Arrival {
    site: Site,
    number: u32,
}

/// Memory that is used again.
#[derive(Debug, Default)]
pub(super) struct Entrance {
    /// What leaves each layer, and the layer to which it goes.
    departures: Vec<Vec<(u32, Arrival)>>,
    /// The same in the order of the layers to which it goes, and where those of each end.
    arrivals: Vec<Arrival>,
    ends: Vec<u32>,
}

impl Entrance {
    /// Fewer that have moved are entered sooner than threads are told.
    const MANY: usize = 4096;

    /// Enters what became of some visits for chains along `axis`. All layers can be changed at the
    /// same time: first what stays in them and what leaves them, then what comes to them, in
    /// the order of the layers whence it comes.
    pub(super) fn enter(&mut self, axis: usize, grid: &Grid, layers: &mut [Layer], outcomes: &[Outcome]) {
        let Self { departures, arrivals, ends } = self;
        departures.resize_with(layers.len(), Vec::new);
        let many = outcomes.iter().map(Outcome::moved).sum::<usize>() > Self::MANY;
        each(many, layers, departures, |number, layer, departures| {
            departures.clear();
            // No more can leave it.
            departures.reserve(layer.spheres.len());
            for outcome in outcomes {
                for moved in outcome.moved_from(number) {
                    let mut position = layer.spheres[moved.index as usize].position;
                    position[axis] = moved.along;
                    let spot = grid.spot(position);
                    let site = grid.site(&spot, position);
                    if spot.layer as usize + 1 == number {
                        layer.shift(grid, moved.index, &site);
                    } else {
                        let number = layer.remove(grid, moved.index);
                        departures.push((spot.layer + 1, Arrival { site, number }));
                    }
                }
            }
        });
        if axis != 0 {
            return;
        }
        ends.clear();
        ends.resize(layers.len() + 1, 0);
        for (to, _) in departures.iter().flatten() {
            ends[*to as usize + 1] += 1;
        }
        for layer in 1..ends.len() {
            ends[layer] += ends[layer - 1];
        }
        arrivals.resize(ends[layers.len()] as usize, Arrival::default());
        for &(to, arrival) in departures.iter().flatten() {
            let end = &mut ends[to as usize];
            arrivals[*end as usize] = arrival;
            *end += 1;
        }
        each(many, layers, departures, |number, layer, _| {
            let begin = number.checked_sub(1).map_or(0, |before| ends[before]);
            for arrival in &arrivals[begin as usize..ends[number] as usize] {
                layer.insert(grid, &arrival.site, arrival.number);
            }
        });
    }
}

/// Calls `change` for each layer.
#[cfg(not(feature = "rayon"))]
fn each<T>(_: bool, layers: &mut [Layer], lists: &mut [T], change: impl Fn(usize, &mut Layer, &mut T)) {
    layers.iter_mut().zip(lists).enumerate().for_each(|(number, (layer, list))| change(number, layer, list));
}

/// Calls `change` for each layer, if there are `many` spheres for several at the same time.
#[cfg(feature = "rayon")]
fn each<T: Send>(
    many: bool,
    layers: &mut [Layer],
    lists: &mut [T],
    change: impl Fn(usize, &mut Layer, &mut T) + Sync,
) {
    use rayon::iter::{IndexedParallelIterator, IntoParallelRefMutIterator, ParallelIterator};
    if many {
        let all = layers.par_iter_mut().zip(lists).enumerate();
        all.for_each(|(number, (layer, list))| change(number, layer, list));
    } else {
        let all = layers.iter_mut().zip(lists).enumerate();
        all.for_each(|(number, (layer, list))| change(number, layer, list));
    }
}
