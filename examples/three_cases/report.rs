//! What the measurements of a case say: profiles, deviations from theory, and the CSV file.

use super::case::Case;
use super::measurement::Replica;
use super::protocol::Protocol;
use gradient_mc::drive::Certificate;
use gradient_mc::equation_of_state::{CarnahanStarling, ModifiedKolafa, packing_fraction};
use gradient_mc::hydrostatics::Hydrostatics;
use gradient_mc::observers::{CenterOfMass, EquationOfStateProfile};
use gradient_mc::statistics::{Estimate, deviations};
use gradient_mc::{Merge, MoveCounts};
use paper::Failure;
use paper::output::write_csv;
use paper::row;
use paper::warnings;
use std::path::Path;
use std::time::Duration;

/// Below this height the layers at the wall are not described by any equation of state.
pub(crate) const BULK_BEGINS: f64 = 8.0;
/// Where the density is below this, counts are too few.
pub(crate) const BULK_DENSITY: f64 = 0.02;

/// One bin of the measured profile, beside theory.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bin {
    pub(crate) height: f64,
    pub(crate) number_density: Estimate,
    pub(crate) pressure: Estimate,
    pub(crate) temperature: f64,
    /// P/(n T Z(η)) − 1 for the Z of Carnahan and Starling at the measured density.
    pub(crate) against_carnahan_starling: Estimate,
    /// The same for the modified Kolafa-Labík-Malijevský equation.
    pub(crate) against_modified_kolafa: Estimate,
    /// Hydrostatics with Carnahan-Starling.
    pub(crate) number_density_theory: f64,
    pub(crate) pressure_theory: f64,
}

impl Bin {
    pub(crate) fn packing_fraction(&self) -> f64 {
        packing_fraction(self.number_density.mean)
    }

    /// Whether an equation of state can be expected to hold here, and counts suffice to see it.
    fn is_bulk(&self) -> bool {
        self.height > BULK_BEGINS && self.number_density.mean > BULK_DENSITY
    }
}

/// Deviations from one equation of state over the bulk, as fractions.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Comparison {
    /// Its error takes bins as independent.
    pub(crate) rms: Estimate,
    /// The rms that the error bars alone would give if the equation of state were exact.
    pub(crate) rms_of_noise: f64,
    /// The deviation of largest magnitude, with its own error bar.
    pub(crate) largest: Estimate,
    /// Packing fraction where it is.
    pub(crate) largest_at: f64,
}

impl Comparison {
    fn new(points: impl Iterator<Item = (f64, Estimate)>) -> Self {
        let (mut squares, mut noise, mut spread, mut count) = (0.0, 0.0, 0.0, 0.0);
        let (mut largest, mut largest_at) = (Estimate::exact(0.0), f64::NAN);
        for (packing_fraction, deviation) in points {
            let square = deviation.mean * deviation.mean;
            let variance = deviation.standard_error * deviation.standard_error;
            squares += square;
            noise += variance;
            // Variance of the square of a normal number of mean μ: 2σ⁴ + 4μ²σ².
            spread += variance * (2.0 * variance + 4.0 * (square - variance).max(0.0));
            count += 1.0;
            if deviation.mean.abs() > largest.mean.abs() {
                (largest, largest_at) = (deviation, packing_fraction);
            }
        }
        let rms = (squares / count).sqrt();
        let rms = Estimate::new(rms, spread.sqrt() / (2.0 * count * rms));
        Self { rms, rms_of_noise: (noise / count).sqrt(), largest, largest_at }
    }
}

/// Mean and largest over the bulk of a measure that the paper prints.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Range {
    pub(crate) mean: f64,
    pub(crate) largest: f64,
}

impl Range {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let (mut sum, mut count, mut largest) = (0.0, 0.0, 0.0);
        for value in values {
            sum += value;
            count += 1.0;
            largest = f64::max(largest, value);
        }
        Self { mean: sum / count, largest }
    }
}

/// Everything about one case.
pub(crate) struct Report {
    pub(crate) case: Case,
    pub(crate) particles: usize,
    pub(crate) bins: Vec<Bin>,
    pub(crate) center_of_mass: Option<Estimate>,
    pub(crate) center_of_mass_theory: f64,
    /// Verdict on the effective field, where there is one and enough was measured.
    pub(crate) certificate: Option<Certificate>,
    /// What the replicas say against themselves, a line for each kind.
    pub(crate) warnings: Vec<String>,
    /// Second half of the measurement minus the first, mean over the replicas.
    pub(crate) drift: Option<Estimate>,
    /// Packing fraction from the base up to where the bulk begins: mean over the layers at the wall.
    pub(crate) low_packing_fraction: f64,
    pub(crate) low_packing_fraction_theory: f64,
    pub(crate) base_packing_fraction_theory: f64,
    pub(crate) production: MoveCounts,
    pub(crate) total: MoveCounts,
    pub(crate) busy: Duration,
    /// σ of eq. (32) between the runs, and how many runs; there is none for a single run.
    pub(crate) scatter: Option<Range>,
    pub(crate) runs: usize,
    /// δ of eq. (33).
    pub(crate) deviation: Range,
}

impl Report {
    /// Of the certificate: the smallest that runs of the usual length can tell.
    const TOLERANCE: f64 = 0.02;

    /// Evaluates the replicas of a case.
    pub(crate) fn new(case: Case, replicas: &[Replica], protocol: &Protocol) -> Result<Self, Failure> {
        let runs: Vec<&EquationOfStateProfile> =
            replicas.iter().flat_map(|replica| &replica.profiles).collect();
        let (first, rest) = runs.split_first().ok_or("nothing was measured")?;
        let mut pooled = (*first).clone();
        for run in rest {
            pooled.merge(run)?;
        }
        let mut center_of_mass = CenterOfMass::new();
        for replica in replicas {
            center_of_mass.merge(&replica.center_of_mass)?;
        }
        let (field, temperature) = (case.field()?, case.temperature()?);
        let theory = Hydrostatics::new(&field, &temperature, &CarnahanStarling)
            .lid(Protocol::HEIGHT)
            .column_density(Protocol::COLUMN_DENSITY)?;
        let against_carnahan_starling = pooled.deviations_from(&CarnahanStarling)?;
        let against_modified_kolafa = pooled.deviations_from(&ModifiedKolafa)?;
        let bins: Vec<Bin> = pooled
            .points()?
            .iter()
            .zip(against_carnahan_starling.iter().zip(&against_modified_kolafa))
            .map(|(point, (carnahan_starling, modified_kolafa))| Bin {
                height: point.height,
                number_density: point.number_density,
                pressure: point.pressure,
                temperature: point.temperature,
                against_carnahan_starling: carnahan_starling.deviation,
                against_modified_kolafa: modified_kolafa.deviation,
                number_density_theory: theory.number_density(point.height),
                pressure_theory: theory.pressure(point.height),
            })
            .collect();

        let low = || bins.iter().filter(|bin| bin.height < BULK_BEGINS);
        let over_low = |density: fn(&Bin) -> f64| {
            packing_fraction(low().map(density).sum::<f64>() / low().count() as f64)
        };
        let bulk = || bins.iter().filter(|bin| bin.is_bulk());
        let deviation =
            Range::of(bulk().map(|bin| deviations::deviation(1.0 + bin.against_carnahan_starling.mean, 1.0)));
        Ok(Self {
            case,
            particles: protocol.particles,
            center_of_mass: center_of_mass.estimate().ok(),
            center_of_mass_theory: theory.center_of_mass(),
            certificate: certificate(replicas)?,
            warnings: warnings::lines(replicas.iter().map(|replica| &replica.warnings[..])),
            drift: center_of_mass.drift().ok(),
            low_packing_fraction: over_low(|bin| bin.number_density.mean),
            low_packing_fraction_theory: over_low(|bin| bin.number_density_theory),
            base_packing_fraction_theory: theory.base_packing_fraction(),
            production: sum_tallies(replicas, |replica| replica.production),
            total: sum_tallies(replicas, |replica| replica.total),
            busy: replicas.iter().map(|replica| replica.busy).sum(),
            scatter: scatter(&runs, &bins),
            runs: runs.len(),
            deviation,
            bins,
        })
    }

    /// Bins where an equation of state can be expected to hold.
    pub(crate) fn bulk(&self) -> impl Iterator<Item = &Bin> + Clone {
        self.bins.iter().filter(|bin| bin.is_bulk())
    }

    pub(crate) fn against_carnahan_starling(&self) -> Comparison {
        Comparison::new(self.bulk().map(|bin| (bin.packing_fraction(), bin.against_carnahan_starling)))
    }

    pub(crate) fn against_modified_kolafa(&self) -> Comparison {
        Comparison::new(self.bulk().map(|bin| (bin.packing_fraction(), bin.against_modified_kolafa)))
    }

    /// Trial moves, or events of chains.
    pub(crate) fn moves(&self) -> u64 {
        self.total.trials + self.total.events
    }

    /// The same per second on one core.
    pub(crate) fn moves_per_second(&self) -> f64 {
        self.moves() as f64 / self.busy.as_secs_f64()
    }

    pub(crate) fn write_csv(&self, path: &Path) -> Result<(), Failure> {
        write_csv(
            path,
            "height in d; densities in 1/d^3; pressures in m g/d^2; temperature in m g d; errors are one \
             standard error; theory is hydrostatics with the Carnahan-Starling equation of state",
            "height, number_density, number_density_error, pressure, pressure_error, \
             temperature, packing_fraction, number_density_theory, pressure_theory",
            self.bins.iter().map(|bin| {
                row![
                    bin.height,
                    bin.number_density,
                    bin.pressure,
                    bin.temperature,
                    bin.packing_fraction(),
                    bin.number_density_theory,
                    bin.pressure_theory,
                ]
            }),
        )
    }
}

/// What all replicas together say of the field; nothing without a field, or too early.
fn certificate(replicas: &[Replica]) -> Result<Option<Certificate>, Failure> {
    let mut records = replicas.iter().filter_map(|replica| replica.force_balance.clone());
    let Some(mut pooled) = records.next() else { return Ok(None) };
    for record in records {
        pooled.merge(&record)?;
    }
    Ok(pooled.certificate(Report::TOLERANCE).ok())
}

fn sum_tallies(replicas: &[Replica], move_counts: impl Fn(&Replica) -> MoveCounts) -> MoveCounts {
    let mut sum = MoveCounts::default();
    for replica in replicas {
        sum.trials += move_counts(replica).trials;
        sum.accepted += move_counts(replica).accepted;
        sum.chains += move_counts(replica).chains;
        sum.events += move_counts(replica).events;
    }
    sum
}

/// σ of eq. (32) in the bulk: scatter of the pressure between the runs.
fn scatter(runs: &[&EquationOfStateProfile], bins: &[Bin]) -> Option<Range> {
    let pressures: Vec<Vec<f64>> = runs
        .iter()
        .map(|run| Ok(run.points()?.iter().map(|point| point.pressure.mean).collect()))
        .collect::<Result<_, gradient_mc::Error>>()
        .ok()?;
    let scatters: Vec<f64> = bins
        .iter()
        .enumerate()
        .filter(|(_, bin)| bin.is_bulk())
        .map(|(index, _)| {
            let values: Vec<f64> = pressures.iter().map(|run| run[index]).collect();
            deviations::scatter(&values)
        })
        .collect::<Result<_, _>>()
        .ok()?;
    Some(Range::of(scatters.into_iter()))
}
