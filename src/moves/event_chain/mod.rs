//! Straight event chains in a field that varies along one axis.

mod constraints;
mod cut;
mod force_bound;
mod length;
#[cfg(feature = "checkpoint")]
mod saved;
mod stall_guard;
mod tiles;
mod visit;

use super::{LocalMoves, Sweep, local};
use crate::configuration::{Contact, wrap};
use crate::drive::Drive;
use crate::frame::Phase;
use crate::observer::{AcceptedMove, Collision};
use crate::random::{Generator, exponential, index, unit};
use crate::{Error, Field, Slab, TemperatureProfile};
use cut::Sizes;
use force_bound::ForceBounds;
use length::ChainLength;
use nalgebra::Vector3;
use stall_guard::StallGuard;
use tiles::Tiles;

/// What becomes of a chain that the field stops.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum FieldEvent {
    /// Another sphere, drawn with probability proportional to |u'|, goes on downhill.
    ///
    /// The chain does not retrace its path, so long chains move the column: the default.
    #[default]
    Relocate,
    /// The sphere itself turns round. Correct as well, and slow: the chain undoes what it has done.
    Reverse,
    /// Wrong, to show that tests notice: any sphere, without the weight |u'|.
    #[cfg(test)]
    Unweighted,
    /// Wrong, to show that tests notice: a sphere drawn as for `Relocate`, but sent uphill.
    #[cfg(test)]
    Uphill,
}

/// Straight event chains (Bernard, Krauth and Wilson, doi:10.1103/PhysRevE.80.056704; the field as a factor
/// of its own, Michel, Kapfer and Krauth, doi:10.1063/1.4863991).
///
/// A sphere moves along an axis until it touches another, which moves on in the same direction, until
/// the chain has used up its length. Nothing is ever rejected. Along x a sphere that goes uphill in the reduced
/// potential u is stopped by the field at the rate |u'| per distance; then the chain continues as
/// [`FieldEvent`] says. A wall turns a sphere round. A sweep of [local moves](Self::local_moves) follows the chains.
///
/// Where the base is wide enough for several tiles of some 32 000 spheres, chains go tile by tile, between strips of spheres that
/// are frozen meanwhile and turn chains round as walls do (Kapfer and Krauth, doi:10.1088/1742-6596/454/1/012031). Then a sweep runs all chains
/// of some tiles, none in others, and [`path_per_sphere`](Self::path_per_sphere) holds on average over some tens of sweeps. The
/// outcome does not depend on the number of cores that share them.
///
/// Chains hold global balance, not detailed balance; the proof is in `docs/event_chains.md`.
///
/// ```
/// use gradient_mc::{Scene, Simulation, Slab, field::UniformField, moves::EventChains};
/// use gradient_mc::{observers::CenterOfMass, temperature::Isothermal};
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 360, UniformField::default(), Isothermal::new(5.0)?)?;
/// let mut simulation = Simulation::builder(scene).moves(EventChains::default()).seed(1).build()?;
/// let mut center_of_mass = CenterOfMass::new();
/// simulation.equilibrate(100, &mut ())?;
/// simulation.run(400, &mut center_of_mass)?;
/// assert!(simulation.move_counts().events > 0);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EventChains {
    /// None where it is tuned.
    length: Option<f64>,
    vertical_fraction: f64,
    path_per_sphere: f64,
    field_event: FieldEvent,
    local_moves: Option<LocalMoves>,
}

impl Default for EventChains {
    /// Chains whose length is tuned while equilibrating, 90 % of their path vertical, and local moves of up to half
    /// a diameter.
    fn default() -> Self {
        Self {
            length: None,
            vertical_fraction: 0.9,
            path_per_sphere: Self::PATH_PER_SPHERE,
            field_event: FieldEvent::Relocate,
            local_moves: Some(LocalMoves::one(0.5)),
        }
    }
}

impl EventChains {
    /// [`path_per_sphere`](Self::path_per_sphere) unless it is set.
    pub const PATH_PER_SPHERE: f64 = 0.25;
    /// Collisions and field events of a sweep, per sphere, beyond which its chains have a shorter path: so a sweep takes
    /// a bounded time in any field. It is found out while equilibrating.
    pub const MOST_EVENTS: f64 = 100.0;
    /// Smallest mean length of a chain, in diameters.
    pub const MINIMUM_LENGTH: f64 = 1e-3;
    /// Largest mean length of a chain, in diameters.
    pub const MAXIMUM_LENGTH: f64 = 1e6;

    /// Chains of the given mean length in diameters, not tuned; single lengths are uniform between zero
    /// and twice that, so that none is commensurate with the box. Lateral ones, which go round and
    /// round, are on average at most as long as the slab is wide.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] below [`MINIMUM_LENGTH`](Self::MINIMUM_LENGTH), of which a sweep would take too many,
    /// or above [`MAXIMUM_LENGTH`](Self::MAXIMUM_LENGTH).
    pub fn with_length(length: f64) -> Result<Self, Error> {
        if (Self::MINIMUM_LENGTH..=Self::MAXIMUM_LENGTH).contains(&length) {
            Ok(Self { length: Some(length), ..Self::default() })
        } else {
            let requirement = "it must be at least 1e-3 and at most 1e6 diameters";
            Err(Error::InvalidParameter { name: "mean length of event chains", value: length, requirement })
        }
    }

    /// Share of the path of all chains that runs along x; the rest runs along y and z, in equal numbers of
    /// chains.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] unless above 0 and below 1: without both kinds not every
    /// configuration can be reached.
    pub fn vertical_fraction(self, fraction: f64) -> Result<Self, Error> {
        if fraction > 0.0 && fraction < 1.0 {
            Ok(Self { vertical_fraction: fraction, ..self })
        } else {
            let requirement = "it must lie between 0 and 1, both excluded";
            Err(Error::InvalidParameter {
                name: "vertical fraction of event chains",
                value: fraction,
                requirement,
            })
        }
    }

    /// Path of all chains of a sweep, in diameters per sphere, on average over sweeps; less where
    /// vertical chains would be stopped more than [`MOST_EVENTS`](Self::MOST_EVENTS) times on it. With a shorter path local moves
    /// get a larger part of the time.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] below 1e-3 or above 1e3.
    pub fn path_per_sphere(self, path: f64) -> Result<Self, Error> {
        if (1e-3..=1e3).contains(&path) {
            Ok(Self { path_per_sphere: path, ..self })
        } else {
            let requirement = "it must be at least 1e-3 and at most 1e3 diameters";
            Err(Error::InvalidParameter { name: "path of event chains per sphere", value: path, requirement })
        }
    }

    /// What becomes of a chain that the field stops.
    #[must_use]
    pub fn field_event(self, field_event: FieldEvent) -> Self {
        Self { field_event, ..self }
    }

    /// A sweep of local moves after the chains of each sweep, by default with S = 0.5.
    ///
    /// Chains move a whole column and local moves its spheres: by both together n(x) becomes known
    /// two to three times as fast in every bin, the center of mass half as fast.
    #[must_use]
    pub fn local_moves(self, local_moves: Option<LocalMoves>) -> Self {
        Self { local_moves, ..self }
    }

    /// Fails if there are local moves too large for `slab`.
    pub(crate) fn check(&self, slab: &Slab) -> Result<(), Error> {
        self.local_moves.map_or(Ok(()), |moves| moves.check(slab))
    }

    /// Mean length of a chain in diameters, unless it is tuned.
    #[must_use]
    pub fn length(&self) -> Option<f64> {
        self.length
    }
}

/// Event chains at work: the choices, and what was derived from the drive.
#[derive(Debug, Clone)]
pub(crate) struct Engine {
    chains: EventChains,
    length: Box<ChainLength>,
    bounds: ForceBounds,
    /// Path by which the chains so far exceed what the sweeps so far were to use, in diameters.
    advance: f64,
    /// How wide systems are shared out.
    tiles: Box<Tiles>,
    pub(super) local: Option<local::Engine>,
}

impl Engine {
    pub(super) fn new(chains: EventChains) -> Self {
        Self {
            chains,
            length: Box::new(ChainLength::new(&chains)),
            bounds: ForceBounds::default(),
            advance: 0.0,
            tiles: Box::new(Tiles::new(Sizes::GOOD)),
            local: chains.local_moves.map(local::Engine::new),
        }
    }

    /// Chains whose lengths add up to at most [`EventChains::path_per_sphere`] for every sphere, on average over
    /// sweeps, and local moves.
    pub(super) fn sweep<F: Field, T: TemperatureProfile, D: Drive<F, T>>(
        &mut self,
        sweep: &mut Sweep<'_, F, T, D>,
    ) -> Result<(), Error> {
        self.bounds.follow(sweep.drive, sweep.scene)?;
        if !self.length.begun {
            let forces = sweep
                .configuration
                .positions()
                .iter()
                .map(|&[height, ..]| sweep.drive.reduced_force(sweep.scene, height).abs());
            self.length.begin(forces.sum::<f64>() / sweep.configuration.len() as f64);
        }
        if sweep.phase == Phase::Equilibration {
            self.length.tune(sweep.scene.slab().height());
        }
        let particles = sweep.configuration.len();
        let vertical_length = self.length.mean();
        let lateral_lengths = sweep.configuration.slab().widths().map(|width| vertical_length.min(width));
        if self.tiles.suit(sweep.configuration.slab(), particles) {
            let lengths = [vertical_length, lateral_lengths[0], lateral_lengths[1]];
            let path = self.length.path_per_sphere;
            let sums = self.tiles.sweep(sweep, &self.chains, &self.bounds, lengths, path)?;
            self.length.path += sums.path;
            self.length.recent[0] += sums.path;
            self.length.recent[1] += sums.events as f64;
            self.length.field_events += sums.field_events;
            return self.local.as_mut().map_or(Ok(()), |moves| moves.sweep(sweep));
        }
        sweep.configuration.track();
        let lateral_length = 0.5 * (lateral_lengths[0] + lateral_lengths[1]);
        // Share of the chains that makes the share of the path.
        let share = self.chains.vertical_fraction;
        let vertical = share * lateral_length / (share * lateral_length + (1.0 - share) * vertical_length);
        // What one sweep uses too much, later ones use less. Lengths do not depend on the configuration,
        // so neither does where a sweep ends. What one that failed did not use is not made up for.
        self.advance = self.advance.max(0.0) - self.length.path_per_sphere * particles as f64;
        while self.advance < 0.0 {
            let axis = if unit(sweep.generator) < vertical {
                0
            } else if unit(sweep.generator) < 0.5 {
                1
            } else {
                2
            };
            let mean = if axis == 0 { vertical_length } else { lateral_lengths[axis - 1] };
            let length = 2.0 * mean * unit(sweep.generator);
            self.advance += length;
            let sphere = index(sweep.generator, particles);
            let mut left = length;
            let outcome = if axis == 0 {
                let rising = unit(sweep.generator) < 0.5;
                let outcome = self.vertical_chain(sweep, sphere, rising, &mut left);
                self.length.path += length - left;
                outcome
            } else {
                lateral_chain(sweep, sphere, axis, &mut left)
            };
            outcome?;
            sweep.move_counts.chains += 1;
            if let Some(recorder) = &mut sweep.recorder {
                recorder.record_chain(axis, length - left);
            }
        }
        self.local.as_mut().map_or(Ok(()), |moves| moves.sweep(sweep))
    }

    /// A chain along x that has `left` to go; less than that, if it is given up or fails.
    fn vertical_chain<F: Field, T: TemperatureProfile, D: Drive<F, T>>(
        &mut self,
        sweep: &mut Sweep<'_, F, T, D>,
        mut sphere: usize,
        mut rising: bool,
        left: &mut f64,
    ) -> Result<(), Error> {
        let slab = *sweep.configuration.slab();
        let mut stall_guard = StallGuard::new(*left, sweep.phase);
        // The field's clock: it strikes when the bound of the force, integrated along the path, uses it up.
        let mut clock = exponential(sweep.generator);
        loop {
            let position = sweep.configuration.position(sphere);
            let height = position[0];
            let to_wall = if rising { slab.highest_center() - height } else { height - slab.lowest_center() };
            let (limit, mut stop) = if *left <= to_wall { (*left, Stop::End) } else { (to_wall, Stop::Wall) };
            let mut distance = limit;
            if let Some(contact) = sweep.configuration.first_contact(sphere, 0, rising, limit) {
                (distance, stop) = (contact.distance, Stop::Contact(contact));
            }
            if let Some((event, bound)) = self.bounds.thinning_event(&mut clock, height, rising, distance) {
                (distance, stop) = (event, Stop::Field { bound });
            }
            let signed = if rising { distance } else { -distance };
            let new_height = (height + signed).clamp(slab.lowest_center(), slab.highest_center());
            sweep.displace(sphere, position, 0, signed, new_height);
            *left -= distance;
            self.length.recent[0] += distance;
            self.length.recent[1] += 1.0;
            if !stall_guard.lasts(*left)? {
                // Given up.
                return Ok(());
            }
            match stop {
                Stop::End => return Ok(()),
                Stop::Contact(contact) => {
                    sweep.collide(0, new_height, contact);
                    sphere = contact.sphere;
                }
                Stop::Wall => {
                    sweep.move_counts.events += 1;
                    rising = !rising;
                }
                Stop::Field { bound } => {
                    clock = exponential(sweep.generator);
                    let force = sweep.drive.reduced_force(sweep.scene, new_height);
                    let uphill = if rising { force } else { -force };
                    if uphill.is_nan() || uphill > bound {
                        return Err(Error::InvalidForce { height: new_height, force, bound });
                    }
                    if unit(sweep.generator) * bound < uphill {
                        sweep.move_counts.events += 1;
                        self.length.field_events += 1;
                        stall_guard.field_event();
                        let Sweep { scene, drive, configuration, generator, .. } = sweep;
                        let force_of = |other: usize| {
                            let height = configuration.position(other)[0];
                            (height, drive.reduced_force(scene, height))
                        };
                        let (rule, spheres) = (self.chains.field_event, configuration.len());
                        (sphere, rising) = field_event(rule, generator, spheres, sphere, force, force_of)?;
                    }
                }
            }
        }
    }
}

/// Which sphere goes on, and whether upwards, after the field has stopped `sphere`, where the force is
/// `force`. `force_of` gives height and force of any of the spheres that may move.
fn field_event(
    rule: FieldEvent,
    generator: &mut Generator,
    spheres: usize,
    sphere: usize,
    force: f64,
    force_of: impl Fn(usize) -> (f64, f64),
) -> Result<(usize, bool), Error> {
    /// Steps of the random walk over spheres. Balance holds for any number; with more, fewer chains
    /// turn round where forces differ much.
    const STEPS: u32 = 4;
    let (mut chosen, mut chosen_force) = (sphere, force);
    if rule != FieldEvent::Reverse {
        for _ in 0..STEPS {
            let other = index(generator, spheres);
            let (height, other_force) = force_of(other);
            if other_force.is_nan() {
                return Err(Error::InvalidForce { height, force: other_force, bound: f64::MAX });
            }
            #[cfg(test)]
            if rule == FieldEvent::Unweighted {
                (chosen, chosen_force) = (other, other_force);
                continue;
            }
            // Metropolis for the distribution |u'|.
            if other_force.abs() >= chosen_force.abs() * unit(generator) && other_force != 0.0 {
                (chosen, chosen_force) = (other, other_force);
            }
        }
    }
    #[cfg(test)]
    if rule == FieldEvent::Uphill {
        return Ok((chosen, chosen_force > 0.0));
    }
    Ok((chosen, chosen_force < 0.0))
}

/// What ends a straight piece of a vertical chain.
enum Stop {
    /// The chain has used up its length.
    End,
    Contact(Contact),
    Wall,
    /// The field, if the true force, not its bound, has it so.
    Field {
        bound: f64,
    },
}

/// A chain along a periodic axis, where nothing but spheres stops it, that has `left` to go.
fn lateral_chain<F, T, D>(
    sweep: &mut Sweep<'_, F, T, D>,
    mut sphere: usize,
    axis: usize,
    left: &mut f64,
) -> Result<(), Error> {
    let width = sweep.configuration.slab().widths()[axis - 1];
    let mut stall_guard = StallGuard::new(*left, sweep.phase);
    loop {
        let position = sweep.configuration.position(sphere);
        // Beyond half the width an image would be nearer.
        let limit = left.min(0.5 * width);
        let contact = sweep.configuration.first_contact(sphere, axis, true, limit);
        let distance = contact.map_or(limit, |contact| contact.distance);
        let coordinate = wrap(position[axis] + distance, width);
        sweep.displace(sphere, position, axis, distance, coordinate);
        *left -= distance;
        if !stall_guard.lasts(*left)? {
            return Ok(());
        }
        if let Some(contact) = contact {
            sweep.collide(axis, position[0], contact);
            sphere = contact.sphere;
        } else if *left <= 0.0 {
            return Ok(());
        }
    }
}

impl<F, T, D> Sweep<'_, F, T, D> {
    /// Moves a sphere along one axis to `coordinate`.
    #[inline]
    fn displace(&mut self, sphere: usize, position: [f64; 3], axis: usize, distance: f64, coordinate: f64) {
        let mut moved = position;
        moved[axis] = coordinate;
        self.configuration.relocate(sphere, moved);
        if let Some(recorder) = &mut self.recorder {
            let mut displacement = Vector3::zeros();
            displacement[axis] = distance;
            let chain_axis = Some(axis);
            recorder.record_move(&AcceptedMove { from_height: position[0], displacement, chain_axis });
        }
    }

    /// Counts a collision of a sphere at `height`, and reports it.
    #[inline]
    fn collide(&mut self, axis: usize, height: f64, contact: Contact) {
        self.move_counts.events += 1;
        if let Some(recorder) = &mut self.recorder {
            let to_height = self.configuration.position(contact.sphere)[0];
            let separation = contact.separation;
            recorder.record_collision(&Collision { axis, from_height: height, to_height, separation });
        }
    }
}

#[cfg(test)]
mod tests;
