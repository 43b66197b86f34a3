//! Results in the directory of a study: pictures with captions, verdicts, and printed output.

use gradient_mc::statistics::Estimate;
use paper::Failure;
use paper::verdict::Verdict;
use std::fs;
use std::path::Path;

/// What a study prints is kept under this name.
pub(crate) const REPORT: &str = "report.txt";

/// A picture and its caption.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Picture {
    /// Name of the PNG file.
    pub(crate) file: String,
    pub(crate) caption: String,
}

impl Picture {
    /// "Figure 14a" for `figure_14a.png`, and the name of any other file in words.
    pub(crate) fn title(&self) -> String {
        let Number { number, rest } = Number::of_file(&self.file);
        let separator = if rest.len() > 1 { ", " } else { "" };
        if self.file.starts_with("figure_") && number > 0 {
            format!("Figure {number}{separator}{rest}")
        } else {
            let words = self.file.trim_end_matches(".png").replace('_', " ");
            let (first, rest) = words.split_at(words.chars().next().map_or(0, char::len_utf8));
            format!("{}{rest}", first.to_uppercase())
        }
    }
}

/// Everything that a study has left.
#[derive(Debug, Clone, Default)]
pub(crate) struct Gathered {
    pub(crate) pictures: Vec<Picture>,
    pub(crate) verdicts: Vec<Verdict>,
    pub(crate) report: Option<String>,
    /// A remark that is not a failure.
    pub(crate) remark: Option<String>,
    /// What should be there and is not, in words.
    pub(crate) missing: Vec<String>,
}

impl Gathered {
    /// Reads the directory of a study. Missing results are listed and are no error.
    pub(crate) fn read(directory: &Path) -> Self {
        let mut gathered =
            Self { report: fs::read_to_string(directory.join(REPORT)).ok(), ..Self::default() };
        match captions(&directory.join("captions.csv")) {
            Ok(pictures) => gathered.pictures = pictures,
            Err(failure) => {
                // Pictures can be looked at without.
                gathered.remark = Some(format!("no captions: {failure}"));
                gathered.pictures = pictures_without_captions(directory);
            }
        }
        for picture in &gathered.pictures {
            if !directory.join(&picture.file).is_file() {
                gathered.missing.push(format!("picture {}", picture.file));
            }
        }
        match verdicts(&directory.join("verdicts.csv")) {
            Ok(verdicts) => gathered.verdicts = verdicts,
            Err(failure) => gathered.missing.push(format!("verdicts: {failure}")),
        }
        gathered
    }

    /// Whether everything is there and every claim holds. A study without a claim has shown
    /// nothing.
    pub(crate) fn holds(&self) -> bool {
        self.missing.is_empty() && !self.verdicts.is_empty() && self.verdicts.iter().all(Verdict::holds)
    }

    /// Number of claims that hold.
    pub(crate) fn held(&self) -> usize {
        self.verdicts.iter().filter(|verdict| verdict.holds()).count()
    }

    /// The verdicts that belong under each picture, and those that belong under none.
    pub(crate) fn by_picture(&self) -> (Vec<(&Picture, Vec<&Verdict>)>, Vec<&Verdict>) {
        let mut with_picture: Vec<(&Picture, Vec<&Verdict>)> =
            self.pictures.iter().map(|picture| (picture, Vec::new())).collect();
        let mut without = Vec::new();
        for verdict in &self.verdicts {
            let wanted = Number::of_figure(&verdict.figure);
            // The very panel, else any of the same figure.
            let of_picture = |picture: &Picture| Number::of_file(&picture.file);
            let place =
                with_picture.iter().position(|(picture, _)| of_picture(picture) == wanted).or_else(|| {
                    let number = wanted.number;
                    with_picture
                        .iter()
                        .position(|(picture, _)| number > 0 && of_picture(picture).number == number)
                });
            match place {
                Some(place) => with_picture[place].1.push(verdict),
                None => without.push(verdict),
            }
        }
        (with_picture, without)
    }
}

/// The number of a figure, and the text after the number: a letter, "inset", or nothing.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Number {
    /// Zero if there is none.
    number: u32,
    rest: String,
}

impl Number {
    /// Of `figure_07_inset.png`.
    fn of_file(file: &str) -> Self {
        let name = file.split('.').next().unwrap_or(file);
        Self::of_figure(name.strip_prefix("figure_").unwrap_or(name))
    }

    /// Of "7 inset", "14a" or "Fig. 3".
    fn of_figure(figure: &str) -> Self {
        let figure = figure.trim_start_matches(|character: char| !character.is_ascii_digit());
        let end = figure.find(|character: char| !character.is_ascii_digit()).unwrap_or(figure.len());
        let (number, rest) = figure.split_at(end);
        let rest = rest.trim_matches(|character: char| !character.is_alphanumeric()).to_lowercase();
        Self { number: number.parse().unwrap_or(0), rest }
    }
}

fn pictures_without_captions(directory: &Path) -> Vec<Picture> {
    let entries = fs::read_dir(directory).into_iter().flatten().flatten();
    let mut files: Vec<String> =
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    files.retain(|file| Path::new(file).extension().is_some_and(|extension| extension == "png"));
    files.sort();
    files.into_iter().map(|file| Picture { file, caption: String::new() }).collect()
}

fn reader(path: &Path) -> Result<csv::Reader<fs::File>, Failure> {
    csv::Reader::from_path(path).map_err(|error| format!("{}: {error}", path.display()).into())
}

fn captions(path: &Path) -> Result<Vec<Picture>, Failure> {
    let mut pictures = Vec::new();
    for record in reader(path)?.records() {
        let record = record?;
        let field = |index: usize| record.get(index).unwrap_or_default().to_owned();
        pictures.push(Picture { file: field(0), caption: field(1) });
    }
    Ok(pictures)
}

fn verdicts(path: &Path) -> Result<Vec<Verdict>, Failure> {
    let mut verdicts = Vec::new();
    for record in reader(path)?.records() {
        let record = record?;
        let field = |index: usize| record.get(index).ok_or("a verdict is incomplete");
        let number = |index: usize| -> Result<f64, Failure> { Ok(field(index)?.parse()?) };
        let verdict = Verdict {
            figure: field(0)?.to_owned(),
            claim: field(1)?.to_owned(),
            measured: Estimate::new(number(2)?, number(3)?),
            lowest: number(4)?,
            highest: number(5)?,
        };
        // Decided again from the numbers, as a check of the file.
        if verdict.holds().to_string() != field(6)? {
            return Err(format!("the verdict on \"{}\" contradicts its numbers", verdict.claim).into());
        }
        verdicts.push(verdict);
    }
    Ok(verdicts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use paper::captions::write_captions;
    use paper::verdict::Verdicts;
    use tempfile::tempdir;

    fn leave(directory: &Path, measured: f64) {
        let mut verdicts = Verdicts::new();
        verdicts.at_most("14a", "less than one, with \"quotes\", and commas", Estimate::new(0.5, 0.1), 1.0);
        verdicts.at_most("15", "less than one", Estimate::new(measured, f64::NAN), 1.0);
        verdicts.write_csv(directory).unwrap();
        let captions =
            ["figure_14a.png", "figure_14b.png", "figure_15.png"].map(|file| (file, file.to_owned()));
        for (file, _) in &captions {
            fs::write(directory.join(file), "").unwrap();
        }
        write_captions(directory, &captions.map(|(file, caption)| (file.to_owned(), caption))).unwrap();
    }

    #[test]
    fn what_was_written_is_read_and_one_failed_claim_fails_all() {
        let directory = tempdir().unwrap();
        let directory = directory.path();
        leave(directory, 0.9);
        let good = Gathered::read(directory);
        assert!(good.holds() && good.held() == 2 && good.pictures.len() == 3, "{good:?}");
        leave(directory, 1.1);
        let bad = Gathered::read(directory);
        assert!(!bad.holds() && bad.held() == 1);
        leave(directory, f64::NAN);
        assert!(!Gathered::read(directory).holds());
    }

    #[test]
    fn what_is_missing_or_tampered_with_does_not_hold() {
        let directory = tempdir().unwrap();
        let directory = directory.path();
        assert!(!Gathered::read(directory).holds());
        leave(directory, 0.9);
        fs::remove_file(directory.join("captions.csv")).unwrap();
        let bare = Gathered::read(directory);
        assert!(bare.holds() && bare.pictures.len() == 3 && bare.remark.is_some());
        leave(directory, 0.9);
        fs::remove_file(directory.join("figure_14b.png")).unwrap();
        assert_eq!(Gathered::read(directory).missing, ["picture figure_14b.png"]);
        leave(directory, 1.1);
        let path = directory.join("verdicts.csv");
        fs::write(&path, fs::read_to_string(&path).unwrap().replace("false", "true")).unwrap();
        assert!(!Gathered::read(directory).holds());
    }

    #[test]
    fn verdicts_stand_under_their_pictures() {
        let picture = |file: &str| Picture { file: file.to_owned(), caption: String::new() };
        let verdict = |figure: &str| Verdict {
            figure: figure.to_owned(),
            claim: String::new(),
            measured: Estimate::exact(0.0),
            lowest: -1.0,
            highest: 1.0,
        };
        let gathered = Gathered {
            pictures: ["figure_07.png", "figure_07_inset.png", "figure_08a.png"].map(picture).to_vec(),
            verdicts: ["7", "7 inset", "8a", "8b", "9", "crystal"].map(verdict).to_vec(),
            ..Gathered::default()
        };
        let (with_picture, without) = gathered.by_picture();
        let figures = |verdicts: &[&Verdict]| -> Vec<String> {
            verdicts.iter().map(|verdict| verdict.figure.clone()).collect()
        };
        let under: Vec<Vec<String>> = with_picture.iter().map(|(_, verdicts)| figures(verdicts)).collect();
        assert_eq!(under, [vec!["7"], vec!["7 inset"], vec!["8a", "8b"]]);
        assert_eq!(figures(&without), ["9", "crystal"]);
        let titles: Vec<String> = gathered.pictures.iter().map(Picture::title).collect();
        assert_eq!(titles, ["Figure 7", "Figure 7, inset", "Figure 8a"]);
        assert_eq!(picture("layered_base.png").title(), "Layered base");
    }
}
