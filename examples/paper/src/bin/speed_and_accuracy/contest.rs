//! The equation of state of a range of packing fractions: one run in a gradient against a homogeneous run for each.

use crate::gradient::{Gradient, Yield};
use gradient_mc::equation_of_state::{EquationOfState, ModifiedKolafa};
use gradient_mc::statistics::{Estimate, mean_of_replicas};
use paper::accuracy::root_mean_square;
use paper::clock::cpu_seconds;
use paper::homogeneous::{Homogeneous, Technique, finite_size};
use paper::{Failure, Session};

/// Packing fractions of the finest grid; coarser ones take every so many of them.
const LOWEST: f64 = 0.05;
const HIGHEST: f64 = 0.45;
const FINEST: usize = 17;
/// fcc cubes along an edge of the homogeneous box: 256 spheres.
const LATTICE: usize = 4;
const SHORTEST: u64 = 64;
/// Of every way.
pub(crate) const REPLICAS: u64 = 4;
/// Temperatures among which the gradient may choose.
const TEMPERATURES: [f64; 3] = [5.0, 10.0, 20.0];

/// A way to the equation of state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Way {
    Gradient(f64),
    Local,
    Chains,
}

impl Way {
    pub(crate) fn label(self) -> String {
        match self {
            Self::Gradient(temperature) => format!("gradient, T = {temperature}"),
            Self::Local => "homogeneous, local moves".to_owned(),
            Self::Chains => "homogeneous, event chains".to_owned(),
        }
    }

    pub(crate) fn is_gradient(self) -> bool {
        matches!(self, Self::Gradient(_))
    }
}

/// Packing fractions that are asked for: a part of the finest grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Task {
    /// Every so many of the finest grid.
    stride: usize,
    first: usize,
    last: usize,
}

impl Task {
    pub(crate) const NINE: Self = Self { stride: 2, first: 0, last: FINEST - 1 };
    pub(crate) const SEVENTEEN: Self = Self { stride: 1, first: 0, last: FINEST - 1 };
    pub(crate) const ALL: [Self; 5] = [
        Self::NINE,
        Self::SEVENTEEN,
        // The three most dilute and the three densest of the nine; and one alone.
        Self { stride: 2, first: 0, last: 4 },
        Self { stride: 2, first: FINEST - 5, last: FINEST - 1 },
        Self { stride: 2, first: 8, last: 8 },
    ];

    fn indices(self) -> impl Iterator<Item = usize> {
        (self.first..=self.last).step_by(self.stride)
    }

    fn spacing(self) -> f64 {
        self.stride as f64 * (HIGHEST - LOWEST) / (FINEST - 1) as f64
    }

    pub(crate) fn label(self) -> String {
        let count = self.indices().count();
        let (low, high) = (packing_fraction(self.first), packing_fraction(self.last));
        if count == 1 { format!("1: {low}") } else { format!("{count}: {low} to {high}") }
    }
}

fn packing_fraction(index: usize) -> f64 {
    // Hundredths and halves of them, without the noise of the last digit.
    let step = (HIGHEST - LOWEST) / (FINEST - 1) as f64;
    (1e3 * (LOWEST + step * index as f64)).round() / 1e3
}

/// One replica of the homogeneous runs at one packing fraction, after so many sweeps.
#[derive(Debug, Clone, Copy)]
struct Single {
    factor: Estimate,
    /// CPU seconds to equilibrate and to measure.
    seconds: [f64; 2],
}

/// Runs of 64, 128 ... sweeps to equilibrate and as many measured.
fn follow(technique: Technique, eta: f64, seed: u64, patience: f64) -> Result<Vec<Single>, Failure> {
    let begin = cpu_seconds();
    let mut box_of_spheres = Homogeneous::new(LATTICE, eta, technique, seed);
    let mut equilibration = cpu_seconds() - begin;
    let (mut singles, mut sweeps, mut done) = (Vec::new(), SHORTEST, 0);
    loop {
        let start = cpu_seconds();
        box_of_spheres.equilibrate(sweeps - done);
        done = sweeps;
        equilibration += cpu_seconds() - start;
        let mut production = box_of_spheres.clone();
        let start = cpu_seconds();
        let measured = production.measure(sweeps)?;
        let measurement = cpu_seconds() - start;
        // Z of infinitely many spheres.
        let factor = measured + finite_size(production.particles(), eta);
        singles.push(Single { factor, seconds: [equilibration, measurement] });
        if 2.0 * (equilibration + measurement) > patience {
            return Ok(singles);
        }
        sweeps *= 2;
    }
}

/// A way after so many sweeps: what a task takes and how well it is done.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Point {
    /// CPU seconds to equilibrate and to measure.
    pub(crate) seconds: [f64; 2],
    /// Root mean square of Z over that of the modified Kolafa equation, less 1, over packing fractions and replicas.
    pub(crate) error: f64,
}

impl Point {
    /// All of it, or only the measurement, for who has an equilibrated configuration.
    pub(crate) fn time(&self, from_scratch: bool) -> f64 {
        if from_scratch { self.seconds[0] + self.seconds[1] } else { self.seconds[1] }
    }
}

/// What was measured of all ways.
#[derive(Debug)]
pub(crate) struct Contest {
    /// Of each temperature, of each replica.
    gradients: Vec<(f64, Vec<Vec<Yield>>)>,
    /// Of each technique, of each packing fraction, of each replica.
    homogeneous: Vec<(Way, Vec<Vec<Vec<Single>>>)>,
}

/// A unit of work, and what comes of it.
#[derive(Debug, Clone, Copy)]
enum Job {
    Gradient(f64, u64),
    Homogeneous(Technique, usize, u64),
}

enum Outcome {
    Gradient(Vec<Yield>),
    Homogeneous(Vec<Single>),
}

impl Contest {
    /// Gradients are followed for `patience` CPU seconds, each homogeneous way, all packing fractions together, for a
    /// quarter of that.
    pub(crate) fn run(session: &Session, patience: f64) -> Result<Self, Failure> {
        let mut jobs = Vec::new();
        for temperature in TEMPERATURES {
            jobs.extend((0..REPLICAS).map(|replica| Job::Gradient(temperature, replica)));
        }
        for technique in [Technique::Local, Technique::Chains] {
            for index in 0..FINEST {
                jobs.extend((0..REPLICAS).map(|replica| Job::Homogeneous(technique, index, replica)));
            }
        }
        let outcomes = session.run_each("equation of state", jobs, |job| {
            Ok(match job {
                Job::Gradient(temperature, replica) => {
                    Outcome::Gradient(Gradient { temperature }.follow(session.seed(replica), patience)?)
                }
                Job::Homogeneous(technique, index, replica) => {
                    let seed = session.seed(10_000 + 100 * index as u64 + replica);
                    let patience = 0.25 * patience / FINEST as f64;
                    Outcome::Homogeneous(follow(technique, packing_fraction(index), seed, patience)?)
                }
            })
        })?;
        let (mut yields, mut singles) = (Vec::new(), Vec::new());
        for outcome in outcomes {
            match outcome {
                Outcome::Gradient(outcome) => yields.push(outcome),
                Outcome::Homogeneous(outcome) => singles.push(outcome),
            }
        }
        let replicas = usize::try_from(REPLICAS)?;
        let of_each: Vec<Vec<Vec<Single>>> = singles.chunks(replicas).map(<[_]>::to_vec).collect();
        Ok(Self {
            gradients: TEMPERATURES.into_iter().zip(yields.chunks(replicas).map(<[_]>::to_vec)).collect(),
            homogeneous: [Way::Local, Way::Chains]
                .into_iter()
                .zip(of_each.chunks(FINEST).map(<[_]>::to_vec))
                .collect(),
        })
    }

    pub(crate) fn ways(&self) -> Vec<Way> {
        let gradients = self.gradients.iter().map(|&(temperature, _)| Way::Gradient(temperature));
        gradients.chain(self.homogeneous.iter().map(|&(way, _)| way)).collect()
    }

    /// The points of a way at a task, the shortest runs first.
    pub(crate) fn points(&self, way: Way, task: Task) -> Vec<Point> {
        let gradients = self.gradients.iter().filter(|(temperature, _)| Way::Gradient(*temperature) == way);
        let homogeneous = self.homogeneous.iter().filter(|(own, _)| *own == way);
        let mut points: Vec<Point> =
            gradients.flat_map(|(_, replicas)| gradient_points(replicas, task)).collect();
        points.extend(homogeneous.flat_map(|(_, runs)| homogeneous_points(runs, task)));
        points
    }

    /// The largest deviation of the homogeneous runs from the modified Kolafa equation, over packing fractions, in standard errors of the
    /// mean over replicas (of their longest runs; the larger of what blocks and scatter say), and relative; and the largest of these errors, relative.
    pub(crate) fn agreement(&self, way: Way) -> [f64; 3] {
        let mut largest = [0.0; 3];
        for (_, runs) in self.homogeneous.iter().filter(|(own, _)| *own == way) {
            for (index, replicas) in runs.iter().enumerate() {
                let last: Vec<Estimate> =
                    replicas.iter().filter_map(|singles| Some(singles.last()?.factor)).collect();
                let count = last.len() as f64;
                let mean = last.iter().map(|factor| factor.mean).sum::<f64>() / count;
                let squares = last.iter().map(|factor| factor.standard_error * factor.standard_error);
                let blocking = squares.sum::<f64>().sqrt() / count;
                let scatter =
                    last.iter().map(|factor| (factor.mean - mean) * (factor.mean - mean)).sum::<f64>();
                // Blocks of a short run may be too short.
                let error = blocking.max((scatter / (count * (count - 1.0))).sqrt());
                let theory = ModifiedKolafa.compressibility_factor(packing_fraction(index));
                let found = [(mean - theory).abs() / error, (mean / theory - 1.0).abs(), error / theory];
                largest = [0, 1, 2].map(|part| f64::max(largest[part], found[part]));
            }
        }
        largest
    }

    /// Of the longest gradient runs at each temperature: the deviation of Z from the modified Kolafa equation at each
    /// packing fraction of the nine, its mean over replicas and the error of that by their scatter.
    pub(crate) fn gradient_deviations(&self) -> Vec<(f64, Vec<(f64, Estimate)>)> {
        let grid: Vec<f64> = Task::NINE.indices().map(packing_fraction).collect();
        let of = |replicas: &[Vec<Yield>]| {
            let last = replicas.iter().filter_map(|yields| yields.last());
            let all: Vec<Vec<f64>> = last.map(|own| own.deviations(&grid, Task::NINE.spacing())).collect();
            let estimates = grid.iter().enumerate().map(|(index, &eta)| {
                let deviations: Vec<f64> = all.iter().map(|own| own[index]).collect();
                (eta, mean_of_replicas(&deviations).unwrap_or(Estimate::new(f64::NAN, f64::NAN)))
            });
            estimates.collect()
        };
        self.gradients.iter().map(|(temperature, replicas)| (*temperature, of(replicas))).collect()
    }

    /// The densest bin of the longest gradient runs at each temperature, and the number of spheres.
    pub(crate) fn columns(&self) -> Result<Vec<(f64, f64, usize)>, Failure> {
        self.gradients
            .iter()
            .map(|&(temperature, ref replicas)| {
                let last = replicas.iter().filter_map(|yields| yields.last());
                let densest = last.map(Yield::densest).fold(0.0, f64::max);
                Ok((temperature, densest, Gradient { temperature }.particles()?))
            })
            .collect()
    }
}

fn gradient_points(replicas: &[Vec<Yield>], task: Task) -> Vec<Point> {
    let grid: Vec<f64> = task.indices().map(packing_fraction).collect();
    let common = replicas.iter().map(Vec::len).min().unwrap_or(0);
    (0..common)
        .map(|index| {
            let yields = replicas.iter().map(|yields| &yields[index]);
            let seconds = [0, 1]
                .map(|part| yields.clone().map(|own| own.seconds[part]).sum::<f64>() / replicas.len() as f64);
            let error = root_mean_square(yields.flat_map(|own| own.deviations(&grid, task.spacing())));
            Point { seconds, error }
        })
        .collect()
}

fn homogeneous_points(runs: &[Vec<Vec<Single>>], task: Task) -> Vec<Point> {
    let chosen: Vec<usize> = task.indices().collect();
    let common = chosen.iter().flat_map(|&index| runs[index].iter().map(Vec::len)).min().unwrap_or(0);
    (0..common)
        .map(|length| {
            let (mut seconds, mut deviations) = ([0.0; 2], Vec::new());
            for &index in &chosen {
                let theory = ModifiedKolafa.compressibility_factor(packing_fraction(index));
                for single in runs[index].iter().map(|singles| singles[length]) {
                    for (sum, own) in seconds.iter_mut().zip(single.seconds) {
                        *sum += own / runs[index].len() as f64;
                    }
                    deviations.push(single.factor.mean / theory - 1.0);
                }
            }
            Point { seconds, error: root_mean_square(deviations) }
        })
        .collect()
}

/// A time to a target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Crossing {
    pub(crate) seconds: f64,
    /// Whether the target was not reached: then it is where the error would get if it fell on with the square root of
    /// time.
    pub(crate) extrapolated: bool,
}

/// The time at which an error falls below a target for good, between points by a power law; none if it does not, and is still more than
/// `reach` times the target at the end.
pub(crate) fn crossing(points: &[(f64, f64)], target: f64, reach: f64) -> Option<Crossing> {
    // A point that is not a number is not below.
    let below = |&(_, error): &(f64, f64)| error < target;
    let found = |seconds| Some(Crossing { seconds, extrapolated: false });
    let Some(above) = points.iter().rposition(|point| !below(point)) else { return found(points.first()?.0) };
    let before = points[above];
    let Some(after) = points.get(above + 1) else {
        let ratio = before.1 / target;
        let seconds = before.0 * ratio * ratio;
        return (ratio < reach).then_some(Crossing { seconds, extrapolated: true });
    };
    if before.1.is_nan() {
        return found(after.0);
    }
    let part = libm::log(before.1 / target) / libm::log(before.1 / after.1);
    found(before.0 * libm::pow(after.0 / before.0, part))
}
