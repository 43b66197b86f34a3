//! The kinds of warnings.

use crate::Warning;
use std::fmt;

macro_rules! kinds {
    ($($variant:ident $words:literal),+ $(,)?) => {
        /// The kind of a [`Warning`], without its numbers, to count and filter warnings.
        ///
        /// ```
        /// use gradient_mc::{Scene, Simulation, Slab, WarningKind};
        /// use gradient_mc::{field::UniformField, temperature::Isothermal};
        /// let slab = Slab::new(60.0, 6.0, 6.0)?;
        /// let scene = Scene::new(slab, 360, UniformField::default(), Isothermal::new(5.0)?)?;
        /// let mut simulation = Simulation::builder(scene).build()?;
        /// simulation.run(10, &mut ())?;
        /// let kinds: Vec<WarningKind> = simulation.warnings().iter().map(|warning| warning.kind()).collect();
        /// assert_eq!(kinds, [WarningKind::TooShort]);
        /// assert_eq!(kinds[0].to_string(), "too short to be judged");
        /// # Ok::<(), gradient_mc::Error>(())
        /// ```
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[non_exhaustive]
        pub enum WarningKind {
            $(
                #[doc = concat!("[`Warning::", stringify!($variant), "`]")]
                $variant,
            )+
        }

        impl Warning {
            /// The kind of this warning.
            #[must_use]
            pub fn kind(&self) -> WarningKind {
                match self {
                    $(Self::$variant { .. } => WarningKind::$variant,)+
                }
            }
        }

        impl fmt::Display for WarningKind {
            fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.pad(match self {
                    $(Self::$variant => $words,)+
                })
            }
        }
    };
}
kinds! {
    TooShort "too short to be judged",
    LowAcceptance "low acceptance",
    NotMixed "not mixed",
    NothingMoved "nothing has moved",
    FarFromTheory "far from theory",
    FeedbackNotConverged "feedback not converged",
    FieldOfTheory "field of the theory",
    CountingNoise "counting noise",
    ChangesWhileMeasuring "changes while measuring",
    LidTooLow "lid too low",
    Metastable "beyond freezing",
    BoxIncommensurate "box incommensurate",
    NarrowBox "narrow box",
    EmptyBins "empty bins",
    ThinBins "thin bins",
    CorrelatedBins "correlated bins",
    ReplicasDisagree "replicas disagree",
    RoutesDisagree "ranks and collisions disagree",
    WideBins "wide bins",
    OutsideDomain "outside the domain",
    InaccurateEquation "inaccurate equation of state",
    SteepGradient "steep gradient",
    DensityJump "density jump",
    NoTheory "no theory",
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    #[test]
    fn warnings_can_be_counted_by_kind() {
        let warnings = [
            Warning::NoTheory { height: 1.0 },
            Warning::TooShort { sweeps: 1, needed: 2 },
            Warning::NoTheory { height: f64::NAN },
        ];
        let mut counts = HashMap::new();
        for warning in &warnings {
            *counts.entry(warning.kind()).or_insert(0) += 1;
        }
        assert_eq!(counts, HashMap::from([(WarningKind::NoTheory, 2), (WarningKind::TooShort, 1)]));
        assert_eq!(format!("{:>12}|", WarningKind::NoTheory), "   no theory|");
    }
}
