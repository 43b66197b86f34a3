//! How the bias depends on the bins, and on how many of them a move crosses: a small column, swept by local moves.

use super::prediction::{Prediction, part_outside};
use super::run::Column;
use gradient_mc::drive::Instantaneous;
use gradient_mc::equation_of_state::{EquationOfState, ModifiedKolafa};
use gradient_mc::field::UniformField;
use gradient_mc::moves::LocalMoves;
use gradient_mc::observers::EquationOfStateProfile;
use gradient_mc::statistics::Estimate;
use gradient_mc::temperature::ExponentialTemperature;
use gradient_mc::{Every, Scene, Simulation, Slab};
use paper::Failure;
use paper::interrupt::Interrupt;
use paper::output;
use paper::progress::Progress;
use paper::replicas::in_chunks;
use paper::table::Table;
use std::path::Path;

/// A column so low that local moves of any size relax it.
const COLUMN: Column = Column { temperature: 4.0, decay_rate: 0.12, spheres_per_area: 6.0, height: 40.0 };
const WIDTH: f64 = 7.0;
/// Bins for the sizes of moves, and size for the widths of bins.
pub(crate) const BIN: f64 = 0.5;
const SIZE: f64 = 0.75;
/// Heights over which the deviation is averaged.
const RANGE: [f64; 2] = [3.0, 9.0];

/// One size of local moves and one width of the bins of the density that enters the field.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scan {
    pub(crate) maximum_displacement: f64,
    pub(crate) bin: f64,
    sweeps: u64,
    seed: u64,
}

impl Scan {
    /// Three spheres to a bin, about.
    pub(crate) const NARROWEST_JUDGED: f64 = 0.2;

    pub(crate) fn all(full: bool, seed: u64) -> Vec<Self> {
        let sizes: &[f64] =
            if full { &[0.05, 0.1, 0.2, 0.4, 0.75, 1.0, 1.5] } else { &[0.1, 0.3, 0.75, 1.5] };
        let bins: &[f64] = if full { &[0.15, 0.25, 0.35, 1.0] } else { &[0.15, 0.25, 1.0] };
        let base = if full { 600_000.0 } else { 200_000.0 };
        let of_sizes = sizes.iter().map(|&size| (size, BIN));
        let all = of_sizes.chain(bins.iter().map(|&bin| (SIZE, bin)));
        let scan = |(index, (maximum_displacement, bin)): (usize, (f64, f64))| {
            // Small moves relax as slowly as the square of their size.
            let slowness = (0.4 / maximum_displacement).clamp(1.0, 4.0);
            // Positive and small.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let sweeps = (base * slowness) as u64;
            Self { maximum_displacement, bin, sweeps, seed: seed.wrapping_add(77 + index as u64) }
        };
        all.enumerate().map(scan).collect()
    }

    /// One that was measured before.
    pub(crate) fn measured(maximum_displacement: f64, bin: f64) -> Self {
        Self { maximum_displacement, bin, sweeps: 0, seed: 0 }
    }

    /// What counting noise predicts.
    pub(crate) fn predicted(&self) -> Result<f64, Failure> {
        Ok(part_outside(self.maximum_displacement, self.bin) * full_bias(self.bin)?)
    }

    fn particles() -> usize {
        // A few hundred.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let particles = (COLUMN.spheres_per_area * WIDTH * WIDTH).round() as usize;
        particles
    }

    /// For the progress bar, in the unit of the other runs; local moves alone take less time.
    pub(crate) fn work(&self) -> u64 {
        self.sweeps * Self::particles() as u64 / 6000
    }

    /// P/(nTZ) − 1 over the range.
    pub(crate) fn run(&self, interrupt: &Interrupt, progress: &Progress) -> Result<Estimate, Failure> {
        let slab = Slab::new(COLUMN.height, WIDTH, WIDTH)?;
        let temperature = ExponentialTemperature::new(COLUMN.temperature, COLUMN.decay_rate)?;
        let scene = Scene::new(slab, Self::particles(), UniformField::default(), temperature)?;
        let moves = LocalMoves::new(self.maximum_displacement)?;
        let builder = Simulation::builder(scene).scheme(Instantaneous::new(self.bin)?).moves(moves);
        let mut simulation = builder.seed(self.seed).build()?;
        simulation.equilibrate(self.sweeps / 5, &mut ())?;
        let profile = EquationOfStateProfile::with_range(&slab, 0.5, 20.5, 200)?;
        let mut profile = Every::new(5, profile);
        let made = in_chunks(self.sweeps, interrupt, &Progress::hidden(), |sweeps| {
            progress.advance(sweeps * Self::particles() as u64 / 6000);
            simulation.run(sweeps, &mut profile)
        })?;
        if made < self.sweeps {
            return Err("interrupted".into());
        }
        let deviation =
            profile.observer.deviations_over(&[RANGE], |eta| ModifiedKolafa.compressibility_factor(eta))?;
        Ok(deviation[0])
    }
}

/// The bias of moves that cross any number of bins, over the range.
pub(crate) fn full_bias(bin: f64) -> Result<f64, Failure> {
    const POINTS: u32 = 24;
    let prediction = Prediction::new(COLUMN)?;
    let [low, high] = RANGE;
    let at = |point: u32| low + (high - low) * (f64::from(point) + 0.5) / f64::from(POINTS);
    Ok((0..POINTS).map(|point| prediction.deviation(WIDTH * WIDTH, bin, at(point))).sum::<f64>()
        / f64::from(POINTS))
}

pub(crate) fn table(scans: &[(Scan, Estimate)]) -> Result<Table, Failure> {
    let mut table = Table::new([
        "small column, instantaneous field: bins",
        "S",
        "P/(nTZ) − 1 in %",
        "predicted, %",
        "part of the way outside the own bin",
    ]);
    for (scan, deviation) in scans {
        let part = part_outside(scan.maximum_displacement, scan.bin);
        table.row(
            &scan.bin.to_string(),
            [
                scan.maximum_displacement.to_string(),
                super::percent(*deviation),
                format!("{:.2}", 100.0 * scan.predicted()?),
                format!("{part:.3}"),
            ],
        );
    }
    Ok(table)
}

pub(crate) fn write(scans: &[(Scan, Estimate)], directory: &Path) -> Result<(), Failure> {
    output::write_csv(
        &directory.join("moves_and_bins.csv"),
        "lengths in d",
        ["maximum_displacement", "bin", "deviation", "deviation_error", "part_outside"],
        scans.iter().map(|(scan, deviation)| {
            let part = part_outside(scan.maximum_displacement, scan.bin);
            [scan.maximum_displacement, scan.bin, deviation.mean, deviation.standard_error, part]
        }),
    )
}
