//! Bins of equal height.

use crate::{Error, Slab};

/// Largest number of bins of a profile.
pub const MAXIMUM_BINS: usize = 65_536;

/// Largest number of parts of bins, [`Bins::divided`].
const MAXIMUM_STRETCHES: usize = 1 << 20;

/// Bins of equal height over a range of heights, given by their number or by their width.
///
/// The range is the whole slab unless [`from`](Self::from) or [`to`](Self::to) change it. If the
/// width does not divide the range, the number of bins is range over width, rounded, so the width
/// changes slightly and all bins are equal.
///
/// ```
/// use gradient_mc::Slab;
/// use gradient_mc::observers::{Bins, DensityProfile};
/// let slab = Slab::new(60.0, 6.0, 6.0)?;
/// let coarse = DensityProfile::new(&slab, Bins::of_width(0.5))?;
/// // From where the centers of spheres begin: 20 bins of 0.05 diameters.
/// let near_base = DensityProfile::new(&slab, Bins::count(20).from(0.5).to(1.5))?;
/// assert_eq!((coarse.means().len(), near_base.means().len()), (120, 20));
/// # Ok::<(), gradient_mc::Error>(())
/// ```
///
/// # Errors
/// Constructors that take bins return
/// - [`Error::InvalidBins`] if the number of bins is not between 1 and [`MAXIMUM_BINS`];
/// - [`Error::InvalidParameter`] if the width is not positive or larger than the range, or not 0 ≤
///   lowest < highest ≤ height of the slab.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bins {
    size: Size,
    low: Option<f64>,
    high: Option<f64>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Size {
    Count(usize),
    Width(f64),
}

impl Bins {
    /// A given number of bins.
    #[must_use]
    pub const fn count(bins: usize) -> Self {
        Self { size: Size::Count(bins), low: None, high: None }
    }

    /// Bins of about this height, in diameters.
    #[must_use]
    pub const fn of_width(width: f64) -> Self {
        Self { size: Size::Width(width), low: None, high: None }
    }

    /// Sets the lower end of the range to `low` instead of the base, in diameters.
    #[must_use]
    pub const fn from(self, low: f64) -> Self {
        Self { low: Some(low), ..self }
    }

    /// Sets the upper end of the range to `high` instead of the lid, in diameters.
    #[must_use]
    pub const fn to(self, high: f64) -> Self {
        Self { high: Some(high), ..self }
    }

    /// The bins of a slab.
    pub(super) fn of(self, slab: &Slab) -> Result<HeightBins, Error> {
        let (low, high) = (self.low.unwrap_or(0.0), self.high.unwrap_or(slab.height()));
        let extent = high - low;
        let count = match self.size {
            Size::Count(count) => count,
            // An invalid range is refused below.
            Size::Width(width) if extent > 0.0 => {
                if !(width > 0.0 && width <= extent) {
                    let requirement = "it must be positive and at most the range of heights";
                    return Err(Error::InvalidParameter {
                        name: "width of a bin",
                        value: width,
                        requirement,
                    });
                }
                // At least one. Too large a number is refused below.
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                let count = (extent / width).round() as usize;
                count
            }
            Size::Width(_) => 1,
        };
        HeightBins::new(slab, low, high, count)
    }
}

/// Position of a height relative to the bins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Place {
    Below,
    /// In a bin: index, and distance from its lower edge over its height.
    Inside(usize, f64),
    Above,
}

/// A range of heights of one slab, divided evenly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct HeightBins {
    slab: Slab,
    low: f64,
    high: f64,
    count: usize,
    per_diameter: f64,
}

impl HeightBins {
    /// Divides the heights from `low` to `high`.
    pub(super) fn new(slab: &Slab, low: f64, high: f64, count: usize) -> Result<Self, Error> {
        for (name, value) in [("lowest height of the bins", low), ("highest height of the bins", high)] {
            if !(0.0..=slab.height()).contains(&value) {
                let requirement = "it must lie between the walls of the slab";
                return Err(Error::InvalidParameter { name, value, requirement });
            }
        }
        let extent = high - low;
        let per_diameter = count as f64 / extent;
        if extent <= 0.0 || !per_diameter.is_finite() {
            return Err(Error::InvalidParameter {
                name: "highest height of the bins",
                value: high,
                requirement: "it must be above the lowest",
            });
        }
        if count == 0 || count > MAXIMUM_BINS {
            return Err(Error::InvalidBins { bins: count, extent, maximum: MAXIMUM_BINS });
        }
        Ok(Self { slab: *slab, low, high, count, per_diameter })
    }

    pub(super) fn count(&self) -> usize {
        self.count
    }

    pub(super) fn lowest_center(&self) -> f64 {
        self.slab.lowest_center()
    }

    pub(super) fn base_area(&self) -> f64 {
        self.slab.base_area()
    }

    /// Volume of a bin.
    pub(super) fn volume(&self) -> f64 {
        self.base_area() / self.per_diameter
    }

    /// Volume of the part of a bin in which centers can be.
    pub(super) fn accessible_volume(&self, bin: usize) -> f64 {
        let edge = |bin: usize| self.low + bin as f64 / self.per_diameter;
        let (low, high) =
            (edge(bin).max(self.slab.lowest_center()), edge(bin + 1).min(self.slab.highest_center()));
        // A smaller value is only rounding of an edge.
        let accessible = (high - low) * self.per_diameter;
        if accessible > 1e-9 { accessible.min(1.0) * self.volume() } else { 0.0 }
    }

    /// Each bin divided into a whole number of parts at most `width` high, as far as
    /// [`MAXIMUM_STRETCHES`] allows.
    pub(super) fn divided(&self, width: f64) -> Self {
        let extent = 1.0 / self.per_diameter;
        // At least 1 and at most the limit.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let wanted = (extent / width).ceil().clamp(1.0, MAXIMUM_STRETCHES as f64) as usize;
        let parts = wanted.min(MAXIMUM_STRETCHES / self.count).max(1);
        Self { count: self.count * parts, per_diameter: self.per_diameter * parts as f64, ..*self }
    }

    /// Middles of the bins, upwards.
    pub(super) fn centers(&self) -> impl ExactSizeIterator<Item = f64> + use<> {
        let Self { low, per_diameter, .. } = *self;
        (0..self.count).map(move |bin| low + (bin as f64 + 0.5) / per_diameter)
    }

    /// The bins that are at least partly accessible to centers, upwards.
    pub(super) fn within_reach(&self) -> impl Iterator<Item = usize> + use<> {
        let Self { slab, low, per_diameter, count, .. } = *self;
        let edge = move |bin: usize| low + bin as f64 / per_diameter;
        (0..count)
            .filter(move |&bin| edge(bin + 1) > slab.lowest_center() && edge(bin) < slab.highest_center())
    }

    /// The bin of a height; the upper edge of the range belongs to the last bin.
    #[inline]
    pub(super) fn locate(&self, height: f64) -> Place {
        if height < self.low {
            return Place::Below;
        }
        if height > self.high {
            return Place::Above;
        }
        let scaled = (height - self.low) * self.per_diameter;
        // Not negative; `as` converts NaN to bin 0.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let bin = (scaled as usize).min(self.count - 1);
        Place::Inside(bin, scaled - bin as f64)
    }

    /// Calls `add` with every bin that the range from `low` to `high` overlaps, and the fraction of
    /// the range in this bin.
    #[inline]
    pub(super) fn spread(&self, low: f64, high: f64, mut add: impl FnMut(usize, f64)) {
        if high < self.low || low > self.high {
            return;
        }
        let scaled = |height: f64| (height - self.low) * self.per_diameter;
        let last = self.count as f64;
        let (first, end) = (scaled(low).max(0.0), scaled(high).min(last));
        // Not negative, and at most the number of bins.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let (mut bin, last_bin) = ((first as usize).min(self.count - 1), (end as usize).min(self.count - 1));
        if low >= high {
            add(bin, 1.0);
            return;
        }
        let extent = (high - low) * self.per_diameter;
        let mut begin = first;
        while bin < last_bin {
            let edge = (bin + 1) as f64;
            add(bin, (edge - begin) / extent);
            (begin, bin) = (edge, bin + 1);
        }
        add(bin, (end - begin) / extent);
    }

    /// Fails if a profile on the bins `other` cannot be merged with one on these.
    pub(super) fn require_same(&self, other: &Self) -> Result<(), Error> {
        let requirement = "profiles can only be pooled if their slabs and bins are the same";
        for (name, mine, value) in [
            ("number of bins", self.count as f64, other.count as f64),
            ("lowest height of the bins", self.low, other.low),
            ("highest height of the bins", self.high, other.high),
            ("height of the slab", self.slab.height(), other.slab.height()),
            ("width along y", self.slab.widths()[0], other.slab.widths()[0]),
            ("width along z", self.slab.widths()[1], other.slab.widths()[1]),
        ] {
            if mine.to_bits() != value.to_bits() {
                return Err(Error::InvalidParameter { name, value, requirement });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_height_has_its_bin() {
        let slab = Slab::new(40.0, 5.0, 5.0).unwrap();
        let bins = HeightBins::new(&slab, 0.5, 39.5, 390).unwrap();
        assert_eq!(bins.locate(0.49), Place::Below);
        assert_eq!(bins.locate(39.51), Place::Above);
        assert_eq!(bins.locate(0.5), Place::Inside(0, 0.0));
        let Place::Inside(last, fraction) = bins.locate(39.5) else { panic!("the upper edge is inside") };
        assert_eq!(last, 389);
        approx::assert_relative_eq!(fraction, 1.0, epsilon = 1e-12);
        for (bin, center) in bins.centers().enumerate() {
            let Place::Inside(found, fraction) = bins.locate(center) else { panic!("{center} is inside") };
            assert_eq!(found, bin);
            approx::assert_relative_eq!(fraction, 0.5, epsilon = 1e-12);
        }
    }

    #[test]
    fn a_stretch_is_spread_over_its_bins() {
        let slab = Slab::new(40.0, 5.0, 5.0).unwrap();
        let bins = HeightBins::new(&slab, 1.0, 3.0, 4).unwrap();
        let spread = |low: f64, high: f64| {
            let mut parts = [0.0; 4];
            bins.spread(low, high, |bin, part| parts[bin] += part);
            parts
        };
        for (low, high, expected) in [
            (1.1, 1.4, [1.0, 0.0, 0.0, 0.0]),
            (1.25, 2.25, [0.25, 0.5, 0.25, 0.0]),
            (2.2, 2.2, [0.0, 0.0, 1.0, 0.0]),
            (0.5, 1.5, [0.5, 0.0, 0.0, 0.0]),
            (2.5, 3.5, [0.0, 0.0, 0.0, 0.5]),
            (0.0, 4.0, [0.125; 4]),
            (0.2, 0.9, [0.0; 4]),
            (3.1, 3.9, [0.0; 4]),
        ] {
            for (part, expected) in spread(low, high).into_iter().zip(expected) {
                assert!((part - expected).abs() < 1e-12, "{low} to {high}: {:?}", spread(low, high));
            }
        }
    }

    #[test]
    fn senseless_bins_are_refused() {
        let slab = Slab::new(40.0, 5.0, 5.0).unwrap();
        let over = |slab, count| Bins::count(count).of(slab);
        assert!(matches!(over(&slab, 0), Err(Error::InvalidBins { bins: 0, .. })));
        assert!(matches!(over(&slab, MAXIMUM_BINS + 1), Err(Error::InvalidBins { .. })));
        assert!(over(&slab, MAXIMUM_BINS).is_ok());
        for (low, high) in
            [(-1.0, 2.0), (0.0, 41.0), (3.0, 3.0), (5.0, 4.0), (f64::NAN, 2.0), (0.0, f64::NAN)]
        {
            assert!(matches!(HeightBins::new(&slab, low, high, 10), Err(Error::InvalidParameter { .. })));
        }
        // So narrow that the number of bins per diameter overflows.
        assert!(HeightBins::new(&slab, 0.0, f64::MIN_POSITIVE, MAXIMUM_BINS).is_err());
    }

    #[test]
    fn a_width_becomes_the_nearest_that_divides_the_range() {
        let slab = Slab::new(40.0, 5.0, 5.0).unwrap();
        for (bins, low, high, count) in [
            (Bins::of_width(0.5), 0.0, 40.0, 80),
            (Bins::of_width(0.1).from(0.5).to(39.5), 0.5, 39.5, 390),
            (Bins::of_width(1.0).to(2.4), 0.0, 2.4, 2),
            (Bins::of_width(1.0).from(37.4), 37.4, 40.0, 3),
            (Bins::of_width(40.0), 0.0, 40.0, 1),
            (Bins::of_width(22.0), 0.0, 40.0, 2),
            (Bins::count(7).from(3.0).to(4.0), 3.0, 4.0, 7),
        ] {
            assert_eq!(bins.of(&slab).unwrap(), HeightBins::new(&slab, low, high, count).unwrap());
        }
        for width in [0.0, -1.0, 40.1, f64::NAN, f64::INFINITY] {
            let refused = Bins::of_width(width).of(&slab);
            assert!(
                matches!(refused, Err(Error::InvalidParameter { name: "width of a bin", .. })),
                "{refused:?}"
            );
        }
        assert!(matches!(Bins::of_width(1e-9).of(&slab), Err(Error::InvalidBins { .. })));
        assert!(matches!(
            Bins::of_width(1.0).from(3.0).to(2.0).of(&slab),
            Err(Error::InvalidParameter { name: "highest height of the bins", .. })
        ));
    }
}
