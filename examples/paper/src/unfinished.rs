//! The folder from which an interrupted study continues.

use super::{Failure, output};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::{self, File, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Name of the folder.
const NAME: &str = "unfinished";
const OPTIONS: &str = "options";
const LOCK: &str = "lock";

/// A folder with the checkpoints of runs and with results, for one process at a time.
#[derive(Debug)]
pub struct Unfinished {
    folder: PathBuf,
    /// Whether an interrupted study is continued.
    goes_on: bool,
    /// Lock against other processes, held until this is dropped.
    _lock: File,
}

impl Unfinished {
    /// Opens the folder of a study that writes to `directory`. `options` are all options on which
    /// the results depend. A folder of other options is refused, or removed if `fresh`.
    pub fn open(directory: &Path, options: &str, fresh: bool) -> Result<Self, Failure> {
        let folder = directory.join(NAME);
        output::create_directory(&folder)?;
        let path = folder.join(LOCK);
        let lock =
            File::create(&path).map_err(|error| format!("cannot write {}: {error}", path.display()))?;
        if let Err(TryLockError::WouldBlock) = lock.try_lock() {
            return Err(format!("another process writes to {}", directory.display()).into());
        }
        let path = folder.join(OPTIONS);
        if fresh {
            // Everything except the lock; the options last, so that an interrupted removal is
            // detected.
            for entry in fs::read_dir(&folder)? {
                let entry = entry?.path();
                if entry.is_dir() {
                    remove_directory(&entry)?;
                }
            }
            fs::remove_file(&path).ok();
        }
        let goes_on = match fs::read_to_string(&path) {
            Ok(text) if text == options => true,
            Ok(_) => {
                let path = path.display();
                return Err(format!(
                    "{path} is of a run with other options: use the same options, another --out, or --fresh"
                )
                .into());
            }
            Err(_) => {
                output::write(&path, options)?;
                false
            }
        };
        Ok(Self { folder, goes_on, _lock: lock })
    }

    /// Whether an interrupted study is continued.
    pub fn goes_on(&self) -> bool {
        self.goes_on
    }

    /// The folder of a task, by group of tasks and number.
    pub fn of_task(&self, what: &str, number: usize) -> PathBuf {
        self.folder.join(what.replace(' ', "_")).join(number.to_string())
    }

    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Whether no task has data.
    pub fn is_empty(&self) -> bool {
        let entries = fs::read_dir(&self.folder).into_iter().flatten().flatten();
        !entries.map(|entry| entry.path()).any(|path| path.is_dir())
    }

    /// Removes the folder of a complete study.
    pub fn remove(&self) -> Result<(), Failure> {
        remove_directory(&self.folder)
    }
}

fn remove_directory(path: &Path) -> Result<(), Failure> {
    match fs::remove_dir_all(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => {
            Err(format!("cannot remove {}: {error}", path.display()).into())
        }
        _ => Ok(()),
    }
}

/// The result stored in a folder by the same build of the program; otherwise makes the result and
/// stores it.
pub fn kept<Output: Serialize + DeserializeOwned>(
    folder: &Path,
    task: &str,
    make: impl FnOnce() -> Result<Output, Failure>,
) -> Result<Output, Failure> {
    let path = folder.join("result");
    let name = (task.to_owned(), this_build());
    if let Ok(bytes) = fs::read(&path)
        && let Ok((saved, rest)) = postcard::take_from_bytes::<(String, String)>(&bytes)
        && saved == name
        && let Ok(output) = postcard::from_bytes(rest)
    {
        return Ok(output);
    }
    let output = make()?;
    output::create_directory(folder)?;
    let mut bytes = postcard::to_allocvec(&name)?;
    bytes.extend(postcard::to_allocvec(&output)?);
    output::write(&path, bytes)?;
    Ok(output)
}

/// Identifies the build; another build may give other results.
fn this_build() -> String {
    let file = std::env::current_exe().and_then(fs::metadata);
    let described = file.and_then(|file| Ok((file.len(), file.modified()?)));
    described.map_or_else(|_| String::new(), |(length, time)| format!("{length} {time:?}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tempfile::tempdir;

    #[test]
    fn one_process_goes_on_with_the_same_options_and_others_are_refused() {
        let directory = tempdir().unwrap();
        let directory = directory.path();
        let first = Unfinished::open(directory, "seed 1", false).unwrap();
        assert!(!first.goes_on() && first.is_empty());
        let refused = Unfinished::open(directory, "seed 1", true).unwrap_err().to_string();
        assert!(refused.contains("another process"), "{refused}");
        fs::create_dir_all(first.of_task("two words", 3)).unwrap();
        assert!(!first.is_empty());
        drop(first);
        let refused = Unfinished::open(directory, "seed 2", false).unwrap_err().to_string();
        assert!(refused.contains("options") && refused.contains("--fresh"), "{refused}");
        let again = Unfinished::open(directory, "seed 1", false).unwrap();
        assert!(again.goes_on() && again.of_task("two words", 3).is_dir());
        drop(again);
        let fresh = Unfinished::open(directory, "seed 2", true).unwrap();
        assert!(!fresh.goes_on() && !fresh.of_task("two words", 3).exists());
        fresh.remove().unwrap();
        assert_eq!(fs::read_dir(directory).unwrap().count(), 0);
    }

    #[test]
    fn results_are_made_once_and_damaged_or_other_ones_again() {
        let folder = tempdir().unwrap();
        let folder = folder.path();
        let get = |task: &str, value: u64| kept(folder, task, || Ok((value, vec![f64::NAN]))).unwrap();
        assert!(kept::<f64>(folder, "a", || Err("broken".into())).is_err());
        assert_eq!(get("a", 1).0, 1);
        let again = get("a", 2);
        assert!(again.0 == 1 && again.1[0].is_nan());
        assert_eq!(get("b", 3).0, 3);
        let path = folder.join("result");
        let bytes = fs::read(&path).unwrap();
        fs::write(&path, &bytes[..bytes.len() - 1]).unwrap();
        assert_eq!(get("b", 4).0, 4);
    }
}
