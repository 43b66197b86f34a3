//! Captions of the pictures of a study, used on the page of all figures.

use super::{Failure, output};
use std::path::Path;

/// Writes `captions.csv`: file and caption of each picture, in the order of the page.
pub fn write_captions(directory: &Path, captions: &[(String, String)]) -> Result<(), Failure> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(["file", "caption"])?;
    for (file, caption) in captions {
        writer.write_record([file, caption])?;
    }
    output::write(&directory.join("captions.csv"), writer.into_inner()?)
}
