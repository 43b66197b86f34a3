//! Independent replicas of a run on all cores.

use crate::statistics::{Estimate, mean_of_replicas};
use crate::{Error, Merge, ObserverError};
use std::num::NonZero;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;

/// Runs the same work for several independent replicas, each with its own seed, on all cores.
///
/// The results are in the order of the replicas, and have the same bits for any number of threads.
/// Independent replicas use the cores better than threads within one run. Their scatter gives a
/// standard error without any analysis of correlations ([`Outcome::scatter`]), and it shows runs
/// that are not equilibrated.
///
/// ```
/// use gradient_mc::observers::CenterOfMass;
/// use gradient_mc::{Replicas, Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
/// let scene = Scene::new(Slab::new(60.0, 6.0, 6.0)?, 36, UniformField::default(), Isothermal::new(5.0)?)?;
/// let outcome = Replicas::new(4).seed(1).run(|replica| {
///     let mut simulation = Simulation::builder(scene).seed(replica.seed()).build()?;
///     simulation.equilibrate(200, &mut ())?;
///     let mut center_of_mass = CenterOfMass::new();
///     simulation.run(400, &mut center_of_mass)?;
///     Ok(center_of_mass)
/// })?;
/// println!("error from blocks: {}", outcome.merged()?.estimate()?);
/// println!("error from replicas: {}", outcome.scatter(|observer| observer.estimate())?);
/// # Ok::<(), gradient_mc::Error>(())
/// ```
///
/// Work with several observers returns a tuple. The tuple may also hold values that cannot be
/// merged, such as warnings; then merge the other parts with [`Merge::pooled`].
///
/// # Seeds
/// Replica r of parameter p has the seed m(m(m(seed + g) + (p + 1)g) + (r + 1)g), with the
/// bijection m and the odd g of `SplitMix64` (Steele, Lea and Flood, doi:10.1145/2660193.2660195).
/// All seeds of one set of replicas are different, and sets with neighboring seeds share none. With
/// `seed + r`, in contrast, the second replica of seed 1 would be the first of seed 2.
#[derive(Debug, Clone, Copy)]
pub struct Replicas {
    count: usize,
    seed: u64,
    threads: usize,
}

/// Number and seed of a replica.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Replica {
    index: usize,
    seed: u64,
}

impl Replica {
    /// Number of the replica among those of the same parameter, from 0.
    #[must_use]
    pub fn index(&self) -> usize {
        self.index
    }

    /// Seed of the replica, for [`SimulationBuilder::seed`](crate::SimulationBuilder::seed).
    #[must_use]
    pub fn seed(&self) -> u64 {
        self.seed
    }
}

impl Replicas {
    /// Makes a set of `count` replicas with seed 0, on all cores.
    #[must_use]
    pub fn new(count: usize) -> Self {
        Self { count, seed: 0, threads: 0 }
    }

    /// Sets the seed from which those of the replicas are computed.
    #[must_use]
    pub fn seed(self, seed: u64) -> Self {
        Self { seed, ..self }
    }

    /// Sets the number of threads. 0, the default, is one thread for each core.
    #[must_use]
    pub fn threads(self, threads: usize) -> Self {
        Self { threads, ..self }
    }

    /// Number of threads that will be used, if there are as many replicas.
    #[must_use]
    pub fn thread_count(&self) -> usize {
        if self.threads > 0 { self.threads } else { thread::available_parallelism().map_or(1, NonZero::get) }
    }

    /// The replica with this `number` from 0, counted through all parameters as in
    /// [`run_each`](Self::run_each). A task of a job array runs one replica.
    ///
    /// ```
    /// use gradient_mc::Replicas;
    /// let replicas = Replicas::new(2).seed(1);
    /// let seeds = replicas.run(|replica| Ok(replica.seed()))?;
    /// assert_eq!(seeds.replicas(), [replicas.replica(0).seed(), replicas.replica(1).seed()]);
    /// # Ok::<(), gradient_mc::Error>(())
    /// ```
    #[must_use]
    pub fn replica(&self, number: usize) -> Replica {
        let count = self.count.max(1);
        let index = number % count;
        Replica { index, seed: seed_of(self.seed, number / count, index) }
    }

    /// Calls `work` for every replica.
    ///
    /// # Errors
    /// [`Error::Replica`] if a replica fails: the first in the order of the replicas, with its
    /// error. No other replica is begun after a failure.
    ///
    /// # Panics
    /// If `work` panics, after the running replicas on other threads have ended.
    pub fn run<R: Send>(
        &self,
        work: impl Fn(Replica) -> Result<R, ObserverError> + Sync,
    ) -> Result<Outcome<R>, Error> {
        let outcomes = self.run_each(&[()], |(), replica| work(replica))?;
        Ok(outcomes.into_iter().next().unwrap_or(Outcome { replicas: Vec::new() }))
    }

    /// Calls `work` for every replica of each of several parameters, such as temperatures. Returns
    /// one outcome for each parameter, in their order.
    ///
    /// ```
    /// use gradient_mc::observers::CenterOfMass;
    /// use gradient_mc::{Replicas, Scene, Simulation, Slab, field::UniformField, temperature::Isothermal};
    /// let temperatures = [4.0, 6.0, 8.0];
    /// let outcomes = Replicas::new(2).seed(1).run_each(&temperatures, |&temperature, replica| {
    ///     let slab = Slab::new(100.0, 6.0, 6.0)?;
    ///     let scene = Scene::new(slab, 36, UniformField::default(), Isothermal::new(temperature)?)?;
    ///     let mut center_of_mass = CenterOfMass::new();
    ///     Simulation::builder(scene).seed(replica.seed()).build()?.run(200, &mut center_of_mass)?;
    ///     Ok(center_of_mass)
    /// })?;
    /// for (temperature, outcome) in temperatures.iter().zip(&outcomes) {
    ///     println!("{temperature}  {}", outcome.merged()?.estimate()?);
    /// }
    /// # Ok::<(), gradient_mc::Error>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`run`](Self::run); replicas are counted through all parameters.
    ///
    /// # Panics
    /// Those of [`run`](Self::run).
    pub fn run_each<P: Sync, R: Send>(
        &self,
        parameters: &[P],
        work: impl Fn(&P, Replica) -> Result<R, ObserverError> + Sync,
    ) -> Result<Vec<Outcome<R>>, Error> {
        let next = AtomicUsize::new(0);
        let stop = AtomicBool::new(false);
        let total = parameters.len() * self.count;
        let worker = || {
            let mut results = Vec::new();
            while !stop.load(Ordering::SeqCst) {
                let number = next.fetch_add(1, Ordering::SeqCst);
                if number >= total {
                    break;
                }
                let guard = StopOnPanic(&stop);
                let result = work(&parameters[number / self.count], self.replica(number));
                if result.is_err() {
                    stop.store(true, Ordering::SeqCst);
                }
                drop(guard);
                results.push((number, result));
            }
            results
        };
        let mut results = thread::scope(|scope| {
            let helpers = self.thread_count().min(total).saturating_sub(1);
            let helpers: Vec<_> = (0..helpers).map(|_| scope.spawn(worker)).collect();
            // The thread of the caller is one of the workers.
            let mut results = worker();
            for helper in helpers {
                results.extend(helper.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
            }
            results
        });
        results.sort_by_key(|(number, _)| *number);
        let mut outcomes: Vec<Outcome<R>> =
            parameters.iter().map(|_| Outcome { replicas: Vec::with_capacity(self.count) }).collect();
        // Replicas are begun in their order, so all replicas before the first failed one are
        // finished. The error therefore does not depend on the number of threads.
        for (number, result) in results {
            let seed = self.replica(number).seed;
            let result = result.map_err(|source| Error::Replica { replica: number, seed, source })?;
            outcomes[number / self.count].replicas.push(result);
        }
        Ok(outcomes)
    }
}

/// Stops other threads from beginning more replicas while this thread unwinds.
struct StopOnPanic<'a>(&'a AtomicBool);

impl Drop for StopOnPanic<'_> {
    fn drop(&mut self) {
        if thread::panicking() {
            self.0.store(true, Ordering::SeqCst);
        }
    }
}

/// The seed of a replica; see [`Replicas`].
fn seed_of(seed: u64, parameter: usize, index: usize) -> u64 {
    const GAMMA: u64 = 0x9e37_79b9_7f4a_7c15;
    let step = |number: usize| GAMMA.wrapping_mul((number as u64).wrapping_add(1));
    let mixed = mix(seed.wrapping_add(GAMMA));
    mix(mix(mixed.wrapping_add(step(parameter))).wrapping_add(step(index)))
}

/// The finalizer of `SplitMix64`.
fn mix(mut bits: u64) -> u64 {
    bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    bits ^ (bits >> 31)
}

/// The results of the replicas, in their order.
#[derive(Debug, Clone)]
pub struct Outcome<R> {
    replicas: Vec<R>,
}

impl<R> Outcome<R> {
    /// The result of each replica.
    #[must_use]
    pub fn replicas(&self) -> &[R] {
        &self.replicas
    }

    /// The result of each replica, by value.
    #[must_use]
    pub fn into_replicas(self) -> Vec<R> {
        self.replicas
    }

    /// All results merged into one. Its standard errors come from blocks of all replicas.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] if there are no replicas; those of [`Merge::merge`].
    pub fn merged(&self) -> Result<R, Error>
    where
        R: Merge + Clone,
    {
        R::pooled(&self.replicas)
    }

    /// The mean of an estimate over the replicas with equal weights, and its standard error from
    /// their scatter. The errors of the single estimates are not used. See [`mean_of_replicas`] for
    /// the accuracy of this error.
    ///
    /// # Errors
    /// [`Error::TooFewObservations`] for fewer than two replicas; those of `estimate`.
    pub fn scatter(&self, estimate: impl Fn(&R) -> Result<Estimate, Error>) -> Result<Estimate, Error> {
        let means: Result<Vec<f64>, Error> =
            self.replicas.iter().map(|replica| Ok(estimate(replica)?.mean)).collect();
        mean_of_replicas(&means?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::UniformField;
    use crate::observers::{Bins, CenterOfMass, DensityProfile};
    use crate::temperature::Isothermal;
    use crate::{Scene, Simulation, Slab};
    use std::collections::HashSet;
    use std::sync::Mutex;

    #[test]
    fn seeds_are_as_documented_and_all_different() {
        // Computed independently, in arithmetic of arbitrary precision.
        let golden = [
            (0, 0, 0, 0x2382_75bc_38fc_be91),
            (1, 0, 0, 0xb18a_02f4_6d8d_86c3),
            (1, 0, 1, 0xf8c5_b62c_83f7_07e8),
            (1, 1, 0, 0x9edb_e9bd_18ad_781d),
            (u64::MAX, 5, 7, 0x03c2_6cab_c8d7_17d9),
        ];
        for (seed, parameter, index, expected) in golden {
            assert_eq!(seed_of(seed, parameter, index), expected, "{seed} {parameter} {index}");
        }
        let mut seeds = HashSet::new();
        for seed in 0..64 {
            for (parameter, index) in
                (0..16).flat_map(|parameter| (0..64).map(move |index| (parameter, index)))
            {
                assert!(seeds.insert(seed_of(seed, parameter, index)));
            }
        }
    }

    type Observed = (CenterOfMass, DensityProfile);

    fn run(threads: usize) -> Outcome<Observed> {
        let slab = Slab::new(60.0, 6.0, 6.0).unwrap();
        let scene = Scene::new(slab, 36, UniformField::default(), Isothermal::new(5.0).unwrap()).unwrap();
        let work = |replica: Replica| -> Result<Observed, ObserverError> {
            let mut simulation = Simulation::builder(scene).seed(replica.seed()).build()?;
            simulation.equilibrate(100, &mut ())?;
            let mut observers = (CenterOfMass::new(), DensityProfile::new(&slab, Bins::count(6))?);
            // Unequal lengths, so that threads finish out of order.
            simulation.run(200 + 100 * (replica.index() as u64 % 3), &mut observers)?;
            Ok(observers)
        };
        Replicas::new(7).seed(5).threads(threads).run(work).unwrap()
    }

    #[test]
    fn bits_do_not_depend_on_the_number_of_threads() {
        let text = |outcome: &Outcome<Observed>| {
            let (center, density) = outcome.merged().unwrap();
            format!(
                "{:?} {:?} {:?}",
                outcome.replicas(),
                center.estimate().unwrap(),
                density.points().unwrap()
            )
        };
        let one = run(1);
        let scatter = one.scatter(|(center, _)| center.estimate()).unwrap();
        assert!(scatter.standard_error > 0.0);
        for threads in [2, 3, 16] {
            let other = run(threads);
            assert_eq!(text(&one), text(&other));
            assert_eq!(other.scatter(|(center, _)| center.estimate()).unwrap(), scatter);
        }
    }

    #[test]
    fn the_first_that_fails_is_named_with_its_error() {
        for threads in [1, 2, 8] {
            let begun = Mutex::new(HashSet::new());
            let failed = Replicas::new(100).threads(threads).run_each(&["a", "b"], |&name, replica| {
                begun.lock().unwrap().insert((name, replica.index()));
                if replica.index() % 5 == 3 {
                    Err(format!("no {name}{}", replica.index()).into())
                } else {
                    Ok(())
                }
            });
            let Err(Error::Replica { replica: 3, seed, source }) = failed else { panic!("{failed:?}") };
            assert_eq!((seed, source.to_string()), (seed_of(0, 0, 3), "no a3".to_owned()));
            assert!(begun.lock().unwrap().len() < 3 + 2 * threads, "{begun:?}");
        }
    }

    #[test]
    fn a_panic_reaches_the_caller_and_hangs_nobody() {
        for threads in [1, 3] {
            let begun = AtomicUsize::new(0);
            // So many that the run ends only if the other threads stop. How many they begin
            // meanwhile depends on the load of the machine.
            let caught = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
                Replicas::new(usize::MAX / 2).threads(threads).run(|replica| {
                    begun.fetch_add(1, Ordering::SeqCst);
                    assert!(replica.index() != 4, "the fifth");
                    thread::sleep(std::time::Duration::from_micros(100));
                    Ok(())
                })
            }));
            let panic = caught.unwrap_err();
            assert_eq!(panic.downcast_ref::<&str>(), Some(&"the fifth"));
            assert!(threads > 1 || begun.load(Ordering::SeqCst) == 5);
        }
    }

    #[test]
    fn no_replicas_are_too_few() {
        let none = Replicas::new(0).run(|_| Ok(CenterOfMass::new())).unwrap();
        assert!(matches!(none.merged(), Err(Error::TooFewObservations { available: 0, .. })));
        assert!(matches!(none.scatter(CenterOfMass::estimate), Err(Error::TooFewObservations { .. })));
    }
}
