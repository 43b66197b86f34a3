//! Files that an example writes.

use super::Failure;
use gradient_mc::statistics::Estimate;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Creates a directory with its parents, and checks that files can be written to it.
pub fn create_directory(path: &Path) -> Result<(), Failure> {
    fs::create_dir_all(path).map_err(|error| format!("cannot create {}: {error}", path.display()))?;
    let probe = path.join(format!("probe.{}", std::process::id()));
    let probed = fs::write(&probe, "probe");
    fs::remove_file(&probe).ok();
    probed.map_err(|error| format!("cannot write to {}: {error}", path.display()).into())
}

/// Writes a file completely or not at all.
pub fn write(path: &Path, bytes: impl AsRef<[u8]>) -> Result<(), Failure> {
    write_by(path, |new| Ok(fs::write(new, bytes)?))
}

/// The same for a file that `write` writes, under a temporary name with the same extension.
pub fn write_by(path: &Path, write: impl FnOnce(&Path) -> Result<(), Failure>) -> Result<(), Failure> {
    let mut name = PathBuf::from(path).with_extension("new").into_os_string();
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    let new = PathBuf::from(name);
    let written = write(&new).and_then(|()| Ok(fs::rename(&new, path)?));
    written.map_err(|error| {
        fs::remove_file(&new).ok();
        format!("cannot write {}: {error}", path.display()).into()
    })
}

/// Writes a CSV file: a comment line with the units, the names of the columns (between commas), and
/// one row per record. A record of another length is an error.
pub fn write_csv(
    path: &Path,
    units: &str,
    columns: &str,
    records: impl IntoIterator<Item = impl AsRef<[f64]>>,
) -> Result<(), Failure> {
    let mut text = Vec::new();
    writeln!(text, "# {units}")?;
    let mut writer = csv::Writer::from_writer(text);
    writer.write_record(columns.split(',').map(str::trim))?;
    for record in records {
        writer.write_record(record.as_ref().iter().map(|&value| short(value)))?;
    }
    write(path, writer.into_inner()?)
}

/// Reads all rows of a file by [`write_csv`], with this number of columns.
pub fn read_csv<const COLUMNS: usize>(text: &str) -> Result<Vec<[f64; COLUMNS]>, Failure> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    let rows = reader.deserialize::<Vec<f64>>().map(|row| {
        let row = row?;
        let found = row.len();
        row.try_into().map_err(|_| format!("a row of {found} numbers, not {COLUMNS}").into())
    });
    rows.collect()
}

/// An entry of a row: a number, or an estimate with two columns, mean and standard error.
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

/// Nine significant digits without trailing zeros.
fn short(value: f64) -> String {
    let rounded = format!("{value:.8e}").parse().unwrap_or(value);
    format!("{rounded}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use tempfile::tempdir;

    #[test]
    fn what_is_written_is_read_again_with_nine_digits() {
        let directory = tempdir().unwrap();
        let path = directory.path().join("table.csv");
        let rows = [row![1.0, Estimate::new(0.1 + 0.2, 1e-7 / 3.0)], row![2.0, 3.0, f64::NAN]];
        write_csv(&path, "units", "height, density, error", rows).unwrap();
        let text = fs::read_to_string(&path).unwrap();
        assert_eq!(text, "# units\nheight,density,error\n1,0.3,0.0000000333333333\n2,3,NaN\n");
        let read = read_csv::<3>(&text).unwrap();
        assert!((read[0][1] - 0.3).abs() < 1e-15 && read[1][2].is_nan() && read.len() == 2);
        assert!(read_csv::<2>(&text).is_err());
        assert!(write_csv(&path, "units", "height, density", [[1.0]]).is_err());
        assert!(write_csv(&path.join("nowhere"), "units", "height", [[1.0]]).is_err());
    }

    #[test]
    fn a_file_is_there_as_a_whole_or_as_it_was() {
        let directory = tempdir().unwrap();
        let directory = directory.path();
        let path = directory.join("picture.png");
        write(&path, "before").unwrap();
        let half = |new: &Path| {
            assert_eq!(new.extension(), path.extension());
            fs::write(new, "ha")?;
            Err("no room".into())
        };
        let failure = write_by(&path, half).unwrap_err().to_string();
        assert!(failure.contains("picture.png") && failure.ends_with("no room"), "{failure}");
        assert_eq!(fs::read_to_string(&path).unwrap(), "before");
        assert_eq!(fs::read_dir(directory).unwrap().count(), 1);
        // Not a directory.
        let refused = create_directory(&path).unwrap_err().to_string();
        assert!(refused.contains("picture.png"), "{refused}");
    }
}
