//! What is simulated: a slab, a number of spheres, a field and a temperature profile.

use crate::{Error, Field, Slab, TemperatureProfile, field, temperature};

/// Hard spheres (diameter 1, mass 1) in a slab, under a field and a temperature that depend on
/// height.
///
/// A scene is checked once, here, so that nothing downstream has to: field and temperature are
/// probed at thousands of heights.
///
/// ```
/// use gradient_mc::{Scene, Slab, field::UniformField, temperature::Isothermal};
/// let slab = Slab::new(400.0, 25.0, 25.0)?;
/// let scene = Scene::new(slab, 25_000, UniformField::default(), Isothermal::new(15.0)?)?;
/// assert_eq!(scene.column_density(), 40.0);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
///
/// Field and temperature may be chosen at run time, and scenes of different kinds kept together:
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Wall {
    /// At x = 0.
    Base,
    /// At the height of the slab.
    Lid,
}

impl Wall {
    /// Height of the centers of spheres in contact with it, in diameters.
    #[must_use]
    pub fn contact_height(self, slab: &Slab) -> f64 {
        match self {
            Self::Base => slab.lowest_center(),
            Self::Lid => slab.highest_center(),
        }
    }

    /// The other wall.
    #[must_use]
    pub fn opposite(self) -> Self {
        match self {
            Self::Base => Self::Lid,
            Self::Lid => Self::Base,
        }
    }

    /// The wall from which `field` pulls spheres away, on the whole.
    fn lighter(field: &(impl Field + ?Sized), slab: &Slab) -> Self {
        let rises = field.potential(slab.highest_center()) >= field.potential(slab.lowest_center());
        if rises { Self::Lid } else { Self::Base }
    }
}

impl<F: Field, T: TemperatureProfile> Scene<F, T> {
    /// Puts the parts together.
    ///
    /// # Errors
    /// [`Error::InvalidParameter`] without spheres, [`Error::SlabTooLarge`] above
    /// [`Slab::MAXIMUM_VOLUME`], [`Error::TooManyParticles`] above close packing,
    /// [`Error::InvalidField`], [`Error::InconsistentField`] or [`Error::InvalidTemperature`] with
    /// the height at which a probe failed.
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

    /// Puts as many spheres in the slab as make `column_density` spheres per area of the base, N/A,
    /// rounded to a whole number; [`column_density`](Self::column_density) tells what it has
    /// become.
    ///
    /// Columns of one N/A are the same but for their base: the weight of the column fixes the
    /// pressure.
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
    /// [`Error::InvalidParameter`] for a column density that is not positive and finite, or so
    /// small that no sphere is left; those of [`new`](Self::new).
    pub fn with_column_density(
        slab: Slab,
        column_density: f64,
        field: F,
        temperature: T,
    ) -> Result<Self, Error> {
        let particles = Error::require_positive("column density", column_density)? * slab.base_area();
        // Positive; a number that does not fit saturates, and is refused as too many.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let particles = particles.round() as usize;
        Self::new(slab, particles, field, temperature)
    }
}

/// A scene of any field and temperature, borrowed: what code that must not depend on their types is
/// given.
pub type AnyScene<'a> = Scene<&'a dyn Field, &'a dyn TemperatureProfile>;

impl<F: Field, T: TemperatureProfile> Scene<F, T> {
    /// The same scene, with field and temperature behind references; it costs nothing and probes
    /// nothing.
    pub fn as_any(&self) -> AnyScene<'_> {
        let Self { slab, particles, field, temperature, open_end } = self;
        Scene { slab: *slab, particles: *particles, field, temperature, open_end: *open_end }
    }
}

#[cfg(test)]
impl<F: Field, T> Scene<F, T> {
    /// A scene that was not checked: tests put spheres where they like.
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

    /// The wall where the column ends, if it is open: that at which the potential is higher, from
    /// which the field pulls spheres away. It is the lid under a field that pulls down, and in
    /// a box without weight. Pressures are summed from it: P there is small, and at any other
    /// height it is known to rounding from the weights between.
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
