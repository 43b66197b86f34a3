//! What each picture shows, in words, beside the pictures.

use crate::common::Failure;
use std::path::Path;

/// File names of pictures with their captions.
#[derive(Debug, Clone, Default)]
pub(crate) struct Captions(Vec<(String, String)>);

impl Captions {
    pub(crate) fn add(&mut self, file: &str, caption: &str) {
        self.0.push((file.to_owned(), caption.to_owned()));
    }

    /// Writes `captions.csv`: file, caption.
    pub(crate) fn write_csv(&self, directory: &Path) -> Result<(), Failure> {
        let mut writer = csv::Writer::from_path(directory.join("captions.csv"))?;
        writer.write_record(["file", "caption"])?;
        for (file, caption) in &self.0 {
            writer.write_record([file, caption])?;
        }
        writer.flush()?;
        Ok(())
    }
}
