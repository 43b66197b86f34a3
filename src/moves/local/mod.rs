//! Local trial moves: one sphere, a small uniform displacement, Metropolis acceptance.

mod batch;
mod domains;
mod tuning;
mod visit;

use super::Sweep;
use crate::configuration::Layer;
use crate::drive::Drive;
use crate::random::Generator;
use crate::{Error, Field, Slab, TemperatureProfile};
use batch::Slice;
use domains::{Domains, Sizes};
use rand::{Rng, SeedableRng};
pub use tuning::TunedDisplacements;
use visit::{Common, Outcome, Scratch};

/// Moves of one sphere, chosen at random, by a displacement uniform in the cube (−S, S)³.
///
/// A trial that leaves the slab or overlaps is rejected; otherwise it is accepted with probability
/// min(1, exp(−Δu)) (eq. 12 of doi:10.1103/PhysRevE.83.061306 and those derived from it). A trial
/// and its reverse are proposed with the same probability, so detailed balance holds.
///
/// Each sweep cuts a large box into domains at random places, and makes as many trials in each as
/// it has spheres, so that threads can share the work. Trials that leave a domain are rejected.
/// `docs/physics.md` proves that detailed balance still holds. The result does not depend on the
/// number of threads.
///
/// ```
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, moves::LocalMoves};
/// use gradient_mc::temperature::Isothermal;
/// let slab = Slab::new(60.0, 6.0, 6.0)?;
/// let scene = Scene::new(slab, 360, UniformField::default(), Isothermal::new(5.0)?)?;
/// // Small steps for the base, large ones for the top.
/// let moves = LocalMoves::mixture(&[0.15, 1.0])?;
/// let mut simulation = Simulation::builder(scene).moves(moves).seed(1).build()?;
/// simulation.run(100, &mut ())?;
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalMoves {
    /// The sizes; unused places repeat the last.
    sizes: [f64; Self::MOST_SIZES],
    count: usize,
    /// Upper limit of displacements along y and z.
    across: f64,
    tuned: bool,
}

impl LocalMoves {
    /// Largest number of sizes in a mixture.
    pub const MOST_SIZES: usize = 4;

    /// Moves with S = `maximum_displacement`, in diameters.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] unless positive and finite. S must not exceed half the smallest
    /// side of the slab, which is checked when the simulation is built.
    pub fn new(maximum_displacement: f64) -> Result<Self, Error> {
        Self::mixture(&[maximum_displacement])
    }

    /// Moves with several S. Each trial draws one of them with equal probability, independently of
    /// the position of the sphere, so detailed balance holds.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] unless there are 1 to [`MOST_SIZES`](Self::MOST_SIZES), each as
    /// in [`new`](Self::new).
    pub fn mixture(maximum_displacements: &[f64]) -> Result<Self, Error> {
        let count = maximum_displacements.len();
        let Some(&last) = maximum_displacements.last().filter(|_| count <= Self::MOST_SIZES) else {
            let requirement = "there must be at least one and at most four";
            let name = "number of maximum displacements";
            return Err(Error::InvalidParameter { name, value: count as f64, requirement });
        };
        let mut sizes = [last; Self::MOST_SIZES];
        sizes[..count].copy_from_slice(maximum_displacements);
        for size in sizes {
            Error::require_positive("maximum displacement", size)?;
        }
        Ok(Self { sizes, count, across: f64::INFINITY, tuned: false })
    }

    /// Moves with S tuned in equilibration and fixed in production. They need no parameters.
    ///
    /// There are two kinds of sweeps, drawn at random. In *short* ones the box is cut into slabs
    /// about a dozen diameters thick. S depends on the height of the slab, is at most three
    /// diameters, and is chosen to renew the structure around a sphere the fastest. In *long* ones
    /// S along x is the same at all heights, up to half the height of the box. Where the column is
    /// not dense, such moves relax it by far the fastest. Their S and the share of long sweeps are
    /// chosen for the fastest relaxation of the column as a whole. The measure for both is the mean
    /// square of accepted displacements along x per trial, not the acceptance. Where there are too
    /// few spheres to choose, sizes are drawn at random. [`TunedDisplacements`] gives the result.
    ///
    /// In production no S depends on the configuration, so detailed balance holds. Equilibrate
    /// until the column is stationary.
    ///
    /// ```
    /// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, moves::LocalMoves};
    /// use gradient_mc::{start::RandomInsertion, temperature::Isothermal};
    /// let scene = Scene::new(Slab::new(400.0, 5.0, 5.0)?, 1000, UniformField::default(), Isothermal::new(20.0)?)?;
    /// let mut simulation =
    ///     Simulation::builder(scene).start(RandomInsertion::default()).moves(LocalMoves::tuned()).seed(1).build()?;
    /// simulation.equilibrate(500, &mut ())?;
    /// let center_of_mass = simulation.frame().heights().sum::<f64>() / 1000.0;
    /// assert!(center_of_mass < 60.0, "it has fallen from 200");
    /// # Ok::<(), gradient_mc::Error>(())
    /// ```
    #[must_use]
    pub fn tuned() -> Self {
        Self {
            sizes: [TunedDisplacements::LARGEST_SHORT; Self::MOST_SIZES],
            count: 0,
            across: f64::INFINITY,
            tuned: true,
        }
    }

    /// Fails if S is too large for a slab.
    pub(crate) fn check(&self, slab: &Slab) -> Result<(), Error> {
        if self.tuned {
            return Ok(());
        }
        let [width_y, width_z] = slab.widths();
        let largest = 0.5 * slab.height().min(width_y).min(width_z);
        match self.sizes.into_iter().find(|&size| size > largest) {
            None => Ok(()),
            Some(value) => Err(Error::InvalidParameter {
                name: "maximum displacement",
                value,
                requirement: "it must be at most half the smallest side of the slab",
            }),
        }
    }

    /// Moves with one S that needs no check.
    pub(crate) fn one(maximum_displacement: f64) -> Self {
        Self::capped(maximum_displacement, f64::INFINITY)
    }

    /// One S in diameters, along y and z at most `across`.
    fn capped(maximum_displacement: f64, across: f64) -> Self {
        Self { sizes: [maximum_displacement; Self::MOST_SIZES], count: 1, across, tuned: false }
    }

    /// The largest S along y and z.
    fn largest_across(&self) -> f64 {
        self.maximum_displacement().min(self.across)
    }

    /// S in diameters: the largest of a mixture; for [tuned](Self::tuned) moves the largest allowed
    /// in short sweeps.
    #[must_use]
    pub fn maximum_displacement(&self) -> f64 {
        self.sizes.into_iter().fold(0.0, f64::max)
    }
}

/// The engine of local moves.
#[derive(Debug, Clone)]
pub(crate) struct Engine {
    moves: LocalMoves,
    domains: Domains,
    sweeps: u64,
    /// Outcomes of the slabs.
    outcomes: Vec<Outcome>,
    /// One, or one for each slab with the feature `rayon`.
    scratch: Vec<Scratch>,
    /// Present if S is tuned.
    tuning: Option<Box<TunedDisplacements>>,
}

impl Engine {
    /// Spheres need thousands of sweeps to leave the neighborhood in which they are sorted.
    const SWEEPS_BETWEEN_SORTS: u64 = 1000;

    pub(in crate::moves) fn new(moves: LocalMoves) -> Self {
        Self {
            moves,
            domains: Domains::new(if moves.tuned { Sizes::TUNED } else { Sizes::GOOD }),
            sweeps: 0,
            outcomes: Vec::new(),
            scratch: Vec::new(),
            tuning: moves.tuned.then(Box::default),
        }
    }

    /// The tuned displacements, if there are any.
    pub(crate) fn tuning(&self) -> Option<&TunedDisplacements> {
        self.tuning.as_deref()
    }

    /// One sweep: as many trials as there are spheres.
    ///
    /// # Errors
    /// [`Error::InvalidPotential`] if field or temperature are not finite between the probed
    /// heights. The configuration stays valid.
    pub(in crate::moves) fn sweep<F: Field, T: TemperatureProfile, D: Drive<F, T>>(
        &mut self,
        sweep: &mut Sweep<'_, F, T, D>,
    ) -> Result<(), Error> {
        let Sweep { scene, drive, configuration, generator, move_counts, phase, recorder } = sweep;
        if self.sweeps.is_multiple_of(Self::SWEEPS_BETWEEN_SORTS) {
            configuration.sort();
        }
        self.sweeps += 1;
        let particles = configuration.len();
        let (grid, layers) = configuration.parts_mut();
        match &mut self.tuning {
            Some(tuning) => tuning.cut(&mut self.domains, grid, layers, particles, *phase, generator),
            None => self.domains.cut(grid, particles, [self.moves.maximum_displacement(); 2], generator),
        }
        let (domains, slabs) = (&self.domains, self.domains.slabs());
        if self.outcomes.len() < slabs {
            self.outcomes.resize_with(slabs, Outcome::default);
        }
        let keys = [generator.next_u64(), generator.next_u64()];
        let (moves, tuning) = (&self.moves, self.tuning.as_deref());
        let mut recorder = recorder.as_mut().take_if(|recorder| recorder.wants_local_moves());
        let record = recorder.is_some() || tuning.is_some_and(TunedDisplacements::adapting);
        let visit = |slab: usize, layers: &mut [Layer], outcome: &mut Outcome, scratch: &mut Scratch| {
            outcome.clear();
            let moves = tuning.map_or(moves, |tuning| tuning.moves_of(slab));
            let common = Common { scene, drive: *drive, grid, moves, domains, record };
            let mut slice = Slice { layers, first: domains.slab(slab)[0] };
            slice.visit(&common, |tile| derived(keys, [slab, tile]), outcome, scratch);
        };
        for color in 0..2 {
            // Slabs of one color are independent: they are swept in any order, or in parallel.
            sweep_color(domains, color, particles, layers, &mut self.outcomes, &mut self.scratch, &visit);
        }
        // Moves before an error, and in other slabs, count.
        for outcome in &self.outcomes[..slabs] {
            move_counts.trials += outcome.trials;
            move_counts.accepted += outcome.accepted;
            move_counts.left_domain += outcome.left_domain;
            if let Some(recorder) = &mut recorder {
                outcome.moves.iter().for_each(|accepted| recorder.record_move(accepted));
            }
        }
        if let Some(height) = self.outcomes[..slabs].iter().find_map(|outcome| outcome.invalid) {
            let potential = drive.reduced_potential(scene, height);
            return Err(Error::InvalidPotential { height, potential });
        }
        if let Some(tuning) = self.tuning.as_deref_mut().filter(|tuning| tuning.adapting()) {
            for (slab, outcome) in self.outcomes[..slabs].iter().enumerate() {
                tuning.learn(slab, &outcome.moves);
            }
            tuning.finish();
        }
        Ok(())
    }
}

#[cfg(feature = "checkpoint")]
impl Engine {
    /// See [`Persist`](crate::checkpoint::Persist).
    pub(in crate::moves) fn persist(
        &mut self,
        archive: &mut crate::checkpoint::Archive<'_>,
        grid: &crate::configuration::Grid,
    ) -> Result<(), Error> {
        archive.count("sweeps", &mut self.sweeps)?;
        let Self { tuning, domains, .. } = self;
        tuning.as_mut().map_or(Ok(()), |tuning| tuning.persist(archive, grid, domains))
    }
}

/// The layers of a slab and its two neighbors, as indices into all layers including those beyond
/// the walls.
fn layers_of(domains: &Domains, slab: usize) -> std::ops::Range<usize> {
    let [first, end] = domains.slab(slab);
    first..end + 2
}

/// Visits every other slab, from `color` on.
#[cfg(not(feature = "rayon"))]
fn sweep_color(
    domains: &Domains,
    color: usize,
    particles: usize,
    layers: &mut [Layer],
    outcomes: &mut [Outcome],
    scratch: &mut Vec<Scratch>,
    visit: &impl Fn(usize, &mut [Layer], &mut Outcome, &mut Scratch),
) {
    if scratch.is_empty() {
        scratch.push(Scratch::for_spheres(particles));
    }
    for slab in (color..domains.slabs()).step_by(2) {
        visit(slab, &mut layers[layers_of(domains, slab)], &mut outcomes[slab], &mut scratch[0]);
    }
}

/// Visits every other slab from `color` on, in parallel.
#[cfg(feature = "rayon")]
fn sweep_color(
    domains: &Domains,
    color: usize,
    particles: usize,
    layers: &mut [Layer],
    outcomes: &mut [Outcome],
    scratch: &mut Vec<Scratch>,
    visit: &(impl Fn(usize, &mut [Layer], &mut Outcome, &mut Scratch) + Sync),
) {
    let slabs = domains.slabs();
    while scratch.len() < slabs {
        scratch.push(Scratch::for_spheres(particles / slabs));
    }
    let all = color..slabs;
    sweep_at_once(domains, all.clone(), (layers, 0), &mut outcomes[all.clone()], &mut scratch[all], visit);
}

/// Visits every other slab of `slabs`, from the first on, in parallel. `layers` begins with the
/// layer of index `begin`. Each half of the slabs gets its own layers, without allocation.
#[cfg(feature = "rayon")]
fn sweep_at_once(
    domains: &Domains,
    slabs: std::ops::Range<usize>,
    (layers, begin): (&mut [Layer], usize),
    outcomes: &mut [Outcome],
    scratch: &mut [Scratch],
    visit: &(impl Fn(usize, &mut [Layer], &mut Outcome, &mut Scratch) + Sync),
) {
    if slabs.is_empty() {
        return;
    }
    // Number of slabs to visit.
    let count = slabs.len().div_ceil(2);
    if count == 1 {
        let range = layers_of(domains, slabs.start);
        let own = &mut layers[range.start - begin..range.end - begin];
        return visit(slabs.start, own, &mut outcomes[0], &mut scratch[0]);
    }
    let first = count / 2 * 2;
    let middle = slabs.start + first;
    // The slab between two of one color has at least two layers, and each of the two reads one.
    let between = layers_of(domains, middle).start;
    let (below, above) = layers.split_at_mut(between - begin);
    let (lower_outcomes, upper_outcomes) = outcomes.split_at_mut(first);
    let (lower_scratch, upper_scratch) = scratch.split_at_mut(first);
    rayon::join(
        || {
            sweep_at_once(domains, slabs.start..middle, (below, begin), lower_outcomes, lower_scratch, visit);
        },
        || {
            sweep_at_once(domains, middle..slabs.end, (above, between), upper_outcomes, upper_scratch, visit);
        },
    );
}

/// The generator of a domain in a sweep.
pub(in crate::moves) fn derived(keys: [u64; 2], [slab, tile]: [usize; 2]) -> Generator {
    /// Mixes all bits (the finalizer of `SplitMix64`).
    fn mix(mut value: u64) -> u64 {
        value = (value ^ value >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        value = (value ^ value >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        value ^ value >> 31
    }
    // Slabs and tiles are at most as many as spheres, which fit a u32.
    let domain = (slab as u64) << 32 | tile as u64;
    let state = [mix(keys[0].wrapping_add(domain)), mix(keys[1] ^ mix(domain))];
    let mut seed = [0; 16];
    seed[..8].copy_from_slice(&state[0].to_le_bytes());
    seed[8..].copy_from_slice(&state[1].to_le_bytes());
    Generator::from_seed(seed)
}

#[cfg(test)]
mod tests;
