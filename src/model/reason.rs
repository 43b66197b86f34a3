//! What a model leaves out, in words and numbers.

use std::fmt;

/// One contribution to the error of a model. Fractions are total variation distances.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Reason {
    /// Points take up no room.
    ExcludedVolume {
        /// Fraction of the spheres that the theory has elsewhere.
        fraction: f64,
    },
    /// A local theory has no layers at a wall.
    Layers {
        /// Which wall.
        wall: Wall,
        /// Packing fraction of the bulk there.
        packing_fraction: f64,
        /// Fraction of the spheres.
        fraction: f64,
    },
    /// Equation of state, and density taken to be locally uniform.
    Bulk {
        /// Largest |d ln n/dx|, per diameter.
        logarithmic_gradient: f64,
        /// Height at which it is.
        height: f64,
        /// Fraction of the spheres.
        fraction: f64,
    },
    /// A finite number of configurations, from a start that was not yet the steady state.
    Noise {
        /// Fraction of the spheres.
        fraction: f64,
    },
    /// A base with few spheres.
    FiniteBase {
        /// Number of spheres.
        particles: usize,
        /// Fraction of the spheres.
        fraction: f64,
    },
    /// The column freezes: no model here is known to be adequate without care.
    Freezing {
        /// Lowest height at which it does.
        lowest_height: f64,
        /// Highest height.
        highest_height: f64,
        /// Largest packing fraction.
        packing_fraction: f64,
    },
}

/// One of the two hard walls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wall {
    /// At x = 0.
    Base,
    /// At the top.
    Lid,
}

impl fmt::Display for Reason {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::ExcludedVolume { fraction } => {
                write!(formatter, "excluded volume moves {} of the spheres", Percent(fraction))
            }
            Self::Layers { wall, packing_fraction, fraction } => {
                let wall = match wall {
                    Wall::Base => "base",
                    Wall::Lid => "lid",
                };
                write!(
                    formatter,
                    "the layers at the {wall}, packing fraction {packing_fraction:.3}, hold {} of the spheres elsewhere",
                    Percent(fraction)
                )
            }
            Self::Bulk { logarithmic_gradient, height, fraction } => write!(
                formatter,
                "equation of state and local density, |d ln n/dx| up to {logarithmic_gradient:.2} at x = {height:.1}: {}",
                Percent(fraction)
            ),
            Self::Noise { fraction } => write!(formatter, "counting noise {}", Percent(fraction)),
            Self::FiniteBase { particles, fraction } => {
                write!(formatter, "a base with {particles} spheres {}", Percent(fraction))
            }
            Self::Freezing { lowest_height, highest_height, packing_fraction } => write!(
                formatter,
                "the column freezes between x = {lowest_height:.1} and {highest_height:.1} (packing fraction up to \
                 {packing_fraction:.3}): no model here is known to be adequate; a crystal needs a wide base whose widths suit it, \
                 and starts on both sides"
            ),
        }
    }
}

/// A fraction as a per cent with two figures.
pub(super) struct Percent(pub(super) f64);

impl fmt::Display for Percent {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = 100.0 * self.0;
        match percent.abs() {
            10.0.. => write!(formatter, "{percent:.0} %"),
            1.0..10.0 => write!(formatter, "{percent:.1} %"),
            0.1..1.0 => write!(formatter, "{percent:.2} %"),
            0.001..0.1 => write!(formatter, "{percent:.3} %"),
            _ => write!(formatter, "{percent:.0e} %"),
        }
    }
}
