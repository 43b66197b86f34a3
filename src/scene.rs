//! What is simulated: a slab, a number of spheres, a field and a temperature profile.

use crate::{Error, Field, Slab, TemperatureProfile, field, temperature};

/// Hard spheres (diameter 1, mass 1) in a slab, under a field and a temperature that depend on
/// height.
///
/// A scene is checked once, when it is made: field and temperature are evaluated at thousands of
/// heights.
///
/// ```
/// use gradient_mc::{Scene, Slab, field::UniformField, temperature::Isothermal};
/// let slab = Slab::new(400.0, 25.0, 25.0)?;
/// let scene = Scene::new(slab, 25_000, UniformField::default(), Isothermal::new(15.0)?)?;
/// assert_eq!(scene.column_density(), 40.0);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
///
/// Field and temperature may be chosen at run time, and scenes of different fields and temperatures
/// may be kept in one list:
///
/// ```
/// use gradient_mc::{Field, Scene, Simulation, Slab, TemperatureProfile, field::*, temperature::*};
/// type ChosenScene = Scene<Box<dyn Field>, Box<dyn TemperatureProfile>>;
/// fn chosen(rate: f64, decay: f64) -> Result<ChosenScene, gradient_mc::Error> {
///     let field: Box<dyn Field> =
///         if rate == 0.0 { Box::new(UniformField::default()) } else { Box::new(ExponentialField::new(rate)?) };
///     let temperature: Box<dyn TemperatureProfile> = if decay == 0.0 {
///         Box::new(Isothermal::new(5.0)?)
///     } else {
///         Box::new(ExponentialTemperature::new(5.0, decay)?)
///     };
///     Scene::new(Slab::new(40.0, 5.0, 5.0)?, 100, field, temperature)
/// }
/// let scenes = vec![chosen(0.0, 0.0)?, chosen(0.02, 0.0)?, chosen(0.0, 0.02)?];
/// std::thread::scope(|scope| {
///     for scene in scenes {
///         scope.spawn(move || Simulation::builder(scene).build()?.run(10, &mut ()));
///     }
/// });
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scene<F, T> {
    slab: Slab,
    particles: usize,
    field: F,
    temperature: T,
    open_end: Wall,
}

/// One of the two hard walls of a slab.
///
/// ```
/// use gradient_mc::{Scene, Slab, Wall, field::UniformField, temperature::Isothermal};
/// let (slab, temperature) = (Slab::new(60.0, 6.0, 6.0)?, Isothermal::new(5.0)?);
/// let open_end = |acceleration: f64| -> Result<Wall, gradient_mc::Error> {
///     Ok(Scene::new(slab, 36, UniformField::new(acceleration)?, temperature)?.open_end())
/// };
/// assert_eq!((open_end(1.0)?, open_end(-1.0)?), (Wall::Lid, Wall::Base));
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Wall {
    /// At x = 0.
    Base,
    /// At the height of the slab.
    Lid,
}

impl Wall {
    /// Height of the centers of spheres in contact with this wall, in diameters.
    #[must_use]
    pub fn contact_height(self, slab: &Slab) -> f64 {
        match self {
            Self::Base => slab.lowest_center(),
            Self::Lid => slab.highest_center(),
        }
    }

    /// The other wall.
    pub(crate) fn opposite(self) -> Self {
        match self {
            Self::Base => Self::Lid,
            Self::Lid => Self::Base,
        }
    }

    /// The wall at which the potential of `field` is higher.
    fn lighter(field: &(impl Field + ?Sized), slab: &Slab) -> Self {
        let rises = field.potential(slab.highest_center()) >= field.potential(slab.lowest_center());
        if rises { Self::Lid } else { Self::Base }
    }
}

impl<F: Field, T: TemperatureProfile> Scene<F, T> {
    /// Makes a scene of `particles` spheres from its parts and checks it.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] if `particles` is 0; [`Error::SlabTooLarge`] above
    /// [`Slab::MAXIMUM_VOLUME`]; [`Error::TooManyParticles`] above close packing;
    /// [`Error::InvalidField`] or [`Error::InvalidTemperature`] if field or temperature are not
    /// finite, or the temperature not positive, at some height; [`Error::InconsistentField`] if the
    /// potential is not the integral of the acceleration; [`Error::InconsistentTemperature`] if
    /// [`TemperatureProfile::constant`] returns a temperature that differs from the profile.
    pub fn new(slab: Slab, particles: usize, field: F, temperature: T) -> Result<Self, Error> {
        if particles == 0 {
            let requirement = "a scene needs at least one sphere";
            return Err(Error::InvalidParameter { name: "number of spheres", value: 0.0, requirement });
        }
        let volume = slab.base_area() * slab.height();
        if volume > Slab::MAXIMUM_VOLUME {
            return Err(Error::SlabTooLarge { volume, limit: Slab::MAXIMUM_VOLUME });
        }
        if particles > slab.capacity() || u32::try_from(particles).is_err() {
            return Err(Error::TooManyParticles {
                particles,
                packing_fraction: slab.packing_fraction(particles),
                capacity: slab.capacity().min(u32::MAX as usize),
            });
        }
        field::probe(&field, &slab)?;
        temperature::probe(&temperature, &slab)?;
        let open_end = Wall::lighter(&field, &slab);
        Ok(Self { slab, particles, field, temperature, open_end })
    }

    /// Makes a scene with `column_density` = N/A spheres per area of the base, in inverse square
    /// diameters. N is rounded to a whole number; [`column_density`](Self::column_density) returns
    /// the rounded N/A.
    ///
    /// Columns with the same N/A have the same profiles on any base, because the weight per area
    /// fixes the pressure.
    ///
    /// ```
    /// use gradient_mc::{Scene, Slab, field::UniformField, temperature::Isothermal};
    /// let slab = Slab::new(400.0, 25.0, 25.0)?;
    /// let scene = Scene::with_column_density(slab, 40.0, UniformField::default(), Isothermal::new(15.0)?)?;
    /// assert_eq!(scene.particles(), 25_000);
    /// # Ok::<(), gradient_mc::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] if the column density is not positive and finite, or so small
    /// that N rounds to 0; those of [`new`](Self::new).
    pub fn with_column_density(
        slab: Slab,
        column_density: f64,
        field: F,
        temperature: T,
    ) -> Result<Self, Error> {
        let particles = Error::require_positive("column density", column_density)? * slab.base_area();
        // Positive. A number that does not fit saturates, and `new` refuses it as too large.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let particles = particles.round() as usize;
        Self::new(slab, particles, field, temperature)
    }
}

/// A borrowed scene of any field and temperature, for code that does not depend on their types.
pub type AnyScene<'a> = Scene<&'a dyn Field, &'a dyn TemperatureProfile>;

impl<F: Field, T: TemperatureProfile> Scene<F, T> {
    /// The same scene, with field and temperature as trait objects behind references. Nothing is
    /// checked again.
    pub fn as_any(&self) -> AnyScene<'_> {
        let Self { slab, particles, field, temperature, open_end } = self;
        Scene { slab: *slab, particles: *particles, field, temperature, open_end: *open_end }
    }
}

#[cfg(test)]
impl<F: Field, T> Scene<F, T> {
    /// A scene without any check, for tests.
    pub(crate) fn unchecked(slab: Slab, particles: usize, field: F, temperature: T) -> Self {
        let open_end = Wall::lighter(&field, &slab);
        Self { slab, particles, field, temperature, open_end }
    }
}

impl<F, T> Scene<F, T> {
    /// The slab.
    pub fn slab(&self) -> &Slab {
        &self.slab
    }

    /// The wall at the dilute end of the column, where the potential is higher. It is the lid if
    /// the field pulls down, and also if there is no field. Pressure profiles are summed from this
    /// wall: P is small there, and the weight of the spheres between this wall and a height gives P
    /// at that height.
    pub fn open_end(&self) -> Wall {
        self.open_end
    }

    /// Number of spheres N.
    pub fn particles(&self) -> usize {
        self.particles
    }

    /// The external field.
    pub fn field(&self) -> &F {
        &self.field
    }

    /// The temperature profile.
    pub fn temperature(&self) -> &T {
        &self.temperature
    }

    /// Spheres per area of the base, N/A, in inverse square diameters.
    pub fn column_density(&self) -> f64 {
        self.particles as f64 / self.slab.base_area()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::UniformField;
    use crate::temperature::Isothermal;

    #[test]
    fn a_column_density_becomes_a_whole_number_of_spheres() {
        let slab = Slab::new(100.0, 5.0, 4.0).unwrap();
        let scene = |column_density: f64| {
            let temperature = Isothermal::new(5.0).unwrap();
            Scene::with_column_density(slab, column_density, UniformField::default(), temperature)
        };
        for (column_density, particles) in [(10.0, 200), (10.024, 200), (10.026, 201), (0.03, 1)] {
            assert_eq!(scene(column_density).unwrap().particles(), particles);
        }
        for senseless in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-9] {
            assert!(matches!(scene(senseless), Err(Error::InvalidParameter { .. })), "{senseless}");
        }
        for too_many in [1e4, 1e300] {
            assert!(matches!(scene(too_many), Err(Error::TooManyParticles { .. })), "{too_many}");
        }
    }
}
