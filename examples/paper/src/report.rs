//! The output of a study: tables, pictures with captions, and claims.

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

    /// Saves a picture under this name, with its caption.
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

    /// Writes and prints the claims, and writes the captions in the order of the names of the
    /// pictures. Returns how the study ended.
    pub fn finish(mut self) -> Result<Ending, Failure> {
        self.captions.sort();
        write_captions(&self.directory, &self.captions)?;
        self.verdicts.write_csv(&self.directory)?;
        println!("\n{}\nwritten to {}", self.verdicts, self.directory.display());
        Ok(self.verdicts.ending())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::{Axis, Panel, Place};
    use gradient_mc::statistics::Estimate;
    use tempfile::tempdir;

    #[test]
    fn a_report_leaves_tables_pictures_captions_and_claims() {
        let directory = tempdir().unwrap();
        let directory = directory.path();
        let session = Session::silent(directory, 1);
        let mut report = Report::new(&session);
        let place = Place { left: 0.0, top: 0.0, width: 1.0, height: 1.0 };
        let panel = Panel::new(place, Axis::new("x", 0.0, 1.0), Axis::new("y", 0.0, 1.0));
        let figure = Figure::new("nothing").with_size(60, 40).panel(panel);
        report.picture("figure_2", &figure, "the second").unwrap();
        report.picture("figure_1", &figure, "the first, \"quoted\"").unwrap();
        report.table("table", "units", "a, b", [[1.0, 2.0]]).unwrap();
        report.verdicts.at_most("1", "small", Estimate::new(1.0, 0.1), 0.5);
        assert_eq!(report.finish().unwrap(), Ending::ClaimFailed);
        let text = |name: &str| std::fs::read_to_string(directory.join(name)).unwrap();
        assert_eq!(
            text("captions.csv"),
            "file,caption\nfigure_1.png,\"the first, \"\"quoted\"\"\"\nfigure_2.png,the second\n"
        );
        assert!(text("verdicts.csv").ends_with("1,small,1,0.1,-inf,0.5,false\n"));
        assert_eq!(text("table.csv"), "# units\na,b\n1,2\n");
        assert!(text("figure_1.svg").contains("<svg") && directory.join("figure_2.png").is_file());
    }
}
