//! Figure 11: g(r) in the lowest layer, and the angles between neighbors in layers.

use super::results::{COLORS, Results};
use gradient_mc::observers::RadialDistributionPoint;
use gradient_mc::statistics::Estimate;
use paper::figure::{Axis, Corner, Figure, Mark, Panel, Place, Point, colors};
use paper::row;
use paper::verdict::Verdicts;
use paper::{Failure, Report};

pub(crate) fn draw(results: &Results, report: &mut Report) -> Result<(), Failure> {
    let crystal = results.shown()?;
    let radial = crystal.first_layer.points()?;
    let highest = radial.iter().map(|point| point.radial_distribution.mean).fold(1.0, f64::max);
    let most = radial.last().map_or(4.0, |point| point.distance);
    let distribution = Panel::new(
        Place { left: 0.0, top: 0.08, width: 0.5, height: 0.92 },
        Axis::new("r / d", 0.0, most),
        Axis::new("g(r)", 0.0, 1.1 * highest),
    )
    .with_title("lowest layer, x = 0.5 to 0.9")
    .line(
        "",
        colors::GRAY,
        Mark::Line,
        radial.iter().map(|point| (point.distance, point.radial_distribution.mean)),
    )
    .points(
        "",
        colors::INK,
        Mark::Dots,
        radial.iter().map(|point| Point::of(point.distance, point.radial_distribution)),
    );
    let mut largest = 1.0_f64;
    for (_, angles) in &crystal.angles {
        let points = angles.points()?;
        largest = points.iter().map(|point| point.angular_distribution.mean).fold(largest, f64::max);
    }
    let mut angular = Panel::new(
        Place { left: 0.5, top: 0.08, width: 0.5, height: 0.92 },
        Axis::new("angle between two neighbors / degrees", 0.0, 360.0).with_numbers(7),
        Axis::new("g(θ)", 0.0, 1.5 * largest),
    )
    .with_title("neighbors within 1.2 d, in layers at x")
    .with_legend(Corner::TopRight);
    let mut rows = Vec::new();
    for ((height, angles), color) in crystal.angles.iter().zip(COLORS) {
        let points = angles.points()?;
        angular = angular.line(
            &format!("x = {height:.1}"),
            color,
            Mark::Line,
            points.iter().map(|point| (point.degrees, point.angular_distribution.mean)),
        );
        rows.extend(points.iter().map(|point| row![height, point.degrees, point.angular_distribution]));
    }
    let title = format!("Figure 11: order within layers   (T = 20, α = 0.1, base {})", crystal.base);
    let figure = Figure::new(&title).panel(distribution).panel(angular);
    report.picture(
        "figure_11",
        &figure,
        "Figure 11: lateral distribution of distances in the lowest layer, and of angles between neighbors",
    )?;
    report.table(
        "figure_11_radial",
        "distances in d; spheres at heights from 0.5 to 0.9; errors are one standard error",
        "distance, radial_distribution, radial_distribution_error",
        radial.iter().map(|point| row![point.distance, point.radial_distribution]),
    )?;
    report.table("figure_11_angles",
        "height of the layer in d; angles in degrees, 1 on average; neighbors within 1.2 d; errors are one standard error",
        "height, angle, angular_distribution, angular_distribution_error",
        rows,
    )
}

/// The centroid of a peak between two distances.
fn peak(points: &[RadialDistributionPoint], low: f64, high: f64) -> f64 {
    let inside = points.iter().filter(|point| (low..high).contains(&point.distance));
    // Weighted by g and not by the number of pairs, which grows with the circumference.
    let (weight, moment) = inside.fold((0.0, 0.0), |(weight, moment), point| {
        let value = point.radial_distribution.mean;
        (weight + value, moment + value * point.distance)
    });
    moment / weight
}

pub(crate) fn judge(results: &Results, verdicts: &mut Verdicts) -> Result<(), Failure> {
    let crystal = results.shown()?;
    let radial = crystal.first_layer.points()?;
    // The second peak ends half way to the third, at 2.
    let first = peak(&radial, 0.9, 1.45);
    let second = peak(&radial, 1.5 * first, 0.5 * (3.0_f64.sqrt() + 2.0) * first);
    verdicts.between(
        "11 left",
        "second peak of g(r) over the first (hexagonal: 1.732)",
        Estimate::exact(second / first),
        1.68,
        1.78,
    );
    for (index, (height, angles)) in crystal.angles.iter().enumerate() {
        // How much more often neighbors are 60, 120, ... degrees apart than 30, 90, ...
        let points = angles.points()?;
        let mean = |offset: f64| {
            let inside = points.iter().filter(|point| {
                let from_first = (point.degrees - 60.0 + offset).rem_euclid(60.0);
                (45.0..315.0).contains(&point.degrees) && from_first.min(60.0 - from_first) <= 6.0
            });
            let (sum, count) = inside
                .fold((0.0, 0), |(sum, count), point| (sum + point.angular_distribution.mean, count + 1));
            sum / f64::from(count)
        };
        let ratio = Estimate::exact(mean(0.0) / mean(30.0));
        let claim = format!("x = {height:.1}: g(θ) at multiples of 60 degrees over g between them");
        // The last is in the fluid.
        if index + 1 < crystal.angles.len() {
            verdicts.at_least("11 right", &claim, ratio, 4.0);
        } else {
            verdicts.at_most("11 right", &claim, ratio, 4.0);
        }
    }
    Ok(())
}
