//! What the program and its workers tell each other, a line of JSON each.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// What a worker is to do.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) enum Task {
    /// Make a picture.
    Draw {
        /// The scene's file.
        input: PathBuf,
        /// The picture's file.
        output: PathBuf,
        /// Of a moving camera.
        frame: Option<u32>,
    },
    /// Name the files that a scene is read from.
    Survey(PathBuf),
}

/// What a worker says.
#[derive(Debug, Serialize, Deserialize)]
pub(super) enum Reply {
    /// It has a context; its first line.
    Ready,
    /// It has none, and why.
    Refused(String),
    /// A picture is done, or has failed.
    Done(Report),
    /// The files that a scene is read from; none if it cannot be read.
    Files(Vec<PathBuf>),
}

/// What became of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Status {
    /// It was drawn and written.
    Made,
    /// It is whole already.
    Kept,
    /// It could not be made.
    Failed,
}

/// The result of a picture.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Report {
    pub(super) status: Status,
    /// Why it has failed.
    pub(super) error: Option<String>,
    /// What is wrong with a picture that was made.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) warning: Option<String>,
    /// The times of a picture that was made.
    pub(super) ms: Option<Milliseconds>,
    /// The number of triangles drawn.
    pub(super) triangles: Option<u64>,
    /// The largest distance that is possible between triangles and surfaces, in pixels, where there is a bound.
    pub(super) largest_bound: Option<f64>,
    /// The most memory that the worker had while it made this picture, in bytes, where the system tells.
    pub(super) peak_memory: Option<u64>,
}

/// The times of the parts of a picture.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(super) struct Milliseconds {
    pub(super) read: f64,
    pub(super) upload: f64,
    pub(super) draw: f64,
    pub(super) write: f64,
}

impl Report {
    /// A picture that has only a status.
    pub(super) const fn of(status: Status) -> Self {
        Self {
            status,
            error: None,
            warning: None,
            ms: None,
            triangles: None,
            largest_bound: None,
            peak_memory: None,
        }
    }

    /// A picture that could not be made.
    pub(super) fn failed(error: impl std::fmt::Display) -> Self {
        Self { error: Some(error.to_string()), ..Self::of(Status::Failed) }
    }
}
