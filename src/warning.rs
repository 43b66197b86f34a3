//! Warnings: reasons why a result may be wrong.

mod evidence;

pub use evidence::{Disagreement, MixingEvidence, Quantity};

use crate::drive::{Certificate, MeasuredShare};
use crate::hydrostatics::DomainExit;
use crate::statistics::{Estimate, FEWEST_INDEPENDENT};
use std::fmt;

/// A reason why a run, a profile or a theory may be wrong, with the numbers that show how much.
///
/// [`Simulation::warnings`](crate::Simulation::warnings) checks a production run,
/// [`HydrostaticProfile::warnings`](crate::HydrostaticProfile::warnings) a theory profile, and the
/// `warnings` of the profiles in [`observers`](crate::observers) their bins. Each warning prints as
/// one line: what is wrong, where, the numbers, and what to do. No warnings is no proof of
/// correctness. Heights and lengths are in diameters.
///
/// ```
/// use gradient_mc::{Scene, Slab, Warning, equation_of_state::ModifiedKolafa};
/// use gradient_mc::{Hydrostatics, field::UniformField, temperature::Isothermal};
/// let (field, temperature, slab) = (UniformField::default(), Isothermal::new(15.0)?, Slab::new(60.0, 5.0, 5.0)?);
/// let theory = Hydrostatics::new(field, temperature, ModifiedKolafa).between_walls(&slab, 10.0)?;
/// let warnings = theory.warnings();
/// assert!(warnings.iter().any(|warning| matches!(warning, Warning::LidTooLow { .. })));
/// assert!(warnings[0].to_string().starts_with("the lid is too low"));
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// Production is too short to be judged.
    #[non_exhaustive]
    TooShort {
        /// Sweeps of production so far.
        sweeps: u64,
        /// Smallest number of sweeps that can be judged.
        needed: u64,
    },
    /// The acceptance of local moves is very low in a range of heights, and there are no other
    /// moves.
    #[non_exhaustive]
    LowAcceptance {
        /// Lower end of the range.
        lowest_height: f64,
        /// Upper end of the range.
        highest_height: f64,
        /// Acceptance in the range, from 0 to 1.
        acceptance: f64,
        /// Fraction of the spheres that are in the range.
        share: f64,
    },
    /// Production is not equilibrated, or too short for its slowest quantity.
    #[non_exhaustive]
    NotMixed {
        /// Sweeps of production so far.
        sweeps: u64,
        /// The observation that shows it.
        evidence: MixingEvidence,
    },
    /// No sphere has moved.
    NothingMoved {
        /// Sweeps of production so far.
        sweeps: u64,
    },
    /// The mean height of the center of mass differs from the theory, in a scene where the theory
    /// is accurate.
    #[non_exhaustive]
    FarFromTheory {
        /// Mean height of the center of mass, with the standard error of the run.
        center_of_mass: Estimate,
        /// Height of the center of mass by
        /// [`Hydrostatics::between_walls`](crate::Hydrostatics::between_walls).
        theory: f64,
    },
    /// The effective field is not self-consistent, or production is too short to decide.
    #[non_exhaustive]
    FeedbackNotConverged {
        /// The certificate, which compares the forces of the field with the weight of the column.
        certificate: Certificate,
    },
    /// The effective field comes mostly from the theory; only a small part of it was measured.
    #[non_exhaustive]
    FieldOfTheory {
        /// The part that was measured.
        measured: MeasuredShare,
    },
    /// The effective field comes from the counts of single configurations, and their noise biases
    /// it ([`Instantaneous`](crate::drive::Instantaneous)).
    #[non_exhaustive]
    CountingNoise {
        /// Number of spheres in a bin of the field, averaged over spheres.
        spheres_per_bin: f64,
        /// Predicted P/(nTZ) − 1 at the base, for moves that cross bins; infinite if the column has
        /// no steady state.
        pressure_deviation: f64,
    },
    /// The reduced potential changed during production, which breaks detailed balance.
    #[non_exhaustive]
    ChangesWhileMeasuring {
        /// Number of changes since production began.
        changes: u64,
    },
    /// The wall at the open end of the column (the lid if the field pulls down) carries pressure.
    /// P(x) from the weight of the column leaves this pressure out unless `set_open_end_pressure`
    /// adds it.
    #[non_exhaustive]
    LidTooLow {
        /// Height of this wall.
        lid: f64,
        /// Pressure on this wall divided by the largest pressure in the column.
        pressure_ratio: f64,
    },
    /// Pressure or density are above those of freezing. A fluid there is metastable, and the
    /// structure of a crystal or a glass depends on the history of the run.
    #[non_exhaustive]
    Metastable {
        /// Lower end of the range.
        lowest_height: f64,
        /// Upper end of the range.
        highest_height: f64,
        /// Largest packing fraction measured in the range, averaged over layers.
        packing_fraction: f64,
    },
    /// The column freezes, and the crystal at its dense end does not fit the periodic widths
    /// without strain.
    #[non_exhaustive]
    BoxIncommensurate {
        /// Largest principal strain of hexagonal layers, in the orientation that fits best.
        strain: f64,
        /// Narrower periodic width.
        width: f64,
        /// Distance of nearest neighbors in the unstrained crystal.
        lattice_constant: f64,
    },
    /// The box is so narrow that spheres of a dense layer are correlated with their own periodic
    /// images.
    #[non_exhaustive]
    NarrowBox {
        /// Narrower periodic width.
        width: f64,
        /// Packing fraction at the densest height.
        packing_fraction: f64,
    },
    /// Bins inside the column in which no sphere was ever recorded.
    #[non_exhaustive]
    EmptyBins {
        /// Number of such bins.
        bins: usize,
        /// Middle of the lowest of these bins.
        lowest_height: f64,
        /// Middle of the highest of these bins.
        highest_height: f64,
    },
    /// Bins inside the column that were occupied too seldom for a standard error.
    #[non_exhaustive]
    ThinBins {
        /// Number of such bins.
        bins: usize,
        /// Middle of the lowest of these bins.
        lowest_height: f64,
        /// Middle of the highest of these bins.
        highest_height: f64,
        /// Number of blocks of frames in which the worst of these bins was occupied.
        blocks: usize,
    },
    /// Bins inside the column with too few independent configurations: their error bars are too
    /// small or very uncertain.
    #[non_exhaustive]
    CorrelatedBins {
        /// Middle of the lowest bin of the range that was judged.
        lowest_height: f64,
        /// Middle of the highest of these bins.
        highest_height: f64,
        /// Effective number of independent configurations.
        effective_sample_size: f64,
    },
    /// Merged replicas differ by more than their standard errors: not all have reached the same
    /// state.
    #[non_exhaustive]
    ReplicasDisagree {
        /// The quantity in which they differ.
        disagreement: Disagreement,
    },
    /// Bins so wide that P/(nT) from the mean density of a bin differs from a local equation of
    /// state.
    #[non_exhaustive]
    WideBins {
        /// Height of a bin.
        bin_width: f64,
        /// Middle of the worst bin.
        height: f64,
        /// Estimated relative error of P/(nT) in this bin: (Δx d ln n/dx)²/24.
        bias: f64,
    },
    /// An equation of state is used outside its domain.
    #[non_exhaustive]
    OutsideDomain {
        /// The heights at which the domain is left, and the packing fraction.
        exit: DomainExit,
    },
    /// An equation of state is used at a density where it is inaccurate for hard spheres.
    #[non_exhaustive]
    InaccurateEquation {
        /// Height at which the density is largest.
        height: f64,
        /// Packing fraction there.
        packing_fraction: f64,
        /// Relative deviation of its Z from that of the best equation
        /// ([`FluidSolid`](crate::equation_of_state::FluidSolid)).
        deviation: f64,
    },
    /// The density changes by a factor of order e within one diameter, where a local equation of
    /// state is wrong.
    #[non_exhaustive]
    SteepGradient {
        /// Height at which the density is steepest.
        height: f64,
        /// d ln n/dx there, in inverse diameters.
        slope: f64,
        /// Fraction of the spheres at heights where the slope is too steep.
        share: f64,
    },
    /// Ranks and collisions give different equations of state
    /// ([`MeasuredEquationOfState`](crate::observers::MeasuredEquationOfState)).
    #[non_exhaustive]
    RoutesDisagree {
        /// Packing fraction at which they differ most, of those that were compared.
        packing_fraction: f64,
        /// Z there by ranks.
        ranks: Estimate,
        /// Z there by collisions.
        collisions: Estimate,
    },
    /// The density of the theory has a jump: at a jump of the temperature, or between fluid and
    /// solid.
    #[non_exhaustive]
    DensityJump {
        /// Height of the jump.
        height: f64,
        /// Number density just below.
        below: f64,
        /// Number density just above.
        above: f64,
    },
    /// The hydrostatic theory has no solution for this scene, so the run was not compared with it.
    #[non_exhaustive]
    NoTheory {
        /// Height at which the solution stopped; NaN if no height is known.
        height: f64,
    },
}

/// If the wall carries a larger part of the largest pressure, the scene is a closed box and not a
/// column that ends below its lid.
const CLOSED: f64 = 0.3;

impl fmt::Display for Warning {
    #[allow(clippy::too_many_lines, reason = "one arm for each variant")]
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooShort { sweeps, needed } => write!(
                formatter,
                "too short to be judged: {sweeps} sweeps of production, at least {needed} are needed: run longer"
            ),
            Self::LowAcceptance { lowest_height, highest_height, acceptance, share } => write!(
                formatter,
                "low acceptance: {:.2} % of the local moves are accepted between heights {lowest_height:.1} and \
                {highest_height:.1}, where {:.0} % of the spheres are: use smaller displacements, LocalMoves::tuned or EventChains",
                100.0 * acceptance,
                100.0 * share,
            ),
            Self::NotMixed { sweeps, evidence } => write!(
                formatter,
                "not mixed after {sweeps} sweeps of production: {evidence}: equilibrate and run longer, or use \
                EventChains or LocalMoves::tuned"
            ),
            Self::NothingMoved { sweeps } => write!(
                formatter,
                "nothing has moved in {sweeps} sweeps of production: the spheres are jammed, or the displacements are \
                too large: use LocalMoves::tuned or EventChains, equilibrate first, or start from another configuration"
            ),
            Self::FarFromTheory { center_of_mass, theory } => write!(
                formatter,
                "far from theory: the mean height of the center of mass is {center_of_mass}, but {theory:.3} by hydrostatics: \
                 equilibrate longer, or start from the theory profile"
            ),
            Self::FeedbackNotConverged { certificate } => {
                let text = certificate.to_string();
                write!(formatter, "feedback not converged {}", text.trim_start_matches("NOT CONVERGED "))
            }
            Self::FieldOfTheory { measured } => write!(
                formatter,
                "field of the theory: only {measured} of the effective field was measured: equilibrate longer, with \
                EventChains, whose collisions measure the field in the bulk"
            ),
            Self::CountingNoise { spheres_per_bin, pressure_deviation } => write!(
                formatter,
                "counting noise in the field: {spheres_per_bin:.1} spheres per bin bias P at the base by up to \
                {:.2} %: use SelfConsistent, wider bins or a larger base",
                100.0 * pressure_deviation,
            ),
            Self::ChangesWhileMeasuring { changes } => write!(
                formatter,
                "changes while measuring: the effective field changed {changes} times during production, which breaks \
                detailed balance: use a scheme that freezes the field"
            ),
            Self::LidTooLow { lid, pressure_ratio } if *pressure_ratio > CLOSED => write!(
                formatter,
                "closed box: the wall at height {lid:.1} carries {:.2} % of the largest pressure, and P(x) from \
                the weight of the column leaves this out: measure it (WallPressure) and add it (set_open_end_pressure)",
                100.0 * pressure_ratio,
            ),
            Self::LidTooLow { lid, pressure_ratio } => write!(
                formatter,
                "the lid is too low: the wall at height {lid:.1}, where the column ends, carries {:.2} % of the largest \
                 pressure: raise the lid, or measure the pressure on that wall (WallPressure) and add it \
                 (set_open_end_pressure)",
                100.0 * pressure_ratio,
            ),
            Self::Metastable { lowest_height, highest_height, packing_fraction } => write!(
                formatter,
                "beyond freezing between heights {lowest_height:.1} and {highest_height:.1}, up to packing fraction \
                {packing_fraction:.3}: a fluid there is metastable, and a solid depends on the history of the run: compare \
                runs from a dense and a dilute start, or use a hotter or lighter column"
            ),
            Self::BoxIncommensurate { strain, width, lattice_constant } => write!(
                formatter,
                "box incommensurate: the crystal (neighbors {lattice_constant:.3} apart) is strained by {:.1} % to fit the base \
                (width {width:.2}): use widths that hold whole rows of spheres, or a larger base",
                100.0 * strain,
            ),
            Self::NarrowBox { width, packing_fraction } => write!(
                formatter,
                "narrow box: at packing fraction {packing_fraction:.2} spheres are correlated with their own \
                periodic images {width:.2} away: use a wider base"
            ),
            Self::EmptyBins { bins, lowest_height, highest_height } => write!(
                formatter,
                "empty bins: {bins} bins between heights {lowest_height:.2} and {highest_height:.2} never held a sphere: \
                use wider bins or run longer"
            ),
            Self::ThinBins { bins, lowest_height, highest_height, blocks } => write!(
                formatter,
                "thin bins: {bins} bins between heights {lowest_height:.2} and {highest_height:.2} were occupied in too few \
                blocks of frames for an error bar, the worst in {blocks}: use wider bins or run longer"
            ),
            Self::CorrelatedBins { lowest_height, highest_height, effective_sample_size } => write!(
                formatter,
                "correlated bins: the effective number of independent configurations is only {effective_sample_size:.1} \
                 between heights {lowest_height:.2} and {highest_height:.2}, at least {FEWEST_INDEPENDENT} are needed: run longer"
            ),
            Self::RoutesDisagree { packing_fraction, ranks, collisions } => write!(
                formatter,
                "ranks and collisions disagree: at packing fraction {packing_fraction:.3} Z is {ranks} by ranks \
                and {collisions} by collisions: the column is not stationary: equilibrate longer"
            ),
            Self::ReplicasDisagree { disagreement } => write!(
                formatter,
                "replicas disagree: {disagreement}: equilibrate longer, and read the warnings of each replica"
            ),
            Self::WideBins { bin_width, height, bias } => write!(
                formatter,
                "wide bins: over a bin of {bin_width:.2} at height {height:.1} the density changes so much that P/(nT) \
                from its mean is off by about {:.1} %: use narrower bins",
                100.0 * bias,
            ),
            Self::OutsideDomain { exit } => write!(
                formatter,
                "outside the domain of the equation of state between heights {:.2} and {:.2}: packing fraction {:.4} is \
                beyond its limit {:.4}: use an equation that is valid there (FluidSolid)",
                exit.lowest_height, exit.highest_height, exit.packing_fraction, exit.limit,
            ),
            Self::InaccurateEquation { height, packing_fraction, deviation } => write!(
                formatter,
                "inaccurate equation of state: Z is off by {:.2} % at height {height:.1} (packing fraction \
                {packing_fraction:.3}): use ModifiedKolafa or FluidSolid",
                100.0 * deviation,
            ),
            Self::SteepGradient { height, slope, share } => write!(
                formatter,
                "steep gradient: d ln n/dx = {slope:.2} at height {height:.1}, and {:.1} % of the spheres are where it is too steep \
                for a local equation of state: simulate, and do not compare with a local equation there",
                100.0 * share,
            ),
            Self::DensityJump { height, below, above } => write!(
                formatter,
                "density jump: the local theory jumps from {below:.4} to {above:.4} at height {height:.2}, while the real density \
                changes over some diameters: do not compare within five diameters of this height"
            ),
            Self::NoTheory { height } => {
                formatter.write_str("no theory to compare with: hydrostatics has no solution")?;
                if height.is_finite() {
                    write!(formatter, " above height {height:.2}")?;
                }
                formatter.write_str(": compare runs from a dense and a dilute start")
            }
        }
    }
}
