//! What an earlier run wrote, read again for the picture.

use super::Drawn;
use super::run::{Band, MEASURING_BINS, MovesChoice, SchemeChoice, Setup, Side};
use super::scan::Scan;
use gradient_mc::statistics::Estimate;
use paper::Failure;
use std::path::Path;

fn rows<const COLUMNS: usize>(path: &Path) -> Result<Vec<[f64; COLUMNS]>, Failure> {
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .from_path(path)
        .map_err(|error| format!("cannot read {}: {error}", path.display()))?;
    reader
        .deserialize::<Vec<f64>>()
        .map(|row| {
            let row = row?;
            let columns = row.len();
            row.try_into().map_err(|_| format!("{}: {columns} columns, not {COLUMNS}", path.display()).into())
        })
        .collect()
}

/// The runs, as measured in the first of [`MEASURING_BINS`].
pub(crate) fn runs(directory: &Path) -> Result<Vec<Drawn>, Failure> {
    let mut runs: Vec<Drawn> = Vec::new();
    let mut before = None;
    for row in rows::<10>(&directory.join("seven_per_cent.csv"))? {
        let [scheme, side, area, acceptance_bin, measuring_bin, displacement, height, mean, error, _] = row;
        if (measuring_bin - MEASURING_BINS[0]).abs() > 1e-9 {
            continue;
        }
        let run = [scheme, side, area, acceptance_bin, displacement].map(f64::to_bits);
        if before != Some(run) {
            before = Some(run);
            let schemes = [
                SchemeChoice::Instantaneous,
                SchemeChoice::RunningAverage,
                SchemeChoice::AveragedThenFrozen,
                SchemeChoice::Closure,
                SchemeChoice::SelfConsistent,
            ];
            let known =
                schemes.into_iter().find(|known| f64::from(*known as u8).to_bits() == scheme.to_bits());
            let setup = Setup {
                scheme: known.ok_or_else(|| format!("there is no scheme {scheme}"))?,
                area,
                acceptance_bin,
                moves: if displacement > 0.0 {
                    MovesChoice::Local(displacement)
                } else {
                    MovesChoice::Chains
                },
                side: if side > 0.5 { Side::Below } else { Side::Above },
                equilibration: 0,
                sweeps: 0,
                seed: 0,
            };
            runs.push((setup, Vec::new()));
        }
        if let Some((_, bands)) = runs.last_mut() {
            bands.push(Band { height, deviation: Estimate::new(mean, error) });
        }
    }
    Ok(runs)
}

pub(crate) fn scans(directory: &Path) -> Result<Vec<(Scan, Estimate)>, Failure> {
    let rows = rows::<5>(&directory.join("moves_and_bins.csv"))?;
    let scan = |[displacement, bin, mean, error, _]: [f64; 5]| {
        (Scan::measured(displacement, bin), Estimate::new(mean, error))
    };
    Ok(rows.into_iter().map(scan).collect())
}
