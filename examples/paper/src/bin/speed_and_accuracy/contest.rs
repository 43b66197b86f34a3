//! The equation of state over a range of packing fractions: one run in a gradient compared with a
//! homogeneous run for each.

use crate::gradient::{Column, Route, Yield};
use crate::pace::Pace;
use gradient_mc::equation_of_state::{EquationOfState, ModifiedKolafa};
use gradient_mc::statistics::{Estimate, mean_of_replicas};
use paper::accuracy::{median, root_mean_square};
use paper::clock::cpu_seconds;
use paper::homogeneous::{Homogeneous, Technique, finite_size};
use paper::least_squares::least_squares;
use paper::{Failure, Session};
use serde::{Deserialize, Serialize};

/// Packing fractions of the finest grid; coarser ones take every so many of them.
const LOWEST: f64 = 0.05;
const HIGHEST: f64 = 0.45;
const FINEST: usize = 65;
/// Of the finest grid every so many are seventeen; local moves have these alone.
const OF_SEVENTEEN: usize = 4;
/// fcc cubes along an edge of the homogeneous box: 256 spheres.
const LATTICE: usize = 4;
const SHORTEST: u64 = 64;
/// Of every way.
pub(crate) const REPLICAS: u64 = 6;

/// Sweeps that chains equilibrate before so many are measured, of gradient and homogeneous runs
/// alike; local moves take as many.
pub(crate) fn equilibration(sweeps: u64) -> u64 {
    sweeps / 4
}

/// A method for the equation of state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Way {
    Gradient(Column, Route),
    Local,
    Chains,
    /// Homogeneous chains with the time per event of the library.
    ChainsAtPace,
}

impl Way {
    pub(crate) fn label(self) -> String {
        match self {
            Self::Gradient(column, route) => format!("{}, {}", column.label(), route.label()),
            Self::Local => "homogeneous, local moves".to_owned(),
            Self::Chains => "homogeneous, event chains".to_owned(),
            Self::ChainsAtPace => "homogeneous, event chains at the speed of the library".to_owned(),
        }
    }

    pub(crate) fn is_gradient(self) -> bool {
        matches!(self, Self::Gradient(..))
    }
}

/// The requested quantity. The first number is the stride on the finest grid; a gradient run always
/// gives the whole curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Task {
    /// Z at packing fractions of the finest grid from one to another: rms error.
    Densities(usize, [usize; 2]),
    /// Z(η) from 0.05 to 0.45: largest error; homogeneous runs are fitted by the same form as a
    /// gradient run.
    Curve(usize),
    /// The excess chemical potential at 0.45, by integration of that curve: relative error.
    ChemicalPotential(usize),
}

impl Task {
    pub(crate) const NINE: Self = Self::Densities(8, [0, FINEST - 1]);
    pub(crate) const SEVENTEEN: Self = Self::Densities(OF_SEVENTEEN, [0, FINEST - 1]);
    pub(crate) const SIXTY_FIVE: Self = Self::Densities(1, [0, FINEST - 1]);
    pub(crate) const DENSITIES: [Self; 6] = [
        Self::NINE,
        Self::SEVENTEEN,
        Self::SIXTY_FIVE,
        // The three most dilute and the three densest of the nine; and one alone.
        Self::Densities(8, [0, 16]),
        Self::Densities(8, [48, 64]),
        Self::Densities(8, [32, 32]),
    ];
    /// Curves through five, nine and seventeen homogeneous points.
    pub(crate) const CURVES: [Self; 6] = [
        Self::Curve(16),
        Self::Curve(8),
        Self::Curve(4),
        Self::ChemicalPotential(16),
        Self::ChemicalPotential(8),
        Self::ChemicalPotential(4),
    ];

    /// Packing fractions at which there are homogeneous runs.
    fn indices(self) -> Vec<usize> {
        let (stride, [first, last]) = match self {
            Self::Densities(stride, range) => (stride, range),
            Self::Curve(stride) | Self::ChemicalPotential(stride) => (stride, [0, FINEST - 1]),
        };
        (first..=last).step_by(stride).collect()
    }

    pub(crate) fn label(self) -> String {
        let indices = self.indices();
        let count = indices.len();
        match self {
            Self::Densities(..) if count == 1 => format!("1: {}", packing_fraction(indices[0])),
            Self::Densities(_, [first, last]) => {
                format!("{count}: {} to {}", packing_fraction(first), packing_fraction(last))
            }
            Self::Curve(_) => format!("curve, from {count}"),
            Self::ChemicalPotential(_) => format!("chemical potential, from {count}"),
        }
    }

    /// The error of a curve.
    fn error_of(self, curve: &Curve) -> f64 {
        match self {
            Self::Densities(..) => {
                root_mean_square(self.indices().into_iter().map(|index| curve.deviations[index]))
            }
            Self::Curve(_) => curve
                .deviations
                .iter()
                .fold(0.0, |largest: f64, own| if own.is_nan() { f64::NAN } else { largest.max(own.abs()) }),
            Self::ChemicalPotential(_) => curve.chemical_potential,
        }
    }
}

fn packing_fraction(index: usize) -> f64 {
    // Without the noise of the last digit.
    let step = (HIGHEST - LOWEST) / (FINEST - 1) as f64;
    (1e5 * (LOWEST + step * index as f64)).round() / 1e5
}

/// A smooth equation of state against the modified Kolafa equation.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Curve {
    /// Of Z, relative, over the finest grid.
    deviations: Vec<f64>,
    /// Of the excess chemical potential at the highest packing fraction, relative.
    chemical_potential: f64,
}

impl Curve {
    pub(crate) fn of(equation: impl EquationOfState) -> Self {
        let deviation = |eta: f64| {
            equation.compressibility_factor(eta) / ModifiedKolafa.compressibility_factor(eta) - 1.0
        };
        let potential = equation.excess_chemical_potential(HIGHEST);
        Self {
            deviations: (0..FINEST).map(packing_fraction).map(deviation).collect(),
            chemical_potential: potential / ModifiedKolafa.excess_chemical_potential(HIGHEST) - 1.0,
        }
    }
}

/// Z = 1 + (c₁η + c₂η² + c₃η³)/(1 − η)³, the form that a short gradient run is fitted by.
struct Fitted([f64; 3]);

impl Fitted {
    fn terms(eta: f64) -> [f64; 3] {
        let void = 1.0 - eta;
        [eta, eta * eta, eta * eta * eta].map(|power| power / (void * void * void))
    }

    /// Through points of equal relative error.
    fn through(points: &[(f64, f64)]) -> Self {
        let row = |&(eta, factor): &(f64, f64)| (Self::terms(eta), factor - 1.0, 1.0 / (factor * factor));
        Self(least_squares(&points.iter().map(row).collect::<Vec<_>>()))
    }
}

impl EquationOfState for Fitted {
    fn compressibility_factor(&self, eta: f64) -> f64 {
        1.0 + Self::terms(eta).iter().zip(self.0).map(|(term, coefficient)| term * coefficient).sum::<f64>()
    }
}

/// One replica of the homogeneous runs at one packing fraction, after so many sweeps.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Single {
    factor: Estimate,
    /// CPU seconds to equilibrate and to measure.
    seconds: [f64; 2],
}

/// Runs of 64, 128 ... measured sweeps.
fn follow(technique: Technique, eta: f64, seed: u64, patience: f64) -> Result<Vec<Single>, Failure> {
    let begin = cpu_seconds();
    let mut box_of_spheres = Homogeneous::new(LATTICE, eta, technique, seed);
    let mut seconds = cpu_seconds() - begin;
    let (mut singles, mut sweeps, mut done) = (Vec::new(), SHORTEST, 0);
    loop {
        let start = cpu_seconds();
        let wanted = if technique == Technique::Chains { equilibration(sweeps) } else { sweeps };
        box_of_spheres.equilibrate(wanted - done);
        done = wanted;
        seconds += cpu_seconds() - start;
        let mut production = box_of_spheres.clone();
        let start = cpu_seconds();
        let measured = production.measure(sweeps)?;
        let measurement = cpu_seconds() - start;
        // Z of infinitely many spheres.
        let factor = measured + finite_size(production.particles(), eta);
        singles.push(Single { factor, seconds: [seconds, measurement] });
        if 2.0 * (seconds + measurement) > patience {
            return Ok(singles);
        }
        sweeps *= 2;
    }
}

/// A method after a number of sweeps: its CPU time and error for a task.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Point {
    /// CPU seconds to equilibrate and to measure, medians over replicas.
    pub(crate) seconds: [f64; 2],
    /// Relative to the modified Kolafa equation, root mean square over replicas.
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
    /// Of each column its spheres, and of each replica its runs.
    gradients: Vec<(Column, usize, Vec<Vec<Yield>>)>,
    /// Of each technique, of each replica, of each packing fraction of the finest grid; none where
    /// there are no runs.
    homogeneous: [(Way, Vec<Vec<Vec<Single>>>); 2],
    /// Events per CPU second of the library over those of the homogeneous chains.
    pace: f64,
}

/// A unit of work, and what comes of it.
#[derive(Debug, Clone, Copy)]
enum Job {
    Gradient(Column),
    Homogeneous(Technique, usize),
}

#[derive(Serialize, Deserialize)]
enum Outcome {
    Gradient(usize, Vec<Yield>),
    Homogeneous(Vec<Single>),
}

impl Contest {
    /// Gradients are followed for `patience` CPU seconds; so are the homogeneous ways, seventeen
    /// packing fractions together.
    pub(crate) fn run(session: &Session, patience: f64, pace: &Pace) -> Result<Self, Failure> {
        let mut jobs = Vec::new();
        for replica in 0..REPLICAS {
            jobs.extend(Column::ALL.map(|column| (replica, Job::Gradient(column))));
            let seventeen = (0..FINEST).step_by(OF_SEVENTEEN);
            jobs.extend(seventeen.map(|index| (replica, Job::Homogeneous(Technique::Local, index))));
            jobs.extend((0..FINEST).map(|index| (replica, Job::Homogeneous(Technique::Chains, index))));
        }
        let name = |(replica, job): &(u64, Job)| format!("{job:?}, replica {replica}");
        let outcomes = session.run_each("equation of state", jobs.clone(), name, |(replica, job)| {
            Ok(match job {
                Job::Gradient(column) => {
                    let (spheres, yields) = column.follow(session.seed(replica), patience)?;
                    Outcome::Gradient(spheres, yields)
                }
                Job::Homogeneous(technique, index) => {
                    let seed = session.seed(10_000 + 100 * index as u64 + replica);
                    // The others are to come as far as 0.5 %.
                    let part = if index.is_multiple_of(OF_SEVENTEEN) { 1.0 } else { 0.5 };
                    let patience = patience * part / (FINEST / OF_SEVENTEEN + 1) as f64;
                    Outcome::Homogeneous(follow(technique, packing_fraction(index), seed, patience)?)
                }
            })
        })?;
        let mut gradients = Column::ALL.map(|column| (column, 0, Vec::new()));
        let replicas = usize::try_from(REPLICAS)?;
        let none = || vec![vec![Vec::new(); FINEST]; replicas];
        let mut homogeneous = [(Way::Local, none()), (Way::Chains, none())];
        for ((replica, job), outcome) in jobs.into_iter().zip(outcomes) {
            match (job, outcome) {
                (Job::Gradient(column), Outcome::Gradient(spheres, yields)) => {
                    for (_, own, replicas) in gradients.iter_mut().filter(|(of, ..)| *of == column) {
                        *own = spheres;
                        replicas.push(yields.clone());
                    }
                }
                (Job::Homogeneous(technique, index), Outcome::Homogeneous(singles)) => {
                    let way = usize::from(technique == Technique::Chains);
                    homogeneous[way].1[usize::try_from(replica)?][index] = singles;
                }
                _ => return Err("outcomes come in the order of the jobs".into()),
            }
        }
        Ok(Self { gradients: gradients.to_vec(), homogeneous, pace: pace.chains() })
    }

    /// All methods. Both routes are combined where the column is stationary.
    pub(crate) fn ways() -> impl Iterator<Item = Way> {
        let gradients = [
            (Column::Designed, Route::Collisions),
            (Column::Designed, Route::Ranks),
            (Column::Designed, Route::Both),
            (Column::WrongStart, Route::Collisions),
            (Column::WrongStart, Route::Ranks),
            (Column::RandomStart, Route::Collisions),
            (Column::RandomStart, Route::Ranks),
            (Column::Uniform, Route::Collisions),
            (Column::Uniform, Route::Both),
        ];
        let gradients = gradients.into_iter().map(|(column, route)| Way::Gradient(column, route));
        gradients.chain([Way::Local, Way::Chains, Way::ChainsAtPace])
    }

    /// The points of a way at a task, the shortest runs first.
    pub(crate) fn points(&self, way: Way, task: Task) -> Vec<Point> {
        match way {
            Way::Gradient(column, route) => {
                let own = self.gradients.iter().find(|(of, ..)| *of == column);
                own.map_or_else(Vec::new, |(_, _, replicas)| gradient_points(replicas, route, task))
            }
            Way::Local => homogeneous_points(&self.homogeneous[0].1, task, 1.0),
            Way::Chains => homogeneous_points(&self.homogeneous[1].1, task, 1.0),
            Way::ChainsAtPace => homogeneous_points(&self.homogeneous[1].1, task, self.pace),
        }
    }

    /// The largest deviation of the homogeneous runs from the modified Kolafa equation, over the
    /// seventeen packing fractions, in standard errors of the mean over replicas (of their
    /// longest runs; the larger of what blocks and scatter say), and relative; and the largest of
    /// these errors, relative.
    pub(crate) fn agreement(&self, way: Way) -> [f64; 3] {
        let mut largest = [0.0; 3];
        for (_, replicas) in self.homogeneous.iter().filter(|(own, _)| *own == way) {
            for index in Task::SEVENTEEN.indices() {
                let last: Vec<Estimate> =
                    replicas.iter().filter_map(|singles| Some(singles[index].last()?.factor)).collect();
                let Estimate { mean, standard_error: blocking, .. } =
                    Estimate::mean_of_independent(last.iter().copied());
                let means: Vec<f64> = last.iter().map(|factor| factor.mean).collect();
                let scatter = mean_of_replicas(&means).map_or(f64::NAN, |mean| mean.standard_error);
                // Blocks of a short run may be too short.
                let error = blocking.max(scatter);
                let theory = ModifiedKolafa.compressibility_factor(packing_fraction(index));
                let found = [(mean - theory).abs() / error, (mean / theory - 1.0).abs(), error / theory];
                largest = [0, 1, 2].map(|part| f64::max(largest[part], found[part]));
            }
        }
        largest
    }

    /// Of the longest gradient runs: the deviation of Z from the modified Kolafa equation at each
    /// packing fraction of the nine, its mean over replicas and the error of that by their scatter.
    pub(crate) fn gradient_deviations(&self) -> Vec<(Way, Vec<(f64, Estimate)>)> {
        let of = |way: Way, column: Column, route: Route| {
            let own = self.gradients.iter().filter(|(of, ..)| *of == column);
            let curves: Vec<&Curve> = own
                .flat_map(|(_, _, replicas)| replicas.iter().filter_map(|yields| yields.last()?.curve(route)))
                .collect();
            let estimates = Task::NINE.indices().into_iter().map(|index| {
                let deviations: Vec<f64> = curves.iter().map(|curve| curve.deviations[index]).collect();
                let mean = mean_of_replicas(&deviations).unwrap_or(Estimate::new(f64::NAN, f64::NAN));
                (packing_fraction(index), mean)
            });
            (way, estimates.collect())
        };
        let gradients = Self::ways().filter_map(|way| match way {
            Way::Gradient(column, route) => Some(of(way, column, route)),
            _ => None,
        });
        gradients.collect()
    }

    /// Columns and their numbers of spheres.
    pub(crate) fn columns(&self) -> impl Iterator<Item = (Column, usize)> {
        self.gradients.iter().map(|&(column, spheres, _)| (column, spheres))
    }
}

fn gradient_points(replicas: &[Vec<Yield>], route: Route, task: Task) -> Vec<Point> {
    let common = replicas.iter().map(Vec::len).min().unwrap_or(0);
    let point = |index: usize| {
        let yields = || replicas.iter().map(|yields| &yields[index]);
        let seconds = [0, 1].map(|part| median(yields().map(|own| own.seconds[part]).collect()));
        let errors: Option<Vec<f64>> = yields().map(|own| Some(task.error_of(own.curve(route)?))).collect();
        Some(Point { seconds, error: root_mean_square(errors?) })
    };
    (0..common).filter_map(point).collect()
}

/// Of runs that are `pace` times as fast.
fn homogeneous_points(replicas: &[Vec<Vec<Single>>], task: Task, pace: f64) -> Vec<Point> {
    let chosen = task.indices();
    let lengths = replicas.iter().flat_map(|runs| chosen.iter().map(|&index| runs[index].len()));
    let point = |length: usize| {
        let single = |replica: usize, index: usize| replicas[replica][index][length];
        let part_of = |part: usize| {
            let of = |&index: &usize| {
                let times = (0..replicas.len()).map(|replica| single(replica, index).seconds[part]);
                median(times.collect())
            };
            chosen.iter().map(of).sum::<f64>() / pace
        };
        let errors = (0..replicas.len()).map(|replica| {
            let points: Vec<(f64, f64)> = chosen
                .iter()
                .map(|&index| (packing_fraction(index), single(replica, index).factor.mean))
                .collect();
            match task {
                Task::Densities(..) => root_mean_square(
                    points
                        .into_iter()
                        .map(|(eta, factor)| factor / ModifiedKolafa.compressibility_factor(eta) - 1.0),
                ),
                Task::Curve(_) | Task::ChemicalPotential(_) => {
                    task.error_of(&Curve::of(Fitted::through(&points)))
                }
            }
        });
        Point { seconds: [0, 1].map(part_of), error: root_mean_square(errors) }
    };
    (0..lengths.min().unwrap_or(0)).map(point).collect()
}

/// A time to a target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Crossing {
    pub(crate) seconds: f64,
    /// Whether the target was not reached: then it is where the error would get if it fell on with
    /// the square root of time.
    pub(crate) extrapolated: bool,
}

/// The time at which an error falls below a target for good, between points by a power law; none if
/// it does not, and is still more than `reach` times the target at the end.
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
