//! Warnings about a theory profile.

use super::HydrostaticProfile;
use crate::Warning;
use crate::equation_of_state::packing_fraction;

impl HydrostaticProfile {
    /// Number of probes of a column, at equal shares of the spheres.
    const PROBES: u32 = 512;
    /// Largest |d ln n/dx|, per diameter, at which a local density is meaningful.
    const STEEPEST: f64 = 0.5;
    /// Smallest share of the spheres that matters.
    const LEAST_SHARE: f64 = 0.01;
    /// Pressure on the lid over the largest pressure. Up to it, P(x) is right within one per cent
    /// down to a tenth of the largest pressure.
    pub(crate) const LARGEST_LID_PRESSURE: f64 = 1e-3;
    /// Largest relative error of Z.
    const LARGEST_DEVIATION: f64 = 0.01;
    /// Smallest jump of ln n; less is rounding.
    const SMALLEST_JUMP: f64 = 0.01;

    /// Warnings about this profile: [`Warning::OutsideDomain`], [`Warning::InaccurateEquation`],
    /// [`Warning::SteepGradient`], [`Warning::DensityJump`] (the largest), and
    /// [`Warning::LidTooLow`]. With the last one the profile is right, but a pressure computed from
    /// the weight of the spheres above is not.
    ///
    /// ```
    /// use gradient_mc::equation_of_state::CarnahanStarling;
    /// use gradient_mc::{Hydrostatics, Warning, field::UniformField, temperature::Isothermal};
    /// let column = |temperature: f64| {
    ///     Hydrostatics::new(UniformField::default(), Isothermal::new(temperature)?, CarnahanStarling).column_density(40.0)
    /// };
    /// assert!(column(15.0)?.warnings().is_empty());
    /// // At a low temperature the base freezes.
    /// assert!(matches!(column(2.5)?.warnings()[..], [Warning::OutsideDomain { .. }]));
    /// # Ok::<(), gradient_mc::Error>(())
    /// ```
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        let mut warnings = Vec::new();
        if let Some(exit) = self.domain_exit() {
            warnings.push(Warning::OutsideDomain { exit });
        } else if self.deviation_of_equation().abs() > Self::LARGEST_DEVIATION {
            let (height, density) = self.density_maximum();
            let (packing_fraction, deviation) = (packing_fraction(density), self.deviation_of_equation());
            warnings.push(Warning::InaccurateEquation { height, packing_fraction, deviation });
        }
        warnings.extend(self.steep_gradient());
        warnings.extend(self.largest_jump());
        // The open end is the wall with the lower pressure.
        let ends = [(self.base(), self.base_pressure()), (self.top(), self.lid_pressure())];
        let (wall, smallest) = if ends[0].1 < ends[1].1 { ends[0] } else { ends[1] };
        let pressure_ratio = smallest / ends[0].1.max(ends[1].1);
        if pressure_ratio > Self::LARGEST_LID_PRESSURE {
            warnings.push(Warning::LidTooLow { lid: wall, pressure_ratio });
        }
        warnings
    }

    /// Slopes are differences of ln n over half a diameter.
    fn steep_gradient(&self) -> Option<Warning> {
        const HALF: f64 = 0.25;
        let slope = |height: f64| {
            let low = (height - HALF).max(self.base());
            let high = (height + HALF).min(self.top());
            (libm::log(self.number_density(high)) - libm::log(self.number_density(low))) / (high - low)
        };
        let (mut steep, mut steepest) = (0, (self.base(), 0.0_f64));
        for probe in 0..Self::PROBES {
            let height = self.height_of_fraction((f64::from(probe) + 0.5) / f64::from(Self::PROBES));
            let slope = slope(height);
            if slope.abs() > Self::STEEPEST {
                steep += 1;
            }
            if slope.abs() > steepest.1.abs() {
                steepest = (height, slope);
            }
        }
        let share = f64::from(steep) / f64::from(Self::PROBES);
        let (height, slope) = steepest;
        (share > Self::LEAST_SHARE).then_some(Warning::SteepGradient { height, slope, share })
    }

    fn largest_jump(&self) -> Option<Warning> {
        let size = |[below, above]: [f64; 2]| libm::log(above / below).abs();
        let jumps = self.jumps().filter(|(_, edges)| size(*edges) > Self::SMALLEST_JUMP);
        let largest = jumps.max_by(|(_, one), (_, other)| size(*one).total_cmp(&size(*other)));
        largest.map(|(height, [below, above])| Warning::DensityJump { height, below, above })
    }
}
