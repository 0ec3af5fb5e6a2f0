//! The errors of the program.

use std::path::PathBuf;

use freeform_surface::Cause;

/// All errors that make the program give up. Each is one line that states the fault, its place, and the
/// expected input.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Error {
    /// An error of the library: of a scene, or of drawing it.
    #[error(transparent)]
    Library(#[from] freeform_surface::Error),

    /// An argument of the command line, or a value typed or dragged in the window.
    #[error("{name} is {value}; expected {expected}")]
    Input {
        /// Name of the input, as the command line or the window calls it.
        name: String,
        /// The value as given.
        value: String,
        /// The range or form that is accepted.
        expected: String,
    },

    /// A file, folder or stream that cannot be read, made or written.
    #[error("cannot {action} {}: {source}", place.display())]
    File {
        /// `"read"`, `"write"`, …
        action: &'static str,
        /// The file, or a name for the stream.
        place: PathBuf,
        /// The error of the operating system or of an encoder, or a text.
        source: Cause,
    },

    /// The driver reported errors while the program created an object.
    #[error("the driver could not create {what}: {reason}")]
    Driver {
        /// The object.
        what: String,
        /// The driver's messages.
        reason: String,
    },

    /// The driver draws wrongly; the text names the driver and the fault.
    #[error("{0}")]
    WrongDriver(String),

    /// Some of many pictures failed; what failed was said before.
    #[error("{failed} of {total} pictures failed")]
    Pictures {
        /// The pictures that failed.
        failed: usize,
        /// All pictures, with those that were kept.
        total: usize,
    },

    /// No window with an OpenGL context could be opened.
    #[cfg(feature = "viewer")]
    #[error("{0}")]
    Window(String),
}

/// Result with the program's [`enum@Error`].
pub(crate) type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// An [`Error::Input`] from anything that prints.
    pub(crate) fn invalid(
        name: impl Into<String>,
        value: impl std::fmt::Display,
        expected: impl Into<String>,
    ) -> Self {
        Self::Input { name: name.into(), value: value.to_string(), expected: expected.into() }
    }

    /// An [`Error::File`] from the error of a crate, or from a text.
    pub(crate) fn file(
        action: &'static str,
        place: impl Into<PathBuf>,
        source: impl Into<Cause>,
    ) -> Self {
        Self::File { action, place: place.into(), source: source.into() }
    }
}
