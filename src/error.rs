//! The one error type of the library.

use crate::equation_of_state::DomainSide;
use crate::failed_observer::describe;
use crate::numbers::figures;
use std::fmt;
use thiserror::Error;

/// All errors of the library, with the numbers that show where and what is wrong.
///
/// Both `{}` and `{:?}` print one sentence that includes the cause. A program with `fn main() ->
/// Result<(), gradient_mc::Error>` therefore ends with a readable message.
#[derive(Error)]
#[non_exhaustive]
pub enum Error {
    /// A parameter is outside its allowed range.
    #[error("{name} = {value} is invalid: {requirement}", value = figures(*value))]
    #[non_exhaustive]
    InvalidParameter {
        /// Name of the parameter, as in the documentation.
        name: &'static str,
        /// The value given.
        value: f64,
        /// What the value must satisfy.
        requirement: &'static str,
    },
    /// The slab is too narrow for the minimum-image convention, or too low for a sphere.
    #[error(
        "the slab is {extent} diameters in {direction}, but at least {minimum} are needed: enlarge it",
        extent = figures(*extent), minimum = figures(*minimum)
    )]
    #[non_exhaustive]
    SlabTooSmall {
        /// Axis: `x` (height), `y` or `z`.
        direction: char,
        /// The extent given, in diameters.
        extent: f64,
        /// The smallest extent allowed, in diameters.
        minimum: f64,
    },
    /// The slab is too large: its cell list would need too much memory.
    #[error(
        "the slab has a volume of {volume} cubic diameters, above the limit of {limit}: \
        lower the lid or use a smaller base", volume = figures(*volume), limit = figures(*limit)
    )]
    #[non_exhaustive]
    SlabTooLarge {
        /// The volume given, in cubic diameters.
        volume: f64,
        /// The largest volume allowed, in cubic diameters.
        limit: f64,
    },
    /// The number of spheres is above close packing.
    #[error(
        "{particles} spheres fill {packing_fraction:.4} of the slab, above close packing 0.7405: \
         at most {capacity} could fit; use fewer spheres or a larger slab"
    )]
    #[non_exhaustive]
    TooManyParticles {
        /// Number of spheres requested.
        particles: usize,
        /// Their packing fraction in this slab.
        packing_fraction: f64,
        /// Upper bound on the number of spheres in this slab.
        capacity: usize,
    },
    /// Acceleration or potential of the field are not finite at some height of the slab.
    #[error(
        "the field gives acceleration {acceleration} and potential {potential} at height {height}: \
         both must be finite over the whole slab",
        height = figures(*height), acceleration = figures(*acceleration), potential = figures(*potential)
    )]
    #[non_exhaustive]
    InvalidField {
        /// Height, in diameters.
        height: f64,
        /// Acceleration there.
        acceleration: f64,
        /// Potential there.
        potential: f64,
    },
    /// The potential of the field is not the integral of its acceleration.
    #[error(
        "around height {height} the field's potential rises by {potential_difference}, but its \
         acceleration integrates to {acceleration_integral}: `potential` must be the integral of \
         `acceleration`; implement only `potential` to use its numerical derivative",
        height = figures(*height), potential_difference = figures(*potential_difference),
        acceleration_integral = figures(*acceleration_integral)
    )]
    #[non_exhaustive]
    InconsistentField {
        /// Middle of the interval that was compared, in diameters.
        height: f64,
        /// Difference of the potential over the interval.
        potential_difference: f64,
        /// Integral of the acceleration over the interval.
        acceleration_integral: f64,
    },
    /// The temperature is not positive and finite at some height of the slab.
    #[error(
        "the temperature is {temperature} at height {height}: it must be positive and finite over the \
         whole slab; lower the lid or change the profile",
        height = figures(*height), temperature = figures(*temperature)
    )]
    #[non_exhaustive]
    InvalidTemperature {
        /// Height, in diameters.
        height: f64,
        /// Temperature there.
        temperature: f64,
    },
    /// `TemperatureProfile::constant` returns a temperature, but the profile is not constant.
    #[error(
        "the temperature is {temperature} at height {height}, but `constant` returns {constant} for all heights: \
        do not implement `constant` for a profile that varies",
        height = figures(*height), temperature = figures(*temperature), constant = figures(*constant)
    )]
    #[non_exhaustive]
    InconsistentTemperature {
        /// Height, in diameters.
        height: f64,
        /// Temperature there.
        temperature: f64,
        /// Temperature that `constant` returns.
        constant: f64,
    },
    /// The scheme does not accept the moves, because its steady state depends on the moves.
    #[error(
        "this scheme does not accept {moves}, because its steady state depends on the moves: use LocalMoves, as in the paper, \
        or allow all moves by `Instantaneous::any_moves`"
    )]
    #[non_exhaustive]
    UnsuitableMoves {
        /// Name of the moves.
        moves: &'static str,
    },
    /// The reduced potential of the scene is not finite at some height.
    #[error(
        "the reduced potential is {potential} at height {height}: {cause}",
        height = figures(*height), potential = figures(*potential),
        cause = if potential.is_nan() {
            "field or temperature are not a number there"
        } else {
            "field or temperature are too steep there"
        }
    )]
    #[non_exhaustive]
    InvalidPotential {
        /// Height, in diameters.
        height: f64,
        /// Reduced potential there.
        potential: f64,
    },
    /// The reduced force is not finite, or larger than its bound, at some height. Event chains
    /// cannot run there.
    #[error(
        "the reduced force is {force} at height {height}, above the bound {bound} of its magnitude from \
        nearby heights: smooth the field or temperature there, or use local moves"
    )]
    #[non_exhaustive]
    InvalidForce {
        /// Height, in diameters.
        height: f64,
        /// Reduced force u' there, in inverse diameters.
        force: f64,
        /// Bound of its magnitude, from nearby heights.
        bound: f64,
    },
    /// An event chain made very many events without moving ahead.
    #[error(
        "an event chain of {length} diameters is stuck after a path of {path} diameters: {cause}",
        length = figures(*length), path = figures(*path),
        cause = if *field_events >= HELD_BY_FIELD {
            "the field stops it at once at every sphere: use shorter chains, equilibrate first, which tunes their \
            length, or use LocalMoves::tuned"
        } else {
            "the spheres on its path touch each other: loosen the packing, or equilibrate longer"
        }
    )]
    #[non_exhaustive]
    ChainStuck {
        /// Intended length of the chain, in diameters.
        length: f64,
        /// Length of its path so far, in diameters.
        path: f64,
        /// Number of field events since the chain last moved ahead by a diameter.
        field_events: u32,
    },
    /// The number of bins is zero or too large.
    #[error("{bins} bins over {extent} diameters are invalid: use between 1 and {maximum}", extent = figures(*extent))]
    #[non_exhaustive]
    InvalidBins {
        /// Number of bins requested.
        bins: usize,
        /// Range divided into bins, in diameters.
        extent: f64,
        /// Largest number allowed.
        maximum: usize,
    },
    /// Two spheres of the given positions overlap.
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
    /// A sphere of the given positions is outside the slab, or a coordinate is not a number.
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
    /// The number of positions differs from the number of spheres of the scene.
    #[error("{found} positions were given, but the scene has {expected} spheres")]
    #[non_exhaustive]
    WrongParticleCount {
        /// Number of spheres of the scene.
        expected: usize,
        /// Number of positions given.
        found: usize,
    },
    /// Random sequential insertion found no free place for the next sphere.
    #[error(
        "random insertion placed {placed} of {requested} spheres (packing fraction {packing_fraction:.3}) \
         and then failed {attempts} times: start from the theory profile or a close-packed crystal instead"
    )]
    #[non_exhaustive]
    InsertionFailed {
        /// Spheres placed.
        placed: usize,
        /// Spheres requested.
        requested: usize,
        /// Failed attempts to place the next sphere.
        attempts: usize,
        /// Packing fraction reached in the region to be filled.
        packing_fraction: f64,
    },
    /// The lattice of a close-packed start has fewer sites than the scene has spheres.
    #[error(
        "the lattice that fits this slab has {sites} sites for {particles} spheres: \
        use fewer spheres or a larger slab"
    )]
    #[non_exhaustive]
    LatticeFull {
        /// Sites available.
        sites: usize,
        /// Spheres requested.
        particles: usize,
    },
    /// The equation of state does not reach the pressure of the column.
    #[error(
        "the equation of state has no state with P/T = {reduced_pressure} (needed at height {height}): use one whose \
        domain reaches {remedy}",
        height = figures(*height), reduced_pressure = figures(*reduced_pressure),
        remedy = match side {
            DomainSide::Above => "higher, or use a lighter column",
            DomainSide::Below => "lower, such as FluidSolid, or put the lid where the domain ends",
        }
    )]
    #[non_exhaustive]
    EquationOfStateExhausted {
        /// Height at which the state is needed.
        height: f64,
        /// Pressure over temperature, in inverse cubic diameters.
        reduced_pressure: f64,
        /// Whether it is above or below the domain of the equation.
        side: DomainSide,
    },
    /// A column without a lid does not end.
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
        /// Height at which the solver stopped, or the base.
        height: f64,
        /// Residual reached.
        residual: f64,
    },
    /// A density functional of the fluid was used for a column that freezes.
    #[error(
        "at height {height} the fluid freezes, with packing fractions up to {packing_fraction}: \
        a functional of the fluid does not describe the crystal; simulate, or use a lighter or hotter column", height = figures(*height)
    )]
    #[non_exhaustive]
    BeyondFreezing {
        /// Lowest height at which it freezes.
        height: f64,
        /// The largest packing fraction of the uniform fluid.
        packing_fraction: f64,
    },
    /// The density of a functional changes too fast for its grid.
    #[error(
        "around height {height} the density is not smooth on the grid of a density functional (relative error {tail:e}): \
        field or temperature are discontinuous or too steep there", height = figures(*height)
    )]
    #[non_exhaustive]
    FunctionalTooSteep {
        /// Lower end of the worst panel of the grid.
        height: f64,
        /// Last coefficients of the series of the density, relative to its mean.
        tail: f64,
    },
    /// The iteration for the density of a functional did not converge.
    #[error(
        "the density functional has residual {residual:e} after {iterations} iterations: \
        the fluid is not stable, or the field is too steep"
    )]
    #[non_exhaustive]
    FunctionalNotConverged {
        /// Number of iterations.
        iterations: u32,
        /// Residual of ln n, root mean square weighted by n.
        residual: f64,
    },
    /// There are too few data for an estimate.
    #[error(
        "{what}: {available} are too few, at least {needed} are needed: run longer or observe more often"
    )]
    #[non_exhaustive]
    TooFewObservations {
        /// The kind of data, and the estimate that needs it.
        what: &'static str,
        /// Number of data.
        available: usize,
        /// Number needed.
        needed: usize,
    },
    /// A series does not reach a steady state.
    #[error(
        "no steady state in {observations} observations: after the best cut, at observation {start}, the effective number of \
        independent ones is only {effective_sample_size:.1}; run longer, or start nearer to the steady state"
    )]
    #[non_exhaustive]
    NotEquilibrated {
        /// Length of the series.
        observations: usize,
        /// Best cut: index of the first observation that is kept.
        start: usize,
        /// Effective number of independent observations after the cut.
        effective_sample_size: f64,
    },
    /// An observer that samples one run was used in another: in another scene, or in a run whose
    /// sweep numbers do not continue those of the first.
    #[error(
        "an observer samples one run only, but the {what} was {seen} and is now {shown}: use a new observer for \
        each run, and pool them with `Merge`", seen = figures(*seen), shown = figures(*shown)
    )]
    #[non_exhaustive]
    AnotherRun {
        /// Name of the quantity that differs: a length of the slab, the number of spheres, field or
        /// temperature at some height, or the number of the sweep.
        what: &'static str,
        /// Its value in the frames so far.
        seen: f64,
        /// Its value in the refused frame.
        shown: f64,
    },
    /// A simulation cannot start from the frame of a trajectory.
    #[error(transparent)]
    Trajectory(#[from] crate::start::TrajectoryError),
    /// An error of a start, a scheme or an adaptation that the user has implemented.
    #[error(transparent)]
    Custom(Box<dyn std::error::Error + Send + Sync>),
    /// An observer failed. Its own error is the source.
    #[error("{who} failed after sweep {sweep}: {source}", who = describe(position, name))]
    #[non_exhaustive]
    Observer {
        /// Number of complete sweeps at the failure.
        sweep: u64,
        /// Index of the observer in the tuple of observers, and in each nested tuple; empty for a
        /// single observer.
        position: Vec<usize>,
        /// Type of the observer.
        name: &'static str,
        /// The observer's own error.
        #[source]
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A table could not be written.
    #[cfg(feature = "csv")]
    #[error("the table cannot be written: {source}")]
    Write {
        /// Error of the writer.
        #[source]
        source: std::io::Error,
    },
    /// A checkpoint belongs to another run or to another observer than those to be continued.
    #[cfg(feature = "checkpoint")]
    #[error("the checkpoint is of another run: {what} was {saved} there and is {given} here")]
    #[non_exhaustive]
    CheckpointMismatch {
        /// Name of the item that differs.
        what: String,
        /// Its value in the checkpoint.
        saved: String,
        /// Its value in the program that reads the checkpoint.
        given: String,
    },
    /// A checkpoint is damaged.
    #[cfg(feature = "checkpoint")]
    #[error("the checkpoint is damaged: {what}")]
    #[non_exhaustive]
    CheckpointDamaged {
        /// What is wrong, or the name of the invalid item.
        what: String,
    },
    /// A checkpoint has another version of the format.
    #[cfg(feature = "checkpoint")]
    #[error(
        "the checkpoint has format {found}, and this program reads format {known}: \
        finish the run with the program that wrote it"
    )]
    #[non_exhaustive]
    CheckpointVersion {
        /// Version of the file.
        found: u32,
        /// The version that this program reads.
        known: u32,
    },
    /// Two checkpoints to be pooled have the same seed, so they are of the same run.
    #[cfg(feature = "checkpoint")]
    #[error("{} and {} have the same seed {seed}: the same run would count twice", paths[0].display(), paths[1].display())]
    #[non_exhaustive]
    SameSeed {
        /// The seed.
        seed: u64,
        /// Both files.
        paths: [std::path::PathBuf; 2],
    },
    /// A file of a checkpoint cannot be written or read. The source is the cause.
    #[cfg(feature = "checkpoint")]
    #[error("{}: {source}", path.display())]
    #[non_exhaustive]
    CheckpointFile {
        /// The file, or the folder.
        path: std::path::PathBuf,
        /// Error of the system, or what is wrong with the file.
        #[source]
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// One of several replicas failed. Its own error is the source.
    #[error("replica {replica}, of seed {seed}, failed: {source}")]
    Replica {
        /// Its number, from 0.
        replica: usize,
        /// Its seed.
        seed: u64,
        /// Error of the replica.
        #[source]
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

/// The same sentence as `Display`.
impl fmt::Debug for Error {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, formatter)
    }
}

/// With at least this number of field events within a diameter, the field is reported as the cause.
const HELD_BY_FIELD: u32 = 100;
