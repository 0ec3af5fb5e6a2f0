//! The crate's error type.

use std::path::PathBuf;

/// The crate's errors. Each message is one line that names the fault, its place and the expected value.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An argument outside its range.
    #[error("{name} is {value}; expected {expected}")]
    Invalid {
        /// Name of the argument, in the words of the call or of the scene file.
        name: String,
        /// The value as given.
        value: String,
        /// The range or form that is accepted.
        expected: String,
    },

    /// A scene file whose text does not describe a scene.
    #[error("{}:{line}: {message}", path.display())]
    Scene {
        /// The scene file.
        path: PathBuf,
        /// Line in the file, counted from 1.
        line: usize,
        /// The fault and what was expected instead.
        message: String,
    },

    /// A file that cannot be read or written.
    #[error("cannot {action} {}: {source}", path.display())]
    File {
        /// `"read"`, `"write"`, …
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// The error of the operating system or of a decoder, or what is wrong with the content.
        source: Cause,
    },

    /// A capability that this build of the crate does not include.
    #[error("{what} is not built in; build with --features {feature}")]
    NotBuilt {
        /// The missing capability.
        what: &'static str,
        /// The crate feature that enables it.
        feature: &'static str,
    },

    /// A shader that does not compile, or a program that does not link.
    #[error("{what} failed: {log}")]
    Shader {
        /// Stage and source files, or the program's name.
        what: String,
        /// The driver's log; `file(line)` in it counts from 1 within the named file.
        log: String,
    },

    /// No OpenGL context could be made, or the context is too old.
    #[error("{0}")]
    Context(String),

    /// The driver could not create an object.
    #[error("the driver could not create {what}: {reason}")]
    Driver {
        /// The object.
        what: String,
        /// The driver's reason.
        reason: String,
    },
}

/// The cause of an error: an error of another crate, or a text.
pub type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Result with the crate's [`enum@Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// Creates an [`Error::Invalid`]; the value can be of any type that implements `Display`.
    pub fn invalid(
        name: impl Into<String>,
        value: impl std::fmt::Display,
        expected: impl Into<String>,
    ) -> Self {
        Self::Invalid { name: name.into(), value: value.to_string(), expected: expected.into() }
    }

    /// Creates an [`Error::File`] from an error of another crate or from a text.
    pub fn file(action: &'static str, path: impl Into<PathBuf>, source: impl Into<Cause>) -> Self {
        Self::File { action, path: path.into(), source: source.into() }
    }

    /// The same error with the argument's name prefixed by the place where the error was found.
    #[must_use]
    pub fn within(self, place: impl std::fmt::Display) -> Self {
        match self {
            Self::Invalid { name, value, expected } => {
                Self::Invalid { name: format!("{place}: {name}"), value, expected }
            }
            other => other,
        }
    }
}

/// The first 20 characters of a word, so that a binary file does not make an error message of a whole page.
pub(crate) fn shortened(word: &str) -> String {
    word.chars().take(20).map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}
