//! One scene of a table: its parameters, and the simulation made from them.

use gradient_mc::field::{ExponentialField, LinearField, UniformField};
use gradient_mc::observers::{CenterOfMass, EquationOfStateFit};
use gradient_mc::temperature::{ExponentialTemperature, Isothermal, LinearTemperature};
use gradient_mc::{Error, Field, Replica, Replicas, Scene, Slab, TemperatureProfile};

/// A scene with all parameters of its runs.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// Name in the table; in a grid, with the number of the scene.
    pub name: String,
    /// Height of the slab, in diameters.
    pub height: f64,
    /// Widths of the slab, in diameters.
    pub base: [f64; 2],
    /// Number of spheres.
    pub spheres: usize,
    /// The external field.
    pub field: FieldChoice,
    /// The temperature profile.
    pub temperature: TemperatureChoice,
    /// Seed from which those of the replicas are computed.
    pub seed: u64,
    /// Number of the scene in its grid, from 0.
    pub parameter: usize,
    /// Number of independent replicas.
    pub replicas: usize,
    /// Sweeps of equilibration of every replica.
    pub equilibration: u64,
    /// Largest number of sweeps of production of every replica.
    pub sweeps: u64,
    /// Standard error of the mean height of the center of mass, of all replicas together, at which
    /// they end early, in diameters.
    pub target_error: Option<f64>,
}

/// A field, chosen by name, with its parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FieldChoice {
    /// Uniform acceleration, in g.
    Uniform(f64),
    /// α of the field exp(αx), in inverse diameters.
    Exponential(f64),
    /// Linear field a₀ + s x.
    Linear {
        /// Value at x = 0.
        base: f64,
        /// Rate or slope, per diameter.
        slope: f64,
    },
}

/// A temperature profile, chosen by name, with its parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TemperatureChoice {
    /// Uniform temperature, in m g d.
    Isothermal(f64),
    /// Exponential profile T₀ exp(−βx).
    Exponential {
        /// Value at x = 0.
        base: f64,
        /// Rate or slope, per diameter.
        decay_rate: f64,
    },
    /// Linear profile T₀ + s x.
    Linear {
        /// Value at x = 0.
        base: f64,
        /// Rate or slope, per diameter.
        slope: f64,
    },
}

/// Name of the choice, and its parameters by column name.
pub(crate) type Named = (&'static str, Vec<(&'static str, f64)>);

impl FieldChoice {
    fn field(self) -> Result<Box<dyn Field>, Error> {
        Ok(match self {
            Self::Uniform(acceleration) => Box::new(UniformField::new(acceleration)?),
            Self::Exponential(rate) => Box::new(ExponentialField::new(rate)?),
            Self::Linear { base, slope } => Box::new(LinearField::new(base, slope)?),
        })
    }

    /// Name and parameters, for tables.
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

    /// Name and parameters, for tables.
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

/// The observers of every replica.
pub type Observers = (CenterOfMass, EquationOfStateFit);

impl Case {
    /// Smallest number of sweeps before a target can end a replica.
    const FEWEST: usize = 1000;

    /// The scene.
    ///
    /// # Errors
    /// Those of [`Slab::new`], of field and temperature, and of [`Scene::new`].
    pub fn scene(&self) -> Result<ChosenScene, Error> {
        let slab = Slab::new(self.height, self.base[0], self.base[1])?;
        Scene::new(slab, self.spheres, self.field.field()?, self.temperature.temperature()?)
    }

    /// New observers for the scene.
    ///
    /// # Errors
    /// [`Error::InvalidBins`] if the slab is too high for a fit.
    pub fn observers(&self, scene: &ChosenScene) -> Result<Observers, Error> {
        Ok((CenterOfMass::new(), EquationOfStateFit::new(scene)?))
    }

    /// Number and seed of a replica, as in [`Replicas`].
    #[must_use]
    pub fn replica(&self, index: usize) -> Replica {
        let replicas = Replicas::new(self.replicas).seed(self.seed);
        replicas.replica(self.parameter * self.replicas + index)
    }

    /// Whether a replica has reached the target: its standard error is √(number of replicas) times
    /// that of all together.
    #[must_use]
    pub fn has_reached(&self, (center_of_mass, _): &Observers) -> bool {
        let Some(target) = self.target_error.filter(|_| center_of_mass.heights().len() >= Self::FEWEST)
        else {
            return false;
        };
        let target = target * (self.replicas as f64).sqrt();
        center_of_mass.estimate().is_ok_and(|height| height.standard_error <= target)
    }

    /// All parameters of a replica, as text.
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

    /// Spheres times sweeps of a replica, approximately proportional to its time.
    #[must_use]
    pub fn work(&self) -> u64 {
        (self.spheres as u64).saturating_mul(self.equilibration.saturating_add(self.sweeps))
    }
}
