//! Input and output of all commands: scenes, pictures, lines of text, errors.

mod error;
pub(crate) mod input;
pub(crate) mod output;
pub(crate) mod scale;
pub(crate) mod scenes;

use std::io::Write as _;

pub(crate) use error::{Error, Result};

/// Prints a line. A reader that has closed the pipe, as `head` does, is not an error.
pub(crate) fn say(line: impl std::fmt::Display) -> Result<(), Error> {
    match writeln!(std::io::stdout(), "{line}") {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::file("write", "standard output", error))
        }
        _ => Ok(()),
    }
}
