//! Files that an example writes.

use super::Failure;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::Path;

/// Creates a directory with its parents; the error names it.
pub fn create_directory(path: &Path) -> Result<(), Failure> {
    fs::create_dir_all(path).map_err(|error| format!("cannot create {}: {error}", path.display()).into())
}

/// Writes a CSV file: a comment line with the units, a header, and one row per record.
pub fn write_csv<const COLUMNS: usize>(
    path: &Path,
    units: &str,
    header: [&str; COLUMNS],
    records: impl IntoIterator<Item = [f64; COLUMNS]>,
) -> Result<(), Failure> {
    let file = File::create(path).map_err(|error| format!("cannot write {}: {error}", path.display()))?;
    let mut file = BufWriter::new(file);
    writeln!(file, "# {units}")?;
    let mut writer = csv::Writer::from_writer(file);
    writer.write_record(header)?;
    for record in records {
        writer.write_record(record.map(short))?;
    }
    writer.flush()?;
    Ok(())
}

/// Nine significant digits, without trailing zeros; more would only be noise.
fn short(value: f64) -> String {
    let rounded = format!("{value:.8e}").parse().unwrap_or(value);
    format!("{rounded}")
}
