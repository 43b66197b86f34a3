//! One scene of a table: its parts, and what a run of it is made of.

use gradient_mc::field::{ExponentialField, LinearField, UniformField};
use gradient_mc::observers::{CenterOfMass, EquationOfStateFit};
use gradient_mc::temperature::{ExponentialTemperature, Isothermal, LinearTemperature};
use gradient_mc::{Error, Field, Replica, Replicas, Scene, Slab, TemperatureProfile};

/// A scene with everything that its results depend on.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// As in the table; of a grid, with its number in it.
    pub name: String,
    /// Of the slab, in diameters.
    pub height: f64,
    /// Widths of the slab, in diameters.
    pub base: [f64; 2],
    /// Number of spheres.
    pub spheres: usize,
    /// What pulls at them.
    pub field: FieldChoice,
    /// How hot they are.
    pub temperature: TemperatureChoice,
    /// That the seeds of the replicas are made of.
    pub seed: u64,
    /// Its number in a grid.
    pub parameter: usize,
    /// Number of independent runs.
    pub replicas: usize,
    /// Sweeps before the measurement, of every replica.
    pub equilibration: u64,
    /// Sweeps of measurement, of every replica, at most.
    pub sweeps: u64,
    /// Standard error of the height of the center of mass, of all replicas together, at which they
    /// end.
    pub target_error: Option<f64>,
}

/// Fields by name, each with its numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FieldChoice {
    /// The acceleration.
    Uniform(f64),
    /// α of exp(αx).
    Exponential(f64),
    /// a₀ + s x.
    Linear {
        /// At the base.
        base: f64,
        /// Per diameter.
        slope: f64,
    },
}

/// Temperature profiles by name, each with its numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TemperatureChoice {
    /// The temperature.
    Isothermal(f64),
    /// T₀ exp(−βx).
    Exponential {
        /// At the base.
        base: f64,
        /// Per diameter.
        decay_rate: f64,
    },
    /// T₀ + s x.
    Linear {
        /// At the base.
        base: f64,
        /// Per diameter.
        slope: f64,
    },
}

/// Name of the choice, and its numbers by column.
pub(crate) type Named = (&'static str, Vec<(&'static str, f64)>);

impl FieldChoice {
    fn field(self) -> Result<Box<dyn Field>, Error> {
        Ok(match self {
            Self::Uniform(acceleration) => Box::new(UniformField::new(acceleration)?),
            Self::Exponential(rate) => Box::new(ExponentialField::new(rate)?),
            Self::Linear { base, slope } => Box::new(LinearField::new(base, slope)?),
        })
    }

    /// For tables.
    pub(crate) fn named(self) -> Named {
        match self {
            Self::Uniform(acceleration) => ("uniform", vec![("field_base", acceleration)]),
            Self::Exponential(rate) => ("exponential", vec![("field_rate", rate)]),
            Self::Linear { base, slope } => ("linear", vec![("field_base", base), ("field_slope", slope)]),
        }
    }
}

impl TemperatureChoice {
    fn temperature(self) -> Result<Box<dyn TemperatureProfile>, Error> {
        Ok(match self {
            Self::Isothermal(temperature) => Box::new(Isothermal::new(temperature)?),
            Self::Exponential { base, decay_rate } => {
                Box::new(ExponentialTemperature::new(base, decay_rate)?)
            }
            Self::Linear { base, slope } => Box::new(LinearTemperature::new(base, slope)?),
        })
    }

    /// For tables.
    pub(crate) fn named(self) -> Named {
        match self {
            Self::Isothermal(temperature) => ("isothermal", vec![("temperature_base", temperature)]),
            Self::Exponential { base, decay_rate } => {
                ("exponential", vec![("temperature_base", base), ("temperature_decay_rate", decay_rate)])
            }
            Self::Linear { base, slope } => {
                ("linear", vec![("temperature_base", base), ("temperature_slope", slope)])
            }
        }
    }
}

/// A scene that was chosen at run time.
pub type ChosenScene = Scene<Box<dyn Field>, Box<dyn TemperatureProfile>>;

/// What looks at every replica.
pub type Observers = (CenterOfMass, EquationOfStateFit);

impl Case {
    /// A target is not believed before so many sweeps.
    const FEWEST: usize = 1000;

    /// What is simulated.
    ///
    /// # Errors
    /// Those of slab, field, temperature and scene.
    pub fn scene(&self) -> Result<ChosenScene, Error> {
        let slab = Slab::new(self.height, self.base[0], self.base[1])?;
        Scene::new(slab, self.spheres, self.field.field()?, self.temperature.temperature()?)
    }

    /// What looks at it, and has seen nothing yet.
    ///
    /// # Errors
    /// [`Error::InvalidBins`] for a slab that is too high for a fit.
    pub fn observers(&self, scene: &ChosenScene) -> Result<Observers, Error> {
        Ok((CenterOfMass::new(), EquationOfStateFit::new(scene)?))
    }

    /// One of its replicas, as [`Replicas`] has it.
    #[must_use]
    pub fn replica(&self, index: usize) -> Replica {
        let replicas = Replicas::new(self.replicas).seed(self.seed);
        replicas.replica(self.parameter * self.replicas + index)
    }

    /// Whether a replica has measured enough. All replicas together know the height √(number) times
    /// as well.
    #[must_use]
    pub fn has_reached(&self, (center_of_mass, _): &Observers) -> bool {
        let Some(target) = self.target_error.filter(|_| center_of_mass.heights().len() >= Self::FEWEST)
        else {
            return false;
        };
        let target = target * (self.replicas as f64).sqrt();
        center_of_mass.estimate().is_ok_and(|height| height.standard_error <= target)
    }

    /// All that the outcome of a replica depends on.
    #[must_use]
    pub fn identity(&self, index: usize) -> String {
        let Self { height, base, spheres, field, temperature, equilibration, sweeps, target_error, .. } =
            self;
        let target = target_error.map(|target| target * (self.replicas as f64).sqrt());
        let seed = self.replica(index).seed();
        format!(
            "slab {height:?} x {base:?}, {spheres} spheres, {field:?}, {temperature:?}, seed {seed}, {equilibration} + {sweeps} \
             sweeps, target {target:?}"
        )
    }

    /// Spheres times sweeps of a replica: about proportional to the time that it takes.
    #[must_use]
    pub fn work(&self) -> u64 {
        (self.spheres as u64).saturating_mul(self.equilibration.saturating_add(self.sweeps))
    }
}
