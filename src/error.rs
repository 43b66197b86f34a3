//! The one error type of the library.

use crate::equation_of_state::DomainSide;
use crate::failed_observer::describe;
use crate::numbers::figures;
use std::fmt;
use thiserror::Error;

/// What can go wrong, with the numbers that say where and what to do.
///
/// It prints as a sentence with `{}` and `{:?}` alike, which names its cause if it has one, so that
/// `fn main() -> Result<(), gradient_mc::Error>` ends with it.
#[derive(Error)]
#[non_exhaustive]
pub enum Error {
    /// A number is outside the range in which it makes sense.
    #[error("{name} = {value} is not usable: {requirement}", value = figures(*value))]
    #[non_exhaustive]
    InvalidParameter {
        /// Name of the parameter, in the words of the documentation.
        name: &'static str,
        /// The value that was given.
        value: f64,
        /// What the value must satisfy.
        requirement: &'static str,
    },
    /// A slab side is too short for the minimum-image convention or for a single sphere.
    #[error(
        "the slab is {extent} diameters in {direction}, but at least {minimum} are needed: enlarge it",
        extent = figures(*extent), minimum = figures(*minimum)
    )]
    #[non_exhaustive]
    SlabTooSmall {
        /// Axis: `x` (height), `y` or `z`.
        direction: char,
        /// The extent that was given, in diameters.
        extent: f64,
        /// The smallest extent allowed.
        minimum: f64,
    },
    /// A slab whose cell list would not fit in memory.
    #[error(
        "the slab has a volume of {volume} cubic diameters, above the limit of {limit}: \
         lower the lid or take a smaller base", volume = figures(*volume), limit = figures(*limit)
    )]
    #[non_exhaustive]
    SlabTooLarge {
        /// Volume that was given, in cubic diameters.
        volume: f64,
        /// The largest volume allowed.
        limit: f64,
    },
    /// More spheres than close packing admits.
    #[error(
        "{particles} spheres fill {packing_fraction:.4} of the slab, above close packing 0.7405: \
         at most {capacity} could fit; take fewer spheres or a larger slab"
    )]
    #[non_exhaustive]
    TooManyParticles {
        /// Number of spheres that was asked for.
        particles: usize,
        /// Packing fraction that they would have.
        packing_fraction: f64,
        /// Upper bound on the number of spheres in this slab.
        capacity: usize,
    },
    /// A field is not finite at some height of the slab.
    #[error(
        "the field gives acceleration {acceleration} and potential {potential} at height {height}: \
         both must be finite over the whole slab",
        height = figures(*height), acceleration = figures(*acceleration), potential = figures(*potential)
    )]
    #[non_exhaustive]
    InvalidField {
        /// Height of the offending value.
        height: f64,
        /// Acceleration there.
        acceleration: f64,
        /// Potential there.
        potential: f64,
    },
    /// A field's potential is not the integral of its acceleration.
    #[error(
        "around height {height} the field's potential rises by {potential_difference}, but its \
         acceleration integrates to {acceleration_integral}: `potential` must be the integral of \
         `acceleration`; implement only `potential` to have the other derived",
        height = figures(*height), potential_difference = figures(*potential_difference),
        acceleration_integral = figures(*acceleration_integral)
    )]
    #[non_exhaustive]
    InconsistentField {
        /// Middle of the interval that was compared.
        height: f64,
        /// Difference of the potential over the interval.
        potential_difference: f64,
        /// Integral of the acceleration over the interval.
        acceleration_integral: f64,
    },
    /// A temperature is not positive and finite at some height of the slab.
    #[error(
        "the temperature is {temperature} at height {height}: it must be positive and finite over the \
         whole slab; lower the lid or change the profile",
        height = figures(*height), temperature = figures(*temperature)
    )]
    #[non_exhaustive]
    InvalidTemperature {
        /// Height of the offending value.
        height: f64,
        /// Temperature there.
        temperature: f64,
    },
    /// A profile that says that it is constant is not.
    #[error(
        "the temperature is {temperature} at height {height}, but `constant` says that it is {constant} everywhere: \
         leave `constant` out",
        height = figures(*height), temperature = figures(*temperature), constant = figures(*constant)
    )]
    #[non_exhaustive]
    InconsistentTemperature {
        /// Height that was probed.
        height: f64,
        /// Temperature there.
        temperature: f64,
        /// Temperature that it should have everywhere.
        constant: f64,
    },
    /// A scheme whose steady state depends on the moves was given others than it stands for.
    #[error(
        "this scheme does not take {moves}, because its steady state depends on the moves: take LocalMoves, as the paper has, \
         or allow all by `Instantaneous::any_moves`"
    )]
    #[non_exhaustive]
    UnsuitableMoves {
        /// The moves.
        moves: &'static str,
    },
    /// The reduced potential of a scene is not finite at some height.
    #[error(
        "the reduced potential is {potential} at height {height}: {cause}",
        height = figures(*height), potential = figures(*potential),
        cause = if potential.is_nan() {
            "field or temperature are no numbers there"
        } else {
            "the scene is too steep there"
        }
    )]
    #[non_exhaustive]
    InvalidPotential {
        /// Height of the offending value.
        height: f64,
        /// Reduced potential there.
        potential: f64,
    },
    /// The reduced force is not finite, or larger than probes had found: event chains cannot be
    /// driven.
    #[error(
        "the reduced force is {force} at height {height}, where its magnitude was bounded by {bound}: \
         smooth the field or temperature there, or use local moves"
    )]
    #[non_exhaustive]
    InvalidForce {
        /// Height of the offending value.
        height: f64,
        /// Reduced force u' there, in inverse diameters.
        force: f64,
        /// Bound of its magnitude, from probes around it.
        bound: f64,
    },
    /// An event chain went from sphere to sphere, or was stopped by the field, without getting
    /// ahead.
    #[error(
        "an event chain of {length} diameters is stuck after {path}: {cause}",
        length = figures(*length), path = figures(*path),
        cause = if *field_events >= HELD_BY_FIELD {
            "the field stops it at once wherever it goes: take shorter chains, or equilibrate, which tunes their length, \
             or LocalMoves::tuned"
        } else {
            "spheres touch all along its way; loosen the packing, or equilibrate longer before measuring"
        }
    )]
    #[non_exhaustive]
    ChainStuck {
        /// Length that the chain was to have, in diameters.
        length: f64,
        /// Path that it made.
        path: f64,
        /// How often the field stopped it since it last got ahead.
        field_events: u32,
    },
    /// A profile of bins was asked for that has no bins, or too many to be sensible.
    #[error("{bins} bins over {extent} diameters is not usable: take between 1 and {maximum}", extent = figures(*extent))]
    #[non_exhaustive]
    InvalidBins {
        /// Number of bins that was asked for.
        bins: usize,
        /// Range to be divided.
        extent: f64,
        /// Largest number allowed.
        maximum: usize,
    },
    /// Two given spheres overlap.
    #[error(
        "spheres {first} and {second} overlap: their centers are {distance} diameters apart, less than 1",
        distance = figures(*distance)
    )]
    #[non_exhaustive]
    Overlap {
        /// Index of the first sphere.
        first: usize,
        /// Index of the second sphere.
        second: usize,
        /// Distance of their centers.
        distance: f64,
    },
    /// A given sphere lies outside the slab, or a coordinate is not a number.
    #[error(
        "sphere {index} has {axis} = {value}, outside [{lowest}, {highest}]: \
         move it inside (centers stay half a diameter off the walls)",
        value = figures(*value), lowest = figures(*lowest), highest = figures(*highest)
    )]
    #[non_exhaustive]
    OutsideSlab {
        /// Index of the sphere.
        index: usize,
        /// Axis: `x`, `y` or `z`.
        axis: char,
        /// Coordinate along that axis.
        value: f64,
        /// Smallest value allowed.
        lowest: f64,
        /// Largest value allowed.
        highest: f64,
    },
    /// The number of positions is not the number of spheres of the scene.
    #[error("{found} positions were given for {expected} spheres")]
    #[non_exhaustive]
    WrongParticleCount {
        /// Number of spheres of the scene.
        expected: usize,
        /// Number of positions given.
        found: usize,
    },
    /// Random sequential insertion found no room for the next sphere.
    #[error(
        "random insertion placed {placed} of {requested} spheres (packing fraction {packing_fraction:.3}) \
         and then failed {attempts} times: start from the theory profile or a close-packed crystal instead"
    )]
    #[non_exhaustive]
    InsertionFailed {
        /// Spheres placed.
        placed: usize,
        /// Spheres wanted.
        requested: usize,
        /// Failed attempts at the last sphere.
        attempts: usize,
        /// Packing fraction reached in the region that was being filled.
        packing_fraction: f64,
    },
    /// A lattice start ran out of sites.
    #[error(
        "the lattice that fits this slab has {sites} sites for {particles} spheres: \
         take fewer spheres or a larger slab"
    )]
    #[non_exhaustive]
    LatticeFull {
        /// Sites available.
        sites: usize,
        /// Spheres wanted.
        particles: usize,
    },
    /// No packing fraction gives the pressure that the column exerts.
    #[error(
        "the equation of state has no state with P/T = {reduced_pressure} (met at height {height}): use one whose \
         domain reaches {remedy}",
        height = figures(*height), reduced_pressure = figures(*reduced_pressure),
        remedy = match side {
            DomainSide::Above => "higher, or a lighter column",
            DomainSide::Below => "lower, such as FluidSolid, or a lid where it ends",
        }
    )]
    #[non_exhaustive]
    EquationOfStateExhausted {
        /// Height at which the state was needed.
        height: f64,
        /// Pressure over temperature, in inverse cubic diameters.
        reduced_pressure: f64,
        /// Whether it is above all that the equation has, or below.
        side: DomainSide,
    },
    /// A column that is open at the top does not end.
    #[error(
        "an open column in this field still holds pressure {pressure} at height {height}: \
         the field must point down far above the bed, or the column needs a lid",
        height = figures(*height), pressure = figures(*pressure)
    )]
    #[non_exhaustive]
    UnboundedColumn {
        /// Height reached.
        height: f64,
        /// Pressure there.
        pressure: f64,
    },
    /// The hydrostatic equations could not be solved to the accuracy promised.
    #[error(
        "hydrostatics stopped at height {height} with residual {residual:e}: \
         the scene may be discontinuous or too steep for the solver", height = figures(*height)
    )]
    #[non_exhaustive]
    HydrostaticsNotConverged {
        /// Height at which the solver gave up, or the base.
        height: f64,
        /// Residual reached.
        residual: f64,
    },
    /// A density functional was asked for a column that freezes.
    #[error(
        "at height {height} the fluid freezes, with packing fractions up to {packing_fraction}: a functional of the fluid does not \
         know the crystal; simulate, or take a lighter or hotter column", height = figures(*height)
    )]
    #[non_exhaustive]
    BeyondFreezing {
        /// Lowest height where it freezes.
        height: f64,
        /// The largest packing fraction of the uniform fluid.
        packing_fraction: f64,
    },
    /// The density of a functional changes faster than its polynomials follow.
    #[error(
        "around height {height} the density is not smooth, by {tail:e} of itself: field or temperature are discontinuous or too \
         steep there for the grid of a density functional", height = figures(*height)
    )]
    #[non_exhaustive]
    FunctionalTooSteep {
        /// Start of the worst panel.
        height: f64,
        /// What is left at the end of its series, over its mean.
        tail: f64,
    },
    /// The iteration for the density of a functional found no fixed point.
    #[error(
        "the density functional has residual {residual:e} after {iterations} iterations: no stable fluid, or too steep a field"
    )]
    #[non_exhaustive]
    FunctionalNotConverged {
        /// Iterations made.
        iterations: u32,
        /// What is left of ln n, root mean square weighted by n.
        residual: f64,
    },
    /// An estimate was asked of too few data.
    #[error(
        "{what}: {available} are too few, at least {needed} are needed: run longer or observe more often"
    )]
    #[non_exhaustive]
    TooFewObservations {
        /// What is too few, and for what.
        what: &'static str,
        /// Observations made.
        available: usize,
        /// Observations needed.
        needed: usize,
    },
    /// A series whose end is not a steady state, as far as it can tell.
    #[error(
        "no steady state in {observations} observations: from the {start}th on, which is best, only \
         {effective_sample_size:.1} are independent; run longer, or start nearer to the steady state"
    )]
    #[non_exhaustive]
    NotEquilibrated {
        /// Length of the series.
        observations: usize,
        /// Where the steady state would begin if there were one.
        start: usize,
        /// Independent observations from there on.
        effective_sample_size: f64,
    },
    /// An observer of one run was shown a frame of another: of another scene, or of a run that
    /// starts anew, whose sweeps do not go on where they were.
    #[error(
        "an observer looks at one run, but the {what} was {seen} and is now {shown}: take an observer of its own for \
         another run, and pool them with `Merge`", seen = figures(*seen), shown = figures(*shown)
    )]
    #[non_exhaustive]
    AnotherRun {
        /// What differs: a length of the slab, the number of spheres, field or temperature at some
        /// height, or the number of the sweep, which did not increase.
        what: &'static str,
        /// Its value in the frames before.
        seen: f64,
        /// Its value in the frame that was refused.
        shown: f64,
    },
    /// A frame of a trajectory cannot be started from.
    #[error(transparent)]
    Trajectory(#[from] crate::start::TrajectoryError),
    /// A start, a scheme or an adaptation of a user's own failed with an error of its own.
    #[error(transparent)]
    Custom(Box<dyn std::error::Error + Send + Sync>),
    /// An observer failed; its own error is the source.
    #[error("{who} failed after sweep {sweep}: {source}", who = describe(position, name))]
    #[non_exhaustive]
    Observer {
        /// Sweeps completed when it failed.
        sweep: u64,
        /// Its index in the tuple of observers, and in each tuple inside; empty for one alone.
        position: Vec<usize>,
        /// Its type.
        name: &'static str,
        /// The observer's own error.
        #[source]
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A table could not be written.
    #[cfg(feature = "csv")]
    #[error("the table cannot be written: {source}")]
    Write {
        /// What the writer returned.
        #[source]
        source: std::io::Error,
    },
    /// A checkpoint is of another run, or of another observer, than what is to go on.
    #[cfg(feature = "checkpoint")]
    #[error("the checkpoint is of another run: {what} was {saved}, and is {given} here")]
    #[non_exhaustive]
    CheckpointMismatch {
        /// What differs.
        what: String,
        /// What it is in the checkpoint.
        saved: String,
        /// What it is in the program that reads it.
        given: String,
    },
    /// A checkpoint is not as it was written.
    #[cfg(feature = "checkpoint")]
    #[error("the checkpoint is damaged: {what}")]
    #[non_exhaustive]
    CheckpointDamaged {
        /// What is wrong, or the name of the item that makes no sense.
        what: String,
    },
    /// A checkpoint of another version of the format.
    #[cfg(feature = "checkpoint")]
    #[error(
        "the checkpoint has format {found}, and this program reads format {known}: finish the run with that which wrote it"
    )]
    #[non_exhaustive]
    CheckpointVersion {
        /// Version of the file.
        found: u32,
        /// The version that can be read.
        known: u32,
    },
    /// Two checkpoints to be pooled are of one seed, so of one run.
    #[cfg(feature = "checkpoint")]
    #[error("{} and {} are of the same seed {seed}: the one run would count twice", paths[0].display(), paths[1].display())]
    #[non_exhaustive]
    SameSeed {
        /// The seed.
        seed: u64,
        /// Both files.
        paths: [std::path::PathBuf; 2],
    },
    /// A file of a checkpoint cannot be written or read; the source says why.
    #[cfg(feature = "checkpoint")]
    #[error("{}", path.display())]
    #[non_exhaustive]
    CheckpointFile {
        /// The file, or the folder.
        path: std::path::PathBuf,
        /// What the system said, or what is wrong with the file.
        #[source]
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// One of several replicas failed; its own error is the source.
    #[error("replica {replica}, of seed {seed}, failed: {source}")]
    Replica {
        /// Its number, from 0.
        replica: usize,
        /// Its seed.
        seed: u64,
        /// What went wrong in it.
        #[source]
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

/// The sentence.
impl fmt::Debug for Error {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, formatter)
    }
}

/// A chain that the field has stopped as often within a diameter is held by the field, whatever
/// else it meets.
const HELD_BY_FIELD: u32 = 100;
