//! Dependence of the bias on the bin width and on the number of bins that a move crosses, in a
//! small column with local moves.

use super::prediction::{Prediction, part_outside};
use super::run::Column;
use gradient_mc::drive::Instantaneous;
use gradient_mc::equation_of_state::ModifiedKolafa;
use gradient_mc::field::UniformField;
use gradient_mc::moves::LocalMoves;
use gradient_mc::observers::{Bins, EquationOfStateProfile};
use gradient_mc::statistics::Estimate;
use gradient_mc::temperature::ExponentialTemperature;
use gradient_mc::{Every, Scene, Simulation, Slab};
use paper::row;
use paper::study::count;
use paper::table::{Table, percent};
use paper::{Failure, Report, Session, Watch};

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

    pub(crate) fn all(full: bool, session: &Session) -> Vec<Self> {
        let sizes: &[f64] =
            if full { &[0.05, 0.1, 0.2, 0.4, 0.75, 1.0, 1.5] } else { &[0.1, 0.3, 0.75, 1.5] };
        let bins: &[f64] = if full { &[0.15, 0.25, 0.35, 1.0] } else { &[0.15, 0.25, 1.0] };
        let base = session.choose(if full { 600_000.0 } else { 200_000.0 }, 1000.0);
        let of_sizes = sizes.iter().map(|&size| (size, BIN));
        let all = of_sizes.chain(bins.iter().map(|&bin| (SIZE, bin)));
        let scan = |(index, (maximum_displacement, bin)): (usize, (f64, f64))| {
            // Small moves relax as slowly as the square of their size.
            let slowness = (0.4 / maximum_displacement).clamp(1.0, 4.0);
            let sweeps = count((base * slowness).floor()) as u64;
            Self { maximum_displacement, bin, sweeps, seed: session.seed.wrapping_add(77 + index as u64) }
        };
        all.enumerate().map(scan).collect()
    }

    /// The prediction by counting noise.
    pub(crate) fn predicted(&self) -> Result<f64, Failure> {
        Ok(part_outside(self.maximum_displacement, self.bin) * full_bias(self.bin)?)
    }

    fn particles() -> usize {
        count(COLUMN.spheres_per_area * WIDTH * WIDTH)
    }

    /// For the progress bar, in the units of the other runs; local moves alone take less time.
    pub(crate) fn work(&self) -> u64 {
        self.sweeps * Self::particles() as u64
    }

    /// P/(nTZ) − 1 over the range.
    pub(crate) fn run(&self, watch: &Watch<'_>) -> Result<Estimate, Failure> {
        let slab = Slab::new(COLUMN.height, WIDTH, WIDTH)?;
        let temperature = ExponentialTemperature::new(COLUMN.temperature, COLUMN.decay_rate)?;
        let scene = Scene::new(slab, Self::particles(), UniformField::default(), temperature)?;
        let moves = LocalMoves::new(self.maximum_displacement)?;
        let builder = Simulation::builder(scene).scheme(Instantaneous::new(self.bin)?).moves(moves);
        let mut simulation = builder.seed(self.seed).build()?;
        watch.equilibrate(&mut simulation, self.sweeps / 5, 0, &mut ())?;
        let profile = EquationOfStateProfile::new(&slab, Bins::count(200).from(0.5).to(20.5))?;
        let mut profile = Every::new(5, profile);
        let size = Self::particles() as u64;
        watch.run(&mut simulation, self.sweeps, size, &mut profile)?;
        let deviation = profile.observer.deviations_over(&[RANGE], &ModifiedKolafa)?;
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
                percent(*deviation),
                format!("{:.2}", 100.0 * scan.predicted()?),
                format!("{part:.3}"),
            ],
        );
    }
    Ok(table)
}

pub(crate) fn write(scans: &[(Scan, Estimate)], report: &Report) -> Result<(), Failure> {
    report.table(
        "moves_and_bins",
        "lengths in d",
        "maximum_displacement, bin, deviation, deviation_error, part_outside",
        scans.iter().map(|(scan, deviation)| {
            let part = part_outside(scan.maximum_displacement, scan.bin);
            row![scan.maximum_displacement, scan.bin, deviation, part]
        }),
    )
}
