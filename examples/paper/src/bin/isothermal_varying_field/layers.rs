//! Figure 9: n(x) at α = 0.1, a crystal below and a fluid above; and how far apart its layers are.

use super::column::Column;
use super::crystal::{Crystal, TOP};
use super::lattice::{lateral_density, lattice_constant};
use super::protocol::Protocol;
use super::results::{Results, front_of, frozen_theory};
use gradient_mc::hydrostatics::HydrostaticProfile;
use gradient_mc::observers::Layer;
use gradient_mc::statistics::Estimate;
use paper::figure::{Axis, Corner, Figure, Mark, Panel, Place, Point, colors};
use paper::row;
use paper::verdict::Verdicts;
use paper::{Failure, Report};

/// The layers that the paper takes the spacing over.
pub(crate) const PAPERS_LAYERS: usize = 20;

/// Mean spacing of the lowest layers.
pub(crate) fn mean_spacing(layers: &[Layer]) -> Estimate {
    let last = layers.len().min(PAPERS_LAYERS);
    if last < 2 {
        return Estimate::new(f64::NAN, f64::NAN);
    }
    let (first, last, gaps) = (layers[0].position, layers[last - 1].position, (last - 1) as f64);
    last.minus_independent(first) / gaps
}

/// The spacing that theory has at a height, of a crystal free to choose how dense its layers are
/// sideways.
pub(crate) fn theory_spacing(theory: &HydrostaticProfile, height: f64) -> f64 {
    let density = theory.number_density(height);
    lateral_density(lattice_constant(density)) / density
}

/// Mean number of spheres per area of the layers of a crystal but the lowest and the uppermost.
pub(crate) fn mean_lateral_density(layers: &[Layer]) -> Estimate {
    let inner = layers.get(1..layers.len().saturating_sub(2)).unwrap_or(&[]);
    Estimate::mean_of_independent(inner.iter().map(|layer| layer.lateral_density))
}

fn column(crystal: &Crystal) -> Column {
    Column { rate: Protocol::CRYSTAL_RATE, base: crystal.base }
}

pub(crate) fn draw(results: &Results, report: &mut Report) -> Result<(), Failure> {
    let crystal = results.shown()?;
    let theory = frozen_theory(column(crystal))?;
    let layers = crystal.crystalline_layers()?;
    let points = crystal.density.points()?;
    let highest = points.iter().map(|point| point.number_density.mean).fold(1.0, f64::max);
    let profile = Panel::new(
        Place { left: 0.0, top: 0.08, width: 1.0, height: 0.52 },
        Axis::new("height x / d", 0.0, TOP).with_numbers(10),
        Axis::new("n d³", 0.0, 1.08 * highest).with_numbers(5),
    )
    .with_legend(Corner::TopRight)
    .line(
        "simulation, bins of 0.05 d",
        colors::INK,
        Mark::Line,
        points.iter().map(|point| (point.height, point.number_density.mean)),
    )
    .line(
        "hydrostatics: modified Kolafa fluid, Speedy crystal",
        colors::VERMILION,
        Mark::Line,
        (0..900).map(|step| (0.05 * f64::from(step), theory.number_density(0.05 * f64::from(step)))),
    );
    let front = front_of(&theory);
    let heights = || (1..100).map(|step| (front - 0.1) * f64::from(step) / 100.0);
    let spacing = Panel::new(
        Place { left: 0.0, top: 0.6, width: 1.0, height: 0.4 },
        Axis::new("height x / d", 0.0, TOP).with_numbers(10),
        Axis::new("spacing / d", 0.7, 1.05).with_numbers(5),
    )
    .with_legend(Corner::BottomRight)
    .points(
        "spacing of the layers",
        colors::INK,
        Mark::Points,
        layers.windows(2).map(|pair| {
            Point::of(f64::midpoint(pair[0].position.mean, pair[1].position.mean), pair[1].spacing)
        }),
    )
    .line(
        "theory of a crystal without lateral strain",
        colors::VERMILION,
        Mark::Line,
        heights().map(|height| (height, theory_spacing(&theory, height))),
    )
    .line("the paper, mean of the lowest 20", colors::BLUE, Mark::Dashed, [(0.5, 0.86), (17.3, 0.86)]);
    let title = format!("Figure 9: layers of the crystal   (T = 20, α = 0.1, base {})", crystal.base);
    let figure = Figure::new(&title).with_size(1600, 900).panel(profile).panel(spacing);
    report.picture(
        "figure_09",
        &figure,
        "Figure 9: density over height at α = 0.1: layers of a crystal grown from the fluid",
    )?;
    report.table(
        "figure_09",
        "heights in d; densities in 1/d^3; errors are one standard error",
        "height, number_density, number_density_error, number_density_theory",
        points
            .iter()
            .map(|point| row![point.height, point.number_density, theory.number_density(point.height)]),
    )?;
    write_layers(results, report)
}

/// The layers of all crystals.
fn write_layers(results: &Results, report: &mut Report) -> Result<(), Failure> {
    let mut rows = Vec::new();
    for (index, crystal) in results.crystals.iter().enumerate() {
        let theory = frozen_theory(column(crystal))?;
        for layer in crystal.layers()? {
            rows.push(row![
                index as f64,
                layer.position,
                layer.spacing,
                layer.width.mean,
                layer.lateral_density,
                layer.visibility.mean,
                theory_spacing(&theory, layer.position.mean),
            ]);
        }
    }
    report.table("layers",
        "crystal: number in the order of the table; lengths in d, lateral density in 1/d^2; theory: spacing of a crystal without lateral strain",
        "crystal, height, height_error, spacing_below, spacing_error, width, lateral_density, \
         lateral_density_error, visibility, spacing_unstrained_theory",
        rows,
    )
}

pub(crate) fn judge(results: &Results, verdicts: &mut Verdicts) -> Result<(), Failure> {
    let crystal = results.shown()?;
    let layers = crystal.crystalline_layers()?;
    let count = Estimate::exact(layers.len() as f64);
    verdicts.at_least("9", "crystalline layers; about 20 clear ones in the figure of the paper", count, 20.0);
    let spacing = mean_spacing(&layers);
    // The paper gives two digits.
    verdicts.between(
        "9",
        "mean spacing of the lowest 20 layers, in d (0.86 in the paper)",
        spacing,
        0.84,
        0.88,
    );
    Ok(())
}
