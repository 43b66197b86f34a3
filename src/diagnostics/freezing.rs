//! Checks whether a part of the column is beyond freezing, and whether a crystal fits the box.

use super::hexagonal;
use crate::equation_of_state::{EquationOfState, FREEZING, FluidSolid, SpeedySolid, packing_fraction};
use crate::monitor::Monitor;
use crate::{Field, HydrostaticProfile, Scene, TemperatureProfile, Wall, Warning};

/// No warning if the largest P/T is within 1 % of coexistence: such a column freezes slowly or not
/// at all.
const MARGIN: f64 = 1.01;
/// Significant excess of the packing fraction of a band over that of freezing.
const DENSITY_MARGIN: f64 = 0.005;
/// A thinner layer beyond freezing is not reported, in diameters.
const THINNEST: f64 = 1.0;
/// Smallest number of spheres per area with which a single layer can freeze, that of hard discs
/// (doi:10.1103/PhysRevLett.107.155704). A layer of fewer spheres is a two-dimensional gas at any
/// weight per area over T.
pub(crate) const LEAST_LAYER: f64 = 0.89;
/// Bands closer to a wall than this, in diameters, do not average over the layers at the wall.
const LAYERED: f64 = 4.0;
/// Largest strain without a warning. An elastic energy of ½ · 50 T/d³ · strain² then changes P of
/// coexistence by about 2 %.
const LARGEST_STRAIN: f64 = 0.02;

/// Judges measured densities, and pressures from the weight of the measured column.
pub(super) fn warnings<F: Field, T: TemperatureProfile>(
    scene: &Scene<F, T>,
    monitor: &Monitor,
    theory: Option<&HydrostaticProfile>,
) -> Vec<Warning> {
    let Some(occupancy) = monitor.mean_occupancy() else { return Vec::new() };
    let bands = monitor.bands();
    let (area, height) = (scene.slab().base_area(), bands.height());
    let freezing = MARGIN * FluidSolid::default().coexistence().reduced_pressure;
    let weight =
        |band: usize| occupancy[band] * scene.field().acceleration(bands.edge(band) + 0.5 * height) / area;
    // P at the lower edges of the bands and at the lid, summed from the open end; divided by T
    // below.
    let mut pressures = vec![0.0; occupancy.len() + 1];
    match scene.open_end() {
        Wall::Lid => {
            pressures[occupancy.len()] = theory.map_or(0.0, HydrostaticProfile::lid_pressure);
            for band in (0..occupancy.len()).rev() {
                pressures[band] = pressures[band + 1] + weight(band);
            }
        }
        Wall::Base => {
            pressures[0] = theory.map_or(0.0, HydrostaticProfile::base_pressure);
            for band in 0..occupancy.len() {
                pressures[band + 1] = pressures[band] - weight(band);
            }
        }
    }
    for (edge, pressure) in pressures.iter_mut().enumerate() {
        *pressure /= scene.temperature().temperature(bands.edge(edge).min(scene.slab().highest_center()));
    }
    let eta = |band: usize| {
        let next = (band + 1).min(occupancy.len() - 1);
        // The bulk profile with the same number of spheres begins at this distance from the wall.
        let lost = [band == 0, next + 1 == occupancy.len()];
        let lost = lost.map(|at_wall| if at_wall { 0.125 } else { 0.0 }).iter().sum::<f64>();
        let heights = if next > band { 2.0 * height } else { height };
        let count = if next > band { occupancy[band] + occupancy[next] } else { occupancy[band] };
        packing_fraction(count / (area * (heights - lost)))
    };
    let (mut range, mut densest) = (None, 0.0_f64);
    let mut extend = |low: f64, high: f64| {
        range = Some(
            range.map_or((low, high), |(lowest, highest): (f64, f64)| (lowest.min(low), highest.max(high))),
        );
    };
    for band in 0..occupancy.len() {
        let [below, above] = [pressures[band], pressures[band + 1]];
        let (low, high) = (bands.edge(band), bands.edge(band + 1));
        let crossing = low + height * (freezing - below) / (above - below);
        let away = low >= LAYERED && high + height <= scene.slab().height() - LAYERED;
        if away && eta(band) > FREEZING + DENSITY_MARGIN {
            extend(low, high);
        } else if below > freezing {
            extend(low, if above > freezing { high } else { crossing });
        } else if above > freezing {
            extend(crossing, high);
        } else {
            continue;
        }
        densest = densest.max(eta(band));
    }
    let mut warnings = Vec::new();
    let layer = |(lowest, highest): (f64, f64)| {
        let reaches = |band: &usize| bands.edge(band + 1) > lowest && bands.edge(*band) < highest;
        (0..occupancy.len()).filter(reaches).map(|band| occupancy[band]).sum::<f64>() / area
    };
    let matters = |range: &(f64, f64)| range.1 - range.0 >= THINNEST && layer(*range) >= LEAST_LAYER;
    if let Some((lowest_height, highest_height)) = range.filter(matters) {
        warnings.push(Warning::Metastable { lowest_height, highest_height, packing_fraction: densest });
        warnings.extend(incommensurate(scene, pressures[0].max(pressures[occupancy.len()])));
    }
    warnings
}

/// Checks whether the crystal that is stable at the larger wall pressure fits the widths.
fn incommensurate<F, T>(scene: &Scene<F, T>, reduced_pressure: f64) -> Option<Warning> {
    let coexistence = FluidSolid::default().coexistence();
    let eta = SpeedySolid
        .packing_fraction_at(reduced_pressure.max(coexistence.reduced_pressure), Some(coexistence.solid))?;
    // 1 at close packing, π/√18.
    let lattice_constant = libm::cbrt(std::f64::consts::PI / 18_f64.sqrt() / eta);
    let widths = scene.slab().widths();
    let strain = hexagonal::smallest_strain(widths.map(|width| width / lattice_constant));
    let width = widths[0].min(widths[1]);
    (strain > LARGEST_STRAIN).then_some(Warning::BoxIncommensurate { strain, width, lattice_constant })
}
