//! Evaluation of a case: profiles, deviations from theory, and CSV files.

use super::case::Case;
use super::measurement::Replica;
use super::protocol::Protocol;
use gradient_mc::drive::Certificate;
use gradient_mc::equation_of_state::{CarnahanStarling, packing_fraction};
use gradient_mc::hydrostatics::Hydrostatics;
use gradient_mc::observers::{
    CenterOfMass, EquationOfStateFit, EquationOfStateProfile, MeasuredEquationOfState,
};
use gradient_mc::statistics::{Estimate, deviations};
use gradient_mc::{EquationOfState, Error, Merge};
use paper::Failure;
use paper::output::write_csv;
use paper::row;
use paper::warnings;
use std::path::Path;
use std::time::Duration;

/// Lower end of the bulk, in diameters. Below are the layers at the wall, which no equation of
/// state describes.
pub(crate) const BULK_BEGINS: f64 = 8.0;
/// Lowest number density of the bulk; below it there are too few counts.
pub(crate) const BULK_DENSITY: f64 = 0.02;

/// One bin of the measured profile, with the theory.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bin {
    pub(crate) height: f64,
    pub(crate) number_density: Estimate,
    pub(crate) pressure: Estimate,
    pub(crate) temperature: f64,
    /// Hydrostatics with Carnahan-Starling.
    pub(crate) number_density_theory: f64,
    pub(crate) pressure_theory: f64,
}

impl Bin {
    pub(crate) fn packing_fraction(&self) -> f64 {
        packing_fraction(self.number_density.mean)
    }

    /// n T Z at the measured density.
    fn pressure_of_carnahan_starling(&self) -> f64 {
        let factor = CarnahanStarling.compressibility_factor(self.packing_fraction());
        self.number_density.mean * self.temperature * factor
    }

    /// Whether the bin is in the bulk: an equation of state holds, and there are enough counts.
    fn is_bulk(&self) -> bool {
        self.height > BULK_BEGINS && self.number_density.mean > BULK_DENSITY
    }
}

/// Z at one packing fraction, from each route and from both combined.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Factor {
    pub(crate) packing_fraction: f64,
    pub(crate) combined: Estimate,
    pub(crate) ranks: Estimate,
    pub(crate) collisions: Estimate,
}

/// Z at packing fractions 0.05, 0.075, 0.10 ... up to the largest above the layers.
fn factors(measured: &MeasuredEquationOfState) -> Result<Vec<Factor>, Error> {
    let packing_fractions: Vec<f64> = (2..40_u32)
        .map(|step| 0.025 * f64::from(step))
        .take_while(|&eta| eta <= measured.highest_packing_fraction())
        .collect();
    let [combined, ranks, collisions] = [measured.combined(), measured.ranks(), measured.collisions()]
        .map(|curve| curve.compressibility_factor_at(&packing_fractions));
    let routes = combined?.into_iter().zip(ranks?).zip(collisions?);
    Ok(packing_fractions
        .into_iter()
        .zip(routes)
        .map(|(packing_fraction, ((combined, ranks), collisions))| Factor {
            packing_fraction,
            combined,
            ranks,
            collisions,
        })
        .collect())
}

/// Deviations in standard errors.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pulls {
    pub(crate) rms: f64,
    pub(crate) largest: f64,
    /// Packing fraction of the largest deviation.
    pub(crate) at: f64,
}

/// Mean and largest value over the bulk of a measure of error of the paper.
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

/// The results of one case.
pub(crate) struct Report {
    pub(crate) case: Case,
    pub(crate) particles: usize,
    pub(crate) bins: Vec<Bin>,
    /// Empty if the runs are too short.
    pub(crate) factors: Vec<Factor>,
    /// Range of heights from which they are measured.
    pub(crate) heights: Option<[f64; 2]>,
    pub(crate) center_of_mass: Option<Estimate>,
    pub(crate) center_of_mass_theory: f64,
    /// Certificate of the effective field; `None` without one, or with too few data.
    pub(crate) certificate: Option<Certificate>,
    /// Warnings about the replicas, one line for each kind.
    pub(crate) warnings: Vec<String>,
    /// Mean height of the center of mass in the second half of production minus that in the first
    /// half, averaged over replicas.
    pub(crate) drift: Option<Estimate>,
    /// Mean packing fraction of the layers at the base, below the bulk.
    pub(crate) low_packing_fraction: f64,
    pub(crate) low_packing_fraction_theory: f64,
    pub(crate) busy: Duration,
    /// σ of eq. (32) between the runs; `None` for a single run.
    pub(crate) scatter: Option<Range>,
    pub(crate) runs: usize,
    /// δ of eq. (33).
    pub(crate) deviation: Range,
}

impl Report {
    /// Tolerance of the certificate: the smallest that runs of the default length can resolve.
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
        let measured = EquationOfStateFit::pooled(replicas.iter().map(|replica| &replica.fit))?.result();
        let of_fit = measured.as_ref().map_or(Vec::new(), MeasuredEquationOfState::warnings);
        let (field, temperature) = (case.field()?, case.temperature()?);
        let theory = Hydrostatics::new(&field, &temperature, &CarnahanStarling)
            .lid(Protocol::HEIGHT)
            .column_density(Protocol::COLUMN_DENSITY)?;
        let bins: Vec<Bin> = pooled
            .points()?
            .iter()
            .map(|point| Bin {
                height: point.height,
                number_density: point.number_density,
                pressure: point.pressure,
                temperature: point.temperature,
                number_density_theory: theory.number_density(point.height),
                pressure_theory: theory.pressure(point.height),
            })
            .collect();

        let low = || bins.iter().filter(|bin| bin.height < BULK_BEGINS);
        let over_low = |density: fn(&Bin) -> f64| {
            packing_fraction(low().map(density).sum::<f64>() / low().count() as f64)
        };
        let bulk = || bins.iter().filter(|bin| bin.is_bulk());
        let deviation = Range::of(
            bulk().map(|bin| deviations::deviation(bin.pressure.mean, bin.pressure_of_carnahan_starling())),
        );
        Ok(Self {
            case,
            particles: protocol.particles,
            factors: measured.as_ref().map_or(Ok(Vec::new()), factors)?,
            heights: measured.as_ref().ok().map(MeasuredEquationOfState::heights),
            center_of_mass: center_of_mass.estimate().ok(),
            center_of_mass_theory: theory.center_of_mass(),
            certificate: certificate(replicas)?,
            warnings: warnings::lines(
                replicas.iter().map(|replica| &replica.warnings[..]).chain([&of_fit[..]]),
            ),
            drift: center_of_mass.drift().ok(),
            low_packing_fraction: over_low(|bin| bin.number_density.mean),
            low_packing_fraction_theory: over_low(|bin| bin.number_density_theory),
            busy: replicas.iter().map(|replica| replica.busy).sum(),
            scatter: scatter(&runs, &bins),
            runs: runs.len(),
            deviation,
            bins,
        })
    }

    /// The bins of the bulk.
    pub(crate) fn bulk(&self) -> impl Iterator<Item = &Bin> + Clone {
        self.bins.iter().filter(|bin| bin.is_bulk())
    }

    /// Root mean square and largest deviation of all Z of a route from an equation of state, in
    /// standard errors.
    pub(crate) fn pulls(
        &self,
        equation: &dyn EquationOfState,
        route: fn(&Factor) -> Estimate,
    ) -> Option<Pulls> {
        let pulls: Vec<(f64, f64)> = self
            .factors
            .iter()
            .map(|factor| {
                let eta = factor.packing_fraction;
                (eta, route(factor).deviation_from(equation.compressibility_factor(eta)))
            })
            .filter(|(_, pull)| pull.is_finite())
            .collect();
        let squares = pulls.iter().map(|(_, pull)| pull * pull).sum::<f64>();
        let &(at, largest) = pulls.iter().max_by(|(_, one), (_, other)| one.abs().total_cmp(&other.abs()))?;
        Some(Pulls { rms: (squares / pulls.len() as f64).sqrt(), largest, at })
    }

    /// Writes `<path>.csv` with the profile and `<path>_equation_of_state.csv`.
    pub(crate) fn write_csv(&self, path: &Path) -> Result<(), Failure> {
        write_csv(
            &path.with_extension("csv"),
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
        )?;
        write_csv(
            &path.with_file_name(format!("{}_equation_of_state.csv", self.case.name())),
            "compressibility factor P/(nT) from the heights of ranks, from the collisions of event chains, and from both; \
             errors are one standard error",
            "packing_fraction, compressibility_factor, compressibility_factor_error, \
             compressibility_factor_ranks, compressibility_factor_ranks_error, \
             compressibility_factor_collisions, compressibility_factor_collisions_error",
            self.factors.iter().map(|factor| {
                row![factor.packing_fraction, factor.combined, factor.ranks, factor.collisions]
            }),
        )
    }
}

/// The certificate from all replicas; `None` without an effective field, or with too few data.
fn certificate(replicas: &[Replica]) -> Result<Option<Certificate>, Failure> {
    let mut records = replicas.iter().filter_map(|replica| replica.force_balance.clone());
    let Some(mut pooled) = records.next() else { return Ok(None) };
    for record in records {
        pooled.merge(&record)?;
    }
    Ok(pooled.certificate(Report::TOLERANCE).ok())
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
