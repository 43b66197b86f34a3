//! The folder of a parameter sweep and its files, which are written completely or not at all.

use crate::Failure;
use crate::case::Case;
use gradient_mc::Warning;
use serde::{Deserialize, Serialize};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The folder of a parameter sweep, shared by all ranks.
#[derive(Debug, Clone)]
pub struct Folder(PathBuf);

/// Record of a finished replica.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Record {
    /// Parameters of the replica, by [`Case::identity`].
    pub identity: String,
    /// Number of sweeps of production.
    pub sweeps: u64,
    /// Warnings about the run.
    pub warnings: Vec<Noted>,
}

/// A warning as text.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Noted {
    /// Kind of the warning.
    pub kind: String,
    /// The warning with its numbers.
    pub text: String,
}

impl From<&Warning> for Noted {
    fn from(warning: &Warning) -> Self {
        Self { kind: warning.kind().to_string(), text: warning.to_string() }
    }
}

impl Folder {
    /// Opens the folder, and creates it if needed.
    ///
    /// # Errors
    /// [`Failure::File`] if it cannot be written.
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

    /// The record of a finished replica. `None` if it is missing, unreadable or of another table.
    #[must_use]
    pub fn record(&self, case: &Case, replica: usize) -> Option<Record> {
        let text = fs::read_to_string(self.of(case, replica, ".finished")).ok()?;
        let record: Record = toml::from_str(&text).ok()?;
        (record.identity == case.identity(replica)).then_some(record)
    }

    /// Writes the record of a finished replica.
    ///
    /// # Errors
    /// [`Failure::File`] if it cannot be written.
    pub fn finish(&self, case: &Case, replica: usize, record: &Record) -> Result<(), Failure> {
        let path = self.of(case, replica, ".finished");
        match toml::to_string(record) {
            Ok(text) => write(&path, text),
            Err(error) => Err(Failure::File { path, source: io::Error::other(error) }),
        }
    }

    /// Path of a table of results.
    #[must_use]
    pub fn results(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

/// Writes a file completely, or leaves it unchanged.
pub(crate) fn write(path: &Path, bytes: impl AsRef<[u8]>) -> Result<(), Failure> {
    let mut new = path.as_os_str().to_owned();
    new.push(".new");
    fs::write(&new, bytes)
        .and_then(|()| fs::rename(&new, path))
        .map_err(|source| Failure::File { path: path.into(), source })
}
