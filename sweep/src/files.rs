//! The folder of a sweep: what stands where, and files that are there as a whole or not at all.

use crate::Failure;
use crate::case::Case;
use gradient_mc::Warning;
use serde::{Deserialize, Serialize};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The folder of a sweep, which all ranks see.
#[derive(Debug, Clone)]
pub struct Folder(PathBuf);

/// That a replica is finished, and what only its process knew.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Record {
    /// Of the [`Case`], as it was then.
    pub identity: String,
    /// Sweeps of measurement.
    pub sweeps: u64,
    /// What speaks against the run.
    pub warnings: Vec<Noted>,
}

/// A warning as it is kept.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Noted {
    /// What it is about.
    pub kind: String,
    /// With its numbers.
    pub text: String,
}

impl From<&Warning> for Noted {
    fn from(warning: &Warning) -> Self {
        Self { kind: warning.kind().to_string(), text: warning.to_string() }
    }
}

impl Folder {
    /// Makes the folder if there is none.
    ///
    /// # Errors
    /// [`Failure::File`].
    pub fn new(path: &Path) -> Result<Self, Failure> {
        let tasks = path.join("tasks");
        fs::create_dir_all(&tasks).map_err(|source| Failure::File { path: tasks, source })?;
        Ok(Self(path.into()))
    }

    /// A file of a replica.
    fn of(&self, case: &Case, replica: usize, suffix: &str) -> PathBuf {
        self.0.join("tasks").join(format!("{}_{replica}{suffix}", case.name))
    }

    /// The checkpoint of a replica.
    #[must_use]
    pub fn checkpoint(&self, case: &Case, replica: usize) -> PathBuf {
        self.of(case, replica, "")
    }

    /// The record of a replica that is finished. One of another table, or one that cannot be read,
    /// is none.
    #[must_use]
    pub fn record(&self, case: &Case, replica: usize) -> Option<Record> {
        let text = fs::read_to_string(self.of(case, replica, ".finished")).ok()?;
        let record: Record = toml::from_str(&text).ok()?;
        (record.identity == case.identity(replica)).then_some(record)
    }

    /// Notes that a replica is finished.
    ///
    /// # Errors
    /// [`Failure::File`].
    pub fn finish(&self, case: &Case, replica: usize, record: &Record) -> Result<(), Failure> {
        let path = self.of(case, replica, ".finished");
        match toml::to_string(record) {
            Ok(text) => write(&path, text),
            Err(error) => Err(Failure::File { path, source: io::Error::other(error) }),
        }
    }

    /// A table of results.
    #[must_use]
    pub fn results(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

/// Writes a file that is there as a whole or as it was.
pub(crate) fn write(path: &Path, bytes: impl AsRef<[u8]>) -> Result<(), Failure> {
    let mut new = path.as_os_str().to_owned();
    new.push(".new");
    fs::write(&new, bytes)
        .and_then(|()| fs::rename(&new, path))
        .map_err(|source| Failure::File { path: path.into(), source })
}
