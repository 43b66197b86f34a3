//! How the bias grows with the number of bins that a move crosses: a small column, swept by local moves of many sizes.

use super::prediction::part_outside;
use crate::common::Failure;
use crate::common::interrupt::Interrupt;
use crate::common::output;
use crate::common::progress::Progress;
use crate::common::replicas::in_chunks;
use crate::common::table::Table;
use gradient_mc::drive::Instantaneous;
use gradient_mc::equation_of_state::{EquationOfState, ModifiedKolafa, packing_fraction};
use gradient_mc::field::UniformField;
use gradient_mc::moves::LocalMoves;
use gradient_mc::observers::{BinState, EquationOfStateProfile};
use gradient_mc::statistics::Estimate;
use gradient_mc::temperature::ExponentialTemperature;
use gradient_mc::{Every, Scene, Simulation, Slab};
use std::path::Path;

/// A column so low that local moves of any size relax it.
const TEMPERATURE: f64 = 4.0;
const DECAY_RATE: f64 = 0.12;
const COLUMN_DENSITY: f64 = 6.0;
const WIDTH: f64 = 7.0;
const HEIGHT: f64 = 40.0;
/// Bins of the density that enters the field.
pub(crate) const BIN: f64 = 0.5;
/// Heights over which the deviation is averaged.
const RANGE: [f64; 2] = [3.0, 9.0];

/// One size of local moves.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scan {
    pub(crate) maximum_displacement: f64,
    sweeps: u64,
    seed: u64,
}

impl Scan {
    pub(crate) fn all(full: bool, seed: u64) -> Vec<Self> {
        let sizes: &[f64] =
            if full { &[0.05, 0.1, 0.2, 0.4, 0.8, 1.2, 1.6, 2.4, 3.2] } else { &[0.1, 0.3, 1.0, 3.0] };
        let base = if full { 600_000 } else { 60_000 };
        let scan = |(index, &maximum_displacement): (usize, &f64)| {
            // Small moves relax as slowly as the square of their size.
            let slowness = (0.4 / maximum_displacement).clamp(1.0, 4.0);
            // Positive and small.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let sweeps = (f64::from(base) * slowness) as u64;
            Self { maximum_displacement, sweeps, seed: seed.wrapping_add(77 + index as u64) }
        };
        sizes.iter().enumerate().map(scan).collect()
    }

    fn particles() -> usize {
        // A few hundred.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let particles = (COLUMN_DENSITY * WIDTH * WIDTH).round() as usize;
        particles
    }

    /// For the progress bar, in the unit of the other runs; local moves alone take less time.
    pub(crate) fn work(&self) -> u64 {
        self.sweeps * Self::particles() as u64 / 6000
    }

    /// P/(nTZ) − 1 over the range.
    pub(crate) fn run(&self, interrupt: &Interrupt, progress: &Progress) -> Result<Estimate, Failure> {
        let slab = Slab::new(HEIGHT, WIDTH, WIDTH)?;
        let temperature = ExponentialTemperature::new(TEMPERATURE, DECAY_RATE)?;
        let scene = Scene::new(slab, Self::particles(), UniformField::default(), temperature)?;
        let moves = LocalMoves::new(self.maximum_displacement, &slab)?;
        let builder = Simulation::builder(scene).scheme(Instantaneous::new(BIN)).moves(moves);
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
        let theory = |state: &BinState| {
            let factor = ModifiedKolafa.compressibility_factor(packing_fraction(state.number_density));
            state.number_density * state.temperature * factor
        };
        let deviation = profile.observer.jackknife(|states| {
            let [low, high] = RANGE;
            let inside = || states.iter().filter(|state| (low..high).contains(&state.height));
            [inside().map(|state| state.pressure).sum::<f64>() / inside().map(theory).sum::<f64>() - 1.0]
        })?;
        Ok(deviation[0])
    }
}

/// The bias of moves that cross any number of bins: what the largest ones have, over the part of their way that is
/// outside.
pub(crate) fn full_bias(scans: &[(Scan, Estimate)]) -> f64 {
    let large = scans.iter().filter(|(scan, _)| scan.maximum_displacement >= 1.0);
    let (sum, count) = large.fold((0.0, 0.0), |(sum, count), (scan, deviation)| {
        (sum + deviation.mean / part_outside(scan.maximum_displacement, BIN), count + 1.0)
    });
    sum / f64::max(count, 1.0)
}

pub(crate) fn table(scans: &[(Scan, Estimate)]) -> Table {
    let mut table = Table::new([
        "small column, instantaneous field, bins 0.5: S",
        "P/(nTZ) − 1 in %",
        "part of the way outside the own bin",
        "that part of the bias of large moves, %",
    ]);
    let full = full_bias(scans);
    for (scan, deviation) in scans {
        let part = part_outside(scan.maximum_displacement, BIN);
        table.row(
            &format!("{}", scan.maximum_displacement),
            [super::percent(*deviation), format!("{part:.3}"), format!("{:.2}", 100.0 * part * full)],
        );
    }
    table
}

pub(crate) fn write(scans: &[(Scan, Estimate)], directory: &Path) -> Result<(), Failure> {
    output::write_csv(
        &directory.join("moves_and_bins.csv"),
        "lengths in d",
        ["maximum_displacement", "bin", "deviation", "deviation_error", "part_outside"],
        scans.iter().map(|(scan, deviation)| {
            let part = part_outside(scan.maximum_displacement, BIN);
            [scan.maximum_displacement, BIN, deviation.mean, deviation.standard_error, part]
        }),
    )
}
