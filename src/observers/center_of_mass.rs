//! Height of the center of mass as a function of time.

use super::one_run::OneRun;
use crate::statistics::{self, Autocorrelation, Equilibration, Estimate, scattered};
use crate::warning::Disagreement;
use crate::{Error, Frame, Merge, Observer, ObserverError, Warning};

/// The series of the height `h_c` of the center of mass in all frames, in diameters.
///
/// The paper uses a constant mean of `h_c` as the criterion of a steady state
/// (doi:10.1103/PhysRevE.83.061306, figs. 2 and 7). In an isothermal column in a uniform field the
/// variance is exactly Var(h) = (T²/N) dh/dT.
///
/// It stores sixteen bytes per frame. Wrap it in [`Every`](crate::Every) to sample fewer frames.
///
/// ```
/// use gradient_mc::observers::CenterOfMass;
/// use gradient_mc::{Every, Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 36, UniformField::default(), Isothermal::new(5.0)?)?;
/// let mut simulation = Simulation::builder(scene).seed(1).build()?;
/// let mut center_of_mass = Every::new(5, CenterOfMass::new());
/// simulation.equilibrate(100, &mut ())?;
/// simulation.run(500, &mut center_of_mass)?;
/// let center_of_mass = center_of_mass.observer;
/// assert_eq!(center_of_mass.heights().len(), 100);
/// println!("{}, drift {}", center_of_mass.estimate()?, center_of_mass.drift()?);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct CenterOfMass {
    run: OneRun,
    series: Series,
    replicas: Vec<Series>,
}

/// Series of one run.
#[derive(Debug, Clone, Default)]
#[cfg_attr(feature = "checkpoint", derive(serde::Serialize, serde::Deserialize))]
struct Series {
    sweeps: Vec<u64>,
    heights: Vec<f64>,
}

impl CenterOfMass {
    /// An empty series.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Sweep numbers of the frames, in the order of observation; merged replicas are not included.
    #[must_use]
    pub fn sweeps(&self) -> &[u64] {
        &self.series.sweeps
    }

    /// Heights of the center of mass in these frames, in diameters.
    #[must_use]
    pub fn heights(&self) -> &[f64] {
        &self.series.heights
    }

    /// The series from `sweep` on, of every replica: use it to drop the relaxation at the start.
    #[must_use]
    pub fn since(&self, sweep: u64) -> Self {
        let cut = |series: &Series| {
            let start = series.sweeps.partition_point(|&observed| observed < sweep);
            Series { sweeps: series.sweeps[start..].to_vec(), heights: series.heights[start..].to_vec() }
        };
        let replicas = self.replicas.iter().map(cut).collect();
        Self { run: self.run.clone(), series: cut(&self.series), replicas }
    }

    /// The nonempty runs, as slices of heights.
    fn runs(&self) -> impl Iterator<Item = &[f64]> {
        [&self.series]
            .into_iter()
            .chain(&self.replicas)
            .map(|series| &series.heights[..])
            .filter(|heights| !heights.is_empty())
    }

    /// An estimate from every run, averaged with the lengths of the runs as weights. The error is
    /// that of the scatter of the runs if this is larger than their errors explain.
    fn pooled(&self, estimate: impl Fn(&[f64]) -> Result<Estimate, Error>) -> Result<Estimate, Error> {
        let estimate =
            |run: &[f64]| estimate(run).map_err(|error| said("frames for the center of mass", error));
        let observations: usize = self.runs().map(<[f64]>::len).sum();
        if observations == 0 {
            // Returns the error of the estimate for an empty run.
            return estimate(&[]);
        }
        let (mut mean, mut squared) = (0.0, 0.0);
        let mut replicas = Vec::with_capacity(self.replicas.len() + 1);
        for run in self.runs() {
            let weight = run.len() as f64 / observations as f64;
            let of_run = estimate(run)?;
            let squared_error = of_run.standard_error * of_run.standard_error;
            mean += weight * of_run.mean;
            squared += weight * weight * squared_error;
            replicas.push((of_run.mean, weight, squared_error));
        }
        Ok(Estimate::new(mean, scattered(&replicas, squared).standard_error))
    }

    /// Warnings about the series: [`Warning::ReplicasDisagree`] if the means of merged replicas
    /// differ by more than their errors. For a single run use
    /// [`Simulation::warnings`](crate::Simulation::warnings).
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        let replicas: Vec<(f64, f64, f64)> = self
            .runs()
            .filter_map(|run| {
                let of_run = statistics::blocking(run).ok()?;
                Some((of_run.mean, run.len() as f64, of_run.standard_error * of_run.standard_error))
            })
            .collect();
        if !scattered(&replicas, 0.0).contradict {
            return Vec::new();
        }
        let means = replicas.iter().map(|(mean, ..)| *mean);
        let (lowest, highest) = means
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), mean| (low.min(mean), high.max(mean)));
        vec![Warning::ReplicasDisagree { disagreement: Disagreement::CenterOfMass { lowest, highest } }]
    }

    /// Mean height in diameters, with its standard error by [`blocking`](statistics::blocking) each
    /// replica, or from the scatter of the replicas if that is significantly larger.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] if a replica has fewer than 16 frames.
    pub fn estimate(&self) -> Result<Estimate, Error> {
        self.pooled(statistics::blocking)
    }

    /// Mean height in the second half of the series minus that in the first half, in diameters,
    /// averaged over replicas; see [`drift`](statistics::drift).
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] if a replica has fewer than 32 frames.
    pub fn drift(&self) -> Result<Estimate, Error> {
        self.pooled(statistics::drift)
    }

    /// Variance of the height in square diameters, about the mean of each replica, averaged over
    /// replicas; see [`variance`](statistics::variance()).
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] if a replica has fewer than 16 frames.
    pub fn variance(&self) -> Result<Estimate, Error> {
        self.pooled(statistics::variance)
    }

    /// Autocorrelation time of the series, in units of the interval between frames; see
    /// [`autocorrelation`](statistics::autocorrelation()). Merged replicas are not included.
    ///
    /// # Errors
    /// Those of [`autocorrelation`](statistics::autocorrelation()).
    pub fn autocorrelation(&self) -> Result<Autocorrelation, Error> {
        let what = "frames for the autocorrelation time of the center of mass (fifty times this time)";
        statistics::autocorrelation(&self.series.heights).map_err(|error| said(what, error))
    }

    /// Detects where the steady state begins in this series; see
    /// [`equilibration`](statistics::equilibration()). Merged replicas are not included.
    ///
    /// # Errors
    /// Those of [`equilibration`](statistics::equilibration()).
    pub fn equilibration(&self) -> Result<Equilibration, Error> {
        let what = "frames for the steady state of the center of mass";
        statistics::equilibration(&self.series.heights).map_err(|error| said(what, error))
    }

    /// The series after relaxation: each replica from the beginning of its own steady state on.
    ///
    /// ```
    /// use gradient_mc::observers::CenterOfMass;
    /// use gradient_mc::{Error, Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
    /// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 36, UniformField::default(), Isothermal::new(5.0)?)?;
    /// let mut center_of_mass = CenterOfMass::new();
    /// Simulation::builder(scene).build()?.run(2000, &mut center_of_mass)?;
    /// match center_of_mass.equilibrated() {
    ///     Ok(steady) => println!("{} from sweep {} on", steady.estimate()?, steady.sweeps()[0]),
    ///     Err(Error::NotEquilibrated { .. }) => println!("run longer"),
    ///     Err(error) => return Err(error),
    /// }
    /// # Ok::<(), gradient_mc::Error>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`equilibration`](statistics::equilibration()), for any replica.
    pub fn equilibrated(&self) -> Result<Self, Error> {
        let cut = |series: &Series| {
            if series.heights.is_empty() {
                return Ok(Series::default());
            }
            let start = statistics::equilibration(&series.heights)?.start;
            Ok(Series { sweeps: series.sweeps[start..].to_vec(), heights: series.heights[start..].to_vec() })
        };
        let replicas = self.replicas.iter().map(cut).collect::<Result<_, Error>>()?;
        Ok(Self { run: self.run.clone(), series: cut(&self.series)?, replicas })
    }
}

/// An error with the name of the estimate.
fn said(what: &'static str, error: Error) -> Error {
    match error {
        Error::TooFewObservations { available, needed, .. } => {
            Error::TooFewObservations { what, available, needed }
        }
        error => error,
    }
}

/// Series of any length can be merged.
impl Merge for CenterOfMass {
    fn merge(&mut self, other: &Self) -> Result<(), Error> {
        self.run.require_same_scene(&other.run)?;
        self.run.join(&other.run);
        self.replicas.push(other.series.clone());
        self.replicas.extend_from_slice(&other.replicas);
        Ok(())
    }
}

impl Observer for CenterOfMass {
    fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
        self.run.admit(frame)?;
        let height = frame.heights().sum::<f64>() / frame.particles() as f64;
        self.series.sweeps.push(frame.sweep());
        self.series.heights.push(height);
        Ok(())
    }
}

persist!(CenterOfMass { part run, value series, value replicas }, |observed| {
    let mut all = [&observed.series].into_iter().chain(&observed.replicas);
    all.all(|series| series.sweeps.len() == series.heights.len())
});

#[cfg(test)]
mod tests {
    use super::super::test_frame::{Scene, ideal_heights};
    use super::*;

    /// Ideal particles at T = 5: mean 0.5 + T, variance T²/N, and the response dh/dT = 1.
    fn observed(frames: u64, seed: u64) -> CenterOfMass {
        let mut scene = Scene::new(500.0, &[]);
        let mut center = CenterOfMass::new();
        for frame in 0..frames {
            scene.sweep.set(10 * frame);
            scene.place(&ideal_heights(25, seed + frame));
            center.observe(&scene.frame()).unwrap();
        }
        center
    }

    #[test]
    fn an_ideal_column_has_its_mean_variance_and_no_drift() {
        let mut center = observed(3000, 0);
        center.merge(&observed(1000, 1_000_000)).unwrap();
        assert_eq!((center.sweeps().len(), center.heights().len(), center.sweeps()[7]), (3000, 3000, 70));
        let estimate = center.estimate().unwrap();
        // Four standard errors T/√(25 · 4000). Blocking gives them within about 3 %, up to 2 % too
        // large.
        let error = 1.0 / 4000_f64.sqrt();
        assert!((estimate.mean - 5.5).abs() < 4.0 * error, "{estimate}");
        assert!((estimate.standard_error / error - 1.0).abs() < 0.15, "{}", estimate.standard_error / error);
        let variance = center.variance().unwrap();
        // Kurtosis of 25 exponential heights: 3 + 6/25, so the variance of squares is 2.24.
        assert!((variance.mean - 1.0).abs() < 4.0 * (2.24_f64 / 4000.0).sqrt(), "{variance}");
        assert!((variance.standard_error / (2.24_f64 / 4000.0).sqrt() - 1.0).abs() < 0.25, "{variance}");
        assert!(center.drift().unwrap().deviation_from(0.0).abs() < 4.0);
        assert!((center.autocorrelation().unwrap().time.mean - 0.5).abs() < 0.1);
    }

    #[test]
    fn relaxation_is_cut_off_replica_by_replica() {
        let relaxing = |seed: u64, frames: u32| {
            let mut center = observed(2000, seed);
            for frame in 0..frames {
                center.series.heights[frame as usize] +=
                    30.0 * (-5.0 * f64::from(frame) / f64::from(frames)).exp();
            }
            center
        };
        let mut center = relaxing(1, 300);
        center.merge(&relaxing(1_000_000, 600)).unwrap();
        assert!(center.estimate().unwrap().mean > 6.0);
        let steady = center.equilibrated().unwrap();
        assert_eq!(steady.sweeps().len(), 2000 - center.equilibration().unwrap().start);
        assert!(steady.heights().len() > steady.replicas[0].heights.len() + 100);
        let estimate = steady.estimate().unwrap();
        assert!(
            (estimate.mean - 5.5).abs() < 4.0 / 3000_f64.sqrt() && estimate.standard_error < 0.025,
            "{estimate}"
        );
        // A replica that still relaxes has no steady state.
        center.merge(&relaxing(2_000_000, 2000)).unwrap();
        assert!(matches!(center.equilibrated(), Err(Error::NotEquilibrated { observations: 2000, .. })));
        assert_eq!(CenterOfMass::new().equilibrated().unwrap().heights().len(), 0);
    }

    #[test]
    fn the_start_can_be_cut_off() {
        let center = observed(100, 7);
        let late = center.since(501);
        assert_eq!((late.sweeps()[0], late.heights().len()), (510, 49));
        assert_eq!(late.heights(), &center.heights()[51..]);
        assert!(matches!(
            center.since(10_000).estimate(),
            Err(Error::TooFewObservations { available: 0, needed: 16, .. })
        ));
        let mut merged = center.since(10_000);
        merged.merge(&center).unwrap();
        assert_eq!(merged.estimate().unwrap(), center.estimate().unwrap());
    }

    #[test]
    fn replicas_that_contradict_each_other_are_named_and_have_their_scatter() {
        let mut center = observed(1000, 0);
        center.merge(&observed(1000, 1_000_000)).unwrap();
        assert_eq!(center.warnings(), []);
        let mut far = observed(1000, 2_000_000);
        far.series.heights.iter_mut().for_each(|height| *height += 183.6);
        let mut both = observed(1000, 0);
        both.merge(&far).unwrap();
        let error = both.estimate().unwrap().standard_error;
        assert!((error - 91.8).abs() < 0.3, "{error}");
        assert!(matches!(
            both.warnings()[..],
            [Warning::ReplicasDisagree { disagreement: Disagreement::CenterOfMass { lowest, highest } }]
                if (lowest - 5.5).abs() < 0.2 && (highest - 189.1).abs() < 0.2
        ));
    }
}
