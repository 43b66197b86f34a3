//! Which of several observers failed.

use crate::{Error, ObserverError};
use std::any::type_name;
use std::fmt;

/// What a tuple of observers returns: which of them failed, and its own error.
#[derive(Debug)]
pub(crate) struct FailedObserver {
    position: Vec<usize>,
    name: &'static str,
    source: ObserverError,
}

impl FailedObserver {
    /// The failure of an observer `O`, which may be a tuple that says which of its own it was.
    fn of<O: ?Sized>(error: ObserverError) -> Self {
        match error.downcast::<Self>() {
            Ok(inside) => *inside,
            Err(source) => {
                Self { position: Vec::new(), name: type_name::<O>().trim_start_matches("&mut "), source }
            }
        }
    }

    /// The failure of the observer `O` at a place in a tuple.
    pub(crate) fn at<O: ?Sized>(place: usize, error: ObserverError) -> Self {
        let mut failed = Self::of::<O>(error);
        failed.position.insert(0, place);
        failed
    }

    /// The failure of one of those who look at a simulation, of whom the last is the user's.
    pub(crate) fn after(sweep: u64, error: ObserverError) -> Error {
        let Self { mut position, name, source } = Self::of::<()>(error);
        position.drain(..1.min(position.len()));
        Error::Observer { sweep, position, name, source }
    }
}

impl fmt::Display for FailedObserver {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} failed: {}", describe(&self.position, self.name), self.source)
    }
}

impl std::error::Error for FailedObserver {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        Some(&*self.source)
    }
}

/// As in a message.
pub(crate) fn describe(position: &[usize], name: &str) -> String {
    if position.is_empty() {
        return format!("the observer {name}");
    }
    let place = position.iter().map(ToString::to_string).collect::<Vec<_>>().join(".");
    format!("observer .{place} of the tuple, {name},")
}
