//! Errors of reading a frame of a trajectory.

use std::io;
use std::path::PathBuf;
use thiserror::Error;

/// The reason why a frame of a trajectory cannot be read, or cannot be a start.
///
/// ```
/// use gradient_mc::start::{TrajectoryError, TrajectoryFrame};
/// // The text of a file with one sphere too few.
/// let text = "2\nLattice=\"6 0 0 0 3 0 0 0 3\"\nX 0.5 1 1\n";
/// let error = TrajectoryFrame::read(std::io::Cursor::new(text), None);
/// assert!(matches!(error, Err(TrajectoryError::CutOff { frame: 0, .. })));
/// ```
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TrajectoryError {
    /// An error in a file.
    #[error("{}: {source}", path.display())]
    #[non_exhaustive]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        #[source]
        source: Box<TrajectoryError>,
    },
    /// The operating system cannot read it.
    #[error(transparent)]
    Unreadable(#[from] io::Error),
    /// The content is not valid.
    #[error("{place}: {what}")]
    #[non_exhaustive]
    Malformed {
        /// A line, or a frame and the name of a chunk.
        place: String,
        /// What is wrong.
        what: String,
    },
    /// A frame ends too early, for example because a program was killed while writing.
    #[error(
        "frame {frame} is cut off: {remedy}",
        remedy = match frame.checked_sub(1) {
            Some(before) => format!("use frame {before}, the last complete one, with `TrajectoryFrame::nth`"),
            None => "there is no complete frame".to_owned(),
        }
    )]
    #[non_exhaustive]
    CutOff {
        /// Its number, from 0.
        frame: u64,
    },
    /// There is no frame with this number.
    #[error("there is no frame {number}: the file has {frames} frames, numbered from 0")]
    #[non_exhaustive]
    NoSuchFrame {
        /// Number of the requested frame; 0 if the last was requested.
        number: u64,
        /// Number of complete frames.
        frames: u64,
    },
    /// The frame has another slab than the scene.
    #[error(
        "the {what} of the frame is {stored}, and that of the scene {given}: use a scene with the same slab, or \
         start from `Positions` of the frame"
    )]
    #[non_exhaustive]
    AnotherSlab {
        /// Name of the length that differs.
        what: &'static str,
        /// Its value in the frame, in diameters.
        stored: f64,
        /// Its value in the scene, in diameters.
        given: f64,
    },
}

impl TrajectoryError {
    pub(super) fn malformed(place: impl Into<String>, what: impl Into<String>) -> Self {
        Self::Malformed { place: place.into(), what: what.into() }
    }
}
