//! Figure 10: where the spheres of the crystal are, from the side and the lowest layers from above.

use super::crystal::{Crystal, TOP};
use super::results::Results;
use gradient_mc::statistics::Estimate;
use paper::figure::{Axis, Corner, Figure, Mark, Panel, Place, Point, colors};
use paper::verdict::Verdicts;
use paper::{Failure, Report};

/// Width of the view from the side, in diameters.
const WIDTH: f64 = 16.0;

/// The spheres of the lowest layers of a configuration, by their places (y, z).
fn lowest_layers(crystal: &Crystal, count: usize) -> Result<Vec<Vec<[f64; 2]>>, Failure> {
    let layers = crystal.layers()?;
    let middle = |index: usize| -> Option<f64> {
        let (below, above) = (layers.get(index)?.position.mean, layers.get(index + 1)?.position.mean);
        Some(f64::midpoint(below, above))
    };
    let mut found = Vec::new();
    let mut low = 0.0;
    for index in 0..count {
        let high = middle(index).ok_or("there are no layers")?;
        let inside = crystal.positions.iter().filter(|position| (low..high).contains(&position.x));
        found.push(inside.map(|position| [position.y, position.z]).collect());
        low = high;
    }
    Ok(found)
}

/// Smallest lateral distance of a place from others, across the periodic edges.
fn nearest(place: [f64; 2], others: &[[f64; 2]], sides: [f64; 2]) -> f64 {
    let squared = |other: &[f64; 2]| {
        let separation = |axis: usize| {
            let difference = place[axis] - other[axis];
            difference - sides[axis] * (difference / sides[axis]).round()
        };
        separation(0) * separation(0) + separation(1) * separation(1)
    };
    others.iter().map(squared).fold(f64::INFINITY, f64::min).sqrt()
}

pub(crate) fn draw(results: &Results, report: &mut Report) -> Result<(), Failure> {
    let crystal = results.shown()?;
    let sides = crystal.base.0;
    // As many periodic images as make the picture wide.
    let images =
        |side: f64| (0..40).map(move |image| f64::from(image) * side).take_while(|start| *start < WIDTH);
    let dot = |x: f64, y: f64| Point { x, y, error: 0.0 };
    let side_view = crystal
        .positions
        .iter()
        .flat_map(|position| images(sides[0]).map(move |shift| dot(position.y + shift, position.x)));
    let side = Panel::new(
        Place { left: 0.0, top: 0.06, width: 0.5, height: 0.94 },
        Axis::new("y / d", 0.0, WIDTH).with_numbers(5),
        Axis::new("height x / d", 0.0, TOP),
    )
    .with_title(if sides[0] < WIDTH {
        "all spheres from the side, with periodic images"
    } else {
        "from the side, a part of the base"
    })
    .points("", colors::INK, Mark::Dots, side_view.filter(|point| point.x <= WIDTH));
    let layers = lowest_layers(crystal, 3)?;
    let from_above = |layer: usize| {
        let places = layers[layer].clone();
        let mut shown = Vec::new();
        for place in places {
            for y in images(sides[0]) {
                shown.extend(images(sides[1]).map(|z| dot(place[0] + y, place[1] + z)));
            }
        }
        shown.into_iter().filter(|point| point.x < 10.0 && point.y < 7.0).collect::<Vec<Point>>()
    };
    let view = |top: f64, title: &str| {
        Panel::new(
            Place { left: 0.5, top, width: 0.5, height: 0.47 },
            Axis::new("y / d", 0.0, 10.0).with_numbers(6),
            Axis::new("z / d", 0.0, 8.6).with_numbers(5),
        )
        .with_title(title)
        .with_legend(Corner::TopRight)
    };
    let two = view(0.06, "the two lowest layers from above")
        .points("lowest", colors::INK, Mark::Rings, from_above(0))
        .points("second", colors::VERMILION, Mark::Points, from_above(1));
    let three = view(0.53, "the third over the lowest layer: different sites in fcc, equal sites in hcp")
        .points("lowest", colors::INK, Mark::Rings, from_above(0))
        .points("third", colors::BLUE, Mark::Points, from_above(2));
    let title = format!("Figure 10: positions of the spheres   (T = 20, α = 0.1, base {})", crystal.base);
    let figure = Figure::new(&title).with_size(1600, 1100).panel(side).panel(two).panel(three);
    report.picture("figure_10", &figure, "Figure 10: positions of the spheres at α = 0.1: a slice of the column, and the two lowest layers from above")?;
    report.table(
        "figure_10",
        "centers of all spheres at the end of the run, in d; x is the height",
        "x, y, z",
        crystal.positions.iter().map(|position| [position.x, position.y, position.z]),
    )
}

pub(crate) fn judge(results: &Results, verdicts: &mut Verdicts) -> Result<(), Failure> {
    let crystal = results.shown()?;
    let layers = lowest_layers(crystal, 2)?;
    // The hollow between three touching or nearly touching spheres is a/√3 from each, a from the
    // density of the layer.
    let area = crystal.base.0[0] * crystal.base.0[1] / layers[0].len() as f64;
    let constant = (2.0 * area / 3.0_f64.sqrt()).sqrt();
    let distances = layers[1].iter().map(|&place| nearest(place, &layers[0], crystal.base.0));
    let mean = distances.sum::<f64>() / layers[1].len() as f64;
    verdicts.between(
        "10",
        "lateral distance of the second layer from the lowest, over that of a hollow site (0 on top)",
        Estimate::exact(mean / (constant / 3.0_f64.sqrt())),
        0.85,
        1.1,
    );
    Ok(())
}
