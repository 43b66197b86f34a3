//! The error of one observer of several.

use crate::{Error, ObserverError};
use std::any::type_name;
use std::fmt;

/// Error of a tuple of observers: which of them failed, and its error.
#[derive(Debug)]
pub(crate) struct FailedObserver {
    position: Vec<usize>,
    name: &'static str,
    source: ObserverError,
}

impl FailedObserver {
    /// The failure of an observer `O`. If `O` is a tuple, the error names the observer inside.
    fn of<O: ?Sized>(error: ObserverError) -> Self {
        match error.downcast::<Self>() {
            Ok(inside) => *inside,
            Err(source) => {
                Self { position: Vec::new(), name: type_name::<O>().trim_start_matches("&mut "), source }
            }
        }
    }

    /// The failure of the observer `O` at index `place` of a tuple.
    pub(crate) fn at<O: ?Sized>(place: usize, error: ObserverError) -> Self {
        let mut failed = Self::of::<O>(error);
        failed.position.insert(0, place);
        failed
    }

    /// The failure of an observer of a simulation. The observer of the user is the last of the
    /// tuple there.
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

/// The observer, as in messages.
pub(crate) fn describe(position: &[usize], name: &str) -> String {
    if position.is_empty() {
        return format!("the observer {name}");
    }
    let place = position.iter().map(ToString::to_string).collect::<Vec<_>>().join(".");
    format!("observer .{place} of the tuple, {name},")
}
