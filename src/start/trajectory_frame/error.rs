//! What can be wrong with a frame of a trajectory.

use std::io;
use std::path::PathBuf;
use thiserror::Error;

/// Why a frame of a trajectory cannot be read, or cannot be started from.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TrajectoryError {
    /// What is wrong with a file.
    #[error("{}: {source}", path.display())]
    #[non_exhaustive]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        #[source]
        source: Box<TrajectoryError>,
    },
    /// The system does not give it.
    #[error(transparent)]
    Unreadable(#[from] io::Error),
    /// Something is not as it must be.
    #[error("{place}: {what}")]
    #[non_exhaustive]
    Malformed {
        /// A line, or a frame and the name of a chunk.
        place: String,
        /// What is wrong.
        what: String,
    },
    /// A frame ends before all of its spheres, as where a program was killed while it wrote.
    #[error(
        "frame {frame} is cut off: {remedy}",
        remedy = match frame.checked_sub(1) {
            Some(before) => format!("take frame {before}, the last that is whole, by `TrajectoryFrame::nth`"),
            None => "there is no whole frame".to_owned(),
        }
    )]
    #[non_exhaustive]
    CutOff {
        /// Its number, from 0.
        frame: u64,
    },
    /// There are not as many frames.
    #[error("there are {frames} frames, and none of number {number} (the first is 0)")]
    #[non_exhaustive]
    NoSuchFrame {
        /// The one that was asked for; 0 if the last was.
        number: u64,
        /// Whole frames that there are.
        frames: u64,
    },
    /// The frame is of another slab than the scene.
    #[error(
        "the frame is of a {what} of {stored}, and the scene has {given}: take a scene like it, or start from \
         `Positions` of the frame"
    )]
    #[non_exhaustive]
    AnotherSlab {
        /// A length of the slab.
        what: &'static str,
        /// That of the frame, in diameters.
        stored: f64,
        /// That of the scene.
        given: f64,
    },
}

impl TrajectoryError {
    pub(super) fn malformed(place: impl Into<String>, what: impl Into<String>) -> Self {
        Self::Malformed { place: place.into(), what: what.into() }
    }
}
