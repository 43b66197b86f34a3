//! What state is written to and read from.

use crate::Error;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt::Debug;

/// Something whose state a checkpoint keeps.
///
/// One method both writes and reads, as the [`Archive`] says, so the two cannot disagree. It names
/// what changes during a run. What the constructor makes (bins, tables, closures) is not kept: a
/// run goes on in an object that the same code has made anew, and whose numbers are then
/// overwritten.
///
/// All ready observers are, but for [`ObserverFn`](crate::ObserverFn); so are tuples of them,
/// [`Every`](crate::Every), `Option`, `Vec`, `Box` and `&mut`. One of your own takes a line for
/// each number:
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
/// [`Drive`](crate::drive::Drive)s and [`Adaptation`](crate::drive::Adaptation)s of your own are
/// made part of checkpoints in the same way.
#[diagnostic::on_unimplemented(
    message = "a checkpoint cannot keep `{Self}`",
    label = "its state is not known",
    note = "implement `gradient_mc::checkpoint::Persist`: one method, with a line for each number that changes during a run"
)]
pub trait Persist {
    /// Writes the state or overwrites it with what was written, always the same items in the same
    /// order.
    ///
    /// # Errors
    /// Those of the [`Archive`]; the object is then of no use.
    fn persist(&mut self, archive: &mut Archive<'_>) -> Result<(), Error>;
}

/// Where state is written to, or read from: each method does either.
///
/// Every item has a name, which is written too. So what was written by other code is found out, and
/// errors say where.
#[derive(Debug)]
pub struct Archive<'a> {
    direction: Direction<'a>,
    /// Names of the parts that are open.
    path: Vec<&'static str>,
}

#[derive(Debug)]
enum Direction<'a> {
    Write(Vec<u8>),
    Read(&'a [u8]),
}

impl<'a> Archive<'a> {
    /// Counters above this are refused: no run gets there, and sums of them still fit.
    const LARGEST_COUNT: u64 = 1 << 53;

    pub(super) fn writing() -> Self {
        Self { direction: Direction::Write(Vec::new()), path: Vec::new() }
    }

    pub(super) fn reading(bytes: &'a [u8]) -> Self {
        Self { direction: Direction::Read(bytes), path: Vec::new() }
    }

    /// What was written; nothing when reading, where all must have been read.
    pub(super) fn finish(self) -> Result<Vec<u8>, Error> {
        match self.direction {
            Direction::Write(bytes) => Ok(bytes),
            Direction::Read([]) => Ok(Vec::new()),
            Direction::Read(_) => Err(Error::CheckpointDamaged { what: "something is left over".into() }),
        }
    }

    /// Whether state is overwritten, so that what depends on it has to be made anew.
    #[must_use]
    pub fn is_reading(&self) -> bool {
        matches!(self.direction, Direction::Read(_))
    }

    /// The path to an item, or to the part that is open.
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
                // A type that cannot be written at all.
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

    /// Plain data of any length.
    ///
    /// # Errors
    /// [`Error::CheckpointDamaged`] for what is not such data, [`Error::CheckpointMismatch`] if
    /// there is another item.
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

    /// A counter: a number below 2⁵³.
    ///
    /// # Errors
    /// As [`value`](Self::value).
    pub fn count(&mut self, name: &'static str, count: &mut u64) -> Result<(), Error> {
        self.value(name, count)?;
        if *count > Self::LARGEST_COUNT { Err(self.damaged(name)) } else { Ok(()) }
    }

    /// Counters, as many as there are; see [`count`](Self::count).
    ///
    /// # Errors
    /// As [`slice`](Self::slice).
    pub fn counts(&mut self, name: &'static str, counts: &mut [u64]) -> Result<(), Error> {
        self.slice(name, counts)?;
        if counts.iter().any(|&count| count > Self::LARGEST_COUNT) { Err(self.damaged(name)) } else { Ok(()) }
    }

    /// Numbers, as many as there are.
    ///
    /// # Errors
    /// As [`value`](Self::value); [`Error::CheckpointMismatch`] if there were more or fewer.
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

    /// Something that the code which goes on must have made again: it is compared as it prints by
    /// `{:?}`.
    ///
    /// # Errors
    /// [`Error::CheckpointMismatch`] with both if it is not the same.
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

    /// What knows by itself what to keep.
    ///
    /// # Errors
    /// Those of the part.
    pub fn part<P: Persist + ?Sized>(&mut self, name: &'static str, part: &mut P) -> Result<(), Error> {
        self.within(name, |archive| part.persist(archive))
    }

    /// Several items under one name.
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

    /// Whether what was read makes sense.
    ///
    /// # Errors
    /// [`Error::CheckpointDamaged`] if it does not.
    pub fn check(&self, holds: bool) -> Result<(), Error> {
        if holds { Ok(()) } else { Err(self.damaged("")) }
    }
}
