//! The archive that writes and reads the state of a run.

use crate::Error;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt::Debug;

/// A type whose state is stored in checkpoints.
///
/// One method both writes and reads, depending on the [`Archive`]. It names every value that
/// changes during a run. Values set by the constructor (bins, tables, closures) are not stored: to
/// continue a run, the same code makes a new object, and the stored values overwrite those of the
/// object.
///
/// Implemented by all observers of the library except [`ObserverFn`](crate::ObserverFn), and by
/// tuples of them, [`Every`](crate::Every), `Option`, `Vec`, `Box` and `&mut`. For your own type
/// write one line for each value:
///
/// ```
/// use gradient_mc::checkpoint::{Archive, Persist};
/// use gradient_mc::{Error, Frame, Observer, ObserverError};
/// /// The highest sphere below a limit, and how often a frame was seen.
/// struct Highest {
///     limit: f64,
///     height: f64,
///     frames: u64,
/// }
/// impl Observer for Highest {
///     fn observe(&mut self, frame: &Frame<'_>) -> Result<(), ObserverError> {
///         self.height = frame.heights().filter(|&height| height < self.limit).fold(self.height, f64::max);
///         self.frames += 1;
///         Ok(())
///     }
/// }
/// impl Persist for Highest {
///     fn persist(&mut self, archive: &mut Archive<'_>) -> Result<(), Error> {
///         archive.same("limit", &self.limit)?;
///         archive.value("height", &mut self.height)?;
///         archive.count("frames", &mut self.frames)
///     }
/// }
/// ```
///
/// Your own [`Drive`](crate::drive::Drive)s and [`Adaptation`](crate::drive::Adaptation)s become
/// part of checkpoints in the same way.
#[diagnostic::on_unimplemented(
    message = "a checkpoint cannot keep `{Self}`",
    label = "its state is not known",
    note = "implement `gradient_mc::checkpoint::Persist`: one method, with a line for each number that changes during a run"
)]
pub trait Persist {
    /// Writes the state, or overwrites it with the stored state: always the same items in the same
    /// order.
    ///
    /// # Errors
    /// Those of the [`Archive`]; the object must not be used afterwards.
    fn persist(&mut self, archive: &mut Archive<'_>) -> Result<(), Error>;
}

/// An archive to which a state is written, or from which it is read. Each method does both.
///
/// Every item is stored with its name, so that a file of other code is detected and errors name the
/// item.
#[derive(Debug)]
pub struct Archive<'a> {
    direction: Direction<'a>,
    /// Names of the enclosing parts.
    path: Vec<&'static str>,
}

#[derive(Debug)]
enum Direction<'a> {
    Write(Vec<u8>),
    Read(&'a [u8]),
}

impl<'a> Archive<'a> {
    /// Largest value of a counter. Larger values are refused; sums of counters cannot overflow.
    const LARGEST_COUNT: u64 = 1 << 53;

    pub(super) fn writing() -> Self {
        Self { direction: Direction::Write(Vec::new()), path: Vec::new() }
    }

    pub(super) fn reading(bytes: &'a [u8]) -> Self {
        Self { direction: Direction::Read(bytes), path: Vec::new() }
    }

    /// The bytes that were written. After reading, it is empty, and fails if something was not
    /// read.
    pub(super) fn finish(self) -> Result<Vec<u8>, Error> {
        match self.direction {
            Direction::Write(bytes) => Ok(bytes),
            Direction::Read([]) => Ok(Vec::new()),
            Direction::Read(_) => {
                Err(Error::CheckpointDamaged { what: "it contains additional data".into() })
            }
        }
    }

    /// Whether the archive is read. Values derived from the state must be computed again then.
    #[must_use]
    pub fn is_reading(&self) -> bool {
        matches!(self.direction, Direction::Read(_))
    }

    /// The path to an item, or to the current part.
    fn path_to(&self, name: &str) -> String {
        let names = self.path.iter().copied().chain((!name.is_empty()).then_some(name));
        names.collect::<Vec<_>>().join(".")
    }

    fn damaged(&self, name: &str) -> Error {
        Error::CheckpointDamaged { what: self.path_to(name) }
    }

    /// Writes an item, or reads and returns it.
    fn item<T: Serialize + DeserializeOwned>(&mut self, name: &str, value: &T) -> Result<Option<T>, Error> {
        match &mut self.direction {
            Direction::Write(bytes) => match postcard::to_extend(value, std::mem::take(bytes)) {
                Ok(extended) => {
                    *bytes = extended;
                    Ok(None)
                }
                // A type that cannot be encoded.
                Err(_) => Err(self.damaged(name)),
            },
            Direction::Read(bytes) => match postcard::take_from_bytes(bytes) {
                Ok((value, rest)) => {
                    *bytes = rest;
                    Ok(Some(value))
                }
                Err(_) => Err(self.damaged(name)),
            },
        }
    }

    fn name(&mut self, name: &'static str) -> Result<(), Error> {
        match self.item(name, &name.to_owned())? {
            Some(saved) if saved != name => {
                let (what, given) = (self.path_to(""), name.into());
                Err(Error::CheckpointMismatch { what: format!("content of {what}"), saved, given })
            }
            _ => Ok(()),
        }
    }

    /// Writes or reads plain data of any length.
    ///
    /// # Errors
    /// [`Error::CheckpointDamaged`] if the data cannot be decoded; [`Error::CheckpointMismatch`] if
    /// the item has another name.
    pub fn value<T: Serialize + DeserializeOwned>(
        &mut self,
        name: &'static str,
        value: &mut T,
    ) -> Result<(), Error> {
        self.name(name)?;
        if let Some(saved) = self.item(name, value)? {
            *value = saved;
        }
        Ok(())
    }

    /// Writes or reads a counter: a number up to 2⁵³.
    ///
    /// # Errors
    /// Those of [`value`](Self::value).
    pub fn count(&mut self, name: &'static str, count: &mut u64) -> Result<(), Error> {
        self.value(name, count)?;
        if *count > Self::LARGEST_COUNT { Err(self.damaged(name)) } else { Ok(()) }
    }

    /// Writes or reads a fixed number of counters; see [`count`](Self::count).
    ///
    /// # Errors
    /// Those of [`slice`](Self::slice).
    pub fn counts(&mut self, name: &'static str, counts: &mut [u64]) -> Result<(), Error> {
        self.slice(name, counts)?;
        if counts.iter().any(|&count| count > Self::LARGEST_COUNT) { Err(self.damaged(name)) } else { Ok(()) }
    }

    /// Writes or reads a fixed number of values.
    ///
    /// # Errors
    /// Those of [`value`](Self::value); [`Error::CheckpointMismatch`] if the number of values
    /// differs.
    pub fn slice<T: Serialize + DeserializeOwned>(
        &mut self,
        name: &'static str,
        values: &mut [T],
    ) -> Result<(), Error> {
        self.name(name)?;
        let mut length = values.len();
        if let Some(saved) = self.item(name, &length)? {
            length = saved;
        }
        self.agree(name, format!("{length} numbers"), format!("{} numbers", values.len()))?;
        for value in values {
            if let Some(saved) = self.item(name, value)? {
                *value = saved;
            }
        }
        Ok(())
    }

    /// Writes a value that is set by the constructor, or compares it with the stored one, as
    /// printed by `{:?}`.
    ///
    /// # Errors
    /// [`Error::CheckpointMismatch`] with both values if they differ.
    pub fn same(&mut self, name: &'static str, value: &dyn Debug) -> Result<(), Error> {
        self.name(name)?;
        let given = format!("{value:?}");
        match self.item(name, &given)? {
            Some(saved) => self.agree(name, saved, given),
            None => Ok(()),
        }
    }

    fn agree(&self, name: &str, saved: String, given: String) -> Result<(), Error> {
        if saved == given {
            return Ok(());
        }
        Err(Error::CheckpointMismatch { what: self.path_to(name), saved, given })
    }

    /// Writes or reads a part that implements [`Persist`].
    ///
    /// # Errors
    /// Those of the part.
    pub fn part<P: Persist + ?Sized>(&mut self, name: &'static str, part: &mut P) -> Result<(), Error> {
        self.within(name, |archive| part.persist(archive))
    }

    /// Writes or reads several items under one name.
    ///
    /// # Errors
    /// Those of the items.
    pub fn within(
        &mut self,
        name: &'static str,
        items: impl FnOnce(&mut Self) -> Result<(), Error>,
    ) -> Result<(), Error> {
        self.name(name)?;
        self.path.push(name);
        items(self)?;
        self.path.pop();
        Ok(())
    }

    /// Fails if a condition on the values that were read does not hold.
    ///
    /// # Errors
    /// [`Error::CheckpointDamaged`] if `holds` is false.
    pub fn check(&self, holds: bool) -> Result<(), Error> {
        if holds { Ok(()) } else { Err(self.damaged("")) }
    }
}
