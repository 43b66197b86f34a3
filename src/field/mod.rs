//! External fields: the acceleration of the spheres as a function of height.
//!
//! To add a field, implement [`Field`] for a type of your own (one method), or wrap a closure in
//! [`FieldFn`]. [`DesignedField`] gives a chosen density profile.

mod designed;

pub use designed::DesignedField;

use crate::numerics::{differentiate_above, integrate_panel};
use crate::{Error, Slab};
use std::cell::Cell;
use std::sync::Arc;

/// An external field that acts on every sphere, positive towards the base.
///
/// The only required method is the potential, because its differences decide the acceptance of
/// moves. The acceleration is its derivative. If only a(x) is known, [`FieldFn`] integrates it.
///
/// A field is `Send` and `Sync`, because threads share it. `&`, `Box` and `Arc` of a field are
/// fields too. With `Box<dyn Field>` the field is chosen at run time (see [`Scene`](crate::Scene)).
///
/// ```
/// use gradient_mc::Field;
/// /// A centrifuge: a(x) = 1 + rate x.
/// struct Centrifuge { rate: f64 }
/// impl Field for Centrifuge {
///     fn potential(&self, height: f64) -> f64 {
///         height + 0.5 * self.rate * height * height
///     }
/// }
/// let field = Centrifuge { rate: 0.1 };
/// assert!((field.acceleration(10.0) - 2.0).abs() < 1e-9);
/// ```
pub trait Field: Send + Sync {
    /// Potential energy m ∫₀ˣ a dx' of a sphere at `height`, in m g d (eq. 15 of
    /// doi:10.1103/PhysRevE.83.061306). It is never evaluated outside the slab, [0, H].
    fn potential(&self, height: f64) -> f64;

    /// Acceleration a(x) towards the base, in g. The default differentiates the potential
    /// numerically, at heights up to 0.002 above `height` and never below 0.
    fn acceleration(&self, height: f64) -> f64 {
        differentiate_above(|x| self.potential(x), height, 1e-3, 0.0)
    }
}

/// Distance from the end of a field up to which its acceleration is evaluated; a numerical
/// derivative needs 0.002.
pub(crate) const END_MARGIN: f64 = 2.5e-3;

/// The acceleration of a field that ends at `highest`. Near the end it is extrapolated by the cubic
/// through four values below.
pub(crate) fn acceleration_below<F: Field + ?Sized>(field: &F, height: f64, highest: f64) -> f64 {
    let edge = highest - END_MARGIN;
    if height <= edge {
        return field.acceleration(height);
    }
    let t = (height - edge) / END_MARGIN;
    let [first, second, third, fourth] =
        [0.0, 1.0, 2.0, 3.0].map(|steps| field.acceleration(edge - steps * END_MARGIN));
    // Newton's backward differences.
    let (one, two) = (first - second, first - 2.0 * second + third);
    let three = first - 3.0 * (second - third) - fourth;
    first + t * (one + 0.5 * (t + 1.0) * (two + (t + 2.0) / 3.0 * three))
}

macro_rules! forward_field {
    ($($pointer:ty),+) => {
        $(impl<F: Field + ?Sized> Field for $pointer {
            #[inline]
            fn potential(&self, height: f64) -> f64 {
                (**self).potential(height)
            }
            #[inline]
            fn acceleration(&self, height: f64) -> f64 {
                (**self).acceleration(height)
            }
        })+
    };
}
forward_field!(&F, Box<F>, Arc<F>);

/// The same acceleration at all heights. [`UniformField::default`] is a = 1, case (a) of the paper.
///
/// ```
/// use gradient_mc::field::{Field, UniformField};
/// assert_eq!(UniformField::default().potential(3.0), 3.0);
/// // A field that pulls up.
/// assert_eq!(UniformField::new(-0.5)?.acceleration(3.0), -0.5);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UniformField {
    acceleration: f64,
}

impl UniformField {
    /// Makes a field with this acceleration, in units of g; 0 is no field.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] if not finite.
    pub fn new(acceleration: f64) -> Result<Self, Error> {
        Ok(Self { acceleration: Error::require_finite("acceleration", acceleration)? })
    }
}

impl Default for UniformField {
    fn default() -> Self {
        Self { acceleration: 1.0 }
    }
}

impl Field for UniformField {
    #[inline]
    fn potential(&self, height: f64) -> f64 {
        self.acceleration * height
    }
    #[inline]
    fn acceleration(&self, _height: f64) -> f64 {
        self.acceleration
    }
}

/// Exponential field a(x) = exp(αx), eq. (1) of doi:10.1103/PhysRevE.83.061306: case (b) of the
/// paper.
///
/// ```
/// use gradient_mc::field::{ExponentialField, Field};
/// let field = ExponentialField::new(0.02)?;
/// assert!((field.acceleration(50.0) - 1f64.exp()).abs() < 1e-14);
/// assert!((field.potential(50.0) - 50.0 * 1f64.exp_m1()).abs() < 1e-12);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExponentialField {
    rate: f64,
}

impl ExponentialField {
    /// Makes a field with rate α in inverse diameters; 0 gives the uniform field.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] if not finite.
    pub fn new(rate: f64) -> Result<Self, Error> {
        Ok(Self { rate: Error::require_finite("rate of the exponential field", rate)? })
    }
}

impl Field for ExponentialField {
    /// (e^{αx} − 1)/α, and x if α = 0.
    #[inline]
    fn potential(&self, height: f64) -> f64 {
        let exponent = self.rate * height;
        // Below this the series x(1 + αx/2) is exact to rounding, and 0/0 is avoided.
        if exponent.abs() < 1e-8 {
            height * (1.0 + 0.5 * exponent)
        } else {
            libm::expm1(exponent) / self.rate
        }
    }
    #[inline]
    fn acceleration(&self, height: f64) -> f64 {
        libm::exp(self.rate * height)
    }
}

/// Linear field a(x) = a₀ + s x.
///
/// ```
/// use gradient_mc::field::{Field, LinearField};
/// let field = LinearField::new(1.0, 0.1)?;
/// assert_eq!((field.acceleration(10.0), field.potential(10.0)), (2.0, 15.0));
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearField {
    base: f64,
    slope: f64,
}

impl LinearField {
    /// Makes a field with acceleration `base` = a₀ at x = 0, in g, and `slope` = s per diameter.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] if not finite.
    pub fn new(base: f64, slope: f64) -> Result<Self, Error> {
        Ok(Self {
            base: Error::require_finite("acceleration at the base", base)?,
            slope: Error::require_finite("slope of the linear field", slope)?,
        })
    }
}

impl Field for LinearField {
    #[inline]
    fn potential(&self, height: f64) -> f64 {
        height * (self.base + 0.5 * self.slope * height)
    }
    #[inline]
    fn acceleration(&self, height: f64) -> f64 {
        self.base + self.slope * height
    }
}

/// The sum of two fields.
///
/// ```
/// use gradient_mc::field::{Field, LinearField, SumField, UniformField};
/// let field = SumField(UniformField::default(), LinearField::new(0.0, 0.1)?);
/// assert_eq!(field.acceleration(10.0), 2.0);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SumField<A, B>(
    /// The first field.
    pub A,
    /// The second field.
    pub B,
);

impl<A: Field, B: Field> Field for SumField<A, B> {
    #[inline]
    fn potential(&self, height: f64) -> f64 {
        self.0.potential(height) + self.1.potential(height)
    }
    #[inline]
    fn acceleration(&self, height: f64) -> f64 {
        self.0.acceleration(height) + self.1.acceleration(height)
    }
}

/// A field from a closure a(x). The potential is integrated once, at construction.
///
/// The potential is a piecewise cubic with 32 nodes per diameter and the values of the closure as
/// slopes. Its error is below 2.5·10⁻⁹ times the third derivative of a. A jump of a at a node, such
/// as a whole number, is exact; a jump between two nodes is spread over 1/32 of a diameter. The
/// last node is the lid; the closure is never evaluated above it.
///
/// ```
/// use gradient_mc::{Slab, field::{Field, FieldFn}};
/// let slab = Slab::new(100.0, 10.0, 10.0)?;
/// let field = FieldFn::new(|height| 1.0 + 0.5 * (height / 10.0).sin(), &slab)?;
/// let exact = 50.0 + 5.0 * (1.0 - 5f64.cos());
/// assert!((field.potential(50.0) - exact).abs() < 1e-9);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Clone)]
pub struct FieldFn<A> {
    acceleration: A,
    /// Potential, acceleration, and acceleration just below, at multiples of [`Self::SPACING`], and
    /// at the lid.
    nodes: Vec<[f64; 3]>,
    /// Height of the lid.
    highest: f64,
}

impl<A> std::fmt::Debug for FieldFn<A> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("FieldFn").field("nodes", &self.nodes.len()).finish_non_exhaustive()
    }
}

impl<A: Fn(f64) -> f64> FieldFn<A> {
    const SPACING: f64 = 1.0 / 32.0;
    /// Distance below a node, relative to its height, at which its lower side is evaluated.
    const BELOW: f64 = 1e-9;
    /// Smallest relative change over this distance that is a jump.
    const JUMP: f64 = 1e-3;

    /// Makes a field from the acceleration `a(x)` in g, for the heights of `slab`.
    ///
    /// # Errors
    /// [`Error::InvalidField`] at the first height where the closure or its integral is not finite.
    pub fn new(acceleration: A, slab: &Slab) -> Result<Self, Error> {
        // The slab's height is at most 1e6, so the count fits.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let panels = (slab.height() / Self::SPACING).ceil() as usize;
        let highest = slab.height();
        let node = |index: usize| (index as f64 * Self::SPACING).min(highest);
        let mut nodes = Vec::with_capacity(panels + 1);
        let mut potential = 0.0_f64;
        for panel in 0..=panels {
            let height = node(panel);
            let value = acceleration(height);
            if !(value.is_finite() && potential.is_finite()) {
                return Err(Error::InvalidField { height, acceleration: value, potential });
            }
            // Without a jump the value of the node is used, so that the bits are the same.
            let below = acceleration(height * (1.0 - Self::BELOW));
            let jumps =
                below.is_finite() && (below - value).abs() > Self::JUMP * below.abs().max(value.abs());
            nodes.push([potential, value, if jumps { below } else { value }]);
            potential += integrate_panel(&acceleration, height, node(panel + 1));
        }
        Ok(Self { acceleration, nodes, highest })
    }
}

impl<A: Fn(f64) -> f64 + Send + Sync> Field for FieldFn<A> {
    fn potential(&self, height: f64) -> f64 {
        let scaled = height / Self::SPACING;
        // Clamped to the table; outside it the cubics of the end panels are used.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let panel = (scaled.max(0.0) as usize).min(self.nodes.len() - 2);
        let [[u0, a0, _], [u1, _, a1]] = [self.nodes[panel], self.nodes[panel + 1]];
        // The last panel ends at the lid.
        let width = (self.highest - panel as f64 * Self::SPACING).min(Self::SPACING);
        let s = (height - panel as f64 * Self::SPACING) / width;
        let (h0, h1) = (a0 * width, a1 * width);
        let rise = u1 - u0;
        u0 + s * (h0 + s * (3.0 * rise - 2.0 * h0 - h1 + s * (h0 + h1 - 2.0 * rise)))
    }
    fn acceleration(&self, height: f64) -> f64 {
        (self.acceleration)(height)
    }
}

/// Checks over the whole slab that a field is finite and its potential is the integral of its
/// acceleration.
pub(crate) fn probe<F: Field>(field: &F, slab: &Slab) -> Result<(), Error> {
    // At least ten probes per diameter: wider steps would miss narrow features and integrate an
    // oscillating field wrongly.
    const LEAST: f64 = 4096.0;
    // Heights are at most 1e6.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let probes = (10.0 * slab.height()).ceil().max(LEAST) as u32;
    let step = slab.height() / f64::from(probes);
    let height_of = |probe: u32| slab.height() * (f64::from(probe) / f64::from(probes));
    let acceleration_at = |x: f64| acceleration_below(field, x, slab.height());
    let (mut integral, mut total_scale, mut total_rounding) = (0.0, 0.0, 0.0_f64);
    for probe in 0..probes {
        let (low, high) = (height_of(probe), height_of(probe + 1));
        for height in [low, high] {
            let (acceleration, potential) = (acceleration_at(height), field.potential(height));
            if !(acceleration.is_finite() && potential.is_finite()) {
                return Err(Error::InvalidField { height, acceleration, potential });
            }
        }
        let potential_difference = field.potential(high) - field.potential(low);
        let offender = Cell::new(None);
        let acceleration_integral = integrate_panel(
            |x| {
                let acceleration = acceleration_at(x);
                if !acceleration.is_finite() {
                    offender.set(Some(x));
                }
                acceleration
            },
            low,
            high,
        );
        if !acceleration_integral.is_finite() {
            let height = offender.get().unwrap_or(0.5 * (low + high));
            let (acceleration, potential) = (acceleration_at(height), field.potential(height));
            return Err(Error::InvalidField { height, acceleration, potential });
        }
        // A loose tolerance: the check finds wrong formulas, and must not reject a jump inside one
        // interval or rounding in a numerical derivative. The error of the rule is at most a tenth
        // of a jump, and a jump is at most twice the largest value.
        let largest = [low, 0.5 * (low + high), high].map(|x| acceleration_at(x).abs()).into_iter();
        let scale = step * largest.fold(0.0, f64::max);
        let rounding = 1e-9 * field.potential(high).abs() + 1e-9;
        if (potential_difference - acceleration_integral).abs() > 0.25 * scale + rounding {
            let height = 0.5 * (low + high);
            return Err(Error::InconsistentField { height, potential_difference, acceleration_integral });
        }
        integral += acceleration_integral;
        total_scale += scale;
        total_rounding = rounding.max(total_rounding);
    }
    // Over the whole slab a tolerance of one per cent is possible, because jumps are few.
    let potential_difference = field.potential(slab.height()) - field.potential(0.0);
    if (potential_difference - integral).abs() > 0.01 * total_scale + total_rounding {
        let height = 0.5 * slab.height();
        return Err(Error::InconsistentField {
            height,
            potential_difference,
            acceleration_integral: integral,
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn exponential_field_is_smooth_through_zero() {
        for height in [0.5, 1.0, 50.0, 399.5] {
            let uniform = UniformField::default().potential(height);
            for rate in [0.0, 1e-18, -1e-16, 1e-15] {
                let potential = ExponentialField::new(rate).unwrap().potential(height);
                assert_relative_eq!(potential, uniform, max_relative = 1e-12);
            }
            // Either side of the switch between the series and expm1.
            let rate = 1e-8 / height;
            let below = ExponentialField::new(rate * (1.0 - 1e-9)).unwrap().potential(height);
            let above = ExponentialField::new(rate * (1.0 + 1e-9)).unwrap().potential(height);
            assert_relative_eq!(below, above, max_relative = 1e-15);
        }
    }

    #[test]
    fn a_field_whose_parts_disagree_is_refused() {
        struct Wrong;
        impl Field for Wrong {
            fn potential(&self, height: f64) -> f64 {
                height
            }
            fn acceleration(&self, _: f64) -> f64 {
                -1.0
            }
        }
        let slab = Slab::new(50.0, 5.0, 5.0).unwrap();
        assert!(matches!(probe(&Wrong, &slab), Err(Error::InconsistentField { .. })));
        assert!(probe(&ExponentialField::new(0.1).unwrap(), &slab).is_ok());
        assert!(probe(&&UniformField::default(), &slab).is_ok());
    }

    #[test]
    fn a_field_that_jumps_is_not_taken_for_wrong() {
        struct Jumping(f64);
        impl Field for Jumping {
            fn potential(&self, height: f64) -> f64 {
                if height < self.0 { height } else { self.0 - 0.9 * (height - self.0) }
            }
            fn acceleration(&self, height: f64) -> f64 {
                if height < self.0 { 1.0 } else { -0.9 }
            }
        }
        struct Kinked(f64);
        impl Field for Kinked {
            fn potential(&self, height: f64) -> f64 {
                Jumping(self.0).potential(height)
            }
        }
        let slab = Slab::new(50.0, 5.0, 5.0).unwrap();
        // Everywhere inside an interval of the probe.
        for part in 0..100 {
            let height = 20.0 + 50.0 / 4096.0 * f64::from(part) / 100.0;
            assert!(probe(&Jumping(height), &slab).is_ok());
            assert!(probe(&Kinked(height), &slab).is_ok());
        }
    }
}
