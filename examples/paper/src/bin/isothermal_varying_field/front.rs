//! Where a quantity that depends on height crosses a level.

use gradient_mc::statistics::Estimate;

/// A quantity at a height.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Crossing {
    height: f64,
    value: Estimate,
}

impl Crossing {
    pub(crate) fn new(height: f64, value: Estimate) -> Self {
        Self { height, value }
    }
}

/// The height at which the values, which are high below, fall below a level for the first time on
/// the way up; on a straight line between the neighbors. NaN if they never do, or never were above.
pub(crate) fn falls_below(values: &[Crossing], level: f64) -> Estimate {
    let known: Vec<Crossing> = values.iter().filter(|point| point.value.mean.is_finite()).copied().collect();
    let high = known.iter().position(|point| point.value.mean >= level);
    let Some(start) = high else { return Estimate::new(f64::NAN, f64::NAN) };
    let pair = known[start..].windows(2).find(|pair| pair[1].value.mean < level);
    pair.map_or(Estimate::new(f64::NAN, f64::NAN), |pair| between(pair[0], pair[1], level))
}

/// The height at which the values, low below and high above, are half way between their mean three
/// to six diameters below `front` and that one to three above.
pub(crate) fn midway_rise(values: &[Crossing], front: f64) -> Estimate {
    let mean = |low: f64, high: f64| {
        let inside = values.iter().filter(|point| (low..high).contains(&(point.height - front)));
        let (sum, count) = inside.fold((0.0, 0), |(sum, count), point| (sum + point.value.mean, count + 1));
        sum / f64::from(count)
    };
    let level = f64::midpoint(mean(-6.0, -3.0), mean(1.0, 3.0));
    let pair = values
        .windows(2)
        .filter(|pair| (pair[0].height - front).abs() < 6.0)
        .find(|pair| pair[0].value.mean < level && pair[1].value.mean >= level);
    pair.map_or(Estimate::new(f64::NAN, f64::NAN), |pair| between(pair[0], pair[1], level))
}

/// Linear interpolation; its error is that of the nearer value over the slope.
fn between(below: Crossing, above: Crossing, level: f64) -> Estimate {
    let slope = (above.value.mean - below.value.mean) / (above.height - below.height);
    let share = (level - below.value.mean) / (above.value.mean - below.value.mean);
    let error = ((1.0 - share) * below.value.standard_error).hypot(share * above.value.standard_error);
    Estimate::new(below.height + share * (above.height - below.height), error / slope.abs())
}
