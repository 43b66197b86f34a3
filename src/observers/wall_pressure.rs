//! Pressure on the walls.

use super::bins::{HeightBins, Place};
use super::one_run::OneRun;
use crate::drive::WallContact;
use crate::statistics::{BlockAverages, Estimate};
use crate::{
    Collision, Error, Field, Frame, Merge, Observer, ObserverError, Recorder, Scene, TemperatureProfile, Wall,
};

/// Pressures on base and lid, for every scene and drive: of a column, of one that hangs, and of a
/// closed box.
///
/// At the wall where the column ends ([`Scene::open_end`]) it is T n(contact), by the momentum that
/// spheres carry to it. In the potential u in which a run is made the normal pressure over T falls
/// as dp/dx = −n u', so that with z, the distance from contact with that wall, and any depth D,
/// exactly
///
/// p(wall) = ⟨(1/D) ∫₀ᴰ p dz − (1/A) Σ u' (1 − z/D)⟩,
///
/// the sum over spheres with z < D, and u' counted positive where it pulls away from the wall.
/// Where there are vertical event chains, p comes from their collisions, as in
/// [`ChainPressureProfile`](super::ChainPressureProfile), and D is where the density has changed by
/// about e: the whole box if it has no weight. Local moves tell nothing about collisions: there the
/// contact density is extrapolated from the spheres within a fifth of a diameter, which knows it to
/// 0.4 % at best, and has ten to a hundred times the variance.
///
/// The other wall bears the weight of the column on top of that.
///
/// With a temperature that varies, what the wall at the open end bears is that of the run, in the
/// field that it was made in: if the field is [certified](crate::Simulation::certificate), that of
/// the scene.
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
    /// Height of centers in contact with the open end, and T there.
    contact_height: f64,
    temperature: f64,
    /// The heights within D of it.
    near: HeightBins,
    depth: f64,
    particles: f64,
    /// Σ s q of vertical chains in these heights, and the path of these chains, since the last
    /// frame.
    transferred: f64,
    path: f64,
    /// Sweeps that ended with an error, up to the last frame.
    incomplete: u64,
    /// Contact density times area; spheres near the open end, and the sum of u' (1 − z/D) over
    /// them; what was transferred, and the path; the weight.
    averages: BlockAverages,
}

impl WallPressure {
    const COMPONENTS: usize = 6;

    /// For runs of `scene`.
    ///
    /// # Errors
    /// None for a scene that was made by [`Scene::new`].
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

    /// Frames observed.
    #[must_use]
    pub fn observations(&self) -> u64 {
        self.averages.observations()
    }

    /// Mean pressure on a wall, in m g/d².
    ///
    /// Of a column that never came near its open end it is 0(0) there: less than one sphere within
    /// D on average over the whole run would exert.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] below 16 frames.
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

/// The distance from the open end within which the potential over T, or T, changes by about one and
/// by e.
fn depth<F: Field, T: TemperatureProfile>(scene: &Scene<F, T>) -> f64 {
    /// Steps by which it is looked for, each half of that before, from the whole box on.
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
        self.run.require_same_scene(&other.run)?;
        self.averages.merge(&other.averages)?;
        self.run.join(&other.run);
        Ok(())
    }
}

impl Observer for WallPressure {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.run.admit(frame)?;
        let incomplete = frame.move_counts().incomplete_sweeps;
        if std::mem::replace(&mut self.incomplete, incomplete) != incomplete {
            // A chain that ended with an error has collisions and no length.
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
