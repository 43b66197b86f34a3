//! Files that an example writes.

use super::Failure;
use gradient_mc::statistics::Estimate;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::Path;

/// Creates a directory with its parents; the error names it.
pub fn create_directory(path: &Path) -> Result<(), Failure> {
    fs::create_dir_all(path).map_err(|error| format!("cannot create {}: {error}", path.display()).into())
}

/// Writes a CSV file: a comment line with the units, the names of the columns (between commas), and one row per record. A record
/// of another length is an error.
pub fn write_csv(
    path: &Path,
    units: &str,
    columns: &str,
    records: impl IntoIterator<Item = impl AsRef<[f64]>>,
) -> Result<(), Failure> {
    let file = File::create(path).map_err(|error| format!("cannot write {}: {error}", path.display()))?;
    let mut file = BufWriter::new(file);
    writeln!(file, "# {units}")?;
    let mut writer = csv::Writer::from_writer(file);
    writer.write_record(columns.split(',').map(str::trim))?;
    for record in records {
        writer.write_record(record.as_ref().iter().map(|&value| short(value)))?;
    }
    writer.flush()?;
    Ok(())
}

/// Reads what [`write_csv`] wrote: all rows, which have so many numbers.
pub fn read_csv<const COLUMNS: usize>(text: &str) -> Result<Vec<[f64; COLUMNS]>, Failure> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    let rows = reader.deserialize::<Vec<f64>>().map(|row| {
        let row = row?;
        let found = row.len();
        row.try_into().map_err(|_| format!("a row of {found} numbers, not {COLUMNS}").into())
    });
    rows.collect()
}

/// What stands in a row: a number, or an estimate, which takes two columns, mean and standard error.
pub trait Cell {
    fn push(&self, row: &mut Vec<f64>);
}

impl Cell for f64 {
    fn push(&self, row: &mut Vec<f64>) {
        row.push(*self);
    }
}

impl Cell for Estimate {
    fn push(&self, row: &mut Vec<f64>) {
        row.extend([self.mean, self.standard_error]);
    }
}

impl<C: Cell> Cell for &C {
    fn push(&self, row: &mut Vec<f64>) {
        (**self).push(row);
    }
}

/// A row of a CSV file, of [cells](crate::output::Cell): `row![height, number_density]`.
#[macro_export]
macro_rules! row {
    ($($cell:expr),* $(,)?) => {{
        let mut row = Vec::new();
        $($crate::output::Cell::push(&$cell, &mut row);)*
        row
    }};
}

/// Nine significant digits, without trailing zeros; more would only be noise.
fn short(value: f64) -> String {
    let rounded = format!("{value:.8e}").parse().unwrap_or(value);
    format!("{rounded}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_again_with_nine_digits() {
        let path = std::env::temp_dir().join(format!("paper_output_{}.csv", std::process::id()));
        let rows = [row![1.0, Estimate::new(0.1 + 0.2, 1e-7 / 3.0)], row![2.0, 3.0, f64::NAN]];
        write_csv(&path, "units", "height, density, error", rows).unwrap();
        let text = fs::read_to_string(&path).unwrap();
        assert_eq!(text, "# units\nheight,density,error\n1,0.3,0.0000000333333333\n2,3,NaN\n");
        let read = read_csv::<3>(&text).unwrap();
        assert!((read[0][1] - 0.3).abs() < 1e-15 && read[1][2].is_nan() && read.len() == 2);
        assert!(read_csv::<2>(&text).is_err());
        assert!(write_csv(&path, "units", "height, density", [[1.0]]).is_err());
        assert!(write_csv(&path.join("nowhere"), "units", "height", [[1.0]]).is_err());
        fs::remove_file(path).unwrap();
    }
}
