//! Pressure on the walls.

use super::bins::{HeightBins, Place};
use super::one_run::OneRun;
use crate::drive::WallContact;
use crate::statistics::{BlockAverages, Estimate};
use crate::{
    Collision, Error, Field, Frame, Merge, Observer, ObserverError, Recorder, Scene, TemperatureProfile, Wall,
};

/// Mean pressures on base and lid in m g/d², for any scene and drive, including closed boxes and
/// fields that pull up.
///
/// The pressure at the [open end](Scene::open_end) of the column is T n(contact). In the reduced
/// potential u the normal pressure over T, p, obeys dp/dx = −n u'. With the distance z from contact
/// with this wall and any depth D this gives exactly
///
/// p(wall) = ⟨(1/D) ∫₀ᴰ p dz − (1/A) Σ u' (1 − z/D)⟩,
///
/// The sum is over spheres with z < D, and u' is positive if it pulls away from the wall. With
/// vertical event chains, p comes from their collisions, as in
/// [`ChainPressureProfile`](super::ChainPressureProfile), and D is the depth at which the density
/// has changed by about e: the whole box if there is no field. With local moves alone, the contact
/// density is extrapolated from the spheres within 0.2 diameters. This has a systematic error of up
/// to 0.4 %, and ten to a hundred times the variance.
///
/// The pressure on the other wall is larger by the weight of the column per area.
///
/// If the temperature varies, the pressure at the open end is that in the effective field of the
/// run. It is that of the scene if the field is self-consistent
/// ([`certificate`](crate::Simulation::certificate)).
///
/// ```
/// use gradient_mc::observers::{Bins, EquationOfStateProfile, WallPressure};
/// use gradient_mc::{Scene, Simulation, Slab, Wall, field::UniformField, temperature::Isothermal};
/// // A closed box without weight.
/// let slab = Slab::new(10.0, 5.0, 5.0)?;
/// let scene = Scene::new(slab, 100, UniformField::new(0.0)?, Isothermal::new(2.0)?)?;
/// let mut simulation = Simulation::builder(scene).seed(1).build()?;
/// let mut profile = EquationOfStateProfile::new(&slab, Bins::of_width(1.0))?;
/// let mut walls = WallPressure::new(&scene)?;
/// simulation.equilibrate(100, &mut ())?;
/// simulation.run(400, &mut (&mut profile, &mut walls))?;
/// println!("pressure on the lid: {}", walls.at(Wall::Lid)?);
/// profile.set_open_end_pressure(walls.at(scene.open_end())?)?;
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct WallPressure {
    run: OneRun,
    open_end: Wall,
    /// Height of centers in contact with the wall at the open end; below, T there.
    contact_height: f64,
    temperature: f64,
    /// The heights within D of this wall.
    near: HeightBins,
    depth: f64,
    particles: f64,
    /// Since the last frame: Σ s q of vertical chains in these heights; below, the path of these
    /// chains.
    transferred: f64,
    path: f64,
    /// Number of incomplete sweeps up to the last frame.
    incomplete: u64,
    /// Components: contact density times area; number of spheres near the open end, and the sum of
    /// u' (1 − z/D) over them; Σ s q, and the path; the weight.
    averages: BlockAverages,
}

impl WallPressure {
    const COMPONENTS: usize = 6;

    /// Makes an observer for runs of `scene`.
    ///
    /// # Errors
    /// None if the scene was made by [`Scene::new`].
    pub fn new<F: Field, T: TemperatureProfile>(scene: &Scene<F, T>) -> Result<Self, Error> {
        let (slab, open_end) = (scene.slab(), scene.open_end());
        let (contact_height, depth) = (open_end.contact_height(slab), depth(scene));
        let (low, high) = match open_end {
            Wall::Lid => (contact_height - depth, contact_height),
            Wall::Base => (contact_height, contact_height + depth),
        };
        Ok(Self {
            run: OneRun::in_slab(slab),
            open_end,
            contact_height,
            temperature: scene.temperature().temperature(contact_height),
            near: HeightBins::new(slab, low, high, 1)?,
            depth: high - low,
            particles: scene.particles() as f64,
            transferred: 0.0,
            path: 0.0,
            incomplete: 0,
            averages: BlockAverages::new(Self::COMPONENTS)?.said_of("frames for the pressure on a wall"),
        })
    }

    /// Number of frames observed.
    #[must_use]
    pub fn observations(&self) -> u64 {
        self.averages.observations()
    }

    /// Mean pressure on a wall, in m g/d².
    ///
    /// It is 0(0) at the open end if no sphere ever came near this wall.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] for fewer than 16 frames.
    pub fn at(&self, wall: Wall) -> Result<Estimate, Error> {
        let area = self.near.base_area();
        let pressures = self.averages.jackknife(|means| {
            let &[contact, spheres, held, transferred, path, weight] = means else { return [f64::NAN] };
            let momentum = if path > 0.0 {
                (spheres + self.particles * transferred / path) / self.depth - held
            } else {
                contact
            };
            let weight = if wall == self.open_end { 0.0 } else { weight };
            [(self.temperature * momentum + weight) / area]
        })?;
        Ok(pressures.into_iter().next().unwrap_or(Estimate::new(f64::NAN, f64::NAN)))
    }
}

/// The distance from the open end in which u changes by about 1, or T by a factor of about e.
fn depth<F: Field, T: TemperatureProfile>(scene: &Scene<F, T>) -> f64 {
    /// Number of bisection steps, starting from the whole box.
    const HALVINGS: u32 = 40;
    let slab = scene.slab();
    let end = scene.open_end().contact_height(slab);
    let inwards = if scene.open_end() == Wall::Lid { -1.0 } else { 1.0 };
    let state = |height: f64| (scene.field().potential(height), scene.temperature().temperature(height));
    let (potential, temperature) = state(end);
    let change = |depth: f64| {
        let (other, other_temperature) = state(end + inwards * depth);
        ((other - potential) / temperature).abs() + libm::log(other_temperature / temperature).abs()
    };
    let whole = slab.highest_center() - slab.lowest_center();
    let (mut low, mut high) = (0.0, whole);
    if change(whole) <= 1.0 {
        return whole;
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if change(middle) > 1.0 { high = middle } else { low = middle }
    }
    high
}

impl Merge for WallPressure {
    fn merge(&mut self, other: &Self) -> Result<(), Error> {
        self.near.require_same(&other.near)?;
        self.run.pool(&mut self.averages, &other.run, &other.averages)
    }
}

impl Observer for WallPressure {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.run.admit(frame)?;
        let incomplete = frame.move_counts().incomplete_sweeps;
        if std::mem::replace(&mut self.incomplete, incomplete) != incomplete {
            // The length of a chain that ended with an error is not recorded, so its collisions are
            // dropped.
            (self.transferred, self.path) = (0.0, 0.0);
        }
        let field = frame.field();
        let away = if self.open_end == Wall::Lid { 1.0 } else { -1.0 };
        let mut contact = WallContact::default();
        let (mut spheres, mut held, mut weight) = (0.0, 0.0, 0.0);
        for height in frame.heights() {
            weight += away * field.acceleration(height);
            let distance = (height - self.contact_height).abs();
            contact.add(distance);
            if let Place::Inside(..) = self.near.locate(height) {
                spheres += 1.0;
                held += away * frame.reduced_force(height) * (1.0 - distance / self.depth);
            }
        }
        let contact = contact.density_times_area();
        self.averages.push(&[contact, spheres, held, self.transferred, self.path, weight])?;
        (self.transferred, self.path) = (0.0, 0.0);
        Ok(())
    }

    fn recorder(&mut self) -> Option<&mut dyn Recorder> {
        Some(self)
    }
}

impl Recorder for WallPressure {
    fn record_collision(&mut self, collision: &Collision) {
        if collision.axis == 0 {
            let [one, other] = [collision.from_height, collision.to_height];
            let transferred = &mut self.transferred;
            self.near.spread(one.min(other), one.max(other), |_, part| {
                *transferred += collision.separation * part;
            });
        }
    }

    fn record_chain(&mut self, axis: usize, length: f64) {
        if axis == 0 {
            self.path += length;
        }
    }
}

persist!(WallPressure {
    part run,
    same open_end,
    same near,
    value transferred,
    value path,
    count incomplete,
    part averages,
});
