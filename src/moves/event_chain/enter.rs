//! Enters the spheres that chains have moved into their cells and layers.

use super::visit::Outcome;
use crate::configuration::{Grid, Layer, Site};

/// A sphere on its way to another layer.
#[derive(Debug, Clone, Copy, Default)]
struct Arrival {
    site: Site,
    number: u32,
}

/// Reused memory.
#[derive(Debug, Default)]
pub(super) struct Entrance {
    /// The spheres that leave each layer, each with the layer to which it goes.
    departures: Vec<Vec<(u32, Arrival)>>,
    /// The same spheres, sorted by the layers to which they go, and the end of each layer's part.
    arrivals: Vec<Arrival>,
    ends: Vec<u32>,
}

impl Entrance {
    /// Number of moved spheres up to which one thread is faster than several.
    const MANY: usize = 4096;

    /// Enters the outcomes of visits for chains along `axis`. Layers can be changed in parallel:
    /// first the spheres that stay or leave, then those that arrive, in the order of the layers
    /// they come from.
    pub(super) fn enter(&mut self, axis: usize, grid: &Grid, layers: &mut [Layer], outcomes: &[Outcome]) {
        let Self { departures, arrivals, ends } = self;
        departures.resize_with(layers.len(), Vec::new);
        let many = outcomes.iter().map(Outcome::moved).sum::<usize>() > Self::MANY;
        each(many, layers, departures, |number, layer, departures| {
            departures.clear();
            // At most all of its spheres leave.
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

/// Calls `change` for each layer, in parallel if there are `many` spheres.
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
