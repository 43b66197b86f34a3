//! What all figures have in common: where they go, and what they claim.

use super::protocol::TEMPERATURES;
use paper::Failure;
use paper::captions::write_captions;
use paper::figure::RGBColor;
use paper::figure::{Figure, Place, colors};
use paper::output::write_csv;
use paper::verdict::Verdicts;
use std::path::PathBuf;

/// Pictures, captions and verdicts of one run.
#[derive(Debug)]
pub(crate) struct Report {
    pub(crate) directory: PathBuf,
    pub(crate) verdicts: Verdicts,
    /// Files of pictures, with their captions.
    captions: Vec<(String, String)>,
}

impl Report {
    pub(crate) fn new(directory: PathBuf) -> Self {
        Self { directory, verdicts: Verdicts::new(), captions: Vec::new() }
    }

    /// Saves a picture under this name and notes its caption.
    pub(crate) fn picture(&mut self, name: &str, figure: &Figure, caption: &str) -> Result<(), Failure> {
        figure.save(&self.directory.join(name))?;
        self.captions.push((format!("{name}.png"), caption.to_owned()));
        Ok(())
    }

    /// Writes a table under this name.
    pub(crate) fn table<const COLUMNS: usize>(
        &self,
        name: &str,
        units: &str,
        header: [&str; COLUMNS],
        records: impl IntoIterator<Item = [f64; COLUMNS]>,
    ) -> Result<(), Failure> {
        write_csv(&self.directory.join(name).with_extension("csv"), units, header, records)
    }

    pub(crate) fn finish(&self) -> Result<(), Failure> {
        write_captions(
            &self.directory,
            self.captions.iter().map(|(file, caption)| (file.as_str(), caption.clone())),
        )?;
        self.verdicts.write_csv(&self.directory)
    }
}

/// Color of a temperature in all figures.
pub(crate) fn color_of(temperature: f64) -> RGBColor {
    const COLORS: [RGBColor; 4] = [colors::BLUE, colors::VERMILION, colors::PURPLE, colors::GREEN];
    let known = TEMPERATURES.iter().position(|&tabulated| tabulated == temperature);
    known.map_or(colors::INK, |number| COLORS[number])
}

/// A place that fills the picture below its title.
pub(crate) const WHOLE: Place = Place { left: 0.0, top: 0.07, width: 1.0, height: 0.93 };
