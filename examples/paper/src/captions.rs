//! Captions of the pictures that a study draws, for whoever puts them on a page.

use super::{Failure, output};
use std::path::Path;

/// Writes `captions.csv`: the file of each picture, in the order in which they are to be seen, and
/// what it shows.
pub fn write_captions(directory: &Path, captions: &[(String, String)]) -> Result<(), Failure> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(["file", "caption"])?;
    for (file, caption) in captions {
        writer.write_record([file, caption])?;
    }
    output::write(&directory.join("captions.csv"), writer.into_inner()?)
}
