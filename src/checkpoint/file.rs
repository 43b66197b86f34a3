//! Files of snapshots: format, writing and reading.

use super::Snapshot;
use crate::Error;
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

const MAGIC: &[u8; 8] = b"gmc-ckpt";
/// Version of the format; it changes whenever the meaning of a file changes.
const VERSION: u32 = 1;
/// Magic, version, checksum and length.
const HEAD: usize = 8 + 4 + 4 + 8;

/// Writes the bytes of a file.
pub(super) struct Writer(Vec<u8>);

impl Writer {
    /// Makes a writer for pieces of `size` bytes in total.
    pub(super) fn new(size: usize) -> Self {
        let mut bytes = Vec::with_capacity(HEAD + 6 * 8 + size);
        bytes.resize(HEAD, 0);
        Self(bytes)
    }

    pub(super) fn number(&mut self, number: u64) {
        self.0.extend_from_slice(&number.to_le_bytes());
    }

    pub(super) fn piece(&mut self, bytes: &[u8]) {
        self.number(bytes.len() as u64);
        self.0.extend_from_slice(bytes);
    }

    pub(super) fn finish(self) -> Vec<u8> {
        let Self(mut bytes) = self;
        let length = (bytes.len() - HEAD) as u64;
        bytes[..8].copy_from_slice(MAGIC);
        bytes[8..12].copy_from_slice(&VERSION.to_le_bytes());
        bytes[16..HEAD].copy_from_slice(&length.to_le_bytes());
        let checksum = crc32fast::hash(&bytes[16..]);
        bytes[12..16].copy_from_slice(&checksum.to_le_bytes());
        bytes
    }
}

/// Reads the bytes of a file.
pub(super) struct Reader<'a>(&'a [u8]);

fn damaged(what: &str) -> Error {
    Error::CheckpointDamaged { what: what.into() }
}

impl<'a> Reader<'a> {
    /// Checks everything except the content of the pieces.
    pub(super) fn new(bytes: &'a [u8]) -> Result<Self, Error> {
        let mut reader = Self(bytes);
        if reader.take(8)? != MAGIC {
            return Err(damaged("it is not a checkpoint file"));
        }
        let [version, checksum] = [reader.short()?, reader.short()?];
        if version != VERSION {
            return Err(Error::CheckpointVersion { found: version, known: VERSION });
        }
        if crc32fast::hash(reader.0) != checksum {
            return Err(damaged("its checksum is wrong"));
        }
        let length = reader.number()?;
        if length != reader.0.len() as u64 {
            return Err(damaged("its length is wrong"));
        }
        Ok(reader)
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], Error> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or_else(|| damaged("it is cut off"))?;
        self.0 = rest;
        Ok(taken)
    }

    fn short(&mut self) -> Result<u32, Error> {
        let bytes = self.take(4)?.try_into().map_err(|_| damaged("it is cut off"))?;
        Ok(u32::from_le_bytes(bytes))
    }

    pub(super) fn number(&mut self) -> Result<u64, Error> {
        let bytes = self.take(8)?.try_into().map_err(|_| damaged("it is cut off"))?;
        Ok(u64::from_le_bytes(bytes))
    }

    pub(super) fn piece(&mut self) -> Result<Vec<u8>, Error> {
        let length = usize::try_from(self.number()?).map_err(|_| damaged("it is cut off"))?;
        Ok(self.take(length)?.to_vec())
    }

    pub(super) fn finish(self) -> Result<(), Error> {
        if self.0.is_empty() { Ok(()) } else { Err(damaged("it contains additional data")) }
    }
}

/// A path with something appended to its last name.
pub(super) fn beside(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    name.into()
}

/// Adds the path of a file to an error.
fn at<T>(
    path: &Path,
    result: Result<T, impl Into<Box<dyn std::error::Error + Send + Sync>>>,
) -> Result<T, Error> {
    result.map_err(|source| Error::CheckpointFile { path: path.into(), source: source.into() })
}

impl Snapshot {
    /// Writes a file completely or not at all: it writes `path.new` in the same folder, syncs it to
    /// the disk and renames it. An existing file is renamed to `path.previous`.
    ///
    /// # Errors
    /// [`Error::CheckpointFile`] with the path and the error of the system; existing files are
    /// unchanged.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let path = path.as_ref();
        let (new, previous) = (beside(path, ".new"), beside(path, ".previous"));
        let bytes = self.to_bytes();
        let written = File::create(&new).and_then(|mut file| {
            file.write_all(&bytes)?;
            file.sync_all()
        });
        if written.is_err() {
            // The incomplete file would only take space.
            fs::remove_file(&new).ok();
        }
        at(&new, written)?;
        match fs::rename(path, previous) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return at(path, Err(error)),
            _ => {}
        }
        at(path, fs::rename(&new, path))?;
        // Makes the renaming permanent.
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        at(folder, sync_folder(folder))
    }

    /// Reads a file that [`write`](Self::write) wrote.
    ///
    /// # Errors
    /// [`Error::CheckpointFile`] with the path. Its source is the error of the system,
    /// [`Error::CheckpointDamaged`] or [`Error::CheckpointVersion`].
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        at(path, fs::read(path)).and_then(|bytes| at(path, Self::from_bytes(&bytes)))
    }
}

#[cfg(unix)]
fn sync_folder(folder: &Path) -> io::Result<()> {
    File::open(folder)?.sync_all()
}

/// On other systems folders cannot be opened as files.
#[cfg(not(unix))]
fn sync_folder(_: &Path) -> io::Result<()> {
    Ok(())
}
