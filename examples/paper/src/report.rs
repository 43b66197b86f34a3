//! What a study leaves behind: tables, pictures with captions, and claims.

use super::captions::write_captions;
use super::figure::Figure;
use super::output::write_csv;
use super::verdict::Verdicts;
use super::{Ending, Failure, Session};
use std::path::PathBuf;

/// Pictures, captions and verdicts of one run.
#[derive(Debug)]
pub struct Report {
    pub directory: PathBuf,
    pub verdicts: Verdicts,
    /// Files of pictures, with their captions.
    captions: Vec<(String, String)>,
}

impl Report {
    pub fn new(session: &Session) -> Self {
        Self { directory: session.directory.clone(), verdicts: Verdicts::new(), captions: Vec::new() }
    }

    /// Saves a picture under this name and notes its caption.
    pub fn picture(&mut self, name: &str, figure: &Figure, caption: &str) -> Result<(), Failure> {
        figure.save(&self.directory.join(name))?;
        self.captions.push((format!("{name}.png"), caption.to_owned()));
        Ok(())
    }

    /// Writes a table under this name.
    pub fn table(
        &self,
        name: &str,
        units: &str,
        columns: &str,
        records: impl IntoIterator<Item = impl AsRef<[f64]>>,
    ) -> Result<(), Failure> {
        write_csv(&self.directory.join(name).with_extension("csv"), units, columns, records)
    }

    /// Writes and prints the claims, and writes the captions in the order of the pictures' names; how the study ends.
    pub fn finish(mut self) -> Result<Ending, Failure> {
        self.captions.sort();
        write_captions(&self.directory, &self.captions)?;
        self.verdicts.write_csv(&self.directory)?;
        println!("\n{}\nwritten to {}", self.verdicts, self.directory.display());
        Ok(self.verdicts.ending())
    }
}
