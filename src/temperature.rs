//! Temperature profiles T(x).
//!
//! To add a profile, implement [`TemperatureProfile`] for a type of your own (one method), or wrap
//! a closure in [`TemperatureFn`].

use crate::numerics::differentiate_above;
use crate::{Error, Slab};
use std::sync::Arc;

/// A temperature profile: temperature as a function of height, in m g d (Boltzmann's constant is
/// 1).
///
/// ```
/// use gradient_mc::TemperatureProfile;
/// /// A hot plate in the middle.
/// struct Bump;
/// impl TemperatureProfile for Bump {
///     fn temperature(&self, height: f64) -> f64 {
///         10.0 + 5.0 * (-(height - 40.0).powi(2) / 200.0).exp()
///     }
/// }
/// assert!(Bump.logarithmic_gradient(40.0).abs() < 1e-9);
/// ```
///
/// A profile is `Send` and `Sync`, because threads share it. `&`, `Box` and `Arc` of a profile are
/// profiles too.
pub trait TemperatureProfile: Send + Sync {
    /// T(x) in m g d: positive and finite over the whole slab. It is never evaluated outside the
    /// slab.
    fn temperature(&self, height: f64) -> f64;

    /// d ln T/dx in inverse diameters. The default differentiates
    /// [`temperature`](Self::temperature) numerically, at heights up to 0.002 above `height` and
    /// never below 0.
    fn logarithmic_gradient(&self, height: f64) -> f64 {
        differentiate_above(|x| self.temperature(x), height, 1e-3, 0.0) / self.temperature(height)
    }

    /// The temperature if it is the same at all heights; the default `None` means unknown.
    ///
    /// With `Some`, a scene runs as fast as one with [`Isothermal`]. A profile that returns `None`
    /// but has the same temperature at all heights is detected and treated as isothermal too.
    #[inline]
    fn constant(&self) -> Option<f64> {
        None
    }
}

macro_rules! forward_profile {
    ($($pointer:ty),+) => {
        $(impl<T: TemperatureProfile + ?Sized> TemperatureProfile for $pointer {
            #[inline]
            fn temperature(&self, height: f64) -> f64 {
                (**self).temperature(height)
            }
            #[inline]
            fn logarithmic_gradient(&self, height: f64) -> f64 {
                (**self).logarithmic_gradient(height)
            }
            #[inline]
            fn constant(&self) -> Option<f64> {
                (**self).constant()
            }
        })+
    };
}
forward_profile!(&T, Box<T>, Arc<T>);

/// The same temperature at all heights. The simulation is an ordinary equilibrium simulation
/// without an effective field.
///
/// ```
/// use gradient_mc::temperature::{Isothermal, TemperatureProfile};
/// let profile = Isothermal::new(5.0)?;
/// assert_eq!((profile.temperature(3.0), profile.constant()), (5.0, Some(5.0)));
/// assert!(Isothermal::new(0.0).is_err());
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Isothermal {
    temperature: f64,
}

impl Isothermal {
    /// Makes an isothermal profile of this temperature, in m g d.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] unless positive and finite.
    pub fn new(temperature: f64) -> Result<Self, Error> {
        Ok(Self { temperature: Error::require_positive("temperature", temperature)? })
    }
}

impl TemperatureProfile for Isothermal {
    #[inline]
    fn temperature(&self, _height: f64) -> f64 {
        self.temperature
    }
    #[inline]
    fn logarithmic_gradient(&self, _height: f64) -> f64 {
        0.0
    }
    #[inline]
    fn constant(&self) -> Option<f64> {
        Some(self.temperature)
    }
}

/// Exponential profile T(x) = T₀ exp(−βx), eq. (2) of doi:10.1103/PhysRevE.83.061306: case (c) of
/// the paper.
///
/// ```
/// use gradient_mc::temperature::{ExponentialTemperature, TemperatureProfile};
/// let profile = ExponentialTemperature::new(20.0, 0.02)?;
/// assert!((profile.temperature(50.0) - 20.0 / 1f64.exp()).abs() < 1e-14);
/// assert_eq!(profile.logarithmic_gradient(50.0), -0.02);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExponentialTemperature {
    base: f64,
    decay_rate: f64,
}

impl ExponentialTemperature {
    /// Makes a profile with temperature `base` = T₀ at x = 0, in m g d, and `decay_rate` = β in
    /// inverse diameters (negative if the top is hotter).
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] unless T₀ is positive and both are finite.
    pub fn new(base: f64, decay_rate: f64) -> Result<Self, Error> {
        Ok(Self {
            base: Error::require_positive("temperature at the base", base)?,
            decay_rate: Error::require_finite("decay rate of the temperature", decay_rate)?,
        })
    }
}

impl TemperatureProfile for ExponentialTemperature {
    fn temperature(&self, height: f64) -> f64 {
        self.base * libm::exp(-self.decay_rate * height)
    }
    fn logarithmic_gradient(&self, _height: f64) -> f64 {
        -self.decay_rate
    }
}

/// Linear profile T(x) = T₀ + s x. It must be positive over the whole slab.
///
/// ```
/// use gradient_mc::temperature::{LinearTemperature, TemperatureProfile};
/// assert_eq!(LinearTemperature::new(20.0, -0.1)?.temperature(50.0), 15.0);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearTemperature {
    base: f64,
    slope: f64,
}

impl LinearTemperature {
    /// Makes a profile with temperature `base` = T₀ at x = 0, in m g d, and `slope` = s per
    /// diameter.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] unless T₀ is positive and both are finite.
    pub fn new(base: f64, slope: f64) -> Result<Self, Error> {
        Ok(Self {
            base: Error::require_positive("temperature at the base", base)?,
            slope: Error::require_finite("slope of the temperature", slope)?,
        })
    }
}

impl TemperatureProfile for LinearTemperature {
    fn temperature(&self, height: f64) -> f64 {
        self.base + self.slope * height
    }
    fn logarithmic_gradient(&self, height: f64) -> f64 {
        self.slope / self.temperature(height)
    }
}

/// A profile from a table: linear between its points, constant below the first and above the last.
///
/// ```
/// use gradient_mc::temperature::{TabulatedTemperature, TemperatureProfile};
/// let profile = TabulatedTemperature::new(vec![(0.0, 20.0), (50.0, 10.0), (100.0, 30.0)])?;
/// assert_eq!(profile.temperature(25.0), 15.0);
/// assert_eq!(profile.temperature(1e3), 30.0);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct TabulatedTemperature {
    points: Vec<(f64, f64)>,
}

impl TabulatedTemperature {
    /// Makes a profile from pairs of height (in diameters) and temperature (in m g d), with
    /// strictly increasing heights.
    ///
    /// # Errors
    /// [`Error::InvalidTemperature`] for a temperature that is not positive and finite;
    /// [`Error::InvalidParameter`] for an empty table, or for heights that are not finite and
    /// strictly increasing.
    pub fn new(points: Vec<(f64, f64)>) -> Result<Self, Error> {
        let requirement = "the table needs at least one point, and finite heights that strictly rise";
        let name = "height in the temperature table";
        if points.is_empty() {
            return Err(Error::InvalidParameter { name, value: f64::NAN, requirement });
        }
        let mut previous = f64::NEG_INFINITY;
        for &(height, temperature) in &points {
            if !height.is_finite() || height <= previous {
                return Err(Error::InvalidParameter { name, value: height, requirement });
            }
            if !(temperature.is_finite() && temperature > 0.0) {
                return Err(Error::InvalidTemperature { height, temperature });
            }
            previous = height;
        }
        Ok(Self { points })
    }
}

impl TemperatureProfile for TabulatedTemperature {
    fn temperature(&self, height: f64) -> f64 {
        let above = self.points.partition_point(|&(x, _)| x <= height);
        match (above.checked_sub(1).map(|below| self.points[below]), self.points.get(above)) {
            (Some((x0, t0)), Some(&(x1, t1))) => t0 + (t1 - t0) * (height - x0) / (x1 - x0),
            (Some((_, edge)), None) | (None, Some(&(_, edge))) => edge,
            // Unreachable, since the table is not empty.
            (None, None) => f64::NAN,
        }
    }
}

/// A profile from a closure T(x).
///
/// ```
/// use gradient_mc::temperature::{TemperatureFn, TemperatureProfile};
/// let profile = TemperatureFn(|height: f64| 10.0 + 5.0 * (height / 30.0).sin());
/// assert_eq!(profile.temperature(0.0), 10.0);
/// ```
#[derive(Clone, Copy)]
pub struct TemperatureFn<T>(
    /// The closure, from height to temperature.
    pub T,
);

impl<T> std::fmt::Debug for TemperatureFn<T> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str("TemperatureFn")
    }
}

impl<T: Fn(f64) -> f64 + Send + Sync> TemperatureProfile for TemperatureFn<T> {
    fn temperature(&self, height: f64) -> f64 {
        (self.0)(height)
    }
}

/// Checks over the whole slab that a profile is positive and finite, and that it equals the
/// temperature that `constant` returns.
pub(crate) fn probe<T: TemperatureProfile + ?Sized>(profile: &T, slab: &Slab) -> Result<(), Error> {
    // At least forty probes per diameter.
    const LEAST: f64 = 16_384.0;
    // Heights are at most 1e6.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let probes = (40.0 * slab.height()).ceil().max(LEAST) as u32;
    for probe in 0..=probes {
        let height = slab.height() * f64::from(probe) / f64::from(probes);
        let temperature = profile.temperature(height);
        if !(temperature.is_finite() && temperature > 0.0) {
            return Err(Error::InvalidTemperature { height, temperature });
        }
        // The bits must be equal, because the constant replaces the profile.
        let differs = |constant: &f64| constant.to_bits() != temperature.to_bits();
        if let Some(constant) = profile.constant().filter(differs) {
            return Err(Error::InconsistentTemperature { height, temperature, constant });
        }
    }
    Ok(())
}

/// The temperature of a slab if it is the same at all heights, up to rounding: from `constant`, or
/// found by evaluating four heights per diameter.
pub(crate) fn constant<T: TemperatureProfile + ?Sized>(profile: &T, slab: &Slab) -> Option<f64> {
    const DENSITY: f64 = 4.0;
    const LEAST: u32 = 256;
    const ROUNDING: f64 = 1e-12;
    // Heights are at most 1e6.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let probes = ((DENSITY * slab.height()).ceil() as u32).max(LEAST);
    let temperature = |probe: u32| profile.temperature(slab.height() * f64::from(probe) / f64::from(probes));
    profile.constant().or_else(|| {
        let first = temperature(0);
        (1..=probes).all(|probe| (temperature(probe) / first - 1.0).abs() < ROUNDING).then_some(first)
    })
}
