//! Style of the figures.

use super::protocol::TEMPERATURES;
use paper::figure::{Place, RGBColor, colors};

/// Color of a temperature in all figures.
pub(crate) fn color_of(temperature: f64) -> RGBColor {
    const COLORS: [RGBColor; 4] = [colors::BLUE, colors::VERMILION, colors::PURPLE, colors::GREEN];
    let known = TEMPERATURES.iter().position(|&tabulated| tabulated == temperature);
    known.map_or(colors::INK, |number| COLORS[number])
}

/// A place that fills the picture below its title.
pub(crate) const WHOLE: Place = Place { left: 0.0, top: 0.07, width: 1.0, height: 0.93 };
