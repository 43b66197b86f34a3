//! Figure 13: P/T against packing fraction.

use super::crystal::Crystal;
use super::protocol::Protocol;
use super::results::{Fluid, Results, color_of};
use gradient_mc::EquationOfState;
use gradient_mc::equation_of_state::{CarnahanStarling, ModifiedKolafa, number_density};
use gradient_mc::observers::EquationOfStateProfile;
use gradient_mc::statistics::Estimate;
use paper::figure::{Axis, Corner, Figure, Mark, Panel, Place, Point, colors};
use paper::groups::{farthest_from_zero, largest, means_over};
use paper::row;
use paper::verdict::Verdicts;
use paper::{Failure, Report};

/// Where the layers at the wall end.
const BULK_BEGINS: f64 = 8.0;
/// Smallest density that is used; below it there are too few spheres.
const LEAST_DENSITY: f64 = 0.02;

/// A range of heights: packing fraction, P/T, and P/(nTZ) − 1 for two equations of state.
#[derive(Debug, Clone, Copy)]
struct Band {
    height: f64,
    packing_fraction: f64,
    reduced_pressure: Estimate,
    /// From Carnahan-Starling and from the modified Kolafa equation.
    deviations: [Estimate; 2],
}

/// Ranges of the bulk, each so wide.
fn bands(profile: &EquationOfStateProfile, begin: f64, end: f64, width: f64) -> Result<Vec<Band>, Failure> {
    let mut ranges = Vec::new();
    let mut low = begin;
    while low + width <= end {
        ranges.push([low, low + width]);
        low += width;
    }
    let temperature = Protocol::TEMPERATURE;
    let count = ranges.len();
    let values = profile.jackknife(|states| {
        let mut values = means_over(states, &ranges, |state| state.number_density);
        values.extend(means_over(states, &ranges, |state| state.pressure / temperature));
        values
    })?;
    let starling = profile.deviations_over(&ranges, &CarnahanStarling)?;
    let kolafa = profile.deviations_over(&ranges, &ModifiedKolafa)?;
    let bands = ranges.iter().enumerate().map(|(index, range)| Band {
        height: f64::midpoint(range[0], range[1]),
        packing_fraction: gradient_mc::equation_of_state::packing_fraction(values[index].mean),
        reduced_pressure: values[count + index],
        deviations: [starling[index], kolafa[index]],
    });
    Ok(bands.filter(|band| number_density(band.packing_fraction) > LEAST_DENSITY).collect())
}

fn of_fluid(fluid: &Fluid, width: f64) -> Result<Vec<Band>, Failure> {
    let top = fluid.theory.height_of_fraction(0.9999);
    bands(&fluid.profile, BULK_BEGINS, top, width)
}

/// The fluid above the crystal, without the layers above the front.
fn of_crystal(crystal: &Crystal, width: f64) -> Result<Vec<Band>, Failure> {
    bands(&crystal.profile, (crystal.fronts()?.bonds.mean + 3.0).ceil(), 42.0, width)
}

/// All columns with their α.
fn all_bands(results: &Results, width: f64) -> Result<Vec<(f64, Vec<Band>)>, Failure> {
    let mut all: Vec<(f64, Vec<Band>)> = Vec::new();
    for fluid in &results.fluids {
        all.push((fluid.column.rate, of_fluid(fluid, width)?));
    }
    if let Some(crystal) = results.crystals.first() {
        all.push((Protocol::CRYSTAL_RATE, of_crystal(crystal, width)?));
    }
    Ok(all)
}

pub(crate) fn draw(results: &Results, report: &mut Report) -> Result<(), Failure> {
    let curve = |equation: &'static dyn EquationOfState| {
        (0..=500)
            .map(|step| 1e-3 * f64::from(step))
            .map(move |eta| (eta, number_density(eta) * equation.compressibility_factor(eta)))
    };
    let ratio = (1..=500).map(|step| 1e-3 * f64::from(step)).map(|eta| {
        let ratio = CarnahanStarling.compressibility_factor(eta) / ModifiedKolafa.compressibility_factor(eta);
        (eta, 100.0 * (ratio - 1.0))
    });
    let mut pressure = Panel::new(
        Place { left: 0.0, top: 0.08, width: 0.5, height: 0.92 },
        Axis::new("packing fraction η", 0.0, 0.5),
        Axis::new("P / T  (d⁻³)", 0.0, 12.0),
    )
    .with_legend(Corner::TopLeft)
    .line("Carnahan–Starling", colors::INK, Mark::Line, curve(&CarnahanStarling));
    let mut deviation = Panel::new(
        Place { left: 0.5, top: 0.08, width: 0.5, height: 0.92 },
        Axis::new("packing fraction η", 0.0, 0.5),
        Axis::new("P / P(modified Kolafa) − 1  (%)", -2.0, 2.0),
    )
    .with_legend(Corner::TopLeft)
    .line("Carnahan–Starling", colors::INK, Mark::Line, ratio)
    .line("modified Kolafa", colors::GRAY, Mark::Dashed, [(0.0, 0.0), (0.5, 0.0)]);
    let mut rows = Vec::new();
    // Narrow for the curve, wide for the deviations from it.
    let (all, wide) = (all_bands(results, 1.0)?, all_bands(results, 4.0)?);
    for ((rate, bands), (_, wide)) in all.iter().zip(&wide) {
        let color = color_of(*rate);
        let label = format!("α = {rate}");
        pressure = pressure.points(
            &label,
            color,
            Mark::Points,
            bands.iter().map(|band| Point::of(band.packing_fraction, band.reduced_pressure)),
        );
        deviation = deviation.points(
            "",
            color,
            Mark::Points,
            wide.iter().map(|band| Point::percent(band.packing_fraction, band.deviations[1])),
        );
        rows.extend(bands.iter().map(|band| {
            row![
                *rate,
                band.height,
                band.packing_fraction,
                band.reduced_pressure,
                band.deviations[0],
                band.deviations[1],
            ]
        }));
    }
    let figure = Figure::new(
        "Figure 13: one equation of state in every field   (T = 20, a = exp(αx), fluid without layers)",
    )
    .panel(pressure)
    .panel(deviation);
    report.picture("figure_13", &figure, "Figure 13: pressure over temperature against packing fraction")?;
    report.table("figure_13",
        "alpha in 1/d; means over 1 d; reduced pressure P/T in 1/d^3; deviations P/(nTZ) - 1; errors are one standard error",
        "alpha, height, packing_fraction, reduced_pressure, reduced_pressure_error, \
         deviation_carnahan_starling, deviation_carnahan_starling_error, \
         deviation_modified_kolafa, deviation_modified_kolafa_error",
        rows,
    )
}

pub(crate) fn judge(results: &Results, verdicts: &mut Verdicts) -> Result<(), Failure> {
    for fluid in &results.fluids {
        let ranges = wide_ranges(fluid);
        let off = fluid.profile.deviations_over(&ranges, &ModifiedKolafa)?;
        let percent = off.iter().map(|off| 100.0 * *off);
        let off = farthest_from_zero(percent.clone());
        let claim =
            format!("{}: largest P/(nTZ) − 1 over 4 d, x > 8, n > 0.1, modified Kolafa, in %", fluid.label());
        verdicts.between("13", &claim, off, -2.0, 2.0);
        let error = largest(percent.map(|off| off.standard_error));
        let claim = format!("{}: largest error of these, in %", fluid.label());
        verdicts.at_most("13", &claim, Estimate::exact(error), 1.0);
    }
    Ok(())
}

/// Ranges of four diameters above the layers in which the theory's density is above 0.1.
fn wide_ranges(fluid: &Fluid) -> Vec<[f64; 2]> {
    const HEIGHT: f64 = 4.0;
    let mut found = Vec::new();
    let mut low = BULK_BEGINS;
    while fluid.theory.number_density(low + HEIGHT) > 0.1 {
        found.push([low, low + HEIGHT]);
        low += HEIGHT;
    }
    found
}
