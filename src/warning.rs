//! What makes a result doubtful, said by the program itself.

use crate::drive::{Certificate, MeasuredShare};
use crate::hydrostatics::DomainExit;
use crate::statistics::Estimate;
use std::fmt;

/// A reason not to trust a run, a profile or a theory, with the numbers that say how bad it is.
///
/// [`Simulation::warnings`](crate::Simulation::warnings) judges a production run,
/// [`HydrostaticProfile::warnings`](crate::HydrostaticProfile::warnings) a theory profile, and the
/// profiles of [`observers`](crate::observers) judge their bins. Each prints as one line: what,
/// where, how much, and what to do. No warnings is no proof of correctness; each variant says what
/// it checks. Heights and lengths are in diameters.
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
    /// Production was too short for any judgment.
    #[non_exhaustive]
    TooShort {
        /// Sweeps of production so far.
        sweeps: u64,
        /// Fewest sweeps that can be judged.
        needed: u64,
    },
    /// Local moves, the only ones, are hardly ever accepted in a range of heights.
    #[non_exhaustive]
    LowAcceptance {
        /// Lower end of the range.
        lowest_height: f64,
        /// Upper end of the range.
        highest_height: f64,
        /// Acceptance there.
        acceptance: f64,
        /// Part of the spheres that is there.
        share: f64,
    },
    /// Production has not explored the configurations that it should.
    #[non_exhaustive]
    NotMixed {
        /// Sweeps of production so far.
        sweeps: u64,
        /// What gives it away.
        evidence: MixingEvidence,
    },
    /// No sphere has moved.
    NothingMoved {
        /// Sweeps of production so far.
        sweeps: u64,
    },
    /// The center of mass is far from where the theory has it, where the theory is good.
    #[non_exhaustive]
    FarFromTheory {
        /// Height of the center of mass, with the error that the run claims.
        center_of_mass: Estimate,
        /// That of [`Hydrostatics::between_walls`](crate::Hydrostatics::between_walls).
        theory: f64,
    },
    /// The effective field is not that of the density that it made, or it cannot be told.
    #[non_exhaustive]
    FeedbackNotConverged {
        /// The verdict in full.
        certificate: Certificate,
    },
    /// The effective field is mostly that of the theory; little of it was measured.
    #[non_exhaustive]
    FieldOfTheory {
        /// How much was.
        measured: MeasuredShare,
    },
    /// The field comes from the counts of single configurations, whose noise biases it
    /// ([`Instantaneous`](crate::drive::Instantaneous)).
    #[non_exhaustive]
    CountingNoise {
        /// Mean number of spheres in a bin of the field, over spheres.
        spheres_per_bin: f64,
        /// What P/(nTZ) − 1 is predicted to be at the base, for moves that cross bins; infinite if
        /// the column runs away.
        pressure_deviation: f64,
    },
    /// The reduced potential has changed during production, which breaks detailed balance.
    #[non_exhaustive]
    ChangesWhileMeasuring {
        /// Number of changes since production began.
        changes: u64,
    },
    /// Pressure on the wall at the open end of the column, the lid if the field pulls down, which
    /// P(x) as a weight leaves out unless it is told.
    #[non_exhaustive]
    LidTooLow {
        /// Height of that wall.
        lid: f64,
        /// Pressure on it over the largest pressure.
        pressure_ratio: f64,
    },
    /// Pressure or density are above those of freezing: a fluid there is metastable, and what a
    /// crystal or a glass is like depends on how it came about.
    #[non_exhaustive]
    Metastable {
        /// Lower end of the range.
        lowest_height: f64,
        /// Upper end of the range.
        highest_height: f64,
        /// Largest packing fraction measured in it, layers averaged over.
        packing_fraction: f64,
    },
    /// The column freezes, and the periodic widths are not those of a crystal of the density that
    /// it has at the base.
    #[non_exhaustive]
    BoxIncommensurate {
        /// Largest principal strain of the hexagonal layers that fit best, over all orientations.
        strain: f64,
        /// Narrower periodic width.
        width: f64,
        /// Distance of neighbors in the unstrained crystal at the base.
        lattice_constant: f64,
    },
    /// Spheres of a dense layer see their own images.
    #[non_exhaustive]
    NarrowBox {
        /// Narrower periodic width.
        width: f64,
        /// Packing fraction at the densest height.
        packing_fraction: f64,
    },
    /// Bins in the column in which no sphere was ever seen.
    #[non_exhaustive]
    EmptyBins {
        /// Number of such bins.
        bins: usize,
        /// Middle of the lowest.
        lowest_height: f64,
        /// Middle of the highest.
        highest_height: f64,
    },
    /// Bins in the column that were seen occupied too seldom for their error bars to mean anything.
    #[non_exhaustive]
    ThinBins {
        /// Number of such bins.
        bins: usize,
        /// Middle of the lowest.
        lowest_height: f64,
        /// Middle of the highest.
        highest_height: f64,
        /// Fewest blocks of frames in which one of them was occupied.
        blocks: usize,
    },
    /// Bins in the column whose counts or pressures are known from few independent configurations,
    /// so that their error bars are too small or mean little.
    #[non_exhaustive]
    CorrelatedBins {
        /// Middle of the lowest of those that were judged together.
        lowest_height: f64,
        /// Middle of the highest.
        highest_height: f64,
        /// As many independent configurations would know them as well.
        effective_sample_size: f64,
    },
    /// Replicas that were merged contradict each other: they have not all reached the same state.
    #[non_exhaustive]
    ReplicasDisagree {
        /// Where they do.
        disagreement: Disagreement,
    },
    /// Bins over which the density changes too much to be compared with a local equation of state
    /// by their means.
    #[non_exhaustive]
    WideBins {
        /// Height of a bin.
        bin_width: f64,
        /// Middle of the worst.
        height: f64,
        /// Estimate of the relative error of P/(nT) there: (Δx d ln n/dx)²/24.
        bias: f64,
    },
    /// An equation of state is used outside its domain.
    #[non_exhaustive]
    OutsideDomain {
        /// Where and how far.
        exit: DomainExit,
    },
    /// An equation of state is used inside its domain, but is not that of hard spheres there.
    #[non_exhaustive]
    InaccurateEquation {
        /// The densest height.
        height: f64,
        /// Packing fraction there.
        packing_fraction: f64,
        /// Its Z over that of the best equation
        /// ([`FluidSolid`](crate::equation_of_state::FluidSolid)), less 1.
        deviation: f64,
    },
    /// The density changes by of order 1 over a diameter, where a local equation of state is wrong.
    #[non_exhaustive]
    SteepGradient {
        /// Where it is steepest.
        height: f64,
        /// d ln n/dx there, in inverse diameters.
        slope: f64,
        /// Part of the spheres that is where the slope is too steep.
        share: f64,
    },
    /// Ranks and collisions do not yield the same equation of state
    /// ([`MeasuredEquationOfState`](crate::observers::MeasuredEquationOfState)).
    #[non_exhaustive]
    RoutesDisagree {
        /// Packing fraction at which they are farthest apart, of those that were compared.
        packing_fraction: f64,
        /// Z there by ranks.
        ranks: Estimate,
        /// Z there by collisions.
        collisions: Estimate,
    },
    /// The density of the theory jumps: at a jump of the temperature, or where fluid and solid
    /// meet.
    #[non_exhaustive]
    DensityJump {
        /// Where.
        height: f64,
        /// Number density just below.
        below: f64,
        /// Number density just above.
        above: f64,
    },
    /// The hydrostatic theory has no profile, so nothing could be compared with it.
    #[non_exhaustive]
    NoTheory {
        /// Where it stopped; NaN if nowhere in particular.
        height: f64,
    },
}

/// Where merged replicas contradict each other; of [`Warning::ReplicasDisagree`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Disagreement {
    /// In the height of the center of mass.
    #[non_exhaustive]
    CenterOfMass {
        /// Lowest mean of a replica.
        lowest: f64,
        /// Highest.
        highest: f64,
    },
    /// In some bins of a profile.
    #[non_exhaustive]
    Bins {
        /// Number of such bins.
        bins: usize,
        /// Middle of the lowest.
        lowest_height: f64,
        /// Middle of the highest.
        highest_height: f64,
    },
}

impl fmt::Display for Disagreement {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::CenterOfMass { lowest, highest } => {
                write!(formatter, "their centers of mass are at {lowest:.3} to {highest:.3}")
            }
            Self::Bins { bins, lowest_height, highest_height } => {
                write!(formatter, "in {bins} bins between heights {lowest_height:.2} and {highest_height:.2}")
            }
        }
    }
}

/// The parts of a column by whose memory a run is judged; of [`MixingEvidence::FewIndependent`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Quantity {
    /// All of it: the height of the center of mass, and the numbers of spheres below two heights.
    Column,
    /// What is near the base: the numbers of spheres in the first layer, and in the lowest two
    /// diameters.
    Base,
}

impl fmt::Display for Quantity {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Self::Column => "the column",
            Self::Base => "what is near the base",
        })
    }
}

/// What gives away that a run has not mixed; of [`Warning::NotMixed`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum MixingEvidence {
    /// The center of mass still moves.
    #[non_exhaustive]
    Drift {
        /// Its height in the second half of production less that in the first.
        drift: Estimate,
    },
    /// The center of mass began production far from where it is later.
    #[non_exhaustive]
    Relaxing {
        /// Its mean height in the first eighth of production less that in the second half.
        shift: Estimate,
    },
    /// The slowest of what is judged has seen few independent configurations: fewer than 2.5.
    #[non_exhaustive]
    FewIndependent {
        /// The slowest.
        quantity: Quantity,
        /// As many independent configurations would know its mean as well.
        effective_sample_size: f64,
    },
    /// The center of mass fluctuates less than it must in equilibrium.
    #[non_exhaustive]
    TooQuiet {
        /// Variance of its height in production.
        variance: f64,
        /// What the sum rule demands.
        required: f64,
    },
}

impl fmt::Display for MixingEvidence {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Drift { drift } => {
                write!(formatter, "the center of mass still moves, by {drift} between the halves of it")
            }
            Self::Relaxing { shift } => write!(
                formatter,
                "the start still relaxes: in the first eighth of it the center of mass is {shift} above where it is in the \
                 second half"
            ),
            Self::FewIndependent { quantity, effective_sample_size } => {
                let number = effective_sample_size;
                write!(formatter, "{quantity} is known as from {number:.1} independent configurations")
            }
            Self::TooQuiet { variance, required } => write!(
                formatter,
                "the center of mass has a variance of {variance:.2e}, where equilibrium demands {required:.2e}"
            ),
        }
    }
}

/// A wall that carries more of the largest pressure is not where a column ends.
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
                "low acceptance: {:.2} % of the local moves between heights {lowest_height:.1} and {highest_height:.1}, \
                 where {:.0} % of the spheres are: take smaller displacements, LocalMoves::tuned or EventChains",
                100.0 * acceptance,
                100.0 * share,
            ),
            Self::NotMixed { sweeps, evidence } => write!(
                formatter,
                "not mixed after {sweeps} sweeps of production: {evidence}: equilibrate and run longer, or take \
                 EventChains or LocalMoves::tuned"
            ),
            Self::NothingMoved { sweeps } => write!(
                formatter,
                "nothing has moved in {sweeps} sweeps of production: spheres are jammed, or displacements too large: take \
                 LocalMoves::tuned or EventChains, equilibrate first, or start from another configuration"
            ),
            Self::FarFromTheory { center_of_mass, theory } => write!(
                formatter,
                "far from theory: the center of mass is at {center_of_mass}, where hydrostatics has {theory:.3}: \
                 equilibrate longer, or start from the theory profile"
            ),
            Self::FeedbackNotConverged { certificate } => {
                write!(formatter, "feedback not converged: {certificate}")
            }
            Self::FieldOfTheory { measured } => write!(
                formatter,
                "the field is theory in part: {measured} was measured: equilibrate longer, by \
                 EventChains, whose collisions measure the bulk"
            ),
            Self::CountingNoise { spheres_per_bin, pressure_deviation } => write!(
                formatter,
                "counting noise in the field: {spheres_per_bin:.1} spheres in a bin bias P at the base by up to \
                 {:.2} %: take SelfConsistent, or wider bins or a larger base",
                100.0 * pressure_deviation,
            ),
            Self::ChangesWhileMeasuring { changes } => write!(
                formatter,
                "the field has changed {changes} times while measuring, which breaks detailed balance: take a scheme \
                 that freezes it"
            ),
            Self::LidTooLow { lid, pressure_ratio } if *pressure_ratio > CLOSED => write!(
                formatter,
                "closed box: the wall at height {lid:.1} carries {:.2} % of the largest pressure, which P(x) as a weight \
                 leaves out: measure it (WallPressure) and add it (set_open_end_pressure)",
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
                 {packing_fraction:.3}: a fluid there is metastable and a solid depends on its history: start from both \
                 sides, or take a hotter or lighter column"
            ),
            Self::BoxIncommensurate { strain, width, lattice_constant } => write!(
                formatter,
                "box incommensurate: a crystal with neighbors {lattice_constant:.3} apart is strained by {:.1} % to fit \
                 the base ({width:.2} across): take widths of whole rows, or a larger base",
                100.0 * strain,
            ),
            Self::NarrowBox { width, packing_fraction } => write!(
                formatter,
                "narrow box: at packing fraction {packing_fraction:.2} spheres see their own images {width:.2} away: \
                 take a wider base"
            ),
            Self::EmptyBins { bins, lowest_height, highest_height } => write!(
                formatter,
                "empty bins: {bins} between heights {lowest_height:.2} and {highest_height:.2} never held a sphere: take \
                 wider bins or run longer"
            ),
            Self::ThinBins { bins, lowest_height, highest_height, blocks } => write!(
                formatter,
                "thin bins: {bins} between heights {lowest_height:.2} and {highest_height:.2} held a sphere in as few as \
                 {blocks} blocks, too few for an error bar: take wider bins or run longer"
            ),
            Self::CorrelatedBins { lowest_height, highest_height, effective_sample_size } => write!(
                formatter,
                "correlated bins: those between heights {lowest_height:.2} and {highest_height:.2} are known as from \
                 {effective_sample_size:.0} independent configurations: run longer"
            ),
            Self::RoutesDisagree { packing_fraction, ranks, collisions } => write!(
                formatter,
                "ranks and collisions disagree: at packing fraction {packing_fraction:.3} Z is {ranks} and {collisions}: the \
                 column is not at rest: equilibrate longer"
            ),
            Self::ReplicasDisagree { disagreement } => write!(
                formatter,
                "replicas disagree: {disagreement}: equilibrate longer, and judge every replica by itself"
            ),
            Self::WideBins { bin_width, height, bias } => write!(
                formatter,
                "wide bins: over the {bin_width:.2} around height {height:.1} the density changes so much that P/(nT) of \
                 its mean is off by some {:.1} %: take narrower bins",
                100.0 * bias,
            ),
            Self::OutsideDomain { exit } => write!(
                formatter,
                "outside the domain of the equation of state between heights {:.2} and {:.2}: packing fraction {:.4} is \
                 beyond {:.4}: take an equation that is valid there (FluidSolid)",
                exit.lowest_height, exit.highest_height, exit.packing_fraction, exit.limit,
            ),
            Self::InaccurateEquation { height, packing_fraction, deviation } => write!(
                formatter,
                "inaccurate equation of state: Z is off by {:.2} % at height {height:.1} (packing fraction \
                 {packing_fraction:.3}): take ModifiedKolafa or FluidSolid",
                100.0 * deviation,
            ),
            Self::SteepGradient { height, slope, share } => write!(
                formatter,
                "steep gradient: d ln n/dx = {slope:.2} at height {height:.1}, and too steep for a local equation of state \
                 for {:.1} % of the spheres: simulate, and do not compare with a local equation there",
                100.0 * share,
            ),
            Self::DensityJump { height, below, above } => write!(
                formatter,
                "the density of the local theory jumps from {below:.4} to {above:.4} at height {height:.2}, where a real one \
                 goes over in some diameters: do not compare within five diameters of it"
            ),
            Self::NoTheory { height } => write!(
                formatter,
                "no theory to compare with: hydrostatics stopped at height {height:.2}: judge by runs from both sides"
            ),
        }
    }
}
